"""The bounds from reduced data against the worst rounding, and data moved by all that their depth allows.

Each modality has one feature, and the rows of X are Pythagorean, so that F, D and all norms are rational. See
`test_adversary`.
"""

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import product
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from wild import UNIT, Wild, copied, exact, exacts, excess, wild

from convexperc.certificate import cases as cases_of
from convexperc.certificate import data_bounds, lasso, reduced

DEPTH = 400
"""Roundings behind the data: so many that half of a bound of them is too little."""
NEEDED = 16
"""Roundings on top that docs/rounding.md counts: the larger of 4 n + 8 and 2 n + 2 m + 5, with n = m = 2."""
X = ((Fraction(3, 5), Fraction(4, 5)), (Fraction(12, 13), Fraction(-5, 13)))
O = (Fraction(3, 7), Fraction(4, 7))
LAMBDAS = (Fraction(2, 3), Fraction(1, 3), Fraction(1, 4))

Row = tuple[Fraction, ...]


def gamma(k: int) -> Fraction:
    """k u / (1 - k u)."""
    return k * UNIT / (1 - k * UNIT)


def dot(x: Any, y: Any) -> Fraction:
    return sum((a * b for a, b in zip(x, y, strict=True)), Fraction(0))


@cache
def code(*changes: tuple[str, str]) -> tuple[ModuleType, ModuleType]:
    """`reduced` and `lasso` for wild numbers."""
    one = copied(reduced, *(pair for pair in changes if pair[0] in source(reduced)))
    return one, copied(lasso, *(pair for pair in changes if pair[0] in source(lasso)), below=[one])


def source(module: ModuleType) -> str:
    return inspect.getsource(module)


@dataclass(frozen=True)
class Moved:
    """A point (w, t, q), with true values of all that is bounded, and data that are off.

    Attributes
    ----------
    signs : (int, int, int)
        Which way G, the K_i, and c with ||o||^2 are moved.
    """

    w: Row
    t: Row
    q: Row
    signs: tuple[int, int, int]
    budget: int = NEEDED

    @property
    def y(self) -> Row:
        """X(X'w - o)."""
        return tuple(dot(row, self.p) for row in X)

    @property
    def p(self) -> Row:
        """X'w - o."""
        return tuple(
            dot(column, self.w) - target for column, target in zip(zip(*X, strict=True), O, strict=True)
        )

    def pulled(self, x: Row) -> Row:
        """X_i'x, one number a modality."""
        return tuple(dot(column, x) for column in zip(*X, strict=True))

    @property
    def e(self) -> Row:
        """Xu - w."""
        u = tuple(t * x for t, x in zip(self.t, self.pulled(self.q), strict=True))
        return tuple(dot(row, u) - w for row, w in zip(X, self.w, strict=True))

    def value(self, moved: Fraction = Fraction(0)) -> Fraction:
        """F(w, u), with each u^i longer by `moved` t_i times a bound of its own length."""
        one, two, three = LAMBDAS
        u = []
        for i, (t, x) in enumerate(zip(self.t, self.pulled(self.q), strict=True)):
            tau = sum((abs(a) * abs(row[i]) for a, row in zip(self.q, X, strict=True)), Fraction(0))
            u.append(t * x + moved * t * tau * (1 if x >= 0 else -1))
        e = [dot(row, u) - w for row, w in zip(X, self.w, strict=True)]
        return dot(self.p, self.p) + one * dot(e, e) + two * sum(map(abs, self.w)) + three * sum(map(abs, u))

    def dual(self, s: Fraction, b: Row) -> Fraction:
        """D(s a, s b) at a = 2(X'w - o)."""
        return -2 * s * dot(self.p, O) - s * s * (dot(self.p, self.p) + dot(b, b) / (4 * LAMBDAS[0]))

    def shared(self) -> Any:
        """Gram matrices, each entry off by gamma_DEPTH times the two lengths."""
        g, off = gamma(DEPTH + self.budget), gamma(DEPTH)
        way = [1 if x >= 0 else -1 for x in self.w]
        K = []
        for i in range(2):
            x, toward = [row[i] for row in X], [1 if v >= 0 else -1 for v in self.q]
            error = [[self.signs[1] * off * abs(a * b) for b in x] for a in x]
            K.append([[x[a] * x[b] + toward[a] * toward[b] * error[a][b] for b in (0, 1)] for a in (0, 1)])
        G = [[dot(X[a], X[b]) + self.signs[0] * off * way[a] * way[b] for b in (0, 1)] for a in (0, 1)]
        lengths = [[abs(row[i]) for row in X] for i in range(2)]
        blocks = Fraction(9, 8), Fraction(1)
        return cases_of.GramBounds(wild(*G), wild(*K), wild(*lengths), wild(1, 1), wild(*blocks), Wild(g))

    def case(self) -> Any:
        """X o and ||o||^2, off likewise, and the point."""
        off, length = self.signs[2] * gamma(DEPTH), Fraction(5, 7)
        way = [1 if x >= 0 else -1 for x in self.w]
        c = [dot(row, O) - off * k * length for row, k in zip(X, way, strict=True)]
        target = Wild(length**2 * (1 + off))
        return cases_of.Case(
            wild(*c), target, wild(*LAMBDAS), *(wild(*part) for part in (self.w, self.t, self.q))
        )


