"""Sentences that the HTML and the Markdown report share: plain text made from the record."""

from collections.abc import Mapping
from typing import Any

from verification.evidence import Verdict

Record = Mapping[str, Any]

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
    """How many claims have which verdict."""
    claims = record["claims"]
    counted = {verdict: sum(claim["verdict"] == verdict for claim in claims) for verdict in Verdict}
    words = {
        Verdict.HOLDS: ("holds", "hold"),
        Verdict.HOLDS_UNDER: ("holds under a condition", "hold under a condition"),
        Verdict.SUPPORTED: ("is supported", "are supported"),
        Verdict.REFUTED: ("is refuted", "are refuted"),
        Verdict.INCONCLUSIVE: ("is inconclusive", "are inconclusive"),
        Verdict.NOT_TESTABLE: ("cannot be tested here", "cannot be tested here"),
    }
    told = [f"{count} {words[verdict][count != 1]}" for verdict, count in counted.items() if count]
    parts = sum(len(claim["parts"]) for claim in claims)
    return f"{len(claims)} claims in {parts} formal parts: {listed(told)}."


def cases(count: Mapping[str, int]) -> str:
    """How many cases of a part had which outcome."""
    total = sum(count[outcome] for outcome in ("held", "failed", "undecided", "skipped"))
    if not total:
        return "No cases."
    told = [f"{count[name]:,} {name}" for name in ("held", "failed", "undecided", "skipped") if count[name]]
    return f"{total:,} {'case' if total == 1 else 'cases'}: {listed(told)}."


def worst(part: Record, told: bool = False) -> str:
    """The worst measure of a part and where it was met; empty where nothing is measured.

    What it measures is left out if it was `told` before.
    """
    count = part["count"]
    if not part["measure"] or not count["held"] + count["failed"] + count["undecided"]:
        return ""
    where = f"Worst: {measure(count['worst'])}, in family {part['worst_family'].replace('_', ' ')}"
    return f"{where}." if told else f"{where} ({part['measure']})."


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
    """The parts that say what is true where the claim is not."""
    parts = {part["key"]: part for each in record["claims"] for part in each["parts"]}
    return [parts[key] for key in claim["nearest"]]


def example(claim: Record) -> Record | None:
    """The counterexample to show first: the first confirmed one of the first refuted stated part."""
    for part in claim["parts"]:
        found = [each for each in part["counterexamples"] if each["confirmed"]]
        if part["role"] == "stated" and found:
            return found[0]  # type: ignore[no-any-return]
    return None


def replay(identity: str) -> str:
    """The command that shows a counterexample step by step."""
    return f"python -m verification replay {identity}"


def anchor(key: str) -> str:
    """The id of a claim or part on the page."""
    return key.replace("/", "-")


def listed(items: list[str]) -> str:
    """Items with commas and an "and"."""
    return " and ".join(filter(None, [", ".join(items[:-1]), *items[-1:]]))
