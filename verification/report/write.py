"""All files of a report, each written whole; SHA256SUMS last, so that what it lists is there."""

import re
from collections.abc import Mapping
from pathlib import Path

from convexperc.errors import InputError
from convexperc.files import check_place, write_atomic
from verification.experiments.record.reading import Experiments
from verification.ledger.baseline import Judged
from verification.report.build import build
from verification.report.experiments.pages import experiment_files
from verification.report.experiments.summary import summary
from verification.report.junit import junit
from verification.report.markdown import markdown
from verification.report.page import EXPERIMENTS, page
from verification.report.sums import listed, sums

RECORDS = "counterexamples"
SUMS = "SHA256SUMS"
PAGE = EXPERIMENTS.rpartition("/")[2]
RECORD_NAME = re.compile(r"[a-z0-9][a-z0-9._-]*\.json")


def files(run: Judged, records: Mapping[str, bytes], stored: Experiments | None = None) -> dict[str, bytes]:
    """The content of every file of the report but SHA256SUMS, by its name in the folder.

    The page of the experiments is among them where a claim about them was judged by a record.

    Raises
    ------
    InputError
        The settings lack something, a series or the record of the experiments has another shape than its
        figure needs, or the name of a record is no plain file name.
    """
    if wrong := [name for name in records if not RECORD_NAME.fullmatch(name)]:
        raise InputError(
            "records", value=wrong, must="must have names of a-z, 0-9, '.', '_', '-' that end in .json"
        )
    shown = summary(stored) if stored is not None and run.evidence.surveys else None
    report = build(run, records, shown)
    beside = {EXPERIMENTS: experiment_files(stored)[PAGE]} if stored is not None and shown is not None else {}
    return (
        {f"{RECORDS}/{name}": data for name, data in sorted(records.items())}
        | beside
        | {
            "report.html": page(report),
            "report.md": markdown(report),
            "report.json": report.file,
            "junit.xml": junit(report),
        }
    )


def store(content: Mapping[str, bytes], outdir: Path) -> None:
    """Write the files of a report into a folder, in place of the one that may be there.

    Every place is looked at before anything is written. Counterexamples and the page of the experiments of
    the former report, as its SHA256SUMS lists them, are removed where the new one has none of their name; no
    other file is touched.

    Parameters
    ----------
    content : mapping of str to bytes
        See `files`.
    outdir : Path
        Made if absent.

    Raises
    ------
    InputError
        The folder cannot be written, or something other than a file is in the place of one.
    """
    try:
        (outdir / RECORDS).mkdir(parents=True, exist_ok=True)
        for name in (*content, SUMS):
            (outdir / name).parent.mkdir(exist_ok=True)
            check_place(outdir / name)
        _withdraw(outdir, content)
    except OSError as problem:
        raise InputError(
            str(outdir), value=problem.strerror, must="must be a folder that can be written"
        ) from None
    for name, data in content.items():
        write_atomic(outdir / name, data)
    write_atomic(outdir / SUMS, sums(content))


def _withdraw(outdir: Path, content: Mapping[str, bytes]) -> None:
    """Take back the former SHA256SUMS, about to be wrong, and the files that are no more."""
    former = outdir / SUMS
    if not former.is_file():
        return
    names = listed(former.read_bytes())
    former.unlink()
    for name in names:
        folder, _, file = name.rpartition("/")
        ours = name == EXPERIMENTS or (folder == RECORDS and RECORD_NAME.fullmatch(file))
        if ours and name not in content:
            (outdir / name).unlink(missing_ok=True)
