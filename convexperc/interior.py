"""An interior-point method on the reduced problem in any precision, for where float64 is not enough.

u is eliminated: with K_i = X_i X_i', G = sum_i K_i, c = X o and t_i = 2 ||u^i|| / lambda3, the problem is

    min over w, t >= 0:  w'Gw - 2 c'w + lambda2 ||w||_1 + w' S(t)^-1 w + (lambda3^2 / 4) sum_i t_i + ||o||^2,
    S(t) = I / lambda1 + sum_i t_i K_i,  q = S(t)^-1 w,  u^i = t_i X_i' q,  Xu - w = -q / lambda1,  b = -2 q.

lambda2 |w_j| becomes min over s of lambda2 s - mu log(s^2 - w_j^2), and t_i >= 0 becomes -mu log t_i.
On the central path the dual point a = 2(X'w - o), b = -2q is strictly feasible, so no scaling is needed.

Source: Boyd and Vandenberghe, Convex Optimization, chapter 11.
"""

from dataclasses import dataclass
from typing import Any

import flint

from convexperc.multiprecision import BallFrame, Number, Numbers, dot, midpoint, times

SHRINK = 12
"""mu falls by this factor between two centrings."""
CENTRINGS = 6000
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

    def __init__(self, frame: BallFrame) -> None:
        lambda1, self.lambda2, self.lambda3 = (x.mid() for x in frame.lambdas)
        self.lambda1 = lambda1
        self.coupled = bool(lambda1 > 0) and bool(self.lambda3 > 0)
        self.G = frame.G.mid()
        self.K = [gram.mid() for gram in frame.K] if self.coupled else []
        self.c = midpoint(frame.c)
        self.n = frame.n
        self.floor = self._floor(frame)
        self.mu = frame.target.mid() if frame.target > 0 else flint.arb(1)
        self.w = [flint.arb(0)] * self.n
        four = 4 * self.mu / (self.lambda3 * self.lambda3) if self.coupled else flint.arb(0)
        self.t = [four.mid() for _ in self.K]
        self.steps = 0

    def _floor(self, frame: BallFrame) -> Any:
        """What joins G where lambda3 = 0: lambda1 times the projection onto {X'b = 0}."""
        if frame.null is None or self.coupled:
            return None
        Z = frame.null.mid()
        gram = (Z.transpose() * Z).inv()
        return (Z * gram * Z.transpose() * self.lambda1).mid()

    def point(self) -> Central:
        """Where the path is now."""
        return Central(self.w, self.t, self._state(self.w, self.t)[1], self.mu)

    def advance(self) -> None:
        """Lower mu and centre again."""
        self.mu = (self.mu / SHRINK).mid()
        for _ in range(60):
            if self.steps >= CENTRINGS or self._newton():
                return

    def _state(self, w: Numbers, t: Numbers) -> tuple[Any, Numbers, list[Numbers]]:
        """S^-1, q = S^-1 w and K_i q."""
        if not self.coupled:
            if self.floor is None:
                return None, [flint.arb(0)] * self.n, []
            return self.floor, midpoint(times(self.floor, w)), []
        S = flint.arb_mat(self.n, self.n)
        for a in range(self.n):
            S[a, a] = 1 / self.lambda1
        for weight, gram in zip(t, self.K, strict=True):
            S = S + gram * weight
        inverse = S.mid().inv().mid()
        q = midpoint(times(inverse, w))
        return inverse, q, [midpoint(times(gram, q)) for gram in self.K]

    def _merit(self, w: Numbers, t: Numbers, q: Numbers) -> Number:
        total = dot(w, times(self.G, w)) - 2 * dot(self.c, w) + dot(w, q)
        for weight in t:
            total += self.lambda3 * self.lambda3 * weight / 4 - self.mu * weight.log()
        if self.lambda2 > 0:
            for value in w:
                s = self._slack(value)
                total += self.lambda2 * s - self.mu * (2 * self.mu * s / self.lambda2).log()
        return total.mid()

    def _slack(self, value: Number) -> Number:
        """The s that belongs to w_j: s = (mu + sqrt(mu^2 + lambda2^2 w_j^2)) / lambda2."""
        return ((self.mu + (self.mu * self.mu + (self.lambda2 * value) ** 2).sqrt()) / self.lambda2).mid()

    def _derivatives(self, q: Numbers, Kq: list[Numbers], inverse: Any) -> tuple[Numbers, Any]:
        """Gradient and Hessian of the barrier function at the current point."""
        n, m = self.n, len(self.K)
        H = flint.arb_mat(n + m, n + m)
        pull = times(self.G, self.w)
        gradient = [2 * (pull[a] - self.c[a] + q[a]) for a in range(n)]
        for a in range(n):
            for b in range(n):
                H[a, b] = 2 * self.G[a, b] + (2 * inverse[a, b] if inverse is not None else 0)
            if self.lambda2 > 0:
                value, s = self.w[a], self._slack(self.w[a])
                gradient[a] += self.lambda2 * value / s
                root = s - self.mu / self.lambda2
                H[a, a] += self.lambda2 / s * (1 - value * value / (s * root))
            else:
                H[a, a] += 2 * self.G[a, a] * flint.arb(2) ** (-flint.ctx.prec // 2)
        columns = [times(inverse, v) for v in Kq]
        for i in range(m):
            gradient.append(self.lambda3 * self.lambda3 / 4 - dot(q, Kq[i]) - self.mu / self.t[i])
            for a in range(n):
                H[a, n + i] = H[n + i, a] = -2 * columns[i][a]
            for k in range(m):
                H[n + i, n + k] = 2 * dot(Kq[i], columns[k])
            H[n + i, n + i] += self.mu / (self.t[i] * self.t[i])
        return midpoint(gradient), H.mid()

    def _newton(self) -> bool:
        """One damped Newton step; true where the point was centred already."""
        self.steps += 1
        inverse, q, Kq = self._state(self.w, self.t)
        gradient, H = self._derivatives(q, Kq, inverse)
        for a in range(self.n):
            if H[a, a] <= 0:
                H[a, a] = flint.arb(1)
        right = flint.arb_mat([[-v] for v in gradient])
        step = [row[0].mid() for row in H.solve(right, algorithm="approx").tolist()]
        decrement = -dot(gradient, step)
        if not decrement > self.mu * flint.arb(2) ** -20:
            if decrement > -self.mu:
                self._move(step, flint.arb(1))
            return True
        before, share = self._merit(self.w, self.t, q), flint.arb(1)
        for _ in range(60):
            w, t = self._moved(step, share)
            if all(weight > 0 for weight in t):
                after = self._merit(w, t, self._state(w, t)[1])
                if after <= before - share * decrement / 100:
                    self.w, self.t = w, t
                    return False
            share = share / 2
        return True

    def _moved(self, step: Numbers, share: Number) -> tuple[Numbers, Numbers]:
        w = [(value + share * step[a]).mid() for a, value in enumerate(self.w)]
        t = [(value + share * step[self.n + i]).mid() for i, value in enumerate(self.t)]
        return w, t

    def _move(self, step: Numbers, share: Number) -> None:
        w, t = self._moved(step, share)
        if all(weight > 0 for weight in t):
            self.w, self.t = w, t
