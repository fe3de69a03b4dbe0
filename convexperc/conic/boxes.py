"""Intervals of the variables of a cone program on its level set: the feasible x with objective at most U.

Every linear inequality sum_j a_j x_j <= h bounds each of its variables by what the others can be at least;
the inequalities are the rows of the program and

    head + tail >= 0, head - tail >= 0   of each second-order cone,
    the sum of two rows s >= 0 that differ in signs alone, as t - v >= 0 and t + v >= 0, which gives t >= 0,
    sum_j (q_j x_j + D_j x_j^2 / 2) <= U - offset   with D from `convexperc.conic.curvature`.

All is computed in float64, and every bound is moved outwards by far more than rounding can have cost it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from convexperc.conic.program import ConeProgram, Floats

PAD = 1e-9
"""Of the sum of the magnitudes that a bound is made of: a million terms err by 1e-10 of it at most."""
TINY = 1e-290
"""Above what can underflow."""
MOST_TERMS = 10**6
"""For which PAD is enough."""
PASSES, SETTLED = 2000, 3
"""Most passes; and those without another finite bound after which the next is not tried."""


@dataclass(frozen=True, eq=False)
class Box:
    """Which intervals contain the variables at every point of the level set.

    Attributes
    ----------
    lower, upper : float64 (n,)
        Infinite where nothing is known.
    """

    lower: Floats
    upper: Floats


def level_box(program: ConeProgram, below: Floats, level: float) -> Box:
    """Return intervals that contain every feasible x whose objective is at most the level.

    Parameters
    ----------
    program : ConeProgram
    below : float64 (n,)
        D, a diagonal below P.
    level : float
        U.
    """
    rows, heights = _inequalities(program)
    entries = sp.coo_array(rows)
    lower, upper = np.full(program.n, -np.inf), np.full(program.n, np.inf)
    room = level - program.offset
    room += PAD * (abs(level) + abs(program.offset)) + TINY
    finite, still = -1, 0
    if max(program.n, entries.nnz) <= MOST_TERMS:
        with np.errstate(all="ignore"):  # infinite and undefined bounds are left out below
            for _ in range(PASSES):
                _rows_pass(entries, heights, lower, upper)
                _level_pass(program.q, below, room, lower, upper)
                now = int(np.isfinite(lower).sum() + np.isfinite(upper).sum())
                still = still + 1 if now == finite else 0
                finite = now
                if still == SETTLED or (now == 2 * program.n and still):
                    break
    return Box(lower, upper)


def _rows_pass(entries: Any, heights: Floats, lower: Floats, upper: Floats) -> None:
    """Narrow the intervals by each row once."""
    r, c, a = entries.row, entries.col, entries.data
    least = np.where(a > 0, a * lower[c], a * upper[c])
    finite = np.isfinite(least)
    least = np.where(finite, least, 0.0)
    size = heights.size
    total, magnitude = (np.bincount(r, v, size) for v in (least, np.abs(least)))
    unknown = np.bincount(r, ~finite, size)[r] - ~finite
    rest = heights[r] - (total[r] - least)
    rest += PAD * (magnitude[r] + np.abs(heights[r])) + TINY
    bound = rest / a
    known = (unknown == 0) & np.isfinite(bound)
    for part, target, narrow in ((a > 0, upper, np.minimum), (a < 0, lower, np.maximum)):
        use = known & part
        outwards = (np.abs(bound[use]) * PAD + TINY) * (1.0 if target is upper else -1.0)
        narrow.at(target, c[use], bound[use] + outwards)


def _level_pass(q: Floats, D: Floats, room: float, lower: Floats, upper: Floats) -> None:
    """Narrow the intervals by q'x + 1/2 sum D_j x_j^2 <= room."""
    linear = np.where(q > 0, q * lower, np.where(q < 0, q * upper, 0.0))
    ends = [q * end + D / 2 * end**2 for end in (lower, upper)]
    concave = np.where(np.isfinite(lower) & np.isfinite(upper), np.minimum(*ends), -np.inf)
    least = np.where(D > 0, -(q**2) / (2 * D), np.where(D < 0, concave, linear))
    magnitude = (
        np.abs(q) * np.maximum(_finite(lower), _finite(upper))
        + np.abs(D) * np.maximum(_finite(lower), _finite(upper)) ** 2
    )
    finite = np.isfinite(least)
    total, scale = least[finite].sum(), np.abs(least[finite]).sum() + magnitude[finite].sum()
    unknown = np.count_nonzero(~finite) - ~finite
    rest = room - (total - np.where(finite, least, 0.0)) + PAD * (scale + abs(room)) + TINY
    root = np.sqrt(np.maximum(q**2 + 2 * D * rest, 0.0)) * (1 + PAD) + TINY
    pad = PAD * (np.abs(q) + root) / np.abs(D) + TINY
    curved = (unknown == 0) & (D > 0) & np.isfinite(rest)
    _narrow(upper, curved, (root - q) / D + pad, np.minimum)
    _narrow(lower, curved, (-root - q) / D - pad, np.maximum)
    bound = rest / q
    straight = (unknown == 0) & (D == 0) & np.isfinite(rest)
    _narrow(upper, straight & (q > 0), bound + PAD * np.abs(bound) + TINY, np.minimum)
    _narrow(lower, straight & (q < 0), bound - PAD * np.abs(bound) - TINY, np.maximum)


