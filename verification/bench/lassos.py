"""The reduced form as a group lasso, and the solvers of that."""

from typing import Any

import numpy as np

from convexperc.problem.arrays import Vector
from verification.bench.posed import Posed


class GroupLasso(Posed):
    """The group lasso of the reduced form: design [[R, 0], [-sqrt(lambda1) I, sqrt(lambda1) L]], G = R'R."""

    def _pose(self) -> None:
        reduced, n = self.instance.reduced, self.instance.shape.n
        root = np.sqrt(self.lambdas[0])
        factor = np.linalg.cholesky(reduced.reduction.G)
        self.targets = np.linalg.solve(factor, self.instance.C.T)
        top = np.hstack([factor.T, np.zeros((n, sum(reduced.ranks)))])
        bottom = root * np.hstack([-np.eye(n), *reduced.L])
        self.design = np.asfortranarray(np.vstack([top, bottom]))
        self.sizes = [1] * n + list(reduced.ranks)
        weights = [self.lambdas[1]] * n + [self.lambdas[2]] * len(reduced.ranks)
        self.weights = np.array(weights) / (4.0 * n)  # both peers minimise ||y - Ax||^2 / (2 * 2n) + ...

    def _target(self, template: int) -> Vector:
        return np.concatenate([self.targets[:, template], np.zeros(self.instance.shape.n)])


class Skglm(GroupLasso):
    """Block coordinate descent with Anderson acceleration and working sets."""

    def _pose(self) -> None:
        from skglm.datafits import QuadraticGroup  # noqa: PLC0415 - an optional peer
        from skglm.penalties import WeightedGroupL2  # noqa: PLC0415 - an optional peer
        from skglm.solvers import GroupBCD  # noqa: PLC0415 - an optional peer
        from skglm.utils.jit_compilation import compiled_clone  # noqa: PLC0415 - an optional peer

        super()._pose()
        pointers = np.concatenate([[0], np.cumsum(self.sizes)]).astype(np.int32)
        indices = np.arange(self.design.shape[1], dtype=np.int32)
        self.datafit = compiled_clone(QuadraticGroup(pointers, indices))
        self.penalty = compiled_clone(WeightedGroupL2(1.0, self.weights, pointers, indices))
        self.solver = GroupBCD(max_iter=10_000, max_epochs=100_000, tol=self.tolerance)

    def _solve(self, template: int) -> Any:
        return self.solver.solve(self.design, self._target(template), self.datafit, self.penalty)[0]


class Celer(GroupLasso):
    """Working sets with dual extrapolation."""

    def _solve(self, template: int) -> Any:
        from celer import celer_path  # noqa: PLC0415 - an optional peer

        found = celer_path(
            self.design, self._target(template), "grouplasso", alphas=[1.0], groups=self.sizes,
            weights=self.weights, tol=self.tolerance, max_iter=1000, max_epochs=1_000_000,
        )  # fmt: skip
        return found[1][:, 0]
