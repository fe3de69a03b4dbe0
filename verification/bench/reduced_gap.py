"""The duality gap on the reduced data, for instances on which the judge would take too long."""

import numpy as np

from convexperc.problem.arrays import Vector
from verification.bench.instances import Instance, Lambdas

LARGE = 1e7
"""n d beyond which the gap is taken from the reduced data, rounding not included."""


def value_and_gap(
    instance: Instance, template: int, lambdas: Lambdas, w: Vector, u: Vector
) -> tuple[float, float]:
    """F(w, u) and F(w, u) - D at a = 2 s (X'w - o), b = 2 s lambda1 (Xu - w), s the best feasible scale.

    D(a, b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1); F - D is a sum of terms >= 0.
    """
    lambda1, lambda2, lambda3 = lambdas
    reduction = instance.reduced.reduction
    c, target = instance.C[template], float(instance.targets[template])
    products = [instance.X[:, columns] @ u[columns] for columns in instance.modalities]
    q = np.sum(products, axis=0) - w
    loss = max(float(w @ reduction.G @ w - 2.0 * c @ w) + target, 0.0)
    quadratic = loss + lambda1 * float(q @ q)
    pull = 2.0 * (reduction.G @ w - c) - 2.0 * lambda1 * q
    lengths = np.array([2.0 * lambda1 * np.sqrt(q @ K @ q) for K in reduction.K])
    s = max(0.0, target - float(c @ w)) / quadratic
    s = min(s, lambda2 / float(np.abs(pull).max()), lambda3 / max(float(lengths.max()), 1e-300))
    gap = (1.0 - s) ** 2 * quadratic + lambda2 * float(np.abs(w).sum()) + s * float(w @ pull)
    crossing = sum(2.0 * lambda1 * float(q @ product) for product in products)
    gap += lambda3 * float(instance.modalities.norms(u).sum()) + s * crossing
    value = quadratic + lambda2 * float(np.abs(w).sum()) + lambda3 * float(instance.modalities.norms(u).sum())
    return value, gap
