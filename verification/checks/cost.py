"""C1: what an iteration costs, in multiplications that a number type counts, and in seconds.

Of steps 6 and 7 only the systems of linear equations are counted, as the claim speaks of them: their
matrices and right sides are given. For Woodbury's identity and for the reduced problem everything is counted
that depends on the iterate.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.checks.interface import Observation
from verification.checks.operations import Counted, Counter, Row, counted, eliminated, inner

Numbers = NDArray[np.float64]

VIEWS, MODALITIES = 4, 3
"""n and m where d varies."""
ORDERS = (8, 16, 32, 64)
"""Orders of the systems of steps 6 and 7."""
FEATURES = (24, 48, 96, 192)
"""d for Woodbury's identity and for the reduced problem."""
CLOSE = 0.1
"""How far a fitted exponent may be from the stated one."""
LAMBDA1, LAMBDA2, LAMBDA3 = 0.5, 0.25, 0.125
TIMED_ORDERS = (128, 256, 512, 1024)
TIMED_FEATURES = (1000, 4000, 16000, 64000)
TIMED_VIEWS = 16
"""Sizes for seconds: large enough that arithmetic dominates calls."""
REPEATS = 3


@dataclass(frozen=True)
class Iterate:
    """Data and a point at which an iteration is counted.

    Attributes
    ----------
    X : float64 (n, d)
    w : float64 (n,)
    u : float64 (d,)
    sizes : tuple of int
        Columns of each modality.
    """

    X: Numbers
    w: Numbers
    u: Numbers
    sizes: tuple[int, ...]

    @classmethod
    def of(cls, n: int, d: int) -> "Iterate":
        """Fixed numbers of that size, without an exact zero."""
        rng = np.random.default_rng([n, d])
        sizes = tuple(part.size for part in np.array_split(np.arange(d), min(MODALITIES, d)))
        return cls(rng.random((n, d)) + 0.1, rng.random(n) + 0.1, rng.random(d) + 0.1, sizes)

    def _parts(self) -> list[Numbers]:
        return np.split(self.u, np.cumsum(self.sizes)[:-1])

    @property
    def lengths(self) -> Numbers:
        """||u^i|| at each of the d columns."""
        return np.concatenate([np.full(part.size, np.linalg.norm(part)) for part in self._parts()])

    def views_system(self) -> Numbers:
        """XX' + lambda1 I + lambda2 D^w, D^w = diag(1/(2 |w_i|))."""
        return self.X @ self.X.T + np.diag(LAMBDA1 + LAMBDA2 / (2.0 * np.abs(self.w)))

    def features_system(self) -> Numbers:
        """lambda1 X'X + lambda3 D^u, D^u = blockdiag(I/(2 ||u^i||))."""
        return LAMBDA1 * self.X.T @ self.X + np.diag(LAMBDA3 / (2.0 * self.lengths))

    def reduced(self) -> "Iterate":
        """The same iterate with n columns a modality: X_i replaced by L_i, X_i X_i' = L_i L_i'."""
        blocks = np.split(self.X, np.cumsum(self.sizes)[:-1], axis=1)
        n = self.X.shape[0]
        factors = [np.linalg.cholesky(block @ block.T) for block in blocks]
        rest = np.concatenate(
            [np.linalg.solve(L, B @ x) for L, B, x in zip(factors, blocks, self._parts(), strict=True)]
        )
        return Iterate(np.concatenate(factors, axis=1), self.w, rest, (n,) * len(factors))


def step6(it: Iterate, counter: Counter) -> Row:
    """Solve the n x n system of step 6, its matrix and its right side given."""
    right = counted((it.X @ (LAMBDA1 * it.u))[None, :], counter)[0]
    return eliminated(counted(it.views_system(), counter), right)


def step7(it: Iterate, counter: Counter) -> Row:
    """Solve the d x d system of step 7, its matrix and its right side given."""
    right = counted((LAMBDA1 * it.X.T @ it.w)[None, :], counter)[0]
    return eliminated(counted(it.features_system(), counter), right)


def woodbury(it: Iterate, counter: Counter) -> Row:
    """The same u = lambda1 Di X'(I + lambda1 X Di X')^-1 w, Di = (lambda3 D^u)^-1, and all that it takes."""
    inverse = counted((2.0 * LAMBDA1 * it.lengths / LAMBDA3)[None, :], counter)[0]
    X = counted(it.X, counter)
    scaled = [[a * b for a, b in zip(row, inverse, strict=True)] for row in X]
    system = [[inner(row, other) for other in X] for row in scaled]
    for i, row in enumerate(system):
        row[i] = row[i] + Counted(1.0, counter)
    solved = eliminated(system, counted(it.w[None, :], counter)[0])
    return [inner([row[k] for row in scaled], solved) for k in range(it.X.shape[1])]


