"""The section on the experiments: rules, tables, figures and sheets, in the order in which they are read."""

from collections.abc import Iterator, Mapping
from typing import Any

from convexperc.errors import InputError
from verification.ledger.claims import PARTS, PROTOCOL
from verification.ledger.surveys import DECIDING
from verification.report.experiments import tables
from verification.report.experiments.advice import advice
from verification.report.experiments.blocks import Block, Heading, Listing, Paragraph, Picture, Sheet
from verification.report.experiments.catalogue import drawings

Data = Mapping[str, Any]
CAPTIONS = {
    "1-case-study-": "A scene of the case study: {name}. The views are ordered by |w|; good ones are framed.",
    "2-case": "The case whose weights are drawn above. Obstructed views are framed in orange.",
    "3-levels": "One object at every level of obstruction. Obstructed views are framed in orange.",
    "4-references": "The references: one view of each object, which a template is made of.",
}
"""By the beginning of a sheet's name."""
RULES = (
    ("What had been seen", PROTOCOL.seen),
    ("Trials", PROTOCOL.trials),
    ("Score", PROTOCOL.score),
    ("Unit", PROTOCOL.unit),
    ("Interval", PROTOCOL.interval),
    ("Reproduced", PROTOCOL.reproduced),
    ("Opposite", PROTOCOL.opposite),
    ("No effect", PROTOCOL.no_effect),
    ("Open", PROTOCOL.open),
    ("Configurations", PROTOCOL.configurations),
    ("Verdict", PROTOCOL.sensitivity),
)


def section(found: Data, sheets: Mapping[str, bytes]) -> list[Block]:
    """All blocks of the section.

    Parameters
    ----------
    found : mapping
        See `verification.report.experiments.summary.summary`.
    sheets : mapping of str to bytes
        JPEG by name.

    Raises
    ------
    InputError
        The record lacks something that a table or a figure needs.
    """
    try:
        return list(_blocks(found, sheets))
    except (KeyError, TypeError, ValueError, IndexError) as problem:
        if isinstance(problem, InputError):
            raise
        told = f"{type(problem).__name__}: {problem}"
        raise InputError("experiments", value=told, must="must have what the tables show") from None


def _blocks(found: Data, sheets: Mapping[str, bytes]) -> Iterator[Block]:
    sets, design = found["sets"], found["design"]
    yield Paragraph(
        "This evidence comes from a stored record; it was not found by the run that wrote this page. The"
        " record is bound by its digest, and the pictures by theirs; the verdicts were counted again from"
        " its configurations."
    )
    yield Listing(tuple(_origin(found)))
    yield Heading("Verdicts by part")
    yield tables.verdicts(sets)
    for pictures in sets:
        yield tables.deciding(pictures)
    yield Heading("What is compared")
    yield Listing(tuple((key, _compared(key)) for key in found["sets"][0]["claims"]))
    yield Heading("Rules, and what had been seen when they were written")
    yield Listing(tuple((name, _sentence(text)) for name, text in RULES))
    for pictures in sets:
        yield from _of_set(pictures, design, sheets)
    yield Heading("What a user should know")
    for pictures in sets:
        yield Heading(f"On the {pictures['name']}", 1)
        yield Listing(tuple(advice(pictures, design)))
        if "rankings" in pictures:
            yield tables.rankings(pictures)
        if "limits" in pictures:
            yield tables.factors(pictures)
            yield tables.confusion(pictures)


def _of_set(pictures: Data, design: Data, sheets: Mapping[str, bytes]) -> Iterator[Block]:
    decides = pictures["name"] == DECIDING
    yield Heading(f"Results: {pictures['name']}")
    yield Paragraph(_described(pictures))
    yield tables.baselines(pictures, design)
    yield tables.scores(pictures, design)
    yield from tables.divided(pictures, design)
    for drawing in drawings(pictures, design):
        yield Picture(drawing)
    if decides:
        yield from (Sheet(name, _caption(name), data) for name, data in sheets.items())


def _compared(key: str) -> str:
    """The statement of a part, the statistic that is compared, and on which scenes."""
    part = PARTS[key]
    if (rule := part.rule) is None:
        raise ValueError(f"{key} is no part about the experiments")
    least = f"smallest effect {rule.smallest_effect:g}" if rule.smallest_effect else "no smallest effect"
    count = "one comparison" if rule.comparisons == 1 else f"{rule.comparisons} comparisons"
    told = (part.statement, f"compared: {rule.statistic}", f"on {rule.scenes}; {count}, {least}")
    return " ".join(map(_sentence, told))


def _origin(found: Data) -> Iterator[tuple[str, str]]:
    yield "Record", f"SHA-256 {found['record']}"
    for pictures in found["sets"]:
        yield f"Pictures, {pictures['name']}", f"SHA-256 {pictures['digest']}"
    yield "Made again by", f"`{found['command']}`"


def _described(pictures: Data) -> str:
    study = pictures["case_study"]
    levels = ", ".join(f"{name} ({count})" for name, count in pictures["levels"].items())
    return (
        f"{pictures['scenes']:,} scenes of {len(pictures['objects'])} objects with"
        f" {pictures['views']:,} views:"
        f" {', '.join(pictures['objects'])}. Obstructed views, with the number of scenes: {levels}."
        " Case study:"
        f" {study['scenes']} scenes of {', '.join(study['objects'])}."
    )


def _caption(name: str) -> str:
    for start, caption in CAPTIONS.items():
        if name.startswith(start):
            return caption.format(name=name.removeprefix(start))
    return name


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}".rstrip(".") + "."
