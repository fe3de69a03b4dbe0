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

from convexperc.arrays import FeatureVector, Matrix, Vector
from convexperc.exact import into_left_null_space
from convexperc.modalities import Modalities
from convexperc.objective import residuals
from convexperc.problem import Problem
from convexperc.rounding import (
    Ball,
    U,
    down,
    inner,
    norm_bounds,
    product,
    scaled_bounds,
    squared_norm,
    sum_bounds,
    up,
)
from convexperc.scaling import Bounds, Scaling


@dataclass(frozen=True, eq=False)
class Frame:
    """The normalised data of one problem, with what is known of its rounding.

    Attributes
    ----------
    X, o : float64 (n, d) and (d,)
        Normalised data, each entry within `entry_error`.
    lambda1, lambda2, lambda3 : (lower, upper)
        Normalised lambdas. The lower ones make dual points, the upper ones bound F from above: a smaller
        lambda can only lower the optimum.
    """

    X: Matrix
    o: FeatureVector
    modalities: Modalities
    lambda1: Bounds
    lambda2: Bounds
    lambda3: Bounds
    entry_error: float

    @classmethod
    def of(cls, problem: Problem, scaling: Scaling) -> "Frame":
        """Normalise `problem` by `scaling`."""
        X, o, error = scaling.data(problem)
        one, two, three = scaling.lambdas(problem)
        return cls(X, o, problem.modalities, one, two, three, error)

    @property
    def target(self) -> Ball:
        """O with its entry error."""
        return Ball(self.o, np.full(self.o.shape, self.entry_error))

    def times_rows(self, x: Ball) -> Ball:
        """X x for x of shape (d,)."""
        return product(self.X, x, self.entry_error)

    def times_columns(self, x: Ball) -> Ball:
        """X' x for x of shape (n,)."""
        return product(self.X.T, x, self.entry_error)

    def modality_norms(self, x: Ball) -> list[Bounds]:
        """Bounds of the 2-norm of each modality's part of x of shape (d,)."""
        return [norm_bounds(Ball(x.mid[c], x.rad[c])) for c in self.modalities]


@dataclass(frozen=True, eq=False)
class DualPoint:
    """A dual point s (a, b) with its excess over each constraint; feasible where the excess is 0.

    Attributes
    ----------
    kind : str
        How it was made.
    a : float64 (d,)
    b, v : Ball of shape (n,)
        v = X a - b.
    scale : float
        s >= 0, applied to a, b and v.
    excess_views : float
        Upper bound of max_j (|s v_j| - lambda2)+.
    excess_modalities : tuple of float
        Upper bounds of (||X_i' s b|| - lambda3)+.
    """

    kind: str
    a: FeatureVector
    b: Ball
    v: Ball
    scale: float
    excess_views: float
    excess_modalities: tuple[float, ...]

    @property
    def feasible(self) -> bool:
        """True when no constraint is exceeded, proved."""
        return self.excess_views == 0.0 and not any(self.excess_modalities)


def dual_value(frame: Frame, point: DualPoint) -> Bounds:
    """Enclose D(s a, s b) = -s a'o - s^2 (||a||^2/4 + ||b||^2/(4 lambda1))."""
    linear, quadratic = _value_parts(frame, point.a, point.b)
    s = point.scale
    square = up(s * s), max(0.0, down(s * s))
    low = down(s * linear[0]) - up(square[0] * quadratic[1])
    high = up(s * linear[1]) - max(0.0, down(square[1] * quadratic[0]))
    return down(low), up(high)


