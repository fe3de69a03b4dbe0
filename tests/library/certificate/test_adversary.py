"""The lemmas of docs/rounding.md against arithmetic that rounds the worst way, on data moved as they allow.

An attack runs a function on numbers of `wild` and returns by how much its bound is missed, exactly. None may
succeed; and each constant that is not more generous than the model asks for is planted too small, where one
must.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from itertools import product as combinations
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from wild import LINALG, UNIT, Wild, copied, exact, exacts, excess, wild

from convexperc.certificate import certificate, duality, evaluation, lambda_max, rounding, screening
from convexperc.recognition import decision

Code = SimpleNamespace
Attack = Callable[..., Fraction]
MODULES = (rounding, evaluation, duality, screening, certificate, lambda_max, decision)


@cache
def code(*changes: tuple[str, str]) -> Code:
    """All modules for wild numbers, with pieces of source replaced in the one that has them."""
    copies: list[ModuleType] = []
    for module in MODULES:
        own = [change for change in changes if change[0].split(".")[0] == module.__name__.split(".")[-1]]
        pairs = [(old.split(".", 1)[1], new) for old, new in own]
        copies.append(copied(module, *pairs, below=copies))
    return Code(
        **{module.__name__.split(".")[-1]: copy for module, copy in zip(MODULES, copies, strict=True)}
    )


def attacked_on(*cases: Any) -> Callable[[Attack], Attack]:
    """The adversary has each of these cases to himself."""

    def marked(attack: Attack) -> Attack:
        attack.__dict__["cases"] = cases
        return attack

    return marked


def worst(attack: Attack, *changes: tuple[str, str], enough: bool = False) -> Fraction:
    """By how much the code, with changes, breaks its bound."""
    c, reached = code(*changes), []
    for case in attack.__dict__.get("cases", ((),)):
        reached.append(excess(lambda case=case: attack(c, *case), enough=enough))
        if enough and reached[-1] > 0:
            break
    return max(reached)


def ball(c: Code, mid: Any, rad: Any = (0, 0, 0)) -> Any:
    return c.rounding.Ball(wild(*mid), wild(*rad[: len(mid)]))


@contextmanager
def instead(module: ModuleType, **names: Any) -> Iterator[None]:
    """Replace names of a module for a while."""
    before = {name: vars(module)[name] for name in names}
    vars(module).update(names)
    try:
        yield
    finally:
        vars(module).update(before)


def furthest(low: Fraction, high: Fraction, bounds: tuple[Any, Any]) -> Fraction:
    """By how much [low, high] is not enclosed."""
    return max(exact(bounds[0]) - low, high - exact(bounds[1]))


MID, RAD = (Fraction(3, 4), Fraction(-5, 8), 1 + 2 * UNIT), (Fraction(1, 16), UNIT, Fraction(1, 3))
MIDS, RADS = (Fraction(7, 8), 1 - UNIT, Fraction(1, 3)), (Fraction(1, 9), Fraction(0), UNIT)
NONE = (Fraction(0),) * 3


def magnitude(c: Code) -> Fraction:
    found = ball(c, MID, RAD).magnitude()
    return max(abs(m) + r - exact(f) for m, r, f in zip(MID, RAD, found, strict=True))


def plus(c: Code) -> Fraction:
    """Of balls whose radii are 0, are large, or come from the centres alone."""
    missed = []
    for left, right in combinations((NONE, RAD), (NONE, RADS)):
        found = ball(c, MID, left).plus(ball(c, MIDS, right), -1.0)
        rows = zip(MID, MIDS, left, right, found.mid, found.rad, strict=True)
        missed += [abs(a - b - exact(m)) + r + s - exact(rad) for a, b, r, s, m, rad in rows]
    return max(missed)


def times(c: Code) -> Fraction:
    factor = Wild(Fraction(2, 3))
    missed = []
    for radii in (NONE, RAD, tuple(1000 * r for r in RAD)):
        found = ball(c, MID, radii).times(factor)
        rows = zip(MID, radii, found.mid, found.rad, strict=True)
        missed += [
            abs(a * exact(factor) - exact(m)) + r * exact(factor) - exact(rad) for a, r, m, rad in rows
        ]
    return max(missed)


def inner_range(x: Any, r: Any, y: Any, s: Any) -> tuple[Fraction, Fraction]:
    """The least and the largest x'y with x and y anywhere in their balls."""
    low = high = Fraction(0)
    for a, p, b, q in zip(x, r, y, s, strict=True):
        ends = [(a + i * p) * (b + k * q) for i, k in combinations((-1, 1), (-1, 1))]
        low, high = low + min(ends), high + max(ends)
    return low, high


