"""What decides: the optimum, or the explained fraction; both from proved bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from convexperc import Verdict, decided_by, recognize, recognize_path
from convexperc.errors import DecisionError
from convexperc.recognition.decision import Decision, costs

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.05, "lambda3": 0.05, "modalities": [7, 5]}
SHARE = "explained fraction"


def frame(p: int, seed: int, *, unit: bool = False) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    X, O = rng.random((4, 12)), rng.random((12, p))
    O /= np.linalg.norm(O, axis=0)
    return X / np.linalg.norm(X, axis=1)[:, None], O if unit else O * np.exp(rng.normal(0.0, 1.0, p))


def test_a_short_template_wins_by_its_length_and_loses_by_its_share():
    X, O = frame(2, 0, unit=True)
    O = np.stack([X.mean(axis=0), 0.1 * O[:, 1]], axis=1)
    assert recognize(X, O, **LAMBDAS).label == "object 2"
    found = recognize(X, O, decision=SHARE, **LAMBDAS)
    assert found.label == "object 1"
    assert "explained" in found.reason
    assert not found.warnings
    assert recognize(X, O, **LAMBDAS).warnings


@given(p=st.integers(2, 60), seed=st.integers(0, 10**6), prune=st.booleans())
@settings(deadline=None, max_examples=30)
def test_the_share_decides_as_the_quotient_of_the_optimum_and_the_square_does(p, seed, prune):
    X, O = frame(p, seed)
    found = recognize(X, O, decision=SHARE, prune=prune, **LAMBDAS)
    full = recognize(X, O, prune=False, **LAMBDAS)
    shares = full.answers.upper / np.square(O).sum(axis=0)
    assert found.verdict is Verdict.PROVED
    assert found.label == f"object {shares.argmin() + 1}", shares
    low, high = found.costs
    assert (low <= shares * (1 + 1e-12)).all(), (low, shares)
    solved = ~found.excluded | found.answers.certified
    assert (high[solved] >= shares[solved] * (1 - 1e-8)).all(), (high, shares)
    assert (low <= high).all()
    assert found.template().cost == (low[shares.argmin()], high[shares.argmin()])


@given(p=st.integers(2, 40), seed=st.integers(0, 10**6), prune=st.booleans())
@settings(deadline=None, max_examples=20)
def test_another_decision_on_the_same_answers_is_that_of_a_new_recognition(p, seed, prune):
    X, O = frame(p, seed)
    first = recognize(X, O, prune=prune, **LAMBDAS)
    for decision in Decision:
        again = decided_by(first, decision)
        fresh = recognize(X, O, decision=decision, **LAMBDAS)
        assert (again.label, again.verdict, again.decision) == (fresh.label, fresh.verdict, decision)


@given(seed=st.integers(0, 10**6))
@settings(deadline=None, max_examples=20)
def test_templates_of_one_length_have_one_label_by_either(seed):
    X, O = frame(8, seed, unit=True)
    assert (
        recognize(X, O, **LAMBDAS).label
        == recognize(X, O, decision=Decision.EXPLAINED_FRACTION, **LAMBDAS).label
    )


@pytest.mark.parametrize("scale", [1e-200, 1e-160, 1e-30, 1e30, 1e160])
def test_a_template_of_any_length_is_bounded_or_left_open(scale):
    X, O = frame(3, 1)
    unit = O / np.linalg.norm(O, axis=0)
    O[:, 1] *= scale
    alone = {**LAMBDAS, "lambda2": 0.0, "lambda3": 0.0}
    found = recognize(X, O, decision=SHARE, **alone)
    low, high = found.costs
    same = recognize(X, unit, **alone)
    exact = same.answers.lower
    assert (low <= exact * (1 + 1e-8)).all(), (low, exact)
    assert (exact <= high * (1 + 1e-8)).all(), (high, exact)


def test_a_zero_template_explains_nothing():
    X, O = frame(3, 2)
    O[:, 2] = 0.0
    assert recognize(X, O, **LAMBDAS).label == "object 3"
    found = recognize(X, O, decision=SHARE, **LAMBDAS)
    assert found.label != "object 3"
    assert found.template("object 3").cost == (1.0, 1.0)


def test_where_every_optimum_is_zero_the_shares_tie():
    X, O = frame(3, 3)
    found = recognize(X, O, decision=SHARE, **{**LAMBDAS, "lambda2": 1e3})
    assert found.verdict is Verdict.TIE
    assert (found.costs[1] == 1.0).all()


def test_bounds_are_rounded_outwards():
    third = np.array([1.0]), np.array([1.0])
    low, high = costs(Decision.EXPLAINED_FRACTION, third, (np.array([3.0]), np.array([3.0])))
    assert 3 * low[0] < 1 < 3 * high[0] + 1e-15
    assert low[0] < 1 / 3 < high[0]
    low, high = costs(Decision.EXPLAINED_FRACTION, (np.array([0.0]), np.array([np.inf])), third)
    assert (low[0], high[0]) == (0.0, 1.0)


def test_the_former_name_of_a_decision_is_understood():
    assert Decision.of("explained share") is Decision.EXPLAINED_FRACTION


def test_another_decision_is_refused():
    X, O = frame(2, 0)
    with pytest.raises(
        DecisionError, match="decision must be one of 'objective', 'explained fraction'; got 'best'"
    ):
        recognize(X, O, decision="best", **LAMBDAS)


@pytest.mark.parametrize("decision", list(Decision))
def test_a_path_recognises_as_each_choice_of_the_lambdas_alone_does(decision):
    X, O = frame(40, 4)
    O[:, 7] = O[:, 8]
    grid = [(0.1, 0.0, 0.0), (0.1, 0.1, 0.0), (0.0, 0.1, 0.1), (0.1, 0.1, 0.1), (0.1, 1e3, 0.1)]
    names = tuple(f"thing {j}" for j in range(40))
    path = recognize_path(X, O, grid, modalities=[7, 5], names=names, decision=decision)
    verdicts = set()
    for (lambda1, lambda2, lambda3), found in zip(grid, path, strict=True):
        lambdas = {"lambda1": lambda1, "lambda2": lambda2, "lambda3": lambda3}
        alone = recognize(X, O, modalities=[7, 5], names=names, decision=decision, **lambdas)
        assert (found.label, found.candidates, found.verdict) == (
            alone.label,
            alone.candidates,
            alone.verdict,
        )
        for one, two in zip(found.costs, alone.costs, strict=True):
            assert np.array_equal(one, two), lambdas
        assert np.array_equal(found.answers.w, alone.answers.w), lambdas
        verdicts.add(found.verdict)
    assert verdicts >= {Verdict.PROVED, Verdict.TIE}
