"""A template library as one set of views sees it: c_j = X o_j, normalised, in one pass over the templates.

After this pass nothing of size d is needed until an answer's u is asked for.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.problem.arrays import BLOCK, times_power_of_two
from convexperc.problem.library import (
    SAFE_SQUARE,
    TemplateLibrary,
    squared_lengths,
)
from convexperc.problem.penalties import Penalties
from convexperc.problem.problem import Problem
from convexperc.problem.reduction import EVERY, Reduction, Rows
from convexperc.problem.scaling import Scaling
from convexperc.problem.views import Views

BEYOND = 2.0**900
"""More than every lambda that is of use; larger ones are cut here, so that nothing overflows."""


@dataclass(frozen=True, eq=False)
class ReducedData:
    """What the solver and the bounds need of n views and p templates.

    The numbers are normalised by exact powers of two: X = 2^x X_, o_j = 2^k_j o_j_, ||o_j_|| in [1/2, 1).

    Attributes
    ----------
    views : Views
        As given.
    library : TemplateLibrary
        As given.
    x : int
    G : float64 (n, n)
        X_ X_'.
    K : float64 (m, n, n)
        X_i X_i' of each modality of X_.
    C : float64 (p, n)
        Row j is X_ o_j_.
    sound : bool (p,)
        False where a length is 0 or out of the safe range, so that nothing here may be used.
    seconds : float
        What the reading took.
    """

    views: Views
    library: TemplateLibrary
    x: int
    G: Float[np.ndarray, "n n"]
    K: Float[np.ndarray, "m n n"]
    C: Float[np.ndarray, "p n"]
    sound: Bool[np.ndarray, " p"]
    seconds: float = field(repr=False)

    @classmethod
    def of(
        cls,
        X: Any,
        templates: Any,
        modalities: Any = None,
        *,
        names: Sequence[str] | None = None,
        earlier: "ReducedData | None" = None,
    ) -> "ReducedData":
        """Read the views, and the templates once.

        Parameters
        ----------
        X : array_like (n, d)
        templates, names, modalities : see `TemplateLibrary.of`
        earlier : ReducedData, optional
            Of as many views and the same library. If at least half of the rows of X are the same, only the
            others are multiplied: with G, K and X O to rounding as without it.

        Raises
        ------
        ProblemError, ModalityError
            As `Views.of` on X; as `TemplateLibrary` on the templates; another number of features than X has.
        TemplateNameError
            See `TemplateLibrary.of`.
        """
        began = time.perf_counter()
        if isinstance(templates, TemplateLibrary):
            library = TemplateLibrary.of(templates, names=names, modalities=modalities)
            views = Views.of(X, library.modalities, library.d)
        else:
            views = Views.of(X, modalities)
            library = TemplateLibrary.for_views(templates, names, views.modalities)
        rows = EVERY if earlier is None else _new_rows(earlier, views, library)
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            if earlier is None or rows is EVERY:
                reduction = Reduction.of(views.X, views.modalities)
            else:
                reduction = earlier.views.reduction.replaced(views.X, np.asarray(rows))
            C = _products(reduction, library, rows)
        views.__dict__["reduction"] = reduction
        x, usable = _exponent(reduction)
        lengths = library.lengths
        C *= (lengths.inverses * math.ldexp(1.0, -x))[:, None]
        if earlier is not None and rows is not EVERY:
            kept = np.ldexp(earlier.C, earlier.x - x)
            kept[:, rows] = C
            C = kept
        G, K = times_power_of_two(reduction.G, -2 * x), times_power_of_two(reduction.K, -2 * x)
        sound = lengths.sound if usable else np.zeros_like(lengths.sound)
        return cls(views, library, x, G, K, C, sound, time.perf_counter() - began)

    def alone(self, i: int) -> "ReducedData":
        """The data of one of the views; where the products of all may be used, without another one."""
        began, chosen = time.perf_counter(), slice(i, i + 1)
        views = Views(self.views.X[chosen], self.views.modalities, self.views.exact)
        views.__dict__["reduction"] = reduction = self.views.reduction.alone(i)
        x, usable = _exponent(reduction)
        if not usable or self.sound is not self.library.lengths.sound:
            return ReducedData.of(views.X, self.library)
        G, K = times_power_of_two(reduction.G, -2 * x), times_power_of_two(reduction.K, -2 * x)
        C = np.ldexp(self.C[:, chosen], self.x - x)
        return ReducedData(views, self.library, x, G, K, C, self.sound, time.perf_counter() - began)

    @property
    def n(self) -> int:
        """Number of views."""
        return int(self.C.shape[1])

    @property
    def m(self) -> int:
        """Number of modalities."""
        return len(self.views.modalities)

    @property
    def p(self) -> int:
        """Number of templates."""
        return int(self.C.shape[0])

    @property
    def exponents(self) -> Int[np.ndarray, " p"]:
        """k_j."""
        return self.library.lengths.exponents

    @property
    def targets(self) -> Float[np.ndarray, " p"]:
        """||o_j_||^2."""
        return self.library.lengths.targets

    def scaling(self, j: int) -> Scaling:
        """The normalisation of template j's problem."""
        return Scaling(self.x, int(self.exponents[j]))

    def problem(self, j: int, penalties: Penalties) -> Problem:
        """Template j's problem as given; the views are shared, not copied."""
        return Problem.of(self.views, self.library.template(j), penalties)

    def normalised(self, penalties: Penalties) -> Float[np.ndarray, "p 3"]:
        """(lambda1, lambda2, lambda3) in each template's own units; cut, or 0, far beyond the safe range."""
        unit, inverses, found = math.ldexp(1.0, -self.x), self.library.lengths.inverses, np.empty((self.p, 3))
        found[:, 0] = min(penalties.lambda1 * unit * unit, BEYOND)
        np.multiply(inverses, min(penalties.lambda2 * unit, BEYOND), out=found[:, 1])
        np.multiply(inverses, min(penalties.lambda3 * unit * unit, BEYOND), out=found[:, 2])
        return found


