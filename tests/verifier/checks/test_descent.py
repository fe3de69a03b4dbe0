"""The checks of Algorithm 1 accuse no sound update where float64 steps are small for another reason."""

import numpy as np
import pytest

from verification.checks.descent import Descent
from verification.exact.algorithm import ORDERS
from verification.faults.loop import halved
from verification.ledger.evidence import Outcome
from verification.problems.families import FAMILIES
from verification.problems.sources import Seeded


def observed(index: int, order: str, family: str = "scaled_data") -> dict[str, Outcome]:
    source = Seeded(np.random.default_rng([index, 7]))
    problem = FAMILIES[family](source).problem()
    return {each.part: each.outcome for each in Descent("corrected", order)(problem, source)}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(
    ("index", "part", "outcome"),
    [
        pytest.param(252, "T1c/limit", Outcome.UNDECIDED, id="steps of 1e-10 where 1e9 of them are needed"),
        pytest.param(184, "T1c/descent/{order}", Outcome.UNDECIDED, id="squares of steps that are rounding"),
        pytest.param(1, "T1c/limit", Outcome.HELD, id="ordinary"),
    ],
)
def test_a_sound_update_is_not_accused(index: int, part: str, outcome: Outcome, order: str):
    found = observed(index, order)
    assert found[part.format(order=order)] is outcome, found
    assert Outcome.FAILED not in found.values(), found


@pytest.mark.parametrize("order", ORDERS)
def test_an_update_with_half_the_weights_is(order: str, monkeypatch: pytest.MonkeyPatch):
    halved("solve_w", "solve_u")(monkeypatch)
    found = observed(1, order, "random")
    assert found["T1c/limit"] is found[f"T1b/corrected/{order}"] is Outcome.FAILED, found
