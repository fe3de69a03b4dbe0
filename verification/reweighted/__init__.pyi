from .answers import Answer, Answers, Word
from .loops import Loop
from .measured import judge_functions
from .objective import Objective, each_loss, loss, norm, norm1, squares, variable
from .terms import Term, judge_term

__all__ = [
    "Answer",
    "Answers",
    "Loop",
    "Objective",
    "Term",
    "Word",
    "each_loss",
    "judge_functions",
    "judge_term",
    "loss",
    "norm",
    "norm1",
    "squares",
    "variable",
]
