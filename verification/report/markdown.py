"""report.md: the report as plain text with light marks, for a terminal or a forge."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from verification.ledger.evidence import Verdict
from verification.problems.families import SUMMARIES
from verification.report import sentences, words
from verification.report.contents import JudgedClaim, JudgedPart, Report
from verification.report.experiments.blocks import Block
from verification.report.experiments.markdown import lines as lines_of
from verification.report.marks import code, prose, table
from verification.report.plain import printable

FEW = 8
"""Claims with more parts than this get a table of them."""
VOLATILE = "## What differs from run to run"
"""Heading of the last section, the only one that may differ between two runs of one seed."""


def markdown(report: Report, experiments: Sequence[Block] = ()) -> bytes:
    """Render report.md.

    Parameters
    ----------
    report : Report
    experiments : sequence of Block
        See `verification.report.experiments.section.section`.
    """
    before = (_top, _refuted, _reproduce, _ledger, _limits, _evidence)
    after = (_terms, _settings, _volatile)
    lines = [line for section in before for line in section(report)]
    if experiments:
        lines += ["## The experiments", "", *lines_of(experiments, 3, "-")]
    lines += [line for section in after for line in section(report)]
    return (printable("\n".join(lines).rstrip()) + "\n").encode()


def _top(report: Report) -> Iterator[str]:
    yield from (f"# {words.TITLE}", "", sentences.headline(report), "", words.PAPER, "")
    if partial := sentences.partial(report):
        yield from (f"**{prose(partial)}**", "")
    yield from (f"**{sentences.outcome(report)}**", "")
    yield from (f"- {prose(line)}" for line in report.outcome.messages)
    yield from ("", "## Verdicts", "")
    verdicts = list(Verdict)
    yield from table(
        ["claims about", *verdicts, "all"],
        ([row.subject, *(row.verdicts[each] for each in verdicts), row.claims] for row in report.summary),
    )
    yield ""
    yield from (f"- **{verdict}**: {prose(meaning)}" for verdict, meaning in words.VERDICTS.items())
    yield ""


def _refuted(report: Report) -> Iterator[str]:
    """Of each refuted claim: the smallest counterexample, how to see it, and what is true instead."""
    yield from ("### Refuted claims and their corrections", "")
    for claim in report.claims:
        if claim.verdict != Verdict.REFUTED:
            continue
        yield f"- **{claim.id}** ({prose(claim.place)}): {prose(claim.statement)}"
        for key, found in sentences.examples(claim):
            given = f" for {code(found.given)}" if found.given else ""
            yield f"  - {prose(key)} fails{given}: {code(found.finding)}."
            yield f"    {code(sentences.replay(found.id))}"
        for part in sentences.corrected(report, claim):
            under = f" {code(part.condition)}" if part.condition else ""
            named = f"{prose(part.key)} **{part.verdict}**{under}"
            yield f"  - Corrected statement: {named}: {code(part.statement)}"
        for key in sentences.elsewhere(report, claim):
            yield f"  - Corrected statement: {prose(key)}, which this run did not judge."
        if claim.parts[0].rule:
            yield f"  - {prose(sentences.sentence(claim.reason))}"
        elif not claim.corrected:
            yield "  - No corrected statement is given."
    yield ""


def _reproduce(report: Report) -> Iterator[str]:
    settings = report.settings
    yield from ("## How to reproduce this", "", f"    {' '.join(str(settings['command']).split())}", "")
    yield f"Profile {prose(settings['profile'])}, seed {prose(settings['seed'])}. Versions are listed with"
    yield "the settings, the commit in the last section. A counterexample, iteration by iteration (for one"
    yield "that the search found, give the folder of this report with `--out`):"
    yield from ("", f"    {sentences.replay('ID')}", "")


def _ledger(report: Report) -> Iterator[str]:
    yield from ("## The claims and their verdicts", "")
    rows = (
        [
            claim.id,
            claim.verdict,
            f"{prose(claim.statement)} ({prose(claim.place)})",
            f"{prose(sentences.sentence(claim.reason))} {prose(sentences.condition(claim))}".rstrip(),
        ]
        for claim in report.claims
    )
    yield from table(["id", "verdict", "claim", "why"], rows)
    yield ""


def _limits(report: Report) -> Iterator[str]:
    yield from ("## Known limitations", "")
    yield from (f"- {prose(limitation)}" for limitation in words.LIMITATIONS)
    for figure in sentences.figures(report):
        if figure.name not in report.series:
            yield f"- {prose(figure.title)} ({figure.claim}): {words.NOT_RUN.lower()}"
    yield from (f"- **Missing in this run:** {prose(what)}" for what in report.missing)
    yield ""


def _evidence(report: Report) -> Iterator[str]:
    yield from ("## Evidence by claim", "")
    for claim in report.claims:
        yield from (f"### {claim.id}: {claim.verdict}", "", prose(claim.statement), "")
        if claim.verdict == Verdict.NOT_TESTABLE:
            yield from (f"Place: {prose(claim.place)}. {prose(sentences.sentence(claim.reason))}", "")
            continue
        yield from (f"Place: {prose(claim.place)}. Method: {prose(claim.method)}", "")
        for part in claim.parts:
            yield from _part(part)
        yield ""
        yield from _by_family(claim)


def _part(part: JudgedPart) -> Iterator[str]:
    head = f"- **{prose(part.key)}** ({words.ROLES[part.role]}): **{part.verdict}**"
    yield f"{head}. {code(part.statement)}"
    under = f"; {sentences.limited(part).lower()}: {prose(part.condition)}" if part.condition else ""
    yield f"  - {prose(part.reason)}{under}"
    if part.rule:
        yield from (f"  - {prose(line)}" for line in sentences.surveyed(part))
        return
    measured = prose(sentences.worst(part))
    yield f"  - {sentences.cases(part.cases, part.formula)} {measured}".rstrip()
    if part.tolerance:
        yield f"  - Tolerance: {prose(part.tolerance)}"
    for argument in part.arguments:
        yield f"  - {prose(sentences.proof(argument))}: {prose(argument.conclusion)}"
        for number, step in enumerate(argument.steps, 1):
            accepted = "" if step.passed else "**not accepted** "
            yield f"    {number}. {code(step.statement)} ({accepted}{prose(sentences.checked(step))})"
    for found in part.counterexamples:
        word = "Counterexample" if found.confirmed else "Stale record, counts as nothing:"
        yield f"  - {word} {code(found.id)} ({prose(found.size)}; {prose(found.origin)})"
        if found.given:
            yield f"    {code(found.given)}"
        yield f"    {code(found.finding)}"
        yield f"    {code(sentences.replay(found.id))}"


def _by_family(claim: JudgedClaim) -> Iterator[str]:
    """A row for each part: its cases on random and on degenerate problems, and where it fails."""
    if len(claim.parts) <= FEW:
        return
    rows = (
        [
            prose(part.key),
            part.verdict,
            *(prose(sentences.cases(count, part.formula)) for _, count in sentences.by_kind(part)),
            prose(_failing(part)),
        ]
        for part in claim.parts
    )
    yield from table(["part", "verdict", "random", "degenerate", "all", "failed of decided, by family"], rows)
    yield ""


def _failing(part: JudgedPart) -> str:
    """Where it fails: failed of decided cases of each family that has a failure."""
    counts = ((name, part.families[name]) for name in sentences.in_order(part.families))
    told = [
        f"{name.replace('_', ' ')} {count.failed}/{count.decided}" for name, count in counts if count.failed
    ]
    return ", ".join(told) or "none"


def _terms(report: Report) -> Iterator[str]:
    yield from ("## Symbols and terms", "")
    yield from (f"- {code(symbol)}: {prose(meaning)}" for symbol, meaning in words.SYMBOLS)
    yield from (f"- update variant {prose(name)}: {prose(meaning)}" for name, meaning in words.VARIANTS)
    yield from ("", "## Families of problems", "")
    rows = (
        [
            prose(row.family),
            "-" if row.problems is None else row.problems,
            *(getattr(row.cases, name) for name in sentences.CASES),
            prose(SUMMARIES.get(row.family, "counted at fixed sizes")),
        ]
        for row in sentences.coverage(report)
    )
    yield from table(["family", "problems", *sentences.CASES, "what it is"], rows)
    yield from ("", prose(sentences.left_out(report)), "")


def _settings(report: Report) -> Iterator[str]:
    yield from ("## Environment, settings and hashes", "")
    yield from _facts(report.settings)
    yield f"- digest of the findings: {code(report.digest)}"
    yield from (f"- {code(name)}: {code(sha256)}" for name, sha256 in report.counterexamples.items())
    yield ""


def _volatile(report: Report) -> Iterator[str]:
    yield from (VOLATILE, "")
    yield from _facts({key: value for key, value in report.volatile.items() if key != "times"})


def _facts(values: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _facts({f"{name}, {inner}": entry for inner, entry in value.items()})
        else:
            yield f"- {prose(name)}: {prose(value)}"
