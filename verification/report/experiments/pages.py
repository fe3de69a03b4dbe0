"""The experiments as files of their own: experiments.html, experiments.md, the figures and the sheets."""

import base64
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from convexperc.errors import FileFormatError
from convexperc.files import check_place, write_atomic
from verification.experiments.record.contact_sheets import sheet_files
from verification.experiments.record.reading import PACKAGED, SHEETS, Experiments, packaged
from verification.ledger.evidence import Verdict
from verification.ledger.surveys import DECIDING
from verification.provenance import TOP
from verification.report.experiments.blocks import Picture
from verification.report.experiments.markdown import lines
from verification.report.experiments.section import section
from verification.report.experiments.summary import summary
from verification.report.findings import counted
from verification.report.mathml import set_formulas
from verification.report.words import TONES

TITLE = "The paper's experiments, repeated on simulated scenes and photographs"


def publish(found: Experiments, folder: Path) -> list[Path]:
    """Write the pages, figures and contact sheets of a record into a folder; see `experiment_files`."""
    return _write(experiment_files(found), folder)


def publish_packaged(folder: Path) -> list[Path]:
    """Write the pages and figures of the record that comes with the verifier.

    Within the project the pages show the contact sheets from where they lie; elsewhere they are copied.

    Raises
    ------
    FileFormatError
        The verifier comes without a record, or it is damaged.
    """
    found = packaged()
    if found is None:
        raise FileFormatError(PACKAGED.name, value="no file", must="must come with the verifier")
    inside = folder.resolve().is_relative_to(TOP)
    place = Path(os.path.relpath(PACKAGED.parent / SHEETS, folder.resolve())).as_posix() if inside else ""
    return _write(experiment_files(found, place), folder)


def _write(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Look at every place, then write each file whole."""
    content = {folder / name: data for name, data in files.items()}
    for place in content:
        place.parent.mkdir(parents=True, exist_ok=True)
        check_place(place)
    for place, data in content.items():
        write_atomic(place, data)
    return list(content)


def experiment_files(found: Experiments, sheets_at: str = "") -> dict[str, bytes]:
    """The content of every file, by its name in the folder.

    Parameters
    ----------
    found : Experiments
        See `verification.experiments.record.reading`; its sheets go into the page.
    sheets_at : str
        Where its sheets lie, seen from the folder; if empty, they are among the files.

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
    text = "\n".join([f"# {TITLE}", "", lead, "", *lines(blocks, 2, sheets=sheets_at or SHEETS)])
    figures = {
        f"figures/{block.drawing.name}.svg": block.drawing.standalone.encode()
        for block in blocks
        if isinstance(block, Picture)
    }
    sheets = {} if sheets_at else sheet_files(found.digest, found.sheets)
    pages = {"experiments.html": page, "experiments.md": text}
    return (
        {name: f"{each.rstrip()}\n".encode() for name, each in pages.items()}
        | figures
        | {f"{SHEETS}/{name}": data for name, data in sheets.items()}
    )


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
        "formulas": set_formulas,
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
        beside = "" if each["name"] == DECIDING else ", beside it"
        told.append(f"{str(each['name']).capitalize()}{beside}: of {len(found)} parts, {counted(found)}.")
    return " ".join(told)
