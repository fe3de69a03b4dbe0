"""One shard: Hypothesis draws problems of one family for one check, and what they say is counted.

A shard depends on its own name and on the seed alone, so that shards may run anywhere, in any order.
"""

import hashlib
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, Verbosity, given, seed, settings, strategies, target
from hypothesis.errors import Flaky, FlakyFailure, HypothesisException

from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation, Recorder
from verification.ledger.evidence import Outcome
from verification.problems.families import FAMILIES, is_trivial
from verification.problems.strategies import Drawn

LARGEST_TARGET = 1e300
"""Hypothesis drives up finite numbers only."""

UNBOUNDED = 10**9
"""Decade of a measure that is not finite."""


class _FalsifiedError(Exception):
    """A hunt found its failure."""


@dataclass(frozen=True)
class Shard:
    """What a worker does at a time.

    Attributes
    ----------
    check, family : str
    index : int
        Of the shards of this check and family.
    problems : int
        Problems to draw, or the most to try in a hunt.
    hunt : str
        The part whose failure is looked for and shrunk; empty to count all parts.
    """

    check: str
    family: str
    index: int
    problems: int
    hunt: str = ""

    @property
    def key(self) -> str:
        """Its name in the journal."""
        return f"{self.check}|{self.family}|{self.index}|{self.problems}|{self.hunt}"

    @classmethod
    def named(cls, key: str) -> "Shard":
        """The shard of that name."""
        check, family, index, problems, hunt = key.split("|")
        return cls(check, family, int(index), int(problems), hunt)


@dataclass(frozen=True)
class Case:
    """One failing case, as small as it was found.

    Attributes
    ----------
    size : (int, int)
        n d, and the bits of all numbers.
    problem : dict
        X, o, sizes and lambdas, floats as hex.
    drawn : list
        What the check drew, for `verification.checks.interface.Player`.
    measure : float
    detail : str
    """

    size: tuple[int, int]
    problem: dict[str, Any]
    drawn: list[Any]
    measure: float
    detail: str

    @property
    def order(self) -> tuple[tuple[int, int], str]:
        """Smallest first; ties broken by the numbers, so that the smallest of several shards is one."""
        return self.size, repr((self.problem, self.drawn))

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Case":
        """Read back what `Found.as_json` wrote."""
        n_d, bits = data["size"]
        return cls(**data | {"size": (n_d, bits), "measure": float.fromhex(data["measure"])})


@dataclass
class Tally:
    """Counts of one part, its measures by decade, the largest finite one, and the smallest failing case."""

    outcomes: dict[str, int] = field(default_factory=lambda: {outcome.value: 0 for outcome in Outcome})
    worst: float = 0.0
    decades: dict[int, int] = field(default_factory=dict)
    smallest: Case | None = None

    def add(self, other: "Tally") -> None:
        """Add what another shard found on the same part."""
        for name, count in other.outcomes.items():
            self.outcomes[name] += count
        for decade, count in other.decades.items():
            self.decades[decade] = self.decades.get(decade, 0) + count
        self.worst = max(self.worst, other.worst)
        known = [each for each in (self.smallest, other.smallest) if each is not None]
        self.smallest = min(known, key=lambda case: case.order, default=None)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Tally":
        """Read back what `Found.as_json` wrote."""
        smallest = None if data["smallest"] is None else Case.from_json(data["smallest"])
        decades = {int(decade): count for decade, count in data["decades"].items()}
        return cls(dict(data["outcomes"]), data["worst"], decades, smallest)


@dataclass
class Found:
    """What a shard found.

    Attributes
    ----------
    key : str
    problems : int
        Drawn and looked at.
    nontrivial : int
        Of these, the ones where nothing is 0 but what the family says: see `families.is_trivial`.
    tallies : dict of str to Tally
        By part.
    broken : list of str
        Exceptions of the check: there must be none.
    """

    key: str
    problems: int = 0
    nontrivial: int = 0
    tallies: dict[str, Tally] = field(default_factory=dict)
    broken: list[str] = field(default_factory=list)

    @property
    def shard(self) -> Shard:
        """The shard that found it."""
        return Shard.named(self.key)

    def as_json(self) -> dict[str, Any]:
        """Plain data; a measure as a hex float, since it may be infinite."""
        data = asdict(self)
        for tally in data["tallies"].values():
            if tally["smallest"] is not None:
                tally["smallest"]["measure"] = float(tally["smallest"]["measure"]).hex()
        return data

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Found":
        """Read back what `as_json` wrote."""
        tallies = {part: Tally.from_json(tally) for part, tally in data["tallies"].items()}
        return cls(data["key"], data["problems"], data["nontrivial"], tallies, list(data["broken"]))


