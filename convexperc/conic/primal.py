"""An upper bound of the optimal value of a cone program: its objective at a point that is proved feasible.

The point starts at any x and is made feasible step by step:

1. A variable is moved into the interval that the rows s >= 0 with no other variable give it.
2. As many variables as there are rows s = 0 follow from the others by the linear system, whose exact solution
   ball arithmetic encloses; the point meant is the one with this solution.
3. A variable that satisfies all its other cones by being large enough, or small enough, is set to what they
   need: a bound of a norm, a residual or an absolute value. Where it is a cost, it is set to no more.

At the end `Repair.violation` checks every cone in ball arithmetic, however the point came about.
"""

from dataclasses import dataclass, field

import flint
import numpy as np
import scipy.linalg

from convexperc.conic.program import ConeProgram, Floats, NoBoundError, exact, inner, row
from convexperc.enclosure.balls import Number, Numbers, float_above, float_below

LARGEST_SYSTEM = 300
"""Rows s = 0 that have to be solved together."""

Cone = range
"""The rows of a cone: one row s >= 0, or those of a second-order cone."""


@dataclass(frozen=True, eq=False)
class Repair:
    """How points of a program are made feasible; it depends on the program alone.

    Attributes
    ----------
    program : ConeProgram
    lower, upper : float64 (n,)
        The intervals of step 1.
    rests : list of (int, int, list of Cone)
        The variables of step 3 in the order in which they are set; 1 where they rise, -1 where they fall; and
        the cones that they see to.
    hard : list of int
        Rows that no variable of step 3 sees to: heads of cones and rows s >= 0.
    """

    program: ConeProgram
    lower: Floats
    upper: Floats
    rests: list[tuple[int, int, list[Cone]]]
    hard: list[int] = field(default_factory=list)

    @classmethod
    def of(cls, program: ConeProgram) -> "Repair":
        """Find the intervals, and the order of the variables that rise or fall."""
        lower, upper, single = _intervals(program)
        cones = [range(i, i + 1) for i in program.nonnegative_rows if i not in single]
        cones += [rows for rows in program.second_order_rows if len(rows) > 0]
        rests = _order(program, cones)
        seen_to = {cone[0] for _, _, owned in rests for cone in owned}
        hard = sorted(single) + [cone[0] for cone in cones if cone[0] not in seen_to]
        return cls(program, lower, upper, rests, hard)

    def near(self, x: Floats) -> Numbers:
        """Return the point that steps 1 to 3 make of x, as balls around its exact coordinates.

        Raises
        ------
        NoBoundError
            The rows s = 0 cannot be solved.
        """
        found = exact(np.clip(x, self.lower, self.upper))
        _solve_equalities(self, x, found)
        for j, direction, cones in self.rests:
            self._set(found, j, direction, cones)
        return found

    def _set(self, found: Numbers, j: int, direction: int, cones: list[Cone]) -> None:
        """Set one variable to what its cones need, or further if that costs nothing."""
        given, found[j] = found[j], flint.arb(0)
        needs = [_need(self.program, cone, j, found) for cone in cones]
        needs.append(flint.arb(float((self.lower if direction > 0 else self.upper)[j])) * direction)
        if not self._is_cost(j, direction):
            needs.append(given * direction)
        top = max(float_above(need) for need in needs)
        found[j] = flint.arb(direction * top) if np.isfinite(top) else given

    def _is_cost(self, j: int, direction: int) -> bool:
        coupled = self.program.P.indptr[j + 1] > self.program.P.indptr[j]
        return not coupled and float(self.program.q[j]) * direction > 0.0

    def violation(self, found: Numbers) -> float:
        """Return 0 where every cone is proved to hold, else by how much one may be violated at most."""
        s, worst = self.program.slack(found), 0.0
        for i in range(self.program.zeros):
            if not s[i].contains(0):
                raise NoBoundError("a row s = 0 does not hold at the point that was to satisfy it")
        for i in self.program.nonnegative_rows:
            if not s[i] >= 0:
                worst = max(worst, float_above(-s[i]), 2.0**-1074)
        for rows in self.program.second_order_rows:
            tail = inner([s[i] for i in rows[1:]], [s[i] for i in rows[1:]])
            if len(rows) > 0 and not (s[rows[0]] >= 0 and s[rows[0]] ** 2 >= tail):
                worst = max(worst, float_above(tail.sqrt() - s[rows[0]]), 2.0**-1074)
        return worst

    def tightened(self, margin: float) -> Floats:
        """Return b with less room in the rows that no variable sees to."""
        program = self.program
        found = program.b.copy()
        for i in self.hard:
            largest = max((abs(value) for _, value in row(program.A, i)), default=0.0)
            found[i] -= margin * max(1.0, abs(float(found[i])), largest)
        return found


def upper_bound(program: ConeProgram, point: Numbers) -> float:
    """Return a float that the objective at a feasible point is not above."""
    return float_above(program.objective(point))


def _intervals(program: ConeProgram) -> tuple[Floats, Floats, set[int]]:
    """What the rows s >= 0 with one variable say of it, rounded inwards, and which rows these are."""
    lower, upper = np.full(program.n, -np.inf), np.full(program.n, np.inf)
    single = set()
    for i in program.nonnegative_rows:
        entries = row(program.A, i)
        if len(entries) != 1:
            continue
        ((j, value),) = entries
        single.add(i)
        end = flint.arb(float(program.b[i])) / value
        if value > 0:
            upper[j] = min(upper[j], float_below(end))
        else:
            lower[j] = max(lower[j], float_above(end))
    if (lower > upper).any():
        raise NoBoundError("the bounds of a variable contradict each other")
    return lower, upper, single


