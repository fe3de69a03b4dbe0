"""Sentences that the HTML and the Markdown report share: plain text made from the contents."""

from collections.abc import Iterable, Sequence, Sized
from typing import NamedTuple

from verification.ledger.claims import Role, Voice
from verification.ledger.evidence import Argument, Outcome, Refutation, Step, Verdict
from verification.ledger.verdicts import case_word, trust_base
from verification.problems.families import FAMILIES
from verification.report import words
from verification.report.contents import Cases, JudgedClaim, JudgedPart, Report

VOICES = {
    Voice.PAPER: "the paper's claims",
    Voice.QUESTION: "our questions",
    Voice.PROMISE: "this library's promises",
}
CASES = tuple(outcome.value for outcome in Outcome)
CAPPED = 1e300
"""Measures end here; a share of F* = 0 is not a number."""

OUTCOMES = {
    0: "Every verdict is the one that the baseline expects; no promise of the library failed, no stored"
    " counterexample is stale, and nothing that was required is missing.",
    1: "This run is not what the baseline expects:",
    3: "Nothing contradicts the baseline, but something that was required was not run or stayed open:",
}


class Coverage(NamedTuple):
    """A family that was met: the problems looked at, if they were counted, and the cases over all parts."""

    family: str
    problems: int | None
    cases: Cases


def outcome(report: Report) -> str:
    """What the run amounts to."""
    return OUTCOMES[report.outcome.code]


def headline(report: Report) -> str:
    """How many claims have which verdict, by who says so."""
    told = [f"{many(report.claims, 'claim')} in {many(report.parts, 'formal part')}."]
    for voice, name in VOICES.items():
        claims = [claim for claim in report.claims if claim.voice is voice]
        told += [f"Of {name} ({len(claims)}): {_counted(claims)}."] if claims else []
    return " ".join(told)


def partial(report: Report) -> str:
    """Say so if the run was about some of the claims alone; else empty."""
    if not report.unjudged:
        return ""
    judged = [claim.id for claim in report.claims]
    total = len(judged) + len(report.unjudged)
    return (
        f"This is a partial report: {len(judged)} of the {total} claims of the ledger were selected and"
        f" judged, {listed(judged)}. It says nothing about the others."
    )


def many(things: Sized, name: str) -> str:
    """A number and its noun."""
    return f"{len(things):,} {name}" if len(things) == 1 else f"{len(things):,} {name}s"


def _counted(claims: Sequence[JudgedClaim]) -> str:
    counted = {verdict: sum(claim.verdict is verdict for claim in claims) for verdict in Verdict}
    named = {
        Verdict.HOLDS: ("holds", "hold"),
        Verdict.HOLDS_UNDER: ("holds under a condition", "hold under a condition"),
        Verdict.SUPPORTED: ("is supported", "are supported"),
        Verdict.REFUTED: ("is refuted", "are refuted"),
        Verdict.REPRODUCED: ("is reproduced", "are reproduced"),
        Verdict.DEPENDS: (depends := "depends on what the paper leaves open", depends.replace("ds", "d", 1)),
        Verdict.NOT_REPRODUCED: ("is not reproduced", "are not reproduced"),
        Verdict.OPPOSITE: ("is met by its opposite", "are met by their opposites"),
        Verdict.INCONCLUSIVE: ("is inconclusive", "are inconclusive"),
        Verdict.NOT_TESTABLE: ("cannot be tested here", "cannot be tested here"),
    }
    return listed([f"{count} {named[verdict][count != 1]}" for verdict, count in counted.items() if count])


def cases(count: Cases, formula: bool = False) -> str:
    """How many cases of a part had which outcome; those of a formula are called evaluations of it."""
    numbers = {name: getattr(count, name) for name in CASES}
    if not (total := sum(numbers.values())):
        return "No cases were drawn for it."
    told = [f"{number:,} {name}" for name, number in numbers.items() if number]
    return f"{total:,} {case_word(formula, total)}: {listed(told)}."


def worst(part: JudgedPart, told: bool = False) -> str:
    """The worst measure of a part and where it was met; empty where nothing is measured.

    What it measures is left out if it was `told` before.
    """
    count = part.cases
    if not part.measure or not count.decided + count.undecided:
        return ""
    what = "" if told else f" ({part.measure})"
    if count.worst == 0:
        return f"Worst: 0{what}."
    if count.worst >= CAPPED:
        return f"Worst: unbounded{what}, as F* is 0 or close to it."
    return f"Worst: {measure(count.worst)}, in {family(part.worst_family)}{what}."


def surveyed(part: JudgedPart) -> list[str]:
    """What the experiments compare for a part, and what they say on each set of pictures."""
    if (rule := part.rule) is None:
        return []
    least = f"smallest effect {rule.smallest_effect:g}" if rule.smallest_effect else "no smallest effect"
    count = "one comparison" if rule.comparisons == 1 else f"{rule.comparisons} comparisons"
    told = [f"Compared: {rule.statistic}.", f"On {rule.scenes}; {count}, {least}."]
    for each in part.surveys:
        default, numbers = each.default, "no scene defines it"
        if default.statistic is not None:
            numbers = f"{default.figures} over {default.units:,} scenes"
        out = f", {default.left_out:,} left out" if default.left_out else ""
        condition = f" {each.condition}" if each.condition else ""
        told.append(
            f"{sentence(each.pictures)[:-1]}: {each.verdict}{condition}; {each.told}; every mean on the"
            f" claim's side in {each.agreeing}."
            f" Default configuration: {default.outcome}, {default.name}: {numbers}{out}."
        )
    return told


