"""Stored instances that speak against loops of the gallery; each replay confirms one again."""

import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from convexperc.errors import InputError
from convexperc.files import parse_json
from convexperc.report.backend import load_matplotlib
from verification.exact.balls import precision
from verification.provenance import digest
from verification.reweighted.answers import Answers, Word
from verification.reweighted.gallery import CASES
from verification.reweighted.loops.instances import (
    BITS,
    Instance,
    exact_run,
    instance,
    shown_number,
    shown_point,
)
from verification.reweighted.loops.judging import SHOWS, judge_loop

SCHEMA = "convexperc/reweighted-loops/1"
STORED = "found.json"
STEPS = 12
"""Iterations that a replay shows."""


@dataclass(frozen=True)
class Record:
    """One instance.

    Attributes
    ----------
    id : str
        The case, the question and the digest of the instance.
    case : str
        A key of `gallery.cases.CASES`.
    question : str
        A key of `judging.SHOWS`.
    statement : str
    data : mapping
        Arguments of the function that builds the loop.
    start : mapping of str to list of str
        Numbers as p/q.
    """

    id: str
    case: str
    question: str
    statement: str
    data: Mapping[str, Any]
    start: Mapping[str, Any]

    @property
    def instance(self) -> Instance:
        """The loop and its start."""
        return instance(CASES[self.case].build, self.data, self.start)

    @property
    def is_confirmed(self) -> bool:
        """Whether the instance still shows what the record says."""
        return SHOWS[self.question](self.instance)

    def table(self, steps: int = STEPS) -> list[tuple[str, str, str]]:
        """Iteration, point and F, exactly, as text."""
        run = exact_run(self.instance.loop, self.start, steps)
        with precision(BITS):
            return [
                (str(k), shown_point(point), shown_number(value))
                for k, (point, value) in enumerate(zip(run.points, run.values, strict=True))
            ]

    def plot(self, kind: str, steps: int = STEPS) -> bytes:
        """F by iteration, as .png or .svg."""
        load_matplotlib()
        from matplotlib.figure import Figure  # noqa: PLC0415 - the extra `plot`

        run = exact_run(self.instance.loop, self.start, steps)
        figure = Figure(figsize=(6.0, 3.0), layout="constrained")
        axes = figure.subplots()
        axes.plot([float(value) for value in run.values], marker="o")
        axes.set(xlabel="iteration", ylabel="F", title=f"{CASES[self.case].title}: {self.question}")
        axes.set_xticks(range(len(run.values)))
        place = io.BytesIO()
        figure.savefig(place, format=kind)
        return place.getvalue()


def records_of(case: str, answers: Answers) -> list[Record]:
    """The instances among the answers about a case."""
    return [
        Record(
            f"{case}-{answer.question}-{digest(dict(answer.replay))[:8]}",
            case,
            answer.question,
            answer.statement,
            answer.replay["data"],
            answer.replay["start"],
        )
        for answer in answers
        if answer.word is Word.NO and answer.replay
    ]


def judged(case: str) -> tuple[Answers, list[Record]]:
    """Judge a case of the gallery.

    Raises
    ------
    InputError
        There is no such case.
    """
    if case not in CASES:
        raise InputError("case", value=case, must=f"must be one of {', '.join(CASES)}")
    data: dict[str, Any] = dict(CASES[case].data)
    answers = judge_loop(CASES[case].build, name=CASES[case].title, **data)
    return answers, records_of(case, answers)


def gallery_record(found: Mapping[str, tuple[Answers, list[Record]]]) -> dict[str, Any]:
    """What is stored of cases that were judged."""
    return {
        "schema": SCHEMA,
        "cases": {
            name: {
                "answers": answers.as_json()["answers"],
                "records": [asdict(record) for record in records],
            }
            for name, (answers, records) in found.items()
        },
    }


@cache
def stored() -> dict[str, Any]:
    """What is stored of the gallery."""
    place = files("verification.reweighted.gallery").joinpath(STORED)
    return dict(parse_json(place.read_text(encoding="utf-8"), STORED))


def stored_records() -> dict[str, Record]:
    """The stored instances by id."""
    return {
        record["id"]: Record(**record) for case in stored()["cases"].values() for record in case["records"]
    }
