"""What a solver claims, and what is returned: the answer together with its proof."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.certificate import Certificate
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem


class Status(Enum):
    """What is known of an answer; decided by its certificate alone."""

    CERTIFIED = "certified"
    """F(w, u) - F* is proved to be within the tolerances."""
    ENCLOSED = "enclosed"
    """F* is enclosed within the tolerances, but no float64 point (w, u) was found that attains it."""
    NOT_CERTIFIED = "not certified"
    """Nothing is proved beyond the certificate's bounds, whatever the solver said."""


@dataclass(frozen=True)
class Timings:
    """Wall-clock seconds of each stage.

    Attributes
    ----------
    normalise : float
    solve : float
    certify : float
        Also of ball arithmetic where the float64 certificate misses.
    """

    normalise: float
    solve: float
    certify: float

    @property
    def total(self) -> float:
        """Seconds in all."""
        return self.normalise + self.solve + self.certify


@dataclass(frozen=True, eq=False)
class Solution:
    """An answer with its proof. Holds no solver object, so it pickles.

    Attributes
    ----------
    problem : Problem
        The problem as given.
    w : float64 (n,), read-only
    u : float64 (d,), read-only
    certificate : Certificate
        For the problem as given.
    solver : str
        Which solver answered.
    solver_status : str
        What that solver said of its answer; not a proof, and not used.
    iterations : int
    timings : Timings
    reason : str
        Why ball arithmetic did not prove more; empty where it did, or was not asked.
    """

    problem: Problem
    w: Vector
    u: FeatureVector
    certificate: Certificate
    solver: str
    solver_status: str
    iterations: int
    timings: Timings = field(repr=False)
    reason: str = ""

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.w.flags.writeable = self.u.flags.writeable = False

    @property
    def status(self) -> Status:
        """Decided by the certificate alone."""
        if self.certificate.certified:
            return Status.CERTIFIED
        return Status.ENCLOSED if self.certificate.enclosed else Status.NOT_CERTIFIED

    @property
    def value(self) -> float:
        """Upper end of the enclosure of F(w, u)."""
        return self.certificate.objective[1]

    @property
    def modality_norms(self) -> NDArray[np.float64]:
        """||u^i||_2 of each modality, shape (m,)."""
        return self.problem.modalities.norms(self.u)

    def duality_gap(self) -> float:
        """Upper bound of F(w, u) - F*."""
        return self.certificate.gap

    def is_optimal(self, eps: float) -> bool:
        """Whether F(w, u) - F* <= eps is proved."""
        return self.certificate.is_optimal(eps)
