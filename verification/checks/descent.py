"""Claims T1a, T1b and T1c on one run: does F rise, where does the run end, how far does each step fall."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from convexperc.certificate.certificate import Certificate
from convexperc.errors import SolverError
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution, Status
from convexperc.solvers.paper import PaperTrace, Stop
from convexperc.solvers.paper.loop import run
from verification.checks.interface import Check, Observation
from verification.exact.algorithm import Update
from verification.exact.balls import UnresolvedError
from verification.exact.formulation import objective
from verification.exact.loop import Enclosures, Rise, rise_confirmed, step
from verification.exact.numbers import Entries, Rationals, rationals, square_root, squares
from verification.exact.reweighting import SingularStepError
from verification.ledger.claims import ORDERS, READINGS
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

ITERATIONS = 150
"""Most iterations of a run; runs that need more are undecided for T1b."""

ROUNDING = 2e-14
"""Of max(F(start), ||o||^2): the rounding of F, as the ledger says. A rise beyond it is confirmed exactly."""

PROMISED = 1e-12
"""Of the same: the rounding of F, of an ill-conditioned update, and of the squares of its steps.
A fall that is shorter than promised by more is judged exactly."""

SQUARABLE = 1e-70, 1e70
"""Sizes whose products of four stay in float64: the loop squares the data as given, and is judged in here."""

EXACT = Fraction(1, 10**40)
"""A rise of an own objective within this share of it may come from the 70 digits of the exact update."""

REACHED = 1e-6
"""Of F*: what the loop's own test of 1e-10 on the steps leaves where it converges slowly."""

REACHED_FLOOR = 1e-12
"""Of ||o||^2, for problems with F* = 0."""


@dataclass(frozen=True)
class Terms:
    """The data of a problem in one kind of number, float64 or Fractions, and the norm of a vector of them."""

    X: Any
    modalities: Iterable[Any]
    lambdas: tuple[Any, ...]
    norm: Callable[[Any], Any]


