"""What names a fault: the quick profile's problems are looked at without it and with it."""

import pickle
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from convexperc.problem.problem import Problem
from verification.checks import cost
from verification.checks.catalogue import CHECKS
from verification.checks.interface import Check, Observation, Player, Recorder
from verification.exact import referee
from verification.faults.fault import Fault, Patcher
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source
from verification.search.engine import plan
from verification.search.profiles import PROFILES
from verification.search.shards import Case, Shard, explore, plain

QUICK, SEED = PROFILES["quick"], 0
"""Profile and seed of the committed report."""
COUNTED = "operation counts"
"""Stands for the check and the family where costs are counted."""
SMALL = (2, 3)
"""Largest n and d of a counterexample: two views and two modalities show every fault."""
PLAYED = 24
"""Problems that are looked at with every fault, however soon it shows."""
TRIES = 300
"""Most problems that are drawn to find a small counterexample."""


@dataclass(frozen=True)
class Drawn:
    """One problem of the profile, and what the check drew beside it."""

    family: str
    problem: Problem
    numbers: list[Any]


@dataclass(frozen=True)
class Seen:
    """What one check says with and without a fault.

    Attributes
    ----------
    check : str
    failing : dict of str to frozenset of str
        By part, the families in which it fails with the fault and not without; never empty.
    silent : frozenset of str
        Parts that fail without the fault, as they are false as stated, and nowhere with it.
    held : frozenset of str
        Parts that hold somewhere without the fault.
    broken : tuple of str
        Exceptions that the check raised with the fault planted.
    problems : int
    """

    check: str
    failing: Mapping[str, frozenset[str]]
    silent: frozenset[str]
    held: frozenset[str]
    broken: tuple[str, ...]
    problems: int

    @property
    def parts(self) -> frozenset[str]:
        """The parts that name the fault."""
        return frozenset(self.failing) | self.silent

    def names(self, fault: Fault) -> bool:
        """Whether every part that must name the fault does."""
        return {fault.part, *fault.also} <= self.parts


def check_of(part: str) -> Check | None:
    """The check that observes a part; None for those of C1, whose costs are counted without a problem."""
    found = [check for check in CHECKS if part in check.parts]
    if found or part.startswith("C1/"):
        return found[0] if found else None
    raise KeyError(part)


def look(fault: Fault, *, enough: int | None = None) -> Seen:
    """Plant a fault, look at the problems that the report's run draws for its check, and take it out.

    Parameters
    ----------
    fault : Fault
    enough : int, optional
        Go no further once every part that must name it has failed in that many families, or in all that the
        check is tried on, and `PLAYED` problems were looked at.
    """
    check = check_of(fault.part)
    if check is None:
        true, name, problems = _counted(), COUNTED, 0
        with fault.planted():
            found, broken = _counted(), tuple[str, ...]()
    else:
        drawn, true = _drawn(check.name)
        name = check.name
        with fault.planted() as patcher, _memory(patcher):
            found, broken, problems = _played(check, drawn, true, fault, enough)
    new = {part: families - true.failed(part) for part, families in found.fails.items()}
    failing = {part: families for part, families in new.items() if families}
    ended = check is None or problems == len(drawn)
    silent = frozenset(true.fails.keys() - found.fails.keys()) if ended else frozenset[str]()
    return Seen(name, failing, silent, frozenset(true.holds), broken, problems)


def look_all(faults: Iterable[Fault], *, enough: int | None = None, jobs: int = 1) -> dict[str, Seen]:
    """Look at every fault, those of one check in one process, which draws their problems once.

    Parameters
    ----------
    faults : iterable of Fault
    enough : int, optional
        See `look`.
    jobs : int
        Worker processes; the outcome does not depend on it.

    Returns
    -------
    dict of str to Seen
        By the fault's name.
    """
    found = Parallel(n_jobs=jobs)(delayed(_looked)(group, enough) for group in by_check(faults))
    return {name: seen for each in found for name, seen in each.items()}


def by_check(faults: Iterable[Fault]) -> list[list[Fault]]:
    """The faults in groups of one check, the largest first."""
    groups: dict[str, list[Fault]] = {}
    for fault in faults:
        check = check_of(fault.part)
        groups.setdefault(COUNTED if check is None else check.name, []).append(fault)
    return sorted(groups.values(), key=len, reverse=True)


def _looked(faults: Iterable[Fault], enough: int | None) -> dict[str, Seen]:
    return {fault.name: look(fault, enough=enough) for fault in faults}


@dataclass
class Outcomes:
    """By part, the families in which it fails, and those in which it holds on some problem."""

    fails: dict[str, frozenset[str]] = field(default_factory=dict)
    holds: dict[str, frozenset[str]] = field(default_factory=dict)

    def failed(self, part: str) -> frozenset[str]:
        """Where a part fails."""
        return self.fails.get(part, frozenset())

    def note(self, found: Iterable[Observation], family: str) -> None:
        """Add what was observed on one problem."""
        for each in found:
            if each.outcome in (Outcome.FAILED, Outcome.HELD):
                places = self.fails if each.outcome is Outcome.FAILED else self.holds
                places[each.part] = places.get(each.part, frozenset()) | {family}


def _counted() -> Outcomes:
    """What the counts of operations say of the parts of C1."""
    outcomes = Outcomes()
    outcomes.note(cost.observations(cost.counts()), COUNTED)
    return outcomes


