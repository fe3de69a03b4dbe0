"""Problems whose data are rational numbers, with F, its optimality conditions and F* over the rationals.

A second derivation: nothing of `convexperc` is used but the data of a `Problem`.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

import numpy as np

from convexperc.errors import FileFormatError, ProblemError
from convexperc.problem import Problem
from verification.oracles import Enclosure, square_root
from verification.referee import optimum

Rational = tuple[Fraction, ...]
NUMBER = re.compile(r"-?[0-9]+(/[1-9][0-9]*)?")
LAMBDAS = ("lambda1", "lambda2", "lambda3")


@dataclass(frozen=True)
class ExactProblem:
    """The data of Eq. (full) as rational numbers.

    Attributes
    ----------
    X : tuple of n tuples of d Fractions
    o : tuple of d Fractions
    groups : tuple of tuples of int
        The columns of each modality.
    lambda1, lambda2, lambda3 : Fraction
    """

    X: tuple[Rational, ...]
    o: Rational
    groups: tuple[tuple[int, ...], ...]
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: Problem) -> "ExactProblem":
        """Take the floats of `problem` as the rationals that they are."""
        X = tuple(tuple(Fraction(float(x)) for x in row) for row in problem.X)
        groups = tuple(tuple(int(c) for c in np.arange(problem.d)[cols]) for cols in problem.modalities)
        o = tuple(Fraction(float(x)) for x in problem.o)
        return cls(X, o, groups, *(Fraction(value) for value in problem.lambdas))

    @classmethod
    def small(
        cls, X: Sequence[Sequence[Any]], o: Sequence[Any], sizes: Sequence[int], *lambdas: Any
    ) -> "ExactProblem":
        """Build it from integers, Fractions or strings p/q; `sizes` as in ``[2, 1]``, the lambdas in order."""
        rows = tuple(tuple(Fraction(x) for x in row) for row in X)
        return cls(rows, tuple(Fraction(x) for x in o), _groups(sizes), *(Fraction(x) for x in lambdas))

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "ExactProblem":
        """Read what `as_json` wrote.

        Raises
        ------
        FileFormatError
            Numbers that are no strings p/q, shapes that do not fit, modalities that are no partition, or a negative lambda.
        """
        sizes = data["modalities"]
        if not isinstance(sizes, list) or not all(type(size) is int and size > 0 for size in sizes):
            must = "must be a list of sizes, whole numbers >= 1"
            raise FileFormatError("problem: modalities", value=sizes, must=must)
        X = [_written(row, "X") for row in data["X"]]
        lambdas = _written([data[name] for name in LAMBDAS], "lambda1 .. lambda3")
        found = cls.small(X, _written(data["o"], "o"), sizes, *lambdas)
        if not found.X or any(len(row) != found.d for row in found.X):
            must = f"must have rows of {found.d} entries, as o has"
            raise FileFormatError("problem: X", value=data["X"], must=must)
        if sum(len(group) for group in found.groups) != found.d:
            must = f"must be sizes that add up to {found.d}, the number of columns"
            raise FileFormatError("problem: modalities", value=data["modalities"], must=must)
        for name, value in zip(LAMBDAS, found.lambdas, strict=True):
            if value < 0:
                raise FileFormatError(f"problem: {name}", value=str(value), must="must be >= 0")
        return found

    def as_json(self) -> dict[str, Any]:
        """Plain data with numbers as strings p/q.

        Raises
        ------
        ProblemError
            The columns of a modality do not follow each other.
        """
        sizes = [len(group) for group in self.groups]
        if _groups(sizes) != self.groups:
            must = "must follow each other, modality by modality, in a record"
            raise ProblemError("the columns of the modalities", value=self.groups, must=must)
        data: dict[str, Any] = {"X": [texts(row) for row in self.X], "o": texts(self.o), "modalities": sizes}
        return data | dict(zip(LAMBDAS, texts(self.lambdas), strict=True))

    @property
    def n(self) -> int:
        """Number of robots."""
        return len(self.X)

    @property
    def d(self) -> int:
        """Number of features."""
        return len(self.o)

    @property
    def m(self) -> int:
        """Number of modalities."""
        return len(self.groups)

    @property
    def lambdas(self) -> Rational:
        """(lambda1, lambda2, lambda3)."""
        return self.lambda1, self.lambda2, self.lambda3

    @property
    def numbers(self) -> Iterator[Fraction]:
        """Every number of the data."""
        for row in self.X:
            yield from row
        yield from self.o
        yield from self.lambdas

    @cached_property
    def columns(self) -> tuple[Rational, ...]:
        """X by columns."""
        return tuple(zip(*self.X, strict=True))

    def for_template(self, o: Sequence[Fraction]) -> "ExactProblem":
        """The same problem for another template."""
        return replace(self, o=tuple(o))

    def in_floats(self) -> Problem | None:
        """The same problem in float64, or None where a number is not representable."""
        try:
            rounded = [float(value) for value in self.numbers]
        except OverflowError:
            return None
        if [Fraction(value) for value in rounded] != list(self.numbers):
            return None
        X = [[float(x) for x in row] for row in self.X]
        l1, l2, l3 = (float(value) for value in self.lambdas)
        named = {f"m{i}": list(group) for i, group in enumerate(self.groups, 1)}
        o = [float(x) for x in self.o]
        return Problem(X, o, modalities=named, lambda1=l1, lambda2=l2, lambda3=l3)


def _groups(sizes: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    starts = [sum(sizes[:i]) for i in range(len(sizes))]
    return tuple(tuple(range(at, at + size)) for at, size in zip(starts, sizes, strict=True))


def _written(values: Any, name: str) -> Rational:
    """Read strings p/q, and nothing else."""
    if not isinstance(values, list) or not all(isinstance(v, str) and NUMBER.fullmatch(v) for v in values):
        raise FileFormatError(f"problem: {name}", value=values, must="must be strings p/q")
    return tuple(Fraction(value) for value in values)


def texts(values: Sequence[Fraction]) -> list[str]:
    """Each number as p/q."""
    return [str(value) for value in values]


def dot(x: Sequence[Fraction], y: Sequence[Fraction]) -> Fraction:
    """The exact inner product."""
    return sum((a * b for a, b in zip(x, y, strict=True)), Fraction(0))


def residuals(problem: ExactProblem, w: Rational, u: Rational) -> tuple[Rational, Rational]:
    """Return p = X'w - o, shape (d,), and q = Xu - w, shape (n,)."""
    p = tuple(dot(column, w) - target for column, target in zip(problem.columns, problem.o, strict=True))
    q = tuple(dot(row, u) - weight for row, weight in zip(problem.X, w, strict=True))
    return p, q


