"""Faults in what the loop is said to do: to fall, by how much, and to end at the optimum.

A rise counts only where the exact update confirms it, so what is to show there is planted in both.
"""

from typing import Any

import numpy as np

from convexperc.solvers.paper.trace import PaperTrace
from convexperc.solvers.paper.variants import CORRECTED, SMOOTHED, Size
from verification.checks import descent
from verification.exact.algorithm import Update
from verification.exact.balls import inner
from verification.faults.fault import Fault, replaced, together, wrapped
from verification.faults.loop import SIGNED, SQUARED, halved, sizes_of_u, sizes_of_w
from verification.ledger.claims import ORDERS, READINGS, order_in_words

THOUSAND = 1e3


def _signed_exactly(self: Update, w: Any) -> Any:
    """The signed w in every reading."""
    return list(w)


def _no_rises(self: PaperTrace, tolerance: float) -> Any:
    return np.zeros(0, dtype=int)


def _unseen(reading: str, order: str) -> Fault:
    """What the check of an update that does not descend F is there to find."""
    return Fault(
        f"no rise and every end the optimum: {reading} update, {order_in_words(order)} order",
        f"T1a/{reading}/{order}",
        together(
            replaced(PaperTrace, "rises", _no_rises),
            replaced(descent, "distance_to_optimum", lambda problem, trace, proof: (0.0, True)),
        ),
        also=(f"T1b/{reading}/{order}",),
    )


DESCENT = (
    Fault(
        "D^w without absolute value, exactly as well",
        "T1a/corrected/gauss_seidel",
        together(SIGNED, replaced(Update, "view_sizes", _signed_exactly)),
        also=("T1b/corrected/gauss_seidel", "T1c/descent/gauss_seidel", "T1c/limit"),
    ),
    Fault(
        "D^w without absolute value, exactly as well, in Jacobi order",
        "T1a/corrected/jacobi",
        together(SIGNED, replaced(Update, "view_sizes", _signed_exactly)),
        also=("T1b/corrected/jacobi", "T1c/descent/jacobi", "T1c/limit"),
    ),
    Fault(
        "half of lambda2 and lambda3 in the corrected update",
        "T1b/corrected/gauss_seidel",
        halved("solve_w", "solve_u"),
        also=("T1c/limit",),
    ),
    Fault(
        "half of lambda2 and lambda3 in the limit",
        "T1c/limit",
        halved("solve_w", "solve_u"),
        also=("T1b/corrected/gauss_seidel",),
    ),
    Fault(
        "the promised fall doubled",
        "T1c/descent/gauss_seidel",
        wrapped(descent, "promised_fall", lambda found, *a: 2.0 * found),
    ),
    Fault(
        "the promised fall doubled, in Jacobi order",
        "T1c/descent/jacobi",
        wrapped(descent, "promised_fall", lambda found, *a: 2.0 * found),
    ),
    Fault(
        "D^u with ||u^i||^2, exactly as well",
        "T1c/smoothed_descent",
        together(SQUARED, replaced(Update, "modality_size", lambda self, block: inner(block, block))),
        also=("T1a/smoothed/gauss_seidel", "T1c/smoothed_distance"),
        may=("T1b/smoothed/gauss_seidel",),
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
        may=("T1a/smoothed/gauss_seidel", "T1b/smoothed/gauss_seidel"),
    ),
    *(_unseen(reading, order) for reading in READINGS if reading != CORRECTED.name for order in ORDERS),
)
