"""Bounds of cone programs from good and from bad points, against optimal values that are known as rationals.

Each part of the proof is left out or falsified once, and the same check has to see it.
"""

import math
from dataclasses import replace
from fractions import Fraction

import cvxpy as cp
import numpy as np
import pytest
import scipy.sparse as sp
from exact_programs import PROBLEMS, box, minimised, simplex

from convexperc.conic import boxes, curvature, dual, primal, program, proof
from convexperc.conic.boxes import Box, level_box
from convexperc.conic.curvature import is_positive_semidefinite

TOLERANCE = 1e-6
DISTURBANCES = (0.0, 1e-9, 1e-3, 1.0)
"""How far the points are from Clarabel's; none of them may make a bound wrong."""


def never(b):
    """No second answer."""
    return


def wrong_bounds():
    """The intervals without the optimal value, over all problems and disturbances."""
    for k, make in enumerate(PROBLEMS):
        rng = np.random.default_rng(k)
        given, x, z, optimum = minimised(make)
        for size in DISTURBANCES:
            for _ in range(4):
                near = x + size * rng.standard_normal(x.size), z + size * rng.standard_normal(z.size)
                found = proof.prove(given, *near, never, TOLERANCE)
                if not (found.lower <= optimum <= found.upper):
                    yield make.__name__, size, found, optimum


def test_no_point_makes_a_bound_wrong():
    assert list(wrong_bounds()) == []


@pytest.mark.parametrize("make", PROBLEMS)
def test_the_answer_of_the_solver_gives_a_narrow_interval(make):
    given, x, z, optimum = minimised(make)
    found = proof.prove(given, x, z, again(make), TOLERANCE)
    assert found.lower <= optimum <= found.upper
    assert found.certified, found.statement
    assert not found.no_lower + found.no_upper


def again(make):
    """Solve the problem with another b, by Clarabel."""
    problem, _ = make()
    data, chain, _ = problem.get_problem_data(cp.CLARABEL)
    return lambda b: np.array(chain.solve_via_data(problem, {**data, "b": b}).x)


def outside_of_the_dual_cone(patch):
    patch.setattr(dual, "in_dual_cone", lambda program, z: list(z))


def residual_left_out(patch):
    patch.setattr(dual, "_least", lambda terms, j, r, x: r * 0)


def half_the_box(patch):
    def half(*arguments):
        found = level_box(*arguments)
        return Box(found.lower / 2, found.upper / 2)

    patch.setattr(proof, "level_box", half)


def offset_forgotten(patch):
    patch.setattr(program.ConeProgram, "objective", objective_without_offset)


def objective_without_offset(self, x):
    return program.inner(x, program.times(self.P, x)) / 2 + program.inner(program.exact(self.q), x)


def quadratic_part_dropped_below(patch):
    def without(A, x):
        return program.times(A * 0.0 if A.shape[0] == A.shape[1] else A, x)

    patch.setattr(dual, "times", without)


def sign_of_b(patch):
    true = dual.lower_bound

    def turned(terms, x, z):
        given = terms.program
        return true(replace(terms, program=replace(given, b=-given.b)), x, z)

    patch.setattr(proof, "lower_bound", turned)


def feasible_by_decree(patch):
    patch.setattr(primal.Repair, "violation", lambda self, found: 0.0)


def curvature_doubled(patch):
    true = curvature.curvature
    patch.setattr(proof, "curvature", lambda P: 2 * true(P))


def change_left_out(patch):
    patch.setattr(dual, "_changed", lambda terms, z, r, columns: z)


def sum_of_rows_with_its_sign_lost(patch):
    true = boxes._sums
    patch.setattr(boxes, "_sums", lambda A, b, C, d: (-true(A, b, C, d)[0], true(A, b, C, d)[1]))


FAULTS = [
    outside_of_the_dual_cone, residual_left_out, half_the_box, offset_forgotten, quadratic_part_dropped_below,
    sign_of_b, feasible_by_decree, curvature_doubled, change_left_out, sum_of_rows_with_its_sign_lost,
]  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_makes_a_bound_wrong(fault, monkeypatch):
    fault(monkeypatch)
    assert next(wrong_bounds(), None) is not None


def test_no_value_is_taken_for_a_bound():
    """NaN compares with nothing, so that min and max would let it pass."""
    given, x, z, _ = minimised(simplex)
    found = proof.prove(given, x * math.nan, z, never, TOLERANCE)
    assert (found.lower, found.upper) == (-math.inf, math.inf)
    assert "not finite" in found.no_lower
    assert not found.certified


def test_the_optimal_value_is_above_a_level_below_which_nothing_is_feasible(monkeypatch):
    """Without an upper bound the level is a guess, and the bound is the lower of the two."""
    given, x, z, optimum = minimised(box)
    monkeypatch.setattr(proof, "_upper", lambda *_: (math.inf, "left out"))
    below = proof.prove(given, x - 10.0 * np.sign(x), z, never, TOLERANCE)
    assert -math.inf < below.lower <= optimum
    assert below.no_upper == "left out"


@pytest.mark.parametrize("seed", range(20))
def test_the_diagonal_below_a_matrix_is_below_it(seed):
    rng = np.random.default_rng(seed)
    R = rng.integers(-3, 4, (rng.integers(1, 5), 5)).astype(float)
    B = R.T @ R + (seed % 3) * np.eye(5)
    found = curvature.curvature(sp.csr_array(B))
    assert is_positive_semidefinite(B)
    shifted = [
        [Fraction(v) - (Fraction(found[i]) if i == j else 0) for j, v in enumerate(line)]
        for i, line in enumerate(B)
    ]
    assert all(minor >= 0 for minor in leading_minors(shifted))
    least = float(np.linalg.eigvalsh(B)[0])
    assert np.all(found <= least + 1e-9)
    assert np.all(found >= min(least, 0.0) - 1e-9)


def leading_minors(M):
    """Determinants of the leading blocks, by elimination as far as the pivots are positive."""
    M, found = [list(line) for line in M], []
    for k in range(len(M)):
        found.append(M[k][k])
        if M[k][k] <= 0:
            break
        for i in range(k + 1, len(M)):
            factor = M[i][k] / M[k][k]
            M[i] = [a - factor * b for a, b in zip(M[i], M[k], strict=True)]
    return found


def test_a_matrix_that_is_not_quite_semidefinite_is_seen():
    ones = np.ones((4, 4))
    assert is_positive_semidefinite(ones)
    assert is_positive_semidefinite(np.zeros((3, 3)))
    less = ones - 2.0**-50 * np.eye(4)
    assert not is_positive_semidefinite(less)
    assert np.all(curvature.curvature(sp.csr_array(less)) < 0.0)
    assert not is_positive_semidefinite(np.array([[0.0, 1.0], [1.0, 0.0]]))
