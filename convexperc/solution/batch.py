"""All templates of one set of views at once, for one choice of the lambdas or for many."""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.certificate.cases import AnswerBounds, Exclusion
from convexperc.certificate.data_bounds import DataBounds, Points
from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.enclosure.budget import SECONDS, Budget
from convexperc.errors import ProblemError, StartError, entries
from convexperc.problem.arrays import every, highest
from convexperc.problem.penalties import Penalties
from convexperc.problem.reduced import ReducedData
from convexperc.problem.scaling import ZERO_LAMBDA2, ZERO_LAMBDA3
from convexperc.solution.advancing import advancing_kernel, ranking_kernel
from convexperc.solution.answers import Answers, Stages, certified_gaps
from convexperc.solution.single import solved
from convexperc.solution.solution import Solution
from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.loop import NO_PRUNING, Pruning, Rules
from convexperc.solvers.newton.method import MAX_ITERATIONS, Batch, lassos
from convexperc.solvers.newton.workspace import Grams, Memory, Rows, Templates, new_memory

SOLVER_PART = 0.3
"""Part of the relative tolerance that the solver is asked for; the rest is left to rounding."""
LEAST_TOLERANCE = 1e-13
"""Relative gap below which the solver is not asked to go: float64 seldom shows a smaller one."""

Chosen = Int[np.ndarray, " chosen"]


