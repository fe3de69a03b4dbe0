"""Sentences that the HTML and the Markdown report share: plain text made from the record."""

from collections.abc import Iterable, Mapping, Sequence, Sized
from typing import Any

from verification.ledger.evidence import Verdict
from verification.problems.families import FAMILIES
from verification.report import words

Record = Mapping[str, Any]
OURS = "ours"
"""Place of a claim that is not the paper's."""
CASES = ("held", "failed", "undecided", "skipped")
CAPPED = 1e300
"""Measures end here; a share of F* = 0 is not a number."""

OUTCOMES = {
    0: "Every verdict is the one that the baseline expects; no promise of the library failed, no stored"
    " counterexample is stale, and nothing that was required is missing.",
    1: "This run is not what the baseline expects:",
    3: "Nothing contradicts the baseline, but something that was required was not run or stayed open:",
}


def outcome(record: Record) -> tuple[str, list[str]]:
    """What the run amounts to, and the findings, the gravest first."""
    found = record["outcome"]
    lines = [*found["failed"], *found["changed"], *found["stale"], *found["open"]]
    return OUTCOMES[found["code"]], lines


def headline(record: Record) -> str:
    """How many claims have which verdict, those of the paper and ours apart."""
    claims = record["claims"]
    ours = [claim for claim in claims if claim["place"] == OURS]
    papers = [claim for claim in claims if claim["place"] != OURS]
    parts = sum(len(claim["parts"]) for claim in claims)
    told = [f"{many(claims, 'claim')} in {many(range(parts), 'formal part')}."]
    told += [f"Of the paper's {len(papers)}: {_counted(papers)}."] if papers else []
    told += [f"Of our own {len(ours)}: {_counted(ours)}."] if ours else []
    return " ".join(told)


def partial(record: Record) -> str:
    """Say so if the run was about some of the claims alone; else empty."""
    if not record["unjudged"]:
        return ""
    judged = [claim["id"] for claim in record["claims"]]
    total = len(judged) + len(record["unjudged"])
    return (
        f"This is a partial report: {len(judged)} of the {total} claims of the ledger were selected and"
        f" judged, {listed(judged)}. It says nothing about the others."
    )


def many(things: Sized, name: str) -> str:
    """A number and its noun."""
    return f"{len(things):,} {name}" if len(things) == 1 else f"{len(things):,} {name}s"


def _counted(claims: Sequence[Record]) -> str:
    counted = {verdict: sum(claim["verdict"] == verdict for claim in claims) for verdict in Verdict}
    named = {
        Verdict.HOLDS: ("holds", "hold"),
        Verdict.HOLDS_UNDER: ("holds under a condition", "hold under a condition"),
        Verdict.SUPPORTED: ("is supported", "are supported"),
        Verdict.REFUTED: ("is refuted", "are refuted"),
        Verdict.INCONCLUSIVE: ("is inconclusive", "are inconclusive"),
        Verdict.NOT_TESTABLE: ("cannot be tested here", "cannot be tested here"),
    }
    return listed([f"{count} {named[verdict][count != 1]}" for verdict, count in counted.items() if count])


def cases(count: Mapping[str, int]) -> str:
    """How many cases of a part had which outcome."""
    total = sum(count[outcome] for outcome in CASES)
    if not total:
        return "No cases were drawn for it."
    told = [f"{count[name]:,} {name}" for name in CASES if count[name]]
    return f"{total:,} {'case' if total == 1 else 'cases'}: {listed(told)}."


def worst(part: Record, told: bool = False) -> str:
    """The worst measure of a part and where it was met; empty where nothing is measured.

    What it measures is left out if it was `told` before.
    """
    count = part["count"]
    if not part["measure"] or not count["held"] + count["failed"] + count["undecided"]:
        return ""
    what = "" if told else f" ({part['measure']})"
    if count["worst"] == 0:
        return f"Worst: 0{what}."
    if float(count["worst"]) >= CAPPED:
        return f"Worst: beyond every number{what}, as F* is 0 or next to it."
    return f"Worst: {measure(count['worst'])}, in {family(part['worst_family'])}{what}."


def surveyed(part: Record) -> list[str]:
    """What the experiments compare for a part, and what the default reading of each set of pictures says."""
    rule = part["rule"]
    least = (
        f"smallest effect {rule['smallest_effect']:g}" if rule["smallest_effect"] else "no smallest effect"
    )
    told = [f"Compared: {rule['statistic']}.", f"On {rule['scenes']}; {rule['comparisons']} joint, {least}."]
    for each in part["surveys"]:
        default, numbers = each["default"], "no scene defines it"
        if default["statistic"] is not None:
            bounds = f"[{default['lower']:.3g}, {default['upper']:.3g}]"
            numbers = f"{default['statistic']:.3g} {bounds} over {default['units']:,} scenes"
        out = f", {default['left_out']:,} left out" if default["left_out"] else ""
        counts = f"holds in {each['holds']}, refuted in {each['refuted']}, open in {each['inconclusive']}"
        outcome = "open" if default["outcome"] == "inconclusive" else default["outcome"]
        told.append(
            f"{sentence(each['pictures'])[:-1]}: {each['verdict']}; {counts} of {each['readings']}"
            " readings. Default"
            f" reading: {outcome}, {default['name']}: {numbers}{out}."
        )
    return told


