"""Exact witnesses of an interval of F*: a primal point, and a dual point that is feasible exactly.

    maximise  D(a,b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1)
    s.t.      ||X a - b||_inf <= lambda2,      ||X_i' b||_2 <= lambda3  for every modality i

Source: Boyd and Vandenberghe, Convex Optimization, section 5.1.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from convexperc.caching import cached_property
from convexperc.certificate.certificate import Certificate
from convexperc.certificate.duality import DualPoint
from convexperc.certificate.rationals import (
    LONGER,
    WORD_BITS,
    Integers,
    RowSpace,
    column,
    integers,
    numerators,
)
from convexperc.certificate.tolerances import Tolerances
from convexperc.enclosure.balls import precision
from convexperc.enclosure.budget import Budget, OutOfBudget
from convexperc.enclosure.central_path import Central, CentralPath
from convexperc.enclosure.dyadic import Dyadic, exact, exact_balls, power, root_down, root_up, shortened
from convexperc.enclosure.exact_data import ExactData
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling

POINT_BITS = 100
"""A point is rounded where that moves the residuals by at most 2^-100 of the data's largest entry."""
BITS = (128, 256, 512, 1024)
"""Precisions tried in turn where no float64 point proves enough."""


@dataclass(frozen=True, eq=False)
class Data:
    """The problem in exact numbers.

    Attributes
    ----------
    problem : Problem
        As given.
    X : object array of int, shape (n, d)
        In units of 2^exponent.
    exponent : int
    o : Dyadic
    lambda1, lambda2, lambda3 : Fraction
    budget : Budget
        Of the search for witnesses; where it does not suffice, the methods raise `OutOfBudget`.
    """

    problem: Problem
    X: Integers
    exponent: int
    o: Dyadic
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction
    budget: Budget

    @classmethod
    def of(cls, problem: Problem, budget: Budget) -> "Data":
        """Take the floats of a problem as the rationals that they are."""
        lambda1, lambda2, lambda3 = (Fraction(value) for value in problem.lambdas)
        return cls(problem, *integers(problem.X), exact(problem.o), lambda1, lambda2, lambda3, budget)

    @cached_property
    def space(self) -> RowSpace:
        """The span of the rows of X, in the same units."""
        found = RowSpace.within_limit(self.problem.X, self.budget.products)
        if found is None:
            self.budget.refuse()
        return found

    def solvable_space(self, *right: Dyadic) -> RowSpace:
        """The same, for a system of equations with these right sides."""
        longest = max((_bits(x.whole) for x in right), default=0) / WORD_BITS / self.space.words
        self.budget.require(LONGER * max(1.0, longest) * self.space.work)
        return self.space

    def rows(self, x: Dyadic) -> Dyadic:
        """X x."""
        return Dyadic(self.X @ x.whole, self.exponent + x.exponent)

    def columns(self, x: Dyadic) -> Dyadic:
        """X' x."""
        return Dyadic(self.X.T @ x.whole, self.exponent + x.exponent)

    def squares(self, x: Dyadic) -> list[Fraction]:
        """||x^i||^2 of each modality's part."""
        parts = (x.part(columns) for columns in self.problem.modalities)
        return [part.dot(part) for part in parts]

    def objective(self, w: Dyadic, u: Dyadic) -> Fraction:
        """F(w, u), its square roots rounded up."""
        p, q = self.columns(w).plus(self.o, -1), self.rows(u).plus(w, -1)
        total = p.dot(p) + self.lambda1 * q.dot(q)
        total += self.lambda2 * int(sum(abs(w.whole))) * power(w.exponent)
        if self.lambda3:
            total += self.lambda3 * sum(map(root_up, self.squares(u)), Fraction(0))
        return total


_Primal = tuple[Fraction, Dyadic, Dyadic]
"""F(w, u), w, u."""
_Dual = tuple[Fraction, Dyadic, Dyadic]
"""D(a, b), a, b."""


