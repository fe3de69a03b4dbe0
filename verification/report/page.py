"""report.html: one file for a screen, a phone and paper; it has no script and loads nothing."""

from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from verification.problems.summaries import SUMMARIES
from verification.report import captions, findings, sentences, symbols, trust, words
from verification.report.contents import Cases, Report
from verification.report.experiments.catalogue import main_drawing
from verification.report.experiments.pages import environment
from verification.report.plain import plain, printable
from verification.report.plots import has_curves, plot
from verification.report.proofs import proofs

SHADES = (0.0, 0.02, 0.1, 0.25, 0.5)
"""Lower ends of the shares of failures that are shaded alike."""
EXPERIMENTS = "experiments/experiments.html"
"""The page of the experiments, beside the report."""


def page(report: Report) -> bytes:
    """Render report.html.

    Raises
    ------
    InputError
        A series or the record of the experiments has another shape than its figure needs.
    """
    text = _environment().get_template("page.html.j2").render(**_context(report))
    return (printable(text.rstrip()) + "\n").encode()


def _context(report: Report) -> dict[str, Any]:
    series = plain(report.series)
    shown = {each.name: _figure(each, series) for each in captions.FIGURES}
    shown["overview"] = _figure(
        captions.OVERVIEW, {"overview": series["counterexample"]} if has_curves(series) else {}
    )
    theory = [claim for claim in report.claims if not (claim.surveyed or findings.is_certificate(claim))]
    return {
        "report": report,
        "words": words,
        "captions": captions,
        "symbols": symbols,
        "sentences": sentences,
        "findings": findings,
        "trust": trust,
        "proofs": proofs(report),
        "summaries": SUMMARIES,
        "theory_claims": theory,
        "surveyed_claims": [claim for claim in report.claims if claim.surveyed],
        "certificate_claims": [claim for claim in report.claims if findings.is_certificate(claim)],
        "figures": shown,
        "times": _figure(captions.TIMES, plain(report.volatile)),
        "unrun": [each for each in sentences.figures(report) if each.name not in series],
        "main_figure": main_drawing(report.experiments) if report.experiments else None,
        "page_of_experiments": EXPERIMENTS,
    }


def _figure(figure: captions.Figure, series: dict[str, Any]) -> Markup | None:
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
