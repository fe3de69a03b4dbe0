"""F, its optimality conditions and F* of a problem over the rationals.

A second derivation: it uses no formula of `convexperc`.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

from convexperc.errors import ProblemError
from verification.exact.oracles import Enclosure, square_root
from verification.exact.problem import ExactProblem, Rational
from verification.exact.referee import optimum


def dot(x: Sequence[Fraction], y: Sequence[Fraction]) -> Fraction:
    """The exact inner product."""
    return sum((a * b for a, b in zip(x, y, strict=True)), Fraction(0))


def residuals(problem: ExactProblem, w: Rational, u: Rational) -> tuple[Rational, Rational]:
    """Return p = X'w - o, shape (d,), and q = Xu - w, shape (n,)."""
    p = tuple(dot(column, w) - target for column, target in zip(problem.columns, problem.o, strict=True))
    q = tuple(dot(row, u) - weight for row, weight in zip(problem.X, w, strict=True))
    return p, q


def value(problem: ExactProblem, w: Rational, u: Rational) -> Enclosure:
    """Enclose F(w, u) at a rational point; exact where the norms of the u^i are rational."""
    p, q = residuals(problem, w, u)
    smooth = dot(p, p) + problem.lambda1 * dot(q, q) + problem.lambda2 * sum(map(abs, w), Fraction(0))
    roots = [rational_root(dot(v, v)) for v in ([u[j] for j in group] for group in problem.groups)]
    low, high = (sum((getattr(r, end) for r in roots), Fraction(0)) for end in ("lower", "upper"))
    return Enclosure(smooth + problem.lambda3 * low, smooth + problem.lambda3 * high)


def rational_root(square: Fraction) -> Enclosure:
    """Enclose sqrt(square); exact if the root is rational, not only if it is dyadic."""
    whole = square_root(Fraction(square.numerator * square.denominator))
    return Enclosure(whole.lower / square.denominator, whole.upper / square.denominator)


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
        _balanced([dot(row, a) - b[j]], [w[j]], problem.lambda2)
        for j, row in enumerate(problem.X)
        if j not in held
    )
    pull = [dot(column, b) for column in problem.columns]
    return views and all(
        _balanced([pull[k] for k in group], [u[k] for k in group], problem.lambda3)
        for group in problem.groups
        if problem.n + group[0] not in held
    )


def _balanced(slope: Sequence[Fraction], point: Sequence[Fraction], weight: Fraction) -> bool:
    """Whether 0 lies in slope + weight times the subdifferential of the length at `point`."""
    if not any(point):
        return dot(slope, slope) <= weight * weight
    parallel = dot(slope, slope) * dot(point, point) == dot(slope, point) ** 2
    opposite = dot(slope, point) <= 0 if weight else not any(slope)
    return parallel and opposite and dot(slope, slope) == weight * weight


def optimum_bounds(problem: ExactProblem) -> Enclosure:
    """Enclose F*, proved: the referee's interval of the same problem in whole numbers, scaled back.

    Formula: X by s, o by t, lambda1 by s^2, lambda2 by s t, lambda3 by s^2 t multiply F* by t^2.

    Raises
    ------
    ProblemError
        The whole numbers do not fit into float64.
    """
    found = problem.in_floats()
    if found is not None:
        return optimum(found).value
    s = lcm(*(x.denominator for row in problem.X for x in row), problem.lambda1.denominator)
    scaled_weights = (problem.lambda2 * s, problem.lambda3 * s * s)
    t = lcm(*(x.denominator for x in (*problem.o, *scaled_weights)))
    X = tuple(tuple(x * s for x in row) for row in problem.X)
    o = tuple(x * t for x in problem.o)
    l1, l2, l3 = problem.lambda1 * s * s, problem.lambda2 * s * t, problem.lambda3 * s * s * t
    whole = ExactProblem(X, o, problem.groups, l1, l2, l3).in_floats()
    if whole is None:
        remedy = "Give data with smaller denominators."
        raise ProblemError("rational data", value=problem, must="must fit into float64", remedy=remedy)
    bounds = optimum(whole).value
    return Enclosure(bounds.lower / t**2, bounds.upper / t**2)
