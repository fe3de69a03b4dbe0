"""The optima of single views, added up: against problems solved one by one, and in exact numbers."""

from fractions import Fraction

import numpy as np
import pytest

from convexperc import Problem, TemplateLibrary, recognize, solve
from convexperc.problem.reduction import Reduction
from convexperc.recognition import EachView

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}


def scene(seed: int, n: int = 3, scale: float = 1.0) -> tuple[np.ndarray, TemplateLibrary]:
    rng = np.random.default_rng(seed)
    X, O = scale * rng.random((n, 7)), scale * rng.random((7, 6))
    return X, TemplateLibrary(O, objects=["a", "b", "c"] * 2, modalities=[4, 3])


@pytest.mark.parametrize("seed", range(8))
def test_the_sum_is_that_of_the_lowest_optima_of_every_view(seed):
    X, library = scene(seed, n=1 + seed % 4)
    found = recognize(X, library, **LAMBDAS)
    every = EachView.of(found)
    lower, upper = every.costs
    sums = {}
    for place, name in enumerate(library.objects):
        ends = [
            [
                solve(Problem(x[None], library.O[:, j], **LAMBDAS, modalities=[4, 3])).certificate
                for j in (library.owners == place).nonzero()[0]
            ]
            for x in X
        ]
        low = sum(min(each.lower for each in view) for view in ends)
        high = sum(min(each.upper for each in view) for view in ends)
        sums[name] = high
        assert lower[place] <= high * (1 + 1e-12)
        assert low <= upper[place] * (1 + 1e-12)
        assert upper[place] - lower[place] <= 1e-8 * high
    assert every.label == min(sums, key=sums.__getitem__)
    assert every.views == found.views
    assert [alone.views for alone in every.recognitions] == [(name,) for name in found.views]


def test_the_sums_are_rounded_outwards():
    X, library = scene(1, n=9, scale=1e-3)
    every = EachView.of(recognize(X, library, **LAMBDAS))
    owners = library.owners
    for side, compare in ((0, Fraction.__le__), (1, Fraction.__ge__)):
        for place in range(3):
            parts = (found.costs[side][owners == place].min() for found in every.recognitions)
            exact = sum((Fraction(float(part)) for part in parts), Fraction(0))
            assert compare(Fraction(float(every.costs[side][place])), exact)


def test_one_view_of_another_object_decides_the_papers_rule_and_not_the_sum():
    O = np.eye(8)[:, :2]
    seen = 0.6 * O[:, 0] + 0.35 * np.eye(8)[:, 4]
    X = np.array([seen, seen, seen, O[:, 1]])
    found = recognize(X, {"in view": O[:, 0], "elsewhere": O[:, 1]}, **{**LAMBDAS, "lambda2": 0.3})
    assert found.label == "elsewhere"
    every = EachView.of(found)
    assert every.label == "in view"
    assert [alone.label for alone in every.recognitions] == ["in view"] * 3 + ["elsewhere"]
    lower, upper = every.margin
    assert 0.0 < lower <= upper < 1.0


def test_what_is_equal_has_no_label_and_one_object_no_margin():
    o, X = np.arange(1.0, 6.0), np.ones((2, 5))
    tied = EachView.of(recognize(X, {"a": o, "b": o}, **LAMBDAS))
    assert (tied.label, tied.candidates) == (None, ("a", "b"))
    alone = EachView.of(recognize(X, {"a": o}, **LAMBDAS))
    assert (alone.label, alone.margin) == ("a", None)


def test_a_sum_beyond_float64_is_bounded_by_infinity():
    X = np.array([[1.0, 0], [0, 1], [1, 1]])
    lambdas = {"lambda1": 0.1, "lambda2": 1e300, "lambda3": 1e300}
    every = EachView.of(recognize(X, {"a": [1.2e154, 0], "b": [0, 1.3e154]}, **lambdas))
    lower, upper = every.costs
    assert np.isfinite(lower).all()
    assert np.isinf(upper).all()
    assert (every.label, every.candidates) == (None, ("a", "b"))


def test_lambdas_and_decision_are_those_of_the_recognition():
    X, library = scene(3)
    found = recognize(X, library, lambda1=0.3, lambda2=0.02, lambda3=0.4, decision="explained fraction")
    every = EachView.of(found)
    for alone in every.recognitions:
        assert alone.answers.lambdas == found.answers.lambdas
        assert alone.decision is found.decision
        assert alone.answers.certified.all()


def test_the_library_is_not_multiplied_again(monkeypatch):
    X, library = scene(4)
    found = recognize(X, library, **LAMBDAS)
    monkeypatch.setattr(Reduction, "product", None)
    every = EachView.of(found)
    monkeypatch.undo()
    for alone, x in zip(every.recognitions, X, strict=True):
        wanted = recognize(x[None], library, **LAMBDAS, prune=False)
        np.testing.assert_allclose(alone.costs, wanted.costs, rtol=1e-8)


@pytest.mark.parametrize("exponent", [-900, -90, 90, 900])
def test_views_of_other_sizes_are_as_each_alone(exponent):
    """A view far smaller or larger than the others; beyond 2^100 the products of all are not used."""
    X, library = scene(5)
    X[1] *= 2.0**exponent
    found = recognize(X, library, **LAMBDAS)
    for alone, x in zip(EachView.of(found).recognitions, X, strict=True):
        lower, upper = recognize(x[None], library, **LAMBDAS, prune=False).costs
        assert (alone.costs[0] <= upper).all()
        assert (lower <= alone.costs[1]).all()
        np.testing.assert_allclose(alone.costs, (lower, upper), rtol=1e-8)


def test_views_that_do_not_change_stay_as_they_are_for_a_single_one():
    """Products that an earlier recognition made serve as well."""
    X, library = scene(6, n=4)
    first = recognize(X, library, **LAMBDAS)
    X = X.copy()
    X[2] *= 0.5
    found = recognize(X, library, start=first, **LAMBDAS)
    wanted = EachView.of(recognize(X, library, **LAMBDAS))
    np.testing.assert_allclose(EachView.of(found).costs, wanted.costs, rtol=1e-8)
