"""A primal-dual interior point method of our own, in decimal arithmetic of any length.

It serves the exact referee. Nothing here is trusted: exact bounds of its points are made by the referee.

The central path of the dual, with slack g_i = lambda3^2 - b'K_i b and w = y- - y+:

    y+_j (lambda2 - v_j) = mu,  y-_j (lambda2 + v_j) = mu,  rho_i g_i = 2 mu,
    v = 2 (H w - c) - b,        b/(2 lambda1) + w + sum_i rho_i K_i b = 0

With lambda2 = 0 the w are free and v = 0; without coupling (lambda1 or lambda3 is 0) b and rho are absent.
"""

from dataclasses import dataclass, field
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.exact.numbers import Rationals, objects, rationals
from verification.exact.reduced import Reduced

Decimals = NDArray[Any]
"""An object array of Decimals."""

MOST_STEPS = 250
STALLED = Decimal("1e-12")
"""Steps shorter than this get nowhere: the arithmetic is too short."""


@dataclass(frozen=True)
class StepRule:
    """How far and in which direction a step along the central path goes.

    Attributes
    ----------
    share : Decimal
        Largest fraction of the distance to the boundary that one step may go.
    least : Decimal
        Smallest factor to which a step may aim to reduce mu.
    residual : Decimal
        While the relative residual is above this, mu is kept.
    """

    share: Decimal
    least: Decimal
    residual: Decimal


AGGRESSIVE = StepRule(Decimal("0.999"), Decimal(0), Decimal("Infinity"))
"""Almost to the boundary, with any reduction of mu: the fewest steps."""
CONSERVATIVE = StepRule(Decimal("0.8"), Decimal("0.15"), Decimal("1e-6"))
"""Feasible first, then near the centre: for problems on which the aggressive rule stalls at a boundary."""


@dataclass(frozen=True, eq=False)
class Central:
    """A point near the end of the central path, over the rationals; b and rho are empty without coupling."""

    w: Rationals
    b: Rationals = field(default_factory=lambda: rationals([]))
    rho: Rationals = field(default_factory=lambda: rationals([]))


