"""Small CVXPY problems with optimal values that were derived by hand, and the programs they become."""

from fractions import Fraction
from functools import cache

import cvxpy as cp
import numpy as np

from convexperc.conic.exchange import program_of

Q = np.array([1.0, -2.0, 0.5])
CENTRE = np.array([3.0, -0.25, 1.0])


def box():
    """q'x over [-1, 1]^3: -sum |q_j|."""
    x = cp.Variable(3)
    return cp.Problem(cp.Minimize(Q @ x), [x >= -1, x <= 1]), Fraction(-7, 2)


def simplex():
    """||x||^2 where the entries add up to 1: 1/4 for four of them."""
    x = cp.Variable(4)
    return cp.Problem(cp.Minimize(cp.sum_squares(x)), [cp.sum(x) == 1]), Fraction(1, 4)


def shifted():
    """A square and a constant: the constant."""
    x = cp.Variable(3)
    return cp.Problem(cp.Minimize(cp.sum_squares(x - CENTRE) + 5)), Fraction(5)


def lasso():
    """(x - a)^2 + l |x|: a^2 where 2 |a| <= l, else l |a| - l^2/4; here l = 1."""
    x = cp.Variable(3)
    objective = cp.sum_squares(x - CENTRE) + cp.norm1(x)
    return cp.Problem(cp.Minimize(objective)), Fraction(11, 4) + Fraction(1, 16) + Fraction(3, 4)


def group():
    """||x - a||^2 + l ||x|| with ||a|| = 5 and l = 2: l ||a|| - l^2/4."""
    x = cp.Variable(2)
    return cp.Problem(cp.Minimize(cp.sum_squares(x - [3.0, 4.0]) + 2 * cp.norm2(x))), Fraction(9)


def ball():
    """c'x where ||x|| <= 1, with ||c|| = 5."""
    x = cp.Variable(2)
    return cp.Problem(cp.Minimize(x @ [3.0, 4.0]), [cp.norm2(x) <= 1]), Fraction(-5)


def squared_ball():
    """The same, with the square of the norm, which becomes another cone."""
    x = cp.Variable(2)
    return cp.Problem(cp.Minimize(x @ [3.0, 4.0]), [cp.sum_squares(x) <= 1]), Fraction(-5)


def median():
    """The least sum of distances to 0, 1 and 5, reached at 1."""
    x = cp.Variable()
    return cp.Problem(cp.Minimize(cp.norm1(x - np.array([0.0, 1.0, 5.0])))), Fraction(5)


def midrange():
    """The least of the largest distances to 0, 1 and 5."""
    x = cp.Variable()
    return cp.Problem(cp.Minimize(cp.norm_inf(x - np.array([0.0, 1.0, 5.0])))), Fraction(5, 2)


def turned():
    """X1 + x2 where |x1 + 2 x2| <= 1 and |2 x1 - x2| <= 1: (1, 1) is 3/5 of one row and 1/5 of the other."""
    x = cp.Variable(2)
    B = np.array([[1.0, 2.0], [2.0, -1.0]])
    return cp.Problem(cp.Minimize(cp.sum(x)), [B @ x <= 1, -B @ x <= 1]), Fraction(-4, 5)


def line():
    """Least squares on (1, 1), (2, 2), (3, 2): residuals 1/6, -1/3, 1/6."""
    x = cp.Variable(2)
    X = np.array([[1.0, 1.0], [1.0, 2.0], [1.0, 3.0]])
    return cp.Problem(cp.Minimize(cp.sum_squares(X @ x - [1.0, 2.0, 2.0]))), Fraction(1, 6)


def coupled():
    """1/2 x'Bx - b'x with B = [[2, 1], [1, 2]] and b = (1, 1): -1/2 b'B^-1 b."""
    x = cp.Variable(2)
    B = np.array([[2.0, 1.0], [1.0, 2.0]])
    return cp.Problem(cp.Minimize(cp.quad_form(x, B) / 2 - cp.sum(x))), Fraction(-1, 3)


def singular():
    """(x1 + x2)^2 - x1 - x2, whose quadratic part is singular: -1/4."""
    x = cp.Variable(2)
    objective = cp.quad_form(x, np.ones((2, 2))) - cp.sum(x)
    return cp.Problem(cp.Minimize(objective), [x >= -1, x <= 1]), Fraction(-1, 4)


def maximum():
    """5 - (x - 1)^2 - |x|, to be maximised: 5 less 3/4."""
    x = cp.Variable()
    return cp.Problem(cp.Maximize(5 - cp.square(x - 1) - cp.abs(x))), Fraction(17, 4)


PROBLEMS = [
    box, simplex, shifted, lasso, group, ball, squared_ball, median, midrange, turned, line, coupled,
    singular, maximum,
]  # fmt: skip


@cache
def minimised(make):
    """The program that CVXPY makes for Clarabel, Clarabel's answer, and the optimal value of the program."""
    problem, optimum = make()
    data, chain, inverse = problem.get_problem_data(cp.CLARABEL)
    program = program_of(data, float(inverse[-1]["offset"]))
    raw = chain.solve_via_data(problem, data)
    return program, np.array(raw.x), np.array(raw.z), -optimum if make is maximum else optimum