def pairs() -> list[tuple[Any, Any, Any, Any]]:
    """Floats that add up with one sign; that cancel; balls around them; and around 0."""
    return [
        ((Fraction(2, 3),) * 3, NONE, (Fraction(2, 3),) * 3, NONE),
        (MID, NONE, MIDS, NONE),
        (MID, RAD, MIDS, RADS),
        (NONE, RAD, MIDS, NONE),
        (NONE, RAD, NONE, RADS),
    ]


def product(c: Code) -> Fraction:
    """Of a row each entry of which is off by an entry error, the way that hurts."""
    missed = []
    for x, r, row, _ in pairs():
        for error in (Fraction(0), Fraction(1, 2**40)):
            found = c.rounding.product(wild(list(row)), ball(c, x, r), Wild(error))
            low, high = inner_range(x, r, row, (error,) * 3)
            mid, rad = exact(found.mid[0]), exact(found.rad[0])
            missed.append(furthest(low, high, (mid - rad, mid + rad)))
    return max(missed)


def inner(c: Code) -> Fraction:
    return max(
        furthest(*inner_range(x, r, y, s), c.rounding.inner(ball(c, x, r), ball(c, y, s)))
        for x, r, y, s in pairs()
    )


def square_range(x: Any, r: Any) -> tuple[Fraction, Fraction]:
    low = sum((max(Fraction(0), abs(a) - p) ** 2 for a, p in zip(x, r, strict=True)), Fraction(0))
    return low, sum(((abs(a) + p) ** 2 for a, p in zip(x, r, strict=True)), Fraction(0))


def squared_norm(c: Code) -> Fraction:
    return max(
        furthest(*square_range(x, r), c.rounding.squared_norm(ball(c, x, r))) for x, r, _, _ in pairs()
    )


def norm_bounds(c: Code) -> Fraction:
    found = c.rounding.norm_bounds(ball(c, (3, 4)))
    return furthest(Fraction(5), Fraction(5), found)


def root_alone(c: Code) -> Fraction:
    """The roots of bounds that are exact: what rounding a root outwards is for."""
    bounds, five = (wild(25), wild(25)), Fraction(5)
    with instead(c.rounding, squared_norm=lambda x: (Wild(25),) * 2, inner_by_group=lambda *given: bounds):
        alone = furthest(five, five, c.rounding.norm_bounds(None))
        low, high = c.rounding.norms_by_group(None, None)
    return max(alone, furthest(five, five, (low[0], high[0])))


def groups_of(c: Code) -> Any:
    """The first two of three entries, and the third."""
    return c.rounding.Groups(None, np.array([0, 2]), np.array([2.0, 1.0]))


def inner_by_group(c: Code) -> Fraction:
    groups = groups_of(c)
    missed = []
    for x, r, y, s in pairs():
        low, high = c.rounding.inner_by_group(ball(c, x, r), ball(c, y, s), groups)
        for g, part in enumerate((slice(0, 2), slice(2, 3))):
            ends = inner_range(x[part], r[part], y[part], s[part])
            missed.append(furthest(*ends, (low[g], high[g])))
    return max(missed)


def sum_bounds(c: Code) -> Fraction:
    parts = [(Wild(m), Wild(m)) for m in (*MID, *MIDS)]
    true = sum((*MID, *MIDS), Fraction(0))
    return furthest(true, true, c.rounding.sum_bounds(*parts))


def scaled_bounds(c: Code) -> Fraction:
    x, y = (Wild(Fraction(1, 3)), Wild(Fraction(2, 3))), (Wild(Fraction(5, 7)), Wild(3))
    return furthest(Fraction(5, 21), Fraction(2), c.rounding.scaled_bounds(x, y))


def around(c: Code) -> Fraction:
    mid, rad = Fraction(1, 3), Fraction(1, 5)
    return furthest(mid - rad, mid + rad, c.rounding._around(Wild(mid), Wild(rad)))


