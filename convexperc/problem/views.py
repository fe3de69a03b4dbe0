"""The views of one moment: X and its modalities, checked and copied once, and what all templates share."""

import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np

from convexperc.caching import cached_property
from convexperc.errors import ProblemError
from convexperc.problem.arrays import (
    Matrix,
    binary_exponent,
    is_power_of_two_times,
    real_array,
    times_power_of_two,
)
from convexperc.problem.modalities import Modalities
from convexperc.problem.reduction import Reduction


@dataclass(frozen=True, eq=False)
class Views:
    """What n robots see.

    Attributes
    ----------
    X : float64 (n, d), read-only
        Row i is robot i's feature vector.
    modalities : Modalities
        The partition of the d columns.
    exact : bool
        False where scaling by a power of two rounded an entry of X that underflowed.
    """

    X: Matrix
    modalities: Modalities
    exact: bool = True

    @classmethod
    def of(cls, X: Any, modalities: Any = None, d: int | None = None) -> "Views":
        """Copy and check; `modalities` as `Modalities.of` reads them, d the number of features if known.

        Raises
        ------
        ProblemError
            NaN, infinity, complex numbers, strings, a wrong shape, an empty X, an integer that overflows,
            another number of columns than d.
        ModalityError
            The modalities are not a partition of the columns.
        """
        matrix = real_array(X, "X", 2)
        if 0 in matrix.shape:
            must = "must have at least one row (robot) and one column"
            raise ProblemError("X", value=matrix.shape, must=must)
        if d is not None and matrix.shape[1] != d:
            must = f"must have {d} columns, as the templates have features"
            raise ProblemError("X", value=matrix.shape, must=must)
        return cls(matrix, Modalities.of(modalities, matrix.shape[1]))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the data, so that what comes back is read-only again."""
        return _rebuild, (self.X, self.modalities, self.exact)

    @cached_property
    def exponent(self) -> int:
        """x such that the longest row of X / 2^x has a length in [1/2, 1); 0 where X = 0."""
        return binary_exponent(self.X)

    @cached_property
    def reduction(self) -> Reduction:
        """The Gram matrices: one pass over X."""
        with np.errstate(over="ignore", invalid="ignore"):
            return Reduction.of(self.X, self.modalities)

    @property
    def normalised(self) -> "Views":
        """X / 2^exponent: the same object for as long as somebody holds it, since it is as large as X."""
        held: Views | None = self.__dict__.get("_normalised", lambda: None)()
        if held is None:
            held = self.divided(self.exponent)
            if held is not self:
                self.__dict__["_normalised"] = weakref.ref(held)
        return held

    def divided(self, exponent: int) -> "Views":
        """X / 2^exponent; the same object where the exponent is 0."""
        if exponent == 0:
            return self
        X = times_power_of_two(self.X, -exponent)
        exact = self.exact and is_power_of_two_times(X, self.X, -exponent)
        X.flags.writeable = False
        return Views(X, self.modalities, exact)


def _rebuild(X: Matrix, modalities: Modalities, exact: bool) -> Views:
    X.flags.writeable = False
    return Views(X, modalities, exact)
