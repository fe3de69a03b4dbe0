"""Faults in what the loop is said to do: to fall, by how much, and to end at the optimum.

A rise counts only where the exact update confirms it, so what is to show there is planted in both.
"""

from typing import Any

import numpy as np

from convexperc.solvers.paper.variants import SMOOTHED, Size
from verification.checks import descent
from verification.exact.algorithm import Update
from verification.exact.balls import inner
from verification.faults.fault import Fault, replaced, together, wrapped
from verification.faults.loop import SIGNED, SQUARED, halved, sizes_of_u, sizes_of_w

FEW = 20
"""Problems of hunts whose check runs the loop to its end."""
THOUSAND = 1e3


def _signed_exactly(self: Update, w: Any) -> Any:
    """The signed w in every reading."""
    return list(w)


DESCENT = (
    Fault(
        "D^w without absolute value, exactly as well",
        "T1a/corrected/gauss_seidel",
        together(SIGNED, replaced(Update, "view_sizes", _signed_exactly)),
        also=("T1b/corrected/gauss_seidel", "T1c/descent/gauss_seidel", "T1c/limit"),
        problems=FEW,
    ),
    Fault(
        "D^w without absolute value, exactly as well, in Jacobi order",
        "T1a/corrected/jacobi",
        together(SIGNED, replaced(Update, "view_sizes", _signed_exactly)),
        also=("T1b/corrected/jacobi", "T1c/descent/jacobi", "T1c/limit"),
        problems=FEW,
    ),
    Fault(
        "half of lambda2 and lambda3 in the corrected update",
        "T1b/corrected/gauss_seidel",
        halved("solve_w", "solve_u"),
        families=("one_view",),
        also=("T1c/limit",),
        problems=FEW,
    ),
    Fault(
        "half of lambda2 and lambda3 in the limit",
        "T1c/limit",
        halved("solve_w", "solve_u"),
        families=("one_view",),
        also=("T1b/corrected/gauss_seidel",),
        problems=FEW,
    ),
    Fault(
        "the promised fall doubled",
        "T1c/descent/gauss_seidel",
        wrapped(descent, "promised_fall", lambda found, *a: 2.0 * found),
        problems=FEW,
    ),
    Fault(
        "the promised fall doubled, in Jacobi order",
        "T1c/descent/jacobi",
        wrapped(descent, "promised_fall", lambda found, *a: 2.0 * found),
        problems=FEW,
    ),
    Fault(
        "D^u with ||u^i||^2, exactly as well",
        "T1c/smoothed_descent",
        together(SQUARED, replaced(Update, "modality_size", lambda self, block: inner(block, block))),
        also=("T1a/smoothed/gauss_seidel", "T1c/smoothed_distance"),
        problems=FEW,
    ),
    Fault(
        "eps a thousand times as large as said",
        "T1c/smoothed_distance",
        together(
            sizes_of_w(Size.SMOOTHED, lambda reading, w: np.hypot(w, THOUSAND * (reading.eps or 0.0))),
            sizes_of_u(
                lambda r, norms, true: (
                    np.hypot(norms, THOUSAND * (r.eps or 0.0)) if r.name == SMOOTHED.name else true
                )
            ),
        ),
        problems=FEW,
    ),
)
