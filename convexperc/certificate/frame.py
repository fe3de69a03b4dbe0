"""The normalised data of one problem, with what is known of its rounding."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from convexperc.certificate.rounding import (
    UNDERFLOW,
    Ball,
    Floats,
    Groups,
    U,
    norms_by_group,
    product,
    smallest_singular_value,
    squared_norm,
)
from convexperc.problem.arrays import FeatureVector, Matrix
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Bounds, Scaling


@dataclass(frozen=True, eq=False)
class Frame:
    """The normalised data; what many points share is computed once.

    Attributes
    ----------
    X, o : float64 (n, d) and (d,)
        Normalised data, each entry within `entry_error`.
    lambda1, lambda2, lambda3 : (lower, upper)
        Normalised lambdas. The lower ones make dual points, the upper ones bound F from above: a smaller
        lambda can only lower the optimum.
    """

    X: Matrix
    o: FeatureVector
    modalities: Modalities
    lambda1: Bounds
    lambda2: Bounds
    lambda3: Bounds
    entry_error: float

    @classmethod
    def of(cls, problem: Problem, scaling: Scaling) -> "Frame":
        """Normalise `problem` by `scaling`."""
        X, o, error = scaling.data(problem)
        one, two, three = scaling.lambdas(problem)
        return cls(X, o, problem.modalities, one, two, three, error)

    @cached_property
    def target(self) -> Ball:
        """O with its entry error."""
        return Ball(self.o, np.full(self.o.shape, self.entry_error))

    @cached_property
    def target_square(self) -> Bounds:
        """Bounds of ||o||^2."""
        return squared_norm(self.target)

    @cached_property
    def groups(self) -> Groups:
        """The columns of each modality."""
        return Groups.of(tuple(self.modalities), self.modalities.sizes)

    @cached_property
    def absolute(self) -> Matrix:
        """|X|, entry by entry."""
        return np.asarray(np.abs(self.X))

    @cached_property
    def row_squares(self) -> Floats:
        """Upper bounds of ||x^j||^2, shape (n,)."""
        d = self.X.shape[1]
        return np.asarray(np.einsum("ij,ij->i", self.X, self.X) * (1.0 + 4 * (d + 8) * U) + d * UNDERFLOW)

    @cached_property
    def block_lengths(self) -> Floats:
        """Upper bounds of the Frobenius norms ||X_i||_F, shape (m,)."""
        squares = self.groups.sums(np.einsum("ij,ij->j", self.X, self.X))
        squares = squares * (1.0 + 4 * (self.X.size + 8) * U) + self.X.size * UNDERFLOW
        return np.asarray(np.nextafter(np.sqrt(squares), np.inf))

    @cached_property
    def smallest_singular_value(self) -> float:
        """Lower bound of sigma_min(X')."""
        return smallest_singular_value(self.X, self.entry_error)

    def times_rows(self, x: Ball) -> Ball:
        """X x for x of shape (d,)."""
        return product(self.X, x, self.entry_error, self.absolute)

    def times_columns(self, x: Ball) -> Ball:
        """X' x for x of shape (n,)."""
        return product(self.X.T, x, self.entry_error, self.absolute.T)

    def modality_norms(self, x: Ball) -> tuple[Floats, Floats]:
        """Lower and upper bounds, shape (m,), of the 2-norm of each modality's part of x of shape (d,)."""
        return norms_by_group(x, self.groups)
