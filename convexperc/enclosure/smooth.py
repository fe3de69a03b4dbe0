"""The smooth part of the reduced objective and its derivatives, in numbers of any length.

With K_i = X_i X_i', G = sum_i K_i, c = X o and t_i = 2 ||u^i|| / lambda3 (`convexperc.problem.reduction`):

    h(w, t) = w'Gw - 2 c'w + w' S(t)^-1 w + (lambda3^2 / 4) sum_i t_i,   S(t) = I / lambda1 + sum_i t_i K_i.

Where lambda3 = 0, S^-1 is lambda1 times the projection onto {X'b = 0} and t plays no part; where
lambda1 = 0, S^-1 is 0. Everything is rounded to midpoints: these are steps towards a point, not bounds.
"""

from dataclasses import dataclass
from typing import Any

import flint

from convexperc.enclosure.balls import ENTRY_COST, Number, Numbers, dot, matrix_cost, midpoint, times
from convexperc.enclosure.reduced import ReducedBalls


@dataclass(frozen=True, eq=False)
class State:
    """What (w, t) determine.

    Attributes
    ----------
    inverse : arb_mat (n, n) or None
        S(t)^-1; None where it is 0.
    q : list of n arb
        S(t)^-1 w.
    Kq : list of m lists of n arb
        K_i q; empty where t plays no part.
    """

    inverse: Any
    q: Numbers
    Kq: list[Numbers]


class Smooth:
    """The function h of one reduced problem, at the midpoints of its data; within the data's budget."""

    def __init__(self, reduced: ReducedBalls) -> None:
        self.lambda1, self.lambda2, self.lambda3 = (x.mid() for x in reduced.lambdas)
        self.coupled = bool(self.lambda1 > 0) and bool(self.lambda3 > 0)
        self.G = reduced.G.mid()
        self.K = [gram.mid() for gram in reduced.K] if self.coupled else []
        self.c = midpoint(reduced.c)
        self.n = reduced.n
        self.floor = self._floor(reduced)
        self.fee = self.lambda3 * self.lambda3 / 4
        self.budget = reduced.budget

    def _floor(self, reduced: ReducedBalls) -> Any:
        """S^-1 where lambda3 = 0."""
        if reduced.null is None or self.coupled:
            return None
        return (reduced.null * self.lambda1).mid()

    def state(self, w: Numbers, t: Numbers) -> State:
        """S^-1, q = S^-1 w and K_i q."""
        if not self.coupled:
            q = [flint.arb(0)] * self.n if self.floor is None else midpoint(times(self.floor, w))
            return State(self.floor, q, [])
        self.budget.require(matrix_cost(self.n**3))
        S = flint.arb_mat(self.n, self.n)
        for a in range(self.n):
            S[a, a] = 1 / self.lambda1
        for weight, gram in zip(t, self.K, strict=True):
            if weight != 0:
                S = S + gram * weight
        inverse = S.mid().inv().mid()
        q = midpoint(times(inverse, w))
        return State(inverse, q, [midpoint(times(gram, q)) for gram in self.K])

    def value(self, w: Numbers, t: Numbers, q: Numbers) -> Number:
        """The value h(w, t)."""
        linear = self.fee * sum(t, flint.arb(0))
        return dot(w, times(self.G, w)) - 2 * dot(self.c, w) + dot(w, q) + linear

    def derivatives(self, w: Numbers, state: State) -> tuple[Numbers, Any]:
        """Gradient and Hessian of h in (w, t)."""
        n, m, q = self.n, len(self.K), state.q
        self.budget.require(ENTRY_COST * (n + m) ** 2)
        H = flint.arb_mat(n + m, n + m)
        gradient = [2 * (g - c + p) for g, c, p in zip(times(self.G, w), self.c, q, strict=True)]
        top = 2 * (self.G if state.inverse is None else self.G + state.inverse)
        for a in range(n):
            for b in range(n):
                H[a, b] = top[a, b]
        columns = [times(state.inverse, v) for v in state.Kq]
        for i in range(m):
            gradient.append(self.fee - dot(q, state.Kq[i]))
            for a in range(n):
                H[a, n + i] = H[n + i, a] = -2 * columns[i][a]
            for k in range(m):
                H[n + i, n + k] = 2 * dot(state.Kq[i], columns[k])
        return gradient, H
