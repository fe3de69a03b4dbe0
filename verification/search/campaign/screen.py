"""A campaign on the screen: tables by family, failures and contradictions, and how far it has come."""

import math
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar

from rich.box import SIMPLE_HEAD
from rich.table import Table as Grid

from verification.problems.families import FAMILIES
from verification.search.campaign.file import Settings, save
from verification.search.campaign.run import State
from verification.search.campaign.tallies import Failure, RawTally, Report, Tally

T = TypeVar("T")

MOST_SHOWN = 40
"""Failures shown on the screen; the JSON file has them all."""
EVERY = 30.0
"""Seconds between two checkpoints."""


class Watch:
    """Called after every chunk: says how far the campaign has come, and saves it now and then.

    Parameters
    ----------
    settings : Settings
    command : list of str
    file : Path or None
        Where to save.
    """

    def __init__(self, settings: Settings, command: list[str], file: Path | None) -> None:
        self._settings, self._command, self._file = settings, command, file
        self._start = self._last = time.monotonic()
        self._before: int | None = None

    def __call__(self, state: State) -> None:
        """Count, tell and save."""
        now, total = time.monotonic(), len(self._settings.plan)
        if self._before is None:
            self._before, self._start = state.report.total, now
        if now - self._last < EVERY and state.done < state.chunks:
            return
        self._last = now
        done = state.report.total
        rate = (done - self._before) / max(now - self._start, 1e-9)
        left = f"{(total - done) / rate / 60.0:.1f} min left" if rate else "time left unknown"
        bad = f"{len(state.report.failures)} failed, {len(state.report.contradictions)} contradicted"
        print(f"{done} of {total}: {rate:.0f}/s, {left}; {bad}", file=sys.stderr, flush=True)  # noqa: T201
        if self._file is not None:
            save(self._file, self._command, self._settings, state)


def _grid(head: str) -> Grid:
    """A narrow table."""
    return Grid(head, box=SIMPLE_HEAD, padding=0, pad_edge=False)


def _sorted(counts: dict[str, T]) -> list[tuple[str, T]]:
    """By the order of the families."""
    order = list(FAMILIES)
    return sorted(counts.items(), key=lambda item: order.index(item[0]))


def families_table(report: Report) -> Grid:
    """Counts by family and in all."""
    grid = _grid("family")
    for head in ("problems", "certif.", "enclos.", "failed", "balls", "refereed", "loose", "contra.", "ms"):
        grid.add_column(head, justify="right")
    everything = Tally("all")
    for _, tally in _sorted(report.families):
        grid.add_row(*_cells(tally))
        everything.add(tally)
    grid.add_section()
    grid.add_row(*_cells(everything))
    return grid


def _cells(tally: Tally) -> list[str]:
    counts = (tally.total, tally.certified, tally.enclosed, tally.failed, tally.escalated)
    judged = tally.refereed, tally.loose, tally.contradicted
    return [
        _short(tally.family),
        *map(str, counts + judged),
        f"{1e3 * tally.seconds / max(1, tally.total):.1f}",
    ]


def raw_table(report: Report) -> Grid:
    """Raw CVXPY + Clarabel against the proved intervals, by family and in all."""
    grid = _grid("raw CVXPY + Clarabel")
    for head in ("problems", "optimal", "inacc.", "failed", "outside", ">1e-8", ">1e-6", ">1e-3", "worst"):
        grid.add_column(head, justify="right")
    everything = RawTally()
    for name, raw in _sorted(report.raw):
        grid.add_row(_short(name), *_raw_cells(raw))
        everything.add(raw)
    grid.add_section()
    grid.add_row("all", *_raw_cells(everything))
    return grid


def _raw_cells(raw: RawTally) -> list[str]:
    claims = raw.total, raw.optimal, raw.inaccurate, raw.failed
    beyond = raw.outside, raw.above_1e_8, raw.above_1e_6, raw.above_1e_3
    return [*map(str, claims + beyond), "inf" if math.isinf(raw.worst) else f"{raw.worst:.0e}"]


def _short(family: str) -> str:
    return family.replace("lambda", "l").replace("_", " ")


def details(report: Report) -> Iterator[str]:
    """One line a reason, a failure (the first ones) and a contradiction."""
    for reason, count in report.reasons().items():
        yield f"not certified: {count} because {reason}"
    yield from (_line(failure) for failure in report.failures[:MOST_SHOWN])
    hidden = len(report.failures) - MOST_SHOWN
    if hidden > 0:
        yield f"... and {hidden} more: see --json"
    for each in report.contradictions:
        yield f"CONTRADICTED {each.case}: {'; '.join(each.statements)}"


def _line(failure: Failure) -> str:
    case = failure.case
    return (
        f"{case.family} seed {case.seed} index {case.index}: n {failure.n} d {failure.d}"
        f" lambdas {failure.lambdas} proved {failure.relative_gap:.1e} true {failure.true_gap:.1e}"
        f" share {failure.share_of_target:.1e} claim {failure.claim!r}: {failure.reason}"
    )
