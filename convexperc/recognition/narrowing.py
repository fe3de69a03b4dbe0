"""Rivals whose intervals overlap, narrowed by ball arithmetic: all coarsely, then those that are left."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int

from convexperc.certificate.data_bounds import Intervals
from convexperc.certificate.tolerances import Tolerances
from convexperc.enclosure.budget import Budget, OutOfBudget
from convexperc.enclosure.enclosure import finite_start
from convexperc.enclosure.exact_data import ExactViews
from convexperc.enclosure.levels import BITS, Known, float_answer
from convexperc.enclosure.result import Enclosure
from convexperc.errors import BudgetError, check_type
from convexperc.recognition.decision import Decision, costs
from convexperc.recognition.recognition import Recognition, compared_squares
from convexperc.solution.answers import Answers

NARROWEST = Tolerances(1e-30, 1e-30)
"""Widths asked of overlapping intervals; what is reported is limited by float64, about 1e-16."""


def narrowed_answers(found: Recognition, budget: Budget) -> Iterator[Answers]:
    """The answers with narrower intervals of the rivals, after each precision.

    In each precision the rivals with the lowest upper bounds come first; one that another excludes is
    narrowed no more. It ends where no rival can be narrowed, or the budget is spent.
    """
    check_type(found, Recognition, "found")
    check_type(budget, Budget, "budget", BudgetError)
    with suppress(OutOfBudget):
        with budget.running():
            shared = ExactViews.of(found.answers.data.views, budget)
        rivals = _Rivals.of(found)
        held = found.answers.data.views.normalised  # so that it is made once
        levels = {group[0]: _levels(found.answers, group[0], budget, shared) for group in rivals.groups}
        while rivals.advance(levels) and not budget.spent:
            yield rivals.answers(found.answers)
        yield rivals.answers(found.answers)
        del held


def _levels(answers: Answers, j: int, budget: Budget, shared: ExactViews) -> Iterator[Enclosure]:
    """Enclosures of template j in one precision after the other."""
    problem = answers.problem(j)
    near = float_answer(problem, finite_start(answers.w[j], answers.u(j)))
    with suppress(OutOfBudget):
        yield from Known.of(problem, near, budget, shared).levels(BITS[0], NARROWEST)


@dataclass(frozen=True, eq=False)
class _Rivals:
    """Bounds of every F*, and of what decides.

    Attributes
    ----------
    groups : lists of int
        Templates of the same data, lowest upper bound first.
    given, optima, squares, cost : (lower, upper), float64 (p,)
        Of F* before and now, of ||o||^2, and of what decides.
    decision : Decision
    """

    groups: list[list[int]]
    given: Intervals
    optima: Intervals
    squares: Intervals
    cost: Intervals
    decision: Decision

    @classmethod
    def of(cls, found: Recognition) -> "_Rivals":
        """The templates that are not excluded."""
        answers, groups = found.answers, dict[bytes, list[int]]()
        lower, upper = (bound.copy() for bound in found.costs)
        order = np.argsort(upper, kind="stable")
        for j in order[~found.excluded[order]].tolist():
            groups.setdefault(answers.data.library.template(j).tobytes(), []).append(j)
        given, squares = (answers.lower, answers.upper), compared_squares(answers)
        optima = answers.lower.copy(), answers.upper.copy()
        return cls(list(groups.values()), given, optima, squares, (lower, upper), found.decision)

    def advance(self, levels: dict[int, Iterator[Enclosure]]) -> bool:
        """Narrow every rival that is left in the next precision; false where there is none for any."""
        narrowed = False
        for group in self.groups:
            if self.cost[0][group[0]] > self.cost[1].min():
                continue
            tight = next(levels[group[0]], None)
            if tight is not None:
                self._put(np.array(group), tight)
                narrowed = True
        return narrowed

    def _put(self, group: Int[np.ndarray, " k"], tight: Enclosure) -> None:
        """The bounds of one group."""
        for mine, given, end, closer in zip(
            self.optima, self.given, (tight.lower, tight.upper), (np.maximum, np.minimum), strict=True
        ):
            mine[group] = closer(given[group], end)
        optima = self.optima[0][group], self.optima[1][group]
        squares = self.squares[0][group], self.squares[1][group]
        for mine, new in zip(self.cost, costs(self.decision, optima, squares), strict=True):
            mine[group] = new

    def answers(self, before: Answers) -> Answers:
        """The same answers with these intervals."""
        return replace(before, lower=self.optima[0].copy(), upper=self.optima[1].copy())
