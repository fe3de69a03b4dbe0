"""Algorithm 1 against exact rational arithmetic: what each variant does, and what it does not."""

import pickle
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest

from convexperc.errors import InputError, PointError
from convexperc.problem.formulation import objective
from convexperc.problem.problem import Problem
from convexperc.solvers.paper import Order, PaperTrace, Stop
from convexperc.solvers.paper.loop import run
from convexperc.solvers.paper.systems import LinearSolver, derivative_u, derivative_w
from convexperc.solvers.paper.trace import RISE_ROUNDING
from convexperc.solvers.paper.variants import (
    ABSOLUTE,
    APPENDIX_FULL,
    APPENDIX_HALF,
    CORRECTED,
    PRINTED,
    SMOOTHED,
    VARIANTS,
    UpdateVariant,
    smoothed,
)

DESCENDING = (ABSOLUTE, CORRECTED, SMOOTHED)
ORDERS, SOLVERS, HALF = tuple(Order), tuple(LinearSolver), Fraction(1, 2)
Vec = list[Fraction]


# --- the referee: one-column modalities in exact arithmetic; it shares no formula with the code ------------


class Exact:
    """F with one-column modalities over the rationals: x = (w, u), value = smooth + sum_j weight_j |x_j|."""

    def __init__(self, X: Sequence[Sequence[int]], o: Sequence[int], *lambdas: Any) -> None:
        self.X, self.o, (self.l1, self.l2, self.l3) = X, o, map(Fraction, lambdas)
        self.n, self.d = len(X), len(o)
        self.weights = [self.l2] * self.n + [self.l3] * self.d
        size = self.n + self.d
        self.slope = self.differences([Fraction(0)] * size)
        units = [[Fraction(i == j) for i in range(size)] for j in range(size)]
        self.hessian = [[a - b for a, b in zip(self.differences(e), self.slope, strict=True)] for e in units]

    def problem(self) -> Problem:
        l1, l2, l3 = float(self.l1), float(self.l2), float(self.l3)
        return Problem(self.X, self.o, lambda1=l1, lambda2=l2, lambda3=l3, modalities=[1] * self.d)

    def smooth(self, x: Vec) -> Fraction:
        w, u = x[: self.n], x[self.n :]
        p = [sum(self.X[i][k] * w[i] for i in range(self.n)) - self.o[k] for k in range(self.d)]
        q = [sum(self.X[i][k] * u[k] for k in range(self.d)) - w[i] for i in range(self.n)]
        return Fraction(sum(v * v for v in p) + self.l1 * sum(v * v for v in q))

    def value(self, x: Vec) -> Fraction:
        return self.smooth(x) + sum(weight * abs(v) for weight, v in zip(self.weights, x, strict=True))

    def differences(self, x: Vec) -> Vec:
        """The gradient of the quadratic part by central differences, which are exact on a quadratic."""
        shifts = [[v + (i == j) for i, v in enumerate(x)] for j in range(len(x))]
        backs = [[v - (i == j) for i, v in enumerate(x)] for j in range(len(x))]
        return [(self.smooth(a) - self.smooth(b)) / 2 for a, b in zip(shifts, backs, strict=True)]

    def gradient(self, x: Vec) -> Vec:
        """Of the quadratic part."""
        rows = zip(self.hessian, self.slope, strict=True)
        return [sum((h * v for h, v in zip(row, x, strict=True)), g) for row, g in rows]

    def stationary(self, free: Sequence[int], ridge: Vec, shift: Vec, x: Vec) -> Vec | None:
        """The x, changed in `free` only, where gradient_j + ridge_j x_j + shift_j = 0 for j in `free`."""
        base = [Fraction(0) if j in free else v for j, v in enumerate(x)]
        at_base = self.gradient(base)
        matrix = [[self.hessian[i][j] + (ridge[i] if i == j else 0) for j in free] for i in free]
        solution = solve_exactly(matrix, [-at_base[j] - shift[j] for j in free])
        if solution is None:
            return None
        for j, value in zip(free, solution, strict=True):
            base[j] = value
        return base

    def optimum(self, zero: Sequence[int] = ()) -> tuple[Fraction, Vec]:
        """The minimum with x_j = 0 for j in `zero`, proved by the subgradients, over all sign patterns."""
        size, nothing = self.n + self.d, Fraction(0)
        choices = [(0,) if j in zero else (1, -1, 0) if self.weights[j] else (1,) for j in range(size)]
        for signs in product(*choices):
            free = [j for j in range(size) if signs[j]]
            shift = [weight * sign for weight, sign in zip(self.weights, signs, strict=True)]
            x = self.stationary(free, [nothing] * size, shift, [nothing] * size)
            if x is None or any(x[j] * signs[j] <= 0 for j in free if self.weights[j]):
                continue
            slope = self.gradient(x)
            if all(signs[j] or j in zero or abs(slope[j]) <= self.weights[j] for j in range(size)):
                return self.value(x), x
        raise AssertionError(f"no sign pattern is optimal for {vars(self)}")

    def step(self, x: Vec, factor: Fraction, order: Order, size: Callable[[Fraction], Fraction] = abs) -> Vec:
        """One iteration: gradient_j + factor weight_j x_j / size(x_j before) = 0, first in w, then in u."""
        ridge = [factor * c / size(v) if v else Fraction(0) for c, v in zip(self.weights, x, strict=True)]
        free = [j for j, v in enumerate(x) if v or not self.weights[j]]
        nothing = [Fraction(0)] * len(x)
        new_w = self.stationary([j for j in free if j < self.n], ridge, nothing, x)
        assert new_w is not None, x
        seen = new_w if order is Order.GAUSS_SEIDEL else x
        new_u = self.stationary([j for j in free if j >= self.n], ridge, nothing, seen)
        assert new_u is not None, x
        return new_w[: self.n] + new_u[self.n :]


