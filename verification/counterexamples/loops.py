"""Counterexamples that are runs of Algorithm 1: rises of F, wrong limits, locked zeros, singular systems."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from convexperc.errors import FileFormatError
from verification.counterexamples.confirmation import Confirmation, Line, minus, point, shown, text
from verification.counterexamples.record import Record, numbers_of
from verification.exact.algorithm import Update
from verification.exact.balls import UnresolvedError
from verification.exact.formulation import objective
from verification.exact.loop import Iterate, image, iterates, step
from verification.exact.numbers import Enclosure, Rational
from verification.exact.optimality import is_optimal, optimum_bounds
from verification.exact.problem import ExactProblem
from verification.exact.reweighting import SingularStepError

SHOWN_AFTER = 3
"""Iterations shown after a zero has locked or a cycle has closed."""


def confirm_rise(record: Record) -> Confirmation:
    """F(k) > F(k-1) at k = `iterations`, exactly, from the given start."""
    problem, k = the_problem(record), int(record.fields["iterations"])
    course = _course(record, problem, k)
    optimum = optimum_bounds(problem)
    if len(course) <= k or k < 1:
        return Confirmation(False, f"there is no iteration {k}: a system is singular", lines=_lines(course))
    change = minus(course[k].F, course[k - 1].F)
    found = {"F": [text(at.F) for at in course], "rise": text(change), "F_star": text(optimum)}
    before, after = shown(course[k - 1].F), shown(course[k].F)
    finding = f"iteration {k}: F {before} -> {after}, a rise of {shown(change)}; F* = {shown(optimum)}"
    return Confirmation(change.lower > 0, finding, found, _lines(course), optimum=optimum)


def confirm_wrong_limit(record: Record) -> Confirmation:
    """From `iterations` on F stays above F* by an amount: the iterates repeat, or never leave a box.

    A box that the update maps into itself holds all later iterates; F over the whole box is enclosed. Where
    `limit` is given it is a fixed point of the update, exactly, in that box.
    """
    problem, k = the_problem(record), int(record.fields["iterations"])
    optimum, course = optimum_bounds(problem), _course(record, problem, k)
    if len(course) <= k:
        return Confirmation(False, f"there is no iteration {k}: a system is singular", lines=_lines(course))
    in_a_box = "box" in record.fields
    caught, stays = _trapped(record, problem, course) if in_a_box else _repeats(record, course)
    excess = minus(stays, optimum)
    found = {"F": [text(at.F) for at in course], "F_from_then_on": text(stays)}
    found |= {"F_star": text(optimum), "excess": text(excess)}
    what = "it stays in a box that the update maps into itself" if in_a_box else "it repeats exactly"
    least = f"F >= {shown(point(stays.lower))} > F* = {shown(optimum)}"
    if "limit" in record.fields:
        limit = _point(record, "limit")
        found["F_limit"] = text(objective(problem, *limit))
        least += f"; F = {shown(objective(problem, *limit))} at the fixed point"
        caught = caught and _is_fixed(record, problem, limit)
    finding = f"from iteration {k} on {what}: {least}"
    if not caught:
        finding = (
            f"iteration {k} is not in a box that maps into itself round its fixed point, nor a repetition"
        )
    return Confirmation(
        caught and excess.lower > 0, finding, found, _lines(course, {k: "stays"}), optimum=optimum
    )


def _is_fixed(record: Record, problem: ExactProblem, limit: tuple[Rational, Rational]) -> bool:
    new, box = step(problem, update_of(record), *limit), _box(record)
    same = tuple(tuple(point(x) for x in part) for part in limit)
    return new == same and _within(same, box)


def _box(record: Record) -> tuple[tuple[Enclosure, ...], tuple[Enclosure, ...]]:
    sides = record.fields["box"]
    w, u = (tuple(Enclosure(*numbers_of(record, pair, "box")) for pair in sides[part]) for part in "wu")
    return w, u


def _repeats(record: Record, course: Sequence[Iterate]) -> tuple[bool, Enclosure]:
    period = int(record.fields["period"])
    last, before = course[-1], course[-1 - period]
    exactly = all(x.width == 0 for at in (last, before) for x in (*at.w, *at.u))
    cycle = course[-period:]
    stays = Enclosure(min(at.F.lower for at in cycle), max(at.F.upper for at in cycle))
    return exactly and (last.w, last.u) == (before.w, before.u), stays


def _trapped(record: Record, problem: ExactProblem, course: Sequence[Iterate]) -> tuple[bool, Enclosure]:
    box = _box(record)
    try:
        *new, stays = image(problem, update_of(record), *box)
    except UnresolvedError:
        return False, course[-1].F
    entered = _within((course[-1].w, course[-1].u), box)
    return entered and _within(new, box), stays


def _within(inner: Sequence[Sequence[Enclosure]], outer: Sequence[Sequence[Enclosure]]) -> bool:
    return all(
        y.lower <= x.lower and x.upper <= y.upper
        for xs, ys in zip(inner, outer, strict=True)
        for x, y in zip(xs, ys, strict=True)
    )


def confirm_locked(record: Record) -> Confirmation:
    """An entry that is exactly 0 stays so, and the best F with it exceeds F at another point.

    `best` minimises F among the points with these zeros, by its subgradients; `better` has a lower F.
    """
    problem, k = the_problem(record), int(record.fields["iterations"])
    course = _course(record, problem, k + SHOWN_AFTER)
    zeros = [int(j) for j in record.fields["zero"]]
    weights = [problem.lambda2 if j < problem.n else problem.lambda3 for j in zeros]
    stuck = all(weights) and all((*at.w, *at.u)[j] == point(0) for at in course[k:] for j in zeros)
    best, better = _point(record, "best"), _point(record, "better")
    lowest, other, optimum = objective(problem, *best), objective(problem, *better), optimum_bounds(problem)
    proved = is_optimal(problem, *best, held=zeros)
    found = {
        "F": [text(at.F) for at in course],
        "F_locked": text(lowest),
        "F_better": text(other),
        "F_star": text(optimum),
    }
    names = ", ".join(_names(problem)[j] for j in zeros)
    finding = f"{names} = 0 from iteration {k} on: F >= {shown(lowest)} ever after; F* = {shown(optimum)}"
    if not (stuck and proved):
        finding = f"{names} is not held at 0, or the best point with it is not the best"
    confirmed = stuck and proved and len(course) > k and lowest.lower > other.upper
    return Confirmation(confirmed, finding, found, _lines(course, {k: "locked"}), optimum=optimum)


def confirm_singular(record: Record) -> Confirmation:
    """The matrix of an update is singular at iteration `iterations`, by its exact rank."""
    problem, k = the_problem(record), int(record.fields["iterations"])
    course, system = _course(record, problem, k), record.fields["system"]
    remarks = {len(course) - 1: "singular next"}
    if len(course) != k + 1:
        return Confirmation(False, f"it is singular before iteration {k}", lines=_lines(course, remarks))
    exactly = [tuple(x.lower for x in part) for part in (course[-1].w, course[-1].u)]
    try:
        step(problem, update_of(record), *exactly)
    except SingularStepError as fault:
        found = {"order": fault.order, "rank": fault.rank, "F": [text(at.F) for at in course]}
        size = f"{fault.order} x {fault.order}"
        finding = f"after iteration {k} the {size} matrix of {fault.system} has rank {fault.rank}"
        exact = all(x.width == 0 for x in (*course[-1].w, *course[-1].u))
        return Confirmation(exact and fault.system == system, finding, found, _lines(course, remarks))
    return Confirmation(False, f"the matrices after iteration {k} are not singular", lines=_lines(course))


def with_iterations(record: Record, result: Confirmation, eps: Fraction, count: int) -> Confirmation:
    """Add the first `count` exact iterations to a case of T1a or T1b, whose part names the update.

    Parameters
    ----------
    record : Record
    result : Confirmation
        What confirming it gave.
    eps : Fraction
        Of the smoothed update.
    count : int

    Raises
    ------
    UnresolvedError
        4096 bits do not tell.
    """
    problem, (_, reading, order) = the_problem(record), record.part.split("/")
    update = Update(reading, order, eps if reading == "smoothed" else Fraction(0))
    course = iterates(problem, update, None, count)
    singular = {} if len(course) > count else {len(course) - 1: "the next system is singular"}
    return replace(result, lines=_lines(course, singular), optimum=optimum_bounds(problem))


def the_problem(record: Record) -> ExactProblem:
    """The record's problem.

    Raises
    ------
    FileFormatError
        It has none.
    """
    if record.problem is None:
        raise FileFormatError(
            f"{record.id}: problem", value=None, must=f"must be given in kind {record.kind}"
        )
    return record.problem


def update_of(record: Record) -> Update:
    """The record's update variant and order."""
    eps = Fraction(record.fields["eps"])
    return Update(record.fields["reading"], record.fields["order"], eps)


def _course(record: Record, problem: ExactProblem, count: int) -> tuple[Iterate, ...]:
    start = None if record.fields["start"] == "paper" else _point(record, "start")
    return iterates(problem, update_of(record), start, count)


def _point(record: Record, name: str) -> tuple[Rational, Rational]:
    parts: Any = record.fields[name]
    return numbers_of(record, parts["w"], name), numbers_of(record, parts["u"], name)


def _lines(course: Sequence[Iterate], remarks: dict[int, str] | None = None) -> tuple[Line, ...]:
    """With "rises" wherever F rose beyond doubt."""
    said = remarks or {}
    lines = []
    for i, at in enumerate(course):
        rose = i > 0 and at.F.lower > course[i - 1].F.upper
        words = (["rises"] if rose else []) + ([said[i]] if i in said else [])
        lines.append(Line(i, at, ", ".join(words)))
    return tuple(lines)


def _names(problem: ExactProblem) -> list[str]:
    return [f"w_{j + 1}" for j in range(problem.n)] + [f"u_{k + 1}" for k in range(problem.d)]
