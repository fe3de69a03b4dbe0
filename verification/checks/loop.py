"""Claim B3: the paper's loop does what its reading says, and its trace says what it did."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solvers.paper import LinearSolver, PaperTrace, Stop
from convexperc.solvers.paper.loop import run
from verification.checks.interface import Check, Observation
from verification.checks.measures import drawn_point
from verification.exact.formulation import objective
from verification.exact.numbers import Rationals, rationals, square_root
from verification.ledger.claims import ORDERS, READINGS
from verification.ledger.evidence import Outcome
from verification.problems.families import EXTREME, FAMILIES
from verification.problems.sources import Source

BACKWARD = {LinearSolver.DIRECT: 2e-14, LinearSolver.WOODBURY: 3e-8}
"""Largest residual of an update in its own linear system, as a share of the magnitudes of its terms,
after the rows are divided by the root of the diagonal. Elimination is backward stable: the worst seen is
3.2e-16. Woodbury's identity is not: where two rows nearly agree it leaves the condition times as much, and
the worst seen is 2.9e-10."""

FAMILIES_IN_RANGE = tuple(family for family in FAMILIES if family not in EXTREME)
"""The loop runs on the data as given and squares them: at 1e150 that leaves float64."""

ROUNDING = 2e-14
"""Of F with magnitudes for entries: n + d terms, each good to some 1e-16 of its parts."""

LARGEST = Fraction(2) ** 1020
"""F beyond this may overflow."""

TINY = Fraction(1, 2**1022)
"""The smallest normal number: below it entries lose digits."""

TOLERANCE = 1e-10
"""The loop's own tolerance on its steps, passed to it."""

FACTORS = dict.fromkeys(("printed", "absolute", "appendix_half"), Fraction(1, 2)) | dict.fromkeys(
    ("corrected", "appendix_full", "smoothed"), Fraction(1)
)
"""What multiplies lambda D in the systems: lambda/2 as printed, lambda as F asks for."""


def loop(problem: Problem, source: Source) -> Iterator[Observation]:
    """Run a few iterations of one reading and set one of them beside the box of Algorithm 1.

    The start is the paper's, or a drawn one: the paper's is rounded, and has hardly ever an entry of 0.
    """
    reading, order = source.choice(READINGS), source.choice(ORDERS)
    solver = source.choice(tuple(LinearSolver))
    steps = source.integer(1, 6)
    start = drawn_point(problem, source) if source.integer(0, 1) else None
    trace = run(
        problem,
        variant=reading,
        order=order,
        linear_solver=solver,
        max_iterations=steps,
        tolerance=TOLERANCE,
        start=start,
        keep_iterates=True,
    )
    yield _step(problem, trace, f"{reading} {order} {solver}")
    yield _trace(problem, trace, steps)


def _step(problem: Problem, trace: PaperTrace, name: str) -> Observation:
    """The last complete iteration solves both systems of the reading."""
    part, last = "B3/step", trace.iterations
    if last == 0:
        return Observation.of(part, trace.stop is not Stop.CONVERGED, 0.0, f"{name}: {trace.stop.value}")
    w, u = trace.path_w[last - 1], trace.path_u[last - 1]
    if not (np.isfinite(w).all() and np.isfinite(u).all()):
        return Observation(part, Outcome.UNDECIDED, detail=f"{name}: overflow before the iteration")
    w_next, u_next = trace.path_w[last], trace.path_u[last]
    seen = w_next if trace.order.value == "gauss_seidel" else w
    eps = Fraction(trace.variant.eps or 0.0)
    systems = Systems(problem, trace.variant.name, eps)
    error = max(systems.error_of_w(w, u, w_next), systems.error_of_u(u, seen, u_next))
    measure = float(error) / BACKWARD[trace.linear_solver]
    detail = f"{name}, iteration {last}: residual {float(error):.3g} of its terms"
    return Observation.of(part, measure <= 1.0, measure, detail)


