from .answers import Answer, Answers, Word
from .loops.judging import judge_loop
from .loops.loop import Loop
from .objectives.objective import Objective, each_loss, loss, norm, norm1, squares, variable
from .objectives.optimum import Optimum
from .programs.judging import Finding, ProgramAnswers, judge_program, replay
from .programs.questions import Question, all_questions
from .programs.recorded import export_inputs, judge_recorded
from .programs.verdicts import Rule
from .terms.judging import judge_term
from .terms.measured import judge_functions
from .terms.term import Term

__all__ = [
    "Answer",
    "Answers",
    "Finding",
    "Loop",
    "Objective",
    "Optimum",
    "ProgramAnswers",
    "Question",
    "Rule",
    "Term",
    "Word",
    "all_questions",
    "each_loss",
    "export_inputs",
    "judge_functions",
    "judge_loop",
    "judge_program",
    "judge_recorded",
    "judge_term",
    "loss",
    "norm",
    "norm1",
    "replay",
    "squares",
    "variable",
]
