"""The referee of lasso fits: closed forms, Clarabel's optima, and false statements that it must refuse."""

import warnings
from dataclasses import replace
from fractions import Fraction

import cvxpy as cp
import numpy as np
import pytest
from flint import fmpq

from convexperc.lasso import certify_lasso
from verification.lassos.objective import Exact
from verification.lassos.problems import draw
from verification.lassos.referee import optimum, violations


def exact(**changes) -> Exact:
    """One column: (1/2) sum (y - 2 b)^2 + l |b| with y = (3, 1), X = (2, 0)."""
    plain = Exact(
        [[Fraction(2)], [Fraction(0)]], [Fraction(3), Fraction(1)], [Fraction(1)] * 2, [Fraction(1)],
        [Fraction(0)], [], intercept=False, positive=False,
    )  # fmt: skip
    return replace(plain, **changes)


@pytest.mark.parametrize(
    ("changes", "value"),
    [
        ({}, fmpq(15, 8)),  # b = 5/4: (1/4 + 1)/2 + 5/4
        ({"l1": [Fraction(7)]}, fmpq(5)),  # b = 0
        ({"ridge": [Fraction(1)]}, fmpq(5, 2)),  # b = 1: 1/2 + 1/2 + 1 + 1/2
        ({"l1": [Fraction(0)]}, fmpq(1, 2)),  # a free column
        ({"l1": [Fraction(0)], "intercept": True}, fmpq(0)),
        ({"k": [Fraction(0), Fraction(2)]}, fmpq(1)),  # b = 0, as the first sample has no weight
        ({"X": [[Fraction(-2)], [Fraction(0)]], "positive": True}, fmpq(5)),
        ({"l1": [Fraction(0)], "groups": [([0], Fraction(1))]}, fmpq(15, 8)),
    ],
)
def test_optima_in_closed_form(changes, value):
    found = optimum(exact(**changes))
    assert found.tight
    assert found.lower <= value <= found.upper


def clarabel(problem: Exact) -> float:
    X, y, k = (np.array(each, dtype=float) for each in (problem.X, problem.y, problem.k))
    b, b0 = cp.Variable(X.shape[1]), cp.Variable()
    parts = cp.sum(cp.multiply(k, cp.square(y - X @ b - b0))) / 2
    parts += np.array(problem.l1, dtype=float) @ cp.abs(b)
    parts += np.array(problem.ridge, dtype=float) @ cp.square(b) / 2
    for group, c in problem.groups:
        parts += float(c) * cp.norm2(b[group])
    conditions = [b >= 0] if problem.positive else []
    whole = cp.Problem(cp.Minimize(parts), conditions if problem.intercept else [*conditions, b0 == 0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole.solve(solver=cp.CLARABEL)
    return float(whole.value)


def test_optima_are_clarabel_s():
    """On problems of an ordinary scale; Clarabel stops at 1e-8 of its own terms."""
    seen = 0
    for number in range(60):
        problem = draw(11, number).exact
        size = max(abs(float(x)) for row in problem.X for x in row), max(abs(float(y)) for y in problem.y)
        if not (1e-2 < size[0] < 1e2 and 1e-2 < size[1] < 1e2):
            continue
        found = optimum(problem)
        low, high = (float(Fraction(int(end.p), int(end.q))) for end in (found.lower, found.upper))
        target = float(sum(k * y * y for k, y in zip(problem.k, problem.y, strict=True)) / 2)
        best = clarabel(problem)
        assert low - 1e-6 * target <= best <= high + 1e-6 * target, number
        seen += found.tight
    assert seen >= 10


FALSE = [
    (lambda c: {"lower": c.upper * 1.001}, "lower <= P*"),
    (lambda c: {"upper": c.lower * 0.999}, "P* <= upper"),
    (lambda c: {"objective": (c.objective[1] * 1.001, np.inf)}, "objective, from below"),
    (lambda c: {"objective": (0.0, c.objective[0] * 0.999)}, "objective, from above"),
    (lambda c: {"gap": c.gap * 0.3}, "gap"),
    (lambda c: {"relative_gap": c.relative_gap * 0.3}, "relative gap"),
    (lambda c: {"share_of_target": c.share_of_target * 0.3}, "share of the target"),
    (lambda c: {"zero_features": np.ones(3, dtype=bool)}, "b*_0 = 0"),
]


@pytest.mark.parametrize(("change", "told"), FALSE, ids=[told for _, told in FALSE])
def test_a_false_statement_is_refused(change, told):
    """At an answer whose gap is known: X = 1, so that each column is a lasso of its own."""
    X, y = np.eye(3), np.array([3.0, 2.0, 0.5])
    drawn = draw(0, 0)
    b = np.array([1.0, 1.0, 0.0])
    problem = Exact(
        [[Fraction(x) for x in row] for row in X.tolist()], [Fraction(v) for v in y.tolist()],
        [Fraction(2)] * 3, [Fraction(2)] * 3, [Fraction(0)] * 3, [], intercept=False, positive=False,
    )  # fmt: skip
    options = {"convention": "residual sum of squares", "positive": False}
    drawn = replace(drawn, X=X, y=y, coef=b, alpha=2.0, options=options, exact=problem)
    found, truth = certify_lasso(X, y, b, 2.0, **options), optimum(problem)
    assert truth.tight
    assert violations(drawn, found, truth) == []
    assert told in violations(drawn, replace(found, **change(found)), truth)