def room_of() -> Any:
    """Working memory for two views and two modalities."""
    shapes = [(2,)] * 7 + [(2, 2)] * 2 + [(2,)] * 5
    return cases_of.Room(*(np.full(shape, Wild(0), dtype=object) for shape in shapes))


def misses(module: ModuleType, point: Moved, kind: str) -> Iterator[Fraction]:
    """By how much each number that `reduced` encloses lies outside."""
    shared, case, room = point.shared(), point.case(), room_of()
    value = module.value_bounds(shared, case, room)
    pulled = point.pulled(point.q)
    yield from _off(room.e, point.e, room.e_error)
    yield from (exact(low) - abs(x) for low, x in zip(room.low, pulled, strict=True))
    yield from (abs(x) - exact(high) for high, x in zip(room.high, pulled, strict=True))
    yield exact(value.lower) - point.value()
    yield point.value(gamma(3)) - exact(value.upper)
    yield point.value(gamma(3)) - point.value() - exact(value.stored)
    yield dot(point.p, point.p) - exact(value.loss) * (1 + gamma(1))
    module._coupling(shared, case, value, room)
    if kind != "coupling":
        module._slack(shared, case, value, kind == "sign", room)
    y = point.y
    v = tuple(2 * (a + b) for a, b in zip(y, point.q, strict=True)) if kind == "coupling" else exacts(room.v)
    b = tuple(2 * a - x for a, x in zip(y, v, strict=True))
    yield from _off(room.b, b, room.b_error)
    yield from _off(room.v, v, room.v_error)
    reach = point.pulled(b)
    yield from (abs(x) - exact(most) for x, most in zip(reach, room.reach, strict=True))
    slack = 4 * UNIT  # `_gap` charges the last rounding of `pull`
    for a, x, most in zip(pulled, reach, room.pull, strict=True):
        yield a * x - exact(most) - slack * abs(exact(most))
    total, s = module._gap(shared, case, value, room)
    if s:
        scale = exact(s)
        yield point.value() - point.dual(scale, b) - exact(total)
        yield from (scale * abs(x) - LAMBDAS[1] for x in v)
        yield from (scale * abs(x) - LAMBDAS[2] for x in reach)


def _off(found: Any, true: Any, error: Any) -> Iterator[Fraction]:
    return (abs(exact(a) - b) - exact(e) for a, b, e in zip(found, true, error, strict=True))


POINTS: tuple[tuple[Row, Row, Row], ...] = (
    ((Fraction(1, 3), Fraction(1, 7)), (Fraction(2, 3), Fraction(1, 9)), (Fraction(1, 5), Fraction(1, 11))),
    ((Fraction(-30), Fraction(70, 3)), (Fraction(0), Fraction(7, 3)), (Fraction(-9, 7), Fraction(40, 3))),
    ((Fraction(1, 30), Fraction(0)), (Fraction(1, 3), Fraction(0)), (Fraction(1, 99), Fraction(-1, 70))),
)
KINDS = ("coupling", "slack", "sign")