def solve_exactly(A: Sequence[Sequence[Fraction]], b: Vec) -> Vec | None:
    """Gauss-Jordan over the rationals; None when A is singular."""
    rows = [[*map(Fraction, row), value] for row, value in zip(A, b, strict=True)]
    for c in range(len(b)):
        pivot = next((r for r in range(c, len(b)) if rows[r][c] != 0), None)
        if pivot is None:
            return None
        rows[c], rows[pivot] = rows[pivot], rows[c]
        rows[c] = [v / rows[c][c] for v in rows[c]]
        for r in range(len(b)):
            if r != c and rows[r][c] != 0:
                rows[r] = [v - rows[r][c] * p for v, p in zip(rows[r], rows[c], strict=True)]
    return [row[-1] for row in rows]


def fractions(*values: Any) -> Vec:
    return [Fraction(v) for v in values]


SIGN = Exact([[1]], [-1], 1, 4, 0)
SINGULAR = Exact([[1]], [-2], 1, 16, 0)
LIMIT = Exact([[1]], [1], 1, 1, 0)
RISING = Exact([[1, -3], [-1, 2]], [1, -4], 2, 2, 2)
LOCKED_W = Exact([[1, 0], [3, 1]], [1, 0], 1, 1, 0)
LOCKED_U = Exact([[1, 3], [0, 1]], [1, 3], 1, 0, 1)


@pytest.mark.parametrize(
    ("case", "zero", "value", "w"),
    [
        (SIGN, (), "1", (0,)),
        (SINGULAR, (), "4", (0,)),
        (LIMIT, (), "3/4", ("1/2",)),
        (RISING, (), "2799/802", ("357/401", "-153/401")),
        (LOCKED_W, (), "3/8", (0, "1/4")),
        (LOCKED_W, (1,), "3/4", ("1/2", 0)),
        (LOCKED_U, (), "135/476", ("215/238", "32/119")),
        (LOCKED_U, (3,), "31/44", ("10/11", "3/22")),
    ],
)
def test_exact_optima_of_the_counterexamples(
    case: Exact, zero: tuple[int, ...], value: str, w: tuple[Any, ...]
) -> None:
    found, x = case.optimum(zero)
    assert found == Fraction(value), (found, x)
    assert x[: case.n] == fractions(*w), x


# --- the counterexamples -----------------------------------------------------------------------------------


def test_printed_sign_raises_the_objective() -> None:
    trace = run(SIGN.problem(), variant="printed", keep_iterates=True)
    assert trace.path_w[:, 0].tolist() == [-1.0, -2.0, -2.0], trace.path_w
    assert trace.F.tolist() == [4.0, 9.0, 9.0], trace.F
    assert trace.rises().tolist() == [1], trace.rises()
    assert trace.stop is Stop.CONVERGED, trace.stop
    x = fractions(-1, -1)
    for value in (4, 9, 9):
        assert SIGN.value(x) == value, (x, SIGN.value(x))
        x = SIGN.step(x, HALF, Order.GAUSS_SEIDEL, size=lambda v: v)


@pytest.mark.parametrize("linear_solver", SOLVERS)
def test_printed_sign_makes_a_system_singular(linear_solver: LinearSolver) -> None:
    problem = SINGULAR.problem()
    trace = run(problem, variant=PRINTED, linear_solver=linear_solver)
    assert (trace.stop, trace.iterations, trace.w.tolist()) == (Stop.SINGULAR, 0, [-2.0]), trace
    held = run(problem, variant=PRINTED, linear_solver=linear_solver, on_singular="minimum_norm")
    assert (held.stop, held.w.tolist(), held.F[-1]) == (Stop.CONVERGED, [0.0], 4.0), held


