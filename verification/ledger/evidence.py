"""What is known about a claim: counts, checked arguments, exact counterexamples, surveys, the verdict.

Everything here is plain data that is written to JSON and read back; nothing computes.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from verification.ledger.surveys import Survey


class Verdict(StrEnum):
    """What the evidence says of a part of a claim, or of the whole claim.

    ``holds``: a written proof; a machine checked each algebraic step, theorems of the literature are cited,
    and what joins the steps is argued in words; ``holds under``: the same, on a condition that is named;
    ``supported``: tested on the stated number of cases without a failure; ``refuted``: a counterexample is
    stored and was confirmed in exact arithmetic; ``inconclusive``: none of these; ``not testable here``.

    Of the experiments, whose data are not the paper's: ``reproduced``, ``reproduced where decided``, ``not
    reproduced``, ``opposite found``, ``depends on``, with the factor that decides, or ``inconclusive``, by
    the rule in `verification.ledger.rules` from the configurations of a stored record. None of them refutes.
    """

    HOLDS = "holds"
    HOLDS_UNDER = "holds under"
    SUPPORTED = "supported"
    REFUTED = "refuted"
    INCONCLUSIVE = "inconclusive"
    NOT_TESTABLE = "not testable here"
    REPRODUCED = "reproduced"
    WHERE_DECIDED = "reproduced where decided"
    NOT_REPRODUCED = "not reproduced"
    OPPOSITE = "opposite found"
    DEPENDS = "depends on"


class Outcome(StrEnum):
    """What one case says of a part of a claim.

    ``undecided``: the case does not tell, for example a loop that met its limit of iterations; ``skipped``:
    the part says nothing about this case.
    """

    HELD = "held"
    FAILED = "failed"
    UNDECIDED = "undecided"
    SKIPPED = "skipped"


class Checker(StrEnum):
    """What verified a step of an argument.

    ``identity``: two polynomials with rational coefficients, expanded, are equal; ``solvers``: z3 and cvc5
    both found the hypotheses satisfiable over the reals, and the negation of the conclusion not; ``exact``: a
    statement about given rational numbers, evaluated. The machine checks nothing of the other two:
    ``cited``, a theorem of the literature, with its source; ``prose``, an inference that joins steps and is
    argued in words.
    """

    IDENTITY = "exact identity"
    SOLVERS = "z3 and cvc5"
    EXACT = "exact evaluation"
    CITED = "cited theorem"
    PROSE = "argued in words"

    @property
    def is_machine(self) -> bool:
        """Whether a step of this kind was checked by a machine."""
        return self not in (Checker.CITED, Checker.PROSE)


@dataclass(frozen=True)
class Step:
    """One step of an argument.

    Attributes
    ----------
    statement : str
        Its name and, where a machine checked it, a gloss that states no relation: `source` was checked.
    checker : Checker
    passed : bool
        Whether the checker accepted it; always True where no machine checks.
    source : str
        What the machine was given; the reference of a cited theorem; the section that argues a joint.
    where : str
        What the names in `source` stand for, or the data whose numbers it holds.
    """

    statement: str
    checker: Checker
    passed: bool
    source: str
    where: str = ""


@dataclass(frozen=True)
class Argument:
    """A written proof of one part of a claim: the steps that were checked, what is cited, and the joints.

    Attributes
    ----------
    part : str
        Which part it proves: a key of `verification.ledger.claims.PARTS`.
    conclusion : str
    condition : str
        Where the conclusion holds, if not everywhere that the part speaks of; else empty.
    steps : tuple of Step
    passed : bool
        Whether a machine accepted every step that one checks, and there is such a step.
    """

    part: str
    conclusion: str
    condition: str
    steps: tuple[Step, ...]
    passed: bool = field(init=False)

    def __post_init__(self) -> None:
        checked = any(step.checker.is_machine for step in self.steps)
        object.__setattr__(self, "passed", checked and all(step.passed for step in self.steps))


@dataclass
class Count:
    """Cases of one family tried on one part.

    Attributes
    ----------
    part, family : str
    held, failed, undecided, skipped : int
    worst : float
        Largest measure of a case; what it measures is said by the part.
    formula : bool
        Whether the cases evaluate formulas of the paper alone, and no code that is judged.
    """

    part: str
    family: str
    held: int = 0
    failed: int = 0
    undecided: int = 0
    skipped: int = 0
    worst: float = 0.0
    formula: bool = False

    @property
    def total(self) -> int:
        """Cases of any outcome."""
        return self.held + self.failed + self.undecided + self.skipped

    def add(self, other: "Count") -> None:
        """Add the counts of the same part and family."""
        self.held += other.held
        self.failed += other.failed
        self.undecided += other.undecided
        self.skipped += other.skipped
        self.worst = max(self.worst, other.worst)
        self.formula = self.formula or other.formula


@dataclass(frozen=True)
class Refutation:
    """A counterexample that was confirmed in exact arithmetic in this run, or is stale.

    Attributes
    ----------
    id : str
        Of the record.
    part : str
    confirmed : bool
        False: the record no longer fails.
    finding : str
        The exact numbers, in one line.
    size : str
        How small it is, for example "n = d = 1, entries up to 4".
    origin : str
        "catalogue", or the search that found it.
    given : str
        The problem, the point and the update, in exact numbers where they are short.
    basis : str
        What the confirmation rests on.
    """

    id: str
    part: str
    confirmed: bool
    finding: str
    size: str
    origin: str
    given: str = ""
    basis: str = "exact arithmetic"


@dataclass(frozen=True)
class Judgement:
    """The verdict on a part or on a whole claim.

    Attributes
    ----------
    verdict : Verdict
    reason : str
        From which evidence it follows, in one line.
    condition : str
        For ``holds under`` and ``depends on``.
    """

    verdict: Verdict
    reason: str
    condition: str = ""


@dataclass
class Evidence:
    """Everything that a run found.

    Attributes
    ----------
    settings : dict
        Profile, seed and budgets: all that the outcome depends on, besides the versions.
    counts : list of Count
    arguments : list of Argument
    refutations : list of Refutation
    surveys : list of Survey
        Read from a record of the experiments; not found by this run.
    series : dict of str to JSON data
        Numbers for the plots, by name; deterministic.
    missing : list of str
        What a run of this profile must have done and did not: families not reached, checks that broke.
    volatile : dict of str to JSON data
        Times, the machine, the date: what may differ between two runs of one seed.
    """

    settings: dict[str, Any] = field(default_factory=dict)
    counts: list[Count] = field(default_factory=list)
    arguments: list[Argument] = field(default_factory=list)
    refutations: list[Refutation] = field(default_factory=list)
    surveys: list[Survey] = field(default_factory=list)
    series: dict[str, Any] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    volatile: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Evidence":
        """Read back what `as_json` wrote."""
        return cls(
            settings=data["settings"],
            counts=[Count(**each) for each in data["counts"]],
            arguments=[_argument(each) for each in data["arguments"]],
            refutations=[Refutation(**each) for each in data["refutations"]],
            surveys=[Survey.from_json(each) for each in data.get("surveys", [])],
            series=data["series"],
            missing=data["missing"],
            volatile=data["volatile"],
        )

    def of_part(self, part: str) -> list[Count]:
        """The counts of one part, by family."""
        return [count for count in self.counts if count.part == part]


def _argument(data: dict[str, Any]) -> Argument:
    steps = tuple(Step(**each | {"checker": Checker(each["checker"])}) for each in data["steps"])
    return Argument(data["part"], data["conclusion"], data["condition"], steps)


def summed(counts: Iterable[Count], part: str) -> Count:
    """Add up the counts of one part over its families."""
    total = Count(part, "all")
    for count in counts:
        if count.part == part:
            total.add(count)
    return total
