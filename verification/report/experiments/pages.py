"""The experiments as files of their own: experiments.html, experiments.md, the figures and the sheets."""

import base64
from collections.abc import Mapping
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from verification.experiments.record.contact_sheets import sheet_files
from verification.experiments.record.reading import SHEETS, Experiments
from verification.ledger.evidence import Verdict
from verification.ledger.surveys import DECIDING
from verification.report.experiments.blocks import Picture
from verification.report.experiments.markdown import lines
from verification.report.experiments.section import section
from verification.report.experiments.summary import summary
from verification.report.words import TONES

TITLE = "The experiments, done again on simulated scenes and photographs"


def experiment_files(found: Experiments) -> dict[str, bytes]:
    """The content of every file, by its name in the folder of the record.

    Parameters
    ----------
    found : Experiments
        See `verification.experiments.record.reading`; its sheets go into the page, and beside it.

    Raises
    ------
    InputError
        The record lacks something that a table or a figure needs.
    """
    told = summary(found)
    blocks = section(told, found.sheets)
    lead = _lead(told["sets"])
    html = environment().get_template("experiments_page.html.j2")
    page = html.render(title=TITLE, lead=lead, blocks=blocks)
    text = "\n".join([f"# {TITLE}", "", lead, "", *lines(blocks, 2)])
    figures = {
        f"figures/{block.drawing.name}.svg": block.drawing.standalone.encode()
        for block in blocks
        if isinstance(block, Picture)
    }
    sheets = {f"{SHEETS}/{name}": data for name, data in sheet_files(found.digest, found.sheets).items()}
    pages = {"experiments.html": page, "experiments.md": text}
    return {name: f"{each.rstrip()}\n".encode() for name, each in pages.items()} | figures | sheets


def environment() -> Environment:
    """What all pages are rendered by."""
    made = Environment(
        loader=PackageLoader("verification.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {
        "tone": lambda verdict: TONES[Verdict(verdict)],
        "base64": lambda data: base64.b64encode(data).decode(),
    }
    made.globals["verdicts"] = [verdict.value for verdict in Verdict]
    return made


def _lead(sets: list[Mapping[str, Any]]) -> str:
    """How many parts of the claims have which verdict."""
    told = []
    for each in sets:
        found = [claim["verdict"] for claim in each["claims"].values()]
        counts = [f"{found.count(verdict)} {verdict.value}" for verdict in Verdict if verdict in found]
        beside = "" if each["name"] == DECIDING else ", beside it"
        told.append(f"{str(each['name']).capitalize()}{beside}: of {len(found)} parts {', '.join(counts)}.")
    return " ".join(told)
