"""Conformance as a test of one's own: two lines in any test suite."""

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from convexperc.errors import InputError
from verification.conformance.answers import told
from verification.conformance.doors import SECONDS, Command, Door, Function, Module
from verification.conformance.judge import Level
from verification.conformance.outputs import told_lines
from verification.conformance.profiles import PROFILES
from verification.conformance.suite import SMALLEST, Report, Selection, read_known, run
from verification.ledger.evidence import Outcome

SHOWN = 400
"""Characters of a request that the error shows."""


def assert_conforms(
    solver: Callable[..., Any] | str | Sequence[str],
    *,
    level: str = "L4",
    profile: str = "float64",
    only: str = "",
    known: str | Path | None = None,
    declined: bool | Sequence[str] = False,
    seconds: float = SECONDS,
) -> Report:
    """Judge a solver by all vectors; see docs/conformance.md.

    Parameters
    ----------
    solver : callable, str or sequence of str
        A function, called in this process; ``package.module:function``, in a process of its own; or the words
        of a command.
    level : str
        What is asked: "L0" .. "L4", with all levels below it.
    profile : str
        "float64" or "float32".
    only : str
        A pattern of ids, or a flag.
    known : path, optional
        A file of known failures.
    declined : bool or sequence of str
        Whether the solver may decline requests, or the patterns of ids that it may decline.
    seconds : float
        Time for one answer; of a function that is called here it is not kept.

    Returns
    -------
    Report

    Raises
    ------
    AssertionError
        Something failed, stayed undecided or was declined, or nothing was answered; with the smallest
        failing requests.
    InputError
        There is no such level or profile, or nothing matches.
    """
    if level not in list(Level):
        raise InputError("level", value=level, must=f"must be one of {', '.join(Level)}")
    if profile not in PROFILES:
        raise InputError("profile", value=profile, must=f"must be one of {', '.join(PROFILES)}")
    selection = Selection(PROFILES[profile], only)
    report = run(_door(solver, seconds), selection, known=None if known is None else read_known(Path(known)))
    lines = _failures(report, level) + _open(report, level, declined)
    if not lines and not _answered(report):
        lines = ["Nothing was answered."]
    if lines:
        raise AssertionError("\n".join([report.statement, *lines]))
    return report


def _answered(report: Report) -> bool:
    """Whether a problem was answered as the protocol says; or none was asked, only malformed requests."""
    problems = {each.id for each in report.findings if each.level is Level.L1}
    held = {each.id for each in report.findings if (each.level, each.outcome) == (Level.L0, Outcome.HELD)}
    return not problems or bool(problems & held)


def _failures(report: Report, level: str) -> list[str]:
    lines = []
    for each in [each for each in report.unexpected if each.level <= level][:SMALLEST]:
        lines += [*told_lines(each, report), report.requests.get(each.id, "")[:SHOWN]]
    return lines


def _open(report: Report, level: str, allowed: bool | Sequence[str]) -> list[str]:
    """What is neither a pass nor a failure, and not allowed."""
    patterns = ["*"] if allowed is True else allowed or []
    refused = [id for id in report.declined if not any(fnmatchcase(id, each) for each in patterns)]  # noqa: A001
    undecided = [
        f"{each.id} {each.level}"
        for each in report.findings
        if each.outcome is Outcome.UNDECIDED and each.level <= level
    ]
    lines = [f"{len(refused)} declined, which declined= may allow: {told(refused)}"] if refused else []
    lines += [f"{len(undecided)} undecided: {told(undecided)}"] if undecided else []
    return lines + ([f"not all were asked: {report.given_up}"] if report.given_up else [])


def _door(solver: Callable[..., Any] | str | Sequence[str], seconds: float) -> Door:
    if callable(solver):
        return Function(solver)
    return Module(solver, seconds=seconds) if isinstance(solver, str) else Command(solver, seconds=seconds)
