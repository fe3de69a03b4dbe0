"""The search beyond the vectors: Hypothesis draws problems, and shrinks to the smallest failing request."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import count

from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from verification.checks.interface import Check, Observation
from verification.conformance.answers import Answer
from verification.conformance.doors import Door, NotAskedError
from verification.conformance.explaining import Explanation, explain
from verification.conformance.judge import Finding, Level, attainable, judge
from verification.conformance.profiles import Profile
from verification.conformance.request import Request, in_float32
from verification.conformance.vectors import Vector
from verification.ledger.evidence import Outcome
from verification.problems.families import EXTREME, FAMILIES
from verification.problems.sources import Source
from verification.search.engine import Result
from verification.search.engine import search as explore
from verification.search.profiles import Profile as Budget
from verification.search.shards import Case, problem_of
from verification.search.shards import Found as Shard

NARROW = 1e-10, 1e-14
"""Tolerances of F*, relative to F* and to ||o||^2."""

LARGEST = (4, 8)
SHARD = 200


@dataclass(frozen=True)
class Found:
    """The smallest request that was found to fail at a level.

    Attributes
    ----------
    level : Level
    failures : int
        Of the requests drawn, how many failed there.
    family : str
    detail : str
    line : str
        The request, to be pasted into a bug report.
    explained : Explanation or None
        Of the answer, where there is one.
    """

    level: Level
    failures: int
    family: str
    detail: str
    line: str
    explained: Explanation | None = None


@dataclass(frozen=True)
class Searched:
    """What a search found.

    Attributes
    ----------
    asked : int
        Requests drawn.
    undecided : int
        Levels of requests where F* was not known well enough.
    found : tuple of Found
    broken : tuple of str
        Exceptions of the kit itself: there must be none.
    """

    asked: int
    undecided: int
    found: tuple[Found, ...]
    broken: tuple[str, ...] = ()


def search(
    door: Door,
    profile: Profile,
    examples: int,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Searched:
    """Draw about `examples` requests of all families, judge the answers, shrink failures, and end the solver.

    In the profile float32 each request is rounded to float32 first; those that overflow there are not asked.
    Neither are those of which no point near the optimum is optimal once it is rounded (see `attainable`). The
    smallest failing requests are asked once more; where that does not fail again, it is told.
    """
    families = tuple(name for name in FAMILIES if name not in EXTREME)
    asking, each = _Asking(door, profile), max(1, -(-examples // len(families)))
    check = Check("conformance", tuple(Level), asking, families, largest=LARGEST)
    budget = Budget("search", problems=each, shard=SHARD, hunts=True, per_scale=0, least=1)
    done = 0

    def told(shard: Shard) -> None:
        nonlocal done
        if not shard.shard.hunt:
            done += shard.problems
            progress(done, each * len(families))

    try:
        result = explore([check], budget, seed, progress=told)
        door.close()
        found = [
            asking.found(Level(part), result, family, case)
            for part, (family, case) in sorted(result.smallest().items())
        ]
    finally:
        door.close()
    undecided = sum(tally.outcomes[Outcome.UNDECIDED] for tally in result.tallies.values())
    return Searched(result.total, undecided, tuple(found), tuple(result.broken))


def _asked(problem: Problem, profile: Profile) -> Problem | None:
    return in_float32(problem) if profile.name == "float32" else problem


class _Asking:
    """What one drawn problem says of the solver."""

    def __init__(self, door: Door, profile: Profile) -> None:
        self.door, self.profile, self.numbers = door, profile, count(1)

    def __call__(self, problem: Problem, source: Source) -> Iterable[Observation]:
        _, judged = self._answered(problem)
        for finding in judged:
            if finding.level is Level.L3:
                continue
            digits = finding.digits if finding.digits is not None else 16.0
            yield Observation(finding.level, finding.outcome, max(0.0, 16.0 - digits), finding.detail)

    def found(self, level: Level, result: Result, family: str, case: Case) -> Found:
        """The smallest failure of a level, asked once more."""
        problem = problem_of(case.problem)
        failures = sum(
            tally.outcomes[Outcome.FAILED] for (name, _), tally in result.tallies.items() if name == level
        )
        explained, judged = self._answered(problem)
        again = any((each.level, each.outcome) == (level, Outcome.FAILED) for each in judged)
        detail = case.detail if again else f"{case.detail}; it did not fail when asked again"
        line = Request("found", _asked(problem, self.profile) or problem).line
        return Found(level, failures, family, detail, line, explained if again else None)

    def _answered(self, problem: Problem) -> tuple[Explanation | None, tuple[Finding, ...]]:
        """What is answered and what that is worth; nothing where the problem is not asked."""
        asked = _asked(problem, self.profile)
        proof = (
            None
            if asked is None
            else solve(asked, relative_tolerance=NARROW[0], absolute_tolerance=NARROW[1])
        )
        if asked is None or proof is None or not math.isfinite(proof.certificate.upper):
            return None, ()
        bounds = Fraction(proof.certificate.lower), Fraction(proof.certificate.upper)
        case = Vector(Request(f"search-{next(self.numbers)}", asked), *bounds)
        if not attainable(case, proof.w, proof.u, self.profile):
            return None, ()
        try:
            reply = self.door.ask(case.request)
        except NotAskedError:
            return None, ()
        self.door.earlier()  # no failure of this request; the vectors tell such a fault
        answer, judged = reply.answer, judge(case, reply, self.profile).findings
        better = proof.w, proof.u
        explained = explain(asked, answer.w, answer.u, better) if isinstance(answer, Answer) else None
        return explained, judged
