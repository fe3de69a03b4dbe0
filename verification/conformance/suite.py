"""One run of the kit: every vector asked through a door, judged, and counted."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from fractions import Fraction
from pathlib import Path

from convexperc.errors import FileFormatError, InputError
from convexperc.files import given_path
from verification.conformance.doors import Door, Reply
from verification.conformance.judge import Finding, Level, judge, judge_malformed, judge_set
from verification.conformance.profiles import FLOAT64, Profile
from verification.conformance.vectors import FLAGS, Malformed, RecognitionSet, Vector, Vectors, all_vectors
from verification.ledger.evidence import Outcome

Known = Mapping[tuple[str, Level], str]
"""Failures that are known, with why: by id and level."""

PROTOCOL = "protocol"
"""The id of what belongs to no request, such as text after the last answer."""

COUNTED = ("held", "failed", "known", "undecided", "skipped")
SMALLEST = 3
"""Failures of each level that a report shows with their requests, smallest first."""


@dataclass(frozen=True)
class Selection:
    """Which vectors are asked.

    Attributes
    ----------
    profile : Profile
    only : str
        A pattern such as ``zero-*`` that an id must match, or a flag; empty for all but those with the flag
        "extreme".
    """

    profile: Profile = FLOAT64
    only: str = ""

    def takes(self, id: str, flags: Iterable[str] = ()) -> bool:  # noqa: A002
        """Whether this vector is asked."""
        own = set(flags)
        if "extreme" in own and not self.only:
            return False
        if "float64" in own and self.profile.name == "float32":
            return False
        return not self.only or self.only in own or fnmatchcase(id, self.only)


@dataclass(frozen=True)
class Report:
    """What a run found.

    Attributes
    ----------
    solver : str
        The door's name.
    version : str
        Of the vectors.
    selection : Selection
    findings : tuple of Finding
        One for each level of each request that was asked, in order.
    known : mapping
        Of the findings that failed, those that were known to.
    stale : tuple of str
        Known failures that did not fail.
    requests : mapping of str to str
        The line of every request that has a finding.
    sizes : mapping of str to int
        n d of each problem.
    seconds : tuple of float
        Of each answer.
    """

    solver: str
    version: str
    selection: Selection
    findings: tuple[Finding, ...]
    known: Known = field(default_factory=dict)
    stale: tuple[str, ...] = ()
    requests: Mapping[str, str] = field(default_factory=dict)
    sizes: Mapping[str, int] = field(default_factory=dict)
    seconds: tuple[float, ...] = ()

    def counts(self, level: Level) -> Counter[str]:
        """How many requests held, failed, failed as known, stayed undecided or were skipped at a level."""
        return Counter(self._word(each) for each in self.findings if each.level == level)

    def _word(self, finding: Finding) -> str:
        known = finding.outcome is Outcome.FAILED and (finding.id, finding.level) in self.known
        return "known" if known else finding.outcome.value

    @property
    def failed(self) -> tuple[Finding, ...]:
        """What failed, known or not; the smallest problems first."""
        found = [each for each in self.findings if each.outcome is Outcome.FAILED]
        return tuple(sorted(found, key=lambda each: (each.level, self.sizes.get(each.id, 0), each.id)))

    @property
    def unexpected(self) -> tuple[Finding, ...]:
        """What failed and was not known to."""
        return tuple(each for each in self.failed if (each.id, each.level) not in self.known)

    @property
    def open(self) -> tuple[Finding, ...]:
        """What is no pass, but no failure either: undecided, or the solver said it is not for it."""
        return tuple(
            each
            for each in self.findings
            if each.outcome is Outcome.UNDECIDED
            or (each.outcome is Outcome.SKIPPED and each.level is Level.L0)
        )

    @property
    def reached(self) -> Level | None:
        """The highest level up to which nothing failed, known or not, and something held."""
        best = None
        for level in Level:
            counts = self.counts(level)
            if counts["failed"] or counts["known"] or counts["undecided"]:
                break
            if counts["held"]:
                best = level
        return best

    @property
    def digits(self) -> tuple[float, ...]:
        """Digits to which F(w, u) agrees with F*; see `Finding`."""
        return tuple(each.digits for each in self.findings if each.digits is not None)

    @property
    def statement(self) -> str:
        """What may be said of the solver, in one sentence."""
        asked = len({each.id for each in self.findings if each.level is Level.L0})
        skipped = sum(each.outcome is Outcome.SKIPPED for each in self.findings if each.level is Level.L0)
        reached = f"reaches {self.reached}" if self.reached else "reaches no level"
        left = f", of which it declined {skipped}" if skipped else ""
        only = f" (those that match {self.selection.only})" if self.selection.only else ""
        count = sum(each.outcome is Outcome.FAILED for each in self.findings)
        failures = f"{count} failures" if count != 1 else "1 failure"
        profile = self.selection.profile.name
        return (
            f"{self.solver} {reached} of the convexperc conformance vectors {self.version},"
            f" profile {profile}: {asked} requests{only}{left}; {failures}."
        )


def run(
    door: Door,
    selection: Selection,
    *,
    known: Known | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    of: Vectors | None = None,
) -> Report:
    """Ask every vector of the selection, judge the answers, and end the solver.

    Raises
    ------
    InputError
        Nothing matches, or a known failure names an id that there is not.
    """
    all_of, known = all_vectors() if of is None else of, known or {}
    problems, sets, malformed = _selected(all_of, selection)
    malformed = [each for each in malformed if door.reads_lines or each.callable]
    total = len(problems) + len(sets) + len(malformed)
    if unknown := [id for id, _ in known if id not in _names(all_of)]:  # noqa: A001
        raise InputError("known failures", value=unknown[0], must="must name ids of the vectors")
    asking = _Run(door, selection.profile)
    everything: list[Vector | RecognitionSet | Malformed] = [*problems, *sets, *malformed]
    late: list[str] = []
    try:
        for done, each in enumerate(everything, 1):
            asking.take(each)
            progress(done, total)
    finally:
        late = door.close()
    asking.late(late)
    failed = {(each.id, each.level) for each in asking.findings if each.outcome is Outcome.FAILED}
    asked = {(each.id, each.level) for each in asking.findings}
    stale = tuple(f"{id} {level}" for id, level in known if (id, level) in asked - failed)  # noqa: A001
    return Report(
        door.name, all_of.version, selection, tuple(asking.findings), known, stale, asking.requests,
        asking.sizes, tuple(asking.seconds),
    )  # fmt: skip


def lines(selection: Selection) -> list[str]:
    """Every request of the selection as its line, in the order in which they are asked.

    Raises
    ------
    InputError
        Nothing matches.
    """
    problems, sets, malformed = _selected(all_vectors(), selection)
    templates = [template for each in sets for template in each.templates]
    return [each.request.line for each in (*problems, *templates)] + [each.line for each in malformed]


def _selected(
    all_of: Vectors, selection: Selection
) -> tuple[list[Vector], list[RecognitionSet], list[Malformed]]:
    problems = [each for each in all_of.problems if selection.takes(each.id, each.flags)]
    sets = [
        each
        for each in all_of.recognition
        if any(selection.takes(name, each.flags) for name in (each.id, *(t.id for t in each.templates)))
    ]
    malformed = [each for each in all_of.malformed if selection.takes(each.id, ["malformed"])]
    if not (problems or sets or malformed):
        must = f"must match an id, or be a flag: {', '.join((*FLAGS, 'malformed'))}"
        raise InputError("filter", value=selection.only, must=must)
    return problems, sets, malformed


def _names(all_of: Vectors) -> frozenset[str]:
    return all_of.ids | {each.id for each in all_of.recognition} | {PROTOCOL}


@dataclass
class _Run:
    door: Door
    profile: Profile
    findings: list[Finding] = field(default_factory=list)
    requests: dict[str, str] = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)

    def take(self, each: Vector | RecognitionSet | Malformed) -> None:
        if isinstance(each, Vector):
            self._problem(each)
        elif isinstance(each, RecognitionSet):
            values = [self._problem(template) for template in each.templates]
            self.findings.append(judge_set(each, values, self.profile))
            self.requests[each.id] = "\n".join(template.request.line for template in each.templates)
            self.sizes[each.id] = sum(self.sizes[template.id] for template in each.templates)
        else:
            self.requests[each.id] = each.line
            self.findings.append(judge_malformed(each, *self.door.ask_malformed(each.id, each.line)))

    def _problem(self, case: Vector) -> Fraction | None:
        reply: Reply = self.door.ask(case.request)
        judged = judge(case, reply, self.profile)
        self.findings += judged.findings
        self.requests[case.id] = case.request.line
        self.sizes[case.id] = case.request.problem.n * case.request.problem.d
        self.seconds.append(reply.seconds)
        return judged.value

    def late(self, faults: list[str]) -> None:
        """What was seen only at the end is nobody's answer: it is a fault of the protocol."""
        if faults:
            detail = "; ".join(faults[:SMALLEST]) + (
                f"; and {len(faults) - SMALLEST} more" * (len(faults) > SMALLEST)
            )
            self.findings.append(Finding(PROTOCOL, Level.L0, Outcome.FAILED, detail))


LINE = re.compile(r"(\S+)\s+(L[0-4])\s*(?:#\s*(.*))?")


def read_known(path: Path) -> dict[tuple[str, Level], str]:
    """Read a file of known failures: lines ``ID LEVEL # why``; a line may be empty, or begin with #.

    Raises
    ------
    FileFormatError
        It cannot be read, or a line has another form.
    """
    try:
        lines = given_path(path).read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as problem:
        raise FileFormatError(str(path), value=str(problem), must="must be a readable text file") from None
    found = {}
    for k, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        match = LINE.fullmatch(text)
        if match is None:
            raise FileFormatError(
                f"{path}:{k}", value=text, must="must be an id and a level, such as random-03 L2"
            )
        found[match[1], Level(match[2])] = match[3] or ""
    return found