class Witnesses:
    """The least upper and the greatest lower bound so far, with their witnesses."""

    def __init__(self, data: Data) -> None:
        n, d = data.problem.n, data.problem.d
        self.data = data
        self.target = data.o.dot(data.o)
        self.primal: _Primal = self.target, Dyadic.zeros(n), Dyadic.zeros(d)
        self.dual: _Dual = Fraction(0), Dyadic.zeros(d), Dyadic.zeros(n)

    def try_primal(self, w: Dyadic, u: Dyadic) -> None:
        """Keep the point if F is lower there."""
        value = self.data.objective(w, u)
        if value < self.primal[0]:
            self.primal = value, w, u

    def try_dual(self, a: Dyadic, b: Dyadic) -> None:
        """Try every feasible point that (a, b) suggests."""
        for coupling in _couplings(self.data, a, b):
            found = _scaled(self.data, a, coupling)
            if found is not None and found[0] > self.dual[0]:
                self.dual = found

    def within(self, tolerances: Tolerances, width: Fraction) -> bool:
        """Whether the interval meets the tolerances, or is at most as wide as another."""
        reached, low = self.primal[0] - self.dual[0], self.dual[0]
        return reached <= width or tolerances.met_exactly(reached, low, self.target)


def witnesses(data: Data, point: tuple[Vector, FeatureVector], certificate: Certificate) -> Witnesses:
    """Find witnesses of bounds as narrow as the certificate asks, by the cheapest points that give them.

    Where the budget of the data is spent before, the best ones so far.

    Parameters
    ----------
    data : Data
    point : float64 (n,) and (d,)
        An answer (w, u); it is never believed.
    certificate : Certificate
        Of that answer.
    """
    best = Witnesses(data)
    with data.budget.running(), suppress(OutOfBudget):
        _search(best, point, certificate)
    return best


def _search(best: Witnesses, point: tuple[Vector, FeatureVector], certificate: Certificate) -> None:
    """Improve the witnesses until they are enough."""
    data = best.data
    if data.lambda2 == 0 and (data.lambda1 == 0 or data.lambda3 == 0):
        _least_squares(best)
        return
    if all(np.isfinite(part).all() for part in point):
        w, u = (exact(part) for part in point)
        best.try_primal(w, u)
        p, q = data.columns(w).plus(data.o, -1), data.rows(u).plus(w, -1)
        best.try_dual(p.times(Fraction(2)), q.times(2 * data.lambda1))
    if certificate.dual is not None:
        best.try_dual(*_suggested(data, certificate.dual))
    width = Fraction(0)
    if math.isfinite(certificate.upper) and not certificate.certified:
        width = Fraction(certificate.upper) - Fraction(certificate.lower)
    tolerances = certificate.tolerances
    for bits in BITS:
        if best.within(tolerances, width):
            break
        with precision(bits), suppress(ZeroDivisionError):  # a matrix singular at these bits: take more
            for central in _central_points(data, bits):
                _try_central(best, central)
                if best.within(tolerances, width):
                    break


def _suggested(data: Data, dual: DualPoint) -> tuple[Dyadic, Dyadic]:
    """(a, b) on the original data of the certificate's normalised dual point, with b = X a - v exactly."""
    scaling, scale = Scaling.of(data.problem), Fraction(dual.scale)
    a = exact(dual.a).times(scale * power(scaling.o))
    v = exact(dual.v.mid).times(scale * power(scaling.x + scaling.o))
    return a, data.rows(a).plus(v, -1)


def _couplings(data: Data, a: Dyadic, b: Dyadic) -> Iterator[Dyadic]:
    """The b to try with a: those that satisfy the constraints that no scale can repair."""
    if data.lambda1 == 0 or data.lambda3 == 0:
        yield Dyadic.zeros(data.problem.n)
        if data.lambda1 > 0:
            yield _into_null_space(data, b)
        return
    Xa = data.rows(a)
    if data.lambda2 == 0:
        yield Xa
        return
    yield Xa.plus(Xa.plus(b, -1).clipped(data.lambda2), -1)
    yield b
    longest = max(data.squares(data.columns(b)))
    if longest > data.lambda3**2:
        yield b.times(shortened(root_down(data.lambda3**2 / longest)))


def _scaled(data: Data, a: Dyadic, b: Dyadic) -> _Dual | None:
    """The best feasible multiple of (a, b) with its D, or None where that proves nothing."""
    linear, quadratic = -a.dot(data.o), a.dot(a) / 4
    if data.lambda1:
        quadratic += b.dot(b) / (4 * data.lambda1)
    if linear <= 0:
        return None
    s = linear / (2 * quadratic)
    longest = data.rows(a).plus(b, -1).largest()
    if longest:
        s = min(s, data.lambda2 / longest)
    for square in data.squares(data.columns(b)):
        if square * s * s > data.lambda3**2:
            s = root_down(data.lambda3**2 / square)
    s = shortened(s)
    return (s * linear - s * s * quadratic, a.times(s), b.times(s)) if s else None