SIGNS = ((1, 1, 1), (-1, -1, -1))


def worst(kind: str, *changes: tuple[str, str], budget: int = NEEDED) -> Fraction:
    """By how much any bound is broken."""
    module = code(*changes)[0]
    return max(
        excess(lambda at=Moved(*point, signs, budget): max(misses(module, at, kind)), tries=4, climb=False)
        for point, signs in product(POINTS, SIGNS)
    )


@pytest.mark.parametrize("kind", KINDS)
def test_no_bound_from_reduced_data_is_broken(kind: str) -> None:
    assert worst(kind) <= 0


def test_each_rounding_alone_cannot_break_one_either() -> None:
    module, at = code()[0], Moved(*POINTS[0], SIGNS[0])
    assert excess(lambda: max(misses(module, at, "sign")), tries=0) <= 0


FEW = 12
"""More roundings than there are in `_gap` and in the bounds of lengths."""
LIMITS = ("views", "modalities", "just beyond, views", "just beyond, modalities")
TERMS = ("coupling", "views", "modalities")


def gap_alone(module: ModuleType, limit: str, term: str) -> Fraction:
    """`_gap` where all that it is given is exact: at a limit, or at a point where one term is almost 0."""
    one, s, far, room = LAMBDAS[0], Fraction(5, 7), Fraction(10), room_of()
    v, reach = (Fraction(-2, 7), Fraction(4, 9)), (Fraction(1, 7), Fraction(2, 9))
    b, loss = ((Fraction(1, 3), Fraction(3, 5)), UNIT**4) if term else ((Fraction(0),) * 2, Fraction(1))
    end = 1 + 40 * UNIT if term else 1 - UNIT / 2 if "just" in limit else Fraction(1, 2)
    two = far if "modalities" in limit else s * v[1] * end
    three = far if "views" in limit else s * reach[1] * end
    e = tuple(s * x / (2 * one) * (1 + 3 * UNIT) for x in b)
    errors = tuple(UNIT * x for x in (Fraction(1, 99), Fraction(1, 98)))
    pull, high = (
        tuple(-three * x / s for x in (Fraction(1, 4), Fraction(2, 3))),
        (Fraction(1, 4), Fraction(2, 3)),
    )
    w = (Fraction(0), Fraction(-1, 9)) if term == "views" else (Fraction(0),) * 2
    t = (Fraction(1, 3), Fraction(3)) if term == "modalities" else (Fraction(0),) * 2
    for name, values in {
        "b": b,
        "v": v,
        "reach": reach,
        "e": e,
        "e_error": errors,
        "pull": pull,
        "high": high,
    }.items():
        getattr(room, name)[:] = wild(*values)
    target = s * (loss + dot(b, b) / (4 * one))
    case = cases_of.Case(None, Wild(target), wild(one, two, three), wild(*w), wild(*t), None)
    shared = SimpleNamespace(gamma=Wild(gamma(FEW)))
    total, found = module._gap(shared, case, SimpleNamespace(loss=Wild(loss), linear=Wild(0)), room)
    s = exact(found)
    coupling = sum(
        ((abs(x - s * y / (2 * one)) + d) ** 2 for x, y, d in zip(e, b, errors, strict=True)), Fraction(0)
    )
    true = (1 - s) ** 2 * loss + one * coupling
    for a, x in zip(w, v, strict=True):
        true += abs(a) * max(Fraction(0), two + s * x * (1 if a > 0 else -1))
    for weight, norm, x in zip(t, high, pull, strict=True):
        true += weight * max(Fraction(0), three * norm + s * x)
    return max(true - exact(total), *(s * abs(x) - two for x in v), *(s * x - three for x in reach))


