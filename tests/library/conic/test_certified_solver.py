"""`Certified` in CVXPY: intervals beside those of `convexperc.solve`, what is refused, and public reports."""

import math

import cvxpy as cp
import numpy as np
import pytest

from convexperc import solve
from convexperc.conic import Certified, interval
from convexperc.conic.reading import EXACT_ATOMS
from convexperc.errors import InputError, ToleranceError
from convexperc.solvers.conic import Model
from verification.problems import EXTREME, FAMILIES, seeded

SOLVERS = ("CLARABEL", "SCS", "OSQP")
ORDINARY = [name for name in FAMILIES if name not in EXTREME and not name.startswith("lambda")]
RNG = np.random.default_rng(0)
X, Y = RNG.standard_normal((12, 5)), RNG.standard_normal(12)


def solved(problem, solver="CLARABEL", **options):
    problem.solve(solver=Certified(solver), **options)
    return interval(problem)


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
@pytest.mark.parametrize("part", range(8))
def test_the_interval_meets_that_of_the_method(part):
    """25 problems each: the two intervals are proved in different ways, and both contain F*."""
    seen = narrow = 0
    for k in range(part, 8 * 40, 8):
        if seen == 25:
            break
        problem = seeded(ORDINARY[k % len(ORDINARY)], 7, k // len(ORDINARY), largest=(5, 12))
        if min(problem.lambdas) <= 0.0:
            continue
        model = Model.of(problem)
        model.assign(problem)
        try:
            found = solved(model.problem)
        except cp.error.SolverError:
            continue  # Clarabel gives up on a few with entries from 1e-9 to 1e9
        proved = solve(problem).certificate
        assert max(found.lower, proved.lower) <= min(found.upper, proved.upper), (k, found, proved)
        seen += 1
        narrow += found.upper - found.lower <= 1e-5 * float(problem.o @ problem.o)
    assert seen == 25
    assert narrow >= 15  # the others have entries of 1e-9 beside some of 1e9, or were given up early


def examples():
    x, t = cp.Variable(5), cp.Variable()
    R = X[:5]
    return {
        "lasso": cp.Problem(cp.Minimize(cp.sum_squares(X @ x - Y) + cp.norm1(x))),
        "bounded": cp.Problem(cp.Minimize(cp.sum_squares(X @ x - Y)), [x >= 0, x <= 0.1]),
        "portfolio": cp.Problem(cp.Maximize(Y[:5] @ x - cp.sum_squares(R @ x)), [cp.sum(x) == 1, x >= 0]),
        "huber": cp.Problem(cp.Minimize(cp.sum(cp.huber(X @ x - Y, 0.5)))),
        "least absolute": cp.Problem(cp.Minimize(cp.norm1(X @ x - Y))),
        "linear": cp.Problem(cp.Minimize(cp.sum(x)), [X @ x <= 1, X @ x >= -1]),
        "largest": cp.Problem(cp.Minimize(cp.max(X @ x - Y) + cp.maximum(t, 1) + cp.abs(t - 3))),
    }


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", examples())
def test_it_answers_as_the_solver_and_proves_an_interval(name, solver):
    problem = examples()[name]
    value = problem.solve(solver=solver)
    found = solved(problem, solver)
    assert problem.value == pytest.approx(value, rel=1e-9)
    assert found.lower <= found.upper
    assert found.lower - 1e-3 * abs(value) <= value <= found.upper + 1e-3 * abs(value)
    assert found.relative_gap < 1e-3, found.statement
    others = solved(examples()[name], "CLARABEL")
    assert max(found.lower, others.lower) <= min(found.upper, others.upper)
    assert problem.solver_stats.solver_name == f"CERTIFIED {solver}"


def test_group_lasso_by_a_conic_solver():
    x = cp.Variable(6)
    objective = cp.sum_squares(RNG.standard_normal((4, 6)) @ x - Y[:4]) + cp.norm2(x[:3]) + cp.norm2(x[3:])
    for solver in ("CLARABEL", "SCS"):
        assert solved(cp.Problem(cp.Minimize(objective)), solver).relative_gap < 1e-4


ATOMS = {
    "abs": lambda x: cp.abs(x[0]),
    "huber": lambda x: cp.sum(cp.huber(x, 0.75)),
    "max": cp.max,
    "maximum": lambda x: cp.maximum(x[0], x[1], 0.25),
    "min": lambda x: -cp.min(x),
    "minimum": lambda x: -cp.minimum(x[0], x[1]),
    "norm1": cp.norm1,
    "norm_inf": cp.norm_inf,
    "Pnorm": cp.norm2,
    "power": lambda x: cp.sum(cp.power(x, 2)),
    "quad_over_lin": lambda x: cp.quad_over_lin(x, 2.0),
    "QuadForm": lambda x: cp.quad_form(x, np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]])),
    "sum_largest": lambda x: cp.sum_largest(x, 2),
    "sum_squares": lambda x: 3 * cp.sum_squares(x - 1),
}


