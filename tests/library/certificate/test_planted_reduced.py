"""Planted faults in the bounds from reduced data: each dropped or turned term is caught, true code is not.

The rounding of G, K and c is played by an adversary: each entry is moved by all that `gamma` allows, with
`gamma` so large that a missing term shows.
"""

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, product
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from convexperc.certificate import cases as cases_of
from convexperc.certificate import reduced as reduced_bounds
from convexperc.problem.formulation import objective
from convexperc.problem.problem import Problem
from convexperc.problem.reduction import Reduction
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.newton.method import Newton

GAMMA = 1e-3
LAMBDAS = (
    (0.5, 0.3, 0.2), (1.0, 0.0, 0.1), (0.1, 1.0, 0.05), (2.0, 0.1, 5.0), (0.02, 3.0, 0.3), (3.0, 0.5, 0.02),
    (10.0, 0.05, 1.0),
)  # fmt: skip
"""The last one's views differ in one modality alone, so that q'K_i q cancels in the other."""
NOTICED = 1e-9
"""What counts as a contradiction, relative to ||o||^2; F* itself is known to 1e-10."""


def interpreted(*changes: tuple[str, str]) -> ModuleType:
    """The module as plain Python, with pieces of its source replaced."""
    source = inspect.getsource(reduced_bounds)
    for old, new in changes:
        assert source.count(old) >= 1, old
        source = source.replace(old, new)
    module = ModuleType("mutant")
    module.__dict__["__name__"] = "convexperc.certificate.reduced"
    exec(compile(source, "mutant", "exec"), module.__dict__)
    return module


@dataclass(frozen=True, eq=False)
class Case:
    """A small problem, its optimum, and a point (w, u) by (w, t, q), which is the solver's or a worse one."""

    problem: Problem
    lowest: float
    best: tuple[np.ndarray, np.ndarray]
    reduction: Reduction
    w: np.ndarray
    t: np.ndarray
    q: np.ndarray
    solved: bool

    @property
    def value(self) -> float:
        return float(objective(self.problem, self.w, self.reduction.recover(self.t, self.q)))


def cases() -> Iterator[Case]:
    rng = np.random.default_rng(7)
    for index, lambdas in enumerate(LAMBDAS):
        n, sizes = 2 + index % 2, [2, 3]
        X = rng.standard_normal((n, 5))
        if index == len(LAMBDAS) - 1:
            n, X = 2, np.array([[0.5, 0.5, 0.5, 0.0, 0.0], [0.5, 0.53, -0.5, 0.0, 0.0]])
        X /= 1.1 * np.linalg.norm(X, axis=1).max()
        o = X.T @ np.array([1.0, -1.0, 0.5])[:n] + 0.3 * rng.standard_normal(5)
        o *= 0.9 / np.linalg.norm(o)
        names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
        problem = Problem(X, o, modalities=sizes, **names)
        found = solve(problem, relative_tolerance=1e-10)
        assert found.status is Status.CERTIFIED
        reduction = Reduction.of(problem.X, problem.modalities)
        batch = Newton().batch(
            reduction.G, reduction.K, (X @ o)[None], np.array([o @ o]), np.array([lambdas])
        )
        best = found.w, found.modality_norms
        for place, point in enumerate(points(rng, batch.W[0], batch.T[0], batch.Q[0])):
            yield Case(problem, found.certificate.lower, best, reduction, *point, place == 0)


def points(rng: Any, w: np.ndarray, t: np.ndarray, q: np.ndarray) -> Iterator[tuple[np.ndarray, ...]]:
    """The optimum, points around it, and points of which one part alone is wrong."""
    yield w, t, q
    yield w * (1 + 1e-3 * rng.standard_normal(w.size)), t, q * (1 + 1e-3 * rng.standard_normal(q.size))
    yield 0 * w, 0 * t, 0 * q
    yield w, 0 * t, q
    yield w, 3 * t, q
    yield w, t + 0.5, q
    yield w, t, 3 * q
    yield w, t, 0.3 * q
    for j in range(w.size):
        for value in (0.0, 0.05, -0.05, -w[j]):
            yield np.where(np.arange(w.size) == j, value, w), t, q


ALL = tuple(cases())


