"""The proof of an answer as a file that anybody can check without this library.

A proof holds the problem, the claim lower <= F* <= upper, and two witnesses in exact numbers: a primal point
(w, u) with F(w, u) <= upper, and a dual point (a, b) that is feasible exactly, with D(a, b) >= lower. Every
number is a C99 hex float; those of the witnesses may have more digits than float64 holds.
`verification.check` reads it, with integers alone and none of this code.

    maximise  D(a,b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1)
    s.t.      ||X a - b||_inf <= lambda2,      ||X_i' b||_2 <= lambda3  for every modality i

Source: Boyd and Vandenberghe, Convex Optimization, section 5.1.
"""

import hashlib
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from convexperc.duality import DualPoint
from convexperc.errors import ProblemError
from convexperc.exact import PRIMES, Integers, integers, row_basis, solve
from convexperc.interior import Central, CentralPath
from convexperc.multiprecision import BallFrame, Numbers, precision
from convexperc.problem import Problem
from convexperc.records import problem_record
from convexperc.scaling import Scaling
from convexperc.solution import Solution

SCHEMA = "convexperc/proof/1"
SCALE_BITS = 80
"""A scale is rounded down to so many bits: it costs 2^-80 of the bound and keeps the numbers short."""
ROOT_BITS = 160
"""Square roots are rounded up at this many bits."""
POINT_BITS = 100
"""A least-squares point is rounded where that moves the residuals by 2^-100 of their size."""
BITS = (128, 256, 512, 1024)
"""Precisions tried in turn where no float64 point proves enough."""


def proof_record(solution: Solution) -> dict[str, Any]:
    """Prove the bounds of a solution's F* by exact witnesses, as plain JSON values.

    The interval is as narrow as the certificate's tolerances, or as its own interval where that is wider.
    Where float64 points do not reach that, an interior point in longer numbers takes their place.

    Parameters
    ----------
    solution : Solution

    Returns
    -------
    dict
        ``schema``; ``problem``, itself a problem file; ``sha256``, see `data_digest`; ``claim`` with
        ``lower`` and ``upper``; ``primal`` with ``w`` and ``u``; ``dual`` with ``a`` and ``b``.

    Raises
    ------
    ProblemError
        F* may exceed the largest float64, so that no claim can be written.
    """
    problem, data = solution.problem, _Data.of(solution.problem)
    best = _best(data, solution)
    (high, w, u), (low, a, b) = best.primal, best.dual
    upper = _rounded_up(high)
    if upper is None:
        must = "must have an optimum below 1.8e308 for a claim in float64"
        raise ProblemError("problem", value=problem, must=must, remedy="Scale o, lambda2 and lambda3 down.")
    return {
        "schema": SCHEMA,
        "problem": problem_record(problem),
        "sha256": data_digest(problem),
        "claim": {"lower": _rounded_down(low).hex(), "upper": upper.hex()},
        "primal": {"w": w.strings(), "u": u.strings()},
        "dual": {"a": a.strings(), "b": b.strings()},
    }


def data_digest(problem: Problem) -> str:
    """SHA-256 of the data, in hexadecimal.

    Of the bytes: the schema's name in ASCII and a zero byte; n, d, m as int64; X row by row, o, lambda1,
    lambda2, lambda3 as float64; for each modality the number of its columns and the columns as int64; all
    little-endian.
    """
    columns = [np.arange(problem.d)[c] for c in problem.modalities]
    parts = [
        SCHEMA.encode("ascii") + b"\0",
        np.array([problem.n, problem.d, problem.m], dtype="<i8").tobytes(),
        *(np.ascontiguousarray(v, dtype="<f8").tobytes() for v in (problem.X, problem.o, problem.lambdas)),
        *(np.array([c.size, *c], dtype="<i8").tobytes() for c in columns),
    ]
    return hashlib.sha256(b"".join(parts)).hexdigest()


