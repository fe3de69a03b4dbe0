"""The written proofs of a report: every argument once, and every step once, however often it is used."""

import re
from collections import Counter
from collections.abc import Collection, Iterator
from itertools import groupby
from typing import NamedTuple

from verification.ledger.evidence import Argument, Checker, Step
from verification.report.contents import JudgedPart, Report


class Used(NamedTuple):
    """A step of an argument.

    Attributes
    ----------
    step : Step
    name : str
        What its statement starts with.
    anchor : str
        Its id on the page.
    shown : bool
        Whether it is shown here; else a former argument shows it.
    """

    step: Step
    name: str
    anchor: str
    shown: bool


class Proof(NamedTuple):
    """An argument, the part that it proves, and its steps."""

    part: JudgedPart
    argument: Argument
    steps: tuple[Used, ...]

    @property
    def runs(self) -> list[list[Used]]:
        """Its steps, each that is shown here alone, those that are shown elsewhere together."""
        runs: list[list[Used]] = []
        for shown, group in groupby(self.steps, key=lambda used: used.shown):
            steps = list(group)
            runs += [[each] for each in steps] if shown else [steps]
        return runs


class Proofs(NamedTuple):
    """All arguments of a report.

    Attributes
    ----------
    listed : tuple of Proof
        In the order of the ledger.
    steps : tuple of Step
        Each once.
    """

    listed: tuple[Proof, ...]
    steps: tuple[Step, ...]

    @property
    def uses(self) -> int:
        """How many steps the arguments have together."""
        return sum(len(proof.steps) for proof in self.listed)

    @property
    def by_checker(self) -> dict[Checker, int]:
        """How many different steps were checked in which way."""
        counted = Counter(step.checker for step in self.steps)
        return {checker: counted[checker] for checker in Checker if counted[checker]}


def proofs(report: Report) -> Proofs:
    """Gather the arguments of all judged parts; steps are alike if they agree in every field."""
    anchors: dict[Step, str] = {}
    listed = tuple(
        Proof(part, argument, tuple(_used(argument, anchors)))
        for part in report.parts
        for argument in part.arguments
    )
    return Proofs(listed, tuple(anchors))


def _used(argument: Argument, anchors: dict[Step, str]) -> Iterator[Used]:
    for step in argument.steps:
        shown = step not in anchors
        if shown:
            anchors[step] = _anchor(step, anchors.values())
        yield Used(step, name_of(step), anchors[step], shown)


def name_of(step: Step) -> str:
    """What comes before the colon of its statement."""
    return step.statement.partition(":")[0]


def _anchor(step: Step, taken: Collection[str]) -> str:
    """An id made of the name; a number tells namesakes apart."""
    name = "step-" + re.sub("[^a-z0-9]+", "-", name_of(step).lower()).strip("-")
    number = 1
    while (found := name if number == 1 else f"{name}-{number}") in taken:
        number += 1
    return found
