"""The tables of the report: each row and column shows what its heads name, in HTML and in Markdown."""

import html
import re

import pytest
from made_up import evidence, judged, refutation
from test_report import spelled

from verification.counterexamples.files import catalogue
from verification.ledger.claims import CAUSES, CLAIMS, Voice
from verification.ledger.evidence import Count, Verdict
from verification.problems.families import FAMILIES
from verification.report import words
from verification.report.build import build
from verification.report.contents import Report
from verification.report.markdown import markdown
from verification.report.page import page

NAMES = list(FAMILIES)
PARTS = [part.key for part in CLAIMS["T1a"].parts]
COUNTS = [
    Count(part, family, held=100 + 40 * row + column, failed=row * column % 7, undecided=(row + column) % 3)
    for column, part in enumerate(PARTS)
    for row, family in enumerate(NAMES)
    if (row + column) % 5
]
"""No two cells are alike."""
EVIDENCE = evidence(counts=[*COUNTS, Count("B1/objective", "one_view", skipped=5, held=2)], series={})


@pytest.fixture(scope="module")
def report() -> Report:
    return build(judged(EVIDENCE), {})


@pytest.fixture(scope="module")
def on_page(report: Report) -> str:
    return page(report).decode()


@pytest.fixture(scope="module")
def in_text(report: Report) -> str:
    return markdown(report).decode()


def plain(cell: str) -> str:
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", cell)).split())


def table_on(text: str, caption: str) -> list[list[str]]:
    """The cells of the table whose caption begins so."""
    for found in re.findall(r"<table.*?</table>", text, re.DOTALL):
        if plain(found.partition("<caption>")[2]).startswith(caption):
            rows = re.findall(r"<tr[^>]*>(.*?)</tr>", found, re.DOTALL)
            return [
                [plain(cell) for cell in re.findall(r"<t[hd].*?</t[hd]>", row, re.DOTALL)] for row in rows
            ]
    raise AssertionError(f"no table {caption!r}")


def table_in(text: str, head: str) -> list[list[str]]:
    """The cells of the table whose head begins so."""
    lines = text.partition(f"\n| {head}")[2].partition("\n\n")[0].splitlines()
    rows = [f"{head}{lines[0]}", *(line.removeprefix("| ") for line in lines[2:])]
    return [[plain(cell.replace("\\", "")) for cell in row.removesuffix(" |").split(" | ")] for row in rows]


def shown(part: str, family: str) -> str:
    """What the cell of a part and a family must show."""
    for count in COUNTS:
        if (count.part, count.family) == (part, family):
            decided = count.held + count.failed
            failed = f"{count.failed}/{decided}" if count.failed else f"{decided}"
            return f"{failed} {count.undecided}?" if count.undecided else failed
    return "-"


def short(part: str) -> str:
    """How the head of a column names it."""
    _, name, order = part.split("/")
    return f"{name.replace('_', ' ')} {'GS' if order == 'gauss_seidel' else 'J'}"


def test_the_cases_by_family_stand_in_their_row_and_column(on_page: str) -> None:
    head, *rows = table_on(on_page, "Failed of decided cases of T1a, by family and part")
    assert head == ["family", *(short(part).replace("appendix", "app.") for part in PARTS)]
    assert [row[0] for row in rows] == [name.replace("_", " ") for name in NAMES]
    for family, row in zip(NAMES, rows, strict=True):
        assert row[1:] == [shown(part, family) for part in PARTS], family


def kinds(part: str) -> list[list[Count]]:
    """The counts on random problems, on all others, and on all."""
    own = [count for count in COUNTS if count.part == part]
    random = [count for count in own if count.family == "random"]
    return [random, [count for count in own if count.family != "random"], own]


def test_the_overview_adds_up_random_and_degenerate_families(on_page: str) -> None:
    head, *rows = table_on(on_page, "T1a by update variant: failed of decided cases")
    assert head == ["update variant", "verdict", "random", "degenerate", "all"]
    for part, row in zip(PARTS, rows, strict=True):
        assert row[0] == short(part)
        for counts, cell in zip(kinds(part), row[2:], strict=True):
            failed, held = (sum(getattr(count, name) for count in counts) for name in ("failed", "held"))
            assert cell.split()[0] == (f"{failed}/{failed + held}" if failed else f"{held or '-'}"), (
                part,
                cell,
            )


