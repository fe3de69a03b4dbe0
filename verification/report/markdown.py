"""report.md: the findings, the causes and the ledger, with links to the page; no evidence."""

from collections.abc import Iterator

from verification.ledger.evidence import Verdict
from verification.report import findings, sentences, symbols, trust, words
from verification.report.contents import JudgedClaim, Report
from verification.report.marks import code, marked, prose, table
from verification.report.plain import printable

PAGE = "report.html"
ELSEWHERE = (
    ("what to trust, and how to replay it", "trust"),
    ("evidence by claim", "evidence"),
    ("proofs", "proofs"),
    ("the experiments", "experiments"),
    ("certificates", "certificates"),
    ("limits", "limits"),
    ("symbols", "symbols"),
    ("environment and settings", "environment"),
    ("what differs from run to run", "volatile"),
    ("hashes", "hashes"),
)
"""What the page has beyond this file, and its anchors."""


def markdown(report: Report) -> bytes:
    """Render report.md."""
    sections = (_top, _right, _replay, _causes, _ledger, _elsewhere)
    lines = [line for section in sections for line in section(report)]
    return (printable("\n".join(lines).rstrip()) + "\n").encode()


def _top(report: Report) -> Iterator[str]:
    yield from (f"# {words.TITLE}", "")
    yield from (f"On *{words.PAPER}* by {words.AUTHORS}, [arXiv:{words.ARXIV}]({words.LINK}).", "")
    yield from (made(report), "")
    yield from (
        "For each known object, the paper minimises a function of a weight for each view, w, and for each"
        f" feature, u: {code(symbols.OBJECTIVE)}",
        "",
    )
    if partial := sentences.partial(report):
        yield from (f"**{prose(partial)}**", "")
    yield from (f"**{prose(sentences.outcome(report))}**", "")
    if report.outcome.messages:
        yield from (*(f"- {prose(line)}" for line in report.outcome.messages), "")
    for each in findings.findings(report):
        claims = f" ({', '.join(map(link, each.claims))})" if each.claims else ""
        yield from (f"{marked(each.text)}{claims}", "")


def made(report: Report) -> str:
    """The day and the commit: the only line that may differ between two runs of one seed."""
    day, commit = trust.made(report)
    return f"Run of {prose(day)} UTC, commit {code(commit)}."


def link(key: str) -> str:
    """A claim or part, linked to its evidence on the page."""
    return f"[{prose(key)}]({PAGE}#{sentences.anchor(key)})"


def _right(report: Report) -> Iterator[str]:
    yield from ("## What the paper got right", "")
    if told := findings.structure(report):
        yield from (marked(told), "")
    for claim in findings.right(report):
        yield f"- {marked(claim.statement)} **{_verdict(claim)}** ({link(claim.id)})"
    for part in findings.right_parts(report):
        counts = findings.where_decided(part)
        told = f"**{part.verdict}**" + (f", {prose(counts)}" if counts else "")
        yield f"- {marked(sentences.sentence(part.statement))} {told} ({link(part.key)})"
    yield ""


def _replay(report: Report) -> Iterator[str]:
    settings = report.settings
    yield from ("## How to replay it", "", f"    {' '.join(str(settings['command']).split())}", "")
    yield f"This repeats the run (profile {prose(settings['profile'])}, seed {prose(settings['seed'])})."
    yield "A counterexample is shown iteration by iteration by"
    yield from ("", f"    {sentences.replay('ID')}", "")


def _causes(report: Report) -> Iterator[str]:
    yield from ("## Causes", "", marked(findings.counted_by_cause(report)), "")
    rows = [
        [
            prose(row.cause.name),
            ", ".join(map(link, row.claims)),
            f"{code(row.example.finding)}, {code(sentences.replay(row.example.id))}" if row.example else "-",
            f"{code(row.cause.printed)} should be {code(row.cause.corrected)}".replace("|", "\\|"),
            ", ".join(f"{link(part.key)} **{part.verdict}**" for part in row.corrected) or "-",
        ]
        for row in findings.causes(report)
    ]
    if rows:
        head = ["cause", "claims", "counterexample", "printed and correct", "corrected statement"]
        yield from table(head, rows)
    yield ""


def _ledger(report: Report) -> Iterator[str]:
    yield from ("## The ledger of claims", "")
    verdicts = sentences.met(report)
    head = ["verdict", *(words.VOICES[row.voice][0] for row in report.summary), "meaning"]
    rows = (
        [each, *(row.verdicts[each] for row in report.summary), prose(words.VERDICTS[each])]
        for each in verdicts
    )
    yield from table(head, [*rows, ["all", *(row.claims for row in report.summary), ""]])
    for voice, (title, meaning) in words.VOICES.items():
        if claims := findings.by_voice(report.claims, voice):
            yield from ("", f"### {title}", "", meaning, "")
            yield from table(["id", "verdict", "claim", "why"], map(_row, claims))
    yield ""


def _row(claim: JudgedClaim) -> list[str]:
    place = "" if claim.place == "ours" else f" ({prose(claim.place)})"
    return [
        link(claim.id),
        str(claim.verdict),
        f"{prose(claim.statement)}{place}",
        prose(sentences.why(claim)),
    ]


def _verdict(claim: JudgedClaim) -> str:
    return (
        f"{claim.verdict} {prose(claim.condition)}"
        if claim.verdict is Verdict.HOLDS_UNDER
        else str(claim.verdict)
    )


def _elsewhere(report: Report) -> Iterator[str]:
    yield from ("## More", "")
    told = ", ".join(f"[{name}]({PAGE}#{anchor})" for name, anchor in ELSEWHERE)
    yield f"- [{PAGE}]({PAGE}): {told}."
    if report.experiments is not None:
        yield "- [The experiments](experiments/experiments.html): rules, numbers, figures and pictures."
    yield "- report.json: everything for machines, with the evidence, the settings and all hashes."
    yield from (f"- **Missing in this run:** {prose(what)}" for what in report.missing)
