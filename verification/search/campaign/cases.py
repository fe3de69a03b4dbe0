"""Which problems a campaign looks at: a case is (family, seed, index) and is repeated from these alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

from convexperc.problem.problem import Problem
from verification.problems.families import EXTREME, ORDINARY_DEGENERATE, RANDOM, seeded


@dataclass(frozen=True)
class Case:
    """One problem by name."""

    family: str
    seed: int
    index: int

    def problem(self) -> Problem:
        """Draw it."""
        return seeded(self.family, self.seed, self.index)


@dataclass(frozen=True)
class Plan(Sequence[Case]):
    """Problems of each group, dealt out evenly over its families; made when they are asked for.

    Attributes
    ----------
    random, degenerate, extreme : int
        Problems of each group.
    seed : int
    """

    random: int
    degenerate: int
    extreme: int
    seed: int

    def __len__(self) -> int:
        return self.random + self.degenerate + self.extreme

    @overload
    def __getitem__(self, at: int) -> Case: ...

    @overload
    def __getitem__(self, at: slice) -> list[Case]: ...

    def __getitem__(self, at: int | slice) -> Case | list[Case]:
        if isinstance(at, slice):
            return [self._case(k) for k in range(*at.indices(len(self)))]
        return self._case(range(len(self))[at])

    def _case(self, k: int) -> Case:
        for count, group in self._groups():
            if k < count:
                return Case(group[k % len(group)], self.seed, k // len(group))
            k -= count
        raise IndexError(k)

    def _groups(self) -> tuple[tuple[int, list[str]], ...]:
        return (
            (self.random, list(RANDOM)),
            (self.degenerate, list(ORDINARY_DEGENERATE)),
            (self.extreme, list(EXTREME)),
        )


def cases(random: int, degenerate: int, seed: int, *, extreme: int = 0) -> list[Case]:
    """The cases of a `Plan`."""
    return list(Plan(random, degenerate, extreme, seed))
