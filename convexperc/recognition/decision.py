"""What the objects are compared by: the optimum, as in the paper, or the share of the template it leaves."""

from enum import Enum

import numpy as np

from convexperc.certificate.data_bounds import Intervals
from convexperc.certificate.rounding import U
from convexperc.errors import DecisionError


class Decision(Enum):
    """How the label follows from the optima F*_j of the templates o_j."""

    OBJECTIVE = "objective"
    """The lowest F*_j. Paper: Algorithm 1. As F*_j <= ||o_j||^2, a short template wins by its length."""
    EXPLAINED_FRACTION = "explained fraction"
    """The largest 1 - F*_j / ||o_j||^2, in [0, 1]: how much of its template the views explain. The same where
    all templates have one length."""

    @classmethod
    def of(cls, value: object) -> "Decision":
        """Read a decision, or its value; "explained share" is the former name of the second.

        Raises
        ------
        DecisionError
            There is no such decision.
        """
        if isinstance(value, cls):
            return value
        if isinstance(value, str):
            for decision in cls:
                if value == decision.value:
                    return decision
            if value == "explained share":
                return cls.EXPLAINED_FRACTION
        names = ", ".join(repr(decision.value) for decision in cls)
        raise DecisionError("decision", value=value, must=f"must be one of {names}")


def costs(decision: Decision, optima: Intervals, squares: Intervals) -> Intervals:
    """Bound what is compared, the lowest being best: F*_j, or F*_j / ||o_j||^2 (Lemma R53).

    Parameters
    ----------
    decision : Decision
    optima : lower, upper : float64 (p,)
        Of F*_j; lower >= 0.
    squares : lower, upper : float64 (p,)
        Of ||o_j||^2.

    Returns
    -------
    lower, upper : float64 (p,)
        Rounded outwards. A template of length 0 leaves all of itself: its share is 1.
    """
    if decision is Decision.OBJECTIVE:
        return optima
    (lower, upper), (least, most) = optima, squares
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        low = np.where(most > 0.0, lower / most * (1.0 - 4 * U) - 2.0**-1000, 1.0)
        high = np.where(most > 0.0, upper / least * (1.0 + 4 * U) + 2.0**-1000, 1.0)
    low = np.where(np.isfinite(low), np.clip(low, 0.0, 1.0), 0.0)
    return low, np.where(np.isfinite(high), np.minimum(high, 1.0), 1.0)
