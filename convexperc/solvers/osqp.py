"""An independent solver for the cases in which Eq. (full) is a quadratic programme: OSQP."""

import signal
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
import osqp
from scipy import sparse

from convexperc.errors import SolverError
from convexperc.problem.problem import Problem
from convexperc.solvers.interface import SolverResult

_ALONE = threading.Lock()
"""Held while OSQP runs: it replaces the handler of SIGINT, and two at once would not put it back."""


def is_quadratic(problem: Problem) -> bool:
    """Whether the problem is a QP: ||u||_M is absent (lambda3 = 0) or the l1-norm (one-column modalities)."""
    return problem.lambda3 == 0.0 or max(problem.modalities.sizes) == 1


@dataclass(frozen=True)
class Quadratic:
    """OSQP on min ||p||^2 + lambda1 ||q||^2 + lambda2 1's + lambda3 1't.

    Constraints: p = X'w - o, q = Xu - w, -s <= w <= s, -t <= u <= t. No code is shared with the conic model.

    Attributes
    ----------
    tolerance : float
        OSQP's eps_abs and eps_rel; its polish step goes beyond the accuracy that ADMM reaches.
    max_iterations : int
        Of ADMM.
    time_limit : float
        Seconds after which OSQP returns the point that it has; the status says so.
    """

    tolerance: float = 1e-9
    max_iterations: int = 200_000
    time_limit: float = 60.0

    @property
    def name(self) -> str:
        """Short name, for reports."""
        return "osqp"

    def solve(self, problem: Problem) -> SolverResult:
        """Answer one normalised problem.

        Raises
        ------
        SolverError
            The problem is no QP, or OSQP returned no point.
        """
        if not is_quadratic(problem):
            must = "must be 0, or every modality must have one column, for OSQP"
            raise SolverError("lambda3", value=problem.lambda3, must=must, remedy="Use the conic solver.")
        n, d = problem.n, problem.d
        P, c, A, lower, upper = _matrices(problem)
        solver = osqp.OSQP()
        settings = {"eps_abs": self.tolerance, "eps_rel": self.tolerance, "max_iter": self.max_iterations}
        settings |= {"time_limit": self.time_limit, "polishing": True, "polish_refine_iter": 20}
        solver.setup(P, c, A, lower, upper, verbose=False, **settings)
        with _ALONE:
            result = solver.solve(raise_error=False)
        if result.info.status_val == osqp.SolverStatus.OSQP_SIGINT:
            signal.raise_signal(signal.SIGINT)  # OSQP has taken it; it is meant for Python
        x = result.x
        if x is None or not np.isfinite(x).all():
            raise SolverError("OSQP", value=self._status(result.info), must="must return a point")
        return SolverResult(
            x[:n].copy(), x[n : n + d].copy(), self._status(result.info), int(result.info.iter)
        )

    def _status(self, info: Any) -> str:
        """What OSQP says; at its limit that may be "solved inaccurate", too."""
        ended = info.status_val != osqp.SolverStatus.OSQP_SOLVED and info.run_time >= self.time_limit
        return (
            f"{info.status}; the time limit of {self.time_limit:g} s is reached"
            if ended
            else str(info.status)
        )


def _matrices(
    problem: Problem,
) -> tuple[sparse.csc_matrix, np.ndarray, sparse.csc_matrix, np.ndarray, np.ndarray]:
    """Return P, c, A, l, u of OSQP's form, min x'Px/2 + c'x with l <= Ax <= u, for x = (w, u, p, q, s, t)."""
    n, d, X = problem.n, problem.d, sparse.csc_matrix(problem.X)
    eye_n, eye_d = sparse.eye(n), sparse.eye(d)
    P = sparse.block_diag(
        [
            sparse.csc_matrix((n + d, n + d)),
            2 * eye_d,
            2 * problem.lambda1 * eye_n,
            sparse.csc_matrix((n + d, n + d)),
        ]
    )
    c = np.concatenate([np.zeros(2 * (n + d)), np.full(n, problem.lambda2), np.full(d, problem.lambda3)])
    A = sparse.bmat(
        [
            [X.T, None, -eye_d, None, None, None],
            [-eye_n, X, None, -eye_n, None, None],
            [eye_n, None, None, None, -eye_n, None],
            [eye_n, None, None, None, eye_n, None],
            [None, eye_d, None, None, None, -eye_d],
            [None, eye_d, None, None, None, eye_d],
        ]
    )
    free_n, free_d = np.full(n, np.inf), np.full(d, np.inf)
    lower = np.concatenate([problem.o, np.zeros(n), -free_n, np.zeros(n), -free_d, np.zeros(d)])
    upper = np.concatenate([problem.o, np.zeros(n), np.zeros(n), free_n, np.zeros(d), free_d])
    return P.tocsc(), c, A.tocsc(), lower, upper
