"""Records of what a search found: a rise of F at a float point, or a failed case of a check."""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from convexperc.problem.problem import Problem
from verification.checks.interface import Check
from verification.counterexamples.kinds import completed
from verification.counterexamples.record import Record, Size, magnitude
from verification.exact.algorithm import Update
from verification.exact.problem import ExactProblem, texts


def rise_record(
    name: str, problem: Problem, update: Update, w: Iterable[float], u: Iterable[float], origin: str
) -> Record:
    """Return the confirmed record of a rise of F at one update from (w, u), floats taken as they are.

    Parameters
    ----------
    name : str
        The id.
    problem : Problem
    update : Update
    w, u : floats (n,), (d,)
        The iterate before the rise.
    origin : str
        Which search found it.

    Raises
    ------
    FileFormatError
        F does not rise here in exact arithmetic.
    """
    point = {key: texts([Fraction(float(x)) for x in part]) for key, part in (("w", w), ("u", u))}
    fields: dict[str, Any] = {"reading": update.reading, "order": update.order, "eps": str(update.eps)}
    fields |= {"start": point, "iterations": 1}
    statement = f"F rises at one {update.reading} update, {update.order.replace('_', '-')} order."
    part = f"T1a/{update.reading}/{update.order}"
    return completed(_record(name, part, "rise", statement, problem, fields, origin), {})


def case_record(
    name: str,
    part: str,
    problem: Problem,
    check: Check,
    drawn: Sequence[Any],
    largest: tuple[int, int],
    origin: str,
) -> Record:
    """Return the confirmed record of a case in which a check says that a part failed.

    Parameters
    ----------
    name, part : str
        The id, and a key of `verification.ledger.claims.PARTS`.
    problem : Problem
    check : Check
    drawn : sequence
        What a `Recorder` noted while the check ran.
    largest : (int, int)
        Of the recorded source.
    origin : str

    Raises
    ------
    FileFormatError
        The check does not fail when it is run again.
    """
    fields = {"check": check.name, "drawn": list(drawn), "largest": list(largest)}
    statement = f"The check {check.name} fails on this problem."
    return completed(_record(name, part, "case", statement, problem, fields, origin), {check.name: check})


def _record(
    name: str, part: str, kind: str, statement: str, problem: Problem, fields: Mapping[str, Any], origin: str
) -> Record:
    exact = ExactProblem.of(problem)
    size = Size(f"n = {exact.n}, d = {exact.d}, the smallest that the search met", magnitude(exact))
    return Record(name, part, kind, statement, exact, fields, origin, size)
