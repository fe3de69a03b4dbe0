"""The rule from evidence to verdict, the baseline and the exit codes; planted inconsistencies are caught."""

import json
from dataclasses import replace

import pytest
from made_up import argument, evidence, refutation, verdicts

from convexperc.errors import FileFormatError
from verification.ledger.baseline import assess, baseline_file, compare, read_baseline
from verification.ledger.claims import CLAIMS, PARTS, Role
from verification.ledger.evidence import Argument, Checker, Count, Evidence, Step, Verdict
from verification.ledger.verdicts import ContradictionError, judge, judge_all, judge_part, trust_base
from verification.problems.families import FAMILIES

CASES = 250 * len(FAMILIES) + 1
"""Of one part in the made-up evidence, with one that fails."""

PART = "T1c/limit"
HELD = Count(PART, "random", held=40)
OPEN = Count(PART, "random", held=40, undecided=3)
FAILED = Count(PART, "one_view", held=5, failed=2)
PROOF, UNDER, BROKEN = argument(PART), argument(PART, "no entry is 0"), argument(PART, passed=False)
OTHER = argument(PART, "n = 1")
CITED = Argument(PART, "so", "", (Step("so", Checker.CITED, True, "a book"),))
FOUND, STALE = refutation(PART), refutation(PART, confirmed=False)

RULE = {
    "nothing": ([], [], [], Verdict.INCONCLUSIVE, "no case was decided"),
    "only undecided": (
        [Count(PART, "random", undecided=9)],
        [],
        [],
        Verdict.INCONCLUSIVE,
        "9 cases undecided",
    ),
    "only skipped": ([Count(PART, "random", skipped=9)], [], [], Verdict.INCONCLUSIVE, "no case was decided"),
    "cases": ([HELD], [], [], Verdict.SUPPORTED, "tested on 40 cases without a failure"),
    "cases, some undecided": ([OPEN], [], [], Verdict.SUPPORTED, "3 cases undecided"),
    "an argument": (
        [],
        [PROOF],
        [],
        Verdict.HOLDS,
        "written proof: 2 steps checked (1 exact identity, 1 by z3 and cvc5), 1 cited theorem, 1 joint in"
        " prose (docs/theorem.md 0)",
    ),
    "an argument and cases": ([HELD], [PROOF], [], Verdict.HOLDS, "tested on 40 cases without a failure"),
    "two arguments on conditions": (
        [],
        [UNDER, OTHER],
        [],
        Verdict.HOLDS_UNDER,
        "written proof: 4 steps checked",
    ),
    "an argument on a condition": ([HELD], [UNDER], [], Verdict.HOLDS_UNDER, "written proof: 2 steps"),
    "two arguments": (
        [],
        [UNDER, PROOF],
        [],
        Verdict.HOLDS,
        "4 steps checked (2 exact identities, 2 by z3 and cvc5), 2 cited theorems, 2 joints in prose",
    ),
    "a failed step": ([], [BROKEN], [], Verdict.INCONCLUSIVE, "an argument failed at: product"),
    "a failed step, cases": ([HELD], [BROKEN], [], Verdict.SUPPORTED, "an argument failed at: product"),
    "one of two arguments failed": ([HELD], [PROOF, BROKEN], [], Verdict.SUPPORTED, "an argument failed"),
    "nothing but citations": ([HELD], [CITED], [], Verdict.SUPPORTED, "no step that a machine checked"),
    "failures, unconfirmed": (
        [HELD, FAILED],
        [],
        [],
        Verdict.INCONCLUSIVE,
        "2 failures in 47 cases, none conf",
    ),
    "failures of what was proved": (
        [FAILED],
        [PROOF],
        [],
        Verdict.INCONCLUSIVE,
        "although its argument passed",
    ),
    "failures, stale record": ([FAILED], [], [STALE], Verdict.INCONCLUSIVE, "stale: t1c-limit"),
    "a counterexample": ([HELD], [], [FOUND], Verdict.REFUTED, "counterexample t1c-limit: 1 > 0"),
    "a counterexample, failures": ([FAILED], [], [FOUND], Verdict.REFUTED, "2 of 7 cases tried failed"),
    "two counterexamples": ([], [], [FOUND, refutation(PART, name="b")], Verdict.REFUTED, "1 more confirmed"),
    "a counterexample beside the condition": (
        [],
        [UNDER],
        [FOUND],
        Verdict.REFUTED,
        "yet it holds under: no entry",
    ),
    "a counterexample, a failed argument": ([], [BROKEN], [FOUND], Verdict.REFUTED, "counterexample"),
    "a stale record": ([HELD], [], [STALE], Verdict.SUPPORTED, "stale: t1c-limit"),
    "a stale record, nothing else": ([], [], [STALE], Verdict.INCONCLUSIVE, "stale: t1c-limit"),
}