def _narrow(target: Floats, where: Any, bound: Floats, narrow: Any) -> None:
    use = where & np.isfinite(bound)
    target[use] = narrow(target[use], bound[use])


def _finite(values: Floats) -> Floats:
    return np.where(np.isfinite(values), np.abs(values), 0.0)


def _inequalities(program: ConeProgram) -> tuple[Any, Floats]:
    """Rows a and heights h with a'x <= h at every feasible x, csr_array (k, n) and float64 (k,)."""
    A, b = program.A, program.b
    first, behind = np.arange(program.zeros), np.array(program.nonnegative_rows, dtype=int)
    parts = [(A[first], b[first]), (-A[first], -b[first]), (A[behind], b[behind])]
    pairs = _opposite_pairs(A, behind)
    parts.append(_sums(A[pairs[:, 0]], b[pairs[:, 0]], A[pairs[:, 1]], b[pairs[:, 1]]))
    cones = [rows for rows in program.second_order_rows if len(rows) > 0]
    heads = np.array([rows[0] for rows in cones for _ in rows[1:]], dtype=int)
    tails = np.array([i for rows in cones for i in rows[1:]], dtype=int)
    alone = np.array([rows[0] for rows in cones], dtype=int)
    parts.append((A[alone], b[alone]))
    parts += [_sums(A[heads], b[heads], A[tails] * sign, b[tails] * sign) for sign in (1.0, -1.0)]
    rows = sp.csr_array(sp.vstack([rows for rows, _ in parts], format="csr"))
    rows.eliminate_zeros()
    return rows, np.concatenate([heights for _, heights in parts])


def _sums(A: Any, b: Floats, C: Any, d: Floats) -> tuple[Any, Floats]:
    """The sums of two inequalities each, without those whose coefficients have no exact sum."""
    total = A + C
    other = total - A
    error = (A - (total - other)) + (C - other)  # Knuth's two-sum: what rounding has cost each entry
    error.eliminate_zeros()
    right = np.flatnonzero(np.diff(sp.csr_array(error).indptr) == 0)
    heights = np.nextafter(b + d, np.inf)
    return sp.csr_array(total)[right], heights[right]


def _opposite_pairs(A: Any, rows: Any) -> Any:
    """Pairs of rows with the same columns and magnitudes, int (k, 2)."""
    seen: dict[tuple[bytes, bytes], int] = {}
    pairs = []
    for i in rows:
        part = slice(A.indptr[i], A.indptr[i + 1])
        order = np.argsort(A.indices[part])
        key = A.indices[part][order].tobytes(), np.abs(A.data[part][order]).tobytes()
        if key in seen:
            pairs.append((seen[key], i))
        seen[key] = i
    return np.array(pairs, dtype=int).reshape(-1, 2)
