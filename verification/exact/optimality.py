"""The optimality conditions and F* of a problem over the rationals.

A second derivation: it uses no formula of `convexperc`.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

from convexperc.errors import ProblemError
from verification.exact.formulation import residuals
from verification.exact.numbers import Enclosure, Rational, inner, squares
from verification.exact.problem import ExactProblem
from verification.exact.referee import optimum


def is_optimal(problem: ExactProblem, w: Rational, u: Rational, held: Sequence[int] = ()) -> bool:
    """Whether (w, u) minimises F among the points that are 0 where it is held, decided exactly.

    F is convex, so a subgradient that vanishes is proof: with a = 2(X'w - o) and b = 2 lambda1 (Xu - w),
    (Xa - b)_j = -lambda2 sign(w_j), or at most lambda2 in size where w_j = 0, and
    X_i'b = -lambda3 u^i / ||u^i||, or at most lambda3 in length where u^i = 0.

    Parameters
    ----------
    problem : ExactProblem
    w, u : Fractions (n,), (d,)
    held : sequence of int
        Positions in (w, u) that are held at 0; of u, only whole modalities.

    Returns
    -------
    bool
    """
    p, q = residuals(problem, w, u)
    a = tuple(2 * x for x in p)
    b = tuple(2 * problem.lambda1 * x for x in q)
    if any((*w, *u)[j] for j in held):
        return False
    views = all(
        _balanced([inner(row, a) - b[j]], [w[j]], problem.lambda2)
        for j, row in enumerate(problem.X)
        if j not in held
    )
    pull = [inner(column, b) for column in problem.columns]
    return views and all(
        _balanced([pull[k] for k in group], [u[k] for k in group], problem.lambda3)
        for group in problem.groups
        if problem.n + group[0] not in held
    )


def _balanced(slope: Sequence[Fraction], point: Sequence[Fraction], weight: Fraction) -> bool:
    """Whether 0 lies in slope + weight times the subdifferential of the length at `point`."""
    if not any(point):
        return squares(slope) <= weight * weight
    parallel = squares(slope) * squares(point) == inner(slope, point) ** 2
    opposite = inner(slope, point) <= 0 if weight else not any(slope)
    return parallel and opposite and squares(slope) == weight * weight


def optimum_bounds(problem: ExactProblem) -> Enclosure:
    """Enclose F*, proved: the referee's interval of the same problem in whole numbers, scaled back.

    Raises
    ------
    ProblemError
        The whole numbers do not fit into float64.
    """
    found = problem.in_floats()
    if found is not None:
        return optimum(found).value
    s = lcm(problem.unit, problem.lambda1.denominator)
    weights = problem.lambda2 * s, problem.lambda3 * s * s
    t = lcm(problem.target_unit, *(x.denominator for x in weights))
    whole = problem.scaled(Fraction(s), Fraction(t)).in_floats()
    if whole is None:
        remedy = "Give data with smaller denominators."
        raise ProblemError("rational data", value=problem, must="must fit into float64", remedy=remedy)
    bounds = optimum(whole).value
    return Enclosure(bounds.lower / t**2, bounds.upper / t**2)