def common(claim: JudgedClaim, field: str) -> str:
    """What all of several parts of a claim have in this field, to be told once; else empty."""
    values = {str(getattr(part, field)) for part in claim.parts}
    return values.pop() if len(values) == 1 and len(claim.parts) > 1 else ""


def sentence(text: str) -> str:
    """With a capital and a full stop."""
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith(".") else ".")


def measure(value: float) -> str:
    """Two digits; "inf" and "nan" stay words."""
    return f"{value:.2g}"


def corrected(report: Report, claim: JudgedClaim) -> list[JudgedPart]:
    """The parts that say what is true where the claim is not, as far as they were judged."""
    parts = {part.key: part for part in report.parts}
    return [parts[key] for key in claim.corrected if key in parts]


def elsewhere(report: Report, claim: JudgedClaim) -> list[str]:
    """The keys of those that belong to claims that the run was not about."""
    judged = {part.key for part in report.parts}
    return [key for key in claim.corrected if key not in judged]


def examples(claim: JudgedClaim) -> list[tuple[str, Refutation]]:
    """The counterexamples to show first: of each refuted stated part the first, with its key."""
    stated = [part for part in claim.parts if part.role is Role.STATED]
    found = ((part.key, [each for each in part.counterexamples if each.confirmed]) for part in stated)
    return [(key, confirmed[0]) for key, confirmed in found if confirmed]


def figures(report: Report) -> list[words.Figure]:
    """The figures of the claims that were judged."""
    judged = {claim.id for claim in report.claims}
    return [figure for figure in words.FIGURES if figure.claim in judged]


def coverage(report: Report) -> list[Coverage]:
    """Every family that was met."""
    parts = [part for part in report.parts if not part.formula]
    names = in_order({name for part in parts for name in part.families})
    problems = report.series.get("coverage", {})
    return [
        Coverage(
            name,
            problems.get(name),
            Cases.of(part.families[name] for part in parts if name in part.families),
        )
        for name in names
    ]


def left_out(report: Report) -> str:
    """What the coverage leaves out: problems on which formulas of the paper were evaluated, and no code."""
    parts = [part for part in report.parts if part.formula]
    total = sum(sum(getattr(part.cases, name) for name in CASES) for part in parts)
    if not total:
        return ""
    names = ", ".join(part.key for part in parts)
    return f"Left out are {total:,} evaluations of formulas alone, which run no code that is judged: {names}."


def by_kind(part: JudgedPart) -> list[tuple[str, Cases]]:
    """The cases of one part on the family "random", on all degenerate families together, and on all."""
    random = Cases.of(count for name, count in part.families.items() if name == "random")
    degenerate = Cases.of(count for name, count in part.families.items() if name != "random")
    return [("random", random), ("degenerate", degenerate), ("all", part.cases)]


def in_order(names: Iterable[str]) -> list[str]:
    """Families, the random one first and the degenerate ones in the order of their definition."""
    order = {name: at for at, name in enumerate(FAMILIES)}
    return sorted(names, key=lambda name: (order.get(name, len(order)), name))


def family(name: str) -> str:
    """A family in words."""
    return f"family {name.replace('_', ' ')}" if name in FAMILIES else name


def short(key: str) -> str:
    """The name of a part within its claim, for the head of a column."""
    name = "/".join(key.split("/")[1:])
    return name.replace("/gauss_seidel", " GS").replace("/jacobi", " J").replace("_", " ").replace("/", " ")


def limited(found: JudgedClaim | JudgedPart) -> str:
    """What the condition of a verdict is called."""
    return "Depends on" if found.verdict is Verdict.DEPENDS else "Condition"


def condition(claim: JudgedClaim) -> str:
    """The condition of a claim as a sentence, with the part that it belongs to; else empty."""
    if not claim.condition:
        return ""
    stated = [part for part in claim.parts if part.role is Role.STATED]
    bound = [part.key for part in stated if part.condition]
    where = f" of {listed(bound)}" if len(stated) > 1 else ""
    return f"{limited(claim)}{where}: {claim.condition}."


def proof(argument: Argument) -> str:
    """Whether a proof passed, and what it rests on."""
    return f"{'Written proof' if argument.passed else 'Proof that failed'}, {trust_base(argument.steps)}"


def checked(step: Step) -> str:
    """By what a step was checked, and which formula; what its letters stand for."""
    verb = ", checked" if step.checker.is_machine else ""
    where = f"; where {step.where}" if step.where else ""
    return f"{step.checker}{verb}: {step.source}{where}"


def replay(identity: str) -> str:
    """The command that shows a counterexample iteration by iteration."""
    return f"python -m verification replay {identity}"


def anchor(key: str) -> str:
    """The id of a claim or part on the page."""
    return key.replace("/", "-")


def listed(items: list[str]) -> str:
    """Items with commas and an "and"."""
    return " and ".join(filter(None, [", ".join(items[:-1]), *items[-1:]]))
