"""The reduced form as a cone program, and the solvers that read one by their own interfaces.

Unknowns x = (w, z, e, s, r), e = sum_i L_i z_i - w, with |w_j| <= s_j and ||z_i|| <= r_i:

    minimise  w'Gw - 2 c'w + lambda1 e'e + lambda2 1's + lambda3 1'r.

The equality keeps the quadratic sparse: without it the products L_i'L_k would fill it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy import sparse

from convexperc.problem.arrays import Vector
from verification.bench.instances import Lambdas, Reduced
from verification.bench.posed import Posed


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """minimise x'Px/2 + q'x subject to Ex = 0 and -Bx in the cone.

    Attributes
    ----------
    P : sparse (N, N)
        Upper triangle.
    q : float64 (N,)
        Without the template's -2c, which `cost` adds.
    E : sparse (n, N)
        The equalities.
    B : sparse (k, N)
        The cone's rows: 2n non-negative ones, then one second-order cone a modality.
    cones : tuple of int
        Sizes of the second-order cones.
    n : int
    """

    P: sparse.csc_matrix
    q: Vector
    E: sparse.csc_matrix
    B: sparse.csc_matrix
    cones: tuple[int, ...]
    n: int

    @classmethod
    def of(cls, reduced: Reduced, lambdas: Lambdas) -> "ConeProgram":
        """Pose it for one choice of the lambdas."""
        lambda1, lambda2, lambda3 = lambdas
        G, ranks = reduced.reduction.G, reduced.ranks
        n, rank, m = G.shape[0], sum(ranks), len(ranks)
        N, eye = 3 * n + rank + m, sparse.identity(n, format="csc")
        quadratic = sparse.block_diag(
            [2.0 * G, sparse.csc_matrix((rank, rank)), 2.0 * lambda1 * eye, sparse.csc_matrix((n + m, n + m))]
        )
        q = np.r_[np.zeros(2 * n + rank), np.full(n, lambda2), np.full(m, lambda3)]
        nothing = sparse.csc_matrix((n, n + m))
        E = sparse.hstack([-eye, sparse.csc_matrix(np.hstack(reduced.L)), -eye, nothing], format="csc")
        s = N - m - n
        rows = [_select(n, N, 0) - _select(n, N, s), -_select(n, N, 0) - _select(n, N, s)]
        at = n
        for i, size in enumerate(ranks):
            rows += [-_select(1, N, N - m + i), -_select(size, N, at)]
            at += size
        B = sparse.vstack(rows, format="csc")
        return cls(sparse.triu(quadratic, format="csc"), q, E, B, tuple(r + 1 for r in ranks), n)

    def stacked(self) -> sparse.csc_matrix:
        """The equalities, then the cone's rows."""
        return sparse.vstack([self.E, self.B], format="csc")

    def cost(self, c: Vector) -> Float[np.ndarray, " N"]:
        """The linear term of one template."""
        q = self.q.copy()
        q[: self.n] -= 2.0 * c
        return q


def _select(count: int, width: int, at: int) -> sparse.csc_matrix:
    """Rows that pick x[at : at + count]."""
    return sparse.eye(count, width, k=at, format="csc")


class Clarabel(Posed):
    """The cone program of the reduced form, by Clarabel's own interface."""

    def _pose(self) -> None:
        import clarabel  # noqa: PLC0415 - imported where it is used

        self.program = program = ConeProgram.of(self.instance.reduced, self.lambdas)
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.presolve_enable, settings.max_threads = False, False, 1
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = self.tolerance
        A, n = program.stacked(), program.n
        cones = [clarabel.ZeroConeT(n), clarabel.NonnegativeConeT(2 * n)]
        cones += [clarabel.SecondOrderConeT(size) for size in program.cones]
        self.solver = clarabel.DefaultSolver(
            program.P, program.cost(self.instance.C[0]), A, np.zeros(A.shape[0]), cones, settings
        )

    def _solve(self, template: int) -> Any:
        self.solver.update(q=self.program.cost(self.instance.C[template]))
        return self.solver.solve().x


class Qoco(Posed):
    """The cone program of the reduced form, by QOCO's own interface."""

    def _pose(self) -> None:
        import qoco  # noqa: PLC0415 - an optional peer

        self.program = program = ConeProgram.of(self.instance.reduced, self.lambdas)
        E, B, n = program.E, program.B, program.n
        self.solver = qoco.QOCO()
        self.solver.setup(
            program.P.shape[0], B.shape[0], n, program.P, program.cost(self.instance.C[0]), E, np.zeros(n), B,
            np.zeros(B.shape[0]), 2 * n, len(program.cones), np.array(program.cones), abstol=self.tolerance,
            reltol=self.tolerance, verbose=0,
        )  # fmt: skip

    def _solve(self, template: int) -> Any:
        self.solver.update_vector_data(c=self.program.cost(self.instance.C[template]))
        return self.solver.solve().x


class Scs(Posed):
    """The cone program of the reduced form, by SCS's own interface."""

    def _pose(self) -> None:
        import scs  # noqa: PLC0415 - an optional peer

        self.program = program = ConeProgram.of(self.instance.reduced, self.lambdas)
        A = program.stacked()
        data = {"P": program.P, "A": A, "b": np.zeros(A.shape[0]), "c": program.cost(self.instance.C[0])}
        cone = {"z": program.n, "l": 2 * program.n, "q": list(program.cones)}
        self.solver = scs.SCS(
            data, cone, eps_abs=self.tolerance, eps_rel=self.tolerance, max_iters=1_000_000, verbose=False
        )

    def _solve(self, template: int) -> Any:
        self.solver.update(c=self.program.cost(self.instance.C[template]))
        return self.solver.solve(warm_start=False)["x"]