def zeros_alone(module: ModuleType) -> Fraction:
    """At lambda2 = s (|v_j| + error) + 2 sqrt(gap (||x^j||^2 + lambda1)) nothing is proved; so at lambda3."""
    room, s, gap, one = room_of(), Fraction(5, 7), Fraction(4, 9), Fraction(16, 25)
    room.v[:], room.v_error[:], room.reach[:] = wild(1, 0), wild(Fraction(1, 7), 0), wild(Fraction(3, 7), 0)
    two = s * Fraction(8, 7) + 2 * Fraction(2, 3)
    three = s * Fraction(3, 7) + 2 * Fraction(2, 3) * Fraction(4, 5) * Fraction(5, 3)
    shared = SimpleNamespace(rows=wild(Fraction(3, 5), 1000), blocks=wild(Fraction(5, 3), 1000))
    bounds = SimpleNamespace(
        zero_views=np.zeros((1, 2), dtype=bool), zero_modalities=np.zeros((1, 2), dtype=bool)
    )
    module._zeros(shared, wild(one, two, three), Wild(gap), Wild(s), room, bounds, 0)
    return Fraction(int(bounds.zero_views.sum() + bounds.zero_modalities.sum()))


def ends_alone(module: ModuleType) -> Fraction:
    """The interval of F* from bounds of F and of the gap that are exact."""
    lower, gap, stored = Fraction(5, 7), Fraction(1, 300), Fraction(1, 900)
    value = SimpleNamespace(lower=Wild(lower), upper=Wild(1), stored=Wild(stored))
    bounds = cases_of.AnswerBounds.unknown(1, 2, 2)._replace(
        **{name: np.full(1, None, dtype=object) for name in ("lower", "upper", "gap")},
        modality_norms=np.zeros((1, 2), dtype=object),
    )  # fmt: skip
    stubs = {
        "value_bounds": lambda *given: value, "_coupling": lambda *given: None, "_slack": lambda *given: None,
        "_gap": lambda *given: (Wild(gap), Wild(1)), "_zeros": lambda *given: None,
    }  # fmt: skip
    before = {name: vars(module)[name] for name in stubs}
    vars(module).update(stubs)
    module._bound_one(
        None, SimpleNamespace(t=wild(1, 1), lambdas=None), Wild(1000), np.inf, room_of(), bounds, 0
    )
    vars(module).update(before)
    return max(exact(bounds.lower[0]) - (lower - gap), gap + stored - exact(bounds.gap[0]))


FLOOR = Fraction(1, 3)
"""A lower bound of lambda_min(X X') = 1 - |x_1'x_2|, which is 48 / 65."""


def lasso_alone(module: ModuleType, w: Row, lambdas: Row, signs: tuple[int, int, int]) -> Fraction:
    """F* >= h(w) - sum_j (2 y_j + v_j)^2 / (4 floor) in exact numbers, against what is made of moved data."""
    at = Moved(w, (Fraction(0),) * 2, (Fraction(0),) * 2, signs)
    one, two, _ = lambdas
    bounds = cases_of.AnswerBounds.unknown(1, 2, 2)._replace(
        **{name: np.full(1, None, dtype=object) for name in ("lower", "upper", "gap")},
        modality_norms=np.zeros((1, 2), dtype=object),
    )  # fmt: skip
    case = at.case()._replace(lambdas=wild(*lambdas))
    module._bound_one(at.shared(), case, Wild(FLOOR), room_of(), bounds, 0)
    h = dot(at.p, at.p) + two * sum(map(abs, w)) + one * dot(w, w)
    deficit = Fraction(0)
    for y, a in zip(at.y, w, strict=True):
        v = two * (1 if a > 0 else -1) if a else min(max(-2 * y, -two), two)
        deficit += (2 * y + v) ** 2 / (4 * FLOOR)
    gap = deficit + one * dot(w, w)
    radius = [two - (abs(2 * y) + 2 * _root(gap)) for y in at.y]
    false = sum(bool(zero) and left <= 0 for zero, left in zip(bounds.zero_views[0], radius, strict=True))
    ends = exact(bounds.lower[0]) - max(Fraction(0), h - gap), h - exact(bounds.upper[0])
    return max(gap - exact(bounds.gap[0]), *ends, Fraction(false))


def _root(square: Fraction) -> Fraction:
    return Fraction(float(square) ** 0.5)


