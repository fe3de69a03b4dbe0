"""An interior-point method on the reduced problem in any precision, for where float64 is not enough.

u is eliminated: with h and S(t) of `convexperc.enclosure.smooth`, the problem is

    min over w, t >= 0:  h(w, t) + lambda2 ||w||_1 + ||o||^2,
    q = S(t)^-1 w,  u^i = t_i X_i' q,  Xu - w = -q / lambda1,  b = -2 q.

lambda2 |w_j| becomes min over s of lambda2 s - mu log(s^2 - w_j^2), and t_i >= 0 becomes -mu log t_i.
On the central path the dual point a = 2(X'w - o), b = -2q is strictly feasible, so no scaling is needed.

Source: Boyd and Vandenberghe, Convex Optimization, chapter 11.
"""

from dataclasses import dataclass
from typing import Any

import flint

from convexperc.enclosure.balls import Number, Numbers, column, dot, matrix_cost, midpoint
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.enclosure.smooth import Smooth, State

BARRIER_DIVISOR = 12
"""mu falls by this factor between two centrings."""
MAX_STEPS = 6000
"""More Newton steps than this in all never were needed; a bound against a loop without end."""


@dataclass(frozen=True, eq=False)
class Central:
    """A point near the central path, as exact numbers.

    Attributes
    ----------
    w, t, q : lists of arb without radius
        q = S(t)^-1 w up to the working precision.
    mu : arb
    """

    w: Numbers
    t: Numbers
    q: Numbers
    mu: Number


class CentralPath:
    """Follows the central path of one reduced problem towards mu = 0."""

    def __init__(self, reduced: ReducedBalls) -> None:
        self.smooth = smooth = Smooth(reduced)
        self.lambda2 = smooth.lambda2
        self.mu = reduced.target.mid() if reduced.target > 0 else flint.arb(1)
        self.w = [flint.arb(0)] * smooth.n
        self.t = [(self.mu / smooth.fee).mid() for _ in smooth.K]
        self.steps = 0

    def point(self) -> Central:
        """Where the path is now."""
        return Central(self.w, self.t, self.smooth.state(self.w, self.t).q, self.mu)

    def advance(self) -> None:
        """Lower mu and centre again."""
        self.mu = (self.mu / BARRIER_DIVISOR).mid()
        for _ in range(60):
            if self.steps >= MAX_STEPS or self._newton():
                return

    def _merit(self, w: Numbers, t: Numbers, q: Numbers) -> Number:
        total = self.smooth.value(w, t, q)
        for weight in t:
            total -= self.mu * weight.log()
        if self.lambda2 > 0:
            for value in w:
                s = self._slack(value)
                total += self.lambda2 * s - self.mu * (2 * self.mu * s / self.lambda2).log()
        return total.mid()

    def _slack(self, value: Number) -> Number:
        """The s that belongs to w_j: s = (mu + sqrt(mu^2 + lambda2^2 w_j^2)) / lambda2."""
        return ((self.mu + (self.mu * self.mu + (self.lambda2 * value) ** 2).sqrt()) / self.lambda2).mid()

    def _derivatives(self, state: State) -> tuple[Numbers, Any]:
        """Gradient and Hessian of the barrier function at the current point."""
        gradient, H = self.smooth.derivatives(self.w, state)
        n = self.smooth.n
        for a, value in enumerate(self.w):
            if self.lambda2 > 0:
                s = self._slack(value)
                gradient[a] += self.lambda2 * value / s
                root = s - self.mu / self.lambda2
                H[a, a] += self.lambda2 / s * (1 - value * value / (s * root))
            else:
                H[a, a] += 2 * self.smooth.G[a, a] * flint.arb(2) ** (-flint.ctx.prec // 2)
        for i, weight in enumerate(self.t):
            gradient[n + i] -= self.mu / weight
            H[n + i, n + i] += self.mu / (weight * weight)
        return midpoint(gradient), H.mid()

    def _newton(self) -> bool:
        """One damped Newton step; true where the point was centred already."""
        self.steps += 1
        state = self.smooth.state(self.w, self.t)
        gradient, H = self._derivatives(state)
        for a in range(self.smooth.n):
            if H[a, a] <= 0:
                H[a, a] = flint.arb(1)
        self.smooth.budget.require(matrix_cost(len(gradient) ** 3 / 3))
        right = flint.arb_mat(len(gradient), 1, [-v for v in gradient])
        step = midpoint(column(H.solve(right, algorithm="approx")))
        decrement = -dot(gradient, step)
        if not decrement > self.mu * flint.arb(2) ** -20:
            if decrement > -self.mu:
                self._move(step, flint.arb(1))
            return True
        before, share = self._merit(self.w, self.t, state.q), flint.arb(1)
        for _ in range(60):
            w, t = self._moved(step, share)
            if all(weight > 0 for weight in t):
                after = self._merit(w, t, self.smooth.state(w, t).q)
                if after <= before - share * decrement / 100:
                    self.w, self.t = w, t
                    return False
            share = share / 2
        return True

    def _moved(self, step: Numbers, share: Number) -> tuple[Numbers, Numbers]:
        w = [(value + share * step[a]).mid() for a, value in enumerate(self.w)]
        t = [(value + share * step[self.smooth.n + i]).mid() for i, value in enumerate(self.t)]
        return w, t

    def _move(self, step: Numbers, share: Number) -> None:
        w, t = self._moved(step, share)
        if all(weight > 0 for weight in t):
            self.w, self.t = w, t
