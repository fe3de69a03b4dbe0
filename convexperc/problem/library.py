"""A whole template library seen through one frame: c_j = X o_j and ||o_j||^2, read block by block.

After this pass nothing of size d is needed until an answer's u is asked for.
"""

import time
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.certificate.lasso import Distinct
from convexperc.certificate.reduced import LARGEST, Shared
from convexperc.certificate.rounding import gamma
from convexperc.errors import ProblemError
from convexperc.problem.arrays import Matrix, real_array
from convexperc.problem.gram import Reduction
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem

BLOCK = 2**19
"""Numbers of O that are read at a time, 4 MB: what a processor keeps near."""
SAFE = 2.0**200
"""Squared lengths beyond this, or below its inverse, are left to `solve`: products may underflow."""


@dataclass(frozen=True, eq=False)
class Projection:
    """What the solver and the bounds need of one frame and p templates.

    The numbers are normalised by exact powers of two: X = 2^x X_, o_j = 2^k_j o_j_, ||o_j_|| in [1/2, 1).

    Attributes
    ----------
    X : float64 (n, d), read-only
        The views as given.
    O : array (d, p)
        The templates as given, not copied.
    modalities : Modalities
    reduction : Reduction
        Of X as given.
    shared : Shared
        G, K and their bounds, normalised.
    x : int
    exponents : int (p,)
        k_j.
    C : float64 (p, n)
        Row j is X_ o_j_.
    targets : float64 (p,)
        ||o_j_||^2.
    sound : bool (p,)
        False where a length is 0 or out of the safe range, so that nothing here may be used.
    seconds : float
        What the reading took.
    """

    X: Matrix
    O: Any  # noqa: E741 - the paper's symbol
    modalities: Modalities
    reduction: Reduction
    shared: Shared
    x: int
    exponents: Int[np.ndarray, " p"]
    C: Float[np.ndarray, "p n"]
    targets: Float[np.ndarray, " p"]
    sound: Bool[np.ndarray, " p"]
    seconds: float = field(repr=False)

    @classmethod
    def of(cls, X: Any, O: Any, modalities: Any = None) -> "Projection":  # noqa: E741 - the paper's symbol
        """Read the views, and the templates once.

        Parameters
        ----------
        X : array_like (n, d)
        O : array_like (d, p)
            Column j is template j. An array, also a memory-mapped one, is not copied; keep it as it is while
            the answers are in use.
        modalities : see `Modalities.of`

        Raises
        ------
        ProblemError, ModalityError
            As `Problem` on X and each column of O.
        """
        began = time.perf_counter()
        views = real_array(X, "X", 2)
        if 0 in views.shape:
            must = "must have at least one row (robot) and one column"
            raise ProblemError("X", value=views.shape, must=must)
        templates = _templates(O, views.shape[1])
        parts = Modalities.of(modalities, views.shape[1])
        reduction = Reduction.of(views, parts)
        x, shared, usable = _normalised(reduction)
        C, squares = _read(reduction, templates)
        sound = usable & (squares > 1.0 / SAFE) & (squares < SAFE)
        exponents = (np.frexp(np.where(sound, squares, 0.5))[1] + 1) // 2
        np.ldexp(C, -(x + exponents)[:, None], out=C)
        np.ldexp(squares, -2 * exponents, out=squares)
        seconds = time.perf_counter() - began
        return cls(views, templates, parts, reduction, shared, x, exponents, C, squares, sound, seconds)

    @property
    def p(self) -> int:
        """Number of templates."""
        return int(self.targets.size)

    def template(self, j: int) -> Float[np.ndarray, " d"]:
        """o_j as given."""
        return np.asarray(self.O[:, j], dtype=np.float64)

    def problem(self, j: int, lambdas: tuple[float, float, float]) -> Problem:
        """Template j's problem as given."""
        one, two, three = lambdas
        o, parts = self.template(j), self.modalities
        return Problem(self.X, o, modalities=parts, lambda1=one, lambda2=two, lambda3=three)

    @cached_property
    def squares(self) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
        """Lower and upper bounds of ||o_j||^2; 0 and infinite where it is not sound."""
        g, found = self.shared.gamma, np.ldexp(self.targets, 2 * self.exponents)
        lower, upper = found * (1.0 - g), found * (1.0 + g)
        lower[~self.sound], upper[~self.sound] = 0.0, np.inf
        return lower, upper

    @cached_property
    def distinct(self) -> Distinct:
        """The views, equal ones taken together, for lambdas that make a lasso of the problem."""
        return Distinct.of(self.X, self.shared)

    def zero_is_optimal(self, lambdas: tuple[float, float, float]) -> Bool[np.ndarray, " p"]:
        """Where lambda2 >= 2 ||X o_j||_inf is proved, so that w = u = 0 is an optimum."""
        size = np.abs(self.C) + 2.0 * self.shared.gamma * self.shared.rows
        lambda2 = self.lambdas(lambdas)[0][:, 1]
        return np.asarray(self.sound & (lambda2 >= (2.0 + 2.0**-40) * size.max(axis=1)))

    def lambdas(
        self, lambdas: tuple[float, float, float]
    ) -> tuple[Float[np.ndarray, "p 3"], Bool[np.ndarray, " p"]]:
        """Normalise the lambdas for each template; also tell where they are in the range of the bounds."""
        found = np.empty((self.p, 3))
        with np.errstate(over="ignore", under="ignore"):
            found[:, 0] = np.ldexp(lambdas[0], -2 * self.x)
            found[:, 1] = np.ldexp(lambdas[1], -self.x - self.exponents)
            found[:, 2] = np.ldexp(lambdas[2], -2 * self.x - self.exponents)
        inside = (found >= 1.0 / LARGEST) & (found <= LARGEST)
        inside[:, np.array(lambdas) == 0.0] = True
        return found, np.asarray(inside.all(axis=1))


