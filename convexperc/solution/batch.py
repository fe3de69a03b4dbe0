"""All templates of one set of views at once, for one choice of the lambdas or for many."""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.certificate.data_bounds import DataBounds, Intervals, Points
from convexperc.certificate.reduced import AnswerBounds
from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.enclosure.budget import SECONDS, Budget
from convexperc.errors import StartError
from convexperc.problem.penalties import Penalties
from convexperc.problem.reduced import ReducedData
from convexperc.problem.scaling import ZERO_LAMBDA2, ZERO_LAMBDA3
from convexperc.solution.answers import Answers, Stages, certified_gaps
from convexperc.solution.single import solved
from convexperc.solution.solution import Solution
from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.loop import Pruning
from convexperc.solvers.newton.method import Batch, Newton, Start, lassos

SOLVER_PART = 0.3
"""Part of the relative tolerance that the solver is asked for; the rest is left to rounding."""
LEAST_TOLERANCE = 1e-13
"""Relative gap below which the solver is not asked to go: float64 seldom shows a smaller one."""

Chosen = Int[np.ndarray, " chosen"]


@dataclass
class BatchSolver:
    """p templates under way: which are solved, and what is proved of each so far.

    Attributes
    ----------
    bounds : DataBounds
    penalties : Penalties
    tolerances : Tolerances
    normalised : float64 (p, 3)
        The lambdas in each template's own units.
    ready : bool (p,)
        Where the reduced data may be used; the others are for `fall_back`.
    reduced : Batch
        Normalised answers.
    proved : AnswerBounds
        Of these, normalised.
    warm : bool
        Whether `reduced` holds a start.
    budget : Budget
        For the ball arithmetic of all templates together.
    singles : dict of int to Solution
        Answers on the original data.
    solving, proving, falling_back : float
        Seconds.
    """

    bounds: DataBounds
    penalties: Penalties
    tolerances: Tolerances
    normalised: Float[np.ndarray, "p 3"]
    ready: Bool[np.ndarray, " p"]
    reduced: Batch
    proved: AnswerBounds
    warm: bool
    budget: Budget
    singles: dict[int, Solution] = field(default_factory=dict)
    solving: float = 0.0
    proving: float = 0.0
    falling_back: float = 0.0

    @classmethod
    def of(
        cls,
        bounds: DataBounds,
        penalties: Penalties,
        tolerances: Tolerances,
        start: Answers | None = None,
        budget: Budget | None = None,
    ) -> "BatchSolver":
        """Nothing is solved yet; `start` gives the first (w, t) of every template.

        Raises
        ------
        StartError
            `start` is of another size.
        """
        data = bounds.data
        (p, n), m = data.C.shape, data.m
        reduced = Batch(
            np.zeros((p, n)), np.zeros((p, m)), np.zeros((p, n)), np.zeros(p, dtype=np.int64),
            np.full((p, 2), np.nan),
        )  # fmt: skip
        lambdas = data.normalised(penalties)
        batch = cls(
            bounds, penalties, tolerances, lambdas, bounds.usable(penalties, lambdas), reduced,
            AnswerBounds.unknown(p, n, m), start is not None, Budget() if budget is None else budget,
        )  # fmt: skip
        if start is not None:
            batch._start_from(start)
        return batch

    @property
    def data(self) -> ReducedData:
        """The views and the templates."""
        return self.bounds.data

    def _start_from(self, start: Answers) -> None:
        if not isinstance(start, Answers):
            must = "must be earlier Answers"
            raise StartError(
                "start", value=type(start).__name__, must=must, remedy="Pass what solve_many returned."
            )
        sizes = self.reduced.W.shape, self.reduced.T.shape
        if (start.w.shape, start.modality_norms.shape) != sizes:
            must = f"must be answers of (p, n) = {sizes[0]} and (p, m) = {sizes[1]}"
            found = start.w.shape, start.modality_norms.shape
            raise StartError("start", value=found, must=must, remedy="Start anew.")
        x, k = self.data.x, self.data.exponents[:, None]
        with np.errstate(over="ignore", under="ignore", divide="ignore", invalid="ignore"):
            W = np.ldexp(start.w, x - k)
            T = 2.0 * np.ldexp(start.modality_norms, 2 * x - k) / self.normalised[:, 2:]
        self.reduced.W[:] = np.where(np.isfinite(W), W, 0.0)
        self.reduced.T[:] = np.where(np.isfinite(T), T, 0.0)

    def advance(self, chosen: Chosen, pruning: Pruning | None = None) -> None:
        """Solve the chosen templates from the reduced data, and prove what can be proved.

        With `pruning`, one that is seen to lie above its ceiling, or above an earlier one, is given up.
        """
        if chosen.size == 0:
            return
        began = time.perf_counter()
        found = self._lassos(chosen) if self.penalties.uncoupled else self._newton(chosen, pruning)
        self.solving += time.perf_counter() - began
        self.prove(chosen, found)

    def _newton(self, chosen: Chosen, pruning: Pruning | None) -> Batch:
        """Newton's answers to the chosen templates; lambdas beyond which nothing changes are cut."""
        data = self.data
        start = Start(self.reduced.W[chosen], self.reduced.T[chosen]) if self.warm else None
        solver = Newton(tolerance=max(SOLVER_PART * self.tolerances.relative, LEAST_TOLERANCE))
        lambdas = np.minimum(self.normalised[chosen], [np.inf, ZERO_LAMBDA2, ZERO_LAMBDA3 * data.n])
        return solver.batch(data.G, data.K, data.C[chosen], data.targets[chosen], lambdas, start, pruning)

    def _lassos(self, chosen: Chosen) -> Batch:
        """The answers where the coupling costs nothing."""
        distinct, lambdas = self.bounds.distinct, self.normalised[chosen]
        C = distinct.merged(self.data.C[chosen])
        W, Q = (distinct.spread(part) for part in lassos(distinct.shared.G, C, distinct.counts, lambdas))
        T = np.full((chosen.size, self.data.m), 1.0 if lambdas[:, 0].any() else 0.0)
        return Batch(W, T, Q, np.ones(chosen.size, dtype=np.int64), np.full((chosen.size, 2), np.nan))

    def prove(self, chosen: Chosen, found: Batch, *, thorough: bool = True) -> None:
        """Keep what is found for the chosen templates together with its bounds.

        Without `thorough`, the first dual point is tried alone.
        """
        began, tolerances = time.perf_counter(), self.tolerances if thorough else None
        proved = self.bounds.of_points(
            chosen, self.normalised[chosen], Points(found.W, found.T, found.Q), tolerances,
            uncoupled=self.penalties.uncoupled,
        )  # fmt: skip
        for mine, new in zip(self.proved, proved, strict=True):
            mine[chosen] = new
        for mine, new in zip(vars(self.reduced).values(), vars(found).values(), strict=True):
            mine[chosen] = new
        self._changed()
        self.proving += time.perf_counter() - began

    def finish(self) -> None:
        """Solve every template to the end."""
        self.advance(self.ready.nonzero()[0])
        self.fall_back((~self.certified).nonzero()[0])

    def fall_back(self, chosen: Chosen, solver: Solver | None = None, *, escalate: bool = True) -> None:
        """Solve the chosen templates one by one, on the original data; the Gram matrices are shared."""
        if chosen.size == 0:
            return
        began = time.perf_counter()
        shared = self.data.views.normalised  # held, so that all templates share it and its Gram matrices
        for j in chosen.tolist():
            problem = self.data.problem(j, self.penalties)
            self.singles[j] = solved(problem, solver, self.tolerances, self.budget, escalate=escalate)
        del shared
        self._changed()
        self.falling_back += time.perf_counter() - began

    @property
    def intervals(self) -> Intervals:
        """Bounds of every F* that are known so far, on the original data."""
        lower, upper, _ = self._values
        return lower, upper

    @cached_property
    def certified(self) -> Bool[np.ndarray, " p"]:
        """Which answers are certified so far."""
        lower, _, gap = self._values
        return certified_gaps(gap, lower, self.bounds, self.tolerances, self.singles)

    @cached_property
    def _values(self) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
        """lower, upper and gap on the original data; powers of two in the safe range are exact."""
        shift, proved = 2 * self.data.exponents, self.proved
        lower, upper, gap = (np.ldexp(x, shift) for x in (proved.lower, proved.upper, proved.gap))
        if not self.ready.all():
            lower[~self.ready], upper[~self.ready], gap[~self.ready] = 0.0, np.inf, np.inf
        upper = np.minimum(upper, self.bounds.squares[1])
        for j, solution in self.singles.items():
            proof = solution.certificate
            lower[j], upper[j], gap[j] = proof.lower, proof.upper, proof.gap
        return lower, upper, gap

    def _changed(self) -> None:
        """Forget what was known before."""
        self.__dict__.pop("_values", None)
        self.__dict__.pop("certified", None)

    def answers(self) -> Answers:
        """What is known, on the original data; nothing can be added afterwards."""
        for array in (*self.proved, *vars(self.reduced).values()):
            array.flags.writeable = False
        lower, upper, gap = self._values
        stages = Stages(self.data.seconds, self.solving, self.proving, self.falling_back)
        return Answers(
            self.bounds, self.penalties, self.tolerances, lower, upper, gap, self.reduced, self.proved,
            dict(self.singles), stages,
        )  # fmt: skip


