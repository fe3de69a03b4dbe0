"""F over the rationals, for the tests. Nothing here calls a formula of the package."""

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

BITS = 400


def fractions(values: Any) -> Any:
    """Floats, or arrays of floats, as the rationals that they are."""
    if np.ndim(values) == 0:
        return Fraction(float(values))
    return [fractions(value) for value in values]


def root_bounds(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose sqrt(square) by rationals about 2^-400 apart, relatively."""
    if square == 0:
        return Fraction(0), Fraction(0)
    shift = 2 * max(0, BITS - square.numerator.bit_length() + square.denominator.bit_length())
    low = math.isqrt((square.numerator << shift) // square.denominator)
    scale = Fraction(1, 2 ** (shift // 2))
    return low * scale, (low + 1) * scale


def inner(x: Sequence[Fraction], y: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(x, y, strict=True)), Fraction(0))


def transposed(X: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    return [list(column) for column in zip(*X, strict=True)]


def term_bounds(
    X: NDArray[np.float64],
    o: NDArray[np.float64],
    groups: Sequence[Sequence[int]],
    lambdas: Sequence[float],
    point: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> tuple[Fraction, Fraction, Fraction, tuple[Fraction, Fraction]]:
    """The four terms of F at a point; the last one, a sum of roots, as (lower, upper)."""
    (l1, l2, l3), w, u = fractions(lambdas), fractions(point[0]), fractions(point[1])
    rows = fractions(X)
    p = [inner(column, w) - target for column, target in zip(transposed(rows), fractions(o), strict=True)]
    q = [inner(row, u) - weight for row, weight in zip(rows, w, strict=True)]
    roots = [root_bounds(inner([u[j] for j in group], [u[j] for j in group])) for group in groups]
    norms = l3 * sum((low for low, _ in roots), Fraction(0)), l3 * sum((r[1] for r in roots), Fraction(0))
    return inner(p, p), l1 * inner(q, q), l2 * sum(map(abs, w), Fraction(0)), norms


def objective_bounds(*problem_and_point: Any) -> tuple[Fraction, Fraction]:
    """F at a point as (lower, upper); arguments as for `term_bounds`."""
    loss, coupling, views, (low, high) = term_bounds(*problem_and_point)
    return loss + coupling + views + low, loss + coupling + views + high


def smallest_scalar(o: Fraction, lambdas: Sequence[Fraction]) -> tuple[Fraction, Fraction, Fraction]:
    """The exact optimum (w, u, F) of n = d = 1, X = 1, o >= 0.

    For a given w the best u leaves lambda1 w^2 below |w| = lambda3 / (2 lambda1) and a straight line above.
    """
    l1, l2, l3 = lambdas
    w, u = max(Fraction(0), (o - l2 / 2) / (1 + l1)), Fraction(0)
    if 2 * l1 * w > l3:
        w = o - (l2 + l3) / 2
        u = w - l3 / (2 * l1)
    if l1 == 0:
        w = max(Fraction(0), o - l2 / 2)
    return w, u, (w - o) ** 2 + l1 * (u - w) ** 2 + l2 * abs(w) + l3 * abs(u)
