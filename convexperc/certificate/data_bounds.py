"""What is proved of all templates of one set of views, from the reduced data alone."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.caching import cached_property
from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.cases import NO_EXCLUSION, AnswerBounds, Cases, Exclusion, GramBounds, new_numbers
from convexperc.certificate.lasso import Distinct, bound_merged
from convexperc.certificate.reduced import LARGEST_NUMBER, UNDERFLOW_SUM, bounding_kernel
from convexperc.certificate.rounding import gamma
from convexperc.certificate.tolerances import Tolerances
from convexperc.problem.arrays import every, highest, lowest
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
        n, m = data.n, data.m
        g = gamma(data.views.reduction.depth + 4 * n + 4 * m + 64)
        lengths = np.sqrt(data.K.reshape(m, -1)[:, :: n + 1] * (1.0 + 4 * g) + UNDERFLOW_SUM)
        squares = lengths * lengths
        rows = np.sqrt(np.add.reduce(squares, axis=0)) * (1.0 + g)
        blocks = np.sqrt(np.add.reduce(squares, axis=1)) * (1.0 + g)
        return cls(data, GramBounds(data.G, data.K, lengths, rows, blocks, g))

    @cached_property
    def squares(self) -> Intervals:
        """Bounds of ||o_j||^2; 0 and infinity where it is not sound, or arithmetic is not (Lemma R42)."""
        data, g = self.data, self.shared.gamma
        if broken_assumption(data.n):
            return np.zeros(data.p), np.full(data.p, np.inf)
        found = data.library.lengths.squares
        lower, upper = found * (1.0 - g), found * (1.0 + g)
        if not every(data.sound):
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
        if lowest(lambdas) >= 1.0 / LARGEST_NUMBER and highest(lambdas) <= LARGEST_NUMBER:
            return self.data.sound
        inside = (lambdas >= 1.0 / LARGEST_NUMBER) & (lambdas <= LARGEST_NUMBER)
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

        Returns
        -------
        AnswerBounds
            `known`, in normalised units.
        """
        data = self.data
        if uncoupled:
            self._put(known, chosen, self._merged(chosen, lambdas, points))
            return self.settled(chosen, lambdas, points, known, 0, tolerances, NO_EXCLUSION)
        tolerance = math.inf if tolerances is None else tolerances.relative
        missed = bounding_kernel(
            self.shared, Cases(data.C, data.targets, lambdas, *points), chosen, tolerance, *NO_EXCLUSION,
            new_numbers(data.n, data.m), known,
        )  # fmt: skip
        return self.settled(chosen, lambdas, points, known, missed, tolerances, NO_EXCLUSION)

    def settled(
        self,
        chosen: Int[np.ndarray, " k"],
        lambdas: Float[np.ndarray, "p 3"],
        points: Points,
        known: AnswerBounds,
        missed: int,
        tolerances: Tolerances | None,
        exclusion: Exclusion,
    ) -> AnswerBounds:
        """What `bound_reduced` has found, where it missed so many times what it searched for.

        Tiny lambdas hide the dual point in rounding: the lasso is looked at, too. Where the arithmetic is not
        sound, nothing is known.
        """
        data = self.data
        if broken_assumption(data.n):
            return self._put(known, chosen, AnswerBounds.unknown(chosen.size, data.n, data.m))
        if missed and tolerances is not None:
            met = tolerances.met(known.gap, known.lower, data.targets * SHORTENED)
            if exclusion.units.size:
                met |= known.lower * exclusion.units >= exclusion.most
            left = chosen[~met[chosen]]
            if left.size and self.independent:
                below = self._merged(left, lambdas, points)
                known.lower[left] = np.maximum(known.lower[left], below.lower)
                known.gap[left] = np.minimum(known.gap[left], below.gap)
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