def solve_many(
    X: Any,
    O: Any,  # noqa: E741 - the paper's symbol
    *,
    lambda1: Any,
    lambda2: Any,
    lambda3: Any,
    modalities: Any = None,
    start: Answers | None = None,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
    seconds: float = SECONDS,
) -> Answers:
    """Minimise F for every template of a library, and prove how well.

    Parameters
    ----------
    X : array_like (n, d)
        Row i is robot i's feature vector.
    O : TemplateLibrary, array_like (d, p), or mapping of str to array_like (d,)
        Column j is template j's reference features. An array is read block by block and not copied: it may
        be memory-mapped. A library is checked and measured once, for any number of calls.
    lambda1, lambda2, lambda3 : real number
    modalities : see `Modalities.of`; those of the library without
    start : Answers, optional
        Earlier answers to as many templates, robots and modalities: to earlier views, or for other lambdas.
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.Tolerances`.
    seconds : float
        For the ball arithmetic of all templates together; see `convexperc.enclosure.budget.Budget`.

    Returns
    -------
    Answers

    Raises
    ------
    ProblemError, ModalityError
        As `Problem` on X and each column of O.
    ToleranceError, BudgetError, StartError
        See `Tolerances` and `Budget`; `start` is of another size.
    """
    budget = Budget(seconds)
    bounds = DataBounds.of(ReducedData.of(X, O, modalities))
    penalties = Penalties(lambda1, lambda2, lambda3)
    tolerances = Tolerances(relative_tolerance, absolute_tolerance)
    batch = BatchSolver.of(bounds, penalties, tolerances, start, budget)
    batch.finish()
    return batch.answers()


def solve_path(
    X: Any,
    O: Any,  # noqa: E741 - the paper's symbol
    grid: Iterable[Penalties | tuple[Any, Any, Any]],
    *,
    modalities: Any = None,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
    seconds: float = SECONDS,
) -> Iterator[Answers]:
    """`solve_many` for each choice of the lambdas in a grid; the data are read once.

    Each answer starts the next, so an order in which neighbours follow each other is the fastest.

    Parameters
    ----------
    X, O, modalities, relative_tolerance, absolute_tolerance, seconds
        See `solve_many`; the budget is that of each step of the path.
    grid : iterable of Penalties or (lambda1, lambda2, lambda3)

    Yields
    ------
    Answers
        In the order of the grid.
    """
    bounds, last = DataBounds.of(ReducedData.of(X, O, modalities)), None
    tolerances = Tolerances(relative_tolerance, absolute_tolerance)
    for triple in grid:
        batch = BatchSolver.of(bounds, Penalties.of(triple), tolerances, last, Budget(seconds))
        batch.finish()
        last = batch.answers()
        yield last
