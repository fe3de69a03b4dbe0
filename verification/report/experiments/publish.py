"""The experiments' own pages, written beside the record that they show."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from convexperc.files import check_place, write_atomic
from verification.experiments.record.reading import read_experiments
from verification.report.experiments.pages import experiment_files
from verification.report.experiments.sheets import contact_sheets

RECORD = "experiments.json"


def publish(folder: Path, data_dirs: Sequence[Path] = ()) -> list[Path]:
    """Read a record and write its pages, figures and contact sheets beside it.

    Parameters
    ----------
    folder : Path
        Holds experiments.json.
    data_dirs : sequence of Path
        Folders of the physical set and the case study; without them the sheets that are there stay.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    FileFormatError, InputError
        See `read_experiments`, `contact_sheets` and `experiment_files`.
    OSError
        A file cannot be written.
    """
    found = read_experiments(folder / RECORD, with_sheets=not data_dirs)
    if data_dirs:
        found = replace(found, sheets=contact_sheets(found.content, data_dirs))
    content = {folder / name: data for name, data in experiment_files(found).items()}
    for place in content:
        place.parent.mkdir(parents=True, exist_ok=True)
        check_place(place)
    for place, data in content.items():
        write_atomic(place, data)
    return list(content)