def test_printed_sign_can_blow_up() -> None:
    problem = Problem([[1.0]], [-1.0], lambda1=1, lambda2=8 * (1 - 1e-13), lambda3=0)
    trace = run(problem, variant=PRINTED)
    assert trace.stop is Stop.DIVERGED, (trace.stop, trace.F)
    assert np.isfinite(trace.w).all(), trace.w
    cancelled = Problem([[1.0]], [-1.0], lambda1=1, lambda2=float(np.nextafter(8, 0)), lambda3=0)
    stopped = run(cancelled, variant=PRINTED)
    assert (stopped.stop, stopped.iterations) == (Stop.SINGULAR, 0), (stopped.stop, stopped.F)


@pytest.mark.parametrize("order", ORDERS)
def test_absolute_has_the_wrong_limit(order: Order) -> None:
    problem = LIMIT.problem()
    wrong, right = (run(problem, variant=r, order=order, tolerance=1e-13) for r in (ABSOLUTE, CORRECTED))
    np.testing.assert_allclose([wrong.w[0], wrong.F[-1]], [3 / 4, 13 / 16], rtol=1e-11)
    np.testing.assert_allclose([right.w[0], right.F[-1]], [1 / 2, 3 / 4], rtol=1e-11)
    assert LIMIT.value(fractions("3/4", "3/4")) == Fraction(13, 16)
    assert LIMIT.step(fractions("3/4", "3/4"), HALF, order) == fractions("3/4", "3/4")
    assert Exact([[1]], [1], 1, HALF, 0).optimum()[1] == fractions("3/4", "3/4")


def test_absolute_climbs_from_the_optimum_itself() -> None:
    trace = run(LIMIT.problem(), variant=ABSOLUTE, start=([0.5], [0.5]), max_iterations=1)
    x = LIMIT.step(fractions(HALF, HALF), HALF, Order.GAUSS_SEIDEL)
    assert (LIMIT.value(fractions(HALF, HALF)), LIMIT.value(x)) == (Fraction(3, 4), Fraction(19, 25)), x
    np.testing.assert_allclose(trace.F, [3 / 4, 19 / 25], rtol=1e-15)
    assert trace.rises().tolist() == [1], trace.F
    assert trace.own_rises().tolist() == [], trace.own


def test_absolute_climbs_from_the_start_of_the_paper() -> None:
    x = fractions(2, 1, -7, -3)
    assert RISING.smooth(x) == 0, "the start solves both least-squares problems exactly"
    exact = [RISING.value(x)]
    for _ in range(7):
        x = RISING.step(x, HALF, Order.GAUSS_SEIDEL)
        exact.append(RISING.value(x))
    rises = [i for i in range(1, len(exact)) if exact[i] > exact[i - 1]]
    assert rises == [7], [float(value) for value in exact]
    assert float(exact[7] - exact[6]) == pytest.approx(0.0034338235412328, rel=1e-10)
    trace = run(RISING.problem(), variant=ABSOLUTE)
    np.testing.assert_allclose(trace.F[:8], [float(value) for value in exact], rtol=1e-11)
    assert trace.rises()[0] == 7, trace.rises()
    assert trace.own_rises().size == 0, trace.own


def test_absolute_climbs_in_jacobi_order_too() -> None:
    """Ten exact steps would cost seconds: only the tenth is exact, from the float iterate before it."""
    trace = run(RISING.problem(), variant=ABSOLUTE, order=Order.JACOBI, keep_iterates=True)
    assert trace.rises()[0] == 10, trace.rises()
    before = fractions(*trace.path_w[9].tolist(), *trace.path_u[9].tolist())
    after = RISING.step(before, HALF, Order.JACOBI)
    rise = RISING.value(after) - RISING.value(before)
    assert float(rise) == pytest.approx(0.0076466251011377, rel=1e-9), float(rise)
    assert trace.F[10] - trace.F[9] == pytest.approx(float(rise), rel=1e-10), trace.F[9:11]
    assert trace.own_rises().size == 0, trace.own


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("linear_solver", SOLVERS)
@pytest.mark.parametrize(
    ("case", "start", "locked"),
    [(LOCKED_W, ([1, 0], [1, -3]), (1, None)), (LOCKED_U, ([1, 0], [1, 0]), (None, 1))],
    ids=["w", "u"],
)
def test_an_exact_zero_stays_locked(
    case: Exact, start: Any, locked: tuple[int | None, int | None], linear_solver: LinearSolver, order: Order
) -> None:
    problem = case.problem()
    options: dict[str, Any] = {"order": order, "linear_solver": linear_solver}
    trace = run(problem, variant=CORRECTED, start=start, **options)
    zero = locked[0] if locked[0] is not None else case.n + int(locked[1] or 0)
    assert trace.stop is Stop.LOCKED_AT_ZERO, (trace.stop, trace.w, trace.u)
    assert trace.F[-1] == pytest.approx(float(case.optimum([zero])[0]), rel=1e-9), trace.F[-1]
    assert (trace.w, trace.u)[zero >= case.n][1] == 0.0, (trace.w, trace.u)
    named = tuple(() if j is None else (j,) for j in locked)
    assert (trace.locked_views, trace.locked_modalities) == named, trace
    for point in (start, (trace.w, trace.u)):
        w0, u0 = (np.where(np.array(part) == 0, 1e-17, part) for part in point)
        escaped = run(problem, variant=CORRECTED, start=(w0, u0), **options)
        assert escaped.stop is Stop.CONVERGED, (point, escaped.stop, escaped.iterations)
        assert escaped.F[-1] == pytest.approx(float(case.optimum()[0]), rel=1e-9), (point, escaped.F[-1])


