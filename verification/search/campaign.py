"""The campaign, a profile of the search: which seeded problems, how each is treated, and its JSON file.

Schema of the file: ``schema``, ``command`` (repeats the campaign), ``made`` (see
`verification.provenance.stamp`), ``settings`` (the fields of `Campaign`), ``reasons`` (failures by reason),
and the plain data of `verification.search.tallies.Report`.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.method import Newton
from verification.problems.families import EXTREME, ORDINARY_DEGENERATE, RANDOM
from verification.search.tallies import Case, Report

SCHEMA = "convexperc/campaign/1"
SHARD = 250
"""Most problems that a worker takes at a time; what a kill can lose."""
RARER = 5
"""See `Campaign.referee`."""
SOLVERS: dict[str, Callable[[], Solver]] = {"newton": Newton, "conic": Conic}


@dataclass(frozen=True)
class Stretch:
    """A shard: consecutive problems of one family's stream. What it finds depends on the campaign alone."""

    family: str
    first: int
    count: int

    @property
    def key(self) -> str:
        """Its name in the journal."""
        return f"{self.family}|{self.first}|{self.count}"


@dataclass(frozen=True)
class Campaign:
    """Everything that the outcome depends on.

    Attributes
    ----------
    random, degenerate, extreme : int
        Problems of each group of families, dealt out evenly over these.
    seed : int
        Of every family's stream.
    solver : str
        A key of `SOLVERS`.
    escalate : bool
        Answer by ball arithmetic where the solver's answer is not certified; an enclosed optimum then is
        no failure.
    referee : int
        Of each family, every how many problems a certified answer is also compared with the exact referee;
        0 for never. Of an `EXTREME` family `RARER` times fewer: entries that span 1e300 need 900 digits.
        Every answer that is not certified is compared with it.
    clarabel : int
        Of each family, every how many problems are also posed directly in CVXPY + Clarabel; 0 for never.
    """

    random: int = 2000
    degenerate: int = 2000
    extreme: int = 0
    seed: int = 0
    solver: str = "newton"
    escalate: bool = True
    referee: int = 20
    clarabel: int = 0

    @property
    def total(self) -> int:
        """Problems in all."""
        return self.random + self.degenerate + self.extreme

    @property
    def command(self) -> str:
        """The command that repeats it."""
        told = [f"--{name} {value}" for name, value in asdict(self).items() if name != "escalate"]
        escalate = "--escalate" if self.escalate else "--no-escalate"
        return " ".join(["python -m verification campaign", *told, escalate])

    def head(self, made: dict[str, Any]) -> dict[str, Any]:
        """Everything that the outcome depends on, for the journal; `made` as in `as_json`."""
        return {"schema": SCHEMA, "settings": asdict(self)} | {key: made[key] for key in ("versions", "code")}

    def as_json(self, report: Report, made: dict[str, Any]) -> dict[str, Any]:
        """Plain data of the file; `made` is the stamp of the program that ran it."""
        settings = {"command": self.command, "made": made, "settings": asdict(self)}
        return {"schema": SCHEMA, **settings, "reasons": report.reasons, **report.as_json()}

    def plan(self) -> list[Stretch]:
        """The shards, interleaved so that an early end has seen some of everything."""
        groups = (
            (self.random, list(RANDOM)),
            (self.degenerate, list(ORDINARY_DEGENERATE)),
            (self.extreme, list(EXTREME)),
        )
        parts = []
        for total, names in groups:
            for k, name in enumerate(names):
                count = -(-(total - k) // len(names))
                for first in range(0, count, SHARD):
                    size = min(SHARD, count - first)
                    parts.append(((first + size / 2) / count, Stretch(name, first, size)))
        return [stretch for _, stretch in sorted(parts, key=lambda part: part[0])]

    def cases(self, stretch: Stretch) -> Iterator[Case]:
        """The problems of a shard."""
        for index in range(stretch.first, stretch.first + stretch.count):
            yield Case(stretch.family, self.seed, index)

    def referees(self, case: Case) -> bool:
        """Whether this problem is refereed in any event."""
        every = self.referee * (RARER if case.family in EXTREME else 1)
        return every > 0 and case.index % every == 0

    def asks_clarabel(self, case: Case) -> bool:
        """Whether this problem is also posed directly."""
        return self.clarabel > 0 and case.index % self.clarabel == 0
