"""Exhaustive search for the smallest problem on which the loop fails: "smallest" as evidence, not opinion.

All problems in whole numbers, in order of n + d and then of the sum of the sizes of their numbers, are run in
float64 from the paper's start. The first failure that exact arithmetic confirms is the smallest, but for
failures too small for the screen.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from whole_numbers import Batch, batches, problems, shapes, whole_problem

from verification.exact.algorithm import Update
from verification.exact.loop import iterates
from verification.exact.problem import ExactProblem

SEEN = 1e-9
"""A rise below this share of F is not seen by the float64 screen."""

VIOLATED = 1e-6
"""A condition at a zero must be violated by this much to be seen by the float64 screen."""

ITERATIONS = 12
"""Iterations tried for a rise."""

SETTLED = 100
"""Iterations after which a run with an exact zero is taken to have settled."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Found:
    """The smallest failure, and what was searched.

    Attributes
    ----------
    problem : ExactProblem
    iteration : int
        F(iteration) > F(iteration - 1); 0 for a zero of the start.
    tried : int
        Problems that were run, this one included.
    """

    problem: ExactProblem
    iteration: int
    tried: int


def smallest_rise(update: Update, largest: int, most: int) -> Found | None:
    """Return the smallest rise of F from the paper's start with lambda1 >= 1, or None.

    Parameters
    ----------
    update : Update
    largest : int
        Largest n + d.
    most : int
        Largest sum of the sizes of all numbers.
    """
    return _first(
        largest, most, lambda batch: _rising(update, batch), lambda p: first_rise(update, p) or None
    )


def smallest_lock(update: Update, largest: int, most: int, part: str) -> Found | None:
    """Return the smallest problem whose start has an exact zero, in w or in u, that the optimum lacks.

    Parameters
    ----------
    update : Update
    largest, most : int
        As for `smallest_rise`.
    part : {"w", "u"}
        Where the zero is.
    """
    return _first(largest, most, lambda batch: _locked(update, batch, part), lambda p: 0)


def first_rise(update: Update, problem: ExactProblem) -> int:
    """Return the first iteration whose F is above the one before, exactly; 0 if there is none."""
    course = iterates(problem, update, None, ITERATIONS)
    rises = (i for i in range(1, len(course)) if course[i].F.lower > course[i - 1].F.upper)
    return next(rises, 0)


def _first(
    largest: int, most: int, screen: Callable[[Batch], Flags], judge: Callable[[ExactProblem], int | None]
) -> Found | None:
    tried = 0
    for size in range(2, largest + 1):
        for total in range(1, most + 1):
            for n, sizes in shapes(size):
                for rows in batches(problems(n, sizes, total)):
                    for row in np.flatnonzero(screen(Batch.of(n, sizes, rows))):
                        problem = whole_problem(n, sizes, rows[row])
                        iteration = judge(problem)
                        if iteration is not None:
                            return Found(problem, iteration, tried + int(row) + 1)
                    tried += len(rows)
    return None


def _rising(update: Update, batch: Batch) -> Flags:
    """Where F rises within `ITERATIONS`."""
    w, u = batch.start()
    F = batch.objective(w, u)
    hits = np.zeros(len(F), dtype=bool)
    for _ in range(ITERATIONS):
        w, u = batch.step(update, w, u)
        after = batch.objective(w, u)
        hits |= after > F * (1 + SEEN)
        F = after
    return hits


def _locked(update: Update, batch: Batch, part: str) -> Flags:
    """Where a zero of the start is wrong in the limit: |Xa - b|_j > lambda2 or ||X_i'b|| > lambda3."""
    l1, l2, l3 = batch.lambdas
    w, u = batch.start()
    zero_w, zero_u = (w == 0) & (l2 > 0)[:, None], (batch.norms(u) == 0) & (l3 > 0)[:, None]
    zero = zero_w if part == "w" else zero_u
    if not zero.any():
        return np.zeros(len(l1), dtype=bool)
    kept = zero.any(axis=1)
    few = Batch(batch.X[kept], batch.o[kept], batch.lambdas[:, kept], batch.groups)
    w, u = w[kept], u[kept]
    for _ in range(SETTLED):
        w, u = few.step(update, w, u)
    p, q = few.residuals(w, u)
    if part == "w":
        slope = np.abs(2 * np.einsum("bnd,bd->bn", few.X, p) - 2 * few.lambdas[0][:, None] * q)
        violated = slope > few.lambdas[1][:, None] + VIOLATED
    else:
        pull = 2 * few.lambdas[0][:, None] * np.einsum("bnd,bn->bd", few.X, q)
        violated = few.norms(pull) > few.lambdas[2][:, None] + VIOLATED
    result = np.zeros(len(l1), dtype=bool)
    result[np.flatnonzero(kept)] = (violated & zero[kept]).any(axis=1)
    return result
