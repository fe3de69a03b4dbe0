"""Another rule: every view has to explain the object by itself, and what it leaves is added up.

Where the paper joins the views in one problem, in which a view that fits is enough, this rule takes, for each
object with the references o in R, the optimum of

    min over o_i in R and w_i, u_i, for every view i, of
    sum_i ||x_i w_i - o_i||^2 + lambda1 ||x_i' u_i - w_i||^2 + lambda2 |w_i| + lambda3 sum_k ||u_i^k||_2

which is the sum over the views of the lowest optimum of the paper's problem with that view alone. As
0 <= F* <= ||o||^2, one view changes the sum by at most the largest ||o||^2, however well it fits another
object. The sum is bounded by the bounds of its parts.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from convexperc.caching import cached_property
from convexperc.certificate.data_bounds import Intervals
from convexperc.errors import check_type
from convexperc.recognition.label import recognize_each
from convexperc.recognition.recognition import Recognition, margin_of


@dataclass(frozen=True, eq=False)
class EachView:
    """What the views say one by one, added up.

    Attributes
    ----------
    views : tuple of n str
        Names of the robots.
    recognitions : tuple of n Recognition
        Of each view alone, with an answer for every reference.
    """

    views: tuple[str, ...]
    recognitions: tuple[Recognition, ...]

    @classmethod
    def of(cls, found: Recognition) -> "EachView":
        """Solve for every view of a recognition alone, with its library, lambdas and decision."""
        check_type(found, Recognition, "found")
        return cls(found.views, recognize_each(found))

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects."""
        return self.recognitions[0].objects

    @cached_property
    def costs(self) -> Intervals:
        """Proved bounds of the sum of each object, shape (k,) each, rounded outwards."""
        ends = []
        for side, way in ((0, -math.inf), (1, math.inf)):
            parts = np.stack([_by_object(found, found.costs[side]) for found in self.recognitions])
            sums = [math.nextafter(_sum(column), way) for column in parts.T.tolist()]
            ends.append(np.maximum(sums, 0.0))
        return ends[0], ends[1]

    @cached_property
    def candidates(self) -> tuple[str, ...]:
        """The objects that may have the lowest sum, best first."""
        lower, upper = self.costs
        near = (lower <= upper.min()).nonzero()[0]
        return tuple(self.objects[j] for j in near[np.argsort(upper[near], kind="stable")].tolist())

    @property
    def label(self) -> str | None:
        """The object that is proved to have the lowest sum; None where none is."""
        return self.candidates[0] if len(self.candidates) == 1 else None

    @property
    def margin(self) -> tuple[float, float] | None:
        """Proved bounds of max(0, 1 - c1 / c2), c1 being the lowest sum, c2 the next; None for one object."""
        return margin_of(self.costs, np.arange(len(self.objects)) == self.objects.index(self.candidates[0]))


def _sum(values: list[float]) -> float:
    """The exact sum, rounded; infinite beyond the range of float64."""
    try:
        return math.fsum(values)
    except OverflowError:
        return math.inf


def _by_object(found: Recognition, ends: Float[np.ndarray, " p"]) -> Float[np.ndarray, " k"]:
    """The least of each object's references."""
    least = np.full(len(found.objects), np.inf)
    np.minimum.at(least, found.answers.data.library.owners, ends)
    return least
