"""Other ways to join what the views say, beside the paper's: nothing of them is proved, or optimised.

Each looks at the squared distances ||x_i - o_j||^2 of views and references, which the Gram matrices and X O
give without another look at the features.

    vote        each view votes for the object of the nearest reference; of equal votes the smaller sum of
                distances decides
    mean        the object of the reference nearest to the mean of the views
    best view   the object of the reference that is nearest to any view
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import NDArray

from convexperc.errors import check_type
from convexperc.problem.arrays import binary_exponent
from convexperc.problem.reduced import ReducedData


@dataclass(frozen=True, eq=False)
class Rules:
    """What each rule says of the same views and references.

    Attributes
    ----------
    nearest : tuple of n str
        The object nearest to each view.
    distances : float64 (n, k)
        Squared distance of each view from the nearest reference of each object.
    vote, mean, best_view : str
        The object by each rule.
    votes : dict of str to int
        Views for each object that has any, most first.
    lowest : str
        The first candidate by the paper's rule, as decided.
    disagreeing : tuple of str
        Robots whose nearest object is another one than `lowest`.
    """

    nearest: tuple[str, ...]
    distances: Float[np.ndarray, "n k"]
    vote: str
    mean: str
    best_view: str
    votes: dict[str, int]
    lowest: str
    disagreeing: tuple[str, ...]

    @classmethod
    def of(cls, data: ReducedData, robots: Sequence[str], lowest: str) -> "Rules":
        """Apply all of them; numbers are to rounding. See `Recognition.rules`."""
        check_type(data, ReducedData, "data")
        objects = data.library.objects
        views, mean, exponent = _distances(data)
        distances, to_mean = _by_object(data, views), _by_object(data, mean[None])[0]
        nearest = tuple(objects[place] for place in distances.argmin(axis=1).tolist())
        votes, sums = Counter(nearest), dict(zip(objects, distances.sum(axis=0).tolist(), strict=True))
        ranked = sorted(votes, key=lambda name: (-votes[name], sums[name]))
        return cls(
            nearest, _scaled(distances, 2 * exponent), ranked[0], objects[int(to_mean.argmin())],
            objects[int(distances.min(axis=0).argmin())], {name: votes[name] for name in ranked}, lowest,
            tuple(robot for robot, name in zip(robots, nearest, strict=True) if name != lowest),
        )  # fmt: skip


def _distances(data: ReducedData) -> tuple[Float[np.ndarray, "n p"], Float[np.ndarray, " p"], int]:
    """||x_i - o_j||^2, the same of the mean of the views, and e: both are to be multiplied by 2^2e."""
    n, lengths = data.n, data.library.lengths
    if data.sound.all():
        e = max(data.x, int(lengths.exponents.max()))
        G = np.ldexp(data.G, 2 * (data.x - e))
        products = np.ldexp(data.C, (data.x + lengths.exponents - 2 * e)[:, None]).T
        squares = _scaled(lengths.squares, -2 * e)
    else:  # the Gram matrices may have overflowed or underflowed
        X, columns = data.views.X, np.asarray(data.library.O, dtype=np.float64)
        e = max(binary_exponent(X), binary_exponent(columns.T))
        X, columns = _scaled(X, -e), _scaled(columns, -e)
        G, products = X @ X.T, X @ columns
        squares = np.einsum("dp,dp->p", columns, columns)
    views = G.diagonal()[:, None] - 2.0 * products + squares
    mean = G.sum() / n**2 - 2.0 * products.mean(axis=0) + squares
    return np.maximum(views, 0.0), np.maximum(mean, 0.0), e


def _scaled(values: NDArray[np.float64], exponent: int) -> NDArray[np.float64]:
    """Multiply by a power of two, in two steps where it is not a number itself."""
    half = exponent // 2
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(np.ldexp(np.ldexp(values, half), exponent - half))


def _by_object(data: ReducedData, distances: Float[np.ndarray, "r p"]) -> Float[np.ndarray, "r k"]:
    """Of each object the distance of its nearest reference."""
    owners: Int[np.ndarray, " p"] = data.library.owners
    found = np.full((distances.shape[0], len(data.library.objects)), np.inf)
    np.minimum.at(found.T, owners, distances.T)
    return found
