"""Newton's method on the face of a float64 answer: from some 10 digits to all digits in a few steps.

On a face (the views with w_j != 0 and their signs, the modalities with t_i > 0) the reduced objective
h(w, t) + lambda2 sum_j sign_j w_j is smooth; its stationary point is the optimum where

    sign_j w_j >= 0,  t_i >= 0  on the face,      |dh/dw_j| <= lambda2,  dh/dt_i >= 0  off the face.

A step ends where an entry reaches 0, which leaves the face; at a stationary point, the entry whose condition
fails most enters.
Nothing here is a proof: the interval at the point is (`convexperc.enclosure.interval`).

Source: Nocedal and Wright, Numerical Optimization, 2nd ed., section 16.5 (active sets).
"""

from contextlib import suppress
from dataclasses import dataclass

import flint
import numpy as np

from convexperc.enclosure.balls import Number, Numbers, column, dot, matrix_cost, midpoint
from convexperc.enclosure.budget import OutOfBudget
from convexperc.enclosure.central_path import Central
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.enclosure.smooth import Smooth
from convexperc.problem.arrays import Vector

MAX_STEPS = 60
"""Newton steps; a good start takes three or four."""
ROUNDING_BITS = 24
"""Bits of the working precision that rounding may have cost at a stationary point."""
STAGNATION_SHARE = 1e-12
"""Decrements below this share of ||o||^2 fall quadratically until rounding stops them."""


@dataclass(frozen=True, eq=False)
class Start:
    """A float64 answer to the normalised problem.

    Attributes
    ----------
    w : float64 (n,)
    t : float64 (m,)
        t_i = 2 ||u^i|| / lambda3.
    """

    w: Vector
    t: np.ndarray


class ActiveSetNewton:
    """Newton's method from one start, on a face that follows the signs."""

    def __init__(self, reduced: ReducedBalls, start: Start) -> None:
        self.smooth = smooth = Smooth(reduced)
        self.w = [flint.arb(float(v)) for v in start.w]
        self.t = [flint.arb(float(v)) for v in start.t] if smooth.coupled else [flint.arb(0)] * len(start.t)
        self.signs = [1 if v > 0 else -1 if v < 0 else 0 for v in start.w]
        self.held = self._held_at_first()
        self.target = reduced.target.mid()
        self.steps = 0

    def _held_at_first(self) -> list[bool]:
        """Entries of (w, t) that are kept at 0."""
        views = [bool(self.smooth.lambda2 > 0) and not sign for sign in self.signs]
        return views + [not weight > 0 for weight in self.t[: len(self.smooth.K)]]

    def point(self) -> Central:
        """Where the steps end: at the budget's end or at a singular matrix, if not before."""
        reached, before = self._here(), None
        with suppress(ZeroDivisionError, OutOfBudget):
            while self.steps < MAX_STEPS:
                self.steps += 1
                gradient, H = self.smooth.derivatives(reached.w, self.state)
                step, decrement = self._step(gradient, H)
                left = self._move(step)
                settled = not left and self._settled(decrement, before)
                before = None if left or settled else decrement
                reached = self._here()
                if settled and not self._enter(gradient):
                    break
        return reached

    def _here(self) -> Central:
        """The current point."""
        self.state = self.smooth.state(self.w, self.t)
        return Central(list(self.w), list(self.t), self.state.q, flint.arb(0))

    def _settled(self, decrement: Number, before: Number | None) -> bool:
        """Whether the last step was rounding: too small, or no smaller than the one before."""
        if not decrement > self.target * flint.arb(2) ** (ROUNDING_BITS - 2 * flint.ctx.prec):
            return True
        return (
            before is not None
            and bool(2 * decrement > before)
            and bool(decrement < self.target * STAGNATION_SHARE)
        )

    def _step(self, gradient: Numbers, H: flint.arb_mat) -> tuple[Numbers, Number]:
        """Newton's step on the face, and its decrement."""
        free = [k for k, held in enumerate(self.held) if not held]
        step = [flint.arb(0)] * len(self.held)
        if not free:
            return step, flint.arb(0)
        self.smooth.budget.require(matrix_cost(len(free) ** 3 / 3))
        slope = [self._slope(gradient, k) for k in free]
        block = flint.arb_mat([[H[a, b].mid() for b in free] for a in free])
        for a in range(len(free)):  # where the optimum is not unique, the Hessian is singular
            block[a, a] = (block[a, a] * (1 + flint.arb(2) ** (-flint.ctx.prec // 2))).mid()
        right = flint.arb_mat(len(free), 1, [-v for v in slope])
        found = midpoint(column(block.solve(right, algorithm="approx")))
        for k, value in zip(free, found, strict=True):
            step[k] = value
        return step, -dot(slope, found).mid()

    def _slope(self, gradient: Numbers, k: int) -> Number:
        """The derivative along entry k on the face."""
        own = gradient[k].mid()
        return (own + self.smooth.lambda2 * self.signs[k]).mid() if k < self.smooth.n else own

    def _move(self, step: Numbers) -> bool:
        """Take the step as far as the first entry that crosses 0, which leaves the face; true if one does."""
        share, blocking = flint.arb(1), None
        for k, held in enumerate(self.held):
            value, sign = self._entry(k)
            if not held and sign and not sign * (value + share * step[k]).mid() > 0:
                share, blocking = (-value / step[k]).mid() if sign * value > 0 else flint.arb(0), k
        for k, held in enumerate(self.held):
            if not held:
                self._put(k, (self._entry(k)[0] + share * step[k]).mid())
        if blocking is None:
            return False
        self._put(blocking, flint.arb(0))
        self.held[blocking] = True
        return True

    def _entry(self, k: int) -> tuple[Number, int]:
        """Entry k of (w, t), and the sign that it has on the face; 0 where it may have any."""
        n = self.smooth.n
        if k >= n:
            return self.t[k - n], 1
        return self.w[k], self.signs[k] if self.smooth.lambda2 > 0 else 0

    def _put(self, k: int, value: Number) -> None:
        """Set entry k of (w, t)."""
        n = self.smooth.n
        if k < n:
            self.w[k] = value
        else:
            self.t[k - n] = value

    def _enter(self, gradient: Numbers) -> bool:
        """Free the held entry whose condition fails most; false where none does."""
        n, slack = self.smooth.n, flint.arb(2) ** (ROUNDING_BITS - flint.ctx.prec)
        worst, chosen = 1 + slack, None
        for k, held in enumerate(self.held):
            if held:
                share = abs(gradient[k]) / self.smooth.lambda2 if k < n else 1 - gradient[k] / self.smooth.fee
                if share.mid() > worst:
                    worst, chosen = share.mid(), k
        if chosen is None:
            return False
        self.held[chosen] = False
        if chosen < n:
            self.signs[chosen] = -1 if gradient[chosen] > 0 else 1
        return True