@dataclass(frozen=True, eq=False)
class _Dyadic:
    """Integers times one power of two: whole * 2^exponent."""

    whole: Integers
    exponent: int

    @classmethod
    def zeros(cls, size: int) -> "_Dyadic":
        return cls(np.full(size, 0, dtype=object), 0)

    def plus(self, other: "_Dyadic", sign: int = 1) -> "_Dyadic":
        low = min(self.exponent, other.exponent)
        mine, theirs = (x.whole * (1 << (x.exponent - low)) for x in (self, other))
        return _Dyadic(mine + sign * theirs, low)

    def times(self, factor: Fraction) -> "_Dyadic":
        """The product with a rational whose denominator is a power of two."""
        shift = factor.denominator.bit_length() - 1
        return _Dyadic(self.whole * factor.numerator, self.exponent - shift)

    def clipped(self, limit: Fraction) -> "_Dyadic":
        """Cut to [-limit, limit], the limit a rational whose denominator is a power of two."""
        low = min(self.exponent, 1 - limit.denominator.bit_length())
        bound = int(limit * _power(-low))
        whole = self.whole * (1 << (self.exponent - low))
        return _Dyadic(np.minimum(np.maximum(whole, -bound), bound), low)

    def dot(self, other: "_Dyadic") -> Fraction:
        return int(self.whole @ other.whole) * _power(self.exponent + other.exponent)

    def largest(self) -> Fraction:
        return int(max(abs(self.whole))) * _power(self.exponent)

    def part(self, columns: Any) -> "_Dyadic":
        return _Dyadic(self.whole[columns], self.exponent)

    def strings(self) -> list[str]:
        """Every entry as a C99 hex float, exactly."""
        return [_hex(int(value), self.exponent) for value in self.whole]


@dataclass(frozen=True, eq=False)
class _Data:
    """The problem in exact numbers; X is stored as integers in units of 2^exponent."""

    problem: Problem
    X: Integers
    exponent: int
    o: _Dyadic
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: Problem) -> "_Data":
        lambda1, lambda2, lambda3 = (Fraction(value) for value in problem.lambdas)
        return cls(problem, *integers(problem.X), _exact(problem.o), lambda1, lambda2, lambda3)

    def rows(self, x: _Dyadic) -> _Dyadic:
        """X x."""
        return _Dyadic(self.X @ x.whole, self.exponent + x.exponent)

    def columns(self, x: _Dyadic) -> _Dyadic:
        """X' x."""
        return _Dyadic(self.X.T @ x.whole, self.exponent + x.exponent)

    def squares(self, x: _Dyadic) -> list[Fraction]:
        """||x^i||^2 of each modality's part."""
        parts = (x.part(columns) for columns in self.problem.modalities)
        return [part.dot(part) for part in parts]

    def objective(self, w: _Dyadic, u: _Dyadic) -> Fraction:
        """F(w, u), its square roots rounded up."""
        p, q = self.columns(w).plus(self.o, -1), self.rows(u).plus(w, -1)
        total = p.dot(p) + self.lambda1 * q.dot(q)
        total += self.lambda2 * int(sum(abs(w.whole))) * _power(w.exponent)
        if self.lambda3:
            total += self.lambda3 * sum(map(_root_up, self.squares(u)), Fraction(0))
        return total


_Primal = tuple[Fraction, _Dyadic, _Dyadic]
"""F(w, u), w, u."""
_Dual = tuple[Fraction, _Dyadic, _Dyadic]
"""D(a, b), a, b."""


class _Best:
    """The least upper and the greatest lower bound so far, with their witnesses."""

    def __init__(self, data: _Data) -> None:
        n, d = data.problem.n, data.problem.d
        self.data = data
        self.target = data.o.dot(data.o)
        self.primal: _Primal = self.target, _Dyadic.zeros(n), _Dyadic.zeros(d)
        self.dual: _Dual = Fraction(0), _Dyadic.zeros(d), _Dyadic.zeros(n)

    def try_primal(self, w: _Dyadic, u: _Dyadic) -> None:
        value = self.data.objective(w, u)
        if value < self.primal[0]:
            self.primal = value, w, u

    def try_dual(self, a: _Dyadic, b: _Dyadic) -> None:
        """Try every feasible point that (a, b) suggests."""
        for coupling in _couplings(self.data, a, b):
            found = _scaled(self.data, a, coupling)
            if found is not None and found[0] > self.dual[0]:
                self.dual = found

    def within(self, relative: float, absolute: float, width: Fraction) -> bool:
        reached, low = self.primal[0] - self.dual[0], self.dual[0]
        return reached <= max(Fraction(relative) * low, Fraction(absolute) * self.target, width)


def _best(data: _Data, solution: Solution) -> _Best:
    """Bounds as narrow as the solution's certificate asks, by the cheapest points that give them."""
    best, certificate = _Best(data), solution.certificate
    if data.lambda2 == 0 and (data.lambda1 == 0 or data.lambda3 == 0):
        _least_squares(best)
        return best
    if np.isfinite(solution.w).all() and np.isfinite(solution.u).all():
        w, u = _exact(solution.w), _exact(solution.u)
        best.try_primal(w, u)
        p, q = data.columns(w).plus(data.o, -1), data.rows(u).plus(w, -1)
        best.try_dual(p.times(Fraction(2)), q.times(2 * data.lambda1))
    if certificate.dual is not None:
        best.try_dual(*_suggested(data, certificate.dual))
    width = Fraction(0)
    if math.isfinite(certificate.upper) and not certificate.certified:
        width = Fraction(certificate.upper) - Fraction(certificate.lower)
    tolerances = certificate.relative_tolerance, certificate.absolute_tolerance
    for bits in BITS:
        if best.within(*tolerances, width):
            break
        with precision(bits), suppress(ZeroDivisionError):  # a matrix singular at these bits: take more
            for point in _central_points(data.problem, bits):
                _try_central(best, point)
                if best.within(*tolerances, width):
                    break
    return best


