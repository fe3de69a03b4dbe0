"""Planted faults in the bounds of a lasso from reduced data: each is caught, and the true code is not.

The rounding of G, K and c is played by an adversary, as in `test_planted_reduced`.
"""

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, product
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from convexperc import solve_many
from convexperc.certificate import cases as cases_of
from convexperc.certificate import lasso as lasso_bounds
from convexperc.certificate import reduced as reduced_bounds
from convexperc.problem.formulation import objective
from convexperc.problem.problem import Problem
from convexperc.problem.reduction import Reduction
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.newton.method import lassos

GAMMA = 1e-3
LAMBDAS = (
    (0.5, 0.3, 0.0),
    (0.0, 0.3, 0.2),
    (0.7, 0.0, 0.0),
    (0.0, 0.0, 0.1),
    (0.0, 0.2, 0.0),
    (2.0, 1.5, 0.0),
    (0.5, 0.5, 0.3),
    (0.01, 0.2, 0.02),
)
"""The last two are coupled: the lasso lies below F, and is not its optimum."""
NOTICED = 1e-9
PLAIN = ("in_range", "value_bounds")


def plain(module: ModuleType, *changes: tuple[str, str]) -> ModuleType:
    """The module as plain Python, with pieces of its source replaced."""
    source = inspect.getsource(module)
    for old, new in changes:
        assert source.count(old) >= 1, old
        source = source.replace(old, new)
    copy = ModuleType("mutant")
    copy.__dict__["__name__"] = module.__name__
    exec(compile(source, "mutant", "exec"), copy.__dict__)
    return copy


def interpreted(*changes: tuple[str, str]) -> ModuleType:
    """As plain Python; its `Distinct` is one of the library's, so that the library takes it."""
    kin = (
        "class Distinct:",
        "class Distinct(__import__('convexperc.certificate.lasso').certificate.lasso.Distinct):",
    )
    copy, below = plain(lasso_bounds, kin, *changes), plain(reduced_bounds)
    copy.__dict__.update({name: getattr(below, name) for name in PLAIN})
    return copy


@dataclass(frozen=True, eq=False)
class Frame:
    """One problem, what is known of its optimum by another way, and its reduced data, undisturbed."""

    problem: Problem
    lowest: float
    highest: float
    best: np.ndarray
    reduction: Reduction

    def shared(self, gamma: float, toward: np.ndarray, signs: tuple[int, int]) -> tuple[Any, Any, Any]:
        """GramBounds data, c and ||o||^2, off by all that `gamma` allows."""
        lengths = np.sqrt(np.einsum("ijj->ij", self.reduction.K))
        rows, omega = np.linalg.norm(self.problem.X, axis=1), float(np.linalg.norm(self.problem.o))
        moved = 0.98 * gamma * signs[0]
        G = self.reduction.G + moved * np.outer(toward * rows, toward * rows)
        c = self.problem.X @ self.problem.o + 0.98 * gamma * signs[1] * toward * rows * omega
        grow = 1.0 + gamma
        blocks = np.sqrt((lengths**2).sum(axis=1))
        data = G, self.reduction.K, grow * lengths, grow * rows, grow * blocks, gamma
        return cases_of.GramBounds(*data), c[None], np.array([omega**2 * (1 + moved)])


def frames() -> Iterator[Frame]:
    rng = np.random.default_rng(11)
    for index, lambdas in enumerate(LAMBDAS):
        for repeated in (False, True):
            X = rng.standard_normal((2 + index % 2, 5))
            X = X[[0, 1, 0, -1]] if repeated else X
            X = X / (1.1 * np.linalg.norm(X, axis=1).max())
            o = X.T @ rng.standard_normal(len(X)) + 0.3 * rng.standard_normal(5)
            o *= 0.9 / np.linalg.norm(o)
            names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
            problem = Problem(X, o, modalities=[2, 3], **names)
            found = solve(problem, relative_tolerance=1e-10)
            assert found.status is Status.CERTIFIED
            proof = found.certificate
            yield Frame(
                problem, proof.lower, proof.upper, found.w, Reduction.of(problem.X, problem.modalities)
            )


ALL = tuple(frames())