def _value_parts(frame: Frame, a: FeatureVector, b: Ball) -> tuple[Bounds, Bounds]:
    """-a'o and Q = ||a||^2/4 + ||b||^2/(4 lambda1); b must be 0 where lambda1 is 0."""
    low, high = inner(Ball.exact(a), frame.target)
    a_part, b_part = squared_norm(Ball.exact(a)), squared_norm(b)
    if b_part[1] == 0.0:
        quadratic = a_part
    elif frame.lambda1[0] == 0.0:
        quadratic = (a_part[0], math.inf)
    else:
        coupling = down(b_part[0] / up(frame.lambda1[1])), up(up(b_part[1]) / frame.lambda1[0])
        quadratic = sum_bounds(a_part, (max(0.0, coupling[0]), coupling[1]))
    return (-high, -low), (0.25 * quadratic[0], 0.25 * quadratic[1])


def candidates(
    frame: Frame, w: Vector, u: FeatureVector, hint: tuple[FeatureVector, Vector] | None
) -> Iterator[DualPoint]:
    """Every dual point that (w, u), and a solver's own dual (a, b) if given, suggest.

    Paper symbols: a = 2(X'w - o), b = 2 lambda1 (Xu - w). The kinds:

    ``slack``     v = X a - b cut to [-lambda2, lambda2];
    ``sign``      v_j = -lambda2 sign(w_j) where w_j is not 0, else as in ``slack``;
    ``coupling``  b itself, each shrunk until ||X_i' b|| <= lambda3;
    ``null``      b moved exactly into {X'b = 0}, the only choice for lambda3 = 0 besides b = 0;
    ``uncoupled`` b = 0.
    """
    problem = _plain(frame)
    p, q = residuals(problem, w, u)
    pairs = [(2.0 * p, 2.0 * frame.lambda1[0] * q)]
    if hint is not None:
        pairs.append(hint)
    for a, b in pairs:
        if not (np.isfinite(a).all() and np.isfinite(b).all()):
            continue
        Xa = frame.times_rows(Ball.exact(a))
        if frame.lambda1[0] > 0.0 and frame.lambda3[0] > 0.0:
            limit = frame.lambda2[0]
            cut = np.clip(Xa.mid - b, -limit, limit)
            yield from _with_slack(frame, "slack", a, Xa, cut)
            yield from _with_slack(frame, "sign", a, Xa, np.where(w == 0, cut, -limit * np.sign(w)))
            yield from _with_coupling(frame, "coupling", a, Xa, _shrunk(frame, b))
        if frame.lambda1[0] > 0.0 and frame.lambda3[0] == 0.0:
            null = into_left_null_space(frame.X, b) if frame.entry_error == 0.0 else None
            if null is not None:
                yield from _with_coupling(frame, "null", a, Xa, null, norms=0.0)
        yield from _with_coupling(frame, "uncoupled", a, Xa, Ball.exact(np.zeros_like(b)), norms=0.0)


def _plain(frame: Frame) -> Problem:
    one, two, three = frame.lambda1[0], frame.lambda2[0], frame.lambda3[0]
    return Problem(frame.X, frame.o, modalities=frame.modalities, lambda1=one, lambda2=two, lambda3=three)


def _with_slack(frame: Frame, kind: str, a: FeatureVector, Xa: Ball, v: Vector) -> Iterator[DualPoint]:
    """B := X a - v for floats |v| <= lambda2."""
    b = Xa.plus(Ball.exact(v), -1.0)
    norms = [high for _, high in frame.modality_norms(frame.times_columns(b))]
    yield from _scaled(frame, kind, a, b, Ball.exact(v), norms)


def _with_coupling(
    frame: Frame, kind: str, a: FeatureVector, Xa: Ball, b: Ball, norms: float | None = None
) -> Iterator[DualPoint]:
    """V := X a - b for a chosen b; `norms` = 0 where X'b = 0 is known exactly."""
    v = Xa.plus(b, -1.0)
    if norms is None:
        found = [high for _, high in frame.modality_norms(frame.times_columns(b))]
    else:
        found = [norms] * len(frame.modalities)
    yield from _scaled(frame, kind, a, b, v, found)