@attacked_on((200, 0, 1), (200, 0, 300), (4000, 1000, 300))
def smallest_eigenvalue(c: Code, units: int, moved: int, far: int) -> Fraction:
    """lambda_min of [[1, 1 - e], [1 - e, 1]] is e, a little more is claimed, and the matrix is moved."""
    e, error = units * UNIT, moved * UNIT
    LINALG.eigvalsh = lambda G: [Wild(2 * e * (1 + Fraction(1, 100 * far)))]
    found = c.rounding.smallest_eigenvalue(wild([Fraction(1), 1 - e], [1 - e, Fraction(1)]), Wild(error))
    return exact(found) - (e - error)


@attacked_on((1, Fraction(0)), (2, Fraction(1, 2**40)), (80, Fraction(0)))
def smallest_singular_value(c: Code, d: int, error: Fraction) -> Fraction:
    """Of one row of d entries 3, each off by an entry error; its length is claimed for an eigenvalue."""
    LINALG.eigvalsh = lambda G: [Wild(2 * exact(G[0, 0]) * (1 - UNIT))]
    found = c.rounding.smallest_singular_value(wild([Fraction(3)] * d), Wild(error))
    return exact(found) ** 2 - d * (3 - error) ** 2


def row_squares(c: Code) -> Fraction:
    X = wild([MID[0], MID[2]])
    data = SimpleNamespace(X=X, groups=c.rounding.Groups(None, np.array([0]), np.array([2.0])))
    true = MID[0] ** 2 + MID[2] ** 2
    kind = c.evaluation.NormalizedData
    squares, lengths = kind.row_squares.func(data), kind.block_lengths.func(data)
    return max(true - exact(squares[0]), true - exact(lengths[0]) ** 2)


def objective_bounds(c: Code) -> Fraction:
    """F with one feature a modality, so that every norm is rational; w, p and q anywhere in their balls."""
    data = SimpleNamespace(
        lambda1=(Wild(Fraction(1, 3)),) * 2,
        lambda2=(Wild(Fraction(1, 7)),) * 2,
        lambda3=(Wild(Fraction(2, 3)),) * 2,
    )
    missed = []
    for radii in (NONE, RADS):
        parts = [ball(c, MIDS, radii) for _ in range(3)]
        lengths = wild(*MIDS), wild(*MIDS)
        found = c.evaluation.objective_bounds(data, *parts, lengths)
        low, high = square_range(MIDS, radii)
        sizes = [sum((m + i * r for m, r in zip(MIDS, radii, strict=True)), Fraction(0)) for i in (-1, 1)]
        norms = Fraction(2, 3) * sum(MIDS, Fraction(0))
        ends = (Fraction(4, 3) * v + s / 7 + norms for v, s in zip((low, high), sizes, strict=True))
        missed.append(furthest(*ends, found))
    return max(missed)


def data_of(c: Code, **given: Any) -> SimpleNamespace:
    """What the gap's terms read of a problem: lambdas, as (lower, upper)."""
    lambdas = {name: (Wild(low), Wild(high)) for name, (low, high) in given.items()}
    return SimpleNamespace(groups=groups_of(c), **lambdas)


SCALE = Fraction(5, 7)


def dual_value(c: Code) -> Fraction:
    linear, quadratic = Fraction(1, 3), Fraction(2, 9)
    ray = SimpleNamespace(linear=(Wild(linear),) * 2, quadratic=(Wild(quadratic),) * 2)
    true = SCALE * linear - SCALE**2 * quadratic
    return furthest(true, true, c.duality.dual_value(SimpleNamespace(ray=ray, scale=Wild(SCALE))))


def value_parts(c: Code) -> Fraction:
    """-a'o and ||a||^2/4 + ||b||^2/(4 lambda1), with b and lambda1 anywhere."""
    interval = Fraction(1, 3), Fraction(2, 5)
    data = data_of(c, lambda1=interval)
    data.target = ball(c, MIDS, RADS)
    with instead(c.duality, squared_norm=exact_square):
        linear, quadratic = c.duality._value_parts(data, wild(*MID), ball(c, MIDS, RADS))
    low, high = inner_range(MID, NONE, MIDS, RADS)
    own, squares = square_range(MID, NONE), square_range(MIDS, RADS)
    ends = (one + other / by for one, other, by in zip(own, squares, reversed(interval), strict=True))
    return max(furthest(-high, -low, linear), furthest(*(end / 4 for end in ends), quadratic))


