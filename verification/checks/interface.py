"""What a check is: a function from a problem, and a source of more numbers, to observations."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from convexperc.problem.arrays import Matrix
from convexperc.problem.problem import Problem
from verification.ledger.evidence import Outcome
from verification.problems.families import FAMILIES
from verification.problems.sources import Source

T = TypeVar("T")


EXPENSIVE = ("mixed_scales",)
"""An X that spans 1e470 takes the exact referee seconds."""
REFEREED = tuple(family for family in FAMILIES if family not in EXPENSIVE)
"""Families for checks that ask the exact referee several times."""


@dataclass(frozen=True)
class Observation:
    """What one problem says of one part.

    Attributes
    ----------
    part : str
        A key of `verification.ledger.claims.PARTS`.
    outcome : Outcome
    measure : float
        0 or more, the larger the worse; what the search drives up. What it measures is said by the part.
    detail : str
        One line that explains a failure, numbers included.
    """

    part: str
    outcome: Outcome
    measure: float = 0.0
    detail: str = ""

    @classmethod
    def of(cls, part: str, held: bool, measure: float = 0.0, detail: str = "") -> "Observation":
        """Held or failed."""
        return cls(part, Outcome.HELD if held else Outcome.FAILED, measure, detail)


@dataclass(frozen=True)
class Check:
    """A check.

    Attributes
    ----------
    name : str
    parts : tuple of str
        All parts that it may observe.
    observe : callable
        From a problem and a source to observations, each part at most once. It draws from the source
        whatever else it needs (points, permutations, pictures), raises nothing, and is deterministic.
    families : tuple of str
        The families that it is tried on.
    largest : (int, int)
        Largest n and d.
    share : float
        Problems a family, as a share of the profile's number.
    hunt : bool
        Whether a failure is shrunk: not where one problem takes long.
    refereed : bool
        Whether the exact referee sees each problem.
    product : bool
        Whether it runs code of `convexperc` beyond the `Problem` itself. Where it does not, it evaluates
        formulas of the paper exactly at drawn points: its observations are no cases of the code.
    """

    name: str
    parts: tuple[str, ...]
    observe: Callable[[Problem, Source], Iterable[Observation]]
    families: tuple[str, ...] = tuple(FAMILIES)
    largest: tuple[int, int] = (4, 8)
    share: float = 1.0
    hunt: bool = True
    refereed: bool = False
    product: bool = True


@dataclass
class Recorder:
    """A source that notes every number drawn from another, so that a case can be repeated."""

    source: Source
    drawn: list[Any] = field(default_factory=list)

    @property
    def largest(self) -> tuple[int, int]:
        """Largest n and largest d."""
        return self.source.largest

    def integer(self, low: int, high: int) -> int:
        """Draw an integer."""
        value = self.source.integer(low, high)
        self.drawn.append(value)
        return value

    def choice(self, options: Sequence[T]) -> T:
        """Draw one of `options`; its position is noted."""
        at = self.source.integer(0, len(options) - 1)
        self.drawn.append(at)
        return options[at]

    def matrix(self, rows: int, columns: int) -> Matrix:
        """Draw a matrix."""
        values = self.source.matrix(rows, columns)
        self.drawn.append([[float(x).hex() for x in row] for row in values])
        return values


@dataclass
class Player:
    """A source that repeats what a `Recorder` noted."""

    drawn: list[Any]
    largest: tuple[int, int] = (4, 8)
    at: int = 0

    def _next(self) -> Any:
        self.at += 1
        return self.drawn[self.at - 1]

    def integer(self, low: int, high: int) -> int:
        """Return the integer that was drawn here."""
        return int(self._next())

    def choice(self, options: Sequence[T]) -> T:
        """Return the option that was drawn here."""
        return options[int(self._next())]

    def matrix(self, rows: int, columns: int) -> Matrix:
        """Return the matrix that was drawn here."""
        values = [[float.fromhex(x) for x in row] for row in self._next()]
        return np.array(values, dtype=np.float64).reshape(rows, columns)
