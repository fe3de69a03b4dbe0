"""Templates from the reduced data to proved answers in one call: put in order, solved, bounded."""

from typing import no_type_check

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.cases import Cases
from convexperc.certificate.reduced import bound_reduced
from convexperc.kernels.kernel import Kernel
from convexperc.solvers.newton.lapack import SHORT
from convexperc.solvers.newton.loop import solve_batch
from convexperc.solvers.newton.ridge import explain
from convexperc.solvers.newton.workspace import Grams, Templates


@no_type_check
def advance(  # noqa: PLR0913, PLR0917 - all that the kernel works on
    grams, templates, lambdas, order, ranked, rules, pruning, memory, rows, shared, tolerance, bounds
):
    """Solve the templates of `order` in turn, and bound their answers.

    With `ranked`, those of which ridge regression leaves least come first. The solver takes the lambdas of
    the templates, the bounds those given beside them. Returns for how many templates the search for a dual
    point did not end early, and the lowest F found; see `bound_reduced` and `solve_batch`.
    """
    if ranked:
        rank(grams.G, templates, order, pruning.units, memory, bounds.gap)
    lowest = solve_batch(grams, templates, order, rules, pruning, memory, rows)
    cases = Cases(templates.C, templates.targets, lambdas, rows.W, rows.T, rows.Q)
    most = (1.0 + pruning.margin) * lowest
    return bound_reduced(shared, cases, order, tolerance, pruning.units, most, memory.numbers, bounds), lowest


@no_type_check
def rank(G, templates, order, units, memory, spare):
    """Sort `order` by ||o_j||^2 - c_j'(G + lambda1 I)^-1 c_j in common units.

    Numbers are kept in `spare` (p,), which is infinite afterwards.
    """
    targets = templates.targets
    explain(G, templates.lambdas[order[0], 0], templates.C, memory, spare)
    for j in range(spare.size):
        spare[j] = (targets[j] - spare[j]) * units[j]
    step = 1
    while 3 * step < order.size:
        step = 3 * step + 1
    while step > 0:  # Shell's method; Knuth, The Art of Computer Programming, volume 3, section 5.2.1
        for k in range(step, order.size):
            chosen, place = order[k], k
            while place >= step and before(spare, chosen, order[place - step]):
                order[place] = order[place - step]
                place -= step
            order[place] = chosen
        step //= 3
    for j in range(spare.size):
        spare[j] = np.inf


@no_type_check
def before(values, i, j):
    """Whether i comes before j: by value, then by index."""
    return values[i] < values[j] or (values[i] == values[j] and i < j)


def _interpreted_seconds(
    grams: Grams, templates: Templates, lambdas: NDArray[np.float64], order: NDArray[np.int64], *rest: object
) -> float:
    """About what `advance` takes interpreted: some steps a template, each of O(m n^2) operations."""
    m, n = grams.K.shape[:2]
    return float(order.size * (1e-2 + 6e-7 * (m + 3) * n * n))


def _interpreted_seconds_of_ranking(
    G: NDArray[np.float64], templates: Templates, order: NDArray[np.int64], *rest: object
) -> float:
    """About what `rank` takes interpreted."""
    p, n = templates.C.shape
    return float(p * (5e-5 + 3e-7 * n * min(n, SHORT)) + 1e-7 * n * n)


ranking_kernel = Kernel(rank, _interpreted_seconds_of_ranking, compile_seconds=1.0)
"""`rank`, interpreted or compiled."""
advancing_kernel = Kernel(advance, _interpreted_seconds, compile_seconds=7.0)
"""`advance`, interpreted or compiled."""
