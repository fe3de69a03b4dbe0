"""The example without strictness: the recursion and the bounds of the proof against the loop that runs."""

from fractions import Fraction

import numpy as np
import pytest

from convexperc.problem.problem import Problem
from convexperc.solvers.paper.loop import run

PROBLEM = Problem([[1.0]], [1.0], lambda1=1.0, lambda2=2.0, lambda3=1.0)
STEPS = 2000


def recursion(order: str, steps: int) -> list[tuple[Fraction, Fraction]]:
    """The closed form of the corrected update, from w = u = 1."""
    w = u = Fraction(1)
    found = [(w, u)]
    for _ in range(steps):
        new = w * (1 + u) / (2 * w + 1)
        u = 2 * u * (new if order == "gauss_seidel" else w) / (2 * u + 1)
        w = new
        found.append((w, u))
    return found


@pytest.mark.parametrize("order", ["gauss_seidel", "jacobi"])
def test_the_loop_follows_the_recursion_and_stays_above_every_geometric_rate(order: str) -> None:
    trace = run(
        PROBLEM, variant="corrected", order=order, tolerance=0.0, max_iterations=STEPS, keep_iterates=True
    )
    w, u, k = trace.path_w[:, 0], trace.path_u[:, 0], np.arange(STEPS + 1)
    exact = np.array([[float(each) for each in point] for point in recursion(order, 8)])
    np.testing.assert_allclose(w[:9], exact[:, 0], rtol=1e-14)
    np.testing.assert_allclose(u[:9], exact[:, 1], rtol=1e-14)
    assert ((2 * k + 1) * w >= 1 - 1e-12).all(), w
    assert (trace.F[1:] - 1 >= (1 - 1e-9) / (2 * k[1:] + 1) ** 2).all(), trace.F
    ratio = (trace.F[-1] - 1) / (trace.F[-2] - 1)
    assert 0.998 < ratio < 1, ratio


def test_gauss_seidel_stays_below_the_upper_bound() -> None:
    w = [point[0] for point in recursion("gauss_seidel", 12)]
    assert all((2 * k - 4) * w[k] <= 1 <= (2 * k + 1) * w[k] for k in range(3, 13)), w
