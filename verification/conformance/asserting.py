"""Conformance as a test of one's own: two lines in any test suite."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from convexperc.errors import InputError
from verification.conformance.doors import SECONDS, Command, Door, Function, Module
from verification.conformance.judge import Level
from verification.conformance.profiles import PROFILES
from verification.conformance.suite import SMALLEST, Report, Selection, read_known, run

SHOWN = 400
"""Characters of a request that the error shows."""


def assert_conforms(
    solver: Callable[..., Any] | str | Sequence[str],
    *,
    level: str = "L4",
    profile: str = "float64",
    only: str = "",
    known: str | Path | None = None,
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
    seconds : float
        Time for one answer; of a function that is called here it is not kept.

    Returns
    -------
    Report

    Raises
    ------
    AssertionError
        Something failed, or nothing was answered; with the smallest failing requests.
    InputError
        There is no such level or profile, or nothing matches.
    """
    if level not in list(Level):
        raise InputError("level", value=level, must=f"must be one of {', '.join(Level)}")
    if profile not in PROFILES:
        raise InputError("profile", value=profile, must=f"must be one of {', '.join(PROFILES)}")
    selection = Selection(PROFILES[profile], only)
    report = run(_door(solver, seconds), selection, known=None if known is None else read_known(Path(known)))
    failed = [each for each in report.unexpected if each.level <= level]
    if failed:
        lines = [report.statement]
        for each in failed[:SMALLEST]:
            lines += [f"{each.id} {each.level}: {each.detail}", report.requests.get(each.id, "")[:SHOWN]]
        raise AssertionError("\n".join(lines))
    if report.reached is None and not report.known:
        raise AssertionError(f"{report.statement} Nothing was answered.")
    return report


def _door(solver: Callable[..., Any] | str | Sequence[str], seconds: float) -> Door:
    if callable(solver):
        return Function(solver)
    return Module(solver, seconds=seconds) if isinstance(solver, str) else Command(solver, seconds=seconds)
