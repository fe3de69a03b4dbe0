"""The enclosure of F* that is proved exactly, and the judgement of a certificate against it."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import fmpq_mat

from convexperc.certificate.certificate import Certificate
from convexperc.problem.problem import Problem
from verification.exact.balls import exact
from verification.exact.central_path import AGGRESSIVE, CONSERVATIVE, Central, Quadratic, follow
from verification.exact.formulation import objective
from verification.exact.numbers import Enclosure, Rationals, fractions, inner, objects, square_root, times
from verification.exact.problem import ExactProblem

ATTEMPTS = (
    *((80, AGGRESSIVE), (80, CONSERVATIVE)),
    *((250, AGGRESSIVE), (250, CONSERVATIVE)),
    (900, AGGRESSIVE),
)
"""Digits and step rule to try in turn: the longest arithmetic is for entries that span all of float64."""

TIGHT = Fraction(1, 10**25)
"""Relative width of F* that ends the search: far below anything that float64 certificates resolve."""

STRICT = Fraction(1, 10**15)
"""A proved zero needs |v_j| < lambda2; within this share of lambda2 the proof is contradicted."""


@dataclass(frozen=True, eq=False)
class Optimum:
    """lower <= F* <= upper, proved exactly, and the dual point behind it.

    Attributes
    ----------
    value : Enclosure
    w : Fractions (n,)
        The primal point with F <= upper.
    views : Fractions (n,)
        |X a - b|_j at the dual point, to be compared with lambda2.
    modalities : tuple of Enclosure
        ||X_i' b|| at the dual point, to be compared with lambda3.
    """

    value: Enclosure
    w: Rationals
    views: Rationals
    modalities: tuple[Enclosure, ...]

    @property
    def relative_width(self) -> Fraction:
        """(upper - lower) / upper; 0 where both are 0."""
        return self.value.width / self.value.upper if self.value.upper else Fraction(0)

    @property
    def tight(self) -> bool:
        """Whether the enclosure is as narrow as `TIGHT`."""
        return self.relative_width <= TIGHT


@dataclass(frozen=True, eq=False)
class Reduced:
    """All that F* depends on, in n dimensions: G = X X', c = X o, ||o||^2 and K_i = X_i X_i', exactly.

    Formula: u^i may be taken in the row space of X_i, so that u enters through X_i u^i and ||u^i|| alone.

    Attributes
    ----------
    G : Fractions (n, n)
    c : Fractions (n,)
    target : Fraction
    K : tuple of m Fractions (n, n)
    """

    G: Rationals
    c: Rationals
    target: Fraction
    K: tuple[Rationals, ...]

    @classmethod
    def of(cls, problem: Problem) -> "Reduced":
        """Multiply out."""
        data = ExactProblem.of(problem)
        X, o = np.array(data.rows, dtype=object), np.array(data.target, dtype=object)
        blocks = [X[:, group] for group in data.groups]
        K = tuple(fractions(B @ B.T, data.unit**2) for B in blocks)
        c = fractions(X @ o, data.unit * data.target_unit)
        return cls(sum(K[1:], K[0]), c, Fraction(o @ o, data.target_unit**2), K)


def optimum(problem: Problem, reduced: Reduced | None = None) -> Optimum:
    """Enclose F* by the referee's own method: exactly for least squares, else from an interior point.

    Parameters
    ----------
    problem : Problem
    reduced : Reduced, optional
        In place of the problem's own: the loss may have further columns, which u has not, and modalities may
        be missing from K.

    Returns
    -------
    Optimum
        Its bounds hold whatever happened on the way; `relative_width` says how tight they are.
    """
    reduced = Reduced.of(problem) if reduced is None else reduced
    lambda1, lambda2, lambda3 = (Fraction(x) for x in problem.lambdas)
    if reduced.target == 0:
        return _bounds(reduced, problem, _central(np.array([Fraction(0)] * problem.n)), None)
    if lambda1 and lambda3:
        quadratic = Quadratic(reduced.G, reduced.c, reduced.target, reduced.K, lambda1, lambda2, lambda3)
        return _tightest(reduced, problem, quadratic, None)
    P = _null_projector(sum(reduced.K[1:], reduced.K[0])) if lambda1 else None
    H = reduced.G if P is None else reduced.G + lambda1 * P
    if lambda2 == 0:
        return _bounds(reduced, problem, _central(_solve(reduced.G, reduced.c)), None)
    return _tightest(
        reduced, problem, Quadratic(H, reduced.c, reduced.target, (), lambda1, lambda2, lambda3), P
    )


def _tightest(reduced: Reduced, problem: Problem, quadratic: Quadratic, P: Rationals | None) -> Optimum:
    best = _bounds(reduced, problem, _central(np.array([Fraction(0)] * problem.n)), P)
    for digits, rule in ATTEMPTS:
        if best.tight:
            break
        found = _bounds(reduced, problem, follow(quadratic, digits, rule), P)
        best = min(best, found, key=lambda each: each.value.width)
    return best


def _central(w: Rationals) -> Central:
    none = np.array([], dtype=object)
    return Central(w, none, none)


def _bounds(reduced: Reduced, problem: Problem, point: Central, P: Rationals | None) -> Optimum:
    """Evaluate both sides exactly at one point.

    The dual point is s (a, b) with a = 2(X'w - o); b is the point's own, X a where lambda2 = 0 (then
    v = 0), -2 lambda1 P w where lambda3 = 0 (P projects on the null space of X'), or 0.
    """
    lambda1, lambda2, lambda3 = (Fraction(x) for x in problem.lambdas)
    w, zero = point.w, np.array([Fraction(0)] * problem.n)
    Gw = times(reduced.G, w)
    Xa = 2 * (Gw - reduced.c)
    pull = tuple(times(K, point.b) for K in reduced.K) if point.b.size else ()
    upper = _primal(reduced, problem, point, (Gw, pull), P)
    b = zero
    if lambda1 and lambda3:
        b = Xa if lambda2 == 0 else (point.b if point.b.size else zero)
    elif lambda1 and P is not None:
        b = -2 * lambda1 * times(P, w)
    views = np.array([abs(x) for x in Xa - b], dtype=object)
    norms = [square_root(inner(b, times(K, b))) for K in reduced.K] if lambda1 and lambda3 and any(b) else []
    linear = 2 * (reduced.target - inner(reduced.c, w))
    square = (
        inner(w, Gw)
        - 2 * inner(reduced.c, w)
        + reduced.target
        + (inner(b, b) / (4 * lambda1) if lambda1 else 0)
    )
    limits = [lambda2 / x for x in views if x] + [lambda3 / x.upper for x in norms if x.upper]
    s = min([linear / (2 * square) if square else Fraction(1), *limits])
    lower = max(Fraction(0), s * linear - s * s * square) if s > 0 else Fraction(0)
    modalities = tuple(Enclosure(s * x.lower, s * x.upper) for x in norms)
    return Optimum(Enclosure(lower, upper), w, s * views, modalities)


def _primal(
    reduced: Reduced,
    problem: Problem,
    point: Central,
    products: tuple[Rationals, tuple[Rationals, ...]],
    P: Rationals | None,
) -> Fraction:
    """An upper bound of min_u F(w, u), exactly: u^i = -rho_i X_i'b, or Xu = w as far as it goes, or u = 0."""
    lambda1, lambda2, lambda3 = (Fraction(x) for x in problem.lambdas)
    w, (Gw, pull) = point.w, products
    value = (
        inner(w, Gw)
        - 2 * inner(reduced.c, w)
        + reduced.target
        + lambda2 * sum((abs(x) for x in w), Fraction(0))
    )
    if not (lambda1 and lambda3):
        return value + (lambda1 * inner(w, times(P, w)) if P is not None else 0)
    Xu = np.array([Fraction(0)] * problem.n)
    for rho, Kb in zip(point.rho, pull, strict=True) if pull else ():
        Xu = Xu - rho * Kb
        value += lambda3 * abs(rho) * square_root(inner(point.b, Kb)).upper
    q = Xu - w
    return min(value + lambda1 * inner(q, q), reduced.target)


def _solve(G: Rationals, c: Rationals) -> Rationals:
    """Return one w with G w = c exactly (c lies in the range of G)."""
    form, pivots = _echelon(np.concatenate([G, c[:, None]], axis=1))
    w = np.array([Fraction(0)] * len(c))
    w[pivots] = form[: len(pivots), -1]
    return w


def _null_projector(G: Rationals) -> Rationals | None:
    """Return the orthogonal projector on {b : G b = 0}, or None where that is {0}."""
    form, pivots = _echelon(G)
    free = [j for j in range(len(G)) if j not in pivots]
    if not free:
        return None
    N = np.array([[Fraction(0)] * len(free) for _ in G])
    N[free, range(len(free))] = Fraction(1)
    N[pivots] = -form[: len(pivots), free]
    basis = _matrix(N)
    across = basis.transpose()
    return _array(basis * (across * basis).solve(across))


def _echelon(A: Rationals) -> tuple[Rationals, list[int]]:
    """Reduced row echelon form over the rationals, and its pivot columns."""
    form, rank = _matrix(A).rref()
    work = _array(form)
    return work, [int(np.flatnonzero(row)[0]) for row in work[:rank]]


def _matrix(A: Rationals) -> fmpq_mat:
    return fmpq_mat([[exact(x) for x in row] for row in A])


def _array(A: fmpq_mat) -> Rationals:
    return objects([Fraction(int(x.numer()), int(x.denom())) for x in A.entries()], (A.nrows(), A.ncols()))


def violations(
    problem: Problem, w: np.ndarray, u: np.ndarray, certificate: Certificate, truth: Optimum
) -> list[str]:
    """Compare every statement of a certificate with the truth; each entry names one that is false.

    Parameters
    ----------
    problem : Problem
    w, u : float64 (n,), (d,)
        The point that was judged.
    certificate : Certificate
    truth : Optimum

    Returns
    -------
    list of str
        Empty if nothing is contradicted.
    """
    found = []
    low, high = truth.value.lower, truth.value.upper
    if not _at_most(certificate.lower, high):
        found.append(f"lower {certificate.lower!r} > F* {float(high)!r}")
    if not _at_least(certificate.upper, low):
        found.append(f"upper {certificate.upper!r} < F* {float(low)!r}")
    if np.isfinite(w).all() and np.isfinite(u).all():
        found += _false_of_the_point(objective(problem, w, u), certificate, truth)
    lambda2, lambda3 = Fraction(problem.lambda2), Fraction(problem.lambda3)
    for j in np.flatnonzero(certificate.zero_views):
        if truth.tight and truth.views[j] >= lambda2 * (1 - STRICT):
            found.append(f"w*_{j} = 0 is not so: |v_j| = lambda2, w_j = {float(truth.w[j])!r}")
    for i in np.flatnonzero(certificate.zero_modalities):
        if truth.tight and truth.modalities and truth.modalities[i].lower >= lambda3 * (1 - STRICT):
            found.append(f"u*^{i} = 0 is not so: ||X_i'b|| = lambda3")
    return found


def _false_of_the_point(value: Enclosure, certificate: Certificate, truth: Optimum) -> list[str]:
    found = []
    low, high = certificate.objective
    if not (_at_most(low, value.upper) and _at_least(high, value.lower)):
        found.append(f"objective {certificate.objective} misses F(w, u)")
    gap = value.lower - truth.value.upper
    if not _at_least(certificate.gap, gap):
        found.append(f"gap {certificate.gap!r} < F(w, u) - F*")
    if gap > 0 and not _at_least(
        certificate.relative_gap, gap / truth.value.upper if truth.value.upper else None
    ):
        found.append(f"relative gap {certificate.relative_gap!r} is too small")
    if certificate.certified and gap > 0 and not _within(gap, certificate, truth):
        found.append("certified, but beyond both tolerances")
    return found


def _within(gap: Fraction, certificate: Certificate, truth: Optimum) -> bool:
    relative = Fraction(certificate.relative_tolerance) * truth.value.upper
    return gap <= relative or certificate.share_of_target <= certificate.absolute_tolerance


def _at_most(number: float, bound: Fraction) -> bool:
    return number == -np.inf or (bool(np.isfinite(number)) and Fraction(number) <= bound)


def _at_least(number: float, bound: Fraction | None) -> bool:
    if bound is None:
        return number == np.inf
    return number == np.inf or (bool(np.isfinite(number)) and Fraction(number) >= bound)
