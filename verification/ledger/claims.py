"""The ledger of claims, read from `ledger.toml`: their places, their formal parts, and how each is judged.

A part is one formal interpretation. Its role says what it means for the claim: ``stated`` is the claim as
the paper has it, ``variant`` the same for another update, or a figure that the paper gives for one scene,
``repair`` a corrected statement. The verdict of a claim is that of its stated parts. Nothing here computes.
"""

import tomllib
from dataclasses import dataclass
from enum import StrEnum
from importlib.resources import files
from typing import Any

from verification.ledger.rules import Protocol, Rule


class Role(StrEnum):
    """What a part means for its claim."""

    STATED = "stated"
    VARIANT = "variant"
    REPAIR = "repair"


class Subject(StrEnum):
    """What a claim is about."""

    FORMULATION = "the formulation"
    ALGORITHM = "the algorithm and its theorem"
    EXPERIMENTS = "the experiments"
    SOLVERS = "other solvers"
    LIBRARY = "this library"


class Voice(StrEnum):
    """Who says what a claim states."""

    PAPER = "paper"
    QUESTION = "question"
    PROMISE = "promise"


@dataclass(frozen=True)
class Cause:
    """What several refuted claims have in common.

    Attributes
    ----------
    id : str
    name, statement : str
    printed, corrected : str
        A formula or phrase as the paper has it, and as it is true.
    example : str
        Id of a counterexample that shows it.
    statements : tuple of str
        Keys of the parts that are true instead.
    """

    id: str
    name: str
    statement: str
    printed: str
    corrected: str
    example: str
    statements: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """One formal interpretation of a claim.

    Attributes
    ----------
    key : str
        The claim's id, a slash, and a name.
    role : Role
    statement : str
        Formal, in the paper's symbols, plain text.
    tolerance : str
        What counts as equal and why; empty where the judgement is exact.
    measure : str
        What `Count.worst` measures; empty where nothing is counted.
    rule : Rule or None
        What the experiments compare, where the part is about them.
    """

    key: str
    role: Role
    statement: str
    tolerance: str = ""
    measure: str = ""
    rule: Rule | None = None

    @property
    def claim(self) -> str:
        """The id of its claim."""
        return self.key.split("/")[0]


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes
    ----------
    id : str
    place : str
        Where in the paper; "ours" for what it does not speak of.
    voice : Voice
        ``paper``: it says so; ``question``: we ask whether it is so; ``promise``: this library says so.
    subject : Subject
    statement : str
        In our words.
    method : str
        How it is judged.
    parts : tuple of Part
    repaired_by : tuple of str
        Keys of parts of other claims that correct it, besides its own repairs.
    causes : tuple of str
        Ids of `CAUSES`: why it is refuted.
    """

    id: str
    place: str
    voice: Voice
    subject: Subject
    statement: str
    method: str
    parts: tuple[Part, ...]
    repaired_by: tuple[str, ...] = ()
    causes: tuple[str, ...] = ()

    @property
    def surveyed(self) -> bool:
        """Whether it is about the experiments."""
        return any(part.rule is not None for part in self.parts)


READINGS = ("printed", "absolute", "corrected", "appendix_half", "appendix_full", "smoothed")
"""The readings of the update, as `convexperc.solvers.paper.variants` names them."""
ORDERS = ("gauss_seidel", "jacobi")
"""Which w the update of u sees, as `convexperc.solvers.paper.variants` names it."""


def _claim(data: dict[str, Any]) -> Claim:
    parts = [_part(data["id"], each) for each in data.pop("part", [])]
    if "by_reading" in data:
        parts += _by_reading(data["id"], data.pop("by_reading"))
    lists = {name: tuple(data.get(name, ())) for name in ("repaired_by", "causes")}
    kinds = {"subject": Subject(data["subject"]), "voice": Voice(data["voice"])}
    return Claim(**data | kinds | lists | {"parts": tuple(parts)})


def _part(claim: str, data: dict[str, Any]) -> Part:
    name, role = data.pop("name"), Role(data.pop("role"))
    rule = Rule(**data.pop("rule")) if "rule" in data else None
    return Part(f"{claim}/{name}", role, rule=rule, **data)


def _by_reading(claim: str, data: dict[str, Any]) -> list[Part]:
    """One part for each reading in each order."""
    parts = []
    for reading in READINGS:
        for order in ORDERS:
            role = Role.STATED if (reading, order) == ("printed", "gauss_seidel") else Role.VARIANT
            statement = data["statement"].format(reading=reading, order=order_in_words(order))
            parts.append(Part(f"{claim}/{reading}/{order}", role, **data | {"statement": statement}))
    return parts


def order_in_words(order: str) -> str:
    """Gauss-Seidel or Jacobi."""
    return order.replace("_", "-").title()


_LEDGER: dict[str, Any] = tomllib.loads(
    files("verification.ledger").joinpath("ledger.toml").read_text(encoding="utf-8")
)
CLAIMS: dict[str, Claim] = {data["id"]: _claim(data) for data in _LEDGER["claim"]}
PARTS: dict[str, Part] = {part.key: part for claim in CLAIMS.values() for part in claim.parts}
CAUSES: dict[str, Cause] = {
    data["id"]: Cause(**data | {"statements": tuple(data["statements"])}) for data in _LEDGER["cause"]
}
PROTOCOL = Protocol(**_LEDGER["protocol"])
"""How the claims about the experiments are judged."""
