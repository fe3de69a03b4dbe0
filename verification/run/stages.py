"""One run of the verifier: search, arguments, counterexamples and series become the evidence."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from convexperc.errors import ConvexpercError
from verification.checks import clarabel, cost
from verification.checks.catalogue import CHECKS, FORMULAS
from verification.checks.interface import Check, Observation
from verification.counterexamples.files import catalogue
from verification.counterexamples.found import case_record
from verification.counterexamples.kinds import confirm, refutation
from verification.counterexamples.record import Record, parse
from verification.journal import Journal
from verification.ledger.claims import PARTS
from verification.ledger.evidence import Count, Evidence, Outcome
from verification.proofs.arguments import all_arguments, other_steps
from verification.provenance import PROVING, code_digest, installed, machine, stamp, versions
from verification.run import series
from verification.search.engine import Result, plan, search
from verification.search.profiles import Profile
from verification.search.shards import Found, problem_of

Progress = Callable[[str, int, int], None]
"""Called with a stage, how much of it is done, and how much there is."""

CATALOGUE = "catalogue"
"""Origin of the counterexamples that come with the verifier."""

COUNTED = "operation counts"
"""Stands for the family where costs are counted."""


@dataclass(frozen=True)
class Options:
    """All that the outcome of a run depends on, and how many workers it may have.

    Attributes
    ----------
    profile : Profile
    seed : int
    jobs : int
        The outcome does not depend on it.
    claims : tuple of str
        Ids; empty for all.
    """

    profile: Profile
    seed: int = 0
    jobs: int = 1
    claims: tuple[str, ...] = ()

    def wants(self, part: str) -> bool:
        """Whether this part is judged."""
        return not self.claims or PARTS[part].claim in self.claims

    @property
    def checks(self) -> tuple[Check, ...]:
        """The checks that observe a part that is judged."""
        return tuple(check for check in CHECKS if any(map(self.wants, check.parts)))


@dataclass
class Run:
    """What a run found.

    Attributes
    ----------
    evidence : Evidence
    records : dict of str to Record
        Counterexamples by id: of the catalogue, and the smallest that the search found.
    interrupted : bool
        The search was not finished; the journal keeps what it found.
    """

    evidence: Evidence = field(default_factory=Evidence)
    records: dict[str, Record] = field(default_factory=dict)
    interrupted: bool = False

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "evidence": self.evidence.as_json(),
            "records": [record.as_json() for record in self.records.values()],
            "interrupted": self.interrupted,
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Run":
        """Read back what `as_json` wrote."""
        records = [parse(each, "evidence") for each in data["records"]]
        return cls(
            Evidence.from_json(data["evidence"]), {each.id: each for each in records}, data["interrupted"]
        )


def gather(options: Options, journal: Path, progress: Progress = lambda stage, done, total: None) -> Run:
    """Find everything that a judgement needs, and judge nothing.

    Parameters
    ----------
    options : Options
    journal : Path
        Where finished shards are kept; an unfinished journal of the same options and versions is continued.
    progress : callable

    Returns
    -------
    Run
        With ``interrupted`` set if Ctrl-C ended it: the counts are then those of the shards so far, and the
        journal is left open, so that a run of the same options does not do them again.

    Raises
    ------
    OSError
        The journal cannot be written.
    """
    settings = _settings(options)
    book = Journal(journal, settings | {"source": code_digest()})
    try:
        run = _gathered(options, settings, book, progress)
    except KeyboardInterrupt:
        return _broken_off(options, settings, book)
    book.finish()
    return run


def _gathered(options: Options, settings: dict[str, Any], book: Journal, progress: Progress) -> Run:
    run, times = Run(Evidence(settings)), dict[str, float]()
    evidence = run.evidence
    with _timed(times, "search"):
        result = _search(options, book, progress)
    evidence.counts = list(_counts(result, options))
    evidence.missing += [*result.unreached, *result.broken]
    with _timed(times, "arguments"):
        evidence.arguments = [each for each in all_arguments() if options.wants(each.part)]
        evidence.missing += [f"not accepted: {step.statement}" for step in other_steps() if not step.passed]
    with _timed(times, "counterexamples"):
        known = [record for record in catalogue() if options.wants(record.part)]
        known += _found(result, options, evidence.missing)
        _confirm(sorted(known, key=_smallest_first), run, progress)
    with _timed(times, "series"):
        _series(options, result, run, progress)
    made = {
        key: value for key, value in stamp("report").items() if key != "versions"
    }  # the settings have them
    found = {"made": made, "machine": machine(), "seconds": times, "jobs": options.jobs}
    evidence.volatile = found | evidence.volatile
    return run


def _broken_off(options: Options, settings: dict[str, Any], book: Journal) -> Run:
    """What the journal has, counted and not judged."""
    result = Result.of(map(Found.from_json, book.entries.values()), options.checks)
    total = sum(shard.problems for shard in plan(options.checks, options.profile))
    missing = [f"interrupted after {result.total:,} of {total:,} problems"]
    return Run(Evidence(settings, list(_counts(result, options)), missing=missing), interrupted=True)


def _settings(options: Options) -> dict[str, Any]:
    return {
        "profile": options.profile.name,
        "problems of each family": options.profile.problems,
        "seed": options.seed,
        "claims": list(options.claims),
        "versions": versions() | {name: installed(name) for name in PROVING},
    }


def _search(options: Options, book: Journal, progress: Progress) -> Result:
    """Search with a journal."""
    checks = options.checks
    total = sum(shard.problems for shard in plan(checks, options.profile))
    done = 0

    def count(found: Found) -> None:
        nonlocal done
        done += 0 if found.shard.hunt else found.problems
        progress("search", done, total)

    return search(checks, options.profile, options.seed, jobs=options.jobs, journal=book, progress=count)


def _counts(result: Result, options: Options) -> Iterator[Count]:
    for (part, family), tally in sorted(result.tallies.items(), key=lambda item: item[0]):
        if options.wants(part):
            yield Count(part, family, **tally.outcomes, worst=tally.worst, formula=part in FORMULAS)


def _found(result: Result, options: Options, missing: list[str]) -> Iterator[Record]:
    """The smallest failing case of each part as a record, confirmed once more."""
    for part, (family, case) in result.smallest().items():
        if not options.wants(part):
            continue
        check = next(check for check in options.checks if part in check.parts)
        name = "found-" + part.lower().replace("/", "-").replace("_", "-")
        origin = f"search: profile {options.profile.name}, seed {options.seed}, family {family}"
        problem = problem_of(case.problem)
        try:
            yield case_record(name, part, problem, check, case.drawn, check.largest, origin)
        except ConvexpercError as fault:
            missing.append(f"{part}: a failure on {family} is not confirmed: {fault}")


def _smallest_first(record: Record) -> tuple[bool, int, str]:
    """Those of the catalogue before those that the search met, which say less; each in order of size."""
    return record.origin != CATALOGUE, record.size.number, record.id


def _confirm(records: Sequence[Record], run: Run, progress: Progress) -> None:
    """Confirm every record once more, exactly; a record that no longer fails is stale.

    A failing case of a part that is proved says that the code does not do what was proved: its record is kept
    to be replayed, but it refutes nothing.
    """
    checks = {check.name: check for check in CHECKS}
    proved = {argument.part for argument in run.evidence.arguments if argument.passed}
    for done, record in enumerate(records, 1):
        run.records[record.id] = record
        if record.kind != "case" or record.part not in proved:
            run.evidence.refutations.append(refutation(record, confirm(record, checks)))
        progress("counterexamples", done, len(records))


def _series(options: Options, result: Result, run: Run, progress: Progress) -> None:
    """The numbers of the plots; costs are counted, and also timed, which may vary."""
    evidence, wants = run.evidence, options.wants
    evidence.series["coverage"] = series.coverage(result)
    evidence.series["problems"] = {
        "of the code": result.total - result.formulas,
        "of formulas alone": result.formulas,
    }
    if wants("T1a/printed/gauss_seidel"):
        evidence.series["counterexample"] = series.counterexample()
    if wants("T1b/printed/gauss_seidel"):
        evidence.series["distance"] = series.distances(result)
    if wants("T1c/rate"):
        evidence.series["rate"] = series.rate()
    progress("series", 1, 3)
    if wants("C1/step6"):
        growths = cost.counts()
        evidence.series["cost"] = {name: growth.as_json() for name, growth in growths.items()}
        evidence.counts += [_counted(each) for each in cost.observations(growths)]
        evidence.volatile["times"] = cost.times()
    progress("series", 2, 3)
    if wants("S1/optimal"):
        evidence.series["clarabel"] = clarabel.by_scale(options.profile.per_scale, seed=options.seed)
    progress("series", 3, 3)


def _counted(each: Observation) -> Count:
    held = each.outcome is Outcome.HELD
    return Count(each.part, COUNTED, held=int(held), failed=int(not held), worst=each.measure)


@contextmanager
def _timed(times: dict[str, float], stage: str) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        times[stage] = round(time.perf_counter() - start, 3)
