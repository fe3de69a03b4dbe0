"""Confirm a record of any kind, in exact arithmetic, against the numbers that it expects."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from convexperc.errors import FileFormatError, SolverError
from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation, Player
from verification.counterexamples.confirmation import Confirmation, agree
from verification.counterexamples.given import given
from verification.counterexamples.loops import (
    confirm_locked,
    confirm_rise,
    confirm_singular,
    confirm_wrong_limit,
    the_problem,
)
from verification.counterexamples.numbers import (
    confirm_derivative,
    confirm_exponent,
    confirm_inequality,
    confirm_similarity,
    confirm_tie,
)
from verification.counterexamples.record import Record
from verification.ledger.evidence import Outcome, Refutation

BY_KIND: dict[str, Callable[[Record], Confirmation]] = {
    "rise": confirm_rise,
    "wrong_limit": confirm_wrong_limit,
    "locked": confirm_locked,
    "singular": confirm_singular,
    "inequality": confirm_inequality,
    "derivative": confirm_derivative,
    "similarity": confirm_similarity,
    "tie": confirm_tie,
    "exponent": confirm_exponent,
}


def confirm(record: Record, checks: Mapping[str, Check]) -> Confirmation:
    """Evaluate a counterexample again.

    Parameters
    ----------
    record : Record
    checks : mapping of str to Check
        By name; only kind ``case`` asks for one.

    Returns
    -------
    Confirmation
        Not confirmed if it no longer fails, or fails by other numbers than the record expects.

    Raises
    ------
    FileFormatError
        A field of the record is missing or malformed.
    """
    try:
        result = BY_KIND[record.kind](record) if record.kind in BY_KIND else _case(record, checks)
    except (KeyError, TypeError, IndexError, ZeroDivisionError) as fault:
        must = f"must have the fields of kind {record.kind} ({type(fault).__name__}: {fault})"
        raise FileFormatError(f"{record.id}: fields", value=dict(record.fields), must=must) from fault
    if not result.confirmed:
        return result
    wrong = [name for name in sorted(record.expect) if not agree(record.expect[name], result.found.get(name))]
    if wrong:
        finding = f"{result.finding}; not what the record expects of {', '.join(wrong)}"
        return replace(result, confirmed=False, finding=finding)
    return result


def completed(record: Record, checks: Mapping[str, Check]) -> Record:
    """Return a new record with what confirming it finds as what it expects from now on.

    Raises
    ------
    FileFormatError
        It is not confirmed.
    """
    result = confirm(record.expecting({}), checks)
    if not result.confirmed:
        raise FileFormatError(record.id, value=result.finding, must="must be confirmed in exact arithmetic")
    return record.expecting(result.found)


def refutation(record: Record, result: Confirmation) -> Refutation:
    """What the report says of it."""
    return Refutation(
        record.id,
        record.part,
        result.confirmed,
        result.finding,
        record.size.text,
        record.origin,
        given(record),
        _basis(record),
    )


def _basis(record: Record) -> str:
    """What a confirmation of this record rests on."""
    if record.kind not in BY_KIND:
        return "the check was run again"
    if record.origin == "catalogue":
        return "exact arithmetic"
    return "found by a check in float64, confirmed in exact arithmetic"


def _case(record: Record, checks: Mapping[str, Check]) -> Confirmation:
    """Repeat one case of a check with the numbers that were drawn, and see whether its part still fails."""
    name, drawn = record.fields["check"], list(record.fields["drawn"])
    n, d = record.fields["largest"]
    problem = the_problem(record).in_floats()
    if problem is None:
        raise FileFormatError(f"{record.id}: problem", value=record.problem, must="must be in float64")
    if name not in checks:
        return Confirmation(False, f"there is no check {name!r} any more")
    seen = next(
        (s for s in _observed(checks[name], problem, Player(drawn, (n, d))) if s.part == record.part), None
    )
    if seen is None:
        return Confirmation(False, f"the check {name!r} says nothing of {record.part} here")
    failed = seen.outcome is Outcome.FAILED
    finding = seen.detail or f"measure {seen.measure!r}"
    return Confirmation(
        failed,
        finding if failed else f"the case is {seen.outcome.value} now",
        {"outcome": seen.outcome.value},
    )


def _observed(check: Check, problem: Problem, source: Player) -> tuple[Observation, ...]:
    """Run a check; a fault of its own is an error, never a malformed record."""
    try:
        return tuple(check.observe(problem, source))
    except Exception as fault:
        must = "must not raise"
        raise SolverError(
            f"check {check.name!r}", value=f"{type(fault).__name__}: {fault}", must=must
        ) from fault
