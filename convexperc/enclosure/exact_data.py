"""The data as they are given, for ball arithmetic of any precision."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import flint

from convexperc.caching import cached_property
from convexperc.certificate.rationals import READ_COST, RowSpace
from convexperc.enclosure.balls import Numbers, exact_matrix, matrix_cost, precision, times
from convexperc.enclosure.budget import Budget, unlimited
from convexperc.problem.problem import Problem
from convexperc.problem.views import Views


@dataclass(frozen=True, eq=False)
class ExactViews:
    """X_i of every modality, and what follows from X alone: the templates of one set of views share it.

    Attributes
    ----------
    views : Views
    blocks : tuple of arb_mat (n, d_i)
    budget : Budget
        Of the call; where it does not suffice, the methods raise `OutOfBudget`.
    """

    views: Views
    blocks: tuple[Any, ...]
    budget: Budget
    _kept: dict[str, tuple[int, Any]] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, views: Views, budget: Budget) -> "ExactViews":
        """Take over the floats."""
        budget.require(READ_COST * views.X.size)
        blocks = tuple(exact_matrix(views.X[:, columns]) for columns in views.modalities)
        return cls(views, blocks, budget)

    @cached_property
    def space(self) -> RowSpace:
        """The span of the rows of X."""
        found = RowSpace.within_limit(self.views.X, self.budget.products)
        if found is None:
            self.budget.refuse()
        return found

    @property
    def grams(self) -> list[Any]:
        """X_i X_i' of every modality in the precision in force, arb_mat (n, n)."""
        n, d = self.views.X.shape

        def find() -> list[Any]:
            self.budget.require(matrix_cost(n * n * d))
            return [block * block.transpose() for block in self.blocks]

        found: list[Any] = self._in_force("grams", find)
        return found

    @property
    def null(self) -> Any:
        """`null_projection` of the span in the precision in force."""
        return self._in_force("null", lambda: null_projection(self.space, self.budget))

    def _in_force(self, name: str, find: Callable[[], Any]) -> Any:
        """What is kept for the precision in force, or else found and kept in place of another precision's."""
        bits, (kept, found) = flint.ctx.prec, self._kept.get(name, (0, None))
        if kept != bits:
            found = find()
            self._kept[name] = bits, found
        return found


@dataclass(frozen=True, eq=False)
class ExactData:
    """X_i and o^i of every modality.

    Attributes
    ----------
    shared : ExactViews
    targets : tuple of arb_mat (d_i, 1)
    """

    shared: ExactViews
    targets: tuple[Any, ...]

    @classmethod
    def of(
        cls, problem: Problem, budget: Budget | None = None, shared: ExactViews | None = None
    ) -> "ExactData":
        """Take over the floats; without a budget, whatever it costs; `shared` if it is known already."""
        if shared is None:
            shared = ExactViews.of(problem.views, unlimited() if budget is None else budget)
        targets = tuple(exact_matrix(problem.o[columns, None]) for columns in problem.modalities)
        return cls(shared, targets)

    @property
    def budget(self) -> Budget:
        """Of the call."""
        return self.shared.budget

    @property
    def blocks(self) -> tuple[Any, ...]:
        """X_i of every modality, arb_mat (n, d_i)."""
        return self.shared.blocks

    def columns(self, parts: list[Numbers]) -> list[Numbers]:
        """X_i' y_i of every modality."""
        return [times(block.transpose(), y) for block, y in zip(self.blocks, parts, strict=True)]


def null_projection(space: RowSpace, budget: Budget) -> Any:
    """The orthogonal projection I - M (M'M)^-1 M' onto {b : X'b = 0}, arb_mat (n, n); None where that is {0}.

    Every entry is known to the bits of the precision in force, however long the numbers of M'M must be for
    that: M has full column rank, so that enough bits make M'M invertible.
    """
    n, bits = space.A.nrows(), flint.ctx.prec
    if space.rank == n:
        return None
    budget.require(n * space.rank * space.A.ncols() * space.words**2)
    more, error = bits, flint.arb(2) ** -bits
    while True:
        more *= 2
        budget.require(matrix_cost(n * n * space.rank, more))
        with precision(more), suppress(ZeroDivisionError):
            M = flint.arb_mat(space.image)
            found = flint.arb_mat(n, n, 1) - M * (M.transpose() * M).inv() * M.transpose()
            if all(value.rad() <= error for value in found.entries()):
                return found
