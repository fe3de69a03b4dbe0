"""Ridge regression on the views, of all templates at once: a cheap guess at which optimum is lowest."""

from typing import no_type_check

from convexperc.solvers.newton.lapack import (
    ARGUMENTS,
    NUMBER,
    arguments_in,
    cholesky,
    cholesky_solve,
    copy,
    inner,
)

REGULARISATION = 1e-9
"""Added to lambda1, as a share of the largest possible eigenvalue of G."""


@no_type_check
def explain(G, lambda1, C, memory, found):
    """Set found_j = c_j'(G + lambda1 I)^-1 c_j, the largest 2 c_j'w - w'(G + lambda1 I)w, to rounding.

    It is 0 where the matrix is not positive definite to rounding. The memory's content is lost.
    """
    n, numbers, arguments = C.shape[1], memory.numbers, arguments_in(memory.numbers, memory.at)
    x_from = ARGUMENTS + n * n
    R, x, c = numbers[ARGUMENTS:x_from].reshape((n, n)), numbers[x_from : x_from + n], numbers[x_from + n :]
    R_at, x_at, c_at = (
        memory.at + NUMBER * ARGUMENTS,
        memory.at + NUMBER * x_from,
        memory.at + NUMBER * (x_from + n),
    )
    for a in range(n):
        copy(G[a], R[a], n)
        R[a, a] += lambda1 + REGULARISATION * n
    definite = cholesky(R, R_at, n, arguments) == 0
    for j in range(C.shape[0]):
        found[j] = 0.0
        if not definite:
            continue
        copy(C[j], c, n)
        copy(c, x, n)
        cholesky_solve(R, R_at, n, x, x_at, arguments)
        found[j] = inner(c, x, c_at, x_at, n, arguments)
