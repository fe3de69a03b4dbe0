"""The problem in n dimensions, over the rationals: what the referee minimises in place of F."""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from flint import fmpq_mat

from convexperc.problem.problem import Problem
from verification.exact.balls import exact
from verification.exact.numbers import Rationals, fractions, objects
from verification.exact.problem import ExactProblem


@dataclass(frozen=True, eq=False)
class Reduced:
    """All that F* depends on: G = X X', c = X o, ||o||^2, K_i = X_i X_i' and the lambdas, exactly.

    Formula: u^i may be taken in the row space of X_i, so that u enters through X_i u^i and ||u^i|| alone.

    Attributes
    ----------
    G : Fractions (n, n)
    c : Fractions (n,)
    target : Fraction
        ||o||^2.
    K : tuple of m Fractions (n, n)
    lambda1, lambda2, lambda3 : Fraction
    """

    G: Rationals
    c: Rationals
    target: Fraction
    K: tuple[Rationals, ...]
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: Problem | ExactProblem) -> "Reduced":
        """Multiply out."""
        data = ExactProblem.of(problem)
        X, o = np.array(data.rows, dtype=object), np.array(data.target, dtype=object)
        blocks = [X[:, group] for group in data.groups]
        K = tuple(fractions(B @ B.T, data.unit**2) for B in blocks)
        c = fractions(X @ o, data.unit * data.target_unit)
        return cls(sum(K[1:], K[0]), c, Fraction(o @ o, data.target_unit**2), K, *data.lambdas)

    @property
    def zero(self) -> Rationals:
        """The vector 0, shape (n,)."""
        return np.array([Fraction(0)] * len(self.c), dtype=object)

    @property
    def coupled(self) -> bool:
        """Whether u has to be found: with lambda1 = 0 it is 0, with lambda3 = 0 least squares of Xu = w."""
        return bool(self.lambda1 and self.lambda3)

    @cached_property
    def P(self) -> Rationals | None:  # noqa: N802 - a matrix
        """Return the projector on the null space of X', (n, n), where min_u ||Xu - w||^2 = w'Pw counts.

        None where that space is {0}.
        """
        if self.lambda1 == 0 or self.lambda3:
            return None
        form, pivots = _echelon(sum(self.K[1:], self.K[0]))
        n = len(self.c)
        free = [j for j in range(n) if j not in pivots]
        if not free:
            return None
        N = objects([Fraction(0)] * (n * len(free)), (n, len(free)))
        N[free, range(len(free))] = Fraction(1)
        N[pivots] = -form[: len(pivots), free]
        basis = _matrix(N)
        across = basis.transpose()
        return _array(basis * (across * basis).solve(across))

    @property
    def H(self) -> Rationals:  # noqa: N802 - a matrix
        """G + lambda1 P, shape (n, n): the quadratic form of w where u does not matter."""
        return self.G if self.P is None else self.G + self.lambda1 * self.P

    def least_squares(self) -> Rationals:
        """Return one w with H w = c, exactly, shape (n,); c lies in the range of G."""
        form, pivots = _echelon(np.concatenate([self.H, self.c[:, None]], axis=1))
        w = self.zero
        w[pivots] = form[: len(pivots), -1]
        return w


def _echelon(A: Rationals) -> tuple[Rationals, list[int]]:
    """Reduced row echelon form over the rationals, and its pivot columns."""
    form, rank = _matrix(A).rref()
    work = _array(form)
    return work, [int(np.flatnonzero(row)[0]) for row in work[:rank]]


def _matrix(A: Rationals) -> fmpq_mat:
    return fmpq_mat([[exact(x) for x in row] for row in A])


def _array(A: fmpq_mat) -> Rationals:
    return objects([Fraction(int(x.numer()), int(x.denom())) for x in A.entries()], (A.nrows(), A.ncols()))
