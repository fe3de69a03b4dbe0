"""The optimum of a small lasso-family problem between two exact numbers, and what a certificate gets wrong.

A descent in float64 suggests which columns are used; Newton's method in long arithmetic solves the conditions
of these; from there everything is exact, or a ball: the value of that point from above, and from below the
value of the dual point k (y - X b - b0), made orthogonal over the rationals to 1 and to the columns that
nothing penalises, and scaled into the feasible set. Whatever the suggestion was, both bounds hold.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, fmpq, fmpq_mat

from convexperc.lasso import LassoCertificate
from verification.exact.balls import exact, precision
from verification.lassos.descent import descend
from verification.lassos.objective import Exact
from verification.lassos.problems import Drawn

BITS = 320
"""Of every ball."""
SWEEPS = 2000
"""Of the descent: more than a well-conditioned problem of this size needs."""
STEPS = 12
"""Newton steps; they double the digits of the descent."""
TIGHT = Fraction(1, 10**25)
"""Relative width of the optimum below which the referee tells zeros as well."""
STRICT = Fraction(1, 10**15)
"""A proved zero needs a dual value below the limit; within this share of it the proof is contradicted."""


@dataclass(frozen=True, eq=False)
class Problem:
    """An `Exact` in FLINT's numbers; each column without a group is one by itself, with c = 0."""

    X: list[list[Any]]
    y: list[Any]
    k: list[Any]
    l1: list[Any]
    ridge: list[Any]
    groups: list[tuple[list[int], Any]]
    intercept: bool
    positive: bool

    @classmethod
    def of(cls, given: Exact) -> "Problem":
        """Convert."""
        X = [[exact(x) for x in row] for row in given.X]
        y, k, l1, ridge = (list(map(exact, each)) for each in (given.y, given.k, given.l1, given.ridge))
        groups = [(members, exact(c)) for members, c in given.groups]
        groups = groups or [([j], fmpq(0)) for j in range(len(l1))]
        return cls(X, y, k, l1, ridge, groups, given.intercept, given.positive)

    @property
    def p(self) -> int:
        """Columns."""
        return len(self.l1)

    def free(self, j: int, c: Any) -> bool:
        """Whether nothing penalises a column of a group with this c."""
        return bool(self.l1[j] == 0 and self.ridge[j] == 0 and c == 0)

    def pulled(self, b: list[Any], b0: Any) -> list[Any]:
        """Return k (y - X b - b0)."""
        fits = (sum((x * c for x, c in zip(row, b, strict=True) if c), b0) for row in self.X)
        return [k * (y - fit) for k, y, fit in zip(self.k, self.y, fits, strict=True)]

    def pulls(self, t: list[Any]) -> list[Any]:
        """X't."""
        return [
            sum((row[j] * each for row, each in zip(self.X, t, strict=True)), fmpq(0)) for j in range(self.p)
        ]

    def value(self, b: list[Any], b0: Any) -> Any:
        """P(b, b0) as a ball, without the condition b >= 0."""
        t = self.pulled(b, b0)
        total = sum((each * each / k for each, k in zip(t, self.k, strict=True) if k), fmpq(0)) / 2
        total += sum((c * abs(x) for c, x in zip(self.l1, b, strict=True)), fmpq(0))
        total += sum((c * x * x for c, x in zip(self.ridge, b, strict=True)), fmpq(0)) / 2
        return arb(total) + sum((arb(c) * norm(b[j] for j in group) for group, c in self.groups if c), arb(0))


def half_squares(problem: Problem) -> Any:
    """Half the sum of k_i y_i^2."""
    return sum((k * y * y for k, y in zip(problem.k, problem.y, strict=True)), fmpq(0)) / 2


def norm(values: Iterable[Any]) -> Any:
    """The length of a vector as a ball; exactly 0 for zeros."""
    return arb(sum((x * x for x in values), fmpq(0))).sqrt()


def ends(ball: Any) -> tuple[Any, Any]:
    """The rational ends of a ball."""
    return rational(ball.lower()), rational(ball.upper())


def rational(number: Any) -> Any:
    """The midpoint of a ball, exactly."""
    mantissa, power = number.mid().man_exp()
    return fmpq(mantissa) * fmpq(2) ** int(power)


