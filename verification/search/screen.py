"""A campaign on the screen: tables by family, failures, contradictions, and shards that were lost."""

import math
from collections.abc import Iterator, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table as Grid

from verification.checks import clarabel
from verification.search.tallies import Failure, Report, Tally

MOST_SHOWN = 40
"""Failures shown on the screen; the JSON file has them all."""


def families_table(report: Report) -> Grid:
    """Counts by family and in all."""
    heads = ("problems", "certif.", "enclos.", "failed", "balls", "refereed", "loose", "contra.", "ms")
    grid, everything = _grid("family", heads), Tally()
    for name, tally in report.families.items():
        grid.add_row(_short(name), *_cells(tally))
        everything.add(tally)
    grid.add_section()
    grid.add_row("all", *_cells(everything))
    return grid


def clarabel_table(report: Report) -> Grid:
    """CVXPY and Clarabel, called directly, against the proved intervals, by family and in all."""
    heads = ("problems", "optimal", "inacc.", "failed", "outside", ">1e-8", ">1e-6", ">1e-3", "worst")
    grid, everything = _grid("CVXPY + Clarabel", heads), clarabel.Tally()
    for name, tally in report.clarabel.items():
        grid.add_row(_short(name), *_clarabel_cells(tally))
        everything.add(tally)
    grid.add_section()
    grid.add_row("all", *_clarabel_cells(everything))
    return grid


def _grid(first: str, heads: Sequence[str]) -> Grid:
    """A narrow table."""
    grid = Grid(first, box=SIMPLE_HEAD, padding=0, pad_edge=False)
    for head in heads:
        grid.add_column(head, justify="right")
    return grid


def _cells(tally: Tally) -> list[str]:
    counts = (tally.total, tally.certified, tally.enclosed, tally.failed, tally.escalated)
    refereed = tally.refereed, tally.loose, tally.contradicted
    return [*map(str, counts + refereed), f"{1e3 * tally.seconds / max(1, tally.total):.1f}"]


def _clarabel_cells(tally: clarabel.Tally) -> list[str]:
    claims = tally.total, tally.optimal, tally.inaccurate, tally.failed
    beyond = tally.outside, tally.above_1e_8, tally.above_1e_6, tally.above_1e_3
    return [*map(str, claims + beyond), "inf" if math.isinf(tally.worst) else f"{tally.worst:.0e}"]


def _short(family: str) -> str:
    return family.replace("lambda", "l").replace("_", " ")


def details(report: Report) -> Iterator[str]:
    """One line a reason, a failure (the first ones), a contradiction and a shard that was lost."""
    for reason, count in report.reasons.items():
        yield f"not certified: {count} because {reason}"
    yield from (_line(failure) for failure in report.failures[:MOST_SHOWN])
    hidden = len(report.failures) - MOST_SHOWN
    if hidden > 0:
        yield f"... and {hidden} more: see --json"
    for each in report.contradictions:
        yield f"CONTRADICTED {each.case}: {'; '.join(each.statements)}"
    for shard, ending in report.lost.items():
        yield f"LOST family|first|count {shard}: {ending}"


def _line(failure: Failure) -> str:
    case = failure.case
    return (
        f"{case.family} seed {case.seed} index {case.index}: n {failure.n} d {failure.d}"
        f" lambdas {failure.lambdas} proved {failure.relative_gap:.1e} true {failure.true_gap:.1e}"
        f" share {failure.share_of_target:.1e} status {failure.status!r}: {failure.reason}"
    )