@pytest.mark.parametrize("case", RULE)
def test_the_rule_for_a_part(case):
    counts, arguments, refutations, verdict, reason = RULE[case]
    other = [Count("B1/dual", "random", held=1, failed=1)], [argument("B1/dual")], [refutation("F1/convex")]
    found = judge_part(
        PARTS[PART], Evidence({}, [*counts, *other[0]], [*arguments, *other[1]], [*refutations, *other[2]])
    )
    assert found.verdict is verdict, found
    assert reason in found.reason, found
    assert bool(found.condition) == (verdict is Verdict.HOLDS_UNDER), found


def test_joints_of_two_pages_are_told_page_by_page():
    places = ("docs/theorem.md 0", "docs/reweighted-theorem.md 2", "docs/theorem.md 2.1")
    steps = [Step(f"{n}: so", Checker.PROSE, True, place) for n, place in enumerate(places)]
    told = "3 joints in prose (docs/reweighted-theorem.md 2; docs/theorem.md 0, 2.1)"
    assert trust_base(steps) == f"0 steps checked, {told}"


def test_one_of_the_conditions_is_enough():
    found = judge_part(PARTS[PART], Evidence(arguments=[UNDER, OTHER]))
    assert found.condition == "no entry is 0 or n = 1", found


def test_a_proof_and_a_counterexample_of_one_part_contradict_each_other():
    both = Evidence(arguments=[PROOF], refutations=[FOUND])
    for call in (lambda: judge_part(PARTS[PART], both), lambda: judge_all(both)):
        with pytest.raises(ContradictionError, match=r"T1c/limit.*t1c-limit.*disagrees with itself"):
            call()
    stale = Evidence(arguments=[PROOF], refutations=[STALE])
    assert judge_part(PARTS[PART], stale).verdict is Verdict.HOLDS


def test_what_no_record_speaks_of_cannot_be_tested_whatever_is_claimed():
    found = judge_part(PARTS["X1/direction"], Evidence(counts=[Count("X1/direction", "random", held=9)]))
    assert found.verdict is Verdict.NOT_TESTABLE, found
    assert "python -m verification experiments" in found.reason, found
    assert judge(CLAIMS["X8"], Evidence()) == found


def of_claim(identity, **by_part):
    """The verdict on a claim whose stated parts have this evidence, in their order."""
    stated = [part.key for part in CLAIMS[identity].parts if part.role is Role.STATED]
    made = Evidence()
    for key, what in zip(stated, by_part.values(), strict=True):
        if what == "case":
            made.counts.append(Count(key, "random", held=1))
        elif what == "counterexample":
            made.refutations.append(refutation(key))
        elif what is not None:
            made.arguments.append(argument(key, what))
    return judge(CLAIMS[identity], made)


@pytest.mark.parametrize(
    ("parts", "verdict", "reason"),
    [
        (("", "", ""), Verdict.HOLDS, "the verdict on all 3 stated parts"),
        (("", "w > 0", ""), Verdict.HOLDS_UNDER, "the weakest of 3 stated parts: F1/bounded"),
        (("", "w > 0", "case"), Verdict.SUPPORTED, "the weakest of 3 stated parts: F1/attained"),
        (("", None, "case"), Verdict.INCONCLUSIVE, "F1/bounded"),
        ((None, None, "counterexample"), Verdict.REFUTED, "F1/attained (1 of 3 stated parts)"),
    ],
)
def test_a_claim_is_refuted_or_as_weak_as_its_weakest_stated_part(parts, verdict, reason):
    found = of_claim("F1", a=parts[0], b=parts[1], c=parts[2])
    assert found.verdict is verdict, found
    assert reason in found.reason, found
    assert found.condition == ("w > 0" if verdict is Verdict.HOLDS_UNDER else ""), found


def test_other_readings_and_repairs_decide_no_claim():
    readings = [part.key for part in CLAIMS["T1a"].parts if part.role is not Role.STATED]
    made = Evidence(
        counts=[Count("T1a/printed/gauss_seidel", "random", held=1)],
        refutations=[refutation(key) for key in readings],
    )
    assert judge(CLAIMS["T1a"], made).verdict is Verdict.SUPPORTED


def test_a_refuted_claim_names_its_corrected_statement_and_the_verdict_on_it():
    own = judge(
        CLAIMS["D1"],
        Evidence(arguments=[argument("D1/corrected", "w_i != 0")], refutations=[refutation("D1/printed")]),
    )
    assert "corrected statement: D1/corrected holds under w_i != 0" in own.reason
    stated = refutation("T1a/printed/gauss_seidel")
    elsewhere = judge(
        CLAIMS["T1a"], Evidence(arguments=[argument("T1c/descent/jacobi")], refutations=[stated])
    )
    assert "T1c/descent/gauss_seidel inconclusive, T1c/descent/jacobi holds" in elsewhere.reason
    bare = replace(CLAIMS["S1"], repaired_by=())
    without = judge(bare, Evidence(refutations=[refutation("S1/optimal")]))
    assert "corrected statement: none is stated" in without.reason


def outcome(found, baseline):
    return assess(found, judge_all(found), baseline)


def without(part):
    return [count for count in evidence().counts if count.part != part]


def failing(part):
    return [*evidence().counts, Count(part, "random", failed=1)]


def plus(part, confirmed=True, name=""):
    return [*evidence().refutations, refutation(part, confirmed, name)]


