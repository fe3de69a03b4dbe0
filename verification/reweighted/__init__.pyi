from .answers import Answer, Answers, Word
from .judging import judge_loop
from .loops import Loop
from .measured import judge_functions
from .objective import Objective, each_loss, loss, norm, norm1, squares, variable
from .optimum import Optimum
from .programs import Finding, ProgramAnswers, judge_program, replay
from .questions import Question, all_questions
from .recorded import export_inputs, judge_recorded
from .terms import Term, judge_term
from .verdicts import Rule

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