def exact_square(x: Any) -> tuple[Wild, Wild]:
    """`squared_norm` without any slack, so that what surrounds it must do without."""
    low, high = square_range(exacts(x.mid), exacts(x.rad))
    return Wild(low), Wild(high)


def exact_inner(x: Any, y: Any) -> tuple[Wild, Wild]:
    """`inner` without any slack."""
    low, high = inner_range(*(exacts(part) for part in (x.mid, x.rad, y.mid, y.rad)))
    return Wild(low), Wild(high)


def feasible(c: Code) -> Fraction:
    """A scale with an excess of 0 keeps the constraint, and an excess bounds what is above it."""
    missed = []
    for norm in (Fraction(1, 3), Fraction(7, 9), 1 + 2 * UNIT):
        for limit in (SCALE * norm, SCALE * norm * (1 - UNIT), SCALE * norm / 2):
            found = exact(c.duality._excess(Wild(SCALE), Wild(norm), Wild(limit)))
            missed.append(SCALE * norm - limit - found)
    return max(missed)


SIGNS = (MIDS, tuple(-m for m in MIDS))


@attacked_on((NONE,), (RADS,))
def loss_term(c: Code, radii: Any) -> Fraction:
    """||p - s a/2||^2."""
    ray = SimpleNamespace(pull=ball(c, NONE))
    dual = SimpleNamespace(scale=Wild(SCALE), a=wild(*MIDS), b=ball(c, NONE), v=ball(c, NONE), ray=ray)
    zero = ball(c, NONE)
    point = SimpleNamespace(p=ball(c, MID, radii), q=zero, w=zero, u=zero, lengths=(None, wild(0, 0)))
    nothing = (Fraction(0),) * 2
    found = c.duality.gap_terms(data_of(c, lambda1=nothing, lambda2=nothing, lambda3=nothing), point, dual)
    shifts = [m - SCALE * a / 2 for m, a in zip(MID, MIDS, strict=True)]
    return square_range(shifts, radii)[1] - exact(found.loss)


@attacked_on(*combinations(SIGNS, (NONE, RADS)))
def view_term(c: Code, w: Any, radii: Any) -> Fraction:
    """sum_j |w_j| (lambda2 + sign(w_j) s v_j), and the sum of the terms."""
    lambda2, zero, nothing = Fraction(9, 10), ball(c, NONE), (Fraction(0),) * 2
    data = data_of(c, lambda1=nothing, lambda2=(lambda2, lambda2), lambda3=nothing)
    point = SimpleNamespace(p=zero, q=zero, w=ball(c, w), u=zero, lengths=(None, wild(0, 0)))
    low = tuple(-m / 2**20 for m in MIDS)  # so that the rounding of lambda2 + s v is that of lambda2
    ray = SimpleNamespace(pull=zero)
    dual = SimpleNamespace(scale=Wild(SCALE), a=wild(*NONE), b=zero, v=ball(c, low, radii), ray=ray)
    with instead(c.duality, inner=exact_inner):
        found = c.duality.gap_terms(data, point, dual)
    views = Fraction(0)
    for a, m, r in zip(w, low, radii, strict=True):
        views += abs(a) * (lambda2 + SCALE * (m * (1 if a > 0 else -1) + r))
    parts = [exact(part) for part in (found.loss, found.coupling, found.view_norm, found.modality_norm)]
    return max(views - exact(found.view_norm), sum(parts, Fraction(0)) - exact(found.total))


LAMBDA1 = ((Fraction(2, 3),) * 2, (Fraction(1, 3), Fraction(1, 3) + Fraction(1, 50)))