def explore(shard: Shard, check: Check, campaign: int, *, shrink: bool = True) -> Found:
    """Draw the problems of one shard and count what `check` observes on them.

    Parameters
    ----------
    shard : Shard
    check : Check
        The one that the shard names.
    campaign : int
        Seed of the campaign.
    shrink : bool
        Whether a hunt goes on from its first failure to a smaller one.
    """
    found = Found(shard.key)
    phases = [Phase.generate, *([Phase.shrink] * shrink if shard.hunt else [Phase.target])]

    @seed(_number(campaign, shard))
    @settings(
        max_examples=shard.problems,
        database=None,
        deadline=None,
        derandomize=False,
        report_multiple_bugs=False,
        print_blob=False,
        verbosity=Verbosity.quiet,
        suppress_health_check=list(HealthCheck),
        phases=phases,
    )
    @given(strategies.data())
    def look(data: Any) -> None:
        drawn = Drawn(data.draw, check.largest)
        problem = FAMILIES[shard.family](drawn).problem()
        recorder = Recorder(drawn)
        observations = _observations(check, problem, recorder, found)
        found.problems += 1
        found.nontrivial += not is_trivial(problem, shard.family)
        for each in observations:
            _count(found, each, problem, recorder.drawn)
            if shard.hunt == each.part and each.outcome is Outcome.FAILED:
                raise _FalsifiedError(each.detail)
            if not shard.hunt and each.measure > 0.0:
                target(min(each.measure, LARGEST_TARGET), label=each.part)

    _quietly(look, shard)
    return found


def _number(campaign: int, shard: Shard) -> int:
    """The seed of one shard, from its name."""
    return int.from_bytes(hashlib.sha256(f"{campaign}|{shard.key}".encode()).digest()[:8])


def _quietly(look: Callable[[], None], shard: Shard) -> None:
    """Run it; a hunt ends with the failure that it looked for."""
    try:
        look()
    except (_FalsifiedError, Flaky, FlakyFailure):
        if not shard.hunt:
            raise


def _observations(check: Check, problem: Problem, recorder: Recorder, found: Found) -> list[Observation]:
    """All observations; an exception of the check is noted, not those by which Hypothesis steers."""
    try:
        with np.errstate(all="ignore"):  # some families are meant to overflow
            return list(check.observe(problem, recorder))
    except HypothesisException:
        raise
    except Exception as error:
        found.broken.append(f"{check.name} on {found.key}: {type(error).__name__}: {error}")
        return []


def _count(found: Found, each: Observation, problem: Problem, drawn: list[Any]) -> None:
    tally = found.tallies.setdefault(each.part, Tally())
    tally.outcomes[each.outcome.value] += 1
    if each.outcome in (Outcome.HELD, Outcome.FAILED):
        decade = _decade(each.measure)
        tally.decades[decade] = tally.decades.get(decade, 0) + 1
        tally.worst = max(tally.worst, each.measure if math.isfinite(each.measure) else 0.0)
    if each.outcome is Outcome.FAILED:
        case = Case(size_of(problem), plain(problem), list(drawn), each.measure, each.detail)
        if tally.smallest is None or case.order < tally.smallest.order:
            tally.smallest = case


def _decade(measure: float) -> int:
    """The k of 10^(k-1) < measure <= 10^k; -400 for 0 and below."""
    if not math.isfinite(measure):
        return UNBOUNDED
    return math.ceil(math.log10(measure)) if measure > 0.0 else -400


def size_of(problem: Problem) -> tuple[int, int]:
    """How large a problem is: n d, and the bits of its numbers as fractions."""
    numbers = np.concatenate([problem.X.ravel(), problem.o, np.array(problem.lambdas)])
    bits = sum(sum(part.bit_length() for part in float(x).as_integer_ratio()) for x in numbers)
    return problem.n * problem.d, bits


def plain(problem: Problem) -> dict[str, Any]:
    """The data of a problem for JSON, floats as hex."""
    return {
        "X": [[float(x).hex() for x in row] for row in problem.X],
        "o": [float(x).hex() for x in problem.o],
        "sizes": list(problem.modalities.sizes),
        "lambdas": [float(x).hex() for x in problem.lambdas],
    }


def problem_of(data: dict[str, Any]) -> Problem:
    """Read back what `plain` wrote."""
    one, two, three = (float.fromhex(x) for x in data["lambdas"])
    X = np.array([[float.fromhex(x) for x in row] for row in data["X"]])
    o = np.array([float.fromhex(x) for x in data["o"]])
    return Problem(X, o, modalities=list(data["sizes"]), lambda1=one, lambda2=two, lambda3=three)