def _exponent(reduction: Reduction) -> tuple[int, bool]:
    """x, and whether the Gram matrices can be used."""
    largest = max(reduction.G.diagonal().tolist())  # no other entry is larger, so that all are finite
    usable = 1.0 / SAFE_SQUARE < largest < SAFE_SQUARE
    return (math.frexp(largest)[1] + 1) // 2 if usable else 0, usable


def _new_rows(earlier: ReducedData, views: Views, library: TemplateLibrary) -> Rows:
    """The rows of X that differ from the earlier ones; all, if nothing can be kept or little would be."""
    if library is not earlier.library or earlier.sound is not library.lengths.sound:
        return EVERY
    if views.X.shape != earlier.views.X.shape or views.modalities is not earlier.views.modalities:
        return EVERY
    changed = (views.X != earlier.views.X).any(axis=1).nonzero()[0]
    return changed if 2 * changed.size <= views.X.shape[0] else EVERY


def _products(reduction: Reduction, library: TemplateLibrary, rows: Rows = EVERY) -> Float[np.ndarray, "p k"]:
    """Row j is X o_j, or some entries of it; the first pass over a library also measures it."""
    O = library.O  # noqa: E741 - the paper's symbol
    if library.measured and (O.size <= BLOCK or (O.dtype == np.float64 and not isinstance(O, np.memmap))):
        return reduction.product(np.asarray(O, dtype=np.float64), rows)
    C = np.empty((len(library), reduction.X[rows].shape[0]))
    squares = None if library.measured else np.empty(len(library))
    for chosen, block in library.blocks():
        C[chosen] = reduction.product(block, rows)
        if squares is not None:
            squares[chosen] = squared_lengths(block, chosen.start)
    if squares is not None:
        library.keep(squares)
    return C