@attacked_on(*combinations(LAMBDA1, ((tuple(5 * m for m in MIDS), NONE), (SIGNS[1], RADS)), (0, 1)))
def coupling_term(c: Code, interval: Any, given: Any, end: int) -> Fraction:
    """lambda1 ||q - s b/(2 lambda1)||^2 at each end of lambda1's interval, q and b in their balls."""
    mids, radii = given
    dual = SimpleNamespace(scale=Wild(SCALE), b=ball(c, MIDS, radii))
    point = SimpleNamespace(q=ball(c, mids, radii))
    with instead(c.duality, squared_norm=exact_square):
        found = c.duality._coupling_term(data_of(c, lambda1=interval), point, dual)
    half = SCALE / (2 * interval[end])
    shifts = [q - half * b for q, b in zip(mids, MIDS, strict=True)]
    spread = [r + half * r for r in radii]
    return interval[end] * square_range(shifts, spread)[1] - exact(found)


def modality_term(c: Code) -> Fraction:
    """sum_i (lambda3 ||u^i|| + u^i' X_i' s b), summands below 0 left out; inner products are exact."""
    lambda3, lengths, products = (
        Fraction(4, 7),
        (Fraction(1, 99), Fraction(3)),
        (Fraction(1, 98), Fraction(-1, 7)),
    )
    dual = SimpleNamespace(scale=Wild(SCALE), ray=SimpleNamespace(pull=ball(c, NONE)))
    point = SimpleNamespace(u=ball(c, NONE), lengths=(None, wild(*lengths)))
    with instead(c.duality, inner_by_group=lambda *given: (None, wild(*products))):
        found = c.duality._modality_term(data_of(c, lambda3=(lambda3, lambda3)), point, dual)
    return sum((lambda3 * u + x for u, x in zip(lengths, products, strict=True)), Fraction(0)) - exact(found)


def weight_bounds(c: Code) -> Fraction:
    """sqrt(n) ||o|| / sigma with n = 4, and ||o||^2 / (2 lambda); roots are rational."""
    sigma, lambda2 = Fraction(1, 3), Fraction(1, 1000)
    data = SimpleNamespace(
        target_square=(None, Wild(Fraction(25, 49))),
        smallest_singular_value=Wild(sigma),
        X=SimpleNamespace(shape=(Wild(9),)),
        lambda2=(Wild(lambda2),),
        lambda3=(Wild(Fraction(2, 3)),),
    )
    by_rank = Fraction(3) * Fraction(5, 7) / sigma - exact(c.screening.view_weight_bound(data, Wild(1)))
    other = c.screening.modality_weight_bound(data, Wild(1))
    return max(by_rank, Fraction(25, 98) / Fraction(2, 3) - exact(other))


def proved_zeros(c: Code) -> Fraction:
    """At lambda2 = |s v_j| + 2 sqrt(gap (||x^j||^2 + lambda1)) nothing is proved; likewise at lambda3."""
    gap, square, one = Fraction(4, 9), Fraction(9, 25), Fraction(16, 25)
    v, rad, norm, length = Fraction(1, 3), Fraction(1, 7), Fraction(3, 7), Fraction(5, 3)
    views = SCALE * (v + rad) + 2 * Fraction(2, 3)
    modalities = SCALE * norm + 2 * Fraction(2, 3) * Fraction(4, 5) * length
    data = SimpleNamespace(
        lambda1=(None, Wild(one)), row_squares=wild(square), block_lengths=wild(length),
        lambda2=(Wild(views),), lambda3=(Wild(modalities),),
    )  # fmt: skip
    point = SimpleNamespace(v=ball(c, (v,), (rad,)), scale=Wild(SCALE), ray=SimpleNamespace(norms=wild(norm)))
    found = c.screening.proved_zeros(data, point, Wild(gap))
    return Fraction(int(found[0][0]) + int(found[1][0]))


def charges(c: Code) -> Fraction:
    """What an excess costs; the lower bound and the gap with that; F(w, u) - lower, and a quotient."""
    weights, excesses = (Fraction(5, 3), Fraction(9, 7)), (Fraction(1, 3), Fraction(2, 7))
    total, lower = Fraction(1, 11), Fraction(1, 9)
    stubs = {
        "view_weight_bound": lambda *given: Wild(weights[0]),
        "modality_weight_bound": lambda *given: Wild(weights[1]),
        "gap_terms": lambda *given: SimpleNamespace(total=Wild(total)),
        "dual_value": lambda *given: (Wild(2), None),
    }
    dual = SimpleNamespace(
        excess_views=Wild(excesses[0]), excess_modalities=Wild(excesses[1]), feasible=False
    )
    charge = excesses[0] * weights[0] + excesses[1] * weights[1]
    missed = []
    with instead(c.certificate, **stubs):
        missed.append(charge - exact(c.certificate._cost(None, dual, None)))
        for value in (Fraction(7, 3), Fraction(3, 2)):
            point = SimpleNamespace(finite=True, objective=(Wild(value),) * 2)
            found, gap, _ = c.certificate._bounded(None, point, dual, None)
            missed += [total + charge - exact(gap), exact(found) - max(2 - charge, value - total - charge)]
            missed.append(value - lower - exact(c.certificate._least(Wild(1000), point, Wild(lower))))
    missed.append(
        Fraction(5, 21) - exact(c.certificate._quotient(Wild(Fraction(1, 7)), Wild(Fraction(3, 5))))
    )
    return max(missed)


