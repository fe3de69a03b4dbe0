"""The first screen, the causes and the proofs say what the run found, and change with it."""

import re

import pytest
from made_up import PROVED, REFUTED, argument, evidence, judged, refutation
from test_report import Page, spelled

from verification.counterexamples.files import catalogue
from verification.counterexamples.given import given
from verification.ledger.claims import CAUSES, CLAIMS, PARTS, Voice
from verification.ledger.evidence import Argument, Checker, Evidence, Step, Verdict
from verification.report import findings, words
from verification.report.build import build
from verification.report.contents import Report
from verification.report.markdown import markdown
from verification.report.page import page
from verification.report.proofs import proofs
from verification.run import series

ALL_PROVED = [argument(key) for key in PROVED] + [
    argument("T1c/descent/jacobi"),
    argument("L1/inequality", "v != 0"),
]


def told(**changes: object) -> Report:
    made: Evidence = evidence(**changes)
    return build(judged(made), {})


def first(report: Report) -> str:
    return " ".join(each.text for each in findings.findings(report))


def without(*parts: str) -> list[object]:
    """The counterexamples of all other parts, and the cases that failed are those of these parts no more."""
    return [refutation(key) for key in REFUTED if key not in parts]


def held(*parts: str) -> dict[str, object]:
    counts = [count for count in evidence().counts if not (count.part in parts and count.failed)]
    return {"counts": counts, "refutations": without(*parts)}


def test_the_theorem_is_called_false_where_a_counterexample_says_so() -> None:
    text = first(told(arguments=ALL_PROVED))
    assert "As printed, this is false. On a counterexample, iteration 1 raises F from 4 to 9." in text
    assert "On another one, it settles at F = 13/16 = 0.8125, although F* = 3/4." in text
    assert "F never rises. Its values then tend to F* provided that lambda1, lambda2, lambda3 > 0" in text


def test_the_smallest_counterexample_is_called_so_where_its_record_says_so() -> None:
    found = refutation("T1a/printed/gauss_seidel")
    smallest = type(found)(
        **vars(found) | {"size": "the smallest in whole numbers", "given": "X = [1], o = [-1]; printed"}
    )
    text = first(told(refutations=[*without("T1a/printed/gauss_seidel"), smallest]))
    assert "On the smallest counterexample, X = [1], o = [-1], iteration 1 raises" in text


@pytest.mark.parametrize(
    ("part", "said", "never"),
    [
        (
            "T1a/printed/gauss_seidel",
            "That the printed update never raises F: supported",
            "raises F from",
        ),
        (
            "T1b/printed/gauss_seidel",
            "That its values tend to F*: supported",
            "settle",
        ),
    ],
)
def test_another_verdict_changes_the_sentence(part: str, said: str, never: str) -> None:
    text = first(told(**held(part)))
    assert said in text
    assert never not in text
    if part.startswith("T1a"):
        assert "In practice" not in text, "nothing is advised against what was not refuted"


def test_of_a_second_counterexample_the_difference_is_told() -> None:
    made = []
    for key, data in (("T1a", "X = [1], o = [-1]; printed"), ("T1b", "X = [1], o = [1]; printed")):
        found = refutation(f"{key}/printed/gauss_seidel")
        made.append(type(found)(**vars(found) | {"given": data}))
    others = without("T1a/printed/gauss_seidel", "T1b/printed/gauss_seidel")
    assert "With o = [1] instead, it settles" in first(told(refutations=[*others, *made]))


def test_a_theorem_that_stands_is_not_called_false() -> None:
    text = first(told(**held("T1a/printed/gauss_seidel", "T1b/printed/gauss_seidel")))
    assert "false" not in text
    assert "That the printed update never raises F: supported" in text


def test_a_repair_that_is_not_proved_is_not_called_so() -> None:
    text = first(told(arguments=[]))
    assert "F never rises." not in text
    assert "that F never rises: supported in this run and supported in this run" in text
    assert "then tend to F*" not in text
    assert "That its values tend to F* provided that lambda1, lambda2, lambda3 > 0" in text
    assert "ever becomes exactly 0: supported in this run" in text
    assert "structure" not in findings.structure(told(arguments=[]))
    assert "descent method" in findings.structure(told(arguments=ALL_PROVED))
    assert "then tend to F*" in first(told(arguments=ALL_PROVED))


def test_the_experiments_are_counted_by_verdict() -> None:
    report = told()
    counted = [claim.verdict for claim in report.claims if claim.surveyed]
    text = first(report)
    assert "Of its 8 claims about them, " in text
    for verdict in set(counted):
        number = counted.count(verdict)
        assert f"{number} {findings.IN_WORDS[verdict][number != 1]}" in text, verdict
    assert "No record of the experiments was available" in first(told(surveys=[]))


