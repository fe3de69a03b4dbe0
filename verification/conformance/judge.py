"""What one answer is worth, level by level. All that accuses a solver is decided in exact numbers.

L0: an answer came as it must. L1: the optimum as a number. L2: the point is optimal within the tolerance.
L3: what is proved to be 0 is 0, and the label is the proved one. L4: the objective never rises.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

import numpy as np

from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem
from verification.conformance.answers import REFUSALS, Answer, Refusal, shown, told
from verification.conformance.doors import Reply
from verification.conformance.profiles import Profile
from verification.conformance.vectors import Malformed, RecognitionSet
from verification.conformance.vectors import Vector as Case
from verification.exact.formulation import objective
from verification.exact.numbers import Enclosure, rationals, square_root, squares, times
from verification.ledger.evidence import Outcome

NOT_ASKED = "not asked"
MOST_DIGITS = 16.0
"""Digits that float64 holds: agreement beyond them is not told."""


class Level(StrEnum):
    """What is asked of an answer."""

    L0 = "L0"
    L1 = "L1"
    L2 = "L2"
    L3 = "L3"
    L4 = "L4"


WORDS = {
    Level.L0: "answers every request, as the protocol says",
    Level.L1: "its objective is the optimum",
    Level.L2: "its point (w, u) is optimal",
    Level.L3: "proved zeros and proved labels agree",
    Level.L4: "its objective never rises from one iteration to the next",
}


@dataclass(frozen=True)
class Finding:
    """One level of one request.

    Attributes
    ----------
    id : str
    level : Level
    outcome : Outcome
    detail : str
        Why, where it did not hold.
    digits : float or None
        L2: digits to which F(w, u) agrees with F*, -log10 of the gap by F*; at most `MOST_DIGITS`. None where
        F* is so small beside ||o||^2 that its tolerance is that of rounding.
    """

    id: str
    level: Level
    outcome: Outcome
    detail: str = ""
    digits: float | None = None


@dataclass(frozen=True)
class Judged:
    """The findings of one answer, and its value for the label: what it says F is, or else F(w, u)."""

    findings: tuple[Finding, ...]
    value: Fraction | None = None

    @property
    def failed(self) -> tuple[Finding, ...]:
        """The findings that accuse."""
        return tuple(each for each in self.findings if each.outcome is Outcome.FAILED)


def judge(case: Case, reply: Reply, profile: Profile) -> Judged:
    """Judge the answer to one problem on L0, L1, L2, L3 (its zeros) and L4."""
    answer = reply.answer
    if isinstance(answer, Refusal) and answer.kind == "unsupported" and not reply.faults:
        return Judged(tuple(Finding(case.id, level, Outcome.SKIPPED, answer.text) for level in Level))
    why = told(reply.faults)
    if not isinstance(answer, Answer):
        refused = f"error: {answer.text}" if answer is not None else ""
        first = Finding(case.id, Level.L0, Outcome.FAILED, "; ".join(filter(None, (why, refused))))
        rest = [Finding(case.id, level, Outcome.SKIPPED, "no answer") for level in Level if level != Level.L0]
        return Judged((first, *rest))
    problem = case.request.problem
    value = objective(problem, answer.w, answer.u)
    judged = (
        Finding(case.id, Level.L0, Outcome.FAILED if why else Outcome.HELD, why),
        _value(case, answer, value, profile),
        _optimal(case, value, profile),
        _zeros(case, answer, profile),
        _trace(case, answer, value, profile),
    )
    said = value.upper if answer.objective is None else Fraction(answer.objective)
    return Judged(judged, said)


def attainable(case: Case, w: Vector, u: Vector, profile: Profile) -> bool:
    """Whether a point, rounded to the profile's type of number, is optimal within the tolerance of L2.

    Where a nearly optimal point is not, no answer in these numbers may be, and none can be asked for.
    """
    with np.errstate(over="ignore", under="ignore"):
        rounded = [np.asarray(x, dtype=profile.name).astype(np.float64) for x in (w, u)]
    if not all(np.isfinite(x).all() for x in rounded):
        return False
    value = objective(case.request.problem, *rounded)
    return value.upper - case.lower <= _allowed(case, profile.optimal, profile)


def judge_set(case: RecognitionSet, values: Sequence[Fraction | None], profile: Profile) -> Finding:
    """Judge the label that the values of the templates give: L3 of a recognition set."""
    if any(value is None for value in values):
        return Finding(case.id, Level.L3, Outcome.SKIPPED, "a template has no answer")
    best = min(each.upper for each in case.templates)
    if Fraction(case.margin) * best <= 2 * max(
        _allowed(each, profile.optimal, profile) for each in case.templates
    ):
        detail = (
            f"the optima differ by {case.margin:.2g} of the lowest, which {profile.name} need not tell apart"
        )
        return Finding(case.id, Level.L3, Outcome.SKIPPED, detail)
    lowest = min(range(len(values)), key=lambda k: values[k] or 0)
    label = case.names[lowest]
    if label in case.labels:
        return Finding(case.id, Level.L3, Outcome.HELD)
    proved = " or ".join(case.labels)
    return Finding(case.id, Level.L3, Outcome.FAILED, f"its lowest value is {label}'s; proved is {proved}")


def not_asked(id: str, levels: Iterable[Level]) -> list[Finding]:  # noqa: A002
    """The findings of a request that was not asked, since the solver had been given up."""
    return [Finding(id, level, Outcome.SKIPPED, NOT_ASKED) for level in levels]


def judge_malformed(case: Malformed, data: dict[str, object] | None, faults: Sequence[str]) -> Finding:
    """Judge what came back for a line that is no valid request: L0."""
    why = told(faults)
    if data is None or why:
        return Finding(case.id, Level.L0, Outcome.FAILED, why or "no answer")
    said = {key: data[key] for key in REFUSALS if isinstance(data.get(key), str) and str(data[key]).strip()}
    if "error" in said:
        return Finding(case.id, Level.L0, Outcome.HELD)
    if said:
        return Finding(case.id, Level.L0, Outcome.SKIPPED, shown(said["unsupported"]))
    detail = f"answers where an error was due ({case.fault}: {case.comment})"
    return Finding(case.id, Level.L0, Outcome.FAILED, detail)


def _value(case: Case, answer: Answer, value: Enclosure, profile: Profile) -> Finding:
    """L1: F(w, u), and what the answer says it is, within the tolerance of F*."""
    allowed = _allowed(case, profile.value, profile)
    outcome, detail = _within(case, value, allowed)
    said = answer.objective
    if said is not None and outcome is not Outcome.FAILED and not _tells(case, answer, value, said, profile):
        detail = f"says that F is {said!r}; F(w, u) is {float(value.upper)!r}"
        outcome = Outcome.FAILED
    return Finding(case.id, Level.L1, outcome, detail)


def _optimal(case: Case, value: Enclosure, profile: Profile) -> Finding:
    """L2: F(w, u) - F* within the tolerance."""
    outcome, detail = _within(case, value, _allowed(case, profile.optimal, profile))
    told = Fraction(profile.optimal) * case.lower > _allowed(case, 0.0, profile)
    return Finding(case.id, Level.L2, outcome, detail, _digits(case, value) if told else None)


def _within(case: Case, value: Enclosure, allowed: Fraction) -> tuple[Outcome, str]:
    if value.upper - case.lower <= allowed:
        return Outcome.HELD, ""
    least = value.lower - case.upper
    detail = f"F(w, u) is {_shown(value.lower)}, F* <= {_shown(case.upper)}"
    if least > allowed:
        share = f", {_shown(least / case.upper, 2)} of F* above" if case.upper > 0 else ""
        return Outcome.FAILED, f"{detail}{share}"
    return Outcome.UNDECIDED, f"{detail}, but F* is not known well enough"


def _digits(case: Case, value: Enclosure) -> float:
    """-log10((F(w, u) - F*) / F*), its gap from above."""
    share = (value.upper - case.lower) / case.lower
    digits = math.log10(share.denominator) - math.log10(share.numerator) if share > 0 else MOST_DIGITS
    return min(digits, MOST_DIGITS)


def _zeros(case: Case, answer: Answer, profile: Profile) -> Finding:
    """L3: weights that are proved to be 0.

    F(w, u) - D(a, b) is a sum of terms >= 0, among them (lambda2 - |Xa - b|_j) |w_j|. A weight counts as
    not 0 if it is a share of the largest, and such that this term alone is beyond the tolerance of L2.
    """
    if not (case.zero_views or case.zero_modalities):
        return Finding(case.id, Level.L3, Outcome.SKIPPED, "nothing is proved to be 0")
    allowed = _allowed(case, profile.optimal, profile) + case.upper - case.lower
    views = np.abs(answer.w)
    norms = np.array([math.hypot(*answer.u[c]) for c in case.request.problem.modalities])
    named = (
        ("w_{}", views, case.zero_views, case.view_slack),
        ("||u^{}||", norms, case.zero_modalities, case.modality_slack),
    )
    wrong = [
        f"{name.format(k)} is {sizes[k]:.3g}, proved is 0"
        for name, sizes, zeros, slack in named
        for k in zeros
        if sizes[k] > profile.zero * sizes.max() and Fraction(float(sizes[k])) * slack[k] > allowed
    ]
    return Finding(case.id, Level.L3, Outcome.FAILED if wrong else Outcome.HELD, "; ".join(wrong))


def _trace(case: Case, answer: Answer, value: Enclosure, profile: Profile) -> Finding:
    """L4: no rise beyond rounding, and the last value is F(w, u)."""
    trace, problem = answer.trace, case.request.problem
    if trace is None or not trace.size:
        return Finding(case.id, Level.L4, Outcome.SKIPPED, "gives no trace")
    floor = float(case.target)
    share = 8 * (problem.n + problem.d) * profile.rounding
    at = _rise(trace, share, floor)
    if at is not None:
        detail = f"iteration {at}: {float(trace[at - 1])!r} -> {float(trace[at])!r}"
        return Finding(case.id, Level.L4, Outcome.FAILED, detail)
    if not _tells(case, answer, value, float(trace[-1]), profile):
        detail = f"the trace ends at {float(trace[-1])!r}; F(w, u) is {float(value.upper)!r}"
        return Finding(case.id, Level.L4, Outcome.FAILED, detail)
    if trace.size == 1:
        return Finding(case.id, Level.L4, Outcome.SKIPPED, "a trace of one value shows no step")
    return Finding(case.id, Level.L4, Outcome.HELD)


def _tells(case: Case, answer: Answer, value: Enclosure, said: float, profile: Profile) -> bool:
    """Whether a number is F(w, u) to the tolerance of F*, or as well as F can be computed there."""
    off = max(value.lower - Fraction(said), Fraction(said) - value.upper)
    near = Fraction(profile.value) * value.upper + _allowed(case, profile.value, profile)
    return off <= near or off <= near + _computed(case.request.problem, answer, value, profile)


def _computed(problem: Problem, answer: Answer, value: Enclosure, profile: Profile) -> Fraction:
    """By how much F changes if each residual does by 4 (n + d) units of rounding of what it is a sum of.

    These are |X|'|w| + |o| and |X||u| + |w|, of which little may be left where large weights cancel. With S
    the sum of their squares, as F has them, and the share s of rounding, it is at most
    s sqrt(8 F S) + s^2 S.
    """
    X, o, w, u = (rationals(np.abs(each).ravel()) for each in (problem.X, problem.o, answer.w, answer.u))
    X = X.reshape(problem.X.shape)
    sizes = squares(times(X.T, w) + o) + Fraction(problem.lambda1) * squares(times(X, u) + w)
    share = Fraction(4 * (problem.n + problem.d) * profile.rounding)
    return share * square_root(8 * value.upper * sizes).upper + share**2 * sizes


def _rise(trace: Vector, share: float, floor: float) -> int | None:
    """The first iteration that rises by more than `share` of the value before it, or of ||o||^2."""
    with np.errstate(over="ignore"):
        rises = np.flatnonzero(np.diff(trace) > share * np.maximum(np.abs(trace[:-1]), floor))
    return int(rises[0]) + 1 if rises.size else None


def _allowed(case: Case, relative: float, profile: Profile) -> Fraction:
    problem = case.request.problem
    return profile.allowed(relative, case.lower, case.target, problem.n + problem.d)


def _shown(value: Fraction, digits: int = 17) -> str:
    try:
        return f"{float(value):.{digits}g}"
    except OverflowError:
        return "more than float64 holds"