@dataclass(frozen=True)
class Descent:
    """One reading in one order, from the paper's start."""

    reading: str
    order: str

    def __call__(self, problem: Problem, source: Source) -> Iterator[Observation]:
        """Run the loop once and look at it."""
        trace = run(
            problem, variant=self.reading, order=self.order, max_iterations=ITERATIONS, keep_iterates=True
        )
        optimum = _optimum(problem)
        yield self._descends(problem, trace)
        yield self._reaches(problem, trace, optimum)
        if self.reading == "corrected":
            yield self._falls(problem, trace)
            yield _limit(problem, trace, optimum)
        if self.reading == "absolute":
            yield self._own("T1c/absolute", problem, trace)
        if self.reading == "smoothed":
            yield self._own("T1c/smoothed_descent", problem, trace)
            yield _distance(problem, trace, optimum)

    def _descends(self, problem: Problem, trace: PaperTrace) -> Observation:
        """T1a: a rise counts once it is confirmed exactly from the iterate before it."""
        part = f"T1a/{self.reading}/{self.order}"
        rises = trace.rises(ROUNDING)
        largest = _largest_rise(trace.F, trace.scale)
        for at in rises:
            rise = self._exactly(problem, trace, int(at))
            if rise is not None and rise.confirmed:
                detail = f"iteration {at}: F {trace.F[at - 1]:.17g} -> {trace.F[at]:.17g}"
                return Observation(part, Outcome.FAILED, largest, detail)
        if rises.size:
            return Observation(part, Outcome.UNDECIDED, largest, "every rise is rounding: none is exact")
        return Observation(part, Outcome.HELD, 0.0)

    def _reaches(self, problem: Problem, trace: PaperTrace, optimum: Solution | None) -> Observation:
        """T1b: where a run that ended by itself has ended."""
        part = f"T1b/{self.reading}/{self.order}"
        if optimum is None or not np.isfinite(trace.F[-1]):
            return Observation(part, Outcome.UNDECIDED, detail="F* is not certified, or F not finite")
        share, reached = distance_to_optimum(problem, trace, optimum.certificate)
        if reached:
            return Observation(part, Outcome.HELD, share)
        if trace.stop in {Stop.SINGULAR, Stop.DIVERGED}:
            ended = self._singular(problem, trace) if trace.stop is Stop.SINGULAR else _squarable(problem)
            detail = f"{trace.stop.value} after {trace.iterations} iterations"
            return Observation(part, Outcome.FAILED if ended else Outcome.UNDECIDED, np.inf, detail)
        detail = f"{trace.stop.value}: {_ends(trace, optimum)}"
        settled = trace.stop in {Stop.CONVERGED, Stop.LOCKED_AT_ZERO} and _tells(problem, trace, optimum)
        return Observation(part, Outcome.FAILED if settled else Outcome.UNDECIDED, share, detail)

    def _falls(self, problem: Problem, trace: PaperTrace) -> Observation:
        """T1c: F falls by at least the weighted squares of the steps."""
        part = f"T1c/descent/{self.order}"
        worst, where, terms = 0.0, 0, _floating(problem)
        points = list(zip(trace.path_w, trace.path_u, strict=True))
        for at in range(1, trace.iterations + 1):
            with np.errstate(all="ignore"):
                promised = promised_fall(terms, self.order, points[at - 1], points[at])
            if not np.isfinite(promised):
                continue
            short = (promised - (trace.F[at - 1] - trace.F[at])) / trace.scale if trace.scale > 0.0 else 0.0
            if short > worst:
                worst, where = float(short), at
        if worst <= PROMISED:
            return Observation(part, Outcome.HELD, worst)
        missed = self._falls_short(problem, trace, where)
        detail = f"iteration {where}: F falls by {worst:.3g} of its scale less than the steps promise"
        return Observation(part, Outcome.FAILED if missed else Outcome.UNDECIDED, worst, detail)

    def _falls_short(self, problem: Problem, trace: PaperTrace, at: int) -> bool:
        """Whether the exact update from the iterate before `at` falls by less than its own steps promise."""
        before = trace.path_w[at - 1], trace.path_u[at - 1]
        after = self._stepped(problem, trace, *before)
        if after is None:
            return False
        old, new = objective(problem, *before), objective(problem, *after)
        start = rationals(before[0]), rationals(before[1])
        promised = promised_fall(_rational(problem), self.order, start, after)
        return bool(promised > (old.upper - new.lower) + EXACT * old.upper)

    def _own(self, part: str, problem: Problem, trace: PaperTrace) -> Observation:
        """T1c: the reading's own objective never rises; a rise is confirmed as for T1a."""
        largest, rises = _largest_rise(trace.own, trace.scale), trace.own_rises(ROUNDING)
        for at in rises:
            before = trace.path_w[at - 1], trace.path_u[at - 1]
            after = self._stepped(problem, trace, *before) if _squarable(problem) else None
            if after is None:
                continue
            old, new = own_objective(problem, trace, *before), own_objective(problem, trace, *after)
            if new > old * (1 + EXACT):
                detail = f"iteration {at}: {float(old):.17g} -> {float(new):.17g}"
                return Observation(part, Outcome.FAILED, largest, detail)
        if rises.size:
            return Observation(part, Outcome.UNDECIDED, largest, "every rise is rounding: none is exact")
        return Observation(part, Outcome.HELD)

    def _stepped(
        self, problem: Problem, trace: PaperTrace, w: Vector, u: FeatureVector
    ) -> tuple[Rationals, Rationals] | None:
        """The exact update of (w, u), to 70 digits where it is irrational; None where there is none."""
        try:
            new = self._next(problem, trace, w, u)
        except SingularStepError:
            return None
        return None if new is None else (_lower_ends(new[0]), _lower_ends(new[1]))

    def _singular(self, problem: Problem, trace: PaperTrace) -> bool:
        """Whether the system after the last iterate is singular exactly, and not to rounding alone."""
        try:
            self._next(problem, trace, trace.w, trace.u)
        except SingularStepError:
            return True
        return False

    def _next(
        self, problem: Problem, trace: PaperTrace, w: Vector, u: FeatureVector
    ) -> tuple[Enclosures, Enclosures] | None:
        """The exact update of (w, u); None where they are not finite or 4096 bits do not tell."""
        if not (np.isfinite(w).all() and np.isfinite(u).all()):
            return None
        try:
            return step(problem, self._update(trace), w, u)
        except UnresolvedError:
            return None

    def _update(self, trace: PaperTrace) -> Update:
        eps = trace.variant.eps if trace.variant.name == "smoothed" else None
        return Update(self.reading, self.order, Fraction(eps or 0.0))

    def _exactly(self, problem: Problem, trace: PaperTrace, at: int) -> Rise | None:
        """Iteration `at` once more, exactly, from the float64 iterate before it; None where there is none."""
        w, u = trace.path_w[at - 1], trace.path_u[at - 1]
        if not (np.isfinite(w).all() and np.isfinite(u).all()):
            return None
        try:
            return rise_confirmed(problem, self._update(trace), w, u)
        except UnresolvedError:
            return None