def _suggested(data: _Data, dual: DualPoint) -> tuple[_Dyadic, _Dyadic]:
    """(a, b) on the original data of the certificate's normalised dual point, with b = X a - v exactly."""
    scaling, scale = Scaling.of(data.problem), Fraction(dual.scale)
    a = _exact(dual.a).times(scale * _power(scaling.o))
    v = _exact(dual.v.mid).times(scale * _power(scaling.x + scaling.o))
    return a, data.rows(a).plus(v, -1)


def _couplings(data: _Data, a: _Dyadic, b: _Dyadic) -> Iterator[_Dyadic]:
    """The b to try with a: those that satisfy the constraints that no scale can repair."""
    if data.lambda1 == 0 or data.lambda3 == 0:
        yield _Dyadic.zeros(data.problem.n)
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
        yield b.times(_short(_root_down(data.lambda3**2 / longest)))


def _scaled(data: _Data, a: _Dyadic, b: _Dyadic) -> _Dual | None:
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
            s = _root_down(data.lambda3**2 / square)
    s = _short(s)
    return (s * linear - s * s * quadratic, a.times(s), b.times(s)) if s else None


@dataclass(frozen=True, eq=False)
class _Range:
    """The range of X as that of M = X X_B', B a row basis, in integers; M is in units of 4^exponent."""

    B: Integers
    M: Integers

    @classmethod
    def of(cls, data: _Data) -> "_Range":
        """Find a basis modulo a prime and verify over the integers that it spans every row."""
        for prime in PRIMES:
            basis = row_basis(data.problem.X, prime)
            B = data.X[list(basis.rows)]
            block, others = list(basis.columns), [i for i in range(data.problem.n) if i not in basis.rows]
            if not others:
                return cls(B, data.X @ B.T)
            rest = data.X[others]
            if basis.rank:
                Y, det = solve(B[:, block].T.copy(), rest[:, block].T.copy())
                rest = B.T @ Y - det * rest.T
            if not rest.any():
                return cls(B, data.X @ B.T)
        raise ArithmeticError("no prime gave the rank over the rationals")

    def fitted(self, right: Integers) -> tuple[Integers, int]:
        """(y, det) with M'M y = det right, det > 0."""
        if not self.B.shape[0]:
            return np.full(0, 0, dtype=object), 1
        Y, det = solve(self.M.T @ self.M, right[:, None])
        return (Y[:, 0], det) if det > 0 else (-Y[:, 0], -det)


def _into_null_space(data: _Data, b: _Dyadic) -> _Dyadic:
    """The orthogonal projection of b onto {X'b = 0}, times a number within 2^-80 of 1."""
    span = _Range.of(data)
    if span.B.shape[0] == data.problem.n:
        return _Dyadic.zeros(data.problem.n)
    if not span.B.shape[0]:
        return b
    y, det = span.fitted(span.M.T @ b.whole)
    inside = _Dyadic(b.whole * det - span.M @ y, b.exponent)
    return inside.times(_short(Fraction(1, det)))


