"""The live view of a stream: what is recognised now, by which robots, and which are missing."""

import textwrap
from collections.abc import Iterable, Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from convexperc.errors import escaped
from convexperc.report.tables import above, below

WIDTH, BAR, LONGEST = 80, 24, 140
"""Columns of the view, of the longest bar, and of a reason in all; the line of JSON has the whole of it."""


def live_view(line: Mapping[str, Any], robots: Iterable[str], rate: float | None = None) -> RenderableType:
    """Return the view of one moment, for Rich.

    Parameters
    ----------
    line : mapping
        See `recognition_line`.
    robots : iterable of str
        All robots, in the order of their rows.
    rate : float, optional
        Moments a second.
    """
    parts: list[RenderableType] = [_facts(line, rate), _robots(line, robots), *_missing(line)]
    parts += [Text(escaped(f"warning: {each}"), style="yellow") for each in line["warnings"]]
    return Panel(Group(*parts), title="convexperc recognize", width=WIDTH, padding=(0, 1))


def _facts(line: Mapping[str, Any], rate: float | None) -> Table:
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    grid.add_row("object", _object(line))
    judged = line["acceptance"]
    names = f" ({', '.join(judged['accepted'])})" if judged and judged["accepted"] else ""
    grid.add_row("acceptance", escaped(f"{judged['verdict']}{names}") if judged else "not judged")
    grid.add_row("optimum", _bounds(line["optimum"], "{} <= F* <= {}", 8))
    margin = _bounds(line["margin"], "{} to {}", 4)
    grid.add_row("margin", escaped(f"{margin} ahead of {line['runner_up']}" if line["margin"] else margin))
    if line["rules"] is not None and line["rules"]["disagreeing"]:
        grid.add_row("disagreeing", escaped(", ".join(line["rules"]["disagreeing"])))
    grid.add_row("time", _clock(line, rate))
    return grid


def _object(line: Mapping[str, Any]) -> Text:
    """The label with its verdict, or what may be it."""
    if line["verdict"] is None:
        return Text(line["reason"], style="bold red")
    shown = line["label"] or " or ".join(line["candidates"][:4])
    more = len(line["candidates"]) - 4
    if line["label"] is None and more > 0:
        shown += f" or {more} more"
    refused = line["acceptance"] is not None and line["acceptance"]["accepted"] != [line["label"]]
    text = Text(escaped(shown), style="bold yellow" if refused or line["label"] is None else "bold green")
    text.append(f"  {line['verdict']}", style="default not bold")
    if line["certified"] is False:
        text.append(", not certified", style="yellow not bold")
    return text


def _bounds(interval: Mapping[str, float | None] | None, form: str, digits: int) -> str:
    if interval is None:
        return "-"
    lower, upper = interval["lower"], interval["upper"]
    ends = "-inf" if lower is None else below(lower, digits), "inf" if upper is None else above(upper, digits)
    return form.format(*ends)


def _clock(line: Mapping[str, Any], rate: float | None) -> str:
    said = "-" if line["time"] is None else f"{line['time']:.3f} s"
    if line["milliseconds"] is not None:
        said += f", recognised in {line['milliseconds']:.1f} ms"
    return said if rate is None else f"{said}, {rate:.1f} moments a second"


def _robots(line: Mapping[str, Any], robots: Iterable[str]) -> Table:
    """A row for each robot, in an order that does not change; a missing one has no weight."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    table.add_column("robot", overflow="fold")
    for name in ("weight", "share"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True, min_width=BAR)
    table.add_column("view", justify="right", no_wrap=True)
    ranked = {each["name"]: each for each in line["ranked_views"]}
    for name in robots:
        if name in ranked:
            table.add_row(escaped(name), *_weights(ranked[name]), _offset(line, name))
        else:
            table.add_row(escaped(name), "", "", Text("missing", style="red"), "")
    return table


def _missing(line: Mapping[str, Any]) -> list[Text]:
    """Why robots are missing."""
    reasons = (
        (name, textwrap.shorten(why, LONGEST, placeholder=" ...")) for name, why in line["missing"].items()
    )
    return [Text(escaped(f"{name}: {why}"), style="red") for name, why in reasons]


def _weights(entry: Mapping[str, Any]) -> tuple[str, str, Text]:
    weight = "inf" if entry["weight"] is None else f"{entry['weight']:.4f}"
    share = entry["share"] or 0.0
    return weight, f"{100 * share:.1f} %", Text("\N{FULL BLOCK}" * round(BAR * share), style="blue")


def _offset(line: Mapping[str, Any], name: str) -> str:
    """How much the view is later than the moment, in milliseconds."""
    time = line["views"].get(name)
    if time is None or line["time"] is None:
        return ""
    return f"{1000 * (time - line['time']):+.0f} ms"