def _shrunk(frame: Frame, b: Vector) -> Ball:
    """B times the largest factor <= 1 that keeps every ||X_i' b|| <= lambda3."""
    norms = [high for _, high in frame.modality_norms(frame.times_columns(Ball.exact(b)))]
    worst = max(norms)
    if worst <= frame.lambda3[0]:
        return Ball.exact(b)
    return Ball.exact(b * (frame.lambda3[0] / worst * (1.0 - 64 * U)))


def _scaled(
    frame: Frame, kind: str, a: FeatureVector, b: Ball, v: Ball, norms: list[float]
) -> Iterator[DualPoint]:
    """The point scaled into the feasible set, and the unscaled one with its excess if it has any."""
    linear, quadratic = _value_parts(frame, a, b)
    if not (math.isfinite(linear[0]) and math.isfinite(quadratic[1])):
        return
    best = 0.5 * (linear[0] + linear[1]) / (2.0 * quadratic[1]) if quadratic[1] > 0.0 else 1.0
    worst = float(v.magnitude().max())
    room = min(_ratio(frame.lambda2[0], worst), *(_ratio(frame.lambda3[0], norm) for norm in norms))
    for s in dict.fromkeys((min(best, room), min(best, 1.0))):
        if s > 0.0:
            views = _excess(s, worst, frame.lambda2[0])
            yield DualPoint(kind, a, b, v, s, views, tuple(_excess(s, x, frame.lambda3[0]) for x in norms))


def _ratio(limit: float, norm: float) -> float:
    """The largest s with s * norm <= limit, rounded down."""
    return math.inf if norm == 0.0 else limit / norm * (1.0 - 8 * U)


def _excess(s: float, norm: float, limit: float) -> float:
    """Upper bound of (s * norm - limit)+, 0 only where s * norm <= limit is proved."""
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


def gap_terms(frame: Frame, w: Ball, u: Ball, point: DualPoint) -> GapTerms:
    """Bound F(w,u) - D(s a, s b) from above without subtracting F and D."""
    s = point.scale
    p = frame.times_columns(w).plus(frame.target, -1.0)
    loss = squared_norm(p.plus(Ball.exact(point.a).times(0.5 * s), -1.0))[1]
    v = point.v.times(s)
    toward = np.where(w.rad > 0.0, np.abs(v.mid), np.sign(w.mid) * v.mid)
    room = frame.lambda2[1] + toward
    rounding = v.rad + 4 * U * (np.abs(v.mid) + frame.lambda2[1])
    views = inner(Ball.exact(w.magnitude()), Ball(np.maximum(room, 0.0), rounding))[1]
    return GapTerms(
        loss, _coupling_term(frame, w, u, point), max(0.0, views), _modality_term(frame, u, point)
    )


def _coupling_term(frame: Frame, w: Ball, u: Ball, point: DualPoint) -> float:
    """lambda1 ||q - s b/(2 lambda1)||^2, with b = 0 where lambda1 = 0."""
    q = frame.times_rows(u).plus(w, -1.0)
    low, high = frame.lambda1
    if low > 0.0:
        half = point.b.times(point.scale).times(0.5 / low)
        spread = (8 * U + (high - low) / low) * half.magnitude()
        q = q.plus(Ball(half.mid, half.rad + spread), -1.0)
    return scaled_bounds(frame.lambda1, squared_norm(q))[1]


def _modality_term(frame: Frame, u: Ball, point: DualPoint) -> float:
    """sum_i (lambda3 ||u^i|| + u^i' X_i' s b), each summand cut at 0 from below."""
    total = 0.0
    Xb = frame.times_columns(point.b.times(point.scale))
    for c in frame.modalities:
        part, pull = Ball(u.mid[c], u.rad[c]), Ball(Xb.mid[c], Xb.rad[c])
        if part.mid.any() or part.rad.any():
            both = sum_bounds(scaled_bounds(frame.lambda3, norm_bounds(part)), inner(part, pull))
            total = up(total + max(0.0, both[1]))
    return total
