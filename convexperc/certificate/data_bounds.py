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
    Cases,
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
    """Reduced answers to p templates, normalised.

    Attributes
    ----------
    W : float64 (p, n)
    T : float64 (p, m)
        u_j^i = T_ji X_i' Q_j.
    Q : float64 (p, n)
        The dual points are a = 2(X'w - o), b = -2 Q_j.
    """

    W: Float[np.ndarray, "p n"]
    T: Float[np.ndarray, "p m"]
    Q: Float[np.ndarray, "p n"]


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
        found = data.library.lengths.squares
        lower, upper = found * (1.0 - g), found * (1.0 + g)
        if not data.sound.all():
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
        if inside.all():
            return self.data.sound
        wanted = [k for k, given in enumerate(penalties) if given != 0.0]
        return np.asarray(inside[:, wanted].all(axis=1) & self.data.sound)

    def of_points(
        self,
        chosen: Int[np.ndarray, " k"],
        lambdas: Float[np.ndarray, "p 3"],
        points: Points,
        known: AnswerBounds,
        *,
        tolerances: Tolerances | None,
        uncoupled: bool,
        enough: Float[np.ndarray, " p"] | None = None,
    ) -> AnswerBounds:
        """Bound F* and the gaps of answers to some of the p templates.

        Parameters
        ----------
        chosen : int (k,)
            The templates.
        lambdas : float64 (p, 3)
            In each template's own units.
        points : Points
            Of all templates.
        known : AnswerBounds
            Of all templates; the rows of the chosen ones are overwritten.
        tolerances : Tolerances or None
            The search for a dual point ends with one that meets the relative one; None: with the first.
        uncoupled : bool
            Whether these lambdas make a lasso of the problem; see `Penalties`.
        enough : float64 (p,), optional
            Lower bounds of F* that settle what is asked, so that the search ends there too.

        Returns
        -------
        AnswerBounds
            `known`, in normalised units.
        """
        data = self.data
        if broken_assumption(data.n):
            return self._put(known, chosen, AnswerBounds.unknown(chosen.size, data.n, data.m))
        if uncoupled:
            return self._put(known, chosen, self._merged(chosen, lambdas, points))
        if enough is None:
            enough = np.full(data.p, np.inf)
        cases = Cases(data.C, data.targets, lambdas, *points)
        tolerance = math.inf if tolerances is None else tolerances.relative
        room = new_room(data.n, data.m)
        if bounding_kernel(self.shared, cases, chosen, tolerance, enough, room, known) == 0:
            return known
        assert tolerances is not None  # with an infinite tolerance none is missed
        met = tolerances.met(known.gap, known.lower, data.targets * SHORTENED) | (known.lower >= enough)
        missed = chosen[~met[chosen]]
        if missed.size and self.independent:  # tiny lambdas: rounding hides the dual point
            below = self._merged(missed, lambdas, points)
            known.lower[missed] = np.maximum(known.lower[missed], below.lower)
            known.gap[missed] = np.minimum(known.gap[missed], below.gap)
        return known

    def _merged(
        self, chosen: Int[np.ndarray, " k"], lambdas: Float[np.ndarray, "p 3"], points: Points
    ) -> AnswerBounds:
        """Bounds by the lasso over the distinct views."""
        data = self.data
        given = data.C[chosen], data.targets[chosen], lambdas[chosen]
        return bound_merged(self.distinct, self.shared, *given, *(rows[chosen] for rows in points))

    @staticmethod
    def _put(known: AnswerBounds, chosen: Int[np.ndarray, " k"], found: AnswerBounds) -> AnswerBounds:
        for mine, new in zip(known, found, strict=True):
            mine[chosen] = new
        return known
