"""report.html: one file for a screen, a phone and paper, without scripts and outside references."""

from collections.abc import Mapping, Sequence
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from verification.ledger.evidence import Checker
from verification.problems.families import SUMMARIES
from verification.report import sentences, words
from verification.report.experiments.blocks import Block
from verification.report.experiments.pages import environment
from verification.report.plots import plot

SHADES = (0.0, 0.02, 0.1, 0.25, 0.5)
"""Lower ends of the shares of failures that are shaded alike."""
LIBRARY, SOLVERS = "this library", "other solvers"
"""The subjects of the section on certificates."""


def page(record: Mapping[str, Any], experiments: Sequence[Block] = ()) -> bytes:
    """Render report.html.

    Parameters
    ----------
    record : mapping
        See `verification.report.machine.report_record`.
    experiments : sequence of Block
        See `verification.report.experiments.section.section`.

    Raises
    ------
    InputError
        A series has another shape than its figure needs.
    """
    text = _environment().get_template("page.html.j2").render(**_context(record), experiments=experiments)
    return (text.rstrip() + "\n").encode()


def _context(record: Mapping[str, Any]) -> dict[str, Any]:
    subjects = list(dict.fromkeys(claim["subject"] for claim in record["claims"]))
    return {
        "record": record,
        "words": words,
        "sentences": sentences,
        "checkers": {checker.value: words.CHECKERS[checker] for checker in Checker},
        "summaries": SUMMARIES,
        "outcome": sentences.outcome(record),
        "paper_subjects": [name for name in subjects if name not in (LIBRARY, SOLVERS)],
        "certificate_subjects": [name for name in subjects if name in (LIBRARY, SOLVERS)],
        "figures": {each.name: _figure(each, record["series"]) for each in words.FIGURES},
        "times": _figure(words.TIMES, record["volatile"]),
        "unrun": [each for each in sentences.figures(record) if each.name not in record["series"]],
    }


def _figure(figure: words.Figure, series: Mapping[str, Any]) -> Markup | None:
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
        "measure": sentences.measure,
        "sentence": sentences.sentence,
    }
    return made


def _shade(count: Mapping[str, int]) -> str:
    """Class of a cell by the share of its decided cases that failed."""
    decided = count["held"] + count["failed"]
    if not count["failed"]:
        return "none" if decided else "empty"
    share = count["failed"] / decided
    return f"f{max(at for at, least in enumerate(SHADES) if share >= least)}"


def _cell(count: Mapping[str, int]) -> str:
    """Failed of decided cases; "?" marks undecided ones."""
    decided = count["held"] + count["failed"]
    shown = f"{count['failed']}/{decided}" if count["failed"] else str(decided) if decided else ""
    undecided = f"{count['undecided']}?" if count["undecided"] else ""
    return f"{shown} {undecided}".strip() or "-"
