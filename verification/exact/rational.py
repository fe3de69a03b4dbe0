"""A problem, its points and its formulas over the rationals, in plain loops, for the checks.

A third derivation: it shares no formula with the library and none with `verification.exact.oracles`, whose
square roots it uses.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem
from verification.exact.oracles import Enclosure, square_root
from verification.problems.sources import Source

Exact = Sequence[Fraction]

ULP = Fraction(1, 2**52)
"""One unit in the last place, as a share of a number."""
SMALLEST = Fraction(1, 2**1074)
"""The smallest positive float: what one underflow can lose."""
LARGEST_MEASURE = 1e300
"""Measures stay finite, so that they can be written to JSON and driven up."""
LARGE = Fraction(2) ** 1000
"""Sums beyond this may overflow float64 on the way."""
FAR = 900
"""Points are scaled by no more than 2^900, so that their entries are finite."""


@dataclass(frozen=True)
class Data:
    """The data of a problem.

    Attributes
    ----------
    X : n rows of d Fractions
    o : d Fractions
    groups : m lists of columns
    lambda1, lambda2, lambda3 : Fraction
    """

    X: tuple[Exact, ...]
    o: Exact
    groups: tuple[tuple[int, ...], ...]
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: Problem) -> "Data":
        """Take every float as the rational that it is."""
        groups = tuple(tuple(np.arange(problem.d)[part].tolist()) for part in problem.modalities)
        return cls(
            tuple(exact(row) for row in problem.X),
            exact(problem.o),
            groups,
            *(Fraction(value) for value in problem.lambdas),
        )

    @property
    def shape(self) -> int:
        """The sum n + d."""
        return len(self.X) + len(self.o)

    def positive(self) -> "Data":
        """The same with |X| and -|o|: at |w| and -|u| its residuals are sums of magnitudes."""
        rows = tuple([abs(x) for x in row] for row in self.X)
        return replace(self, X=rows, o=[-abs(x) for x in self.o])

    def magnitudes(self, w: Exact, u: Exact) -> tuple[Exact, Exact]:
        """X'w - o and Xu - w with every sign taken as +: what their rounding is a share of."""
        p, q = self.positive().residuals([abs(x) for x in w], [-abs(x) for x in u])
        return p, [-x for x in q]

    def underflow(self, w: Exact, u: Exact) -> Fraction:
        """A bound of what underflow may take from any formula of degree 2 in X, w, u and o."""
        entries = [abs(x) for part in (*self.X, self.o, w, u) for x in part]
        factor = (1 + max(entries)) ** 3 * (1 + max(self.lambda1, self.lambda2, self.lambda3))
        return self.shape**2 * factor * SMALLEST

    def residuals(self, w: Exact, u: Exact) -> tuple[Exact, Exact]:
        """X'w - o and Xu - w."""
        p = [inner((row[k] for row in self.X), w) - self.o[k] for k in range(len(self.o))]
        q = [inner(row, u) - weight for row, weight in zip(self.X, w, strict=True)]
        return p, q

    def norms(self, u: Exact) -> list[Enclosure]:
        """||u^i|| of every modality."""
        return [square_root(squares(u[k] for k in group)) for group in self.groups]


def exact(values: Iterable[float]) -> list[Fraction]:
    """Take finite floats as the rationals that they are."""
    return [Fraction(float(value)) for value in values]


def total(values: Iterable[Fraction]) -> Fraction:
    """The exact sum."""
    return sum(values, Fraction(0))


def inner(x: Iterable[Fraction], y: Iterable[Fraction]) -> Fraction:
    """The exact inner product."""
    return total(a * b for a, b in zip(x, y, strict=True))


def squares(x: Iterable[Fraction]) -> Fraction:
    """The exact sum of squares."""
    return total(a * a for a in x)


def number(value: Fraction) -> float:
    """The nearest float, infinite beyond the largest."""
    try:
        return float(value)
    except OverflowError:
        return np.inf if value > 0 else -np.inf


def share(part: Fraction, whole: Fraction) -> float:
    """Divide `part` by `whole`, as a float from 0 to `LARGEST_MEASURE`; that where only `whole` is 0."""
    if part <= 0:
        return 0.0
    return min(number(part / whole), LARGEST_MEASURE) if whole else LARGEST_MEASURE


def is_finite(*vectors: np.ndarray) -> bool:
    """Whether no entry is NaN or infinite, as those of weights beyond float64 are."""
    return all(bool(np.isfinite(vector).all()) for vector in vectors)


def drawn_point(problem: Problem, source: Source) -> tuple[Vector, FeatureVector]:
    """Draw (w, u) of the size that optima have: about ||o|| / ||X|| and ||o|| / ||X||^2."""
    views, target = _exponent(problem.X), _exponent(problem.o)
    w, u = source.matrix(1, problem.n)[0], source.matrix(1, problem.d)[0]
    return _shifted(w, target - views), _shifted(u, target - 2 * views)


def _exponent(values: np.ndarray) -> int:
    return int(np.frexp(np.abs(values).max())[1])


def _shifted(values: np.ndarray, exponent: int) -> np.ndarray:
    with np.errstate(under="ignore"):
        return np.asarray(np.ldexp(values, max(-FAR, min(FAR, exponent))))