def _order(program: ConeProgram, cones: list[Cone]) -> list[tuple[int, int, list[Cone]]]:
    """Which variables see to which cones, in the order in which they are set.

    Found from the end: a variable that helps in all cones left sees to them, and is set after all others.
    """
    members = [_directions(program, cone) for cone in cones]
    effect: list[dict[int, int]] = [{} for _ in range(program.n)]
    for k, directions in enumerate(members):
        for j, direction in directions.items():
            effect[j][k] = direction
    used = {j for i in range(program.zeros) for j, _ in row(program.A, i)}
    costs = [j for j in range(program.n) if program.q[j] != 0.0]
    waiting = [*(j for j in range(program.n) if program.q[j] == 0.0), *costs]
    found = []
    while waiting:
        j = waiting.pop()
        ways = set(effect[j].values())
        if len(ways) != 1 or 0 in ways or j in used:
            continue
        owned = sorted(effect[j])
        found.append((j, ways.pop(), [cones[k] for k in owned]))
        for k in owned:
            for i in members[k]:
                del effect[i][k]
                if i != j:
                    waiting.append(i)
            members[k] = {}
    return found[::-1]


def _directions(program: ConeProgram, cone: Cone) -> dict[int, int]:
    """1 or -1 for each variable of a cone that can satisfy it by rising or falling, else 0."""
    heads = dict(row(program.A, cone[0]))
    tails: dict[int, list[float]] = {}
    for i in cone[1:]:
        for j, value in row(program.A, i):
            tails.setdefault(j, []).append(value)
    found = {}
    for j in heads.keys() | tails.keys():
        head, tail = heads.get(j, 0.0), tails.get(j, [])
        able = head != 0.0 and (not tail or (len(tail) == 1 and abs(tail[0]) == abs(head)))
        found[j] = int(-np.sign(head)) if able else 0
    return found


def _need(program: ConeProgram, cone: Cone, j: int, x: Numbers) -> Number:
    """The least value of direction * x_j at which a cone holds, the other variables being as they are.

    With y = direction * x_j, a = |A_head,j| and s at x_j = 0: s_head + a y >= ||tail||. Or, if x_j is in one
    row k of the tail as well, with c = s_head - e s_k, which does not depend on x_j,
    (s_head + e s_k + 2 a y) c >= ||other tail||^2. e is 1 where the two coefficients are equal, else -1. x_j
    must be 0 in x.
    """
    s = [_row_slack(program, i, x) for i in cone]
    coefficients = [dict(row(program.A, i)).get(j, 0.0) for i in cone]
    a = flint.arb(abs(coefficients[0]))
    shared = next((k for k in range(1, len(cone)) if coefficients[k] != 0.0), None)
    others = [value for k, value in enumerate(s) if k not in (0, shared)]
    square = inner(others, others)
    if shared is None:
        return (square.sqrt() - s[0]) / a
    same = 1 if coefficients[shared] == coefficients[0] else -1
    constant = s[0] - same * s[shared]
    quotient = flint.arb(0) if square.is_zero() else square / constant
    return (quotient - s[0] - same * s[shared]) / (2 * a)


def _row_slack(program: ConeProgram, i: int, x: Numbers) -> Number:
    total = flint.arb(float(program.b[i]))
    for j, value in row(program.A, i):
        total -= x[j] * value
    return total


def _solve_equalities(repair: Repair, x: Floats, found: Numbers) -> None:
    """Let variables follow from the others so that all rows s = 0 hold.

    Rows with a variable that no other row left has are put aside; what remains is solved as one system.
    """
    program = repair.program
    room = _room(repair, x)
    entries = [row(program.A, i) for i in range(program.zeros)]
    count = np.zeros(program.n, dtype=int)
    for line in entries:
        for j, _ in line:
            count[j] += 1
    left, order = set(range(program.zeros)), []
    changed = True
    while changed:
        changed = False
        for i in sorted(left):
            own = [j for j, _ in entries[i] if count[j] == 1]
            if own:
                order.append((i, max(own, key=lambda j: room[j])))
                left.discard(i)
                changed = True
                for j, _ in entries[i]:
                    count[j] -= 1
    if left:
        _solve_together(program, sorted(left), room, found)
    for i, j in reversed(order):
        found[j] = flint.arb(0)
        found[j] = _row_slack(program, i, found) / dict(entries[i])[j]


def _room(repair: Repair, x: Floats) -> Floats:
    """How far each variable may be moved; most where no cone has it."""
    program = repair.program
    inside = np.minimum(x - repair.lower, repair.upper - x)
    found = np.where(np.isfinite(inside), np.maximum(inside, 0.0), 1.0 + np.abs(x))
    behind = program.A[program.zeros :]
    free = np.asarray(abs(behind).sum(axis=0)).ravel() == 0.0
    found[free] = 1e6 * (1.0 + np.abs(x[free]))
    return np.asarray(found, dtype=np.float64)


def _solve_together(program: ConeProgram, rows: list[int], room: Floats, found: Numbers) -> None:
    """Solve some rows s = 0 for as many variables, with most room."""
    if len(rows) > LARGEST_SYSTEM:
        raise NoBoundError(f"{len(rows)} equations are coupled, more than {LARGEST_SYSTEM}")
    dense = program.A[rows].toarray()
    pivots = scipy.linalg.qr(dense * room, mode="r", pivoting=True)[1][: len(rows)]
    for j in pivots:
        found[j] = flint.arb(0)
    right = [_row_slack(program, i, found) for i in rows]
    system = flint.arb_mat([[float(v) for v in line] for line in dense[:, pivots]])
    try:
        solved = system.solve(flint.arb_mat(len(rows), 1, right)).entries()
    except (ZeroDivisionError, ValueError):
        raise NoBoundError("the equations are not proved to have a solution") from None
    for j, value in zip(pivots, solved, strict=True):
        found[j] = value
