"""Hunts: a fault is planted and its check looks for it; without it the same hunts must find nothing."""

import time
from collections.abc import Iterable
from dataclasses import dataclass

from verification.faults.fault import Fault
from verification.search.shards import Case, Found, Shard, explore

SEED = 0


@dataclass(frozen=True)
class Caught:
    """What became of one fault.

    Attributes
    ----------
    fault, part, check : str
        Its name, and what must name it.
    family : str
        Where it was caught; empty where it escaped.
    n, d, bits : int
        Size of the shrunk counterexample, and the bits of its numbers as fractions; 0 where it escaped.
    problems : int
        Problems looked at with the fault planted, those of shrinking included.
    detail : str
        What the check says of the counterexample; else what went wrong.
    seconds : float
    """

    fault: str
    part: str
    check: str
    family: str
    n: int
    d: int
    bits: int
    problems: int
    detail: str
    seconds: float

    @property
    def caught(self) -> bool:
        """Whether its check named it."""
        return bool(self.family)


def hunt(fault: Fault, *, shrink: bool = True) -> Caught:
    """Plant a fault, hunt in one family after the other until its part fails, and take it out again.

    Without `shrink` the first failure is enough.
    """
    began, problems, broken = time.perf_counter(), 0, ""
    with fault.planted():
        for family in fault.families:
            found = explored(fault, family, shrink=shrink)
            problems += found.problems
            case = smallest(found, fault.part)
            if case is not None:
                n, d = len(case.problem["X"]), len(case.problem["o"])
                size = n, d, case.size[1]
                return _caught(fault, family, size, problems, case.detail, began)
            broken = broken or "".join(found.broken[:1])
    return _caught(fault, "", (0, 0, 0), problems, broken or "no failure was seen", began)


def _caught(
    fault: Fault, family: str, size: tuple[int, int, int], problems: int, detail: str, began: float
) -> Caught:
    seconds = time.perf_counter() - began
    return Caught(fault.name, fault.part, fault.check.name, family, *size, problems, detail, seconds)


def explored(fault: Fault, family: str, *, shrink: bool = True) -> Found:
    """Hunt in one family, whatever is planted now, for a failure of the fault's part."""
    check = fault.check
    return explore(Shard(check.name, family, 0, fault.problems, fault.part), check, SEED, shrink=shrink)


def smallest(found: Found, part: str) -> Case | None:
    """The smallest failing case of a part, if it failed."""
    return found.tallies[part].smallest if part in found.tallies else None


def hunts(faults: Iterable[Fault]) -> dict[tuple[str, str, int, tuple[int, int]], tuple[Fault, str]]:
    """All hunts for these faults, by part, family, problems and size: without a fault none finds anything."""
    return {
        (fault.part, family, fault.problems, fault.largest): (fault, family)
        for fault in faults
        for family in fault.families
    }