@dataclass(frozen=True, eq=False)
class Optimum:
    """lower <= P* <= upper, and the dual point behind the lower bound.

    Attributes
    ----------
    lower, upper : fmpq
    v : fmpq (p,)
        X't there.
    target : fmpq
        Half the sum of k_i y_i^2, the value of b = 0, b0 = 0.
    """

    lower: Any
    upper: Any
    v: list[Any]
    target: Any

    @property
    def tight(self) -> bool:
        """Whether the two are as close as `TIGHT`, or, where P* may be 0, as its square beside the target."""
        width, share = self.upper - self.lower, exact(TIGHT)
        return bool(width <= share * self.upper or width <= share * share * self.target)


def optimum(given: Exact) -> Optimum:
    """Enclose P*.

    Returns
    -------
    Optimum
        The bounds hold whatever happened on the way; `tight` says how close they are.
    """
    problem = Problem.of(given)
    target = half_squares(problem)
    b, b0 = descend(given, SWEEPS)
    start = [exact(float(x)) for x in b], exact(b0)
    with precision(BITS):
        points = [start, ([fmpq(0)] * problem.p, fmpq(0))]
        polished = _polished(problem, *start)
        if polished is not None and not (problem.positive and any(x < 0 for x in polished[0])):
            points.insert(0, polished)
        best: Optimum | None = None
        for point in points:
            upper = ends(problem.value(*point))[1]
            lower, v = _dual(problem, *point)
            if best is None:
                best = Optimum(lower, upper, v, target)
            better = lower > best.lower
            best = Optimum(max(best.lower, lower), min(best.upper, upper), v if better else best.v, target)
            if best.tight:
                break
    assert best is not None
    return best


def _polished(problem: Problem, b: list[Any], b0: Any) -> tuple[list[Any], Any] | None:
    """Solve the conditions of the columns that are used; None where they are singular or Newton fails."""
    signs = [(x > 0) - (x < 0) for x in b]
    for _ in range(2 * problem.p + 1):
        used = _independent(problem, [j for j in range(problem.p) if signs[j]])
        signs = [sign if j in used else 0 for j, sign in enumerate(signs)]
        start = [x if signs[j] else fmpq(0) for j, x in enumerate(b)]
        found = _newton(problem, start, b0, used, signs)
        if found is None:
            return None
        wrong = [j for j in used if not _free(problem, j) and found[0][j] * signs[j] <= 0]
        if wrong:
            signs = [0 if j in wrong else sign for j, sign in enumerate(signs)]
            continue
        added = _missing(problem, *found, signs)
        if added is None:
            return found
        signs[added[0]] = added[1]
        b, b0 = found
        b = [each if each or j != added[0] else fmpq(added[1], 10**9) for j, each in enumerate(b)]
    return None


def _free(problem: Problem, j: int) -> bool:
    return any(j in group and problem.free(j, c) for group, c in problem.groups)


def _missing(problem: Problem, b: list[Any], b0: Any, signs: list[int]) -> tuple[int, int] | None:
    """An unused column by itself whose dual value is beyond its limit, and its sign."""
    v = problem.pulls(problem.pulled(b, b0))
    margin = 1 + exact(TIGHT)
    for group, c in problem.groups:
        j = group[0]
        if len(group) == 1 and not signs[j]:
            beyond = v[j] if problem.positive else abs(v[j])
            if beyond > (problem.l1[j] + c) * margin and beyond > 0 and not problem.free(j, c):
                return j, 1 if v[j] > 0 else -1
    return None


def _independent(problem: Problem, used: list[int]) -> list[int]:
    """Columns of which none depends on the others and on 1; ridge penalties and norms leave all of them."""
    kept: list[int] = []
    rows = [[fmpq(int(k != 0)) for k in problem.k]] if problem.intercept else []
    curved = {j for group, c in problem.groups for j in group if (c and len(group) > 1) or problem.ridge[j]}
    for j in used:
        more = [*rows, [row[j] if k else fmpq(0) for row, k in zip(problem.X, problem.k, strict=True)]]
        if j in curved:
            kept.append(j)
        elif fmpq_mat(more).rank() == len(more):
            kept.append(j)
            rows = more
    return kept


