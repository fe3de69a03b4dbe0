"""Each family is what its name says, repeats itself, and is legal; the strategies draw the same families."""

import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, find, given, settings
from hypothesis import strategies as st

from convexperc.certificate.rationals import RowSpace
from convexperc.errors import InputError
from convexperc.problem.problem import Problem, same_data
from verification.problems.families import (
    DEGENERATE,
    EXTREME,
    FAMILIES,
    ORDINARY_DEGENERATE,
    RANDOM,
    seeded,
)
from verification.problems.strategies import degenerate_problems, problems, random_problems
from verification.problems.summaries import SUMMARIES

TRIES = range(25)


def holds(family: str, p: Problem) -> bool:
    """The defining property of a family, where it has one that can be read off."""
    zero = [value == 0.0 for value in p.lambdas]
    columns = p.blocks()
    rank = RowSpace.of(p.X).rank
    properties = {
        "zero_row": lambda: not p.X.any(axis=1).all(),
        "zero_modality": lambda: any(not block.any() for block in columns),
        "zero_data": lambda: not p.X.any(),
        "duplicate_rows": lambda: np.array_equal(p.X[0], p.X[1]),
        "near_duplicate_rows": lambda: bool(np.allclose(p.X[0], p.X[1], rtol=2.0**-19, atol=0.0)),
        "rank_deficient": lambda: rank < p.n,
        "zero_target": lambda: not p.o.any(),
        "orthogonal_target": lambda: not (p.X @ p.o).any(),
        "lambda1_zero": lambda: zero == [True, False, False],
        "lambda2_zero": lambda: zero == [False, True, False],
        "lambda3_zero": lambda: zero == [False, False, True],
        "lambda1_lambda2_zero": lambda: zero == [True, True, False],
        "lambda1_lambda3_zero": lambda: zero == [True, False, True],
        "lambda2_lambda3_zero": lambda: zero == [False, True, True],
        "all_lambdas_zero": lambda: all(zero),
        "near_duplicates_without_lambdas": lambda: any(zero) and p.n >= 2,
        "lambda_above_critical": lambda: p.lambda2 >= 2.0 * np.abs(p.X @ p.o).max() * (1 - 1e-12),
        "one_view": lambda: p.n == 1,
        "more_views_than_features": lambda: p.n > p.d,
        "nearly_zero_view": lambda: p.n > p.d and zero[2] and np.abs(p.X).max(axis=1).min() <= 1e-6,
        "one_column_modalities": lambda: set(p.modalities.sizes) == {1},
    }
    return bool(properties.get(family, lambda: True)())


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_is_what_its_name_says(family: str) -> None:
    for index in TRIES:
        p = seeded(family, 1, index)
        assert holds(family, p), (family, index, p, p.X, p.o)
        assert max(p.n / 8, p.d / 60) <= 1, (family, index, p)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_case_repeats_itself_bit_for_bit(family: str) -> None:
    first, again, other = seeded(family, 3, 7), seeded(family, 3, 7), seeded(family, 3, 8)
    assert same_data(first, again), (family, first, again)
    assert not same_data(first, other), (family, first, other)


def test_a_problem_travels_to_a_worker_process() -> None:
    first = seeded("recognition", 0, 0)
    assert first.n != first.d, first
    assert same_data(first, pickle.loads(pickle.dumps(first))), first


def test_the_groups_cover_all_families_once() -> None:
    groups = [*RANDOM, *ORDINARY_DEGENERATE, *EXTREME]
    assert sorted(groups) == sorted(FAMILIES), (groups, list(FAMILIES))
    assert len(DEGENERATE) == len(ORDINARY_DEGENERATE) + len(EXTREME), list(DEGENERATE)
    assert list(SUMMARIES) == list(FAMILIES)
    assert all(SUMMARIES.values()), SUMMARIES


def test_the_scale_families_span_their_decades() -> None:
    sizes = [abs(seeded("extreme_target", 0, i).o).max() for i in range(200)]
    assert min(sizes) < 1e-100, min(sizes)
    assert max(sizes) > 1e100, max(sizes)
    entries = np.concatenate([np.abs(seeded("mixed_scales", 0, i).X).ravel() for i in range(50)])
    positive = entries[entries > 0]
    assert positive.min() < 1e-320, positive.min()
    assert positive.max() > 1e149, positive.max()


def test_near_duplicates_reach_the_last_bit() -> None:
    spreads = set()
    for index in range(200):
        X = seeded("near_duplicate_rows", 0, index).X
        mask = X[1] != 0
        if mask.any():
            spreads.add(float(np.abs(X[0][mask] / X[1][mask] - 1).max()))
    assert any(0 < spread < 2.0**-50 for spread in spreads), sorted(spreads)[:5]
    assert any(spread > 2.0**-30 for spread in spreads), sorted(spreads)[-5:]


@pytest.mark.parametrize("family", FAMILIES)
@settings(max_examples=5, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_a_strategy_draws_its_family(family: str, data: st.DataObject) -> None:
    p = data.draw(problems(family))
    assert holds(family, p), (family, p, p.X, p.o)
    assert max(p.n / 4, p.d / 8) <= 1, p


def test_strategies_shrink_to_small_examples() -> None:
    quiet = settings(
        max_examples=2000, database=None, suppress_health_check=list(HealthCheck), derandomize=True
    )
    p = find(random_problems(), lambda q: q.n >= 2 and bool(q.X.any()), settings=quiet)
    assert (p.n, p.m, np.count_nonzero(p.X), np.count_nonzero(p.o)) == (2, 1, 1, 0), (p, p.X, p.o)
    worst = find(degenerate_problems(), lambda q: q.lambda3 == 0, settings=quiet)
    assert worst.n <= 2, (worst, worst.X)
    assert all(Fraction(x).denominator <= 2 for x in worst.X.flat), worst.X


@pytest.mark.parametrize("family", ["", "nope", "Random"])
def test_an_unknown_family_is_refused_with_the_names(family: str) -> None:
    with pytest.raises(InputError, match="zero_row") as caught:
        problems(family)
    assert caught.value.value == family, caught.value


def test_a_size_too_small_for_the_families_is_refused() -> None:
    with pytest.raises(InputError, match=r"at least \(2, 2\)") as caught:
        problems("random", largest=(1, 5))
    assert caught.value.value == (1, 5), caught.value