def _into_null_space(data: Data, b: Dyadic) -> Dyadic:
    """The orthogonal projection of b onto {X'b = 0}, times a number within 2^-80 of 1."""
    inside, denominator = numerators(data.solvable_space(b).outside(column(b.whole)))
    return Dyadic(inside, b.exponent).times(shortened(Fraction(1, denominator)))


def _least_squares(best: Witnesses) -> None:
    """The equality case min_w ||X'w - o||^2, both bounds from its exact solution.

    Formula: w = X u for the u in the span of the rows with X'X u the projection of o onto it; the residual
    r = o - X'w gives a = -2 r, b = 0. u is rounded, r only scaled.
    """
    data, t = best.data, column(best.data.o.whole)
    space = data.solvable_space(data.o)
    residual, denominator = numerators(space.residual(t))
    a = Dyadic(-2 * residual, data.o.exponent).times(shortened(Fraction(1, denominator)))
    best.try_dual(a, Dyadic.zeros(data.problem.n))
    if best.target == 0:
        return
    u = _rounded(space.fitted(t), 2 * _bits(data.X) + data.problem.n.bit_length() - _bits(data.o.whole))
    u = Dyadic(u.whole, u.exponent + data.o.exponent - 2 * data.exponent)
    best.try_primal(data.rows(u), u if data.lambda1 else Dyadic.zeros(data.problem.d))


def _bits(whole: Integers) -> int:
    """Bits of the largest entry."""
    return int(max(abs(whole).ravel())).bit_length()


def _rounded(values: Any, digits: int) -> Dyadic:
    """A rational vector in fractions of 2^-digits and `POINT_BITS` more, for the sum of its entries."""
    over, denominator = numerators(values)
    digits = max(0, digits + over.size.bit_length() + POINT_BITS)
    return Dyadic(over * (1 << digits) // denominator, -digits)


def _central_points(data: Data, bits: int) -> Iterator[tuple[Scaling, Central]]:
    """Points near the central path, nearer and nearer to the optimum, in the precision in force."""
    problem, scaling = data.problem, Scaling.of(data.problem)
    reduced = ReducedBalls.of(problem, (scaling.x, scaling.o), ExactData.of(problem, data.budget))
    path = CentralPath(reduced)
    for share in range(40, bits, 24):
        while path.mu > reduced.target * flint.arb(2) ** -share:
            path.advance()
        yield scaling, path.point()


def _try_central(best: Witnesses, found: tuple[Scaling, Central]) -> None:
    """Try a point of the central path: u^i = t_i X_i' q, a = 2(X'w - o), b = -2q."""
    (scaling, point), data = found, best.data
    w = exact_balls(point.w, scaling.o - scaling.x)
    a = data.columns(w).plus(data.o, -1).times(Fraction(2))
    if data.lambda1 == 0 or data.lambda3 == 0:
        best.try_primal(w, _nearest_coupling(data, w))
        best.try_dual(a, w.times(-2 * data.lambda1))
        return
    u = Dyadic.zeros(data.problem.d)
    for weight, columns in zip(point.t, data.problem.modalities, strict=True):
        pulled = exact_balls([(weight * v).mid() for v in point.q], scaling.o - 3 * scaling.x)
        part = Dyadic.zeros(data.problem.d)
        part.whole[columns] = (data.X.T @ pulled.whole)[columns]
        u = u.plus(Dyadic(part.whole, pulled.exponent + data.exponent))
    best.try_primal(w, u)
    best.try_dual(a, exact_balls(point.q, scaling.x + scaling.o).times(Fraction(-2)))


def _nearest_coupling(data: Data, w: Dyadic) -> Dyadic:
    """The u of lambda3 = 0, for which X u is the projection of w onto the range of X; 0 if uncoupled."""
    if data.lambda1 == 0:
        return Dyadic.zeros(data.problem.d)
    u = _rounded(data.solvable_space(w).coupling(column(w.whole)), _bits(data.X))
    return Dyadic(u.whole, u.exponent + w.exponent - data.exponent)
