"""The tables of the report: each row and column shows what its heads name, in HTML and in Markdown."""

import html
import re

import pytest
from made_up import evidence, judged

from verification.ledger.claims import CLAIMS, Role
from verification.ledger.evidence import Count, Verdict
from verification.problems.families import FAMILIES
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
            rows = re.findall(r"<tr>(.*?)</tr>", found, re.DOTALL)
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


def test_the_text_names_the_families_in_which_a_part_fails(in_text: str) -> None:
    head, *rows = table_in(in_text, "part | verdict | random")
    assert head[-1] == "failed of decided, by family"
    for part, row in zip(PARTS, rows, strict=True):
        failing = [
            f"{count.family.replace('_', ' ')} {count.failed}/{count.failed + count.held}"
            for count in kinds(part)[2]
            if count.failed
        ]
        assert row[0] == part
        assert row[-1] == (", ".join(failing) or "none"), part


def test_the_coverage_counts_the_cases_of_each_family(on_page: str, in_text: str) -> None:
    on, text = table_on(on_page, "Problems looked at and cases"), table_in(in_text, "family | problems")
    assert on[0] == text[0] == ["family", "problems", "held", "failed", "undecided", "skipped", "what it is"]
    for name, row, line in zip(NAMES, on[1:], text[1:], strict=True):
        own = [count for count in EVIDENCE.counts if count.family == name]
        numbers = [sum(getattr(count, outcome) for count in own) for outcome in on[0][2:6]]
        assert row[:2] == [name.replace("_", " "), "-"]
        assert line[:2] == [name, "-"]
        assert row[2:6] == [f"{number:,}" for number in numbers], name
        assert line[2:6] == [str(number) for number in numbers], name


def test_the_verdicts_stand_with_their_claims(report: Report, on_page: str, in_text: str) -> None:
    on, text = table_on(on_page, "Every claim, where it stands"), table_in(in_text, "id | verdict | claim")
    expected = [(claim.id, claim.verdict.value) for claim in report.claims]
    assert [(row[0], row[1]) for row in on[1:]] == expected
    assert [(row[0], row[1]) for row in text[1:]] == expected
    assert len({verdict for _, verdict in expected}) > 3, expected


def test_the_summary_counts_claims_by_subject_and_verdict(report: Report, on_page: str, in_text: str) -> None:
    on, text = table_on(on_page, "Number of claims by subject"), table_in(in_text, "claims about")
    assert on[0][1:] == text[0][1:] == [*(verdict.value for verdict in Verdict), "all"]
    subjects = list(dict.fromkeys(claim.subject for claim in report.claims))
    for subject, row, line in zip(subjects, on[1:], text[1:], strict=True):
        own = [claim.verdict for claim in report.claims if claim.subject is subject]
        numbers = [*(own.count(verdict) for verdict in Verdict), len(own)]
        assert row == [subject.value, *(str(number or "-") for number in numbers)]
        assert line == [subject.value, *map(str, numbers)]


def test_each_refuted_claim_stands_with_its_own_counterexample_and_correction(
    report: Report, in_text: str
) -> None:
    block = in_text.partition("### Refuted claims")[2].partition("\n## ")[0].replace("\\", "")
    for claim in report.claims:
        entry = block.partition(f"\n- **{claim.id}** (")[2].partition("\n- **")[0]
        assert bool(entry) == (claim.verdict is Verdict.REFUTED), claim.id
        if entry and claim.parts[0].rule is None:
            named = set(re.findall(r"replay ([a-z0-9-]+)", entry))
            stated = [part for part in claim.parts if part.role is Role.STATED and part.counterexamples]
            assert named == {part.counterexamples[0].id for part in stated}, claim.id
            assert set(re.findall(r"Corrected statement: ([^ ]+)", entry)) == set(claim.corrected), claim.id
