"""Algorithm 1 of the paper, line by line; its faults are kept, and depend on the update variant.

It runs on the data as given, without rescaling. The reason for a stop concerns the loop only, never F*.
"""

from enum import StrEnum
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from convexperc.errors import InputError, PointError
from convexperc.problem.arrays import real_array
from convexperc.problem.problem import Problem
from convexperc.solvers.paper.systems import (
    LinearSolver,
    OnSingular,
    SingularSystemError,
    least_norm,
    solve_u,
    solve_w,
)
from convexperc.solvers.paper.trace import Log, PaperTrace, Point, Stop
from convexperc.solvers.paper.variants import (
    PRINTED,
    VARIANTS,
    Order,
    UpdateVariant,
)

Choice = TypeVar("Choice", bound=StrEnum)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def run(
    problem: Problem,
    *,
    variant: UpdateVariant | str = PRINTED,
    order: Order | str = Order.GAUSS_SEIDEL,
    linear_solver: LinearSolver | str = LinearSolver.DIRECT,
    tolerance: float = 1e-10,
    max_iterations: int = 5000,
    on_singular: OnSingular | str = OnSingular.STOP,
    start: tuple[ArrayLike, ArrayLike] | None = None,
    keep_iterates: bool = False,
) -> PaperTrace:
    """Run Algorithm 1 for one template, exactly as it is printed.

    Parameters
    ----------
    problem : Problem
        The data and the lambdas, used as they are.
    variant : UpdateVariant or its name
        Which D^w, D^u and factor the updates use: printed, absolute, corrected, appendix_half,
        appendix_full or smoothed.
    order : Order or its name
        Whether u is computed from w(i+1) or from w(i).
    linear_solver : LinearSolver or its name
        How u is solved for; the iterates are the same up to rounding.
    tolerance : float
        Relative tolerance of the convergence test, which the paper does not give. Ours holds when neither
        ||w(i+1) - w(i)|| nor ||u(i+1) - u(i)|| exceeds `tolerance` times the larger of the two norms, and no
        penalised size in D^w and D^u (|w_j|, ||u^j||) grew by more than `tolerance` times itself. The second
        condition keeps the loop running while a coordinate too small to affect the norm still leaves zero.
    max_iterations : int
        At least 0.
    on_singular : OnSingular or its name
        Stop at a singular system, or use its least-squares solution of least norm.
    start : pair (w, u) or None
        None is the paper's start: w = argmin ||X'w - o||, then u = argmin ||Xu - w||, each of least norm, in
        float64. An entry that is 0 in exact arithmetic may become 1e-17; pass the start to have it exact.
    keep_iterates : bool
        Whether the trace holds every (w, u).

    Returns
    -------
    PaperTrace

    Raises
    ------
    InputError
        An argument is invalid; `PointError` if the start does not fit the problem.

    Notes
    -----
    A coordinate that is exactly 0 makes 1/(2 |w_j|) infinite; the limit of the update keeps it at 0 in
    every later iteration.

    Paper: Algorithm 1, lines 2-10
    """
    log = Log(problem, _variant(variant).for_problem(problem), tolerance, max_iterations, keep_iterates)
    order = _choice(Order, order, "order")
    linear_solver = _choice(LinearSolver, linear_solver, "linear_solver")
    on_singular = _choice(OnSingular, on_singular, "on_singular")
    with np.errstate(over="ignore", invalid="ignore"):
        w, u = _paper_start(problem) if start is None else _given_start(problem, start)  # line 2
        log.add(w, u)
        while log.stop is None:  # line 3: repeat
            Dw = log.variant.view_diagonal(w)  # line 4
            Du = log.variant.modality_diagonal(u, problem.modalities)  # line 5
            try:
                w_next = solve_w(problem, log.variant, Dw, u, on_singular)  # line 6
                w_seen = w_next if order is Order.GAUSS_SEIDEL else w
                u_next = solve_u(problem, log.variant, Du, w_seen, linear_solver, on_singular)  # line 7
            except SingularSystemError:
                log.stop = Stop.SINGULAR
                break
            w, u = w_next, u_next  # line 8
            log.add(w, u)  # line 9: until convergence
        return log.trace(order, linear_solver)  # line 10: the value of F


def _paper_start(problem: Problem) -> Point:
    """Line 2: w solves Eq. (loss), then u minimises Eq. (modal_loss)."""
    w = least_norm(problem.X.T, problem.o)
    return w, least_norm(problem.X, w)


def _given_start(problem: Problem, start: tuple[ArrayLike, ArrayLike]) -> Point:
    if len(start) != 2:
        raise PointError("start", value=start, must="must be a pair (w, u)")
    w, u = (real_array(part, name, 1, error=PointError) for part, name in zip(start, ("w", "u"), strict=True))
    for part, name, size in ((w, "w", problem.n), (u, "u", problem.d)):
        if part.shape != (size,):
            raise PointError(f"start: {name}", value=part.shape, must=f"must have {size} entries")
    return w, u


def _variant(value: UpdateVariant | str) -> UpdateVariant:
    if isinstance(value, UpdateVariant):
        return value
    named = {variant.name: variant for variant in VARIANTS}
    if value not in named:
        must = f"must be an UpdateVariant or one of {', '.join(named)}"
        raise InputError("variant", value=value, must=must)
    return named[value]


def _choice(kind: type[Choice], value: str, name: str) -> Choice:
    try:
        return kind(value)
    except ValueError:
        raise InputError(name, value=value, must=f"must be one of {', '.join(kind)}") from None