def _least_squares(best: _Best) -> None:
    """The equality case min_w ||X'w - o||^2, both bounds from its exact solution.

    Formula: with M = X X_B' and M'M t = X_B o, the point u = X_B' t, w = X u = M t makes X'w the projection
    of o onto the rows; the residual r = o - X'w gives a = -2 r, b = 0. t is rounded, r only scaled.
    """
    data, span = best.data, _Range.of(best.data)
    t, det = span.fitted(span.B @ data.o.whole)
    residual = data.o.whole * det - data.X.T @ (span.M @ t) if t.size else data.o.whole
    a = _Dyadic(-2 * residual, data.o.exponent).times(_short(Fraction(1, det)))
    best.try_dual(a, _Dyadic.zeros(data.problem.n))
    if not t.size or best.target == 0:
        return
    exponent = data.o.exponent - 3 * data.exponent
    pull = int(max(abs(data.X.T @ span.M).ravel())) * t.size
    digits = max(0, pull.bit_length() - int(max(abs(data.o.whole))).bit_length() + POINT_BITS)
    point = _Dyadic(t * (1 << digits) // det, exponent - digits)
    u = _Dyadic(span.B.T @ point.whole, point.exponent + data.exponent)
    w = data.rows(u)
    best.try_primal(w, u if data.lambda1 else _Dyadic.zeros(data.problem.d))


def _central_points(problem: Problem, bits: int) -> Iterator[tuple[Scaling, Central]]:
    """Points near the central path, nearer and nearer to the optimum, in the precision in force."""
    scaling = Scaling.of(problem)
    frame = BallFrame.of(problem, (scaling.x, scaling.o))
    path = CentralPath(frame)
    for share in range(40, bits, 24):
        while path.mu > frame.target * flint.arb(2) ** -share:
            path.advance()
        yield scaling, path.point()


def _try_central(best: _Best, found: tuple[Scaling, Central]) -> None:
    """Try a point of the central path: u^i = t_i X_i' q, a = 2(X'w - o), b = -2q."""
    (scaling, point), data = found, best.data
    w = _exact_balls(point.w, scaling.o - scaling.x)
    a = data.columns(w).plus(data.o, -1).times(Fraction(2))
    if data.lambda1 == 0 or data.lambda3 == 0:
        best.try_primal(w, _nearest_coupling(data, w))
        best.try_dual(a, w.times(-2 * data.lambda1))
        return
    u = _Dyadic.zeros(data.problem.d)
    for weight, columns in zip(point.t, data.problem.modalities, strict=True):
        pulled = _exact_balls([(weight * v).mid() for v in point.q], scaling.o - 3 * scaling.x)
        part = _Dyadic.zeros(data.problem.d)
        part.whole[columns] = (data.X.T @ pulled.whole)[columns]
        u = u.plus(_Dyadic(part.whole, pulled.exponent + data.exponent))
    best.try_primal(w, u)
    best.try_dual(a, _exact_balls(point.q, scaling.x + scaling.o).times(Fraction(-2)))


def _nearest_coupling(data: _Data, w: _Dyadic) -> _Dyadic:
    """The u of lambda3 = 0, for which X u is the projection of w onto the range of X; 0 if uncoupled."""
    if data.lambda1 == 0:
        return _Dyadic.zeros(data.problem.d)
    span = _Range.of(data)
    y, det = span.fitted(span.M.T @ w.whole)
    if not y.size:
        return _Dyadic.zeros(data.problem.d)
    digits = int(max(abs(span.M).ravel())).bit_length() + POINT_BITS
    whole = span.B.T @ (y * (1 << digits) // det)
    return _Dyadic(whole, w.exponent - data.exponent - digits)


def _exact(values: np.ndarray) -> _Dyadic:
    return _Dyadic(*integers(values))


def _exact_balls(values: Numbers, shift: int) -> _Dyadic:
    """Balls without radius, times 2^shift."""
    pairs = [tuple(int(part) for part in value.man_exp()) for value in values]
    low = min((exponent for whole, exponent in pairs if whole), default=0)
    result = np.full(len(pairs), 0, dtype=object)
    result[:] = [whole << (exponent - low) if whole else 0 for whole, exponent in pairs]
    return _Dyadic(result, low + shift)


def _power(exponent: int) -> Fraction:
    return Fraction(1 << exponent) if exponent >= 0 else Fraction(1, 1 << -exponent)


def _short(value: Fraction) -> Fraction:
    """A positive number rounded down to `SCALE_BITS` bits."""
    shift = SCALE_BITS + value.denominator.bit_length() - value.numerator.bit_length()
    return math.floor(value * _power(shift)) * _power(-shift)


def _root_bits(square: Fraction) -> int:
    return ROOT_BITS + (square.denominator.bit_length() - square.numerator.bit_length()) // 2


def _root_down(square: Fraction) -> Fraction:
    shift = _root_bits(square)
    return math.isqrt(math.floor(square * _power(2 * shift))) * _power(-shift)


def _root_up(square: Fraction) -> Fraction:
    low = _root_down(square)
    return low if low * low == square else low + _power(-_root_bits(square))


def _rounded_down(value: Fraction) -> float:
    try:
        near = float(value)
    except OverflowError:
        return math.nextafter(math.inf, 0.0)
    return near if Fraction(near) <= value else math.nextafter(near, -math.inf)


def _rounded_up(value: Fraction) -> float | None:
    """The least float that is not below the value; None beyond the largest."""
    try:
        near = float(value)
    except OverflowError:
        return None
    near = near if Fraction(near) >= value else math.nextafter(near, math.inf)
    return near if math.isfinite(near) else None


def _hex(whole: int, exponent: int) -> str:
    if not whole:
        return "0x0p+0"
    zeros = (whole & -whole).bit_length() - 1
    return f"{'-' if whole < 0 else ''}{hex(abs(whole) >> zeros)}p{exponent + zeros:+d}"
