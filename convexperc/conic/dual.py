"""A lower bound of the optimal value of a cone program, from any x^ and z.

For every z in the dual cone K* (z free where s = 0, z >= 0, z_0 >= ||z_1..||), every x^ and every feasible x,
with r = P x^ + q + A'z and P - diag(D) positive semidefinite,

    1/2 x'Px + q'x >= -1/2 x^'P x^ - b'z + sum_j (r_j x_j + D_j (x_j - x^_j)^2 / 2).

Source: Boyd and Vandenberghe, Convex Optimization, sections 5.1 and 5.9. Each term of the sum is at least
r_j x^_j - r_j^2/(2 D_j) where D_j > 0, and at least its minimum over an interval that contains x_j. With the
intervals of the level set of any U (`convexperc.conic.boxes`) that gives a number l. A feasible x is in the
level set, or its objective is above U: the optimal value is at least min(U, l), whatever U is worth.

Where x_j has no interval and r_j is not 0, z is changed so that r_j = 0 exactly: the change solves a square
linear system, whose exact solution ball arithmetic encloses.
"""

from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
import scipy.linalg

from convexperc.conic.boxes import Box
from convexperc.conic.program import ConeProgram, Floats, NoBoundError, exact, inner, row, times
from convexperc.enclosure.balls import Number, Numbers, float_above

LARGEST_SYSTEM = 300
"""Variables without an interval for which z is changed: solving for so many in balls takes seconds."""
INTERIOR = 2.0**-40
"""Entries of z below this share of the largest are not lowered by the change."""


@dataclass(frozen=True, eq=False)
class Terms:
    """What a lower bound is made of.

    Attributes
    ----------
    program : ConeProgram
    below : float64 (n,)
        D.
    box : Box
    """

    program: ConeProgram
    below: Floats
    box: Box


def lower_bound(terms: Terms, x: Floats, z: Floats) -> Number:
    """Return a ball whose lower end no feasible x of the level set falls below.

    Parameters
    ----------
    terms : Terms
    x : float64 (n,)
        x^.
    z : float64 (m,)
        It need not be in the dual cone.

    Raises
    ------
    NoBoundError
        A variable has no interval, and z cannot be changed so that none is needed.
    """
    program = terms.program
    point, dual = exact(x), in_dual_cone(program, exact(z))
    Px = times(program.P, point)
    total, missing = _sum(terms, _residual(program, Px, dual), point)
    given, columns = dual, set[int]()
    while missing:
        if columns.issuperset(missing):
            raise NoBoundError(_needed(sorted(columns)))
        columns.update(missing)  # the change moves the r of others, which may need more of it
        wanted = sorted(columns)
        dual = _changed(terms, given, _residual(program, Px, given), wanted)
        r = _residual(program, Px, dual)
        for j in wanted:
            r[j] = flint.arb(0)  # exactly, by the system that the change solves
        total, missing = _sum(terms, r, point)
    return total - inner(point, Px) / 2 - inner(exact(program.b), dual) + program.offset


def _sum(terms: Terms, r: Numbers, x: Numbers) -> tuple[Number, list[int]]:
    """The sum of the least terms, and the variables that have none."""
    total, missing = flint.arb(0), []
    for j in range(terms.program.n):
        part = _least(terms, j, r[j], x[j])
        if part is None:
            missing.append(j)
        else:
            total += part
    return total, missing


def in_dual_cone(program: ConeProgram, z: Numbers) -> Numbers:
    """Move z into K*: what is negative becomes 0, and a head rises to what its tail needs."""
    found = list(z)
    for i in program.nonnegative_rows:
        if not found[i] >= 0:
            found[i] = flint.arb(0)
    for rows in program.second_order_rows:
        tail = sum((found[i] ** 2 for i in rows[1:]), flint.arb(0))
        if not (found[rows[0]] >= 0 and found[rows[0]] ** 2 >= tail):
            found[rows[0]] = flint.arb(float_above(tail.sqrt()))
    return found


def _residual(program: ConeProgram, Px: Numbers, z: Numbers) -> Numbers:
    """R = P x^ + q + A'z."""
    pulled = times(program.transposed, z)
    return [p + q + v for p, q, v in zip(Px, exact(program.q), pulled, strict=True)]


def _least(terms: Terms, j: int, r: Number, x: Number) -> Number | None:
    """The least of r x_j + D_j (x_j - x)^2 / 2, or None where no interval bounds it."""
    D, low, high = (float(v[j]) for v in (terms.below, terms.box.lower, terms.box.upper))
    if r.is_zero() and D >= 0.0:
        return flint.arb(0)
    curved = r * x - r * r / (2 * flint.arb(D)) if D > 0.0 else None
    if D < 0.0 and not (np.isfinite(low) and np.isfinite(high)):
        return None
    if (not np.isfinite(low) and not r <= 0) or (not np.isfinite(high) and not r >= 0):
        return curved
    linear = _minimum(*(r * end for end in (low, high) if np.isfinite(end)))
    if D < 0.0:
        far = abs(flint.arb(low) - x).max(abs(flint.arb(high) - x))
        return linear + flint.arb(D) / 2 * far**2
    return linear if curved is None or linear.lower() > curved.lower() else curved


def _minimum(*values: Number) -> Number:
    """A ball whose lower end is below every one of them."""
    found = values[0].lower()
    for value in values[1:]:
        found = found if found <= value.lower() else value.lower()
    return found


def _needed(columns: list[int]) -> str:
    return (
        f"{len(columns)} variables of the canonical problem have no interval on the level set, and no "
        "dual point that needs none was found"
    )


def _changed(terms: Terms, z: Numbers, r: Numbers, columns: list[int]) -> Numbers:
    """Return z with A'z lowered by exactly r in these columns, in the dual cone.

    Raises
    ------
    NoBoundError
        There is no such change of the rows that have room for it.
    """
    program = terms.program
    if len(columns) > LARGEST_SYSTEM or any(terms.below[j] < 0.0 for j in columns):
        raise NoBoundError(_needed(columns))
    rows = _rows_with_room(program, z, columns)
    system = flint.arb_mat([[float(v) for v in line] for line in program.A[rows][:, columns].toarray().T])
    right = flint.arb_mat(len(columns), 1, [-r[j] for j in columns])
    try:
        change = system.solve(right).entries()
    except ZeroDivisionError:
        raise NoBoundError(_needed(columns)) from None
    found = list(z)
    for i, step in zip(rows, change, strict=True):
        found[i] += step
    kept = in_dual_cone(program, found)
    moved = [i for i in range(len(z)) if kept[i] is not found[i]]
    wanted = set(columns)
    if any(j in wanted for i in moved for j, _ in row(program.A, i)):
        raise NoBoundError(_needed(columns))  # the change left the dual cone
    return kept


def _rows_with_room(program: ConeProgram, z: Numbers, columns: list[int]) -> list[int]:
    """As many independent rows as columns, with most room to change z."""
    values = np.array([abs(float(v.mid())) for v in z])
    room = values + 0.0
    room[: program.zeros] = 1.0 + values[: program.zeros]
    for cone in program.second_order_rows:
        room[cone[0]] = 0.0
        room[list(cone[1:])] = 1.0
    room[room <= INTERIOR * room.max(initial=0.0)] = 0.0
    usable = np.flatnonzero(room)
    if usable.size < len(columns):
        raise NoBoundError(_needed(columns))
    block: Any = program.A[usable][:, columns].toarray() * room[usable, None]
    _, _, order = scipy.linalg.qr(block.T, mode="economic", pivoting=True)
    return [int(i) for i in usable[order[: len(columns)]]]
