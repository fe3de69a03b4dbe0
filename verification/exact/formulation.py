"""F, its dual D and dual feasibility over the rationals: a second derivation.

It reads the data of a `Problem` and uses no formula of `convexperc`. All sums run over integers with one
denominator; F is also defined at balls, where the same formula gives an enclosure of F over all of a box.
"""

from collections.abc import Iterable
from fractions import Fraction
from operator import mul
from typing import Any

import numpy as np
from flint import arb, fmpq, fmpq_mat

from convexperc.errors import InputError
from convexperc.problem.problem import Problem
from verification.exact import balls
from verification.exact.balls import enclosed, exact, root
from verification.exact.numbers import (
    ROOT_BITS,
    Enclosure,
    Entries,
    Rational,
    inner,
    integers,
    square_root,
    total,
)
from verification.exact.problem import ExactProblem

Point = Entries | balls.Numbers
"""A vector of floats, of Fractions, or of FLINT's rationals and balls."""

Over = tuple[list[Any], int]
"""A vector as integers, or as balls, over one denominator; that of balls is 1."""


def objective(problem: Problem | ExactProblem, w: Point, u: Point, *, bits: int = ROOT_BITS) -> Enclosure:
    """Enclose F(w, u): exactly unless the norm of a modality is irrational or an entry is a ball.

    Formula: ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||.

    Parameters
    ----------
    problem : Problem or ExactProblem
    w, u : floats, Fractions or FLINT's numbers (n,), (d,)
        Where balls are among them F is enclosed over all of the box, with the precision of their context.
    bits : int
        Of irrational norms at rational points.

    Raises
    ------
    UnresolvedError
        The balls are too large.
    """
    data = ExactProblem.of(problem)
    over_w, over_u = _over(w, data.n, "w"), _over(u, data.d, "u")
    (p, unit_p), (q, unit_q) = _residuals(data, over_w, over_u)
    loss, coupling = _ratio(_dot(p, p), unit_p**2), _ratio(_dot(q, q), unit_q**2)
    views, lengths = _ratio(sum(map(abs, over_w[0])), over_w[1]), _squared_lengths(data, over_u)
    weights, terms = (Fraction(1), *data.lambdas), [loss, coupling, views]
    if any(isinstance(x, arb) for x in terms):
        norm = sum((root(x) for x in map(_flint, lengths)), fmpq(0))
        return enclosed(balls.inner([*map(exact, weights)], [*map(_flint, terms), norm]))
    roots = [square_root(x, bits) for x in lengths] if data.lambda3 else []
    ends = (total(getattr(x, end) for x in roots) for end in ("lower", "upper"))
    return Enclosure(*(inner(weights, [*terms, norm]) for norm in ends))


def residuals(problem: Problem | ExactProblem, w: Point, u: Point) -> tuple[Rational, Rational]:
    """Return p = X'w - o, shape (d,), and q = Xu - w, shape (n,), at floats or Fractions (n,), (d,)."""
    data = ExactProblem.of(problem)
    p, q = _residuals(data, _over(w, data.n, "w"), _over(u, data.d, "u"))
    return tuple(Fraction(x, p[1]) for x in p[0]), tuple(Fraction(x, q[1]) for x in q[0])


def norms(problem: Problem | ExactProblem, u: Point) -> list[Enclosure]:
    """Enclose ||u^i|| of each of the m modalities, u floats or Fractions (d,)."""
    data = ExactProblem.of(problem)
    return [square_root(x) for x in _squared_lengths(data, _over(u, data.d, "u"))]


def dual_objective(problem: Problem | ExactProblem, a: Point, b: Point) -> Fraction:
    """Return D(a, b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1), exactly; b must be 0 where lambda1 is 0.

    Parameters
    ----------
    problem : Problem or ExactProblem
    a, b : floats or Fractions (d,), (n,)
    """
    data = ExactProblem.of(problem)
    (a_, unit_a), (b_, unit_b) = _over(a, data.d, "a"), _over(b, data.n, "b")
    linear = Fraction(_dot(a_, data.target), unit_a * data.target_unit)
    coupling = Fraction(_dot(b_, b_), unit_b * unit_b)
    if coupling:
        coupling = coupling / (4 * data.lambda1)
    return -linear - Fraction(_dot(a_, a_), 4 * unit_a * unit_a) - coupling


def is_dual_feasible(problem: Problem | ExactProblem, a: Point, b: Point) -> bool:
    """Decide exactly whether |X a - b|_j <= lambda2, ||X_i' b|| <= lambda3, and b = 0 if lambda1 = 0.

    Parameters
    ----------
    problem : Problem or ExactProblem
    a, b : floats or Fractions (d,), (n,)
    """
    data = ExactProblem.of(problem)
    over_a, over_b = _over(a, data.d, "a"), _over(b, data.n, "b")
    if data.lambda1 == 0 and any(over_b[0]):
        return False
    v, unit = _minus(_rows(data, over_a), over_b)
    pull = _columns(data, over_b)
    return max(map(abs, v)) <= data.lambda2 * unit and all(
        square <= data.lambda3**2 for square in _squared_lengths(data, pull)
    )


def _residuals(data: ExactProblem, w: Over, u: Over) -> tuple[Over, Over]:
    """X'w - o and Xu - w."""
    return _minus(_columns(data, w), (list(data.target), data.target_unit)), _minus(_rows(data, u), w)


def _squared_lengths(data: ExactProblem, u: Over) -> list[Any]:
    blocks = ([u[0][k] for k in group] for group in data.groups)
    return [_ratio(_dot(v, v), u[1] ** 2) for v in blocks]


def _columns(data: ExactProblem, w: Over) -> Over:
    """X'w."""
    return [_dot(column, w[0]) for column in zip(*data.rows, strict=True)], data.unit * w[1]


def _rows(data: ExactProblem, u: Over) -> Over:
    """Xu."""
    return [_dot(row, u[0]) for row in data.rows], data.unit * u[1]


def _minus(x: Over, y: Over) -> Over:
    return [y[1] * a - x[1] * b for a, b in zip(x[0], y[0], strict=True)], x[1] * y[1]


def _dot(x: Iterable[Any], y: Iterable[Any]) -> Any:
    """x'y; a number times itself is a product of two equal balls, never a power."""
    return sum(map(mul, x, y))


def _ratio(number: Any, denominator: int) -> Any:
    """A ball for a ball, a Fraction for an integer."""
    return number / denominator if isinstance(number, arb) else Fraction(number, denominator)


def _flint(value: Any) -> Any:
    return value if isinstance(value, arb) else exact(value)


def _over(values: Point, size: int, name: str) -> Over:
    entries = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if len(entries) != size:
        raise InputError(name, value=len(entries), must=f"must have {size} entries")
    if any(isinstance(x, arb) for x in entries):
        return [arb(x) for x in entries], 1
    if isinstance(entries[0], fmpq):
        whole, unit = fmpq_mat([entries]).numer_denom()
        return [int(x) for x in whole.entries()], int(unit)
    return integers(entries)