@pytest.mark.parametrize("case", [LOCKED_W, LOCKED_U], ids=["w", "u"])
def test_the_start_in_float64_decides_whether_it_locks(case: Exact) -> None:
    trace = run(case.problem(), variant=CORRECTED, keep_iterates=True)
    start, zero = np.concatenate([trace.path_w[0], trace.path_u[0]]), 1 if case is LOCKED_W else 3
    exactly = start[zero] == 0.0
    expected = case.optimum([zero] if exactly else [])[0]
    assert abs(start[zero]) < 1e-14, start
    assert trace.F[-1] == pytest.approx(float(expected), rel=1e-9), (trace.F[-1], start)
    assert trace.stop is (Stop.LOCKED_AT_ZERO if exactly else Stop.CONVERGED), (trace.stop, start)


def test_a_zero_that_belongs_there_is_not_locked() -> None:
    for lambda2, variant, stop in [
        (3, CORRECTED, Stop.CONVERGED),
        (3, ABSOLUTE, Stop.LOCKED_AT_ZERO),
        (1.9, CORRECTED, Stop.LOCKED_AT_ZERO),
        (3, PRINTED, Stop.CONVERGED),
        (1.9, SMOOTHED, Stop.CONVERGED),
    ]:
        problem = Problem([[1]], [1], lambda1=1, lambda2=lambda2, lambda3=0)
        trace = run(problem, variant=variant, start=([0], [0]))
        assert trace.stop is stop, (lambda2, variant.name, trace.stop, trace.w)
    for lambda3, variant, stop in [
        (1.5, CORRECTED, Stop.CONVERGED),
        (1.5, ABSOLUTE, Stop.LOCKED_AT_ZERO),
        (0.9, CORRECTED, Stop.LOCKED_AT_ZERO),
        (1.5, APPENDIX_HALF, Stop.CONVERGED),
    ]:
        problem = Problem([[1]], [1], lambda1=1, lambda2=0, lambda3=lambda3)
        trace = run(problem, variant=variant, start=([0.5], [0]))
        assert trace.stop is stop, (lambda3, variant.name, trace.stop, trace.u)


def test_only_a_penalised_entry_is_waited_for() -> None:
    for weight, waits in ((0.0, False), (1e-25, True)):
        problem = Problem(np.eye(2), [1, 1e-20], lambda1=1, lambda2=weight, lambda3=weight, modalities=[1, 1])
        trace = run(problem, variant=CORRECTED, start=([1, 1e-22], [1, 1e-22]))
        assert trace.stop is Stop.CONVERGED, trace.stop
        assert (trace.iterations > 1) == waits, (weight, trace.iterations)


@pytest.mark.parametrize(
    ("variant", "w", "value"),
    [(APPENDIX_FULL, ("9/4", "3/4"), "53/8"), (APPENDIX_HALF, ("21/8", "7/8"), "229/32")],
    ids=["full", "half"],
)
def test_appendix_shrinks_every_view_alike(variant: UpdateVariant, w: tuple[str, str], value: str) -> None:
    case = Exact([[1, 0], [0, 1]], [3, 1], 0, 2, 1)
    point = fractions(*w, 0, 0)
    assert case.optimum() == (Fraction(6), fractions(2, 0, 0, 0)), case.optimum()
    assert case.value(point) == Fraction(value), case.value(point)
    trace = run(case.problem(), variant=variant, tolerance=1e-13)
    np.testing.assert_allclose(trace.w, [float(v) for v in point[:2]], rtol=1e-11)
    assert trace.F[-1] == pytest.approx(float(Fraction(value)), rel=1e-11), trace.F[-1]
    assert trace.own.shape == (0,), trace.own


