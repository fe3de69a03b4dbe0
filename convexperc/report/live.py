"""The live view of a stream: what is recognised now, by which robots, and which are missing."""

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from convexperc.errors import InputError, check_type, entries, escaped
from convexperc.report.lines import SCHEMA
from convexperc.report.tables import above, accepted, below, margin_words, percents

EPOCH = 1e9, 1e10
"""Seconds since the epoch from 2001 to 2286; other times are those of a recording without a clock."""
WIDTH, BAR, LONGEST = 80, 24, 140
"""Columns of the view, of the longest bar, and of a reason in all; the line of JSON has the whole of it."""
NAMES, NUMBERS = 19, 33
"""Columns of the robots' names, for which the bars make room, and of all else beside a bar."""
MISSING = "missing"


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
    check_type(line, Mapping, "line")
    if line.get("schema") != SCHEMA:
        raise InputError("line", value=dict(line), must="must be what recognition_line returns")
    check_type(rate, (int, float, type(None)), "rate")
    robots = tuple(entries(robots, "robots"))
    for robot in robots:
        check_type(robot, str, "a robot's name")
    parts: list[RenderableType] = [_facts(line, rate), _Robots(line, robots), *_missing(line)]
    parts += [Text(escaped(f"warning: {each}"), style="yellow") for each in line["warnings"]]
    return Panel(Group(*parts), title="convexperc recognize", width=WIDTH, padding=(0, 1))


def _facts(line: Mapping[str, Any], rate: float | None) -> Table:
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    grid.add_row("object", _object(line))
    grid.add_row("acceptance", escaped(accepted(line["acceptance"])))
    grid.add_row("optimum", _bounds(line["optimum"]))
    grid.add_row("margin", escaped(_margin(line)))
    explained = f"{percents(_ends(line['explained']))} of ||o||^2 by the views" if line["explained"] else "-"
    grid.add_row("explained", explained)
    if line["rules"] is not None and line["rules"]["disagreeing"]:
        grid.add_row("disagreeing", escaped(", ".join(line["rules"]["disagreeing"])))
    grid.add_row("time", _clock(line))
    speed = _speed(line, rate)
    if speed:
        grid.add_row("speed", speed)
    return grid


def _object(line: Mapping[str, Any]) -> Text:
    """What is accepted, and what is proved; only a label that is accepted alone is green.

    Without a calibration nothing says that the label is right, so that it has no colour.
    """
    if line["verdict"] is None:
        return Text(line["reason"], style="bold red")
    judged, proved = line["acceptance"], line["label"] or _either(line["candidates"])
    said = line["verdict"]
    if judged is not None and (line["label"] is None or judged["accepted"] != [line["label"]]):
        text = _refused(judged)
        said = f"{said.removeprefix('proved: ')}: {proved}"
    else:
        style = "bold yellow" if line["label"] is None else "bold" if judged is None else "bold green"
        text = Text(escaped(proved), style=style)
    text.append(escaped(f"  {said}"), style="default not bold")
    if line["certified"] is False:
        text.append(", not certified", style="yellow not bold")
    return text


def _refused(judged: Mapping[str, Any]) -> Text:
    """What a calibration says that does not accept the label, or not alone."""
    accepted = judged["accepted"]
    if not accepted:
        return Text("unknown", style="bold red")
    said = f"ambiguous: {_either(accepted)}" if len(accepted) > 1 else f"accepted: {accepted[0]}"
    return Text(escaped(said), style="bold yellow")


def _either(names: Sequence[str]) -> str:
    """Four of the names at most, and how many more there are."""
    more = f" or {len(names) - 4} more" if len(names) > 4 else ""
    return " or ".join(names[:4]) + more


def _margin(line: Mapping[str, Any]) -> str:
    """How far the next object lies behind."""
    if line["margin"] is None:
        return "-"
    return margin_words(_ends(line["margin"]), line["decision"], line["runner_up"])


def _bounds(interval: Mapping[str, float | None] | None) -> str:
    if interval is None:
        return "-"
    lower, upper = interval["lower"], interval["upper"]
    ends = "-inf" if lower is None else below(lower, 8), "inf" if upper is None else above(upper, 8)
    return f"{ends[0]} <= F* <= {ends[1]}"


def _ends(interval: Mapping[str, float]) -> tuple[float, float]:
    return interval["lower"], interval["upper"]


def _clock(line: Mapping[str, Any]) -> str:
    """The time of the moment: date and local time of one since the epoch, seconds of any other."""
    time, nanoseconds = line["time"], line["nanoseconds"]
    if time is None or not EPOCH[0] <= time < EPOCH[1]:
        return "-" if time is None else f"{time:.3f} s"
    seconds, rest = divmod(nanoseconds, 10**9)
    shown = datetime.fromtimestamp(seconds).astimezone()
    return f"{shown:%Y-%m-%d %H:%M:%S}.{rest // 10**6:03}"


def _speed(line: Mapping[str, Any], rate: float | None) -> str:
    took = [] if line["milliseconds"] is None else [f"recognised in {line['milliseconds']:.1f} ms"]
    return ", ".join(took if rate is None else [*took, f"{rate:.1f} moments a second"])


@dataclass(frozen=True)
class _Robots:
    """A row for each robot, in an order that does not change; a missing one has no weight.

    In a narrow terminal the bars are shorter, and then there are neither bars nor weights.
    """

    line: Mapping[str, Any]
    robots: tuple[str, ...]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table]:
        names = min(NAMES, max(map(len, self.robots), default=0))
        yield self._table(min(BAR, options.max_width - names - NUMBERS))

    def _table(self, bar: int) -> Table:
        wide = bar >= len(MISSING)
        table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
        table.add_column("robot", overflow="fold")
        if wide:
            table.add_column("weight", justify="right", no_wrap=True)
        table.add_column("share", justify="right", no_wrap=True)
        if wide:
            table.add_column("", no_wrap=True, min_width=bar)
        table.add_column("view", justify="right", no_wrap=True)
        ranked = {each["name"]: each for each in self.line["ranked_views"]}
        for name in self.robots:
            shown = _weights(ranked[name], bar) if name in ranked else ("", "", Text(MISSING, style="red"))
            when = _offset(self.line, name) if name in ranked else ""
            narrow = shown[1] if name in ranked else shown[2]
            table.add_row(escaped(name), *(shown if wide else (narrow,)), when)
        return table


def _missing(line: Mapping[str, Any]) -> list[Text]:
    """Why robots are missing."""
    reasons = (
        (name, textwrap.shorten(why, LONGEST, placeholder=" ...")) for name, why in line["missing"].items()
    )
    return [Text(escaped(f"{name}: {why}"), style="red") for name, why in reasons]


def _weights(entry: Mapping[str, Any], bar: int) -> tuple[str, str, Text]:
    weight = "inf" if entry["weight"] is None else f"{entry['weight']:.4f}"
    share = entry["share"] or 0.0
    return weight, f"{100 * share:.1f} %", Text("\N{FULL BLOCK}" * round(bar * share), style="blue")


def _offset(line: Mapping[str, Any], name: str) -> str:
    """How much the view is later than the moment, in milliseconds."""
    time = line["views"].get(name)
    if time is None or line["time"] is None:
        return ""
    return f"{1000 * (time - line['time']):+.0f} ms"