def test_the_coverage_counts_the_cases_of_each_family(on_page: str) -> None:
    head, *rows = table_on(on_page, "Problems looked at and cases")
    assert head == ["family", "problems", "held", "failed", "undecided", "skipped", "what it is"]
    for name, row in zip(NAMES, rows, strict=True):
        own = [count for count in EVIDENCE.counts if count.family == name]
        numbers = [sum(getattr(count, outcome) for count in own) for outcome in head[2:6]]
        assert row[:2] == [name.replace("_", " "), "-"]
        assert row[2:6] == [f"{number:,}" for number in numbers], name


@pytest.mark.parametrize("voice", Voice)
def test_the_verdicts_stand_with_their_claims_by_who_states_them(
    voice: Voice, report: Report, on_page: str, in_text: str
) -> None:
    title = words.VOICES[voice][0]
    on = table_on(on_page, f"{title} and their verdicts")
    text = table_in(in_text.partition(f"\n### {title}\n")[2], "id | verdict | claim")
    expected = [(claim.id, claim.verdict.value) for claim in report.claims if claim.voice is voice]
    assert [(row[0], row[1]) for row in on[1:]] == expected
    assert [(row[0].partition("]")[0].strip("["), row[1]) for row in text[1:]] == expected
    assert len(expected) > 3, expected
    for row in on[1:]:
        claim = next(claim for claim in report.claims if claim.id == row[0])
        if claim.verdict is Verdict.REFUTED:
            assert all(key in row[3] for key in claim.corrected), row
            assert spelled(claim.parts[0].counterexamples[0].finding)[1:] in spelled(row[3]), row


def test_the_summary_counts_claims_by_verdict_and_voice(report: Report, on_page: str, in_text: str) -> None:
    on, text = table_on(on_page, "Verdicts, their meaning"), table_in(in_text, "verdict | The paper's claims")
    assert on[0] == [each.capitalize() if each == "verdict" else each for each in text[0][:-1]] + ["Meaning"]
    met = [verdict for verdict in Verdict if any(claim.verdict is verdict for claim in report.claims)]
    assert [row[0] for row in on[1:]] == [row[0] for row in text[1:]] == [*map(str, met), "all"]
    for at, voice in enumerate(Voice, 1):
        own = [claim.verdict for claim in report.claims if claim.voice is voice]
        assert on[0][at] == words.VOICES[voice][0]
        assert [row[at] for row in on[1:]] == [*(str(own.count(each) or "-") for each in met), str(len(own))]
        assert [row[at] for row in text[1:]] == [*(str(own.count(each)) for each in met), str(len(own))]


def test_each_cause_stands_with_its_claims_example_and_correction(
    report: Report, on_page: str, in_text: str
) -> None:
    refuted = {
        claim.id for claim in report.claims if claim.verdict is Verdict.REFUTED and claim.voice is Voice.PAPER
    }
    assert refuted == {"D1", "L2", "T1a", "T1b"}
    expected = {
        "the sign of w_i": ["D1", "T1a", "T1b"],
        "the factor 2": ["D1", "T1a", "T1b"],
        "the l1 substitution": ["L2"],
        "exact zeros": ["T1b"],
    }
    on, text = table_on(on_page, "Each cause with"), table_in(in_text, "cause | claims")
    assert len(on) == len(text) == 1 + len(expected)
    for (name, claims), row, line in zip(expected.items(), on[1:], text[1:], strict=True):
        cause = next(each for each in CAUSES.values() if each.name == name)
        assert spelled(row[0]) == spelled(
            f"{cause.name}{cause.statement[0].upper()}{cause.statement[1:]}."
        ) or (spelled(row[0]) == spelled(f"{cause.name}{cause.statement}."))
        assert row[1] == f"{len(claims)}: {', '.join(claims)}"
        assert re.findall(r"\[([A-Z]\d\w?)\]", line[1]) == claims
        assert spelled(cause.printed) in spelled(row[3])
        assert spelled(cause.corrected) in spelled(row[3])
        assert all(key in row[3] and spelled(key) in spelled(line[4]) for key in cause.statements), name


def test_a_cause_shows_the_counterexample_that_it_names() -> None:
    named = {cause.example for cause in CAUSES.values()}
    assert named <= {record.id for record in catalogue()}
    found = [refutation("L2/inequality", name=CAUSES["substitution"].example)]
    made = page(build(judged(evidence(refutations=found, series={})), {})).decode()
    (row,) = table_on(made, "Each cause with")[1:]
    assert f"python -m verification replay {CAUSES['substitution'].example}" in row[2]
    stale = [
        *found,
        refutation("D2/printed", False, CAUSES["factor"].example),
        refutation("D2/printed", True, "other"),
    ]
    made = page(build(judged(evidence(refutations=stale, series={})), {})).decode()
    (factor, _) = table_on(made, "Each cause with")[1:]
    assert factor[2] == "None was confirmed in this run."
