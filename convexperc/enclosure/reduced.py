"""The reduced problem of `convexperc.problem.reduction` in ball arithmetic."""

from dataclasses import dataclass
from typing import Any

import flint

from convexperc.certificate.rationals import RowSpace
from convexperc.enclosure.balls import Number, Numbers, column, matrix_cost
from convexperc.enclosure.budget import Budget
from convexperc.enclosure.exact_data import ExactData
from convexperc.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class ReducedBalls:
    """K_i = X_i X_i', G, c = X o and ||o||^2 of the normalised problem, enclosed; and its lambdas.

    Attributes
    ----------
    K : list of arb_mat (n, n)
    G : arb_mat (n, n)
    c : list of n arb
    target : arb
        ||o||^2.
    lambdas : tuple of three arb
    null : arb_mat (n, n) or None
        The orthogonal projection onto {b : X'b = 0}; only where lambda3 = 0 < lambda1, and None where that
        space is {0}.
    space : RowSpace or None
        Where lambda3 = 0 < lambda1 or lambda1 = lambda2 = 0.
    budget : Budget
        Of what is computed with these numbers.
    """

    K: list[Any]
    G: Any
    c: Numbers
    target: Number
    lambdas: tuple[Number, Number, Number]
    null: Any
    space: RowSpace | None
    budget: Budget

    @classmethod
    def of(
        cls, problem: Problem, exponents: tuple[int, int], data: ExactData | None = None
    ) -> "ReducedBalls":
        """Enclose the data of `problem`, scaled by 2^-x and 2^-o, in the precision in force."""
        data = ExactData.of(problem) if data is None else data
        x, t = exponents
        two = flint.arb(2)
        units = two ** (-2 * x), two ** (-x - t), two ** (-2 * t)
        K = [gram * units[0] for gram in data.shared.grams]
        data.budget.require(matrix_cost(problem.n * problem.d))
        c = sum((block * o for block, o in zip(data.blocks, data.targets, strict=True)), _zeros(problem.n, 1))
        target = sum((o.transpose() * o for o in data.targets), _zeros(1, 1))[0, 0]
        powers = units[0], units[1], two ** (-2 * x - t)
        lambdas = [flint.arb(v) * power for v, power in zip(problem.lambdas, powers, strict=True)]
        null, space = None, None
        if problem.lambda3 == 0.0 < problem.lambda1 or problem.lambda1 == problem.lambda2 == 0.0:
            space = data.shared.space
            null = data.shared.null if problem.lambda1 > 0.0 else None
        G = sum(K, _zeros(problem.n, problem.n))
        coupled = lambdas[0], lambdas[1], lambdas[2]
        return cls(K, G, column(c * units[1]), target * units[2], coupled, null, space, data.budget)

    @property
    def n(self) -> int:
        """Number of views."""
        return len(self.c)


def _zeros(rows: int, columns: int) -> Any:
    return flint.arb_mat(rows, columns)
