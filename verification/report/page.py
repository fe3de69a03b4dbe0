"""report.html: one file for a screen, a phone and paper, without scripts and outside references."""

from collections.abc import Sequence
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from verification.ledger.claims import Subject
from verification.problems.families import SUMMARIES
from verification.report import sentences, words
from verification.report.contents import Cases, Report
from verification.report.experiments.blocks import Block
from verification.report.experiments.pages import environment
from verification.report.plain import plain, printable
from verification.report.plots import plot

SHADES = (0.0, 0.02, 0.1, 0.25, 0.5)
"""Lower ends of the shares of failures that are shaded alike."""
CERTIFICATES = (Subject.LIBRARY, Subject.SOLVERS)
"""The subjects of the section on certificates."""


def page(report: Report, experiments: Sequence[Block] = ()) -> bytes:
    """Render report.html.

    Parameters
    ----------
    report : Report
    experiments : sequence of Block
        See `verification.report.experiments.section.section`.

    Raises
    ------
    InputError
        A series has another shape than its figure needs.
    """
    text = _environment().get_template("page.html.j2").render(**_context(report), experiments=experiments)
    return (printable(text.rstrip()) + "\n").encode()


def _context(report: Report) -> dict[str, Any]:
    series = plain(report.series)
    return {
        "report": report,
        "words": words,
        "sentences": sentences,
        "summaries": SUMMARIES,
        "paper_claims": [claim for claim in report.claims if claim.subject not in CERTIFICATES],
        "certificate_claims": [claim for claim in report.claims if claim.subject in CERTIFICATES],
        "figures": {each.name: _figure(each, series) for each in words.FIGURES},
        "times": _figure(words.TIMES, plain(report.volatile)),
        "unrun": [each for each in sentences.figures(report) if each.name not in series],
    }


def _figure(figure: words.Figure, series: dict[str, Any]) -> Markup | None:
    """Inline SVG that is safe as it is: `plot` escapes its label, matplotlib its texts."""
    if figure.name not in series:
        return None
    label = f"{figure.title}. {figure.caption}"
    return Markup(plot(figure.name, series[figure.name], label))


def _environment() -> Environment:
    made = environment()
    made.filters |= {
        "anchor": sentences.anchor,
        "shade": _shade,
        "cell": _cell,
        "sentence": sentences.sentence,
    }
    return made


def _shade(count: Cases) -> str:
    """Class of a cell by the share of its decided cases that failed."""
    if not count.failed:
        return "none" if count.decided else "empty"
    share = count.failed / count.decided
    return f"f{max(at for at, least in enumerate(SHADES) if share >= least)}"


def _cell(count: Cases) -> str:
    """Failed of decided cases; "?" marks undecided ones."""
    shown = f"{count.failed}/{count.decided}" if count.failed else str(count.decided or "")
    undecided = f"{count.undecided}?" if count.undecided else ""
    return f"{shown} {undecided}".strip() or "-"