lasso_kernel = tuple(
    (w, (one, two, Fraction(0)), signs)
    for w, signs in product(((Fraction(1, 3), Fraction(0)), (Fraction(-9), Fraction(7))), SIGNS)
    for one, two in ((Fraction(0), Fraction(1, 3)), (Fraction(1, 7), Fraction(0)))
)


def lengths_alone(module: ModuleType) -> Fraction:
    """Lengths of rows and of blocks, ||o||^2, and ||X o||_inf, where the data are shorter by their depth."""
    off, parts = gamma(DEPTH), (Fraction(3, 5), Fraction(4, 5))
    K = wild(*([[part**2 * (1 - off)]] for part in parts))
    views = SimpleNamespace(reduction=SimpleNamespace(depth=DEPTH))
    square, c = Fraction(25, 49), Fraction(1, 2**20)
    library = SimpleNamespace(lengths=SimpleNamespace(squares=wild(square * (1 + off))))
    data = SimpleNamespace(
        n=1, m=2, p=1, K=K, G=None, views=views, library=library,
        sound=np.ones(1, dtype=bool), C=wild([c - off]),
        normalised=lambda penalties: wild([Fraction(0), 2 * c * (1 - UNIT**3), Fraction(0)]),
    )  # fmt: skip
    found = module.DataBounds.of(data)
    shared = found.shared
    missed = [part - exact(length[0]) for part, length in zip(parts, shared.lengths, strict=True)]
    missed += [
        1 - exact(shared.rows[0]),
        *(part - exact(b) for part, b in zip(parts, shared.blocks, strict=True)),
    ]
    lower, upper = found.squares
    library.lengths.squares = wild(square * (1 - off))
    missed += [exact(lower[0]) - square, square - exact(module.DataBounds(data, shared).squares[1][0])]
    assert exact(upper[0]) > square
    return max(*missed, Fraction(int(found.zero_is_optimal(None)[0])))


GAPS = (*((limit, "") for limit in LIMITS), *(("", term) for term in TERMS))


@pytest.mark.parametrize(("limit", "term"), GAPS)
def test_the_gap_of_exact_numbers_is_bounded_at_a_point_that_is_feasible(limit: str, term: str) -> None:
    assert excess(lambda: gap_alone(code()[0], limit, term)) <= 0


def test_zeros_and_the_ends_of_the_interval_are_rounded_outwards() -> None:
    assert excess(lambda: zeros_alone(code()[0])) <= 0
    assert excess(lambda: ends_alone(code()[0])) <= 0


@pytest.mark.parametrize("given", lasso_kernel)
def test_no_bound_of_the_lasso_is_broken(given: Any) -> None:
    assert excess(lambda: lasso_alone(code()[1], *given), climb=False) <= 0


def test_lengths_are_bounded_from_their_squares() -> None:
    assert excess(lambda: lengths_alone(bounds_of_data())) <= 0


@cache
def bounds_of_data(*changes: tuple[str, str]) -> ModuleType:
    """`data_bounds` for wild numbers."""
    return copied(data_bounds, *changes, below=[code()[0]])


def gaps(*changes: tuple[str, str]) -> Iterator[Fraction]:
    yield from (excess(lambda at=at: gap_alone(code(*changes)[0], *at), enough=True) for at in GAPS)


def others(*changes: tuple[str, str]) -> Iterator[Fraction]:
    yield from (excess(lambda do=do: do(code(*changes)[0]), enough=True) for do in (zeros_alone, ends_alone))


def lassos(*changes: tuple[str, str]) -> Iterator[Fraction]:
    yield from (excess(lambda at=at: lasso_alone(code(*changes)[1], *at), climb=False) for at in lasso_kernel)


def lengths(*changes: tuple[str, str]) -> Iterator[Fraction]:
    yield excess(lambda: lengths_alone(bounds_of_data(*changes)), enough=True)


def enclosures(*changes: tuple[str, str]) -> Iterator[Fraction]:
    yield from (worst(kind, *changes) for kind in KINDS)