def lambda2_max(c: Code) -> Fraction:
    """2 ||X o||_inf from enclosed products."""
    rows = SimpleNamespace(target=None, times_rows=lambda target: ball(c, MIDS, RAD))
    scaling = SimpleNamespace(of=lambda problem: SimpleNamespace(gradient_back=lambda bounds: bounds))
    with instead(c.lambda_max, Scaling=scaling, NormalizedData=SimpleNamespace(of=lambda *given: rows)):
        found = c.lambda_max.lambda2_max(None)
    ends = [max(m + sign * r for m, r in zip(MIDS, RAD, strict=True)) for sign in (-1, 1)]
    return furthest(2 * ends[0], 2 * ends[1], found)


def costs(c: Code) -> Fraction:
    """F* / ||o||^2."""
    F, square = (Fraction(1, 3), Fraction(2, 5)), (Fraction(5, 7), Fraction(6, 7))
    intervals = [tuple(wild(end) for end in pair) for pair in (F, square)]
    low, high = c.decision.costs(c.decision.Decision.EXPLAINED_FRACTION, *intervals)
    return furthest(F[0] / square[1], F[1] / square[0], (low[0], high[0]))


ATTACKS: tuple[Attack, ...] = (
    magnitude, plus, times, product, inner, squared_norm, norm_bounds, root_alone, inner_by_group,
    sum_bounds, scaled_bounds, around, smallest_eigenvalue, smallest_singular_value, row_squares,
    objective_bounds, dual_value, value_parts, feasible, loss_term, view_term, coupling_term, modality_term,
    weight_bounds, proved_zeros, charges, lambda2_max, costs,
)  # fmt: skip


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.__name__)
def test_no_bound_is_broken(attack: Attack) -> None:
    assert worst(attack) <= 0


