"""Every check: its names are the ledger's, what it says is well-formed, and what it drew can be played again.

What the checks say of the true code is the report run's to judge, which `.ci/run` compares with the committed
report; that they name what is wrong is shown by the mutation test, tests/verifier/faults/test_hunt.py.
"""

from collections import Counter

import numpy as np
import pytest

from verification.checks import catalogue
from verification.checks.catalogue import CHECKS
from verification.checks.interface import Check, Player, Recorder
from verification.exact.algorithm import ORDERS
from verification.ledger.claims import PARTS
from verification.problems.families import FAMILIES, seeded
from verification.problems.sources import Seeded

NAMES = [check.name for check in CHECKS]


def test_names_and_parts_are_those_of_the_ledger():
    assert len(set(NAMES)) == len(NAMES), NAMES
    parts = [part for check in CHECKS for part in check.parts]
    assert set(parts) <= set(PARTS), set(parts) - set(PARTS)
    variants = {
        "absolute": ["absolute"],
        "corrected": ["limit"],
        "smoothed": ["smoothed_descent", "smoothed_distance"],
    }
    assert {
        part: [check.name for check in CHECKS if part in check.parts]
        for part, count in Counter(parts).items()
        if count > 1
    } == {
        f"T1c/{name}": [f"descent {variant} {order}" for order in ORDERS]
        for variant, names in variants.items()
        for name in names
    }, "the ledger states these for both orders of the updates at once"
    assert all(check.families and set(check.families) <= set(FAMILIES) for check in CHECKS), NAMES
    assert all(topic.CHECKS for topic in catalogue.TOPICS)


@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
def test_what_was_drawn_can_be_played_again(check: Check):
    for family in check.families[:3]:
        problem = seeded(family, 9, 1, largest=check.largest)
        rng = np.random.default_rng([8, 1, *family.encode()])
        recorder = Recorder(Seeded(rng, check.largest))
        first = list(check.observe(problem, recorder))
        parts = [each.part for each in first]
        assert len(set(parts)) == len(parts), (family, parts)
        assert set(parts) <= set(check.parts), (family, parts)
        assert all(each.measure >= 0.0 for each in first), (family, first)
        again = list(check.observe(problem, Player(recorder.drawn, check.largest)))
        assert again == first, (family, first, again)