def promised_fall(
    terms: Terms, order: str, before: tuple[Rationals, Rationals], after: tuple[Rationals, Rationals]
) -> Any:
    """Sum of the weighted squares by which F must fall from (w, u) to what the corrected update makes of it.

    ||X'dw||^2 + lambda1 c + lambda2/2 sum dw_j^2/|w_j| + lambda3/2 sum ||du^i||^2/||u^i||, where c is
    ||dw||^2 + ||Xdu||^2 in Gauss-Seidel order and ||dw + Xdu||^2 in Jacobi order; w and u are those before.
    In float64 or over the rationals, whichever all numbers are.
    """
    (w, u), (dw, du) = before, (after[0] - before[0], after[1] - before[1])
    Xdu, Xtdw, lambdas = terms.X @ du, terms.X.T @ dw, terms.lambdas
    coupling = dw @ dw + Xdu @ Xdu if order == "gauss_seidel" else ((dw + Xdu) ** 2).sum()
    views = sum(step * step / abs(size) for step, size in zip(dw, w, strict=True) if size)
    norms = [(du[c] @ du[c], terms.norm(u[c])) for c in terms.modalities]
    groups = sum(square / norm for square, norm in norms if norm)
    return Xtdw @ Xtdw + lambdas[0] * coupling + (lambdas[1] * views + lambdas[2] * groups) / 2


def own_objective(problem: Problem, trace: PaperTrace, w: Entries, u: Entries) -> Fraction:
    """What the absolute or the smoothed update descends, to 1e-100 of itself.

    ||X'w - o||^2 + lambda1 ||Xu - w||^2 + f (lambda2 sum_j s(w_j) + lambda3 sum_i s(||u^i||)),
    s(t) = sqrt(t^2 + e^2), with f = 1/2, e = 0 for the absolute update and f = 1, e = eps for the smoothed.
    """
    smoothed = trace.variant.name == "smoothed"
    factor = Fraction(1) if smoothed else Fraction(1, 2)
    eps = Fraction(trace.variant.eps or 0.0) if smoothed else Fraction(0)
    smooth = Problem(problem.X, problem.o, lambda1=problem.lambda1, lambda2=0.0, lambda3=0.0)
    w_, u_ = rationals(w), rationals(u)
    views = sum((square_root(x * x + eps * eps).lower for x in w_), Fraction(0))
    blocks = [u_[columns] for columns in problem.modalities]
    norms = sum((square_root(squares(b) + eps * eps).lower for b in blocks), Fraction(0))
    penalty = Fraction(problem.lambda2) * views + Fraction(problem.lambda3) * norms
    return objective(smooth, w_, u_).lower + factor * penalty


def _lower_ends(values: Enclosures) -> Rationals:
    return rationals(x.lower for x in values)


def _floating(problem: Problem) -> Terms:
    return Terms(problem.X, problem.modalities, problem.lambdas, np.linalg.norm)


def _rational(problem: Problem) -> Terms:
    X = rationals(problem.X.ravel()).reshape(problem.X.shape)
    lambdas = tuple(map(Fraction, problem.lambdas))
    return Terms(X, problem.modalities, lambdas, lambda x: square_root(squares(x)).upper)


def _optimum(problem: Problem) -> Solution | None:
    try:
        solution = solve(problem)
    except SolverError:
        return None
    return None if solution.status is Status.NOT_CERTIFIED else solution


def _ends(trace: PaperTrace, optimum: Solution) -> str:
    return f"F {trace.F[-1]:.17g}, F* <= {optimum.certificate.upper:.17g}"


def distance_to_optimum(problem: Problem, trace: PaperTrace, proof: Certificate) -> tuple[float, bool]:
    """(F(last) - F*) / F* from above, and whether it counts as reached."""
    gap = float(trace.F[-1]) - proof.lower
    share = max(0.0, float(trace.F[-1]) - proof.upper) / proof.upper if proof.upper > 0.0 else 0.0
    return share, gap <= _counts_as_reached(problem, proof)


def _counts_as_reached(problem: Problem, proof: Certificate) -> float:
    return REACHED * proof.lower + REACHED_FLOOR * float(problem.o @ problem.o)


def _squarable(problem: Problem) -> bool:
    """Whether every number of the problem is 0 or of a size that the loop can square."""
    sizes = np.abs(np.concatenate([problem.X.ravel(), problem.o, np.array(problem.lambdas)]))
    sizes = sizes[sizes > 0.0]
    return bool(((sizes > SQUARABLE[0]) & (sizes < SQUARABLE[1])).all())