def follow(reduced: Reduced, digits: int, rule: StepRule = AGGRESSIVE) -> Central:
    """Follow the central path in `digits` digits until mu is 10^-(digits/2) ||o||^2, or no step helps."""
    with localcontext(Context(prec=digits)):
        path = _Path.of(reduced)
        goal = path.mu() * Decimal(10) ** -(digits // 2)
        for _ in range(MOST_STEPS):
            if path.mu() <= goal and path.infeasibility() <= Decimal(10) ** -(digits // 2):
                break
            if not path.interior() or path.step(rule) < STALLED:
                break
        return Central(*(_fractions(x) for x in (path.w, path.at.b, path.at.rho)))


@dataclass(frozen=True, eq=False)
class _Iterate:
    """y+ and y-, v, rho and b, with K_i b and the slack g of b."""

    y: tuple[Decimals, Decimals]
    v: Decimals
    rho: Decimals
    b: Decimals
    Kb: Decimals
    slack: Decimals


@dataclass(eq=False)
class _Path:
    """The problem and the iterate, in decimals."""

    H: Decimals
    c: Decimals
    K: Decimals
    lambdas: tuple[Decimal, Decimal, Decimal]
    w: Decimals
    at: _Iterate = field(init=False)

    @classmethod
    def of(cls, reduced: Reduced) -> "_Path":
        """Start at v = b = 0, on the central path but for v's residual."""
        blocks = reduced.K if reduced.coupled else ()
        n, m = len(reduced.c), len(blocks)
        one, two, three = (_decimal(x) for x in (reduced.lambda1, reduced.lambda2, reduced.lambda3))
        mu = _decimal(reduced.target)
        zero = _filled(n, Decimal(0))
        y = _filled(n, mu / two) if two else zero
        rho = _filled(m, 2 * mu / (three * three)) if m else _filled(0, mu)
        K = np.array([_decimals(k) for k in blocks], dtype=object).reshape(m, n, n)
        path = cls(_decimals(reduced.H), _decimals(reduced.c), K, (one, two, three), zero)
        path.at = path._iterate((y, y), zero, rho, zero)
        return path

    def _iterate(self, y: tuple[Decimals, Decimals], v: Decimals, rho: Decimals, b: Decimals) -> _Iterate:
        Kb = self.K @ b
        return _Iterate(y, v, rho, b, Kb, np.asarray(self.lambdas[2] ** 2 - Kb @ b))

    def interior(self) -> bool:
        """Whether every slack is still positive: rounding can end that."""
        two = self.lambdas[1]
        views = not two or all(abs(v) < two for v in self.at.v)
        return views and all(g > 0 for g in self.at.slack)

    def mu(self) -> Decimal:
        """Mean complementarity."""
        return self._complementarity(self.at)

    def _complementarity(self, at: _Iterate) -> Decimal:
        two = self.lambdas[1]
        total, count = Decimal(0), 0
        if two:
            total += sum(at.y[0] * (two - at.v), Decimal(0)) + sum(at.y[1] * (two + at.v), Decimal(0))
            count += 2 * at.v.size
        if at.rho.size:
            total += sum(at.rho * at.slack, Decimal(0)) / 2
            count += at.rho.size
        return total / count

    def _residuals(self) -> tuple[Decimals, Decimals]:
        at = self.at
        first = 2 * (self.H @ self.w - self.c) - at.b - at.v
        if not at.rho.size:
            return first, at.b
        return first, at.b / (2 * self.lambdas[0]) + self.w + np.tensordot(at.rho, at.Kb, 1)

    def infeasibility(self) -> Decimal:
        """Largest residual, relative to the size of its terms."""
        at, (first, second) = self.at, self._residuals()
        size = 2 * np.abs(self.H) @ np.abs(self.w) + 2 * np.abs(self.c) + np.abs(at.b) + np.abs(at.v)
        worst = [abs(r) / s for r, s in zip(first, size, strict=True) if s]
        if at.rho.size:
            terms = np.abs(at.b) / (2 * self.lambdas[0]) + np.abs(self.w)
            worst += [abs(r) / s for r, s in zip(second, terms, strict=True) if s]
        return max(worst, default=Decimal(0))

    def step(self, rule: StepRule) -> Decimal:
        """One predictor for the centring, one Newton step; returns its length."""
        fixed, centring = self._directions()
        mu = self.mu()
        length = self._length(fixed, Decimal(1))
        ratio = max(Decimal(0), self._complementarity(self._moved(fixed, length)) / mu) if mu else Decimal(0)
        waiting = rule.residual.is_finite() and self.infeasibility() > rule.residual
        toward = mu * (Decimal(1) if waiting else max(rule.least, ratio**3))
        direction = tuple(f + toward * c for f, c in zip(fixed, centring, strict=True))
        length = self._length(direction, rule.share)
        self.at = self._moved(direction, length)
        self.w = self.w + length * direction[0] if not self.lambdas[1] else self.at.y[1] - self.at.y[0]
        return length

    def _directions(self) -> tuple[tuple[Decimals, ...], tuple[Decimals, ...]]:
        """Newton's direction (w, v, b, rho, y+, y-) for mu = 0, and its derivative in mu."""
        at, (first, second), n = self.at, self._residuals(), self.at.v.size
        (up, down), (slack_up, slack_down) = at.y, self._view_slacks()
        zero, ones = _filled(n, Decimal(0)), _filled(n, Decimal(1))
        A, rhs = 2 * self.H, np.array([-first, zero], dtype=object)
        theta, shift = zero, np.array([zero, zero], dtype=object)
        if self.lambdas[1]:
            theta = down / slack_down + up / slack_up
            shift = np.array([up - down, ones / slack_down - ones / slack_up], dtype=object)
            A = A + np.diag(ones / theta)
            rhs = rhs + shift / theta
        k, g, e = at.Kb, at.slack, (-at.rho * at.slack, _filled(at.rho.size, Decimal(2)))
        if at.rho.size:
            M = np.diag(ones / (2 * self.lambdas[0])) + np.tensordot(at.rho, self.K, 1)
            M = M + (2 * at.rho / g * k.T) @ k
            eye = np.diag(ones)
            A = np.concatenate([np.concatenate([A, -eye], axis=1), np.concatenate([eye, M], axis=1)])
            below = np.array([-second - (e[0] / g) @ k, -(e[1] / g) @ k], dtype=object)
            rhs = np.concatenate([rhs, below], axis=1)
        found = _solve(A, rhs.T).T
        result = []
        for i in range(2):
            dw, db = found[i][:n], found[i][n:] if at.rho.size else zero
            dv = (shift[i] - dw) / theta if self.lambdas[1] else zero
            drho = (e[i] + 2 * at.rho * (k @ db)) / g if at.rho.size else at.rho
            result.append((dw, dv, db, drho, *self._multipliers(i, dv)))
        return result[0], result[1]

    def _view_slacks(self) -> tuple[Decimals, Decimals]:
        """lambda2 - v and lambda2 + v."""
        return self.lambdas[1] - self.at.v, self.lambdas[1] + self.at.v

    def _multipliers(self, i: int, dv: Decimals) -> tuple[Decimals, Decimals]:
        """Directions of y+ and y-, for mu = 0 (i = 0) or in mu (i = 1)."""
        (up, down), (slack_up, slack_down) = self.at.y, self._view_slacks()
        if not self.lambdas[1]:
            return dv, dv
        if i == 0:
            return -up + up * dv / slack_up, -down - down * dv / slack_down
        return (1 + up * dv) / slack_up, (1 - down * dv) / slack_down

    def _moved(self, direction: tuple[Decimals, ...], t: Decimal) -> _Iterate:
        at, (_, dv, db, drho, dup, ddown) = self.at, direction
        y = at.y[0] + t * dup, at.y[1] + t * ddown
        return self._iterate(y, at.v + t * dv, at.rho + t * drho, at.b + t * db)

    def _length(self, direction: tuple[Decimals, ...], share: Decimal) -> Decimal:
        """The longest step <= 1 that keeps 1 - share of every positive quantity."""
        at, (_, dv, db, drho, dup, ddown) = self.at, direction
        pairs = [(at.rho, drho)]
        if self.lambdas[1]:
            slack_up, slack_down = self._view_slacks()
            pairs += [(slack_up, -dv), (slack_down, dv), (at.y[0], dup), (at.y[1], ddown)]
        value, change = (np.concatenate(part) for part in zip(*pairs, strict=True))
        falling = change < 0
        longest: Decimal = min([Decimal(1), *(share * value[falling] / -change[falling])])
        if at.rho.size:
            for g, kb, square in zip(at.slack, at.Kb @ db, self.K @ db @ db, strict=True):
                root = (kb * kb + max(square, Decimal(0)) * share * g).sqrt()
                if root + kb > 0:
                    longest = min(longest, share * g / (root + kb))
        return longest


def _solve(A: Decimals, B: Decimals) -> Decimals:
    """Solve A x = B by equilibrated elimination with partial pivoting; x = 0 along a pivot of 0."""
    column = _sizes(A, 0)
    A = A / column
    work = np.concatenate([A, B], axis=1) / _sizes(A, 1)[:, None]
    size = A.shape[0]
    for k in range(size):
        pivot = k + int(np.argmax(np.abs(work[k:, k])))
        if not work[pivot, k]:
            continue
        if pivot != k:
            work[[k, pivot]] = work[[pivot, k]]
        rows = k + 1 + np.flatnonzero(work[k + 1 :, k])
        work[rows, k:] = work[rows, k:] - (work[rows, k] / work[k, k])[:, None] * work[k, k:]
    x = np.full((size, B.shape[1]), Decimal(0), dtype=object)
    for k in reversed(range(size)):
        if work[k, k]:
            x[k] = (work[k, size:] - work[k, k + 1 : size] @ x[k + 1 :]) / work[k, k]
    return np.asarray(x / column[:, None])


def _sizes(A: Decimals, axis: int) -> Decimals:
    """Largest size of an entry along an axis; 1 where all are 0."""
    found = np.abs(A).max(axis=axis)
    found[found == 0] = Decimal(1)
    return np.asarray(found)


def _filled(size: int, value: Decimal) -> Decimals:
    return np.full(size, value, dtype=object)


def _decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)


def _decimals(values: Rationals) -> Decimals:
    return objects([_decimal(value) for value in values.flat], values.shape)


def _fractions(values: Decimals) -> Rationals:
    return objects([Fraction(value) for value in values.flat], values.shape)
