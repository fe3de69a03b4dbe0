"""The three lambdas."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from convexperc.errors import ProblemError
from convexperc.problem.arrays import nonnegative_number


@dataclass(frozen=True)
class Penalties:
    """How much each term of F counts beside ||X'w - o||^2; iterates as (lambda1, lambda2, lambda3).

    Attributes
    ----------
    lambda1 : float
        Of the coupling ||Xu - w||^2.
    lambda2 : float
        Of ||w||_1, which selects views.
    lambda3 : float
        Of sum_i ||u^i||_2, which selects modalities.

    Raises
    ------
    ProblemError
        One is no real number, negative, NaN or infinite. Each may be 0.
    """

    lambda1: float
    lambda2: float
    lambda3: float

    def __init__(self, lambda1: Any, lambda2: Any, lambda3: Any) -> None:
        for name, value in (("lambda1", lambda1), ("lambda2", lambda2), ("lambda3", lambda3)):
            object.__setattr__(self, name, nonnegative_number(value, name))

    @classmethod
    def of(cls, values: Any) -> "Penalties":
        """Read penalties, or three numbers in the order lambda1, lambda2, lambda3.

        Raises
        ------
        ProblemError
            As for `Penalties`; also not three values.
        """
        if isinstance(values, cls):
            return values
        try:
            one, two, three = values
        except (TypeError, ValueError):
            must = "must be Penalties or three numbers (lambda1, lambda2, lambda3)"
            raise ProblemError("penalties", value=values, must=must) from None
        return cls(one, two, three)

    def __iter__(self) -> Iterator[float]:
        return iter((self.lambda1, self.lambda2, self.lambda3))

    @property
    def uncoupled(self) -> bool:
        """Whether the coupling costs nothing, so that F* is that of a lasso where views are independent.

        With lambda1 = 0, u = 0 is best; with lambda3 = 0 some u has Xu = w.
        """
        return self.lambda1 == 0.0 or self.lambda3 == 0.0
