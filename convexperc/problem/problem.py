"""One template's problem: the data and the three lambdas, validated once and frozen."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from convexperc.errors import ProblemError, check_type
from convexperc.problem.arrays import FeatureVector, Matrix, real_array
from convexperc.problem.modalities import Modalities
from convexperc.problem.penalties import Penalties
from convexperc.problem.views import Views


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
    `views` holds X and the modalities as the templates of one set of views share them, and `penalties` the
    three lambdas.

    Paper: Eq. (full).
    """

    # Of each problem, and no fields, so that `dataclasses.replace` takes X and the lambdas.
    views: ClassVar[Views]
    penalties: ClassVar[Penalties]
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
        views = Views.of(X, modalities)
        self._fill(views, _target(o, views), Penalties(lambda1, lambda2, lambda3))

    @classmethod
    def of(cls, views: Views, o: Any, penalties: Penalties) -> "Problem":
        """The problem of one template; the views are shared, not copied.

        Raises
        ------
        ProblemError
            As for `o` above.
        """
        check_type(views, Views, "views", ProblemError)
        check_type(penalties, Penalties, "penalties", ProblemError)
        problem = object.__new__(cls)
        problem._fill(views, _target(o, views), penalties)
        return problem

    def _fill(self, views: Views, o: FeatureVector, penalties: Penalties) -> None:
        one, two, three = penalties
        self.__dict__.update(
            X=views.X, o=o, modalities=views.modalities, lambda1=one, lambda2=two, lambda3=three, views=views,
            penalties=penalties,
        )  # fmt: skip

    def for_template(self, o: Any) -> "Problem":
        """The same problem for another template; X is shared, not copied. Errors as for `o` above."""
        return Problem.of(self.views, o, self.penalties)

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


def _target(o: Any, views: Views) -> FeatureVector:
    """A read-only copy of o, with as many entries as X has columns."""
    target = real_array(o, "o", 1)
    d = views.X.shape[1]
    if target.shape[0] != d:
        must = f"must have one entry for each of the {d} columns of X"
        raise ProblemError("o", value=target.shape, must=must)
    return target


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
        and first.modalities.same(second.modalities)
    )
