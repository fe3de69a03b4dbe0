"""All shards of a run, by as many workers as wanted, joined in one order whatever order they end in."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from verification.checks.interface import Check
from verification.journal import Journal
from verification.search.profiles import Profile
from verification.search.shards import Case, Found, Shard, Tally, explore
from verification.search.tasks import run_tasks

TELLING = 12
"""Problems of a family from which on most of them must not be trivial: the first is all zeros."""

HUNTED = 300
"""Most problems that a hunt draws before it gives up; it starts where a failure was seen."""


@dataclass
class Result:
    """What a run found.

    Attributes
    ----------
    tallies : dict of (part, family) to Tally
    problems : dict of (check, family) to int
        Problems looked at.
    nontrivial : dict of (check, family) to int
        Of these, the ones where nothing is 0 but what the family says.
    formulas : int
        Of all problems, those of checks that run no code of the product; see `Check.product`.
    broken : list of str
        Exceptions of checks, and shards that were lost with their workers.
    unreached : list of str
        Checks and families without a single problem, or where most problems are trivial.
    """

    tallies: dict[tuple[str, str], Tally] = field(default_factory=dict)
    problems: dict[tuple[str, str], int] = field(default_factory=dict)
    nontrivial: dict[tuple[str, str], int] = field(default_factory=dict)
    formulas: int = 0
    broken: list[str] = field(default_factory=list)
    unreached: list[str] = field(default_factory=list)

    @property
    def total(self) -> int:
        """Problems looked at."""
        return sum(self.problems.values())

    @classmethod
    def of(cls, found: Iterable[Found], checks: Sequence[Check]) -> "Result":
        """Join what shards found, hunts left aside."""
        result = cls()
        for each in found:
            shard = each.shard
            if shard.hunt:
                continue
            place = shard.check, shard.family
            result.problems[place] = result.problems.get(place, 0) + each.problems
            result.nontrivial[place] = result.nontrivial.get(place, 0) + each.nontrivial
            result.broken += each.broken
            for part, tally in each.tallies.items():
                result.tallies.setdefault((part, shard.family), Tally()).add(tally)
        pairs = [(check.name, family) for check in checks for family in check.families]
        unreached = [pair for pair in pairs if not result.problems.get(pair)]
        result.unreached = [f"{check} was not tried on {family}" for check, family in unreached]
        result.unreached += result._mostly_trivial()
        names = {check.name for check in checks if not check.product}
        result.formulas = sum(count for (name, _), count in result.problems.items() if name in names)
        return result

    def _mostly_trivial(self) -> list[str]:
        """Checks and families of which less than half of the problems are more than zeros."""
        return [
            f"{check}: {self.nontrivial[check, family]} of {count} problems of {family} are not trivial"
            for (check, family), count in self.problems.items()
            if count >= TELLING and 2 * self.nontrivial[check, family] < count
        ]

    def smallest(self) -> dict[str, tuple[str, Case]]:
        """For each part with a failure: the family and the smallest failing case."""
        best: dict[str, tuple[str, Case]] = {}
        for (part, family), tally in sorted(self.tallies.items(), key=lambda item: item[0]):
            case = tally.smallest
            if case is not None and (part not in best or case.order < best[part][1].order):
                best[part] = family, case
        return best


def plan(checks: Iterable[Check], profile: Profile) -> list[Shard]:
    """The shards that count, interleaved so that an early end has seen some of everything."""
    shards = []
    for check in checks:
        for family in check.families:
            budget = profile.budget(check, family)
            sizes = [profile.shard] * (budget // profile.shard) + [budget % profile.shard]
            shards += [Shard(check.name, family, k, size) for k, size in enumerate(sizes) if size]
    return sorted(shards, key=lambda shard: shard.index)


def search(
    checks: Sequence[Check],
    profile: Profile,
    seed: int,
    *,
    jobs: int = 1,
    journal: Journal | None = None,
    progress: Callable[[Found], None] = lambda found: None,
) -> Result:
    """Count every check on every family, then shrink the failures.

    Parameters
    ----------
    checks : sequence of Check
        With different names.
    profile : Profile
    seed : int
        Two runs of one seed find the same, however many workers there are and wherever a run was broken.
    jobs : int
        Worker processes; 1 works in this one.
    journal : Journal, optional
        Keeps finished shards; those it has already are not done again.
    progress : callable
        Called with each finished shard, those of the journal first.

    Returns
    -------
    Result
    """
    named = {check.name: check for check in checks}
    counted = _run(plan(checks, profile), named, seed, jobs, journal, progress)
    result = Result.of(counted, checks)
    hunted = _run(_hunts(result, named, profile), named, seed, jobs, journal, progress)
    for found in hunted:
        part = found.shard.hunt
        smallest = found.tallies.get(part, Tally()).smallest
        result.tallies[part, found.shard.family].add(Tally(smallest=smallest))
        result.broken += found.broken
    return result


def _run(
    shards: Sequence[Shard],
    named: Mapping[str, Check],
    seed: int,
    jobs: int,
    journal: Journal | None,
    progress: Callable[[Found], None],
) -> list[Found]:
    """What every shard found, in the order of the plan; a lost shard found nothing and is broken."""
    tasks = {shard.key: partial(_explored, shard, named[shard.check], seed) for shard in shards}
    found = dict[str, Found]()

    def take(key: str, data: dict[str, Any]) -> None:
        found[key] = Found.from_json(data)
        progress(found[key])

    for key, data in ({} if journal is None else dict(journal.entries)).items():
        if key in tasks:
            take(key, data)
    for key, ending in run_tasks(tasks, take, jobs=jobs, journal=journal).items():
        found[key] = Found(key, broken=[f"shard {key} is lost: {ending}"])
    return [found[key] for key in tasks]


def _explored(shard: Shard, check: Check, seed: int) -> dict[str, Any]:
    return explore(shard, check, seed).as_json()


def _hunts(result: Result, named: Mapping[str, Check], profile: Profile) -> list[Shard]:
    """One hunt for each part that failed and is to be shrunk, in the family of its smallest failure."""
    hunts = []
    for part, (family, _) in result.smallest().items():
        owner = next(check for check in named.values() if part in check.parts)
        if profile.hunted(part) and owner.hunt:
            hunts.append(Shard(owner.name, family, 0, HUNTED, part))
    return hunts
