"""How narrow a gap must be: the one rule of what is certified."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from convexperc.errors import ToleranceError
from convexperc.problem.arrays import nonnegative_number

RELATIVE = 1e-9
"""Largest gap, as a share of F*, of a certified answer."""
ABSOLUTE = 1e-14
"""Largest gap, as a share of ||o||^2, certified whatever F* is: about the rounding of float64 data."""


@dataclass(frozen=True)
class Tolerances:
    """A gap is within the tolerances where it is at most a share of F*, or at most a share of ||o||^2.

    Attributes
    ----------
    relative : float
        Largest share of F*.
    absolute : float
        Largest share of ||o||^2.

    Raises
    ------
    ToleranceError
        One is no real number, negative, NaN or infinite.
    """

    relative: float
    absolute: float

    def __init__(self, relative: Any = RELATIVE, absolute: Any = ABSOLUTE) -> None:
        for name, value in (("relative", relative), ("absolute", absolute)):
            number = nonnegative_number(value, f"{name}_tolerance", error=ToleranceError)
            object.__setattr__(self, name, number)

    def met(self, gap: Any, lower: Any, target: Any) -> Any:
        """Whether gap <= relative * lower or gap <= absolute * target; false for NaN.

        Parameters
        ----------
        gap, lower, target : numbers, or float64 arrays of one shape
            A gap or a width, a lower bound of F*, and one of ||o||^2.

        Returns
        -------
        bool, or bool array of that shape
        """
        return (gap <= self.relative * lower) | (gap <= self.absolute * target)

    def met_by_shares(self, of_optimum: float, of_target: float) -> bool:
        """`met` for a gap that is given as shares of F* and of ||o||^2."""
        return of_optimum <= self.relative or of_target <= self.absolute

    def met_exactly(self, gap: Fraction, lower: Fraction, target: Fraction) -> bool:
        """`met` over the rationals."""
        return gap <= Fraction(self.relative) * lower or gap <= Fraction(self.absolute) * target
