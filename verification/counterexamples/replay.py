"""Replay a counterexample: evaluate it again, and show it iteration by iteration as a table and a plot."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from convexperc.errors import InputError
from convexperc.report.backend import load_matplotlib
from convexperc.solvers.paper.variants import SMOOTHED
from verification.checks.interface import Check
from verification.counterexamples.confirmation import Confirmation, Line, minus, shown
from verification.counterexamples.given import in_words
from verification.counterexamples.kinds import confirm
from verification.counterexamples.loops import with_iterations
from verification.counterexamples.record import Record
from verification.exact.numbers import Enclosure
from verification.ledger.claims import PARTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH = 100
"""Columns of the terminal that a table fits into."""

MOST_ENTRIES = 4
"""Entries of w and of u that a table shows."""

SHOWN = 25
"""Iterations shown of a case that a search found."""

LOOPS = ("T1a/", "T1b/")
"""Parts whose cases are runs of Algorithm 1."""

PLOTS = ("svg", "png")
INK, QUIET, ACCENT, ALARM = "#1d2733", "#6b7683", "#0b6fb8", "#b3261e"
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "text.color": INK,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "svg.hashsalt": "convexperc",
    "svg.fonttype": "path",
}


@dataclass(frozen=True)
class Row:
    """One iteration as it is shown: exact where short, else rounded; `decimal` always."""

    iteration: int
    w: str
    u: str
    F: str
    decimal: float
    excess: float
    remark: str


@dataclass(frozen=True)
class Replay:
    """A record, evaluated again.

    Attributes
    ----------
    record : Record
    result : Confirmation
    """

    record: Record
    result: Confirmation

    @property
    def stale(self) -> bool:
        """Whether the record no longer fails, or not by the numbers that it expects."""
        return not self.result.confirmed

    @property
    def verdict(self) -> str:
        """One line: what was found, or that the record is stale."""
        word = "stale: " if self.stale else "confirmed: "
        return word + self.result.finding

    @property
    def rows(self) -> tuple[Row, ...]:
        """By iteration; empty where the record has none."""
        return tuple(_row(line, self.result.optimum) for line in self.result.lines)

    def table(self) -> Table:
        """The iterations, or the numbers that are compared, at most `WIDTH` columns wide."""
        table = Table(box=SIMPLE_HEAD, width=WIDTH, title=Text(self.record.id), title_justify="left")
        if self.result.lines:
            self._by_iteration(table)
        elif self.result.sides:
            self._sides(table)
        else:
            table.add_column("finding", overflow="fold")
            table.add_row(Text(self.result.finding))
        return table

    def text(self) -> tuple[str, ...]:
        """The lines above the table: what is claimed, on which problem, and what comes out."""
        record = self.record
        return (
            f"{record.part}: {PARTS[record.part].statement}",
            record.statement,
            *([] if record.problem is None else [in_words(record.problem)]),
            f"smallness: {record.size.text}",
            f"origin: {record.origin}",
            self.verdict,
        )

    def plot(self, kind: str = "svg") -> bytes:
        """Draw F by iteration, or the compared numbers as bars; the same record gives the same bytes.

        Raises
        ------
        InputError
            Another kind than svg or png.
        MissingExtraError
            Matplotlib is not installed.
        """
        if kind not in PLOTS:
            raise InputError("plot", value=kind, must=f"must be one of {', '.join(PLOTS)}")
        load_matplotlib()
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - the table does without it
        from matplotlib.figure import Figure  # noqa: PLC0415

        from convexperc.report.canvas import settings  # noqa: PLC0415

        with settings(STYLE):
            figure = Figure(figsize=(6.4, 3.6), layout="constrained")
            FigureCanvasAgg(figure)
            axes = figure.subplots()
            if self.result.lines:
                _draw_iterations(axes, self.rows, self.result.optimum)
            else:
                _draw_sides(axes, self.result)
            axes.set_title(self.record.id, loc="left", color=INK)
            axes.spines[["top", "right"]].set_visible(False)
            stream = io.BytesIO()
            unset = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
            figure.savefig(stream, format=kind, metadata=unset, dpi=120)
        return stream.getvalue()

    def _by_iteration(self, table: Table) -> None:
        for name in ("i", "w", "u", "F", "F decimal", "F - F*"):
            vector = name in ("w", "u")
            justify: Literal["left", "right"] = "left" if vector else "right"
            table.add_column(name, justify=justify, overflow="fold", no_wrap=not vector)
        table.add_column("", overflow="fold")
        for row in self.rows:
            excess = "" if self.result.optimum is None else f"{row.excess:.3e}"
            style = "bold" if row.remark else ""
            exact = row.F if "." not in row.F else ""
            cells = (str(row.iteration), row.w, row.u, exact, f"{row.decimal:.10g}", excess, row.remark)
            table.add_row(*(Text(cell) for cell in cells), style=style)

    def _sides(self, table: Table) -> None:
        table.add_column("number", overflow="fold")
        table.add_column("exact", justify="right", overflow="fold")
        table.add_column("decimal", justify="right")
        sides = [(side.label, side.value) for side in self.result.sides]
        if len(sides) == 2:
            sides.append(("difference", minus(sides[0][1], sides[1][1])))
        for label, value in sides:
            table.add_row(Text(label), Text(_exactly(value)), Text(f"{float(value.lower):.10g}"))


def replay(record: Record, checks: Mapping[str, Check]) -> Replay:
    """Evaluate a record again, in exact arithmetic.

    Parameters
    ----------
    record : Record
    checks : mapping of str to Check
        By name; only kind ``case`` asks for one.

    Returns
    -------
    Replay

    Raises
    ------
    FileFormatError
        A field of the record is missing or malformed.
    """
    result = confirm(record, checks)
    problem = None if record.problem is None else record.problem.in_floats()
    if record.kind == "case" and record.part.startswith(LOOPS) and problem is not None:
        eps = Fraction(SMOOTHED.for_problem(problem).eps or 0.0)
        result = with_iterations(record, result, eps, SHOWN)
    return Replay(record, result)


def _row(line: Line, optimum: Enclosure | None) -> Row:
    at = line.at
    excess = float("nan") if optimum is None else float(minus(at.F, optimum).lower)
    w, u = _vector(at.w), _vector(at.u)
    return Row(line.iteration, w, u, shown(at.F), float(at.F.lower), excess, line.remark)


def _vector(values: Sequence[Enclosure]) -> str:
    cells = [shown(value, 8) if value.width == 0 else f"{float(value.lower):.6g}" for value in values]
    cells = [
        f"{float(v.lower):.6g}" if len(cell) > 9 else cell for cell, v in zip(cells, values, strict=True)
    ]
    dots = ["..."] if len(cells) > MOST_ENTRIES else []
    return "(" + ", ".join(cells[:MOST_ENTRIES] + dots) + ")"


def _exactly(value: Enclosure) -> str:
    if value.width == 0:
        return shown(value, 30)
    return f"[{shown(Enclosure(value.lower, value.lower))}, {shown(Enclosure(value.upper, value.upper))}]"


def _draw_iterations(axes: "Axes", rows: Sequence[Row], optimum: Enclosure | None) -> None:
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415 - the table does without it

    at = [row.iteration for row in rows]
    F = [row.decimal for row in rows]
    if optimum is not None:
        low, high = float(optimum.lower), float(optimum.upper)
        axes.axhspan(low, high, color=ACCENT, alpha=0.25, linewidth=2, label="F*, proved interval")
    axes.plot(at, F, color=INK, marker="o", markersize=4, linewidth=1.2, label="F(w(i), u(i))")
    rises = [i for i, row in enumerate(rows) if "rises" in row.remark]
    if rises:
        axes.plot(
            [at[i] for i in rises], [F[i] for i in rises], "^", color=ALARM, markersize=8, label="rises"
        )
    axes.set_xlabel("iteration i")
    axes.set_ylabel("F")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False)


def _draw_sides(axes: "Axes", result: Confirmation) -> None:
    labels = [side.label for side in result.sides]
    low = [float(side.value.lower) for side in result.sides]
    high = [float(side.value.upper) for side in result.sides]
    places = list(range(len(labels)))[::-1]
    axes.hlines(places, low, high, color=ACCENT, linewidth=6)
    axes.plot(low, places, "|", color=INK, markersize=14)
    axes.plot(high, places, "|", color=INK, markersize=14)
    axes.set_yticks(places, labels)
    axes.set_ylim(-0.6, len(places) - 0.4)
    axes.margins(x=0.15)