def flipped(part):
    """Surveys in which configurations that reproduced a part show the opposite."""
    return [
        replace(
            each, tally=each.tally._replace(reproduced=each.tally.opposite, opposite=each.tally.reproduced)
        )
        if each.part == part
        else each
        for each in evidence().surveys
    ]


def broken(part):
    """The arguments, with that of one part failed."""
    return [each if each.part != part else argument(part, passed=False) for each in evidence().arguments]


EXPECTED = verdicts(evidence())
EXITS = {
    "equal": ({}, 0, ""),
    "a proof was lost": ({"arguments": []}, 1, "D1/corrected: supported, the baseline says holds"),
    "a proof failed, and no case was run": (
        {"arguments": broken("D1/corrected"), "counts": without("D1/corrected")},
        1,
        "D1/corrected: inconclusive, the baseline says holds",
    ),
    "a counterexample was lost": (
        {"refutations": []},
        1,
        "D1/printed: inconclusive, the baseline says refuted",
    ),
    "a new counterexample": ({"refutations": plus("F2/conic")}, 1, "F2/conic: refuted"),
    "unconfirmed failures": ({"counts": failing("F2/conic")}, 1, "F2/conic: inconclusive, the baseline says"),
    "a stale record": ({"refutations": plus("D1/printed", False, "old")}, 1, "record old no longer fails"),
    "a failed promise": ({"counts": failing("B2/true")}, 1, f"B2/true: 1 of {CASES:,} cases failed"),
    "a refuted promise": ({"refutations": plus("B4/tie")}, 1, "B4/tie: 1 > 0"),
    "a family was not reached": ({"missing": ["family one_view"]}, 3, "missing: family one_view"),
    "a part was not run": ({"counts": without("F2/conic")}, 3, "F2/conic: inconclusive, the baseline says"),
    "no record of the experiments": (
        {"surveys": []},
        3,
        "X1: not testable here, the baseline says reproduced",
    ),
    "another record": (
        {"surveys": flipped("X1/direction")},
        1,
        "X1/direction: opposite found, the baseline says reproduced",
    ),
    "both": ({"missing": ["family one_view"], "arguments": []}, 1, "missing: family one_view"),
}


@pytest.mark.parametrize("case", EXITS)
def test_the_exit_code_and_what_it_names(case):
    changes, code, message = EXITS[case]
    found = outcome(evidence(**changes), EXPECTED)
    assert found.code == code, found
    assert message in "\n".join(found.messages), found


def test_a_failing_promise_is_no_news_for_the_baseline_but_for_the_exit_code():
    made = evidence(counts=failing("B2/true"))
    assert outcome(made, verdicts(made)).code == 1


def test_an_open_part_that_the_baseline_lists_as_open_is_expected():
    made = evidence(counts=without("F2/conic"))
    assert outcome(made, verdicts(made)).code == 0
    fresh = {key: verdict for key, verdict in verdicts(made).items() if key != "F2/conic"}
    found = outcome(made, fresh)
    assert (found.code, found.messages) == (3, ("F2/conic: inconclusive, the baseline says not listed",))


def test_a_part_that_the_baseline_or_the_ledger_lacks_is_a_change():
    judged = judge_all(evidence())
    fewer = {key: verdict for key, verdict in EXPECTED.items() if key != "F1/convex"}
    assert [str(each) for each in compare(judged, fewer)] == [
        "F1/convex: holds, the baseline says not listed"
    ]
    more = EXPECTED | {"F1/gone": Verdict.HOLDS}
    assert [str(each) for each in compare(judged, more)] == ["F1/gone: not listed, the baseline says holds"]
    assert outcome(evidence(), more).code == 1


def test_the_baseline_comes_back_and_the_committed_one_covers_the_ledger(tmp_path):
    path = tmp_path / "baseline.json"
    path.write_bytes(baseline_file(judge_all(evidence())))
    assert read_baseline(path) == EXPECTED
    assert list(read_baseline()) == [*CLAIMS, *PARTS]


@pytest.mark.parametrize(
    ("content", "needed"),
    [
        ("{", "baseline.json"),
        ("[]", "must map claims and parts"),
        ('{"schema": "other", "claims": {}, "parts": {}}', "must be 'convexperc/baseline/1'"),
        ('{"schema": "convexperc/baseline/1", "claims": {}}', "parts"),
        ('{"schema": "convexperc/baseline/1", "claims": {"F1": "true"}, "parts": {}}', "'true'"),
        ('{"schema": "convexperc/baseline/1", "claims": [], "parts": []}', "must map claims and parts"),
    ],
)
def test_a_file_that_is_no_baseline_is_refused(tmp_path, content, needed):
    path = tmp_path / "baseline.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_baseline(path)
    assert needed in str(caught.value), caught.value
    with pytest.raises(FileFormatError, match="No such file"):
        read_baseline(tmp_path / "none.json")


def test_judging_is_the_same_for_evidence_that_was_stored():
    made = evidence()
    back = Evidence.from_json(json.loads(json.dumps(made.as_json())))
    assert judge_all(back) == judge_all(made)