def disturbed(case: Case, gamma: float, signs: tuple[int, int]) -> tuple[Any, Any, float]:
    """GramBounds data, c and ||o||^2, off by all that `gamma` allows, in a direction that hurts."""
    problem, reduction = case.problem, case.reduction
    lengths = np.sqrt(np.einsum("ijj->ij", reduction.K))
    rows = np.linalg.norm(problem.X, axis=1)
    omega = float(np.linalg.norm(problem.o))
    toward, pulled = signs[0] * np.sign(case.w), np.sign(case.q)
    moved = 0.98 * gamma
    K = reduction.K + signs[1] * moved * np.einsum("ij,ik,j,k->ijk", lengths, lengths, pulled, pulled)
    G = reduction.G + signs[0] * moved * np.outer(np.sign(case.w) * rows, np.sign(case.w) * rows)
    c = problem.X @ problem.o - moved * toward * rows * omega
    target = omega**2 + signs[0] * moved * omega**2
    blocks = np.sqrt((lengths**2).sum(axis=1))
    grow = 1.0 + gamma
    return cases_of.GramBounds(G, K, grow * lengths, grow * rows, grow * blocks, gamma), c, target


def judged(module: ModuleType, case: Case, gamma: float, signs: tuple[int, int]) -> Any:
    """The bounds that follow from disturbed data."""
    shared, c, target = disturbed(case, gamma, signs)
    bounds = cases_of.AnswerBounds.unknown(1, case.problem.n, len(shared.K))
    data = c[None], np.array([target]), np.array([case.problem.lambdas])
    cases = cases_of.Cases(*data, case.w[None], case.t[None], case.q[None])
    room = cases_of.new_numbers(case.problem.n, len(shared.K))
    module.bound_reduced(shared, cases, np.arange(1), 1e-9, *cases_of.NO_EXCLUSION, room, bounds)
    return bounds


def broken_enclosures(module: ModuleType, case: Case, signs: tuple[int, int]) -> list[str]:
    """Every intermediate number that lies outside of its own bound."""
    problem, reduction = case.problem, case.reduction
    shared, c, target = disturbed(case, GAMMA, signs)
    n, m = problem.n, len(shared.K)
    room = cases_of.Room(*(np.empty(n) for _ in range(7)), *(np.empty((m, n)) for _ in range(2)),
                        *(np.empty(m) for _ in range(5)))  # fmt: skip
    given = cases_of.Case(c, target, np.array(problem.lambdas), case.w, case.t, case.q)
    value = module.value_bounds(shared, given, room)
    y, z = reduction.G @ case.w - problem.X @ problem.o, reduction.K @ case.q
    norms = np.sqrt(np.einsum("i,ji->j", case.q, z))
    e = case.t @ z - case.w
    wrong = {"e": np.abs(room.e - e) > room.e_error, "low": room.low > norms, "high": room.high < norms}
    module._coupling(shared, given, value, room)
    for kind in ("coupling", "slack", "sign"):
        if kind != "coupling":
            module._slack(shared, given, value, kind == "sign", room)
        b = -2.0 * case.q if kind == "coupling" else 2.0 * y - room.v
        v = 2.0 * y - b
        reach = np.sqrt(np.einsum("i,jik,k->j", b, reduction.K, b))
        wrong[f"b, {kind}"] = np.abs(room.b - b) > room.b_error + 1e-15
        wrong[f"v, {kind}"] = np.abs(room.v - v) > room.v_error + 1e-15
        wrong[f"||X_i'b||, {kind}"] = room.reach < reach * (1 - 1e-12)
        wrong[f"q'K_i b, {kind}"] = room.pull < z @ b - 1e-12 * norms * reach
    return [name for name, false in wrong.items() if false.any()]


def contradictions(module: ModuleType) -> Iterator[str]:
    """Every statement of the bounds that is false."""
    for (index, case), signs in product(enumerate(ALL), product((-1, 1), (-1, 1))):
        bounds = judged(module, case, GAMMA, signs)
        slack = NOTICED * float(case.problem.o @ case.problem.o)
        where = f"case {index}, signs {signs}"
        if module is not reduced_bounds:
            yield from (f"{where}: {name} is not enclosed" for name in broken_enclosures(module, case, signs))
        if bounds.lower[0] > case.lowest * (1 + 1e-9) + slack:
            yield f"{where}: lower {bounds.lower[0]} > F* {case.lowest}"
        if bounds.upper[0] < case.value - slack:
            yield f"{where}: upper {bounds.upper[0]} < F(w, u) {case.value}"
        if bounds.gap[0] < case.value - case.lowest * (1 + 1e-9) - slack:
            yield f"{where}: gap {bounds.gap[0]} < {case.value - case.lowest}"
        if (bounds.zero_views[0] & (np.abs(case.best[0]) > 1e-4)).any():
            yield f"{where}: a view that is used is called zero"
        if (bounds.zero_modalities[0] & (case.best[1] > 1e-4)).any():
            yield f"{where}: a modality that is used is called zero"