@pytest.mark.parametrize("name", ATOMS)
def test_the_canonical_form_has_the_value_of_the_atom(name):
    """CVXPY evaluates an expression without reducing it; with x held at a point it is the optimal value."""
    for _ in range(20):
        x, point = cp.Variable(3), RNG.integers(-200, 200, 3) / 64
        problem = cp.Problem(cp.Minimize(ATOMS[name](x)), [x == point])
        found = solved(problem)
        x.value = point
        value = float(problem.objective.value)
        room = 1e-12 * max(1.0, abs(value))
        assert found.lower - room <= value <= found.upper + room
        assert found.upper - found.lower <= 1e-6 * max(1.0, abs(value)), found.statement


def test_no_other_atoms_are_accepted():
    assert {*ATOMS, "PnormApprox", "Power", "PowerApprox"} - {"sum_squares"} == EXACT_ATOMS


def refused():
    x, t = cp.Variable(2), cp.Variable()
    S = cp.Variable((2, 2), PSD=True)
    return {
        "exp": (cp.Problem(cp.Minimize(cp.sum(cp.exp(x) + cp.exp(-x)))), "exp"),
        "semidefinite": (cp.Problem(cp.Minimize(cp.trace(S)), [S[0, 1] == 1]), "ExactCone2Cone"),
        "exponent": (cp.Problem(cp.Minimize(cp.pnorm(x - 1, 3) + cp.sum_squares(x))), "exponent 2"),
        "factorised": (cp.Problem(cp.Minimize(t), [cp.quad_form(x, np.eye(2)) <= t]), "sum_squares"),
        "infeasible": (cp.Problem(cp.Minimize(t), [t >= 1, t <= 0]), "infeasible"),
        "unbounded": (cp.Problem(cp.Minimize(t), [t <= 0]), "unbounded"),
        "complex": (cp.Problem(cp.Minimize(cp.abs(cp.Variable(complex=True) - 1j))), "Complex2Real"),
    }


@pytest.mark.parametrize("name", refused())
def test_what_is_not_covered_has_no_bound_and_says_why(name):
    problem, reason = refused()[name]
    found = solved(problem)
    assert (found.lower, found.upper) == (-math.inf, math.inf)
    assert reason in found.no_lower
    assert reason in found.no_upper
    assert reason in found.statement
    assert not found.certified


def test_a_geometric_program_is_not_taken_for_the_program_of_its_logarithms():
    x = cp.Variable(pos=True)
    problem = cp.Problem(cp.Minimize(x), [x >= 2])
    problem.solve(solver=Certified(cp.CLARABEL), gp=True)
    assert "Dgp2Dcp" in interval(problem).no_lower


def test_integer_variables_are_left_to_cvxpy_to_refuse():
    with pytest.raises(cp.error.SolverError, match="mixed-integer"):
        cp.Problem(cp.Minimize(cp.sum(cp.Variable(2, boolean=True)))).solve(solver=Certified(cp.CLARABEL))


def test_parameters_are_those_of_the_last_solve():
    x, weight = cp.Variable(3), cp.Parameter(nonneg=True)
    problem = cp.Problem(cp.Minimize(cp.sum_squares(x - 1) + weight * cp.norm1(x)))
    for value, optimum in ((1.0, 2.25), (2.0, 3.0), (4.0, 3.0)):
        weight.value = value
        found = solved(problem)
        assert found.lower <= optimum <= found.upper
        assert found.certified