def value(problem: ExactProblem, w: Rational, u: Rational) -> Enclosure:
    """Enclose F(w, u) at a rational point; exact where the norms of the u^i are rational."""
    p, q = residuals(problem, w, u)
    smooth = dot(p, p) + problem.lambda1 * dot(q, q) + problem.lambda2 * sum(map(abs, w), Fraction(0))
    roots = [rational_root(dot(v, v)) for v in ([u[j] for j in group] for group in problem.groups)]
    low, high = (sum((getattr(r, end) for r in roots), Fraction(0)) for end in ("lower", "upper"))
    return Enclosure(smooth + problem.lambda3 * low, smooth + problem.lambda3 * high)


def rational_root(square: Fraction) -> Enclosure:
    """Enclose sqrt(square); exact if the root is rational, not only if it is dyadic."""
    whole = square_root(Fraction(square.numerator * square.denominator))
    return Enclosure(whole.lower / square.denominator, whole.upper / square.denominator)


def is_optimal(problem: ExactProblem, w: Rational, u: Rational, held: Sequence[int] = ()) -> bool:
    """Whether (w, u) minimises F among the points that are 0 where it is held, decided exactly.

    F is convex, so a subgradient that vanishes is proof: with a = 2(X'w - o) and b = 2 lambda1 (Xu - w),
    (Xa - b)_j = -lambda2 sign(w_j), or at most lambda2 in size where w_j = 0, and
    X_i'b = -lambda3 u^i / ||u^i||, or at most lambda3 in length where u^i = 0.

    Parameters
    ----------
    problem : ExactProblem
    w, u : Fractions (n,), (d,)
    held : sequence of int
        Positions in (w, u) that are held at 0; of u, only whole modalities.

    Returns
    -------
    bool
    """
    p, q = residuals(problem, w, u)
    a = tuple(2 * x for x in p)
    b = tuple(2 * problem.lambda1 * x for x in q)
    if any((*w, *u)[j] for j in held):
        return False
    views = all(
        _balanced([dot(row, a) - b[j]], [w[j]], problem.lambda2)
        for j, row in enumerate(problem.X)
        if j not in held
    )
    pull = [dot(column, b) for column in problem.columns]
    return views and all(
        _balanced([pull[k] for k in group], [u[k] for k in group], problem.lambda3)
        for group in problem.groups
        if problem.n + group[0] not in held
    )


def _balanced(slope: Sequence[Fraction], point: Sequence[Fraction], weight: Fraction) -> bool:
    """Whether 0 lies in slope + weight times the subdifferential of the length at `point`."""
    if not any(point):
        return dot(slope, slope) <= weight * weight
    parallel = dot(slope, slope) * dot(point, point) == dot(slope, point) ** 2
    opposite = dot(slope, point) <= 0 if weight else not any(slope)
    return parallel and opposite and dot(slope, slope) == weight * weight


def optimum_bounds(problem: ExactProblem) -> Enclosure:
    """Enclose F*, proved: the referee's interval of the same problem in whole numbers, scaled back.

    Formula: X by s, o by t, lambda1 by s^2, lambda2 by s t, lambda3 by s^2 t multiply F* by t^2.

    Raises
    ------
    ProblemError
        The whole numbers do not fit into float64.
    """
    found = problem.in_floats()
    if found is not None:
        return optimum(found).value
    s = lcm(*(x.denominator for row in problem.X for x in row), problem.lambda1.denominator)
    scaled_weights = (problem.lambda2 * s, problem.lambda3 * s * s)
    t = lcm(*(x.denominator for x in (*problem.o, *scaled_weights)))
    X = tuple(tuple(x * s for x in row) for row in problem.X)
    o = tuple(x * t for x in problem.o)
    l1, l2, l3 = problem.lambda1 * s * s, problem.lambda2 * s * t, problem.lambda3 * s * s * t
    whole = ExactProblem(X, o, problem.groups, l1, l2, l3).in_floats()
    if whole is None:
        remedy = "Give data with smaller denominators."
        raise ProblemError("rational data", value=problem, must="must fit into float64", remedy=remedy)
    bounds = optimum(whole).value
    return Enclosure(bounds.lower / t**2, bounds.upper / t**2)
