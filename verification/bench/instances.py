"""The named instances of the benchmark: what one frame looks like, from five robots to two thousand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from convexperc.problem.arrays import Matrix, Vector
from convexperc.problem.library import TemplateLibrary
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem
from convexperc.problem.reduction import Reduction

LAMBDAS = ((0.1, 0.1, 0.1), (1.0, 0.1, 0.1), (1.0, 1.0, 0.1))
"""(lambda1, lambda2, lambda3) of every instance."""
MIXED = 3
"""Rows that a template mixes."""
NOISE = 0.3
"""Length of a template's noise, as a share of the mix's."""
NEGLIGIBLE = 1e-13
"""Eigenvalues of K_i below this share of the largest are rounding."""

Lambdas = tuple[float, float, float]


@dataclass(frozen=True)
class Shape:
    """The size of an instance and the seed of its data.

    Attributes
    ----------
    name : str
    n : int
        Robots.
    sizes : tuple of int
        Columns of each modality.
    p : int
        Templates.
    seed : int
    """

    name: str
    n: int
    sizes: tuple[int, ...]
    p: int
    seed: int

    @property
    def d(self) -> int:
        """Columns in all."""
        return sum(self.sizes)


SHAPES = {
    shape.name: shape
    for shape in (
        Shape("S", 6, (768, 1764, 26), 8, 71),
        Shape("M", 64, (2000, 8000, 500), 100, 72),
        Shape("L", 500, (5000, 20000, 2000, 5000, 8000), 20, 73),
        Shape("XL", 2000, (20000, 20000, 20000, 20000, 20000), 2, 74),
        Shape("P", 6, (768, 1764, 26), 10000, 75),
    )
}
"""By name; P is S with ten thousand templates."""
TINY = Shape("tiny", 3, (4, 5), 2, 70)
"""What peers warm up on: imports and compilers take their time here."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """The reduced form that several peers are given: K_i = L_i L_i', X_i u^i = L_i z_i, ||u^i|| = ||z_i||.

    Attributes
    ----------
    reduction : Reduction
    L : tuple of float64 (n, r_i)
    back : tuple of float64 (n, r_i)
        u^i = X_i' back_i z_i.
    """

    reduction: Reduction
    L: tuple[Float[np.ndarray, "n _"], ...]
    back: tuple[Float[np.ndarray, "n _"], ...]

    @classmethod
    def of(cls, reduction: Reduction) -> "Reduced":
        """One eigendecomposition a modality."""
        factors, backs = [], []
        for K in reduction.K:
            values, vectors = np.linalg.eigh(K)
            kept = values > NEGLIGIBLE * values[-1]
            roots = np.sqrt(values[kept])
            factors.append(np.ascontiguousarray(vectors[:, kept] * roots))
            backs.append(np.ascontiguousarray(vectors[:, kept] / roots))
        return cls(reduction, tuple(factors), tuple(backs))

    @property
    def ranks(self) -> tuple[int, ...]:
        """Entries of each z_i."""
        return tuple(L.shape[1] for L in self.L)

    def point(self, x: Vector) -> tuple[Vector, Vector]:
        """(w, u) of the original problem from (w, z_1, ..., z_m)."""
        X, n = self.reduction.X, self.reduction.G.shape[0]
        u, at = np.zeros(X.shape[1]), n
        for columns, back in zip(self.reduction.modalities, self.back, strict=True):
            u[columns] = X[:, columns].T @ (back @ x[at : at + back.shape[1]])
            at += back.shape[1]
        return np.array(x[:n]), u


@dataclass(frozen=True, eq=False)
class Instance:
    """One frame: non-negative rows and templates of unit length by modality.

    Attributes
    ----------
    shape : Shape
    X : float64 (n, d)
    O : float64 (d, p)
        A template is a mix of some rows with noise.
    modalities : Modalities
    """

    shape: Shape
    X: Matrix
    O: Float[np.ndarray, "d p"]  # noqa: E741 - the paper's symbol
    modalities: Modalities

    @classmethod
    def of(cls, shape: Shape) -> "Instance":
        """Draw it from its seed."""
        rng, modalities = np.random.default_rng(shape.seed), Modalities.of(list(shape.sizes), shape.d)
        X = _unit(rng.random((shape.n, shape.d)), modalities)
        templates = np.empty((shape.p, shape.d))
        for row in templates:
            chosen = rng.choice(shape.n, min(MIXED, shape.n), replace=False)
            mix, noise = rng.dirichlet(np.ones(chosen.size)) @ X[chosen], rng.random(shape.d)
            row[:] = mix + NOISE * np.linalg.norm(mix) / np.linalg.norm(noise) * noise
        return cls(shape, X, _unit(templates, modalities).T, modalities)

    @cached_property
    def library(self) -> TemplateLibrary:
        """The templates, checked and measured once."""
        return TemplateLibrary(self.O, modalities=self.modalities)

    @cached_property
    def C(self) -> Float[np.ndarray, "p n"]:  # noqa: N802 - a matrix
        """Row j is X o_j."""
        return np.ascontiguousarray((self.X @ self.O).T)

    @cached_property
    def targets(self) -> Float[np.ndarray, " p"]:
        """||o_j||^2."""
        return np.asarray(np.einsum("dp,dp->p", self.O, self.O))

    @cached_property
    def reduced(self) -> Reduced:
        """The reduced form, made once."""
        return Reduced.of(Reduction.of(self.X, self.modalities))

    def problem(self, template: int, lambdas: Lambdas) -> Problem:
        """One template's problem on the original data."""
        names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
        return Problem(self.X, self.O[:, template], modalities=list(self.shape.sizes), **names)


def _unit(rows: Matrix, modalities: Modalities) -> Matrix:
    """Bring every modality of every row to unit length, in place."""
    for columns in modalities:
        rows[:, columns] /= np.linalg.norm(rows[:, columns], axis=1, keepdims=True)
    return rows