# --- random problems ---------------------------------------------------------------------------------------


def random_problem(seed: int, shape: tuple[int, list[int]] | None = None, **lambdas: float) -> Problem:
    rng = np.random.default_rng(seed)
    n, sizes = shape or (int(rng.integers(1, 6)), rng.integers(1, 5, rng.integers(1, 4)).tolist())
    X = rng.normal(size=(n, sum(sizes)))
    drawn = dict(zip(("lambda1", "lambda2", "lambda3"), 10 ** rng.uniform(-1, 0.7, 3), strict=True))
    o = X.T @ rng.normal(size=n) + 0.3 * rng.normal(size=sum(sizes))
    return Problem(X, o, modalities=sizes, **(drawn | lambdas))


@cache
def corrected(seed: int, order: Order = Order.GAUSS_SEIDEL) -> PaperTrace:
    """Where the corrected variant takes `random_problem(seed)`."""
    return run(random_problem(seed), variant=CORRECTED, order=order)


def lower_bound(problem: Problem, w: np.ndarray, u: np.ndarray) -> float:
    """D(s a, s b) <= F* for a, b from (w, u), scaled to be feasible."""
    a, b = 2 * (problem.X.T @ w - problem.o), 2 * problem.lambda1 * (problem.X @ u - w)
    sides = [(problem.lambda2, np.abs(problem.X @ a - b).max())]
    sides += [(problem.lambda3, np.linalg.norm(X_i.T @ b)) for X_i in problem.blocks()]
    curvature = a @ a / 4 + b @ b / (4 * problem.lambda1)
    s = min(-(a @ problem.o) / (2 * curvature), *(bound / side for bound, side in sides if side > 0))
    return float(-s * (a @ problem.o) - s * s * curvature)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
@pytest.mark.parametrize("shape", [(3, [4, 3]), (2, [2]), (6, [2, 1])], ids=["n<d", "n=d", "n>d"])
def test_direct_and_woodbury_are_one_iteration(
    shape: tuple[int, list[int]], variant: UpdateVariant, order: Order
) -> None:
    for seed in range(2):
        problem = random_problem(seed, shape)
        options: dict[str, Any] = {
            "variant": variant,
            "order": order,
            "max_iterations": 12,
            "keep_iterates": True,
        }
        direct, woodbury = (run(problem, linear_solver=solver, **options) for solver in SOLVERS)
        assert direct.path_w.shape == woodbury.path_w.shape == (direct.iterations + 1, problem.n)
        assert direct.path_u.shape == (direct.iterations + 1, problem.d), direct.path_u.shape
        for one, other in ((direct.path_w, woodbury.path_w), (direct.path_u, woodbury.path_u)):
            np.testing.assert_allclose(
                one, other, rtol=1e-7, atol=1e-9 * np.abs(one).max(), err_msg=f"{seed}"
            )


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("variant", DESCENDING, ids=lambda variant: variant.name)
def test_own_objective_never_rises(variant: UpdateVariant, order: Order) -> None:
    """Jacobi too: the Hessian stays positive semidefinite when its coupling of w and u changes sign."""
    for seed in range(6):
        problem = random_problem(seed)
        rng = np.random.default_rng(seed)
        for start in (None, (rng.normal(size=problem.n), 10 * rng.normal(size=problem.d))):
            trace = run(problem, variant=variant, order=order, max_iterations=30, start=start)
            assert trace.own.shape == trace.F.shape, (trace.own.shape, trace.F.shape)
            assert trace.own_rises().size == 0, (seed, np.diff(trace.own).max(), trace.scale)
            assert trace.own[-1] < trace.own[0], (seed, trace.own)


@pytest.mark.parametrize("order", ORDERS)
def test_corrected_reaches_the_optimum(order: Order) -> None:
    for seed in range(5):
        problem = random_problem(seed)
        trace = corrected(seed, order)
        low = lower_bound(problem, trace.w, trace.u)
        assert trace.stop is Stop.CONVERGED, (seed, trace.stop)
        assert low <= trace.F[-1] + RISE_ROUNDING * trace.scale, (seed, low, trace.F[-1])
        assert trace.F[-1] - low <= 1e-6 * trace.scale, (seed, low, trace.F[-1])
        np.testing.assert_allclose(trace.own, trace.F, rtol=1e-14)