FAULTS = (
    (enclosures, "error = g * rho * rho", "error = 0.5 * g * rho * rho"),
    (enclosures, "error = g * tau * tau", "error = 0.5 * g * tau * tau"),
    (enclosures, "room.e_error[a] += g *", "room.e_error[a] += 0.5 * g *"),
    (enclosures, "2.0 * shared.gamma * (", "1.0 * shared.gamma * ("),
    (enclosures, "room.b_error[a] = 2.0 * g *", "room.b_error[a] = 1.0 * g *"),
    (enclosures, "+ g * tau * tau", "+ 0.5 * g * tau * tau"),
    (enclosures, "(np.sqrt(square) + extra)", "(np.sqrt(square) + 0.5 * extra)"),
    (enclosures, "(1.0 + g) * extra * room.tau[i]", "0.5 * extra * room.tau[i]"),
    (enclosures, "stored = (", "stored = 0.0 * ("),
    (gaps, "s * worst * (1.0 + 4 * U) > two", "s * worst > two"),
    (gaps, "s * room.reach[i] * (1.0 + 4 * U) > three", "s * room.reach[i] > three"),
    (gaps, "two / worst * (1.0 - 16 * U)", "two / worst"),
    (gaps, "three / room.reach[i] * (1.0 - 16 * U)", "three / room.reach[i]"),
    (gaps, "/ one + 8 * U *", "/ one + 0.0 *"),
    (gaps, "s * room.v_error[a] + 8 * U *", "s * room.v_error[a] + 0.0 *"),
    (gaps, "pulled + 8 * U *", "pulled + 0.0 *"),
    (gaps, "total * (1.0 + g) +", "total +"),
    (others, "(1.0 + 2.0**-40)", "1.0"),
    (others, "8 * U * (value.lower + best)", "2 * U * (value.lower + best)"),
    (others, "(best + value.stored) * (1.0 + 4 * U)", "(best + value.stored) * (1.0 + 2 * U)"),
    (lassos, "error = 2.0 * g * (shared.rows[a] * value.rho", "error = g * (shared.rows[a] * value.rho"),
    (lengths, "(1.0 + 4 * g)", "(1.0 + 0.5 * g)"),
    (lengths, "found * (1.0 - g)", "found * (1.0 - 0.5 * g)"),
    (lengths, "found * (1.0 + g)", "found * (1.0 + 0.5 * g)"),
    (lengths, "2.0 * self.shared.gamma", "0.5 * self.shared.gamma"),
)


@pytest.mark.parametrize(("attacks", "old", "new"), FAULTS, ids=[old for _, old, _ in FAULTS])
def test_a_constant_that_is_too_small_is_caught(attacks: Any, old: str, new: str) -> None:
    assert any(missed > 0 for missed in attacks((old, new)))


@pytest.mark.parametrize("kind", KINDS)
def test_without_roundings_on_top_of_the_depth_a_bound_is_broken(kind: str) -> None:
    assert worst(kind, budget=0) > 0


def test_a_scale_that_is_feasible_only_in_rounded_arithmetic_is_not_taken() -> None:
    """In float64: s |v| rounds to lambda2, and lies above it; the same at lambda3."""
    rng, seen = np.random.default_rng(0), 0
    for worst_v, s in rng.uniform(0.5, 1.0, size=(200, 2)).tolist():
        limit = s * worst_v
        if not Fraction(limit) < Fraction(s) * Fraction(worst_v):
            continue
        seen += 1
        for two, three, v, reach in ((limit, 8.0, worst_v, 0.0), (8.0, limit, 0.0, worst_v)):
            room = cases_of.room_in(cases_of.new_numbers(1, 1), 1, 1)
            for array in room:
                array[:] = 0.0
            room.v[0], room.reach[0] = v, reach
            case = cases_of.Case(
                np.zeros(1), s, np.array([1.0, two, three]), np.zeros(1), np.zeros(1), np.zeros(1)
            )
            empty = np.zeros((1, 1, 1))
            shared = cases_of.GramBounds(empty[0], empty, empty[0], np.ones(1), np.ones(1), 1e-14)
            _, found = reduced._gap(shared, case, cases_of.Value(1.0, 0.0, 1.0, 0.0, 1.0, 0.0), room)
            assert found > 0.0
            assert Fraction(found) * Fraction(worst_v) <= Fraction(limit), (found, worst_v, limit)
    assert seen > 50