def test_a_promise_that_failed_is_said_beside_the_advice() -> None:
    broken = told(refutations=[*without(), refutation("B2/true")])
    assert "the claim that no certificate is false is refuted in this run" in first(broken)
    assert "the claim that no certificate is false" not in first(told())


def test_what_the_paper_got_right_is_what_the_verdicts_say() -> None:
    report = told()
    found = {claim.id for claim in findings.right(report)}
    expected = {
        claim.id
        for claim in report.claims
        if claim.voice is Voice.PAPER
        and claim.verdict.value in ("holds", "holds under", "supported", "reproduced")
    }
    assert found == {key for key in expected if not CLAIMS[key].surveyed} >= {"F1", "L1"}
    text = (
        Page(page(report).decode())
        .text.partition("1. What the paper got right")[2]
        .partition("2. What to trust")[0]
    )
    assert all(spelled(CLAIMS[key].statement) in spelled(text) for key in found)
    assert "X7/hog" in text, "a stated part of a claim that is not right as a whole"
    assert "X6/direction" in text
    assert "X6/two" not in text, "a figure that was not found, although the claim is reproduced"
    assert spelled(CLAIMS["X6"].statement) not in spelled(text)


def test_refuted_claims_are_counted_by_cause_and_one_story_is_called_one() -> None:
    report = told()
    text = findings.counted_by_cause(report)
    assert text.startswith("4 of the paper's claims are refuted. They have 4 causes")
    assert "D1, L2, T1a and T1b are one story and should not be counted as 4 separate faults" in text
    assert findings.counted_by_cause(told(refutations=[], counts=[])) == (
        "No claim of the paper is refuted in this run."
    )
    named = {key for cause in CAUSES.values() for key in cause.statements}
    assert named <= set(PARTS)
    assert {cause for claim in CLAIMS.values() for cause in claim.causes} == set(CAUSES)


def test_each_step_is_shown_once_and_linked_from_where_it_is_used_again() -> None:
    shared = Step("shared: a = b", Checker.IDENTITY, True, "a: both sides")
    alike = Step("shared: a = b", Checker.IDENTITY, True, "b: another source")
    single = Step("single: c = d", Checker.EXACT, True, "c = 1")
    made = [
        Argument("F1/convex", "one", "", (shared, single)),
        Argument("F1/bounded", "two", "a > 0", (shared, alike)),
    ]
    report = told(arguments=made, series={})
    found = proofs(report)
    assert (found.uses, len(found.steps), found.by_checker) == (4, 3, {Checker.IDENTITY: 2, Checker.EXACT: 1})
    text = page(report).decode().partition('<section id="proofs">')[2].partition("</section>")[0]
    assert text.count('id="step-shared"') == text.count('href="#step-shared"') == 1
    assert text.count('id="step-shared-2"') == text.count('id="step-single"') == 1
    assert text.count("both sides") == text.count("another source") == 1
    assert "Together they have 4 steps, of which 3 are different" in " ".join(Page(text).text.split())
    whole = page(report).decode()
    assert set(re.findall(r'href="#(proof-\d+)"', whole)) == set(re.findall(r'id="(proof-\d+)"', whole))


def test_the_figure_draws_the_counterexample_that_the_first_sentence_tells() -> None:
    record = next(each for each in catalogue() if each.id == CAUSES["sign"].example)
    drawn = series.counterexample()
    F = drawn["runs"]["printed"]
    data, _, how = given(record).partition("; ")
    assert data == "X = [1], o = [-1], lambda1 = 1, lambda2 = 1, lambda3 = 0"
    assert how.startswith("printed update, Gauss-Seidel")
    assert drawn["title"] == "n = d = 1, X = 1, o = -1, lambda1 = 1, lambda2 = 1, lambda3 = 0"
    assert F[0] == 1.0
    assert F[1] == pytest.approx(57 / 49, rel=1e-14)
    assert sorted(F) == F, "the printed update raises F again and again"
    falls = drawn["runs"]["corrected"]
    assert falls == sorted(falls, reverse=True)
    lower, upper = drawn["F_star"]
    assert lower <= 0.75 <= upper


def test_the_text_is_short_and_leads_to_the_page() -> None:
    text = markdown(told()).decode()
    assert len(text.encode()) < 40_000
    assert "2\\*a\\*b" not in text, "no steps"
    ids = set(Page(page(told()).decode()).ids)
    linked = set(re.findall(r"\]\(report\.html#([^)]*)\)", text))
    assert linked <= ids, linked - ids
    assert set(CLAIMS) <= linked
    assert words.LINK in text


def test_every_verdict_has_words_and_a_tone() -> None:
    assert set(words.VERDICTS) == set(words.TONES) == set(Verdict)
    surveyed = {Verdict.REPRODUCED, Verdict.DEPENDS, Verdict.NOT_REPRODUCED, Verdict.OPPOSITE}
    assert surveyed <= set(findings.IN_WORDS)