def test_absolute_is_corrected_with_half_the_lambdas() -> None:
    for seed in range(4):
        problem = random_problem(seed)
        l1, l2, l3 = problem.lambdas
        halved = Problem(
            problem.X, problem.o, modalities=problem.modalities, lambda1=l1, lambda2=l2 / 2, lambda3=l3 / 2
        )
        one, other = (
            run(p, variant=r, max_iterations=40) for p, r in ((problem, ABSOLUTE), (halved, CORRECTED))
        )
        np.testing.assert_array_equal(one.w, other.w)
        np.testing.assert_array_equal(one.u, other.u)
        np.testing.assert_allclose(one.own, other.F, rtol=1e-14)


def test_absolute_converges_to_the_optimum_of_the_halved_problem_exactly_refereed() -> None:
    case = RISING
    halved = Exact(case.X, case.o, case.l1, case.l2 / 2, case.l3 / 2)
    value, x = halved.optimum()
    trace = run(case.problem(), variant=ABSOLUTE, tolerance=1e-13)
    assert value == Fraction(6191, 3208), value
    assert trace.own[-1] == pytest.approx(float(value), rel=1e-11), trace.own[-1]
    np.testing.assert_allclose(np.concatenate([trace.w, trace.u]), [float(v) for v in x], atol=1e-9)


@pytest.mark.parametrize("eps", [None, 1e-1, 1e-3])
def test_smoothed_limit_is_within_its_bound(eps: float | None) -> None:
    for seed in range(3):
        problem = random_problem(seed)
        trace = run(problem, variant=smoothed(eps))
        best = corrected(seed)
        low = lower_bound(problem, best.w, best.u)
        used = trace.variant.eps
        assert used is not None
        loss = used * (problem.n * problem.lambda2 + problem.m * problem.lambda3)
        assert eps is not None or loss == pytest.approx(1e-6 * (problem.o @ problem.o), rel=1e-12), loss
        slack = 1e-6 * trace.scale
        assert low - slack <= trace.F[-1] <= trace.own[-1] <= best.F[-1] + loss + slack, (
            seed,
            loss,
            trace.F[-1],
        )
        assert (trace.own <= trace.F + loss + 1e-12 * trace.scale).all(), (trace.own - trace.F).max()
        assert (trace.own >= trace.F).all(), (trace.own - trace.F).min()
        assert trace.stop is Stop.CONVERGED, (seed, trace.stop)


def test_smoothed_leaves_an_exact_zero() -> None:
    for case, start in ((LOCKED_W, ([1, 0], [1, -3])), (LOCKED_U, ([1, 0], [1, 0]))):
        trace = run(case.problem(), variant=smoothed(1e-7), start=start)
        best = float(case.optimum()[0])
        assert best - 1e-12 <= trace.F[-1] <= best + 1e-7 * 2 + 1e-12, (trace.F[-1], best)


def test_one_view_makes_the_appendix_agree() -> None:
    for seed in range(3):
        problem = random_problem(seed, (1, [2, 3]))
        for appendix, plain in ((APPENDIX_FULL, CORRECTED), (APPENDIX_HALF, ABSOLUTE)):
            one, other = (run(problem, variant=r, max_iterations=50) for r in (appendix, plain))
            np.testing.assert_array_equal(one.F, other.F)


def test_readings_differ_where_they_should() -> None:
    problem = random_problem(3, (3, [2, 3]))
    limits = {variant.name: run(problem, variant=variant).F[-1] for variant in VARIANTS}
    best = limits["corrected"]
    for name, value in limits.items():
        near = name in ("corrected", "smoothed")
        assert (value - best < 2e-6 * (problem.o @ problem.o)) == near, limits


# --- the printed derivatives -------------------------------------------------------------------------------


def test_derivatives_printed_and_corrected() -> None:
    problem = Problem([[1.0]], [0.0], lambda1=1, lambda2=4, lambda3=2)
    w, u = np.array([-1.0]), np.array([-1.0])
    found = [
        f(problem, variant, w, u)[0] for variant in (CORRECTED, PRINTED) for f in (derivative_w, derivative_u)
    ]
    assert found == [-6.0, -2.0, 0.0, -1.0], found


