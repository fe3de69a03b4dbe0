"""How long one call may spend on ball arithmetic and exact numbers."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any, NoReturn

from convexperc.certificate.rationals import PRODUCTS_PER_SECOND
from convexperc.errors import BudgetError
from convexperc.problem.conversion import real_number

SECONDS = 60.0
"""The budget of a call that names none: what a person may wait for. None of the verifier's small problems
needs a tenth of it, some with 1,000 views need it all (docs/certificates.md)."""


class OutOfBudget(Exception):  # noqa: N818 - no error: the caller keeps what is proved so far
    """The next step is not begun: nothing is left, or it is expected to take longer than what is."""


class Budget:
    """Seconds that one call may spend on ball arithmetic and exact numbers, in all.

    The clock runs inside `running` alone: neither while a solver works in float64, nor while another thread
    has the balls. Before each long step `require` compares what is left with the cost that is expected, so
    that the end comes between two steps.

    Parameters
    ----------
    seconds : real number
        > 0; infinite for no limit.

    Raises
    ------
    BudgetError
        It is no such number.
    """

    def __init__(self, seconds: Any = SECONDS) -> None:
        self.seconds = number = real_number(seconds, "seconds", BudgetError)
        if not number > 0.0:
            must, remedy = "must be a number > 0", "Pass math.inf for no limit."
            raise BudgetError("seconds", value=seconds, must=must, remedy=remedy)
        self.spent = False
        self._used = 0.0
        self._since: float | None = None

    @property
    def left(self) -> float:
        """Seconds."""
        running = 0.0 if self._since is None else perf_counter() - self._since
        return self.seconds - self._used - running

    @property
    def products(self) -> float:
        """What is left, in products of machine words."""
        return self.left * PRODUCTS_PER_SECOND

    @property
    def reason(self) -> str:
        """Why no more is proved; empty unless the budget ended the work."""
        if not self.spent:
            return ""
        return f"the budget of {self.seconds:g} s for ball arithmetic does not suffice; give more `seconds`"

    def require(self, products: float | int = 0) -> None:
        """Go on only if a step of so many products of machine words may be begun.

        Raises
        ------
        OutOfBudget
            The budget is spent from now on.
        """
        left = self.products
        if self.spent or left <= 0.0 or products > left:
            self.refuse()

    def refuse(self) -> NoReturn:
        """End the work: a step would take longer than what is left."""
        self.spent = True
        raise OutOfBudget

    @contextmanager
    def running(self) -> Iterator[None]:
        """Let the clock run inside the block."""
        if self._since is not None:
            yield
            return
        self._since = perf_counter()
        try:
            yield
        finally:
            self._used += perf_counter() - self._since
            self._since = None


def unlimited() -> Budget:
    """A budget without an end."""
    return Budget(math.inf)
