"""One template's problem: the data and the three lambdas, validated once and frozen."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from convexperc.errors import ProblemError
from convexperc.problem.arrays import FeatureVector, Matrix, nonnegative_number, real_array
from convexperc.problem.modalities import Modalities


@dataclass(frozen=True, eq=False)
class Problem:
    """minimise ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||_2.

    Attributes
    ----------
    X : float64 (n, d), read-only
        Row i is robot i's feature vector.
    o : float64 (d,), read-only
        Reference features of one object.
    modalities : Modalities
        The partition of the d columns. Anything that `Modalities.of` reads is accepted.
    lambda1, lambda2, lambda3 : float
        Coupling, view selection and modality selection; finite and >= 0, each may be 0.

    Raises
    ------
    ProblemError
        NaN, infinity, complex numbers, strings, wrong shapes, an empty X, a negative lambda, an integer
        that overflows float64.
    ModalityError
        The modalities are not a partition of the columns.

    Notes
    -----
    Paper: Eq. (full).
    """

    X: Matrix
    o: FeatureVector
    modalities: Modalities = field(kw_only=True)
    lambda1: float = field(kw_only=True)
    lambda2: float = field(kw_only=True)
    lambda3: float = field(kw_only=True)

    def __init__(
        self,
        X: Any,
        o: Any,
        *,
        lambda1: Any,
        lambda2: Any,
        lambda3: Any,
        modalities: Any = None,
    ) -> None:
        views = real_array(X, "X", 2)
        target = real_array(o, "o", 1)
        if 0 in views.shape:
            raise ProblemError(
                "X", value=views.shape, must="must have at least one row (robot) and one column"
            )
        if target.shape[0] != views.shape[1]:
            must = f"must have one entry for each of the {views.shape[1]} columns of X"
            raise ProblemError("o", value=target.shape, must=must)
        put = object.__setattr__
        put(self, "X", views)
        put(self, "o", target)
        put(self, "modalities", Modalities.of(modalities, views.shape[1]))
        put(self, "lambda1", nonnegative_number(lambda1, "lambda1"))
        put(self, "lambda2", nonnegative_number(lambda2, "lambda2"))
        put(self, "lambda3", nonnegative_number(lambda3, "lambda3"))

    def for_template(self, o: Any) -> "Problem":
        """The same problem for another template; X is shared, not copied.

        Raises
        ------
        ProblemError
            As for `o` above.
        """
        target = real_array(o, "o", 1)
        if target.shape[0] != self.d:
            must = f"must have one entry for each of the {self.d} columns of X"
            raise ProblemError("o", value=target.shape, must=must)
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__, o=target)
        return other

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the data, so that what comes back is checked and read-only again."""
        return _rebuild, (self.X, self.o, self.modalities, self.lambdas)

    @property
    def n(self) -> int:
        """Number of robots (views)."""
        return int(self.X.shape[0])

    @property
    def d(self) -> int:
        """Number of features."""
        return int(self.X.shape[1])

    @property
    def m(self) -> int:
        """Number of modalities."""
        return len(self.modalities)

    @property
    def lambdas(self) -> tuple[float, float, float]:
        """(lambda1, lambda2, lambda3)."""
        return self.lambda1, self.lambda2, self.lambda3

    def blocks(self) -> tuple[Matrix, ...]:
        """X_1 ... X_m, the columns of each modality."""
        return tuple(self.X[:, columns] for columns in self.modalities)

    def __repr__(self) -> str:
        l1, l2, l3 = self.lambdas
        sizes = dict(zip(self.modalities.names, self.modalities.sizes, strict=True))
        return (
            f"Problem(n={self.n}, d={self.d}, modalities={sizes}, lambda1={l1}, lambda2={l2}, lambda3={l3})"
        )


def _rebuild(
    X: Matrix, o: FeatureVector, modalities: Modalities, lambdas: tuple[float, float, float]
) -> Problem:
    lambda1, lambda2, lambda3 = lambdas
    return Problem(X, o, modalities=modalities, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3)


def same_data(first: Problem, second: Problem) -> bool:
    """Tell whether two problems hold bit for bit the same data, partition and lambdas."""
    return (
        first.lambdas == second.lambdas
        and np.array_equal(first.X, second.X)
        and np.array_equal(first.o, second.o)
        and len(first.modalities) == len(second.modalities)
        and all(
            np.array_equal(np.r_[a], np.r_[b])
            for a, b in zip(first.modalities, second.modalities, strict=True)
        )
    )