def test_corrected_derivative_is_the_derivative() -> None:
    problem, h = random_problem(5, (3, [2, 3])), 1e-6
    rng = np.random.default_rng(5)
    w, u = rng.normal(size=3), rng.normal(size=5)
    slopes_w = [
        (objective(problem, w + e, u) - objective(problem, w - e, u)) / (2 * h) for e in h * np.eye(3)
    ]
    slopes_u = [
        (objective(problem, w, u + e) - objective(problem, w, u - e)) / (2 * h) for e in h * np.eye(5)
    ]
    np.testing.assert_allclose(derivative_w(problem, CORRECTED, w, u), slopes_w, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(derivative_u(problem, CORRECTED, w, u), slopes_u, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_a_fixed_point_zeroes_the_derivatives_of_its_reading(variant: UpdateVariant) -> None:
    problem = random_problem(3, (2, [2, 2]), lambda2=0.1, lambda3=0.1)
    trace = run(problem, variant=variant, tolerance=1e-11)
    assert trace.stop is Stop.CONVERGED, trace.stop
    slopes = [f(problem, trace.variant, trace.w, trace.u) for f in (derivative_w, derivative_u)]
    np.testing.assert_allclose(np.concatenate(slopes), 0.0, atol=1e-7 * trace.scale)


# --- zeros among the lambdas, singular systems -------------------------------------------------------------


@pytest.mark.parametrize("linear_solver", SOLVERS)
@pytest.mark.parametrize("shape", [(2, [3, 2]), (4, [2, 1])], ids=["n<d", "n>d"])
@pytest.mark.parametrize("zeros", list(product([0, 1], repeat=3)), ids=str)
def test_any_lambda_may_be_zero(
    zeros: tuple[int, ...], shape: tuple[int, list[int]], linear_solver: LinearSolver
) -> None:
    l1, l2, l3 = (0.7 * keep for keep in zeros)
    problem = random_problem(1, shape, lambda1=l1, lambda2=l2, lambda3=l3)
    options: dict[str, Any] = {"linear_solver": linear_solver, "max_iterations": 20}
    n, d = problem.n, problem.d
    singular = (l1 == l2 == 0 and n > d) or (l3 == 0 and (n < d or l1 == 0))
    for variant in VARIANTS:
        plain = run(problem, variant=variant, **options)
        assert (plain.stop is Stop.SINGULAR) == singular, (variant.name, plain.stop)
        trace = run(problem, variant=variant, on_singular="minimum_norm", **options) if singular else plain
        assert trace.iterations >= 1, trace
        assert np.isfinite(trace.F).all(), trace.F
        assert trace.own_rises().size == 0, (variant.name, trace.own)
        if l1 == 0:
            assert not trace.u.any(), (variant.name, trace.u)
        if l2 == l3 == 0:
            np.testing.assert_allclose(trace.F, trace.F[0], rtol=0, atol=1e-12 * trace.scale)


@pytest.mark.parametrize("linear_solver", SOLVERS)
@pytest.mark.parametrize(
    ("n", "d", "rank", "singular"),
    [(2, 5, 2, True), (1, 2, 1, True), (5, 3, 2, True), (5, 3, 3, False), (3, 3, 3, False)],
)
def test_without_lambda3_the_rank_decides(
    n: int, d: int, rank: int, singular: bool, linear_solver: LinearSolver
) -> None:
    for seed in range(2):
        rng = np.random.default_rng(seed)
        X = rng.normal(size=(n, rank)) @ rng.normal(size=(rank, d))
        problem = Problem(X, rng.normal(size=d), lambda1=0.5, lambda2=0.2, lambda3=0)
        options: dict[str, Any] = {"variant": CORRECTED, "linear_solver": linear_solver, "max_iterations": 20}
        trace = run(problem, **options)
        assert (trace.stop is Stop.SINGULAR) == singular, (seed, trace.stop)
        held = run(problem, on_singular="minimum_norm", **options)
        np.testing.assert_allclose(held.u, np.linalg.pinv(X, rcond=1e-9) @ held.w, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("order", ORDERS)
def test_duplicate_views_without_penalty_take_the_least_norm(order: Order) -> None:
    X = np.array([[1.0, 2, 3, 4], [1, 2, 3, 4], [2, 0, 1, 1]])
    problem = Problem(X, [1, 1, 2, 0], lambda1=0, lambda2=0, lambda3=0.5)
    assert run(problem, order=order).stop is Stop.SINGULAR
    trace = run(problem, order=order, on_singular="minimum_norm")
    np.testing.assert_allclose(trace.w, np.linalg.pinv(X.T) @ problem.o, rtol=1e-12)


def test_a_huge_diagonal_is_not_singular() -> None:
    problem = random_problem(0, (3, [2, 2]))
    start = (np.array([1.0, 1e-200, 1e-308]), np.array([1.0, 1.0, 1e-250, 1e-250]))
    for variant, solver in product((PRINTED, CORRECTED), SOLVERS):
        trace = run(problem, variant=variant, linear_solver=solver, start=start, max_iterations=5)
        assert trace.iterations == 5, (variant.name, solver, trace.stop)
        assert np.isfinite(trace.F).all(), trace.F


@pytest.mark.parametrize("solver", SOLVERS)
def test_absurd_scales_end_without_nan(solver: LinearSolver) -> None:
    for scale in (1e-160, 1e160):
        trace = run(
            Problem([[scale, scale / 2]], [1, 1], lambda1=1, lambda2=1, lambda3=1), linear_solver=solver
        )
        assert trace.stop in (Stop.DIVERGED, Stop.CONVERGED, Stop.SINGULAR), (scale, trace.stop)
        assert np.isfinite(trace.w).all(), (scale, trace.w)


def test_the_start_is_least_squares_of_least_norm() -> None:
    for shape in ((2, [3, 2]), (5, [2, 1])):
        problem = random_problem(7, shape)
        trace = run(problem, max_iterations=0)
        pinv = np.linalg.pinv(problem.X)
        np.testing.assert_allclose(trace.w, pinv.T @ problem.o, rtol=1e-10)
        np.testing.assert_allclose(trace.u, pinv @ trace.w, rtol=1e-10)
        assert (trace.stop, trace.iterations) == (Stop.ITERATION_LIMIT, 0), trace


# --- the trace and the arguments ---------------------------------------------------------------------------


def test_trace_is_frozen_and_pickles() -> None:
    problem = random_problem(2)
    trace = run(problem, variant="smoothed", keep_iterates=True, max_iterations=7, tolerance=0.0)
    again: PaperTrace = pickle.loads(pickle.dumps(trace))
    for one in (trace, again):
        for name in ("w", "u", "F", "own", "steps", "path_w", "path_u"):
            array = getattr(one, name)
            assert not array.flags.writeable, name
            np.testing.assert_array_equal(array, getattr(trace, name))
    assert (again.variant, again.stop, again.iterations) == (trace.variant, Stop.ITERATION_LIMIT, 7), again
    assert trace.steps.shape == (7, 2), trace.steps.shape
    np.testing.assert_array_equal(trace.path_u[-1], trace.u)
    change = np.linalg.norm(trace.path_w[1] - trace.path_w[0])
    sizes = [np.linalg.norm(w) for w in trace.path_w[:2]]
    assert trace.steps[0, 0] == pytest.approx(change / max(sizes), rel=1e-14), trace.steps
    grown = run(LIMIT.problem(), start=([0.1], [0.1]), max_iterations=1)
    assert grown.w[0] > 0.1, grown.w
    assert grown.steps[0, 0] == pytest.approx((grown.w[0] - 0.1) / grown.w[0], rel=1e-14), grown.steps
    F = [objective(problem, w, u) for w, u in zip(trace.path_w, trace.path_u, strict=True)]
    np.testing.assert_array_equal(trace.F, F)
    bare = run(problem, max_iterations=2)
    assert (bare.path_w.shape, bare.path_u.shape) == ((0, problem.n), (0, problem.d)), bare


def test_rises_allow_for_rounding_only() -> None:
    trace = run(SIGN.problem(), variant=PRINTED)
    assert trace.scale == 4.0, trace.scale
    assert trace.rises(1.24).tolist() == [1], trace.F
    assert trace.rises(1.26).tolist() == [], trace.F


def test_names_and_members_are_the_same() -> None:
    problem = random_problem(4)
    one = run(problem, variant="corrected", order="jacobi", linear_solver="woodbury", on_singular="stop")
    other = run(problem, variant=CORRECTED, order=Order.JACOBI, linear_solver=LinearSolver.WOODBURY)
    np.testing.assert_array_equal(one.F, other.F)
    assert one.linear_solver is LinearSolver.WOODBURY, one.linear_solver


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"variant": "exact"}, InputError, "printed, absolute, corrected"),
        ({"order": "chaotic"}, InputError, "gauss_seidel, jacobi"),
        ({"linear_solver": "lu"}, InputError, "direct, woodbury"),
        ({"on_singular": "pray"}, InputError, "stop, minimum_norm"),
        ({"tolerance": -1.0}, InputError, "tolerance must be a finite real number >= 0"),
        ({"tolerance": float("nan")}, InputError, "tolerance"),
        ({"max_iterations": -1}, InputError, "max_iterations must be an integer >= 0"),
        ({"max_iterations": True}, InputError, "max_iterations must be an integer >= 0"),
        ({"start": ([1.0], [1.0, 2.0])}, PointError, "start: u must have 1 entries"),
        ({"start": ([1.0, 2.0], [1.0])}, PointError, "start: w must have 1 entries"),
        ({"start": ([float("nan")], [1.0])}, PointError, r"w\[0\] must be finite"),
    ],
)
def test_bad_arguments_are_named(options: dict[str, Any], error: type[InputError], words: str) -> None:
    with pytest.raises(error, match=words):
        run(LIMIT.problem(), **options)


@pytest.mark.parametrize("eps", [0.0, -1.0, float("inf"), float("nan")])
def test_smoothing_must_be_positive(eps: float) -> None:
    with pytest.raises(InputError, match="eps must be"):
        smoothed(eps)
