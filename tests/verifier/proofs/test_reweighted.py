"""The general theorem beside loops that run: random data in float64, its examples in rationals."""

from collections.abc import Callable
from fractions import Fraction
from statistics import median

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import block_diag, eigvalsh

WEIGHTS: dict[str, Callable[[float], float]] = {
    "norm": lambda s: 0.5 / np.sqrt(s),
    "smoothed norm": lambda s: 0.5 / np.sqrt(s + 0.01),
    "Cauchy": lambda s: 1 / (1 + s),
    "Geman and McClure": lambda s: 1 / (1 + s) ** 2,
    "a step": lambda s: 1.0 if s < 1 else 0.25,
}
BLOCKS = [slice(0, 2), slice(2, 3), slice(3, 6)]
SIZE = 6


class Problem:
    """q(z) = ||B z - d||^2, and five terms of random sizes with one weight."""

    def __init__(self, seed: int, weight: Callable[[float], float]) -> None:
        rng = np.random.default_rng(seed)
        self.weight, self.z = weight, rng.normal(size=SIZE)
        self.B, self.d = rng.normal(size=(4, SIZE)), rng.normal(size=4)
        self.terms = [
            (rng.random(), rng.normal(size=(rows, SIZE)), rng.normal(size=rows)) for rows in (1, 1, 2, 3, 2)
        ]

    def squares(self, z: np.ndarray) -> list[float]:
        return [float(np.sum((A @ z - b) ** 2)) for _, A, b in self.terms]

    def rise(self, z: np.ndarray, new: np.ndarray) -> float:
        """F_omega(new) - F_omega(z), the losses by quadrature of the weight."""
        loss = sum(
            factor * quad(self.weight, s, t, points=[1.0] if min(s, t) < 1 < max(s, t) else None)[0]
            for (factor, _, _), s, t in zip(self.terms, self.squares(z), self.squares(new), strict=True)
        )
        return float(np.sum((self.B @ new - self.d) ** 2) - np.sum((self.B @ z - self.d) ** 2) + loss)

    def quadratic(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """P and c of Q at the iterate z."""
        P, c = self.B.T @ self.B, self.B.T @ self.d
        for (factor, A, b), s in zip(self.terms, self.squares(z), strict=True):
            P, c = P + factor * self.weight(s) * A.T @ A, c + factor * self.weight(s) * A.T @ b
        return P, c


def step(P: np.ndarray, c: np.ndarray, z: np.ndarray, block: slice) -> np.ndarray:
    """The step to the minimum over a block, with zeros elsewhere."""
    found = np.zeros(SIZE)
    found[block] = np.linalg.solve(P[block, block], (c - P @ z)[block])
    return found


def run(problem: Problem, order: str) -> tuple[np.ndarray, float]:
    """The next iterate, and the fall that the theorem promises."""
    z = problem.z
    P, c = problem.quadratic(z)
    if order == "whole":
        d = step(P, c, z, slice(None))
        return z + d, d @ P @ d
    if order == "two blocks at once":
        dx, dy = step(P, c, z, slice(0, 3)), step(P, c, z, slice(3, 6))
        return z + dx + dy, (dx - dy) @ P @ (dx - dy)
    if order == "three blocks, a third of each step":
        steps = [step(P, c, z, block) for block in BLOCKS]
        return z + sum(steps) / 3, sum(d @ P @ d for d in steps) / 3
    fall, new = 0.0, z
    for block in BLOCKS:
        d = step(P, c, new, block)
        new, fall = new + d, fall + d @ P @ d
    return new, fall


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize(
    "order",
    [
        "whole",
        "two blocks at once",
        "three blocks, a third of each step",
        "three blocks, one after the other",
    ],
)
def test_the_integral_of_the_weight_falls_by_the_form(weight: str, order: str) -> None:
    for seed in range(20):
        problem = Problem(seed, WEIGHTS[weight])
        new, fall = run(problem, order)
        assert fall > 0, seed
        assert problem.rise(problem.z, new) <= -fall + 1e-7 * (1 + fall), (seed, fall)


def test_a_weight_that_rises_breaks_it() -> None:
    """The bound is no triviality: with omega = s it fails somewhere."""
    excess = []
    for seed in range(20):
        problem = Problem(seed, lambda s: s)
        new, fall = run(problem, "whole")
        excess.append(problem.rise(problem.z, new) + fall)
    assert max(excess) > 1e-3, excess


@pytest.mark.parametrize("weight", ["smoothed norm", "Cauchy", "Geman and McClure"])
def test_the_fall_pays_for_the_gradient(weight: str) -> None:
    for seed in range(20):
        problem = Problem(seed, WEIGHTS[weight])
        P, c = problem.quadratic(problem.z)
        _, fall = run(problem, "whole")
        bound = eigvalsh(problem.B.T @ problem.B)[-1] + sum(
            factor * problem.weight(0) * eigvalsh(A.T @ A)[-1] for factor, A, _ in problem.terms
        )
        gradient = 2 * (P @ problem.z - c)
        assert gradient @ gradient <= 4 * bound * fall * (1 + 1e-9), seed
        h = 1e-5 * gradient / np.linalg.norm(gradient)
        slope = (problem.rise(problem.z, problem.z + h) - problem.rise(problem.z, problem.z - h)) / 2e-5
        np.testing.assert_allclose(slope, np.linalg.norm(gradient), rtol=1e-4)


def test_three_blocks_at_once_rise_where_the_page_says() -> None:
    def objective(point: list[Fraction]) -> Fraction:
        return (sum(point) + 1) ** 2 + sum(abs(each) for each in point)

    old = [Fraction(1)] * 3
    # the minimum over x of (x + y + z + 1)^2 + x^2/(2|x_i|): 2 (x + y + z + 1) + x/|x_i| = 0
    new = [-2 * (sum(old) - each + 1) / (2 + 1 / abs(each)) for each in old]
    assert (new, objective(old), objective(new)) == ([-2] * 3, 19, 31)


def test_any_wrong_factor_rises_for_a_steep_quadratic() -> None:
    """The construction of section 3 for psi = sqrt: q = g (x - p)^2, x = lambda = 1."""
    for factor in (Fraction(1, 2), Fraction(9, 10), Fraction(11, 10), Fraction(2)):
        omega, g = factor / 2, Fraction(1000)
        p = 1 + (omega + Fraction(1, 2)) / (2 * g)
        new = g * p / (g + omega)
        assert g * (new - p) ** 2 + abs(new) > g * (1 - p) ** 2 + 1, factor
    p = 1 + Fraction(1, 1000)
    new = 1000 * p / (1000 + Fraction(1, 2))
    assert 1000 * (new - p) ** 2 + abs(new) < 1000 * (1 - p) ** 2 + 1


def test_the_geometric_median_locks_and_is_freed() -> None:
    points = [Fraction(each) for each in (0, 1, 1, 1, -15)]

    def objective(z: Fraction) -> Fraction:
        return sum((abs(z - each) for each in points), Fraction(0))

    def mean(z: Fraction) -> Fraction:
        others = [each for each in points if each != z]
        return sum(each / abs(z - each) for each in others) / sum(1 / abs(z - each) for each in others)

    assert mean(Fraction(5)) == 0
    assert objective(Fraction(median(points))) == 17 < objective(Fraction(0)) == 18
    pull = abs(sum((each > 0) - (each < 0) for each in points))
    z = (1 - Fraction(1, pull)) * mean(Fraction(0))
    assert (pull, z, objective(z)) == (2, Fraction(15, 46), Fraction(813, 46))


def test_the_form_of_the_paper_is_that_of_the_general_theorem() -> None:
    """P of the paper's Q, assembled: its form at (dw, -du) is the sum of squares for Jacobi."""
    rng = np.random.default_rng(0)
    X, dw, du, l1 = rng.normal(size=(2, 3)), rng.normal(size=2), rng.normal(size=3), 0.7
    A, B = np.diag(rng.random(2)), np.diag(rng.random(3))
    rows = np.block([[X.T, np.zeros((3, 3))], [-np.sqrt(l1) * np.eye(2), np.sqrt(l1) * X]])
    P = rows.T @ rows + block_diag(A, B)
    step, other = np.concatenate([dw, -du]), X.T @ dw
    squares = other @ other + l1 * np.sum((dw + X @ du) ** 2) + dw @ A @ dw + du @ B @ du
    np.testing.assert_allclose(step @ P @ step, squares)
