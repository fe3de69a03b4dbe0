"""The enclosure of F* that is proved exactly, and the judgement of a certificate against it."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from convexperc.certificate.certificate import Certificate
from convexperc.problem.problem import Problem
from verification.exact.central_path import AGGRESSIVE, CONSERVATIVE, Central, follow
from verification.exact.formulation import objective
from verification.exact.numbers import Enclosure, Rationals, inner, square_root, times, total
from verification.exact.problem import ExactProblem
from verification.exact.reduced import Reduced

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


def optimum(problem: Problem | ExactProblem | Reduced) -> Optimum:
    """Enclose F* by the referee's own method: exactly for least squares, else from an interior point.

    Parameters
    ----------
    problem : Problem, ExactProblem or Reduced
        Of a `Reduced` the loss may have further columns, which u has not, and a K_i may be 0.

    Returns
    -------
    Optimum
        Its bounds hold whatever happened on the way; `relative_width` says how tight they are.
    """
    reduced = problem if isinstance(problem, Reduced) else Reduced.of(problem)
    if reduced.target and not reduced.coupled and reduced.lambda2 == 0:
        return _bounds(reduced, Central(reduced.least_squares()))
    best = _bounds(reduced, Central(reduced.zero))
    for digits, rule in ATTEMPTS if reduced.target else ():
        if best.tight:
            break
        found = _bounds(reduced, follow(reduced, digits, rule))
        best = min(best, found, key=lambda each: each.value.width)
    return best


def _bounds(reduced: Reduced, point: Central) -> Optimum:
    """Evaluate both sides exactly at one point; the dual point is s (a, b) with a = 2(X'w - o)."""
    w, Gw = point.w, times(reduced.G, point.w)
    Xa, loss = 2 * (Gw - reduced.c), inner(w, Gw) - 2 * inner(reduced.c, w) + reduced.target
    b = _dual(reduced, point, Xa)
    views = np.abs(Xa - b)
    norms = _norms(reduced, b) if reduced.coupled and any(b) else []
    linear = 2 * (reduced.target - inner(reduced.c, w))
    square = loss + (inner(b, b) / (4 * reduced.lambda1) if reduced.lambda1 else 0)
    limits = [reduced.lambda2 / x for x in views if x] + [reduced.lambda3 / x.upper for x in norms if x.upper]
    s = min([linear / (2 * square) if square else Fraction(1), *limits])
    lower = max(Fraction(0), s * linear - s * s * square) if s > 0 else Fraction(0)
    modalities = tuple(Enclosure(s * x.lower, s * x.upper) for x in norms)
    return Optimum(Enclosure(lower, _primal(reduced, point, loss)), w, s * views, modalities)


def _dual(reduced: Reduced, point: Central, Xa: Rationals) -> Rationals:
    """Return the b of the point, X a where lambda2 = 0, as v = 0, or -2 lambda1 P w where lambda3 = 0."""
    if reduced.coupled:
        return Xa if reduced.lambda2 == 0 else (point.b if point.b.size else reduced.zero)
    return reduced.zero if reduced.P is None else -2 * reduced.lambda1 * times(reduced.P, point.w)


def _norms(reduced: Reduced, b: Rationals) -> list[Enclosure]:
    """||X_i'b|| of each modality."""
    return [square_root(inner(b, times(K, b))) for K in reduced.K]


def _primal(reduced: Reduced, point: Central, loss: Fraction) -> Fraction:
    """An upper bound of min_u F(w, u), exactly: u^i = -rho_i X_i'b, or Xu = w as far as it goes, or u = 0."""
    value = loss + reduced.lambda2 * total(map(abs, point.w))
    if not reduced.coupled:
        return (
            value
            if reduced.P is None
            else value + reduced.lambda1 * inner(point.w, times(reduced.P, point.w))
        )
    q = -point.w
    if point.b.size:
        for rho, K, norm in zip(point.rho, reduced.K, _norms(reduced, point.b), strict=True):
            q = q - rho * times(K, point.b)
            value += reduced.lambda3 * abs(rho) * norm.upper
    return min(value + reduced.lambda1 * inner(q, q), reduced.target)


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