class Known(NamedTuple):
    """What is known of p templates, on the original data.

    Attributes
    ----------
    lower, upper, gap : float64 (p,)
        Bounds of F*, and of F(w, u) - F*.
    certified : bool (p,)
    """

    lower: Float[np.ndarray, " p"]
    upper: Float[np.ndarray, " p"]
    gap: Float[np.ndarray, " p"]
    certified: Bool[np.ndarray, " p"]


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
    memory : Memory
        The solver's.
    budget : Budget
        For the ball arithmetic of all templates together.
    singles : dict of int to Solution
        Answers on the original data.
    solving, falling_back : float
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
    memory: Memory
    budget: Budget
    singles: dict[int, Solution] = field(default_factory=dict)
    _known: Known | None = None
    solving: float = 0.0
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
        lambdas = data.normalised(penalties)
        batch = cls(
            bounds, penalties, tolerances, lambdas, bounds.usable(penalties, lambdas), Batch.new(p, n, m),
            AnswerBounds.unknown(p, n, m), start is not None, new_memory(n, m),
            Budget() if budget is None else budget,
        )  # fmt: skip
        if start is not None:
            batch._start_from(start)
        return batch

    @property
    def data(self) -> ReducedData:
        """The views and the templates."""
        return self.bounds.data

    def _start_from(self, start: Answers) -> None:
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

    def rank(self, order: Chosen, pruning: Pruning) -> None:
        """Sort by what ridge regression on the views leaves of each template, in the units of `pruning`."""
        data = self.data
        templates = Templates(data.C, data.targets, self.normalised)
        ranking_kernel(data.G, templates, order, pruning.units, self.memory, self.proved.gap)

    def advance(self, chosen: Chosen, pruning: Pruning = NO_PRUNING, *, ranked: bool = False) -> None:
        """Solve the chosen templates from the reduced data, in this order, and prove what can be proved.

        With `pruning`, one that is seen to lie above its ceiling, or above an earlier one, is given up; with
        `ranked`, `chosen` is first sorted by what ridge regression on the views leaves of them.
        """
        if chosen.size == 0:
            return
        if not self.reduced.W.flags.writeable:
            raise ValueError("the answers were handed out, and are read-only")
        if ranked and not pruning.units.size:
            raise ValueError("templates are ranked in the units of a pruning; without one there are none")
        began = time.perf_counter()
        if self.penalties.uncoupled:
            self._lassos(chosen)
            self.prove(chosen)
        else:
            self._advance(chosen, pruning, ranked)
        self.solving += time.perf_counter() - began

    def _advance(self, chosen: Chosen, pruning: Pruning, ranked: bool) -> None:
        """Newton's answers; lambdas beyond which nothing changes are cut for it."""
        data, bounds, reduced, lambdas = self.data, self.bounds, self.reduced, self.normalised
        templates = Templates(data.C, data.targets, lambdas)
        if highest(lambdas) > ZERO_LAMBDA2:  # the smallest of the limits
            cut = np.minimum(lambdas, [np.inf, ZERO_LAMBDA2, ZERO_LAMBDA3 * data.n])
            templates = Templates(data.C, data.targets, cut)
        relative = self.tolerances.relative
        rules = Rules(max(SOLVER_PART * relative, LEAST_TOLERANCE), MAX_ITERATIONS, self.warm)
        missed, lowest = advancing_kernel(
            Grams.of(data.G, data.K), templates, lambdas, chosen, ranked, rules, pruning, self.memory,
            Rows(*vars(reduced).values()), bounds.shared, relative, self.proved,
        )  # fmt: skip
        exclusion = Exclusion(pruning.units, (1.0 + pruning.margin) * lowest)
        points = Points(reduced.W, reduced.T, reduced.Q)
        self.proved = bounds.settled(chosen, lambdas, points, self.proved, missed, self.tolerances, exclusion)
        self._known = None

    def _lassos(self, chosen: Chosen) -> None:
        """The answers where the coupling costs nothing."""
        distinct, lambdas, reduced = self.bounds.distinct, self.normalised[chosen], self.reduced
        C = distinct.merged(self.data.C[chosen])
        found = lassos(distinct.shared.G, C, distinct.counts, lambdas)
        reduced.W[chosen], reduced.Q[chosen] = (distinct.spread(part) for part in found)
        reduced.T[chosen] = 1.0 if lambdas[:, 0].any() else 0.0
        reduced.iterations[chosen] = 1

    def prove(self, chosen: Chosen, *, thorough: bool = True) -> None:
        """Bound the reduced answers to the chosen templates; without `thorough`, by the first dual point."""
        points = Points(self.reduced.W, self.reduced.T, self.reduced.Q)
        self.proved = self.bounds.of_points(
            chosen, self.normalised, points, self.proved, tolerances=self.tolerances if thorough else None,
            uncoupled=self.penalties.uncoupled,
        )  # fmt: skip
        self._known = None

    def finish(self) -> None:
        """Solve every template to the end."""
        self.advance(self.ready.nonzero()[0])
        self.fall_back((~self.known.certified).nonzero()[0])

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
        self._known = None
        self.falling_back += time.perf_counter() - began

    @property
    def known(self) -> Known:
        """What is known so far, on the original data."""
        if self._known is None:
            self._known = self._look()
        return self._known

    def _look(self) -> Known:
        """Scale what is proved: powers of two in the safe range are exact."""
        fourfold, proved, squares = self.data.library.lengths.fourfold, self.proved, self.bounds.squares
        lower, upper, gap = proved.lower * fourfold, proved.upper * fourfold, proved.gap * fourfold
        if not every(self.ready):
            lower[~self.ready], upper[~self.ready], gap[~self.ready] = 0.0, np.inf, np.inf
        upper = np.minimum(upper, squares[1])
        for j, solution in self.singles.items():
            proof = solution.certificate
            lower[j], upper[j], gap[j] = proof.lower, proof.upper, proof.gap
        return Known(
            lower, upper, gap, certified_gaps(gap, lower, self.bounds, self.tolerances, self.singles)
        )

    def answers(self) -> Answers:
        """What is known, on the original data; nothing can be added afterwards."""
        for array in (*self.proved, *vars(self.reduced).values()):
            array.setflags(write=False)
        lower, upper, gap, _ = self.known
        stages = Stages(self.data.seconds, self.solving, self.falling_back)
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
        With the same `TemplateLibrary`, rows of X that have not changed are not multiplied again.
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
    if start is not None and not isinstance(start, Answers):
        must = "must be earlier Answers"
        raise StartError(
            "start", value=type(start).__name__, must=must, remedy="Pass what solve_many returned."
        )
    earlier = None if start is None else start.data
    penalties = Penalties(lambda1, lambda2, lambda3)
    tolerances = Tolerances(relative_tolerance, absolute_tolerance)
    with np.errstate(all="ignore"):  # what overflows is bounded by infinity
        bounds = DataBounds.of(ReducedData.of(X, O, modalities, earlier=earlier))
        return _answers(bounds, penalties, tolerances, start, budget)


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
    tolerances, last = Tolerances(relative_tolerance, absolute_tolerance), None
    with np.errstate(all="ignore"):
        bounds = DataBounds.of(ReducedData.of(X, O, modalities))
    for triple in entries(grid, "grid", ProblemError):
        with np.errstate(all="ignore"):
            last = _answers(bounds, Penalties.of(triple), tolerances, last, Budget(seconds))
        yield last


def _answers(
    bounds: DataBounds, penalties: Penalties, tolerances: Tolerances, start: Answers | None, budget: Budget
) -> Answers:
    """Every template, solved to the end."""
    batch = BatchSolver.of(bounds, penalties, tolerances, start, budget)
    batch.finish()
    return batch.answers()