@cache
def _drawn(name: str) -> tuple[list[Drawn], Outcomes]:
    """The problems of the quick profile for one check, and what it says of them in the true code.

    Raises
    ------
    RuntimeError
        The check raised something.
    """
    check = next(each for each in CHECKS if each.name == name)
    drawn, outcomes, family = list[Drawn](), Outcomes(), ""

    def observe(problem: Problem, source: Source) -> list[Observation]:
        found = list(check.observe(problem, source))
        assert isinstance(source, Recorder)
        drawn.append(Drawn(family, problem, source.drawn))
        outcomes.note(found, family)
        return found

    with _memory(Patcher()):
        for shard in plan([check], QUICK):
            family = shard.family
            if broken := explore(shard, replace(check, observe=observe), SEED).broken:
                raise RuntimeError(broken[0])
    return drawn, outcomes


def _played(
    check: Check, drawn: list[Drawn], true: Outcomes, fault: Fault, enough: int | None
) -> tuple[Outcomes, tuple[str, ...], int]:
    """What the check says of the same problems now, what it raised, and how many it looked at."""
    outcomes, broken, must = Outcomes(), list[str](), (fault.part, *fault.also)
    least = min(enough or len(check.families), len(check.families))
    for done, each in enumerate(drawn, 1):
        try:
            with np.errstate(all="ignore"):  # some families are meant to overflow
                found = list(check.observe(each.problem, Player(each.numbers, check.largest)))
        except Exception as error:
            broken.append(f"{each.family}: {type(error).__name__}: {error}")
            continue
        outcomes.note(found, each.family)
        shown = all(len(outcomes.failed(part) - true.failed(part)) >= least for part in must)
        if enough and shown and done >= PLAYED:
            return outcomes, tuple(broken), done
    return outcomes, tuple(broken), len(drawn)


_optima: dict[object, referee.Optimum] = {}
_optimum = referee.optimum


@contextmanager
def _memory(planted: Patcher) -> Iterator[None]:
    """Let the referee solve each problem once for all faults, except for those in the exact arithmetic."""
    homes = [t.__name__ if isinstance(t, ModuleType) else t.__module__ for t, _, _ in planted.before]
    patcher = Patcher()
    if not any(home.startswith("verification.exact") for home in homes):
        patcher.setattr(referee, "optimum", _remembered)
    try:
        yield
    finally:
        patcher.undo()


def _remembered(problem: Any) -> referee.Optimum:
    """The referee's optimum of a problem, by its data."""
    key = repr(plain(problem)) if isinstance(problem, Problem) else pickle.dumps(problem)
    if key not in _optima:
        _optima[key] = _optimum(problem)
    return _optima[key]


@dataclass(frozen=True)
class Caught:
    """What became of one fault.

    Attributes
    ----------
    fault, part, check : str
        Its name, what must name it, and the check of that part.
    parts : tuple of str
        All parts that named it.
    caught : bool
        Whether every part named it that must.
    families : int
        In how many families the part fails with it and not without.
    family : str
        Where the small counterexample is; empty where there is none, as where a failure that the true code
        shows is shown no longer.
    n, d, bits : int
        Size of the small counterexample, and the bits of its numbers as fractions; 0 where there is none.
    problems : int
        Problems looked at with the fault planted, those of shrinking included.
    detail : str
        What the check says of the counterexample; else what went wrong.
    seconds : float
    """

    fault: str
    part: str
    check: str
    parts: tuple[str, ...]
    caught: bool
    families: int
    family: str
    n: int
    d: int
    bits: int
    problems: int
    detail: str
    seconds: float


def hunt_all(faults: Iterable[Fault], *, jobs: int = 1) -> Iterator[list[Caught]]:
    """Hunt every fault, those of one check in one process, and give what was found as the groups end."""
    groups = by_check(faults)
    yield from Parallel(n_jobs=jobs, return_as="generator_unordered")(
        delayed(_hunted)(each) for each in groups
    )


def _hunted(faults: Iterable[Fault]) -> list[Caught]:
    return [hunt(fault) for fault in faults]


def hunt(fault: Fault) -> Caught:
    """Look at the problems of the quick profile, then shrink a problem that shows the fault."""
    began, seen = time.perf_counter(), look(fault)
    families = seen.failing.get(fault.part, frozenset())
    family, case, problems = _smallest(fault, sorted(families))
    size = (len(case.problem["X"]), len(case.problem["o"]), case.size[1]) if case else (0, 0, 0)
    if case is not None:
        detail = case.detail
    elif families:
        detail = "fails where it held"
    elif fault.part in seen.silent:
        detail = "a failure that the true code shows is shown no longer"
    else:
        detail = "".join(seen.broken[:1]) or "no failure was seen"
    return Caught(
        fault.name, fault.part, seen.check, tuple(sorted(seen.parts)), seen.names(fault), len(families),
        family, *size, seen.problems + problems, detail, time.perf_counter() - began,
    )  # fmt: skip


def _smallest(fault: Fault, families: list[str]) -> tuple[str, Case | None, int]:
    """A small counterexample, its family, and how many problems were drawn for it."""
    check, problems = check_of(fault.part), 0
    if check is None:
        return "", None, 0
    small = replace(check, largest=SMALL)
    for family in sorted(families, key=check.families.index):
        with fault.planted():
            found = explore(Shard(check.name, family, 0, TRIES, fault.part), small, SEED)
        problems += found.problems
        case = found.tallies[fault.part].smallest if fault.part in found.tallies else None
        if case is not None:
            return family, case, problems
    return "", None, problems
