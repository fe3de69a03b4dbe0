"""Dual points that are feasible by proof, the lower bounds they give, and the gap without cancellation.

    maximise  D(a,b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1)
    s.t.      ||X a - b||_inf <= lambda2,      ||X_i' b||_2 <= lambda3  for every modality i

A dual point is kept as (a, b, v) with v = X a - b. Either v is chosen as floats inside [-lambda2, lambda2]
and b := X a - v is the real vector that this defines, enclosed in a ball; or b is chosen and v is enclosed.
Nothing is accepted "within a tolerance": a point is scaled into the feasible set, or its excess is charged.

Source: Boyd and Vandenberghe, Convex Optimization, section 5.1.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from convexperc.certificate.evaluation import NormalizedData, PrimalPoint
from convexperc.certificate.rationals import into_left_null_space
from convexperc.certificate.rounding import (
    Ball,
    Floats,
    U,
    down,
    inner,
    inner_by_group,
    scaled_bounds,
    squared_norm,
    sum_bounds,
    up,
)
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.scaling import Bounds

SMALLEST_TWICE = 2.0**-1021
"""From here on, half of a float is a float."""


@dataclass(frozen=True, eq=False)
class Ray:
    """A dual point (a, b) before it is scaled.

    Attributes
    ----------
    kind : str
        How it was made.
    a : float64 (d,)
    b, v : Ball of shape (n,)
        v = X a - b.
    pull : Ball of shape (d,)
        X'b.
    norms : float64 (m,)
        Upper bounds of ||X_i' b||.
    linear, quadratic : (lower, upper)
        D(s a, s b) = s linear - s^2 quadratic.
    """

    kind: str
    a: FeatureVector
    b: Ball
    v: Ball
    pull: Ball
    norms: Floats
    linear: Bounds
    quadratic: Bounds


@dataclass(frozen=True, eq=False)
class DualPoint:
    """A dual point s (a, b) with its excess over each kind of constraint; feasible where both are 0.

    Attributes
    ----------
    ray : Ray
    scale : float
        s >= 0, applied to a, b and v.
    excess_views : float
        Upper bound of max_j (|s v_j| - lambda2)+.
    excess_modalities : float
        Upper bound of max_i (||X_i' s b|| - lambda3)+.
    """

    ray: Ray
    scale: float
    excess_views: float
    excess_modalities: float

    @property
    def kind(self) -> str:
        """How it was made."""
        return self.ray.kind

    @property
    def a(self) -> FeatureVector:
        """Before scaling."""
        return self.ray.a

    @property
    def b(self) -> Ball:
        """Before scaling."""
        return self.ray.b

    @property
    def v(self) -> Ball:
        """X a - b, before scaling."""
        return self.ray.v

    @property
    def feasible(self) -> bool:
        """True when no constraint is exceeded, proved."""
        return self.excess_views == 0.0 and self.excess_modalities == 0.0


def dual_value(point: DualPoint) -> Bounds:
    """Enclose D(s a, s b) = -s a'o - s^2 (||a||^2/4 + ||b||^2/(4 lambda1)) (Lemma R25)."""
    linear, quadratic, s = point.ray.linear, point.ray.quadratic, point.scale
    square = up(s * s), max(0.0, down(s * s))
    low = down(s * linear[0]) - up(square[0] * quadratic[1])
    high = up(s * linear[1]) - max(0.0, down(square[1] * quadratic[0]))
    return down(low), up(high)


def _value_parts(data: NormalizedData, a: FeatureVector, b: Ball) -> tuple[Bounds, Bounds]:
    """-a'o and Q = ||a||^2/4 + ||b||^2/(4 lambda1); b must be 0 where lambda1 is 0 (Lemma R26)."""
    low, high = inner(Ball.exact(a), data.target)
    a_part, b_part = squared_norm(Ball.exact(a)), squared_norm(b)
    if b_part[1] == 0.0:
        quadratic = a_part
    elif data.lambda1[0] == 0.0:
        quadratic = (a_part[0], math.inf)
    else:
        quadratic = sum_bounds(a_part, (b_part[0] / data.lambda1[1], up(b_part[1] / data.lambda1[0])))
    quarters = max(0.0, down(0.25 * quadratic[0])), up(0.25 * quadratic[1]) if quadratic[1] else 0.0
    return (-high, -low), quarters


def dual_points(
    data: NormalizedData, point: PrimalPoint, hint: tuple[FeatureVector, Vector] | None
) -> Iterator[DualPoint]:
    """Every dual point that (w, u), and a solver's own dual (a, b) if given, suggest; the likeliest first.

    Paper symbols: a = 2(X'w - o), b = 2 lambda1 (Xu - w). The kinds:

    ``slack``     v = X a - b cut to [-lambda2, lambda2];
    ``sign``      v_j = -lambda2 sign(w_j) where w_j is not 0, else as in ``slack``;
    ``coupling``  b itself, each shrunk until ||X_i' b|| <= lambda3;
    ``uncoupled`` b = 0;
    ``null``      b moved exactly into {X'b = 0}, the only choice for lambda3 = 0 besides b = 0.
    """
    pairs = [(2.0 * point.p.mid, 2.0 * data.lambda1[0] * point.q.mid)]
    if hint is not None:
        pairs.append(hint)
    for a, b in pairs:
        if np.isfinite(a).all() and np.isfinite(b).all():
            yield from _of_pair(data, point, a, b)


def _of_pair(data: NormalizedData, point: PrimalPoint, a: FeatureVector, b: Vector) -> Iterator[DualPoint]:
    """The kinds that one pair (a, b) suggests; each is worked out only when it is asked for."""
    w, coupled = point.w.mid, data.lambda1[0] > 0.0
    Xa = data.times_rows(Ball.exact(a))
    if coupled and data.lambda3[0] > 0.0:
        limit = data.lambda2[0]
        cut = np.clip(Xa.mid - b, -limit, limit)
        signed = np.where(w == 0, cut, -limit * np.sign(w))
        yield from _scaled(data, _with_slack(data, "slack", a, Xa, cut))
        if not np.array_equal(signed, cut):
            yield from _scaled(data, _with_slack(data, "sign", a, Xa, signed))
        yield from _scaled(data, _with_coupling(data, "coupling", a, Xa, _shrunk(data, b)))
    yield from _scaled(data, _with_coupling(data, "uncoupled", a, Xa, Ball.exact(np.zeros_like(b))))
    if coupled and data.lambda3[0] == 0.0:
        null = into_left_null_space(data.X, b) if data.entry_error == 0.0 else None
        if null is not None:
            yield from _scaled(data, _with_coupling(data, "null", a, Xa, null))


def _with_slack(data: NormalizedData, kind: str, a: FeatureVector, Xa: Ball, v: Vector) -> Ray:
    """B := X a - v for floats |v| <= lambda2."""
    b = Xa.plus(Ball.exact(v), -1.0)
    pull = data.times_columns(b)
    norms = data.modality_norms(pull)[1]
    return Ray(kind, a, b, Ball.exact(v), pull, norms, *_value_parts(data, a, b))


def _with_coupling(data: NormalizedData, kind: str, a: FeatureVector, Xa: Ball, b: Ball) -> Ray:
    """V := X a - b for a chosen b; X'b = 0 is known exactly of the kinds ``uncoupled`` and ``null``."""
    if kind == "coupling":
        pull = data.times_columns(b)
        norms = data.modality_norms(pull)[1]
    else:
        pull, norms = Ball.exact(np.zeros_like(a)), np.zeros(len(data.modalities))
    return Ray(kind, a, b, Xa.plus(b, -1.0), pull, norms, *_value_parts(data, a, b))


def _shrunk(data: NormalizedData, b: Vector) -> Ball:
    """B times the largest factor <= 1 that keeps every ||X_i' b|| <= lambda3 (Lemma R28)."""
    worst = float(data.modality_norms(data.times_columns(Ball.exact(b)))[1].max())
    if worst <= data.lambda3[0]:
        return Ball.exact(b)
    return Ball.exact(b * (data.lambda3[0] / worst * (1.0 - 64 * U)))


def _scaled(data: NormalizedData, ray: Ray) -> Iterator[DualPoint]:
    """The point scaled into the feasible set, and the unscaled one with its excess if it has any."""
    linear, quadratic = ray.linear, ray.quadratic
    if not (math.isfinite(linear[0]) and math.isfinite(quadratic[1])):
        return
    best = 0.5 * (linear[0] + linear[1]) / (2.0 * quadratic[1]) if quadratic[1] > 0.0 else 1.0
    view, modality = float(ray.v.magnitude().max()), float(ray.norms.max())
    room = min(_ratio(data.lambda2[0], view), _ratio(data.lambda3[0], modality))
    for s in dict.fromkeys((min(best, room), min(best, 1.0))):
        if s > 0.0:
            views, modalities = _excess(s, view, data.lambda2[0]), _excess(s, modality, data.lambda3[0])
            yield DualPoint(ray, s, views, modalities)


def _ratio(limit: float, norm: float) -> float:
    """The largest s with s * norm <= limit, rounded down (Lemma R28)."""
    return math.inf if norm == 0.0 else limit / norm * (1.0 - 8 * U)


def _excess(s: float, norm: float, limit: float) -> float:
    """Upper bound of (s * norm - limit)+, 0 only where s * norm <= limit is proved (Lemma R27)."""
    reached = up(s * norm) if norm else 0.0
    return 0.0 if reached <= limit else up(reached - limit)


@dataclass(frozen=True)
class GapTerms:
    """Upper bounds of the four terms of F(w,u) - D(s a, s b), each >= 0 at a feasible dual point.

    Formula, with p = X'w - o and q = Xu - w:

        loss            ||p - s a/2||^2
        coupling        lambda1 ||q - s b/(2 lambda1)||^2
        view_norm       sum_j |w_j| (lambda2 + sign(w_j) s v_j)
        modality_norm   sum_i (lambda3 ||u^i|| + u^i' X_i' s b)

    Attributes
    ----------
    loss, coupling, view_norm, modality_norm : float
        In units where ||o|| is about 1.
    """

    loss: float
    coupling: float
    view_norm: float
    modality_norm: float

    @property
    def total(self) -> float:
        """Upper bound of the sum."""
        return sum_bounds(
            *((0.0, x) for x in (self.loss, self.coupling, self.view_norm, self.modality_norm))
        )[1]


def gap_terms(data: NormalizedData, point: PrimalPoint, dual: DualPoint) -> GapTerms:
    """Bound F(w,u) - D(s a, s b) from above without subtracting F and D (Lemma R29)."""
    s, w = dual.scale, point.w
    exact = 0.5 * s if s >= SMALLEST_TWICE else 0.0
    half = Ball.exact(dual.a).times(exact) if exact else Ball.exact(dual.a).times(s).times(0.5)
    loss = squared_norm(point.p.plus(half, -1.0))[1]
    v = dual.v.times(s)
    toward = np.where(w.rad > 0.0, np.abs(v.mid), np.sign(w.mid) * v.mid)
    room = data.lambda2[1] + toward
    rounding = v.rad + 4 * U * (np.abs(v.mid) + data.lambda2[1])
    views = inner(Ball.exact(w.magnitude()), Ball(np.maximum(room, 0.0), rounding))[1]
    return GapTerms(
        loss, _coupling_term(data, point, dual), max(0.0, views), _modality_term(data, point, dual)
    )


def _coupling_term(data: NormalizedData, point: PrimalPoint, dual: DualPoint) -> float:
    """lambda1 ||q - s b/(2 lambda1)||^2, with b = 0 where lambda1 = 0 (Lemma R30)."""
    q = point.q
    low, high = data.lambda1
    if low > 0.0:
        half = dual.b.times(dual.scale).times(0.5 / low)
        spread = (8 * U + (high - low) / low) * half.magnitude()
        q = q.plus(Ball(half.mid, half.rad + spread), -1.0)
    return scaled_bounds(data.lambda1, squared_norm(q))[1]


def _modality_term(data: NormalizedData, point: PrimalPoint, dual: DualPoint) -> float:
    """sum_i (lambda3 ||u^i|| + u^i' X_i' s b), each summand cut at 0 from below (Lemma R31)."""
    total, pull = 0.0, dual.ray.pull.times(dual.scale)
    products = inner_by_group(point.u, pull, data.groups)[1].tolist()
    for length, product in zip(point.lengths[1].tolist(), products, strict=True):
        if length:
            norm = scaled_bounds(data.lambda3, (0.0, length))[1]
            total = up(total + max(0.0, up(norm + product)))
    return total