class Systems:
    """Both linear systems of an update, over the rationals.

    Parameters
    ----------
    problem : Problem
    reading : str
    eps : Fraction
        Of the smoothed reading.
    """

    def __init__(self, problem: Problem, reading: str, eps: Fraction) -> None:
        self._reading, self._eps = reading, eps
        self._X = np.array([rationals(row) for row in problem.X], dtype=object).reshape(problem.X.shape)
        self._o = rationals(problem.o)
        self._sizes = problem.modalities.sizes
        self._lambda1, self._lambda2, self._lambda3 = (Fraction(x) for x in problem.lambdas)

    def error_of_w(self, w: np.ndarray, u: np.ndarray, found: np.ndarray) -> Fraction:
        """(XX' + lambda1 I + f lambda2 D^w) w(i+1) against X (o + lambda1 u)."""
        X, size, target = self._X, np.abs(self._X), self._o + self._lambda1 * rationals(u)
        coupling = np.array([[self._lambda1 * (i == j) for j in range(len(X))] for i in range(len(X))])
        sizes = self._view_sizes(rationals(w))
        true = _System(X @ X.T + coupling, X @ target)
        behind = _System(
            size @ size.T + coupling, size @ (np.abs(self._o) + self._lambda1 * np.abs(rationals(u)))
        )
        return self._error(true, behind, sizes, self._lambda2, rationals(found))

    def error_of_u(self, u: np.ndarray, w: np.ndarray, found: np.ndarray) -> Fraction:
        """(lambda1 X'X + f lambda3 D^u) u(i+1) against lambda1 X'w."""
        sizes = np.array(self._modality_sizes(rationals(u)), dtype=object)
        true, behind = (
            _System(self._lambda1 * (X.T @ X), self._lambda1 * (X.T @ seen))
            for X, seen in ((self._X, rationals(w)), (np.abs(self._X), np.abs(rationals(w))))
        )
        return self._error(true, behind, sizes, self._lambda3, rationals(found))

    def _view_sizes(self, w: Rationals) -> Rationals:
        if self._reading == "printed":
            return w
        if self._reading.startswith("appendix"):
            return np.array([sum(abs(x) for x in w)] * len(w), dtype=object)
        if self._reading == "smoothed":
            return np.array([square_root(x * x + self._eps**2).upper for x in w], dtype=object)
        return np.array([abs(x) for x in w], dtype=object)

    def _modality_sizes(self, u: Rationals) -> list[Fraction]:
        sizes: list[Fraction] = []
        for start, size in zip(np.cumsum([0, *self._sizes]), self._sizes, strict=False):
            square = sum((x * x for x in u[start : start + size]), Fraction(0))
            extra = self._eps**2 if self._reading == "smoothed" else Fraction(0)
            sizes += [square_root(square + extra).upper] * size
        return sizes

    def _error(
        self, system: "_System", behind: "_System", sizes: Rationals, weight: Fraction, x: Rationals
    ) -> Fraction:
        """The largest scaled residual over the largest scaled sum of magnitudes; held entries must be 0.

        `behind` is the system with every product in it taken by its size: what rounding is a share of, also
        where products cancel inside of the matrix or of the right side.
        """
        order, factor, gram = len(x), FACTORS[self._reading], system.gram
        free = [k for k in range(order) if weight == 0 or sizes[k] != 0]
        if any(x[k] != 0 for k in range(order) if k not in free):
            return Fraction(1)
        residual = terms = Fraction(0)
        for k in free:
            ridge = factor * weight / (2 * sizes[k]) if weight else Fraction(0)
            scale = square_root(gram[k, k] + abs(ridge)).upper
            if scale == 0:
                continue
            products = [gram[k, at] * x[at] for at in free] + [ridge * x[k], -system.rhs[k]]
            lost = TINY * (sum(abs(gram[k, at]) for at in free) + abs(ridge) + 1)
            residual = max(residual, (abs(sum(products)) - lost) / scale)
            magnitudes = [behind.gram[k, at] * abs(x[at]) for at in free] + [abs(ridge * x[k]), behind.rhs[k]]
            terms = max(terms, sum(magnitudes) / scale)
        return residual / terms if terms else Fraction(0)


@dataclass(frozen=True, eq=False)
class _System:
    """A matrix without its ridge, and a right side."""

    gram: Rationals
    rhs: Rationals


def _trace(problem: Problem, trace: PaperTrace, steps: int) -> Observation:
    """F of every iterate against exact arithmetic; the stop reason against the iterates."""
    wrong = []
    for at, (w, u) in enumerate(zip(trace.path_w, trace.path_u, strict=True)):
        if not (np.isfinite(w).all() and np.isfinite(u).all()):
            if np.isfinite(trace.F[at]):
                wrong.append(f"F({at}) is {trace.F[at]} where an iterate is not finite")
            continue
        value = objective(problem, w, u)
        if not np.isfinite(trace.F[at]) and value.upper > LARGEST:
            continue
        allowed = Fraction(ROUNDING) * _magnitude(problem, w, u) + TINY
        if not _near(trace.F[at], value.lower, value.upper, allowed):
            wrong.append(f"F({at}) is {float(value.lower):.17g}, not {trace.F[at]:.17g}")
    if trace.stop is Stop.ITERATION_LIMIT and trace.iterations != steps:
        wrong.append(f"iteration limit after {trace.iterations} of {steps}")
    if trace.stop in {Stop.CONVERGED, Stop.LOCKED_AT_ZERO} and trace.steps[-1].max() > TOLERANCE:
        wrong.append(f"{trace.stop.value} with steps of {trace.steps[-1].max():.3g}")
    ends = (trace.w, trace.path_w[-1]), (trace.u, trace.path_u[-1])
    if not all(np.array_equal(end, last, equal_nan=True) for end, last in ends):
        wrong.append("w and u are not those of the last iteration")
    return Observation.of("B3/trace", not wrong, float(len(wrong)), "; ".join(wrong[:3]))


def _magnitude(problem: Problem, w: np.ndarray, u: np.ndarray) -> Fraction:
    """F with every sum taken over magnitudes: what its rounding is proportional to."""
    p = _products(problem.X.T, w) + np.abs(rationals(problem.o))
    q = _products(problem.X, u) + np.abs(rationals(w))
    lambda1, lambda2, lambda3 = (Fraction(x) for x in problem.lambdas)
    squares = sum(x * x for x in p) + lambda1 * sum(x * x for x in q)
    norms = lambda2 * sum(abs(x) for x in rationals(w)) + lambda3 * sum(abs(x) for x in rationals(u))
    return Fraction(squares + norms)


def _products(M: np.ndarray, x: np.ndarray) -> Rationals:
    """|M| |x|."""
    exact = np.array([rationals(np.abs(row)) for row in M], dtype=object).reshape(M.shape)
    return np.asarray(exact @ rationals(np.abs(x)))


def _near(value: float, low: Fraction, high: Fraction, allowed: Fraction) -> bool:
    return bool(np.isfinite(value)) and low - allowed <= Fraction(float(value)) <= high + allowed


CHECKS = (Check("loop", ("B3/step", "B3/trace"), loop, FAMILIES_IN_RANGE),)
