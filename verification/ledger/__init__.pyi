from .baseline import Judged, read_baseline
from .claims import CLAIMS, PARTS, PROTOCOL, Claim, Part, Role, Subject
from .evidence import Argument, Checker, Count, Evidence, Judgement, Outcome, Refutation, Step, Verdict
from .rules import Protocol, Rule
from .surveys import Comparison, Survey
from .verdicts import ContradictionError, judge_all, judge_part

__all__ = [
    "CLAIMS",
    "PARTS",
    "PROTOCOL",
    "Argument",
    "Checker",
    "Claim",
    "Comparison",
    "ContradictionError",
    "Count",
    "Evidence",
    "Judged",
    "Judgement",
    "Outcome",
    "Part",
    "Protocol",
    "Refutation",
    "Role",
    "Rule",
    "Step",
    "Subject",
    "Survey",
    "Verdict",
    "judge_all",
    "judge_part",
    "read_baseline",
]