QUOTIENT = "b_part[1] / data.lambda1[0]"
BETWEEN = "))\n    quarters = max(0.0, down(0.25 * quadratic[0])), "
"""Of two steps upwards the second is there for underflow, which this arithmetic does not have."""
FAULTS: tuple[tuple[Attack, str, str], ...] = (
    (magnitude, "rounding.self.rad) * (1.0 + 4 * U)", "self.rad) * (1.0 + 2 * U)"),
    (plus, "rounding.(1.0 + 8 * U)", "(1.0 + 4 * U)"),
    (plus, "rounding.other.rad + U", "other.rad + 0.5 * U"),
    (times, "rounding.(1.0 + 8 * U)", "(1.0 + 4 * U)"),
    (times, "rounding.abs(factor) + U", "abs(factor) + 0.5 * U"),
    (product, "rounding.gamma(k + 1) *", "0.5 * gamma(k + 1) *"),
    (product, "rounding.4 * (k + 8) * U", "0.0"),
    (product, "rounding.(UNDERFLOW + entry_error)", "UNDERFLOW"),
    (inner, "rounding.gamma(k + 1) *", "0.5 * gamma(k + 1) *"),
    (inner, "rounding.4 * (k + 8) * U", "0.0"),
    (squared_norm, "rounding.gamma(k + 1) *", "0.5 * gamma(k + 1) *"),
    (squared_norm, "rounding.4 * (k + 8) * U", "0.0"),
    (root_alone, "rounding.down(math.sqrt(lower))", "math.sqrt(lower)"),
    (root_alone, "rounding.up(math.sqrt(upper))", "math.sqrt(upper)"),
    (root_alone, "rounding.np.nextafter(low, -np.inf)", "low"),
    (root_alone, "rounding.np.nextafter(high, np.inf)", "high"),
    (inner_by_group, "rounding.groups.rounding *", "0.5 * groups.rounding *"),
    (inner_by_group, "rounding.4 * (k + 12.0) * U", "0.0"),
    (sum_bounds, "rounding.up(total + value)", "(total + value)"),
    (sum_bounds, "rounding.down(total + value)", "(total + value)"),
    (scaled_bounds, "rounding.down(low)", "low"),
    (scaled_bounds, "rounding.up(high)", "high"),
    (around, "rounding.down(mid - rad)", "mid - rad"),
    (around, "rounding.up(mid + rad)", "mid + rad"),
    (smallest_eigenvalue, "rounding.4 * gamma(n + 4)", "0 * gamma(n + 4)"),
    (smallest_eigenvalue, "rounding.slack = error +", "slack = 0.0 +"),
    (smallest_singular_value, "rounding.gamma(d + 2) * total", "0.0"),
    (smallest_singular_value, "rounding.+ entry_error", "+ 0.0 * entry_error"),
    (row_squares, "evaluation.4 * (d + 8) * U", "0.0"),
    (row_squares, "evaluation.4 * (self.X.size + 8) * U", "0.0"),
    (dual_value, "duality.up(s * s)", "s * s"),
    (dual_value, "duality.down(s * s)", "s * s"),
    (dual_value, "duality.down(s * linear[0])", "s * linear[0]"),
    (dual_value, "duality.up(square[0]", "(square[0]"),
    (dual_value, "duality.up(s * linear[1])", "s * linear[1]"),
    (dual_value, "duality.down(square[1]", "(square[1]"),
    (dual_value, "duality.return down(low)", "return low"),
    (dual_value, "duality.up(high)", "high"),
    (
        value_parts,
        f"duality.up({QUOTIENT}){BETWEEN}up(0.25 * quadratic[1])",
        f"{QUOTIENT}{BETWEEN}0.25 * quadratic[1]",
    ),
    (value_parts, "duality.down(0.25 * quadratic[0])", "0.25 * quadratic[0]"),
    (feasible, "duality.up(s * norm)", "s * norm"),
    (feasible, "duality.up(reached - limit)", "reached - limit"),
    (coupling_term, "duality.8 * U + (high", "0.0 + (high"),
    (coupling_term, "duality.+ (high - low) / low", ""),
    (modality_term, "duality.up(total + max", "(total + max"),
    (modality_term, "duality.up(norm + product)", "norm + product"),
    (weight_bounds, "screening.2.0**-50", "0.0"),
    (weight_bounds, "screening.return up(min", "return (min"),
    (proved_zeros, "screening.views * (1.0 + 2.0**-48)", "views"),
    (proved_zeros, "screening.modalities * (1.0 + 2.0**-48)", "modalities"),
    (charges, "certificate.cost = up(dual", "cost = (dual"),
    (charges, "certificate.up(cost + up", "(cost + up"),
    (charges, "certificate.up(dual_point.excess_modalities", "(dual_point.excess_modalities"),
    (charges, "certificate.down(lower - cost)", "lower - cost"),
    (charges, "certificate.up(parts.total + cost)", "parts.total + cost"),
    (charges, "certificate.down(point.objective[0] - total)", "point.objective[0] - total"),
    (charges, "certificate.up(point.objective[1] - lower))", "point.objective[1] - lower)"),
    (charges, "certificate.up(gap / value)", "gap / value"),
    (lambda2_max, "lambda_max.down(2.0 * lower)", "2.0 * lower"),
    (costs, "decision.1.0 - 4 * U", "1.0 - 2 * U"),
    (costs, "decision.1.0 + 4 * U", "1.0 + 2 * U"),
)
"""Where a bound holds with half of a constant, docs/rounding.md says how much of it is needed; `test_lemmas`
compares every constant with its lemma."""


@pytest.mark.parametrize(
    ("attack", "old", "new"), FAULTS, ids=[f"{at.__name__}: {old}" for at, old, _ in FAULTS]
)
def test_a_constant_that_is_too_small_is_caught(attack: Attack, old: str, new: str) -> None:
    assert worst(attack, (old, new), enough=True) > 0