def answered(module: ModuleType, frame: Frame, gamma: float, signs: tuple[int, int], kind: int) -> Any:
    """The bounds of the solver's point (kind 0) or of a worse one, with the point's own objective."""
    toward = np.sign(frame.best) + (frame.best == 0)
    shared, c, target = frame.shared(gamma, toward, signs)
    distinct = module.Distinct.of(frame.problem.X, shared)
    if distinct.floor == 0.0:
        return None
    lambdas = np.array([frame.problem.lambdas])
    merged = lassos(distinct.shared.G, distinct.merged(c), distinct.counts, lambdas)
    W, Q = (distinct.spread(part) for part in merged)
    T = np.full((1, 2), float(lambdas[0, 0] > 0.0))
    if kind == 1:
        W *= 1.01
    if kind == 2:
        W, Q, T = 0 * W, 0 * Q, 0 * T
    if kind == 3:
        W[0, 0] += 0.05
    if kind == 4:  # where the first and the third view are equal, their sum stays
        W[0, 0], W[0, W.shape[1] // 2] = W[0, 0] + 2.0, W[0, W.shape[1] // 2] - 2.0
    bounds = module.bound_merged(distinct, shared, c, target, lambdas, W, T, Q)
    value = float(objective(frame.problem, W[0], frame.reduction.recover(T[0], Q[0])))
    return bounds, value


def contradictions(module: ModuleType) -> Iterator[str]:
    """Every statement of the bounds that is false; the solver's point is not proved: counts as one too."""
    for (index, frame), signs in product(enumerate(ALL), product((-1, 1), (-1, 1))):
        slack = NOTICED * float(frame.problem.o @ frame.problem.o)
        for kind, gamma in (
            (0, GAMMA),
            (1, GAMMA),
            (2, GAMMA),
            (3, GAMMA),
            (0, 1e-13),
            (1, 1e-13),
            (4, 1e-13),
        ):
            got = answered(module, frame, gamma, signs, kind)
            if got is None:
                continue
            (bounds, value), where = got, f"frame {index}, signs {signs}, kind {kind}, gamma {gamma}"
            if bounds.lower[0] > frame.highest + slack:
                yield f"{where}: lower {bounds.lower[0]} > F* {frame.highest}"
            if bounds.upper[0] < value - slack:
                yield f"{where}: upper {bounds.upper[0]} < F(w, u) {value}"
            if bounds.gap[0] < value - frame.highest - slack:
                yield f"{where}: gap {bounds.gap[0]} < {value - frame.highest}"
            if (bounds.zero_views[0] & (np.abs(frame.best) > 1e-6)).any():
                yield f"{where}: a view that is used is called zero"
            if bounds.zero_modalities[0].any() and not frame.problem.lambda1 == 0.0 < frame.problem.lambda3:
                yield f"{where}: a modality is called zero that need not be"
            width = bounds.upper[0] - bounds.lower[0]
            coupled = frame.problem.lambda1 * frame.problem.lambda3 > 0.0
            if gamma < GAMMA and kind == 0 and not coupled and width > 1e-9 * bounds.upper[0] + slack:
                yield f"{where}: width {width}"


def test_the_true_code_contradicts_nothing_and_proves_every_optimum() -> None:
    true = interpreted()
    assert list(contradictions(true)) == []
    judged = [answered(true, frame, 1e-13, (1, 1), 0) for frame in ALL]
    assert all(found is not None for found in judged)
    assert any(bounds.zero_views.any() for bounds, _ in judged)
    assert any(bounds.zero_modalities.any() for bounds, _ in judged)
    assert sum(answered(true, frame, GAMMA, (1, 1), 0) is not None for frame in ALL) > 6


MUTANTS = {
    "the pull without its rounding": (
        "left = abs(pull + v) + error + 8 * U * (abs(pull) + two)",
        "left = abs(pull + v)",
    ),
    "the deficit dropped": ("gap = (deficit + coupled", "gap = (0.0 * deficit + coupled"),
    "a tenth of the deficit": ("deficit *= 0.25 / floor", "deficit *= 0.025 / floor"),
    "the coupling of the point dropped": ("case.lambdas[0] * far", "0.0 * far"),
    "the modality norms of the point dropped": ("case.lambdas[2] * norms", "0.0 * norms"),
    "the gap added to the lower bound": ("(value.lower - gap)", "(value.lower + gap)"),
    "the sign of w forgotten": ("if case.w[a] != 0.0:", "if False:"),
    "the wrong sign of w": ("v = two if case.w[a] > 0.0 else -two", "v = -two if case.w[a] > 0.0 else two"),
    "v beyond its box": ("v = min(max(-pull, -two), two)", "v = -pull"),
    "zero views without their radius": ("error + root * shared.rows[a]", "error"),
    "zero modalities whatever lambda3 is": (" and case.lambdas[2] > 0.0", ""),
    "equal views kept apart": ("if len(seen) == n:", "if True:"),
    "equal views with their whole weight each": ("(W / self.counts)", "(W)"),
    "the lower bound of the equal views kept": ("lower=merged.lower, gap=gap,", "gap=gap,"),
    "the gap of the equal views kept": ("lower=merged.lower, gap=gap,", "lower=merged.lower,"),
    "the smallest eigenvalue ten times as large": (
        "return smallest_eigenvalue(shared.G, error)",
        "return 10.0 * smallest_eigenvalue(shared.G, error)",
    ),
}


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_caught(name: str) -> None:
    mutant = interpreted(MUTANTS[name])
    unproved = (answered(mutant, frame, 1e-13, (1, 1), 0) is None for frame in ALL)
    assert any(chain(contradictions(mutant), unproved)), name


@pytest.mark.parametrize("lambdas", [(0.3, 0.2, 0.0), (0.0, 0.2, 0.1), (0.3, 0.0, 0.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("places", [[0, 1, 2], [0, 1, 0, 2, 0], [1, 1]])
def test_no_template_is_left_to_be_solved_alone_where_views_are_equal_or_independent(
    lambdas: tuple[float, float, float], places: list[int]
) -> None:
    rng = np.random.default_rng(3)
    X, O = rng.random((3, 20))[places], rng.random((20, 6))
    names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
    found = solve_many(X, O, modalities=[5, 9, 6], **names)
    assert not found.singles
    assert found.certified.all()
    for j in range(6):
        proof = solve(found.problem(j)).certificate
        assert found.lower[j] <= proof.upper
        assert proof.lower <= found.upper[j]
        assert abs(float(objective(found.problem(j), found.w[j], found.u(j))) - found.upper[j]) < 1e-9
        assert found.solution(j).certificate.certified