def test_an_inequality_with_an_infinite_bound_is_none():
    x = cp.Variable(3)
    found = solved(
        cp.Problem(cp.Maximize(cp.sum(x)), [x >= 0, x <= np.array([1, 2, 3]), x <= np.array([np.inf, 1, 2])])
    )
    assert found.lower <= 4 <= found.upper
    assert found.relative_gap < 1e-6


def test_bad_arguments_are_named():
    for value in ("HIGHS", "clarabell"):
        with pytest.raises(InputError, match="solver must be one of 'CLARABEL', 'SCS', 'OSQP'"):
            Certified(value)
    for value in (-1.0, math.nan, math.inf):
        with pytest.raises(ToleranceError, match="relative_tolerance"):
            Certified("clarabel", relative_tolerance=value)
    problem = examples()["lasso"]
    for one in (problem, 3):
        with pytest.raises(InputError, match="solved by Certified"):
            interval(one)
    problem.solve(solver=cp.CLARABEL)
    with pytest.raises(InputError, match="solved by Certified"):
        interval(problem)


def test_the_tolerance_decides_what_is_certified():
    problem = examples()["lasso"]
    problem.solve(solver=Certified(cp.CLARABEL, relative_tolerance=1e-3))
    assert interval(problem).certified
    problem.solve(solver=Certified(cp.CLARABEL, relative_tolerance=0.0))
    assert not interval(problem).certified


# Public reports


def test_a_quadratic_program_that_osqp_calls_optimal_30_percent_above_the_optimum():
    """As in cvxpy#2554: x counts in ten thousands, its coefficient in the squares is 1/80000.

    Scaled by hand, x = 80000 y, the least value of sum (y_i + c_i)^2 is at a corner: by the order of c,
    y = (1/8, 1/8, 0, 1/8) with squares 1/1600, 81/1600, 256/1600 and 121/1600.
    """
    level = np.array([0.4, 0.6, 0.9, 0.1])
    optimum = 0.286875
    assert optimum == pytest.approx(float(np.sum((level - 0.5 + np.array([1, 1, 0, 1]) / 8) ** 2)))

    def posed():
        x = cp.Variable(4)
        objective = cp.sum_squares(level + x / 80000 - 0.5)
        return cp.Problem(cp.Minimize(objective), [x >= 0, x <= 10000, cp.sum(x) == 30000])

    first, second = posed(), posed()
    wrong, right = solved(first, "OSQP"), solved(second, "CLARABEL")
    assert first.status == second.status == "optimal"
    assert first.value > 1.3 * optimum
    assert not wrong.certified
    assert wrong.lower <= optimum * (1 + 1e-15)
    assert wrong.upper >= optimum
    assert right.certified
    assert right.upper < first.value
    assert right.lower <= optimum * (1 + 1e-15)
    assert right.upper >= optimum


def test_a_quadratic_program_that_osqp_calls_unbounded():
    """As in cvxpy#1489: coefficients around 1e-5; a bound from Clarabel shows that it is not."""
    n, slope = 6, np.array([5.0, 1.0, -3.0, 2.0, 8.0, 13.0])

    def posed():
        x = cp.Variable(n)
        objective = (0.5 * cp.quad_form(x, np.diag(np.arange(n) + 1.0)) - slope @ x) / 400000
        return cp.Problem(cp.Minimize(objective), [x[:-1] <= x[1:]])

    first, second = posed(), posed()
    nothing, found = solved(first, "OSQP"), solved(second, "CLARABEL")
    assert first.status == "unbounded"
    assert (nothing.lower, nothing.upper) == (-math.inf, math.inf)
    assert "unbounded" in nothing.no_lower
    assert -1e-3 < found.lower <= found.upper < 0.0
    assert found.relative_gap < 1e-2


def test_a_value_that_is_right_beside_a_point_that_is_not():
    """As in Clarabel.cpp#36: the least of a^2 + 2 b^2 - 2 a with a + b = 1 is -1, at (1, 0).

    The derivative along the constraint vanishes there, so that a point 1e-5 away has a value 1e-10 away.
    """
    x = cp.Variable(2, nonneg=True)
    problem = cp.Problem(cp.Minimize(cp.square(x[0]) + 2 * cp.square(x[1]) - 2 * x[0]), [cp.sum(x) == 1])
    found = solved(problem)
    assert found.lower <= -1.0 <= found.upper
    assert found.certified
    assert abs(x.value[0] - 1.0) > 10 * (found.upper - found.lower)
