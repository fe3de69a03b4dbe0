"""Proximal Newton on the reduced problem, all templates in one call; a lasso where a lambda is 0."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from convexperc.problem.arrays import Matrix
from convexperc.problem.problem import Problem
from convexperc.problem.reduction import Reduction
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.newton.loop import NO_PRUNING, Rules, newton_kernel
from convexperc.solvers.newton.subproblem import lasso_kernel
from convexperc.solvers.newton.workspace import Grams, H, Rows, Templates, new_memory, workspace

MAX_ITERATIONS = 80
"""Largest number of Newton steps for each template, if nothing else is asked for."""
SOLVED, DIRECT = "gap within the tolerance", "direct solution"
STAGNATED, LIMIT = "stagnation at rounding level", "iteration limit"
STATUSES = (SOLVED, DIRECT, STAGNATED, LIMIT)
"""Status texts of `Newton`; the gap is that of the reduced data, without a bound of its rounding errors."""


@dataclass(frozen=True, eq=False)
class Batch:
    """The answers to all templates of one set of views, on normalised data, before certification.

    Attributes
    ----------
    W : float64 (p, n)
    T : float64 (p, m)
        t = 2 ||u^i|| / lambda3; u_j^i = T_ji X_i' Q_j.
    Q : float64 (p, n)
        Row j gives template j's dual point, a = 2(X'w - o), b = -2 Q_j.
    iterations : int (p,)
        Newton steps taken.
    gaps : float64 (p, 2)
        F and its duality gap, computed from the reduced data; NaN where they were not computed.
    """

    W: Float[np.ndarray, "p n"]
    T: Float[np.ndarray, "p m"]
    Q: Float[np.ndarray, "p n"]
    iterations: Int[np.ndarray, " p"]
    gaps: Float[np.ndarray, "p 2"]

    @classmethod
    def new(cls, p: int, n: int, m: int) -> "Batch":
        """Room for the answers; all are 0, and no gap is known."""
        gaps = np.empty((p, 2))
        gaps.fill(np.nan)
        return cls(np.zeros((p, n)), np.zeros((p, m)), np.zeros((p, n)), np.zeros(p, dtype=np.int64), gaps)

    def status(self, j: int, tolerance: float, limit: int) -> str:
        """Why template j was left, one of `STATUSES`: at this relative gap, or after so many iterations."""
        F, gap = self.gaps[j]
        if np.isnan(gap):
            return DIRECT
        if gap <= tolerance * F:
            return SOLVED
        return LIMIT if self.iterations[j] >= limit else STAGNATED


@dataclass(frozen=True)
class Newton:
    """Proximal Newton in (w, t); see `convexperc.problem.reduction` for the reduced form.

    Attributes
    ----------
    tolerance : float
        Relative duality gap at which a template is solved, computed from the reduced data.
    max_iterations : int
        Largest number of Newton steps for each template.
    """

    tolerance: float = 1e-11
    max_iterations: int = MAX_ITERATIONS

    @property
    def name(self) -> str:
        """Short name, for reports."""
        return "newton"

    def solve(self, problem: Problem) -> SolverResult:
        """Answer one normalised problem."""
        reduction = problem.views.reduction
        if problem.penalties.uncoupled:
            return self._uncoupled(problem, reduction)
        c, target = problem.X @ problem.o, float(problem.o @ problem.o)
        lambdas = np.array([problem.lambdas])
        batch = self.batch(reduction.G, reduction.K, c[None, :], np.array([target]), lambdas)
        w, q = batch.W[0], batch.Q[0]
        u = reduction.recover(batch.T[0], q)
        dual = 2.0 * (problem.X.T @ w - problem.o), -2.0 * q
        return SolverResult(
            w, u, batch.status(0, self.tolerance, self.max_iterations), int(batch.iterations[0]), dual
        )

    def batch(
        self,
        G: Float[np.ndarray, "n n"],
        K: Float[np.ndarray, "m n n"],
        C: Float[np.ndarray, "p n"],
        targets: Float[np.ndarray, " p"],
        lambdas: Float[np.ndarray, "p 3"],
    ) -> Batch:
        """Answer all templates of a set of views; lambda1, lambda3 > 0.

        The first one starts cold, and its t starts the others of the same lambda1.

        Parameters
        ----------
        G : float64 (n, n)
            X X'.
        K : float64 (m, n, n)
            X_i X_i'.
        C : float64 (p, n)
            Row j is X o_j.
        targets : float64 (p,)
            ||o_j||^2.
        lambdas : float64 (p, 3)

        Returns
        -------
        Batch
        """
        p, n = C.shape
        batch = Batch.new(p, n, len(K))
        newton_kernel(
            Grams.of(G, K), Templates(np.ascontiguousarray(C), targets, lambdas), np.arange(p),
            Rules(self.tolerance, self.max_iterations, False), NO_PRUNING, new_memory(n, len(K)),
            Rows(*vars(batch).values()),
        )  # fmt: skip
        return batch

    def _uncoupled(self, problem: Problem, reduction: Reduction) -> SolverResult:
        """Solve a lasso in w for lambda1 = 0 (then u = 0) or lambda3 = 0 (then Xu is the projection of w)."""
        X, o = problem.X, problem.o
        basis = _range_basis(X)
        if problem.lambda2 == 0.0:
            w = np.linalg.lstsq(X.T, o, rcond=None)[0]
        else:
            quadratic = reduction.G
            if problem.lambda1 > 0.0:
                quadratic = quadratic + problem.lambda1 * (np.eye(problem.n) - basis @ basis.T)
            w = _lassos(quadratic, (X @ o)[None, :], np.array([problem.lambda2]))[0]
        u, b = np.zeros(problem.d), np.zeros(problem.n)
        if problem.lambda1 > 0.0:
            u = np.linalg.lstsq(X, w, rcond=None)[0]
            b = -2.0 * problem.lambda1 * (w - basis @ (basis.T @ w))
        return SolverResult(w, u, DIRECT, 1, (2.0 * (X.T @ w - o), b))


def lassos(
    G: Float[np.ndarray, "k k"],
    C: Float[np.ndarray, "p k"],
    counts: Float[np.ndarray, " k"],
    lambdas: Float[np.ndarray, "p 3"],
) -> tuple[Float[np.ndarray, "p k"], Float[np.ndarray, "p k"]]:
    """Answer all templates of a set of views for lambda1 = 0 or lambda3 = 0, where no coupling term is left.

    Parameters
    ----------
    G : float64 (k, k)
        X X' of the distinct views, which must be linearly independent.
    C : float64 (p, k)
        Row j is X o_j.
    counts : float64 (k,)
        Multiplicity of each of the distinct views.
    lambdas : float64 (p, 3)

    Returns
    -------
    W, Q : float64 (p, k)
        W is the sum of the weights of equal views. With lambda1 = 0, Q = 0 and u = 0; with lambda3 = 0,
        u = X'Q_j, so that Xu = w where equal views have equal weights.
    """
    W = np.zeros_like(C)
    weighted = lambdas[:, 1] > 0.0
    if not weighted.all():
        W[~weighted] = np.linalg.solve(G, C[~weighted].T).T
    if weighted.any():
        W[weighted] = _lassos(G, C[weighted], lambdas[weighted, 1])
    if not lambdas[:, 0].any():
        return W, np.zeros_like(W)
    return W, np.linalg.solve(G, (W / counts).T).T


def _range_basis(X: Matrix) -> Float[np.ndarray, "n r"]:
    """Orthonormal basis of the range of X, of its numerical rank in float64."""
    left, values, _ = np.linalg.svd(X, full_matrices=False)
    rank = int((values > values[0] * max(X.shape) * np.finfo(np.float64).eps).sum()) if values[0] > 0.0 else 0
    return np.asarray(left[:, :rank])


def _lassos(
    quadratic: Float[np.ndarray, "n n"], C: Float[np.ndarray, "p n"], weights: Float[np.ndarray, " p"]
) -> Float[np.ndarray, "p n"]:
    """Minimise w'Qw - 2 c_j'w + weight_j ||w||_1 for every row of C."""
    n = C.shape[1]
    found, room = np.empty_like(C), workspace(new_memory(n, 0), n, 0)
    room.matrices[H] = 2.0 * quadratic
    lasso_kernel(-2.0 * C, weights, room, found)
    return found