def _newton(
    problem: Problem, b: list[Any], b0: Any, used: list[int], signs: list[int]
) -> tuple[list[Any], Any] | None:
    """Newton's method for the conditions at these columns and at the intercept."""
    b, size = list(b), len(used) + problem.intercept
    if not size:
        return b, fmpq(0)
    columns = [[row[j] for row in problem.X] for j in used]
    columns += [[fmpq(1)] * len(problem.y)] if problem.intercept else []
    gram = [[_inner(problem.k, one, other) for other in columns] for one in columns]
    for _ in range(STEPS):
        t = problem.pulled(b, b0)
        slopes = [
            arb(-sum((x * each for x, each in zip(column, t, strict=True)), fmpq(0))) for column in columns
        ]
        curves = [[arb(x) for x in row] for row in gram]
        _add_penalties(problem, b, used, signs, slopes, curves)
        try:
            step = arb_mat(curves).solve(arb_mat(size, 1, slopes)).entries()
        except ZeroDivisionError:
            return None
        if not all(each.is_finite() for each in step):
            return None
        moved = [rational(each) for each in step]
        for j, each in zip(used, moved, strict=False):
            b[j] = rational(arb(b[j] - each))
        if problem.intercept:
            b0 = rational(arb(b0 - moved[-1]))
        largest = max([abs(x) for x in b] + [abs(b0)])
        if max(map(abs, moved)) <= largest / fmpq(2) ** (BITS // 2):
            return b, b0
    return None


def _inner(k: list[Any], one: list[Any], other: list[Any]) -> Any:
    """The sum of k_i x_i z_i."""
    return sum((weight * x * z for weight, x, z in zip(k, one, other, strict=True)), fmpq(0))


def _add_penalties(
    problem: Problem,
    b: list[Any],
    used: list[int],
    signs: list[int],
    slopes: list[Any],
    curves: list[list[Any]],
) -> None:
    """Add the first and second derivatives of the penalties, where they are smooth."""
    place = {j: i for i, j in enumerate(used)}
    for j, i in place.items():
        slopes[i] += arb(problem.l1[j] * signs[j] + problem.ridge[j] * b[j])
        curves[i][i] += arb(problem.ridge[j])
    for group, c in problem.groups:
        inside = [j for j in group if j in place]
        if c and inside:
            length = norm(b[j] for j in inside)
            for j in inside:
                slopes[place[j]] += arb(c) * arb(b[j]) / length
                for i in inside:
                    same = arb(int(i == j))
                    curves[place[j]][place[i]] += arb(c) * (same - arb(b[i]) * arb(b[j]) / length**2) / length


def _dual(problem: Problem, b: list[Any], b0: Any) -> tuple[Any, list[Any]]:
    """A lower bound of P*, and X't at the dual point."""
    t = problem.pulled(b, b0)
    free = [j for group, c in problem.groups for j in group if problem.free(j, c)]
    some = [j for j in free if not problem.positive or b[j]]
    for chosen in (some, free):
        found = _orthogonal(problem, t, chosen)
        v = problem.pulls(found)
        if all(v[j] <= 0 if problem.positive else v[j] == 0 for j in free):
            break
    scale = min([fmpq(1), *(_room(problem, v, group, c) for group, c in problem.groups)])
    linear = sum((y * each for y, each in zip(problem.y, found, strict=True)), fmpq(0))
    quadratic = sum((each * each / k for each, k in zip(found, problem.k, strict=True) if k), fmpq(0)) / 2
    charges = (_charge(problem, v, group, c, scale) for group, c in problem.groups)
    value = arb(scale * linear - scale * scale * quadratic) - sum(charges, arb(0))
    return max(fmpq(0), ends(value)[0]), [scale * each for each in v]


def _orthogonal(problem: Problem, t: list[Any], free: list[int]) -> list[Any]:
    """T minus what it has of 1, with an intercept, and of these columns: t - k A z, A'k A z = A't."""
    columns = [[fmpq(1)] * len(t)] if problem.intercept else []
    for j in free:
        more = [*columns, [row[j] for row in problem.X]]
        seen = [[x if k else fmpq(0) for x, k in zip(each, problem.k, strict=True)] for each in more]
        if fmpq_mat(seen).rank() == len(more):
            columns = more
    q = len(columns)
    if not q:
        return t
    gram = [[_inner(problem.k, one, other) for other in columns] for one in columns]
    right = [sum((x * each for x, each in zip(column, t, strict=True)), fmpq(0)) for column in columns]
    z = fmpq_mat(gram).solve(fmpq_mat(q, 1, right)).entries()
    shift = [
        sum((c * column[i] for c, column in zip(z, columns, strict=True)), fmpq(0)) for i in range(len(t))
    ]
    return [each - k * off for each, k, off in zip(t, problem.k, shift, strict=True)]


def _beyond(problem: Problem, v: list[Any], group: list[int], scale: Any) -> list[Any]:
    """S(s v, l), in absolute values."""
    reach = [scale * (v[j] if problem.positive else abs(v[j])) - problem.l1[j] for j in group]
    return [each if each > 0 else fmpq(0) for each in reach]


def _room(problem: Problem, v: list[Any], group: list[int], c: Any) -> Any:
    """A scale <= 1 at which the supremum of a group is finite; its length is convex in the scale."""
    if problem.ridge[group[0]]:
        return fmpq(1)
    most = ends(norm(_beyond(problem, v, group, fmpq(1))))[1]
    if most <= c:
        return fmpq(1)
    reach = [(problem.l1[j], v[j] if problem.positive else abs(v[j])) for j in group]
    inside = min([fmpq(1), *(limit / size for limit, size in reach if size > 0)])
    return inside + (1 - inside) * c / most if c else inside


def _charge(problem: Problem, v: list[Any], group: list[int], c: Any, scale: Any) -> Any:
    """The supremum of s v'b minus the penalties of a group, where the scale has made it finite."""
    ridge = problem.ridge[group[0]]
    if not ridge:
        return arb(0)
    length = norm(_beyond(problem, v, group, scale)) - arb(c)
    most = ends(length)[1]
    return arb(most * most / (2 * ridge)) if most > 0 else arb(0)


def violations(drawn: Drawn, found: LassoCertificate, truth: Optimum) -> list[str]:
    """The statements of a certificate that are false."""
    problem = Problem.of(drawn.exact)
    b, b0 = [exact(float(x)) for x in drawn.coef], exact(drawn.options.get("intercept", 0.0))
    allowed = not (problem.positive and any(x < 0 for x in b))
    with precision(BITS):
        low, high = ends(problem.value(b, b0))
    least = low - truth.upper
    wrong = {
        "lower <= P*": _float(found.lower) <= truth.upper,
        "P* <= upper": _above(found.upper, truth.lower),
        "objective, from below": not allowed or _float(found.objective[0]) <= high,
        "objective, from above": _above(found.objective[1], low)
        if allowed
        else found.objective[1] == float("inf"),
        "gap": _above(found.gap, least) if allowed else found.gap == float("inf"),
        "relative gap": not allowed or _above(found.relative_gap, least, truth.upper),
        "share of the target": not allowed or _above(found.share_of_target, least, truth.target),
    }
    wrong |= _zeros(problem, found, truth) if truth.tight else {}
    return [statement for statement, holds in wrong.items() if not holds]


def _float(value: float) -> Any:
    return exact(float(value))


def _above(value: float, number: Any, unit: Any = 1) -> bool:
    """Whether value * unit >= number; infinity is above everything, NaN above nothing."""
    return value == float("inf") or (not math.isnan(value) and bool(_float(value) * unit >= number))


def _zeros(problem: Problem, found: LassoCertificate, truth: Optimum) -> dict[str, bool]:
    """Whether what is said to be zero has a dual value below its limit."""
    share, holds = 1 - exact(STRICT), dict[str, bool]()
    for g, (group, c) in enumerate(problem.groups):
        with precision(BITS):
            length = ends(norm(_beyond(problem, truth.v, group, fmpq(1))))[0]
        at_limit = bool(length >= c * share)
        for j in group:
            reach = truth.v[j] if problem.positive else abs(truth.v[j])
            if found.zero_features[j]:
                holds[f"b*_{j} = 0"] = not (at_limit and reach >= problem.l1[j] * share)
        if found.zero_groups.size and found.zero_groups[g]:
            holds[f"b*_g = 0, g = {g}"] = not at_limit
    return holds
