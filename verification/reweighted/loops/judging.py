"""Loops judged: what follows from the theorem and the terms, and the smallest instance of what goes wrong.

Everything that speaks against a loop is shown at one instance, F in rationals and balls. What is said for it
follows from the theorem of docs/reweighted-theorem.md and from what is proved of its terms, or is not said.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp
from hypothesis import strategies as st

from convexperc.errors import InputError
from verification.reweighted.answers import Answer, Answers, Word
from verification.reweighted.loops.instances import (
    STEPS,
    Build,
    Instance,
    Search,
    shown_number,
)
from verification.reweighted.loops.loop import Loop, Point, float_run, in_unit
from verification.reweighted.loops.meeting import meetings
from verification.reweighted.objectives.objective import rational_point
from verification.reweighted.terms.judging import judge_term

EXAMPLES = 200
"""Instances that are drawn for one question."""

SOME, FEW, MANY = 40, 30, 1000
"""Instances: for what is proved of all, for what costs long runs, and for what is rare and quickly seen."""

LONG = 1000
"""Iterations in float64 to where a loop ends."""

AFTER = 200
"""Iterations after an end that must not change F."""

SMALL = 1e-10
"""Share of the iterate; steps below it are an end, where the loop has no rule of its own."""

QUESTIONS = ("terms", "descends", "defined", "starts", "zeros", "units", "limit")

UNITS = tuple(Fraction(2) ** k for k in (-10, -20, -30, 20))
"""Data in other units: multiplied by these, which float64 does exactly."""


def judge_loop(
    build: Build,
    *,
    examples: int = EXAMPLES,
    questions: Sequence[str] = QUESTIONS,
    name: str = "",
    **data: st.SearchStrategy[Any],
) -> Answers:
    """Judge a reweighted loop against its own objective.

    Parameters
    ----------
    build : function
        Returns a `Loop` for the data.
    examples : int
        Instances that are drawn for a question.
    questions : sequence of str
        Which of those below.
    name : str
        Of the loop; default: the name of `build`.
    **data : Hypothesis strategies
        Of the arguments of `build`. Small integers give small counterexamples.

    Returns
    -------
    Answers
        ``terms``: is something wrong with a loss and its weight? ``descends``: does F never rise?
        ``defined``: is there always an update? ``starts`` and ``zeros``: does it leave a residual of 0 that
        is not optimal, at the start, or met later? ``units``: does it end near the optimum when the data
        are in another unit, if it does in theirs? ``limit``: is what it tends to the optimum? A NO has the
        smallest instance that was found.

    Raises
    ------
    InputError
        `build` does not return a loop for the data drawn, or there is no such question.
    """
    if odd := set(questions) - set(QUESTIONS):
        raise InputError("questions", value=sorted(odd), must=f"must be among {', '.join(QUESTIONS)}")
    search = Search(build, st.fixed_dictionaries(data), examples)
    facts = Facts.of(search.loops(SOME))
    answers = tuple(ANSWERS[question](search, facts) for question in QUESTIONS if question in questions)
    return Answers(name or getattr(build, "__name__", "loop").replace("_", " "), answers)


@dataclass(frozen=True)
class Facts:
    """What is proved of the terms of a loop, and of its form.

    Attributes
    ----------
    majorised : bool
        Every weight is >= 0 and never rises.
    tangent : bool
        Every weight is tangent, or all by one positive factor where there are no squares.
    smooth : bool
        Every weight is bounded.
    convex : bool
        Every loss is convex.
    covered : bool
        The update is the reweighted one, in the order of Gauss and Seidel or of at most two blocks.
    in_turn : bool
        Each block sees the new values of those before it, or there is one block.
    smoothing : str
        Where some weights are those of a loss within a bounded distance of the stated one, and the others are
        tangent: that distance, the largest of any term; else empty.
    free_of_units : bool
        Every weight follows a change of unit, and the loop has no stopping rule of its own.
    given_start : bool
        The loop says where it starts.
    terms : tuple of Answers
        About each loss with its weight.
    """

    majorised: bool
    tangent: bool
    smooth: bool
    convex: bool
    covered: bool
    in_turn: bool
    smoothing: str
    free_of_units: bool
    given_start: bool
    terms: tuple[Answers, ...]

    @classmethod
    def of(cls, loops: Sequence[Loop]) -> "Facts":
        """Judge the terms of some instances of one loop."""
        terms = [judge_term(term) for term in {term: None for loop in loops for term in loop.objective.terms}]

        def every(question: str) -> bool:
            return all(answers[question].word is Word.YES for answers in terms)

        factors = {answers["tangent"].instance.get("factor", "-") for answers in terms}
        bare = not any(
            part.term is None and part.coefficient for loop in loops for part in loop.objective.parts
        )
        by_one = bare and len(factors) == 1 and not next(iter(factors)).startswith("-")
        return cls(
            every("majorises") and every("sign"),
            every("tangent") or by_one,
            every("at zero"),
            every("convex"),
            all(loop.is_reweighted and (loop.order != "jacobi" or len(loop.groups) <= 2) for loop in loops),
            all(loop.order == "gauss_seidel" or len(loop.groups) == 1 for loop in loops),
            _distance(terms),
            every("units") and all(loop.update is None and loop.stop is None for loop in loops),
            any(loop.start is not None for loop in loops),
            tuple(terms),
        )

    @property
    def smoothed(self) -> bool:
        """Whether the theorem says that F never rises but for its smoothing."""
        return self.majorised and bool(self.smoothing) and self.covered

    @property
    def proved(self) -> bool:
        """Whether the theorem says that F itself never rises."""
        return self.majorised and self.tangent and self.covered


def _distance(terms: Sequence[Answers]) -> str:
    if any(answers["tangent"].word is not Word.YES and answers["tangent"].accuses for answers in terms):
        return ""
    smoothed = [answers for answers in terms if answers["tangent"].word is Word.NO]
    reaches = [answers["descends"].instance.get("distance") for answers in smoothed]
    if None in reaches:
        return "a share of its own that vanishes far from 0, not"
    return _largest([reach for reach in reaches if reach])


def _largest(reaches: Sequence[str]) -> str:
    return max(reaches, key=lambda reach: float(sp.sympify(reach)), default="")


def _terms(search: Search, facts: Facts) -> Answer:
    question, basis = "terms", "`judge_term` of each loss and its weight"
    wrong = [
        f"{each.subject}: {answer.question}: {answer.statement}"
        for each in facts.terms
        for answer in each.faults
        if not (facts.tangent and answer.question == "tangent")
    ]
    if wrong:
        return Answer(question, Word.NO, " ".join(wrong), basis)
    said = "Every weight is tangent to its loss, or smooths it, and never rises."
    if any(each["tangent"].accuses for each in facts.terms):
        said = (
            "Every weight is tangent to its loss but for one factor, which changes nothing without squares."
        )
    if any(
        each[asked].word is Word.UNDECIDED
        for each in facts.terms
        for asked in ("tangent", "majorises", "sign")
    ):
        return Answer(question, Word.UNDECIDED, "Of a loss and its weight something was not decided.", basis)
    return Answer(question, Word.YES, said, basis)


def _descends(search: Search, facts: Facts) -> Answer:
    question = "descends"
    if facts.proved:
        said = "F never rises: each weighted square lies above its loss and touches it at the iterate."
        return Answer(question, Word.YES, said, "theorem, part (a); the terms are tangent and majorise")
    if facts.smoothed:
        said = f"F with smoothed losses, each within {facts.smoothing} of its own, never rises; F itself may."
        return Answer(question, Word.NO, said, "theorem, parts (a) and (b); the integrals of the weights")
    found = search.smallest(SHOWS[question])
    if found is not None:
        at = found.run.rise or 1
        before, after = (shown_number(found.run.values[k]) for k in (at - 1, at))
        shown = {**found.shown(), "iteration": str(at), "F before": before, "F after": after}
        said = f"F rises in iteration {at}, from {before} to {after}."
        return _against(question, said, "exact iterates from the start", shown, found)
    basis = f"{search.examples} instances, {STEPS} exact iterations each"
    if facts.majorised and facts.covered:
        said = "No rise was found; what never rises is F with the losses that the weights are tangent to."
        return Answer(question, Word.UNDECIDED, said, f"theorem, part (a); {basis}")
    said = "No rise was found; the theorem does not cover this update."
    return Answer(question, Word.UNDECIDED, said, basis)


def _defined(search: Search, facts: Facts) -> Answer:
    question = "defined"
    found = search.smallest(SHOWS[question])
    if found is None:
        basis = f"{search.examples} instances, {STEPS} exact iterations each"
        return Answer(question, Word.UNDECIDED, "Every update that was tried exists.", basis)
    said = f"There is no iterate {len(found.run.points)}: {found.run.ended}"
    return _against(question, said, "exact iterates from the start", found.shown(), found)


def _starts(search: Search, facts: Facts) -> Answer:
    question = "starts"
    if facts.smooth:
        return _never_held(question)
    count = MANY if facts.given_start else search.examples
    found = search.smallest(SHOWS[question], count)
    if found is None:
        said = "No start was found that is at a residual of 0 and rests there away from the optimum."
        return Answer(question, Word.UNDECIDED, said, f"{count} instances")
    return _rests(question, "The start is", found, rational_point(found.start), "exact update")


def _rests(question: str, where: str, found: Instance, point: Point, basis: str) -> Answer:
    shown = found.shown() | found.compared(point)
    said = f"{where} at a residual of 0, where the loop rests with F = {shown['F there']}"
    said += f"; F = {shown['F elsewhere']} at {shown['better point']}."
    return _against(question, said, basis, shown, found)


def _against(question: str, said: str, basis: str, shown: dict[str, str], found: Instance) -> Answer:
    """A NO that an instance shows."""
    return Answer(question, Word.NO, said, basis, shown, True, found.as_json())


def _never_held(question: str) -> Answer:
    said = "Every weight is bounded: no residual is held at 0."
    return Answer(question, Word.YES, said, "limits of the weights at 0")


@dataclass(frozen=True)
class _Locked:
    """A zero at which an iterate after the start rests away from the optimum."""

    start: str
    point: Point
    basis: str


def _zeros(search: Search, facts: Facts) -> Answer:
    question = "zeros"
    if facts.smooth:
        return _never_held(question)
    found = search.smallest(SHOWS[question])
    locked = None if found is None else _locked(found)
    if found is None or locked is None:
        said = (
            "No start was found from which an iterate meets a residual of 0 and rests there off the optimum."
        )
        return Answer(question, Word.UNDECIDED, said, f"{search.examples} instances")
    where = f"From {locked.start} an iterate is exactly"
    answer = _rests(question, where, found, locked.point, locked.basis)
    return replace(answer, instance={**answer.instance, "start": locked.start})


def _locked(instance: Instance) -> _Locked | None:
    if not instance.starts_at_zero:
        run = instance.run
        at = run.rests or 0
        if at and instance.rests_away(run.points[at]):
            return _Locked(
                instance.shown()["start"], run.points[at], f"exact iterates; {at} is its own successor"
            )
    if instance.loop.start is not None:
        return None
    for met in meetings(instance.loop):
        zero = rational_point({met.name: [met.zero]})
        if instance.rests_away(zero):
            theorem = "" if met.lower == met.upper else "s at both ends; intermediate value theorem"
            return _Locked(met.shown(), zero, f"exact iterate{theorem}")
    return None


def _units(search: Search, facts: Facts) -> Answer:
    question = "units"
    if facts.free_of_units:
        said = "In another unit it makes the same steps: the weights follow as the losses do."
        return Answer(question, Word.YES, said, "dimensional analysis of the terms")
    found = search.smallest(SHOWS[question], FEW)
    unit = None if found is None else _unit_missed(found)
    if found is None or unit is None:
        said = "In every unit that was tried it ends as near to the optimum."
        return Answer(question, Word.UNDECIDED, said, f"{FEW} instances in float64")
    moved = _in_unit(found, unit)
    assert moved is not None
    end = _end(moved)
    assert end is not None
    shown = found.shown() | {"unit": str(unit)} | moved.compared(end)
    there, elsewhere = shown["F there"], shown["F elsewhere"]
    said = f"With the data times {unit} it ends at F = {there}; F = {elsewhere} elsewhere."
    return _against(question, said, "float64 iterates; F at both points in balls", shown, found)


def _unit_missed(instance: Instance) -> Fraction | None:
    """A unit in which the run ends away from the optimum, though it ends at it in that of the data."""
    end = _end(instance)
    if end is None or instance.better(end) is not None:
        return None
    for unit in UNITS:
        moved = _in_unit(instance, unit)
        if moved is not None and (last := _end(moved)) is not None and moved.better(last) is not None:
            return unit
    return None


def _in_unit(instance: Instance, unit: Fraction) -> Instance | None:
    """The same instance with its data in another unit; None where a loss has a unit of its own."""
    loop = in_unit(instance.loop, unit)
    if loop is None:
        return None
    start = {name: tuple(unit * x for x in values) for name, values in instance.start.items()}
    return Instance(instance.data, loop, start)


def _limit(search: Search, facts: Facts) -> Answer:
    question = "limit"
    if facts.proved and facts.convex:
        if facts.smooth and facts.in_turn:
            said = "Every limit point is a minimiser: F is convex and the weights are bounded."
            return Answer(question, Word.YES, said, "theorem, part (c)")
        said = "A limit is optimal if no residual ever is 0 and those that vanish are independent."
        if facts.smooth:
            said = "A limit is optimal if the squares are strictly convex in both blocks together."
        return Answer(question, Word.UNDECIDED, said, "theorem, part (c), where each norm is of one block")
    if facts.smoothed and facts.convex and facts.smooth and facts.in_turn:
        said = f"A limit point minimises F with smoothed losses, each within {facts.smoothing} of its own."
        return Answer(question, Word.NO, said, "theorem, parts (b) and (c)")
    if not facts.convex:
        said = "A loss is not convex: what it tends to may be a minimum that is not the least."
        return Answer(question, Word.UNDECIDED, said, "second derivatives")
    found = search.smallest(SHOWS[question], FEW)
    end = None if found is None else _end(found)
    if found is None or end is None:
        said = "No end away from the optimum was found."
        return Answer(question, Word.UNDECIDED, said, f"{FEW} instances of {LONG} iterations in float64")
    shown = found.shown() | found.compared(end)
    said = f"It ends at F = {shown['F there']}, {shown['point']}; F = {shown['F elsewhere']} elsewhere."
    basis = "float64 iterates; F at both points in balls"
    return _against(question, said, basis, shown, found)


def _rises(instance: Instance) -> bool:
    return instance.run.rise is not None


def _has_no_update(instance: Instance) -> bool:
    return bool(instance.run.ended)


def _starts_and_rests(instance: Instance) -> bool:
    return instance.starts_at_zero and instance.rests_away(rational_point(instance.start))


def _meets_and_rests(instance: Instance) -> bool:
    return _locked(instance) is not None


def _misses_in_a_unit(instance: Instance) -> bool:
    return _unit_missed(instance) is not None


def _ends_away(instance: Instance) -> bool:
    end = _end(instance)
    return end is not None and instance.better(end) is not None


def _end(instance: Instance) -> Point | None:
    """Where the float64 iterates end; None if they still move, or are not finite.

    Without a stopping rule of the loop's own, small steps are an end only if F stays where it is for many
    more: a residual that is almost 0 is left slowly.
    """
    start = {name: np.array([float(x) for x in values]) for name, values in instance.start.items()}
    run = float_run(instance.loop, start, LONG, SMALL)
    last = run.points[-1]
    if not run.ended or not all(np.isfinite(values).all() for values in last.values()):
        return None
    if instance.loop.stop is None:
        later = float_run(instance.loop, last, AFTER, -1.0).points[-1]
        F = [instance.loop.objective.in_floats(point) for point in (last, later)]
        if not abs(F[1] - F[0]) <= SMALL * abs(F[0]):
            return None
    return rational_point({name: values.tolist() for name, values in last.items()})


SHOWS: dict[str, Callable[[Instance], bool]] = {
    "descends": _rises,
    "defined": _has_no_update,
    "starts": _starts_and_rests,
    "zeros": _meets_and_rests,
    "units": _misses_in_a_unit,
    "limit": _ends_away,
}
"""What an instance shows where the answer to a question is NO."""

ANSWERS: dict[str, Callable[[Search, Facts], Answer]] = {
    "terms": _terms,
    "descends": _descends,
    "defined": _defined,
    "starts": _starts,
    "zeros": _zeros,
    "units": _units,
    "limit": _limit,
}