def common(claim: Record, field: str) -> str:
    """What all of several parts of a claim have in this field, to be told once; else empty."""
    values = {part[field] for part in claim["parts"]}
    return values.pop() if len(values) == 1 and len(claim["parts"]) > 1 else ""


def sentence(text: str) -> str:
    """With a capital and a full stop."""
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith(".") else ".")


def measure(value: float | str) -> str:
    """Two digits; "inf" and "nan" stay words."""
    return f"{float(value):.2g}"


def nearest(record: Record, claim: Record) -> list[Record]:
    """The parts that say what is true where the claim is not, as far as they were judged."""
    parts = {part["key"]: part for part in parts_of(record)}
    return [parts[key] for key in claim["nearest"] if key in parts]


def elsewhere(record: Record, claim: Record) -> list[str]:
    """The keys of those that belong to claims that the run was not about."""
    judged = {part["key"] for part in parts_of(record)}
    return [key for key in claim["nearest"] if key not in judged]


def examples(claim: Record) -> list[tuple[str, Record]]:
    """The counterexamples to show first: of each refuted stated part the first, with its key."""
    found = []
    for part in claim["parts"]:
        confirmed = [each for each in part["counterexamples"] if each["confirmed"]]
        if part["role"] == "stated" and confirmed:
            found.append((part["key"], confirmed[0]))
    return found


def figures(record: Record) -> list[words.Figure]:
    """The figures of the claims that were judged."""
    judged = {claim["id"] for claim in record["claims"]}
    return [figure for figure in words.FIGURES if figure.claim in judged]


def coverage(record: Record) -> list[dict[str, Any]]:
    """Of each family that was met: the problems looked at, and the cases by outcome, over all parts."""
    rows: dict[str, dict[str, Any]] = {}
    for part in parts_of(record):
        for name, count in part["families"].items():
            row = rows.setdefault(name, dict.fromkeys(CASES, 0) | {"family": name})
            for outcome in CASES:
                row[outcome] += count[outcome]
    problems = record["series"].get("coverage", {})
    return [rows[name] | {"problems": problems.get(name)} for name in in_order(rows)]


def by_kind(part: Record) -> list[tuple[str, dict[str, int]]]:
    """The cases of one part on the family "random", on all degenerate families together, and on all."""
    kinds = {"random": ["random"], "degenerate": [name for name in part["families"] if name != "random"]}
    rows = []
    for kind, names in kinds.items():
        counts = [part["families"][name] for name in names if name in part["families"]]
        rows.append((kind, {outcome: sum(count[outcome] for count in counts) for outcome in CASES}))
    return [*rows, ("all", {outcome: part["count"][outcome] for outcome in CASES})]


def in_order(names: Iterable[str]) -> list[str]:
    """Families, the random one first and the degenerate ones in the order of their definition."""
    order = {name: at for at, name in enumerate(FAMILIES)}
    return sorted(names, key=lambda name: (order.get(name, len(order)), name))


def family(name: str) -> str:
    """A family in words."""
    return f"family {name.replace('_', ' ')}" if name in FAMILIES else name


def parts_of(record: Record) -> list[Record]:
    """All parts that were judged."""
    return [part for claim in record["claims"] for part in claim["parts"]]


def short(key: str) -> str:
    """The name of a part within its claim, for the head of a column."""
    name = "/".join(key.split("/")[1:])
    return name.replace("/gauss_seidel", " GS").replace("/jacobi", " J").replace("_", " ").replace("/", " ")


def condition(claim: Record) -> str:
    """The condition of a claim as a sentence, with the part that it belongs to; else empty."""
    if not claim["condition"]:
        return ""
    stated = [part for part in claim["parts"] if part["role"] == "stated"]
    bound = [part["key"] for part in stated if part["condition"]]
    where = f" of {listed(bound)}" if len(stated) > 1 else ""
    return f"Condition{where}: {claim['condition']}."


def replay(identity: str) -> str:
    """The command that shows a counterexample step by step."""
    return f"python -m verification replay {identity}"


def anchor(key: str) -> str:
    """The id of a claim or part on the page."""
    return key.replace("/", "-")


def listed(items: list[str]) -> str:
    """Items with commas and an "and"."""
    return " and ".join(filter(None, [", ".join(items[:-1]), *items[-1:]]))
