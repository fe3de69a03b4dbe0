"""The campaign: every problem of a stretch is drawn and its answer certified; some are refereed.

Schema of the JSON file: ``schema``, ``command`` (repeats the campaign), ``made`` (see
`verification.provenance.stamp`), ``settings`` (the fields of `Settings`), and the plain data of `Outcome`.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

from scipy.sparse import csr_array

from convexperc.lasso import LassoCertificate, certify_lasso
from verification.checks.measures import add_fields
from verification.journal import Journal
from verification.lassos.problems import Drawn, draw
from verification.lassos.referee import optimum, violations
from verification.search.tasks import run_tasks

SCHEMA = "convexperc/lassos/1"
SHARD = 1000
"""Most problems that a worker takes at a time; what a kill can lose."""


@dataclass(frozen=True)
class Settings:
    """Everything that the outcome depends on.

    Attributes
    ----------
    problems : int
    seed : int
    referee : int
        Every how many problems the certificate is compared with the exact optimum; 0 for never.
    """

    problems: int = 20_000
    seed: int = 0
    referee: int = 20

    @property
    def command(self) -> str:
        """The command that repeats it."""
        told = (f"--{name} {value}" for name, value in asdict(self).items())
        return " ".join(["python -m verification lassos", *told])

    def head(self, made: dict[str, Any]) -> dict[str, Any]:
        """Everything that the outcome depends on, for the journal; `made` as in `as_json`."""
        return {"schema": SCHEMA, "settings": asdict(self)} | {key: made[key] for key in ("versions", "code")}

    def as_json(self, outcome: "Outcome", made: dict[str, Any]) -> dict[str, Any]:
        """Plain data of the file; `made` is the stamp of the program that ran it."""
        told = {"command": self.command, "made": made, "settings": asdict(self)}
        return {"schema": SCHEMA, **told, **asdict(outcome)}

    def stretches(self) -> Iterator[tuple[int, int]]:
        """The shards, as the first number and how many."""
        for first in range(0, self.problems, SHARD):
            yield first, min(SHARD, self.problems - first)


@dataclass
class Tally:
    """Counts of one convention.

    Attributes
    ----------
    total, certified : int
        Problems; those whose answer is within the usual tolerances, by proof.
    bounded : int
        Those with a lower bound above 0.
    zeros : int
        Columns that are proved not to be used.
    refereed, loose : int
        Compared with the exact optimum; those of them where that is not narrow, so that zeros are not judged.
    wrong : int
        Certificates that say something false, or contradict themselves.
    crashed : int
        An exception where there must be none.
    seconds : float
        Spent on drawing, certifying and refereeing, of processor time; no part of a comparison.
    """

    total: int = 0
    certified: int = 0
    bounded: int = 0
    zeros: int = 0
    refereed: int = 0
    loose: int = 0
    wrong: int = 0
    crashed: int = 0
    seconds: float = field(default=0.0, compare=False)


@dataclass
class Outcome:
    """What a campaign found.

    Attributes
    ----------
    conventions : dict of str to Tally
    found : list of dict
        Each problem with a false statement or an exception: its number, kind, and what is wrong.
    lost : dict of str to str
        By the name of a shard, how its worker process ended.
    """

    conventions: dict[str, Tally] = field(default_factory=dict)
    found: list[dict[str, Any]] = field(default_factory=list)
    lost: dict[str, str] = field(default_factory=dict)

    @property
    def total(self) -> Tally:
        """The counts of all conventions together."""
        every = Tally()
        for tally in self.conventions.values():
            add_fields(every, tally)
        return every

    @property
    def clean(self) -> bool:
        """Nothing false, no exception, nothing lost, and at least one problem looked at."""
        return self.total.total > 0 and not (self.found or self.lost)

    def add(self, data: dict[str, Any]) -> None:
        """Add what another shard found, as plain data."""
        for name, counts in data["conventions"].items():
            add_fields(self.conventions.setdefault(name, Tally()), Tally(**counts))
        self.found += data["found"]

    def ordered(self) -> "Outcome":
        """The same by name and number, in whatever order the shards ended."""
        return Outcome(
            dict(sorted(self.conventions.items())),
            sorted(self.found, key=lambda each: int(each["number"])),
            dict(sorted(self.lost.items())),
        )


def run(
    settings: Settings,
    *,
    jobs: int = 1,
    journal: Journal | None = None,
    progress: Callable[[Outcome], None] = lambda outcome: None,
) -> Outcome:
    """Judge every problem of the campaign.

    Parameters
    ----------
    settings : Settings
    jobs : int
        Worker processes; 1 works in this one.
    journal : Journal, optional
        Keeps finished shards; those it has already are not done again.
    progress : callable
        Called with the outcome so far: of what the journal keeps, and after each shard.

    Returns
    -------
    Outcome
    """
    outcome = Outcome()
    tasks = {
        f"{first}|{count}": partial(shard, settings, first, count) for first, count in settings.stretches()
    }
    for name, data in ({} if journal is None else journal.entries).items():
        if name in tasks:
            outcome.add(data)
    progress(outcome)

    def take(name: str, data: dict[str, Any]) -> None:
        outcome.add(data)
        progress(outcome)

    outcome.lost |= run_tasks(tasks, take, jobs=jobs, journal=journal)
    return outcome.ordered()


def shard(settings: Settings, first: int, count: int) -> dict[str, Any]:
    """Judge consecutive problems; plain data."""
    outcome = Outcome()
    for number in range(first, first + count):
        start = time.process_time()
        drawn = draw(settings.seed, number)
        tally = outcome.conventions.setdefault(drawn.options["convention"], Tally())
        tally.total += 1
        wrong = _judge(drawn, tally, refereed=bool(settings.referee) and number % settings.referee == 0)
        if wrong:
            outcome.found.append({"number": number, "kind": drawn.kind, "wrong": wrong})
        tally.seconds += time.process_time() - start
    return asdict(outcome)


def _judge(drawn: Drawn, tally: Tally, *, refereed: bool) -> list[str]:
    """What is wrong with the certificate of a problem; an exception is that of this problem alone."""
    try:
        X = csr_array(drawn.X) if drawn.sparse else drawn.X
        found = certify_lasso(X, drawn.y, drawn.coef, drawn.alpha, **drawn.options)
        wrong = contradictions(found)
        if refereed:
            truth = optimum(drawn.exact)
            tally.refereed += 1
            tally.loose += not truth.tight
            wrong += violations(drawn, found, truth)
    except Exception as error:
        tally.crashed += 1
        return [f"{type(error).__name__}: {error}"]
    tally.certified += found.certified
    tally.bounded += found.lower > 0.0
    tally.zeros += int(found.zero_features.sum())
    tally.wrong += bool(wrong)
    return wrong


def contradictions(found: LassoCertificate) -> list[str]:
    """What a certificate says against itself."""
    numbers = (
        found.lower,
        found.upper,
        *found.objective,
        found.gap,
        found.relative_gap,
        found.share_of_target,
    )
    wrong = {
        "a number is NaN or negative": all(each >= 0.0 for each in numbers),
        "lower > upper": found.lower <= found.upper < math.inf,
        "objective, lower > upper": found.objective[0] <= found.objective[1],
        "upper > objective": found.upper <= found.objective[1],
        "certified with a wide interval": not found.certified or found.gap < math.inf,
    }
    return [statement for statement, holds in wrong.items() if not holds]