def reduction(it: Iterate, counter: Counter) -> Row:
    """Steps 6 and 7 on the reduced problem, the second by Woodbury's identity."""
    reduced = it.reduced()
    step6(reduced, counter)
    return woodbury(reduced, counter)


def multiplications(step: Callable[[Iterate, Counter], Row], it: Iterate) -> int:
    """How many multiplications and divisions a step takes."""
    counter = Counter()
    step(it, counter)
    return counter.operations


@dataclass(frozen=True)
class Growth:
    """How one cost grows.

    Attributes
    ----------
    x : tuple of int
        n for step 6, else d.
    y : tuple of float
        Multiplications, or seconds.
    """

    x: tuple[int, ...]
    y: tuple[float, ...]

    @property
    def slope(self) -> float:
        """The exponent that least squares fits on logarithms."""
        x, y = np.log(np.array(self.x, dtype=np.float64)), np.log(np.array(self.y))
        x, y = x - x.mean(), y - y.mean()
        return float(x @ y / (x @ x))

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"x": list(self.x), "y": list(self.y), "slope": self.slope}


def counts() -> dict[str, Growth]:
    """Count all four; the same at every call."""
    return {
        "step6": Growth(ORDERS, tuple(multiplications(step6, Iterate.of(n, 2 * n)) for n in ORDERS)),
        "step7": Growth(ORDERS, tuple(multiplications(step7, Iterate.of(VIEWS, d)) for d in ORDERS)),
        "woodbury": Growth(
            FEATURES, tuple(multiplications(woodbury, Iterate.of(VIEWS, d)) for d in FEATURES)
        ),
        "reduction": Growth(
            FEATURES, tuple(multiplications(reduction, Iterate.of(VIEWS, d)) for d in FEATURES)
        ),
    }


EXPONENTS = {"step6": 2.0, "step7": 2.0, "woodbury": 1.0, "reduction": 0.0}
"""What the parts of C1 state: in n, in d, in d, in d."""


def observations(growths: dict[str, Growth]) -> list[Observation]:
    """Judge every part of C1: a smaller exponent than the stated one holds as well."""
    found = []
    for name, stated in EXPONENTS.items():
        slope = growths[name].slope
        detail = f"exponent {slope:.3f} for {stated:g}: {growths[name].y} at {growths[name].x}"
        found.append(Observation.of(f"C1/{name}", slope <= stated + CLOSE, abs(slope), detail))
    return found


def times() -> dict[str, dict[str, Any]]:
    """Seconds of the same steps in NumPy at larger sizes; they differ from run to run."""
    wide = [Iterate.of(TIMED_VIEWS, d) for d in TIMED_FEATURES]
    found = {
        "step6": Growth(TIMED_ORDERS, tuple(_system_seconds(n) for n in TIMED_ORDERS)),
        "step7": Growth(TIMED_ORDERS, tuple(_system_seconds(d) for d in TIMED_ORDERS)),
        "woodbury": Growth(TIMED_FEATURES, tuple(_seconds(_woodbury_of(it)) for it in wide)),
        "reduction": Growth(TIMED_FEATURES, tuple(_seconds(_woodbury_of(it.reduced())) for it in wide)),
    }
    return {name: growth.as_json() for name, growth in found.items()}


def _seconds(work: Callable[[], Any]) -> float:
    """The fastest of a few runs."""
    found = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return min(found)


def _system_seconds(order: int) -> float:
    """One dense symmetric system of that order."""
    rng = np.random.default_rng(order)
    A = rng.random((order, order))
    A, b = A @ A.T + order * np.eye(order), rng.random(order)
    return _seconds(lambda: np.linalg.solve(A, b))


def _woodbury_of(it: Iterate) -> Callable[[], Numbers]:
    """The function `woodbury` in NumPy."""
    X, w, inverse = it.X, it.w, 2.0 * LAMBDA1 * it.lengths / LAMBDA3

    def work() -> Numbers:
        scaled = X * inverse
        return np.asarray(scaled.T @ np.linalg.solve(np.eye(w.size) + scaled @ X.T, w))

    return work
