"""Every check: quiet on the true code, on every family; loud on its planted fault; repeatable."""

from collections import Counter
from functools import cache

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from verification.checks import (
    agreement,
    certificates,
    clarabel,
    convexity,
    derivatives,
    features,
    label,
    lemmas,
    objective,
    scaling,
    zeros,
)
from verification.checks.interface import Check, Observation, Player, Recorder
from verification.faults.fault import ORDINARY, Fault
from verification.faults.own import FAULTS
from verification.ledger.claims import PARTS
from verification.ledger.evidence import Outcome
from verification.problems.families import EXTREME, FAMILIES, seeded
from verification.problems.sources import Seeded
from verification.problems.strategies import Drawn

MODULES = (
    agreement, certificates, clarabel, convexity, derivatives, features, label, lemmas, objective, scaling,
    zeros,
)  # fmt: skip
CHECKS: tuple[Check, ...] = tuple(check for module in MODULES for check in module.CHECKS)
NAMES = [check.name for check in CHECKS]
PROBLEMS = 24
"""Problems a family, times the check's share."""
FEWER = 8
"""Problems a family with a fault planted: that it is seen at all is the business of its hunt."""
RARER = 6
"""Problems of extreme families are this many times fewer: their exact referee takes long numbers."""
FALSE = {"D1/printed", "D2/printed", "L2/inequality", "A1/objective", "A2/substitution", "S1/optimal"}
"""Parts that are false as stated: to fail on them is the finding."""


def source_of(family: str, index: int, check: Check) -> Seeded:
    return Seeded(np.random.default_rng([8, index, *family.encode()]), check.largest)


def observed(check: Check, family: str, index: int) -> list[Observation]:
    problem = seeded(family, 9, index, largest=check.largest)
    return list(check.observe(problem, source_of(family, index, check)))


def failures(check: Check, families: tuple[str, ...], count: int) -> dict[str, str]:
    """The first failure of each part."""
    found: dict[str, str] = {}
    for family in families:
        for index in range(count):
            for each in observed(check, family, index):
                if each.outcome is Outcome.FAILED:
                    found.setdefault(each.part, f"{family} {index}: {each.detail}")
    return found


@cache
def failures_of_the_true_code(check: Check, families: tuple[str, ...]) -> dict[str, str]:
    return failures(check, families, FEWER)


def test_names_and_parts_are_those_of_the_ledger():
    assert len(set(NAMES)) == len(NAMES), NAMES
    parts = [part for check in CHECKS for part in check.parts]
    assert set(parts) <= set(PARTS), set(parts) - set(PARTS)
    assert len(set(parts)) == len(parts), Counter(parts).most_common(2)
    assert all(set(check.families) <= set(FAMILIES) for check in CHECKS), NAMES


@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
def test_the_true_code_passes_on_every_family(check):
    outcomes: dict[str, Counter[Outcome]] = {part: Counter() for part in check.parts}
    for family in check.families:
        rarer = RARER if family in EXTREME else 1
        for index in range(max(2, round(PROBLEMS * check.share / rarer))):
            found = observed(check, family, index)
            parts = [each.part for each in found]
            assert len(set(parts)) == len(parts), (family, index, parts)
            for each in found:
                assert 0.0 <= each.measure < np.inf, (family, index, each)
                false = each.outcome is Outcome.FAILED and each.part not in FALSE
                assert not false, (family, index, each)
                outcomes[each.part][each.outcome] += 1
    for part, counts in outcomes.items():
        assert counts[Outcome.HELD] > 0, (part, counts)
        assert (counts[Outcome.FAILED] > 0) == (part in FALSE), (part, counts)


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_a_planted_fault_fails_no_other_part(fault: Fault):
    before = failures_of_the_true_code(fault.check, fault.families)
    with fault.planted():
        after = failures(fault.check, fault.families, FEWER)
    others = set(after) - set(before) - {fault.part, *fault.also}
    assert not others, {part: after[part] for part in others}
    if fault.part not in FALSE or fault.families != ORDINARY:
        assert fault.part not in before, before[fault.part]


def test_every_part_has_a_fault():
    parts = {part for check in CHECKS for part in check.parts}
    without = parts - {fault.part for fault in FAULTS}
    assert without == {"L2/inequality", "A1/objective", "A2/substitution"}, without
    assert without <= FALSE, without


@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
def test_what_was_drawn_can_be_played_again(check):
    for family in check.families[:3]:
        problem = seeded(family, 9, 1, largest=check.largest)
        recorder = Recorder(source_of(family, 1, check))
        first = list(check.observe(problem, recorder))
        again = list(check.observe(problem, Player(recorder.drawn, check.largest)))
        assert again == first, (family, first, again)


@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
def test_hypothesis_may_draw_for_a_check(check):
    @given(st.data(), st.sampled_from(check.families))
    @settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
    def run(data, family):
        source = Drawn(data.draw, check.largest)
        found = list(check.observe(FAMILIES[family](source).problem(), source))
        false = [each for each in found if each.outcome is Outcome.FAILED and each.part not in FALSE]
        assert not false, false

    run()
