"""What is proved of all templates of one set of views, from the reduced data alone."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.lasso import Distinct, bound_merged
from convexperc.certificate.reduced import (
    LARGEST_NUMBER,
    UNDERFLOW_SUM,
    AnswerBounds,
    GramBounds,
    bounding_kernel,
    new_room,
)
from convexperc.certificate.rounding import gamma
from convexperc.certificate.tolerances import Tolerances
from convexperc.problem.penalties import Penalties
from convexperc.problem.reduced import ReducedData

Intervals = tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]
"""Lower and upper bounds, one of each a template."""
SHORTENED = 1.0 - 2.0**-20
"""Taken off ||o_j||^2 where its rounding must not matter: it is off by less than a millionth."""


class Points(NamedTuple):
    """Reduced answers to k templates, normalised.

    Attributes
    ----------
    W : float64 (k, n)
    T : float64 (k, m)
        u_j^i = T_ji X_i' Q_j.
    Q : float64 (k, n)
        The dual points are a = 2(X'w - o), b = -2 Q_j.
    """

    W: Float[np.ndarray, "k n"]
    T: Float[np.ndarray, "k m"]
    Q: Float[np.ndarray, "k n"]


@dataclass(frozen=True, eq=False)
class DataBounds:
    """The reduced data with bounds of their rounding.

    Attributes
    ----------
    data : ReducedData
    shared : GramBounds
        G, K and their bounds, normalised.
    """

    data: ReducedData
    shared: GramBounds

    @classmethod
    def of(cls, data: ReducedData) -> "DataBounds":
        """Bound the lengths of the rows of X_ and of their parts, and all rounding (Lemma R40)."""
        n, m, squares = data.n, data.m, np.einsum("ijj->ij", data.K)
        g = gamma(data.views.reduction.depth + 4 * n + 4 * m + 64)
        lengths = np.sqrt(squares * (1.0 + 4 * g) + UNDERFLOW_SUM)
        rows = np.sqrt((lengths**2).sum(axis=0)) * (1.0 + g)
        blocks = np.sqrt((lengths**2).sum(axis=1)) * (1.0 + g)
        return cls(data, GramBounds(data.G, data.K, lengths, rows, blocks, g))

    @cached_property
    def squares(self) -> Intervals:
        """Bounds of ||o_j||^2; 0 and infinity where it is not sound, or arithmetic is not (Lemma R42)."""
        data, g = self.data, self.shared.gamma
        if broken_assumption(data.n):
            return np.zeros(data.p), np.full(data.p, np.inf)
        found = np.ldexp(data.targets, 2 * data.exponents)
        lower, upper = found * (1.0 - g), found * (1.0 + g)
        lower[~data.sound], upper[~data.sound] = 0.0, np.inf
        return lower, upper

    @cached_property
    def distinct(self) -> Distinct:
        """The views, equal ones taken together, for lambdas that make a lasso of the problem."""
        return Distinct.of(self.data.views.X, self.shared)

    @property
    def independent(self) -> bool:
        """Whether the distinct views are proved to be linearly independent."""
        return self.distinct.floor > 0.0

    def zero_is_optimal(self, penalties: Penalties) -> Bool[np.ndarray, " p"]:
        """Where lambda2 >= 2 ||X o_j||_inf is proved, so that w = u = 0 is an optimum (Lemma R44)."""
        if broken_assumption(self.data.n):
            return np.zeros(self.data.p, dtype=bool)
        size = np.abs(self.data.C) + 2.0 * self.shared.gamma * self.shared.rows
        lambda2 = self.data.normalised(penalties)[:, 1]
        return np.asarray(self.data.sound & (lambda2 >= (2.0 + 2.0**-40) * size.max(axis=1)))

    def usable(self, penalties: Penalties, lambdas: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, " p"]:
        """Where bounds can be given at these lambdas; the other templates are solved on the original data.

        Parameters
        ----------
        penalties : Penalties
        lambdas : float64 (p, 3)
            The same in each template's own units.
        """
        if penalties.uncoupled and not self.independent:
            return np.zeros(self.data.p, dtype=bool)
        inside = (lambdas >= 1.0 / LARGEST_NUMBER) & (lambdas <= LARGEST_NUMBER)
        for k, given in enumerate(penalties):
            if given == 0.0:
                inside[:, k] = True
        return np.asarray(inside.all(axis=1) & self.data.sound)

    def of_points(
        self,
        chosen: Int[np.ndarray, " k"],
        lambdas: Float[np.ndarray, "k 3"],
        points: Points,
        tolerances: Tolerances | None,
        *,
        uncoupled: bool,
    ) -> AnswerBounds:
        """Bound F* and the gaps of answers to some templates.

        Parameters
        ----------
        chosen : int (k,)
            The templates.
        lambdas : float64 (k, 3)
            In each template's own units.
        points : Points
        tolerances : Tolerances or None
            The search for a dual point ends with one that meets the relative one; None: with the first.
        uncoupled : bool
            Whether these lambdas make a lasso of the problem; see `Penalties`.

        Returns
        -------
        AnswerBounds
            In normalised units.
        """
        data = self.data
        if broken_assumption(data.n):
            return AnswerBounds.unknown(chosen.size, data.n, data.m)
        given = self.shared, data.C[chosen], data.targets[chosen], lambdas
        if uncoupled:
            return bound_merged(self.distinct, *given, *points)
        bounds = AnswerBounds.unknown(chosen.size, data.n, data.m)
        tolerance = math.inf if tolerances is None else tolerances.relative
        bounding_kernel(*given, *points, tolerance, new_room(data.n, data.m), bounds)
        if tolerances is None:
            return bounds
        missed = ~tolerances.met(bounds.gap, bounds.lower, given[2] * SHORTENED)
        if not missed.any() or not self.independent:
            return bounds
        below = bound_merged(self.distinct, *given, *points)  # tiny lambdas: rounding hides the dual point
        return bounds._replace(
            lower=np.maximum(bounds.lower, below.lower), gap=np.minimum(bounds.gap, below.gap)
        )
