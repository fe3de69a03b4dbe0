"""The campaign about the judges of pairs: random sound pairs are to be acquitted, planted faults to be named.

Schema of the JSON file: ``schema``, ``command`` (repeats the campaign), ``made`` (see
`verification.provenance.stamp`), ``settings`` (the fields of `Settings`), and the plain data of `Outcome`.
"""

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

from verification.checks.measures import add_fields
from verification.journal import Journal
from verification.reweighted.answers import Answers, Word
from verification.reweighted.terms.judging import judge_term
from verification.reweighted.terms.measured import judge_functions
from verification.reweighted.terms.random_terms import Drawn, draw
from verification.search.tasks import run_tasks

SCHEMA = "convexperc/kernels/1"
SHARD = 500
"""Most pairs that a worker takes at a time."""

OTHER_UNITS = 10
"""Every so many pairs are made in other units as well."""


@dataclass(frozen=True)
class Settings:
    """Everything that the outcome depends on.

    Attributes
    ----------
    pairs : int
        Sound ones, judged in float64.
    seed : int
    mutants : int
        Every how many numbers a pair with a fault is judged as well; 0 for never.
    exact : int
        Every how many numbers two pairs of one known function each, sound and with a fault, are judged by
        their formulas; 0 for never. That takes about a second each, of compositions often minutes.
    """

    pairs: int = 1000
    seed: int = 0
    mutants: int = 20
    exact: int = 0

    def head(self, made: dict[str, Any]) -> dict[str, Any]:
        """Everything that the outcome depends on, for the journal; `made` as in `as_json`."""
        return {"schema": SCHEMA, "settings": asdict(self)} | {key: made[key] for key in ("versions", "code")}

    @property
    def command(self) -> str:
        """The command that repeats it."""
        told = f"--campaign {self.pairs} --seed {self.seed} --mutants {self.mutants} --exact {self.exact}"
        return f"python -m verification kernels {told}"

    def as_json(self, outcome: "Outcome", made: dict[str, Any]) -> dict[str, Any]:
        """Plain data of the file; `made` is the stamp of the program that ran it."""
        told = {"command": self.command, "made": made, "settings": asdict(self)}
        return {"schema": SCHEMA, **told, **asdict(outcome)}

    def stretches(self) -> Iterator[tuple[int, int]]:
        """The shards, as the first number and how many."""
        for first in range(0, self.pairs, SHARD):
            yield first, min(SHARD, self.pairs - first)


@dataclass
class Tally:
    """Counts of one way to judge.

    Attributes
    ----------
    sound, accused : int
        Sound pairs that were judged; those with a fault, which must be none.
    mutants, caught, named : int
        Pairs with a planted fault; those with any found; those to which the question that is meant says no.
        A floor that smooths a kink is no fault, but its answer is no.
    crashed : int
        An exception where there must be none.
    seconds : float
        Of processor time; no part of a comparison.
    """

    sound: int = 0
    accused: int = 0
    mutants: int = 0
    caught: int = 0
    named: int = 0
    crashed: int = 0
    seconds: float = field(default=0.0, compare=False)


@dataclass
class Outcome:
    """What a campaign found.

    Attributes
    ----------
    measured, exact : Tally
        By `judge_functions`, by `judge_term`.
    undecided : dict of str to int
        Sound pairs by way and question, such as ``"exact: majorises"``.
    found : list of dict
        Each sound pair that is accused, each fault that is not named, each exception.
    lost : dict of str to str
        By the name of a shard, how its worker process ended.
    """

    measured: Tally = field(default_factory=Tally)
    exact: Tally = field(default_factory=Tally)
    undecided: dict[str, int] = field(default_factory=dict)
    found: list[dict[str, Any]] = field(default_factory=list)
    lost: dict[str, str] = field(default_factory=dict)

    @property
    def clean(self) -> bool:
        """No sound pair is accused, no exception, nothing lost, and at least one pair looked at."""
        both = (self.measured, self.exact)
        wrong = sum(each.accused + each.crashed for each in both)
        return sum(each.sound for each in both) > 0 and not wrong and not self.lost

    @property
    def named(self) -> bool:
        """Every planted fault is named by the question that is meant."""
        return all(each.named == each.mutants for each in (self.measured, self.exact))

    def add(self, data: dict[str, Any]) -> None:
        """Add what another shard found, as plain data."""
        add_fields(self.measured, Tally(**data["measured"]))
        add_fields(self.exact, Tally(**data["exact"]))
        self.undecided = dict(Counter(self.undecided) + Counter(data["undecided"]))
        self.found += data["found"]