def loose(module: ModuleType) -> Iterator[str]:
    """Every answer of the solver that is not proved to be optimal."""
    for index, case in enumerate(ALL):
        bounds = judged(module, case, 1e-12, (1, 1))
        width = bounds.upper[0] - bounds.lower[0]
        if case.solved and width > 1e-9 * bounds.upper[0]:
            yield f"case {index}: width {width}"


def test_the_true_code_contradicts_nothing_and_proves_every_optimum() -> None:
    true = interpreted()
    assert [*contradictions(true), *loose(true)] == []
    tight = [judged(true, case, 1e-12, (1, 1)) for case in ALL]
    assert any(b.zero_modalities.any() for b in tight)
    assert any(b.zero_views.any() for b in tight)


MUTANTS = {
    "the loss without its rounding": ("error = g * rho * rho + UNDERFLOW_SUM", "error = UNDERFLOW_SUM"),
    "half of the loss's rounding": (
        "error = g * rho * rho + UNDERFLOW_SUM",
        "error = 0.05 * g * rho * rho + UNDERFLOW_SUM",
    ),
    "the loss's rounding turned": ("max(0.0, loss + error)", "max(0.0, loss - error)"),
    "the lower loss's rounding turned": (
        "max(0.0, loss - error) + lambdas",
        "max(0.0, loss + error) + lambdas",
    ),
    "modality norms without rounding": ("error = g * tau * tau + UNDERFLOW_SUM", "error = UNDERFLOW_SUM"),
    "modality norms bounded on the wrong side": (
        "room.high[i] = np.sqrt(max(0.0, square) + error)",
        "room.high[i] = np.sqrt(max(0.0, square - error))",
    ),
    "v without rounding": (
        "room.v_error[a] = (\n            2.0 * shared.gamma",
        "room.v_error[a] = (\n            0.0 * shared.gamma",
    ),
    "b without rounding": ("room.b_error[a] = 2.0 * g *", "room.b_error[a] = 0.0 * g *"),
    "the reach of b without rounding": (
        "+ g * tau * tau + UNDERFLOW_SUM\n        room.reach",
        "+ UNDERFLOW_SUM\n        room.reach",
    ),
    "v not scaled into its box": ("s = two / worst * (1.0 - 16 * U)", "s = s"),
    "b not scaled into its balls": ("s = three / room.reach[i] * (1.0 - 16 * U)", "s = s"),
    "a scale beyond its limit": ("s = two / worst * (1.0 - 16 * U)", "s = 1.001 * two / worst"),
    "the loss term dropped": ("total = _square(1.0 - s) * value.loss + one", "total = one"),
    "the coupling term dropped": ("+ one * coupling + views", "+ views"),
    "the view term dropped": ("coupling + views + modalities", "coupling + modalities"),
    "the modality term dropped": ("+ views + modalities\n", "+ views\n"),
    "the view term with the wrong sign": (
        "toward = s * room.v[a] if w[a] > 0.0 else -s * room.v[a]",
        "toward = -s * room.v[a] if w[a] > 0.0 else s * room.v[a]",
    ),
    "the pull turned": ("s * room.pull[i]\n", "-s * room.pull[i]\n"),
    "the gap added to the lower bound": ("(value.lower - best)", "(value.lower + best)"),
    "half of the gap": ("(value.lower - best)", "(value.lower - 0.5 * best)"),
    "zero views without their radius": ("+ room.v_error[a]) + radius)", "+ room.v_error[a]))"),
    "zero modalities without their radius": ("(s * room.reach[i] + radius)", "(s * room.reach[i])"),
    "the root of the gap forgotten": ("root = 2.0 * np.sqrt(gap)", "root = 2.0 * gap"),
}


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_caught(name: str) -> None:
    mutant = interpreted(MUTANTS[name])
    assert any(chain(contradictions(mutant), loose(mutant))), name


def test_a_negative_t_is_refused() -> None:
    """The bounds take t >= 0: a negative norm would lower F."""
    lambdas, w, q = np.array([1.0, 0.1, 0.1]), np.array([0.5, 0.0]), np.array([0.2, -0.1])
    case = cases_of.Case(np.ones(2), 1.0, lambdas, w, np.array([0.0, 2.0]), q)
    assert reduced_bounds.in_range(case)
    assert reduced_bounds.in_range(case._replace(q=np.array([-2.0, 0.0])))
    for wrong in (-1e-300, -2.0, np.nan, np.inf, 2.0**101):
        assert not reduced_bounds.in_range(case._replace(t=np.array([0.0, wrong]))), wrong