def _tells(problem: Problem, trace: PaperTrace, optimum: Solution) -> bool:
    """Whether a corrected update with steps as small as the last would be at the optimum.

    F is convex, so F(z) - F* <= (z - z*)'g with any subgradient g of F at z = (w, u), and the corrected
    update from z to z+ has g = 2 M (z - z+), M the matrix of its two systems. Where that is more than what
    counts as reached, the steps are small for another reason: slow convergence, or an entry or a block that
    is tiny and still grows. Step and matrix are taken by size, the step with its rounding.
    """
    if not _squarable(problem) or trace.iterations == 0:
        return False
    X, (l1, l2, l3) = np.abs(problem.X), problem.lambdas
    w, u = np.abs(trace.path_w[-2]), np.abs(trace.path_u[-2])
    dw, du = np.abs(np.diff(trace.path_w[-2:], axis=0)[0]), np.abs(np.diff(trace.path_u[-2:], axis=0)[0])
    dw, du = dw + ROUNDING * w, du + ROUNDING * u
    g_w = X @ (X.T @ dw) + l1 * dw + l2 / 2 * _shares(dw, w)
    g_u = l1 * X.T @ (X @ du + dw)
    for c in problem.modalities:
        g_u[c] += l3 / 2 * _shares(du[c], float(np.linalg.norm(u[c])))
    far_w, far_u = np.abs(trace.path_w[-2] - optimum.w), np.abs(trace.path_u[-2] - optimum.u)
    return bool(2 * (far_w @ g_w + far_u @ g_u) <= _counts_as_reached(problem, optimum.certificate))


def _shares(step: Vector, size: Vector | float) -> Vector:
    """The step by the size; 0 where the size is 0, which the update holds there."""
    sizes = np.broadcast_to(size, step.shape)
    shares: Vector = np.divide(step, sizes, out=np.zeros_like(step), where=sizes > 0.0)
    return shares


def _limit(problem: Problem, trace: PaperTrace, optimum: Solution | None) -> Observation:
    """T1c/limit: converged without an exact zero and with positive lambdas means optimal."""
    part = "T1c/limit"
    zeros = not all(problem.lambdas) or not trace.path_w.all()
    zeros = zeros or any((np.linalg.norm(u[c]) == 0.0) for u in trace.path_u for c in problem.modalities)
    if zeros:
        return Observation(part, Outcome.SKIPPED, detail="a lambda, an entry of w or a block of u is 0")
    if optimum is None or trace.stop is not Stop.CONVERGED:
        return Observation(part, Outcome.UNDECIDED, detail=trace.stop.value)
    share, reached = distance_to_optimum(problem, trace, optimum.certificate)
    if reached or _tells(problem, trace, optimum):
        return Observation.of(part, reached, share, _ends(trace, optimum))
    return Observation(part, Outcome.UNDECIDED, share, f"small steps far from F*: {_ends(trace, optimum)}")


def _largest_rise(values: np.ndarray, scale: float) -> float:
    """Largest rise as a share of the scale; 0 where nothing rises."""
    with np.errstate(all="ignore"):
        rises = np.diff(values) / scale
    return float(np.max(rises[np.isfinite(rises)], initial=0.0))


def _distance(problem: Problem, trace: PaperTrace, optimum: Solution | None) -> Observation:
    """T1c/smoothed_distance: a converged run is within eps (n lambda2 + m lambda3) of F*."""
    part = "T1c/smoothed_distance"
    if optimum is None or trace.stop is not Stop.CONVERGED:
        return Observation(part, Outcome.UNDECIDED, detail=trace.stop.value)
    proof = optimum.certificate
    allowed = (trace.variant.eps or 0.0) * (problem.n * problem.lambda2 + problem.m * problem.lambda3)
    allowed += _counts_as_reached(problem, proof)
    used = (float(trace.F[-1]) - proof.lower) / allowed if allowed > 0.0 else 0.0
    if used <= 1.0 or _tells(problem, trace, optimum):
        return Observation.of(part, used <= 1.0, max(0.0, used), f"{used:.3g} of the allowed distance")
    return Observation(part, Outcome.UNDECIDED, used, f"small steps far from F*: {_ends(trace, optimum)}")


def _parts(reading: str, order: str) -> tuple[str, ...]:
    own = {
        "absolute": ("T1c/absolute",),
        "smoothed": ("T1c/smoothed_descent", "T1c/smoothed_distance"),
        "corrected": (f"T1c/descent/{order}", "T1c/limit"),
    }
    return f"T1a/{reading}/{order}", f"T1b/{reading}/{order}", *own.get(reading, ())


CHECKS = tuple(
    Check(f"descent {reading} {order}", _parts(reading, order), Descent(reading, order), share=0.5)
    for reading in READINGS
    for order in ORDERS
)
