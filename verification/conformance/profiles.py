"""Tolerances for solvers that compute in float64 and in float32, with their reasons."""

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Profile:
    """The tolerances of one number type.

    A gap F(w, u) - F* is within a tolerance if it is at most that share of F*, plus 4 (n + d) units of
    rounding of ||o||^2: sums of n + d products, as F has them, are known no better than that.

    Attributes
    ----------
    name : str
    rounding : float
        Unit of rounding, half the distance from 1 to the next number.
    value : float
        Relative tolerance of L1: the optimum as a number, and what is said to be the objective.
    optimal : float
        Relative tolerance of L2, which labels and rankings rest on. In float64 the default of interior-point
        solvers, 1e-8. In float32 a gradient is known to about 1e-7 of its terms; the gap that this leaves is
        its square times the condition of the problem, 1e-5 at a condition of 1e9.
    zero : float
        L3: a weight that is proved to be 0 may be this share of the largest of its kind.
    """

    name: str
    rounding: float
    value: float
    optimal: float
    zero: float

    def allowed(self, relative: float, optimum: Fraction, target: Fraction, numbers: int) -> Fraction:
        """The largest gap: `relative` F* + 4 `numbers` u ||o||^2."""
        return Fraction(relative) * optimum + Fraction(4 * numbers * self.rounding) * target


FLOAT64 = Profile("float64", 2.0**-53, value=1e-6, optimal=1e-8, zero=1e-4)
FLOAT32 = Profile("float32", 2.0**-24, value=1e-3, optimal=1e-5, zero=1e-2)
PROFILES = {each.name: each for each in (FLOAT64, FLOAT32)}
