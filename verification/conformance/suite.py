"""One run of the kit: every vector asked through a door, judged, and counted."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from convexperc.errors import FileFormatError, InputError
from convexperc.files import given_path
from verification.conformance.answers import Answer, told
from verification.conformance.doors import Door, NotAskedError
from verification.conformance.explaining import Explanation, explain
from verification.conformance.judge import (
    NOT_ASKED,
    Finding,
    Level,
    judge,
    judge_malformed,
    judge_set,
    not_asked,
)
from verification.conformance.profiles import FLOAT64, Profile
from verification.conformance.vectors import FLAGS, Malformed, RecognitionSet, Vector, Vectors, all_vectors
from verification.ledger.evidence import Outcome

T = TypeVar("T")
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
    given_up : str
        Why the rest was not asked; empty where all were.
    ignored : tuple of str
        Keys of answers that nobody reads.
    explained : mapping of str to Explanation
        Of the answers that fail L1, L2 or L3.
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
    given_up: str = ""
    ignored: tuple[str, ...] = ()
    explained: Mapping[str, Explanation] = field(default_factory=dict)

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
    def declined(self) -> tuple[str, ...]:
        """The ids that the solver said are not for it."""
        skipped = (
            each for each in self.findings if (each.level, each.outcome) == (Level.L0, Outcome.SKIPPED)
        )
        return tuple(each.id for each in skipped if each.detail != NOT_ASKED)

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
        ids = {each.id for each in self.findings if each.level is Level.L0} - {PROTOCOL}
        lost = {each.id for each in self.findings if each.level is Level.L0 and each.detail == NOT_ASKED}
        reached = f"reaches {self.reached}" if self.reached else "reaches no level"
        left = f", of which it declined {len(self.declined)}" if self.declined else ""
        only = f" (those that match {self.selection.only})" if self.selection.only else ""
        rest = f" {len(lost)} more were not asked: {self.given_up}." if lost else ""
        profile = self.selection.profile.name
        return (
            f"{self.solver} {reached} of the convexperc conformance vectors {self.version},"
            f" profile {profile}: {len(ids - lost)} requests{only}{left}; {self._failures}.{rest}"
        )

    @property
    def _failures(self) -> str:
        failed, new = self.failed, len(self.unexpected)
        if not failed:
            return "0 failures"
        many = _counted(len(failed), "failure"), _counted(len({each.id for each in failed}), "request")
        known = "" if new == len(failed) else f", {len(failed) - new} of them known" if new else ", all known"
        return f"{' on '.join(many)}{known}"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'s' * (count != 1)}"


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
        Nothing matches.
    """
    all_of, known = all_vectors() if of is None else of, known or {}
    problems, sets, malformed = _selected(all_of, selection)
    malformed = [each for each in malformed if door.reads_lines or each.callable]
    total = len(problems) + len(sets) + len(malformed)
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
        asking.sizes, tuple(asking.seconds), asking.given_up, tuple(sorted(asking.ignored)),
        asking.explained,
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
    ignored: set[str] = field(default_factory=set)
    explained: dict[str, Explanation] = field(default_factory=dict)
    given_up: str = ""

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
            asked = self._asked(lambda: self.door.ask_malformed(each.id, each.line))
            self.findings += [judge_malformed(each, *asked)] if asked else not_asked(each.id, [Level.L0])

    def _asked(self, ask: Callable[[], T]) -> T | None:
        """What came of a question; None from the first on that was not asked."""
        if self.given_up:
            return None
        try:
            return ask()
        except NotAskedError as why:
            self.given_up = str(why)
            return None
        finally:
            self._blame(self.door.earlier())

    def _blame(self, faults: list[str]) -> None:
        """Faults of the request before: it fails L0, whatever was found there."""
        if not (faults and self.findings):
            return
        k = max(k for k, each in enumerate(self.findings) if each.level is Level.L0)
        before = self.findings[k]
        why = [before.detail] if before.outcome is Outcome.FAILED else []
        self.findings[k] = replace(before, outcome=Outcome.FAILED, detail=told([*why, *faults]))

    def _problem(self, case: Vector) -> Fraction | None:
        self.requests[case.id] = case.request.line
        self.sizes[case.id] = case.request.problem.n * case.request.problem.d
        reply = self._asked(lambda: self.door.ask(case.request))
        if reply is None:
            self.findings += not_asked(case.id, Level)
            return None
        judged = judge(case, reply, self.profile)
        self.findings += judged.findings
        self.seconds.append(reply.seconds)
        if isinstance(reply.answer, Answer):
            self.ignored.update(reply.answer.ignored)
            if {Level.L1, Level.L2, Level.L3} & {each.level for each in judged.failed}:
                self.explained[case.id] = explain(
                    case.request.problem, reply.answer.w, reply.answer.u, case.primal
                )
        return judged.value

    def late(self, faults: list[str]) -> None:
        """What was seen only at the end is nobody's answer: it is a fault of the protocol."""
        if faults:
            self.findings.append(Finding(PROTOCOL, Level.L0, Outcome.FAILED, told(faults)))


LINE = re.compile(r"(\S+)\s+(L[0-4])\s*(?:#\s*(.*))?")


def read_known(path: Path) -> dict[tuple[str, Level], str]:
    """Read a file of known failures: lines ``ID LEVEL # why``; a line may be empty, or begin with #.

    Raises
    ------
    FileFormatError
        It cannot be read, or a line has another form, names no id of the vectors, or repeats another.
    """
    try:
        lines = given_path(path).read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as problem:
        raise FileFormatError(str(path), value=str(problem), must="must be a readable text file") from None
    found, names = {}, _names(all_vectors())
    for k, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        match = LINE.fullmatch(text)
        if match is None:
            raise FileFormatError(
                f"{path}:{k}", value=text, must="must be an id and a level, such as random-03 L2"
            )
        if match[1] not in names:
            raise FileFormatError(f"{path}:{k}", value=match[1], must="must name ids of the vectors")
        key = match[1], Level(match[2])
        if key in found:
            raise FileFormatError(f"{path}:{k}", value=" ".join(key), must="must be given once")
        found[key] = match[3] or ""
    return found