def run(
    settings: Settings,
    *,
    jobs: int = 1,
    journal: Journal | None = None,
    progress: Callable[[Outcome], None] = lambda outcome: None,
) -> Outcome:
    """Judge every pair of the campaign.

    Parameters
    ----------
    settings : Settings
    jobs : int
        Worker processes; 1 works in this one.
    journal : Journal, optional
        Keeps finished shards; those it has already are not done again.
    progress : callable
        Called with the outcome so far: of what the journal keeps, and after each shard.
    """
    outcome = Outcome()
    tasks = {
        f"{first}|{count}": partial(shard, settings, first, count) for first, count in settings.stretches()
    }

    for name, data in ({} if journal is None else journal.entries).items():
        if name in tasks:
            outcome.add(data)
    progress(outcome)

    def take(_: str, data: dict[str, Any]) -> None:
        outcome.add(data)
        progress(outcome)

    outcome.lost |= run_tasks(tasks, take, jobs=jobs, journal=journal)
    outcome.found.sort(key=lambda each: (int(each["number"]), str(each["pair"])))
    outcome.undecided = dict(sorted(outcome.undecided.items()))
    return outcome


def shard(settings: Settings, first: int, count: int) -> dict[str, Any]:
    """Judge consecutive pairs; plain data."""
    outcome = Outcome()
    for number in range(first, first + count):
        _count(draw(settings.seed, number), "measured", outcome, _by_measuring)
        if settings.mutants and number % settings.mutants == 0:
            _count(draw(settings.seed, number, mutant=True), "measured", outcome, _by_measuring)
        for mutant in (False, True) if settings.exact and number % settings.exact == 0 else ():
            _count(draw(settings.seed, number, mutant=mutant, depth=0), "exact", outcome, _by_formula)
    return asdict(outcome)


def _by_measuring(drawn: Drawn) -> Answers:
    make = drawn.make if drawn.number % OTHER_UNITS == 0 and not drawn.fault else None
    return judge_functions(*drawn.functions(), drawn.square, make=make, formula=False, name=drawn.name)


def _by_formula(drawn: Drawn) -> Answers:
    return judge_term(drawn.term())


def _count(drawn: Drawn, way: str, outcome: Outcome, judge: Callable[[Drawn], Answers]) -> None:
    """Judge one pair, and count; an exception is that of this pair alone."""
    tally: Tally = getattr(outcome, way)
    start = time.process_time()
    try:
        answers = judge(drawn)
    except Exception as error:
        tally.crashed += 1
        told = {"number": drawn.number, "pair": drawn.name, "way": way}
        outcome.found.append({**told, "wrong": f"{type(error).__name__}: {error}"})
        return
    finally:
        tally.seconds += time.process_time() - start
    wrong = _count_fault(drawn, answers, tally) if drawn.fault else _count_sound(answers, tally)
    if not drawn.fault:
        for answer in answers:
            if answer.word is Word.UNDECIDED:
                key = f"{way}: {answer.question}"
                outcome.undecided[key] = outcome.undecided.get(key, 0) + 1
    if wrong:
        outcome.found.append({"number": drawn.number, "pair": drawn.name, "way": way, "wrong": wrong})


def _count_sound(answers: Answers, tally: Tally) -> str:
    tally.sound += 1
    tally.accused += bool(answers.faults)
    return "; ".join(f"accused: {fault.statement} {dict(fault.instance)}" for fault in answers.faults)


def _count_fault(drawn: Drawn, answers: Answers, tally: Tally) -> str:
    named = answers[drawn.expected].word is Word.NO
    tally.mutants += 1
    tally.caught += named or bool(answers.faults)
    tally.named += named
    return "" if named else f"not named: {drawn.expected} says: {answers[drawn.expected].statement}"
