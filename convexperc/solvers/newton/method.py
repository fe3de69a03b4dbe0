"""Proximal Newton on the reduced problem, all templates of a frame at once; a lasso where a lambda is 0."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from convexperc.certificate.lasso import Distinct
from convexperc.certificate.reduced import Shared
from convexperc.problem.arrays import Matrix, Vector
from convexperc.problem.gram import Reduction
from convexperc.problem.problem import Problem
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.newton.loop import Race, Rules, solve_batch
from convexperc.solvers.newton.subproblem import lasso, lasso_batch

NO_RACE = Race(np.empty(0), np.inf, 0.0)


@dataclass(frozen=True, eq=False)
class Start:
    """Where to begin: the (w, t) of earlier answers, one row a template.

    Attributes
    ----------
    W : float64 (p, n)
    T : float64 (p, m)
        t_i = 2 ||u^i|| / lambda3.
    """

    W: Float[np.ndarray, "p n"]
    T: Float[np.ndarray, "p m"]


@dataclass(frozen=True, eq=False)
class Batch:
    """The answers to all templates of one frame, normalised, before anybody has judged them.

    Attributes
    ----------
    W : float64 (p, n)
    T : float64 (p, m)
        u_j^i = T_ji X_i' Q_j.
    Q : float64 (p, n)
        The dual points are a = 2(X'w - o), b = -2 Q_j.
    iterations : int (p,)
    """

    W: Float[np.ndarray, "p n"]
    T: Float[np.ndarray, "p m"]
    Q: Float[np.ndarray, "p n"]
    iterations: np.ndarray

    def start(self) -> Start:
        """A start for the next frame, or for the next lambda."""
        return Start(self.W, self.T)


@dataclass(frozen=True)
class Newton:
    """Proximal Newton in (w, t); see `convexperc.problem.gram` for the form and `newton_kernel` for the loop.

    Attributes
    ----------
    tolerance : float
        Relative duality gap at which a template is done, as seen from the reduced data.
    max_iterations : int
    """

    tolerance: float = 1e-11
    max_iterations: int = 80

    @property
    def name(self) -> str:
        """Short name, for reports."""
        return "newton"

    def solve(self, problem: Problem) -> SolverResult:
        """Answer one normalised problem."""
        reduction = Reduction.of(problem.X, problem.modalities)
        if problem.lambda1 == 0.0 or problem.lambda3 == 0.0:
            return self._uncoupled(problem, reduction)
        c, target = problem.X @ problem.o, float(problem.o @ problem.o)
        lambdas = np.array([problem.lambdas])
        batch = self.batch(reduction, c[None, :], np.array([target]), lambdas)
        w, q = batch.W[0], batch.Q[0]
        u = reduction.recover(batch.T[0], q)
        dual = 2.0 * (problem.X.T @ w - problem.o), -2.0 * q
        return SolverResult(w, u, "stopped", int(batch.iterations[0]), dual)

    def batch(
        self,
        reduction: Reduction | Shared,
        C: Float[np.ndarray, "p n"],
        targets: Float[np.ndarray, " p"],
        lambdas: Float[np.ndarray, "p 3"],
        start: Start | None = None,
        race: Race | None = None,
    ) -> Batch:
        """Answer all templates of a frame; lambda1, lambda3 > 0.

        Parameters
        ----------
        reduction : Reduction or Shared
            Its G and K.
        C : float64 (p, n)
            Row j is X o_j.
        targets : float64 (p,)
            ||o_j||^2.
        lambdas : float64 (p, 3)
        start : Start, optional
            Cold without; then the t of the first answer starts the others of the same lambda1.
        race : Race, optional
            Give up templates whose optimum is seen not to be the lowest.

        Returns
        -------
        Batch
        """
        p, n = C.shape
        m = len(reduction.K)
        W = np.zeros((p, n)) if start is None else np.array(start.W, dtype=np.float64)
        T = np.zeros((p, m)) if start is None else np.array(start.T, dtype=np.float64)
        Q, iterations, _ = solve_batch(
            reduction.G, reduction.K, np.ascontiguousarray(C), targets, lambdas, W, T,
            Rules(self.tolerance, self.max_iterations, start is not None),
            NO_RACE if race is None else race,
        )  # fmt: skip
        return Batch(W, T, Q, iterations)

    def _uncoupled(self, problem: Problem, reduction: Reduction) -> SolverResult:
        """lambda1 = 0 (then u = 0) or lambda3 = 0 (then Xu is the projection of w): a lasso in w."""
        X, o = problem.X, problem.o
        basis = _range_basis(X)
        if problem.lambda2 == 0.0:
            w = np.linalg.lstsq(X.T, o, rcond=None)[0]
        else:
            quadratic = reduction.G
            if problem.lambda1 > 0.0:
                quadratic = quadratic + problem.lambda1 * (np.eye(problem.n) - basis @ basis.T)
            w = _lasso(quadratic, X @ o, problem.lambda2)
        u, b = np.zeros(problem.d), np.zeros(problem.n)
        if problem.lambda1 > 0.0:
            u = np.linalg.lstsq(X, w, rcond=None)[0]
            b = -2.0 * problem.lambda1 * (w - basis @ (basis.T @ w))
        return SolverResult(w, u, "stopped", 1, (2.0 * (X.T @ w - o), b))


def lassos(
    distinct: Distinct, C: Float[np.ndarray, "p n"], lambdas: Float[np.ndarray, "p 3"], m: int
) -> Batch:
    """Answer all templates of a frame where the coupling costs nothing: lambda1 = 0 or lambda3 = 0.

    Parameters
    ----------
    distinct : Distinct
        Its views must be proved to be independent.
    C : float64 (p, n)
        Row j is X o_j.
    lambdas : float64 (p, 3)
    m : int
        Number of modalities.

    Returns
    -------
    Batch
        With lambda1 = 0, u = 0; with lambda3 = 0, u = X'q where Xu = w.
    """
    p, H, merged = C.shape[0], distinct.shared.G, distinct.merged(C)
    W = np.zeros_like(merged)
    weighted = lambdas[:, 1] > 0.0
    if not weighted.all():
        W[~weighted] = np.linalg.solve(H, merged[~weighted].T).T
    if weighted.any():
        found = np.zeros((int(weighted.sum()), W.shape[1]))
        lasso_batch(2.0 * H, -2.0 * merged[weighted], lambdas[weighted, 1], found)
        W[weighted] = found
    spread, iterations = distinct.spread(W), np.ones(p, dtype=np.int64)
    if not lambdas[:, 0].any():
        return Batch(spread, np.zeros((p, m)), np.zeros_like(spread), iterations)
    Q = np.linalg.solve(H, (W / distinct.counts).T).T
    return Batch(spread, np.ones((p, m)), distinct.spread(Q), iterations)


def _range_basis(X: Matrix) -> Float[np.ndarray, "n r"]:
    """Orthonormal basis of the range of X, up to float64's idea of its rank."""
    left, values, _ = np.linalg.svd(X, full_matrices=False)
    rank = int((values > values[0] * max(X.shape) * np.finfo(np.float64).eps).sum()) if values[0] > 0.0 else 0
    return np.asarray(left[:, :rank])


def _lasso(quadratic: Float[np.ndarray, "n n"], c: Vector, weight: float) -> Vector:
    """Minimise w'Qw - 2 c'w + weight ||w||_1."""
    z = np.zeros(c.size)
    lasso(2.0 * quadratic, -2.0 * c, weight, z)
    return z