def _templates(O: Any, d: int) -> Any:  # noqa: E741 - the paper's symbol
    """O as an array of real numbers with d rows, copied only if it is no such array."""
    templates = (
        O if isinstance(O, np.ndarray) and O.dtype.kind in "buif" and O.ndim == 2 else real_array(O, "O", 2)
    )
    if templates.shape[0] != d or templates.shape[1] == 0:
        must = f"must have {d} rows, as X has columns, and at least one column a template"
        raise ProblemError("O", value=templates.shape, must=must, remedy="Each column of O is one template.")
    return templates


def _normalised(reduction: Reduction) -> tuple[int, Shared, bool]:
    """x, and the normalised K and G with their bounds; whether they can be used."""
    n, m = reduction.G.shape[0], len(reduction.K)
    squares = np.einsum("ijj->ij", reduction.K)
    largest = float(reduction.G.diagonal().max())
    sound = 1.0 / SAFE < largest < SAFE and bool(np.isfinite(reduction.G).all())
    x = int(np.frexp(largest)[1] + 1) // 2 if sound else 0
    g = gamma(reduction.depth + 4 * n + 4 * m + 64)
    lengths = np.sqrt(np.ldexp(squares, -2 * x) * (1.0 + 4 * g) + 2.0**-300)
    rows = np.sqrt((lengths**2).sum(axis=0)) * (1.0 + g)
    blocks = np.sqrt((lengths**2).sum(axis=1)) * (1.0 + g)
    G, K = np.ldexp(reduction.G, -2 * x), np.ldexp(reduction.K, -2 * x)
    return x, Shared(G, K, lengths, rows, blocks, g), sound


def _read(reduction: Reduction, O: Any) -> tuple[Float[np.ndarray, "p n"], Float[np.ndarray, " p"]]:  # noqa: E741
    """Row j of the first is X o_j; the second holds ||o_j||^2."""
    d, p = O.shape
    C, squares = np.empty((p, reduction.G.shape[0])), np.empty(p)
    width = max(1, BLOCK // d)
    for start in range(0, p, width):
        chosen = slice(start, start + width)
        block = np.asarray(O[:, chosen], dtype=np.float64)
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            C[chosen] = reduction.product(block)
            squares[chosen] = reduction.squares(block)
        if not np.isfinite(squares[chosen]).all():
            for j in np.flatnonzero(~np.isfinite(squares[chosen])):
                real_array(block[:, j], f"O[:, {start + j}]", 1)
    return C, squares
