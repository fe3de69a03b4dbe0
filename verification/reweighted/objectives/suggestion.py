"""A point and a dual vector from Clarabel, of which nothing is believed."""

from collections.abc import Sequence
from typing import Any

import clarabel
import numpy as np
from flint import fmpq
from scipy import sparse

from verification.exact.balls import Numbers, exact
from verification.reweighted.objectives.conjugates import Growth
from verification.reweighted.objectives.system import Floats, System, floats_of

TOLERANCE = 1e-13
"""Asked of Clarabel; it need not reach it."""


def suggested(system: System) -> tuple[Numbers, Numbers | None]:
    """A point, and a dual vector or None, from Clarabel, whatever it says of them."""
    n, m = system.n, len(system.d)
    columns: list[Floats] = []
    squares: list[float] = [0.0] * n
    costs: list[float] = [0.0] * n
    bounds: list[tuple[list[int], Any]] = []

    def add(rows: Sequence[int], sign: float, square: float, cost: float) -> list[int]:
        first = n + len(columns)
        for i in rows:
            column = np.zeros(m)
            column[i] = -sign
            columns.append(column)
            squares.append(square)
            costs.append(cost)
        return list(range(first, n + len(columns)))

    for block, where in zip(system.blocks, system.slices, strict=True):
        rows = range(where.start, where.stop)
        if len(rows) == 1:
            for sign, growth in zip((1.0, -1.0), (block.growths[0], block.growths[-1]), strict=True):
                for square, cost in _kinds(growth):
                    bounds.append((add(rows, sign, square, cost), clarabel.NonnegativeConeT(1)))
            continue
        for square, cost in _kinds(block.growths[0]):
            inside = add(rows, 1.0, square, 0.0)
            if not square:
                length = add([0], 0.0, 0.0, cost)
                bounds.append((length + inside, clarabel.SecondOrderConeT(1 + len(rows))))
    size = n + len(columns)
    top = np.hstack([system.floats, np.array(columns).T]) if columns else system.floats
    entries = [k for places, _ in bounds for k in places]
    below = sparse.csc_matrix(
        (-np.ones(len(entries)), (range(len(entries)), entries)), shape=(len(entries), size)
    )
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    solver = clarabel.DefaultSolver(
        sparse.diags(2 * np.array(squares)).tocsc(),
        np.array(costs),
        sparse.vstack([sparse.csc_matrix(top), below]).tocsc(),
        np.concatenate([-floats_of(system.d), np.zeros(len(entries))]),
        [clarabel.ZeroConeT(m), *(cone for _, cone in bounds)],
        settings,
    )
    found = solver.solve()
    z, v = np.array(found.x)[:n], np.array(found.z)[:m]
    primal = [exact(x) for x in z] if np.isfinite(z).all() else [fmpq(0)] * n
    return primal, [exact(x) for x in v] if np.isfinite(v).all() else None


def _kinds(growth: Growth) -> list[tuple[float, float]]:
    """What a residual is divided into: a share with a square, and one with a slope."""
    squares = [] if growth.curve is None else [(float(growth.curve), 0.0)]
    return squares + ([] if growth.radius is None else [(0.0, float(growth.radius))])
