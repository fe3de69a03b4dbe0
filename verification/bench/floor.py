"""A whole recognition against its floor: the Gram matrices and the product X O; and how its cost grows."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from statistics import median

import numpy as np

from convexperc.problem.reduction import Reduction
from convexperc.recognition.label import recognize
from convexperc.recognition.recognition import Recognition, Verdict
from convexperc.recognition.warming import warm
from convexperc.solvers.newton.method import Newton
from verification.bench.instances import LAMBDAS, Instance, Lambdas, Shape

TOLERANCE = 9e-10
"""Relative gap asked of every template."""
BASE = Shape("growth", 32, (1000, 1000, 1000), 32, 76)
"""Where the growth is measured from, one size at a time."""
STEPS = {"n": (16, 32, 64, 128), "d": (1500, 3000, 6000, 12000), "m": (2, 4, 8, 16), "p": (8, 32, 128, 512)}


@dataclass(frozen=True)
class FrameTimes:
    """Median seconds of one frame.

    Attributes
    ----------
    floor : float
        The Gram matrices and X O alone.
    recognition : tuple of float
        From X and a library made once to the proved label with its w and u, for each choice of the lambdas.
    labelled : int
        Choices of the lambdas whose label is proved.
    full : tuple of int
        Templates that were solved to the end; lower bounds excluded the others.
    """

    floor: float
    recognition: tuple[float, ...]
    labelled: int
    full: tuple[int, ...]

    @property
    def ratios(self) -> tuple[float, ...]:
        """Recognition over floor."""
        return tuple(seconds / self.floor for seconds in self.recognition)


@dataclass(frozen=True)
class Growth:
    """Times of growing frames, and the exponents that fit them best.

    Attributes
    ----------
    size : str
        Which size grows: n, d, m or p.
    values : tuple of int
    floor, solve : tuple of float
        Seconds: the floor, and all templates solved after it.
    """

    size: str
    values: tuple[int, ...]
    floor: tuple[float, ...]
    solve: tuple[float, ...]

    @property
    def exponents(self) -> tuple[float, float]:
        """Least squares of log time against log size, for the floor and the solves."""
        floor, solve = (
            np.polyfit(np.log(self.values), np.log(times), 1)[0] for times in (self.floor, self.solve)
        )
        return float(floor), float(solve)


def frame_times(instance: Instance, repeat: int) -> FrameTimes:
    """Time the floor and the recognition, by machine code; a first call of each is not counted."""
    warm()
    found = [_summary(instance, lambdas) for lambdas in LAMBDAS]
    floor = timed(partial(_floor, instance), repeat)
    whole = tuple(timed(partial(_recognised, instance, lambdas), repeat) for lambdas in LAMBDAS)
    return FrameTimes(floor, whole, sum(proved for proved, _ in found), tuple(full for _, full in found))


def growth(repeat: int) -> list[Growth]:
    """Grow n, d, m and p in turn from `BASE`, by machine code."""
    warm()
    found = []
    for size, values in STEPS.items():
        floors, solves = [], []
        for value in values:
            instance = Instance.of(_grown(size, value))
            reduction, C, targets = _floor_and_norms(instance)
            floors.append(timed(partial(_floor, instance), repeat))
            solves.append(timed(partial(_solve, reduction, C, targets, LAMBDAS[0]), repeat))
        found.append(Growth(size, values, tuple(floors), tuple(solves)))
    return found


def _grown(size: str, value: int) -> Shape:
    m = value if size == "m" else len(BASE.sizes)
    d = value if size == "d" else BASE.d
    sizes = tuple(d // m + (i < d % m) for i in range(m))
    n, p = value if size == "n" else BASE.n, value if size == "p" else BASE.p
    return replace(BASE, n=n, sizes=sizes, p=p)


def timed(work: Callable[[], object], repeat: int) -> float:
    """Median seconds of `repeat` calls; one before them is not counted."""
    work()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return median(times)


def _floor(instance: Instance) -> None:
    for columns in instance.modalities:
        block = instance.X[:, columns]
        block @ block.T
    instance.X @ instance.O


def _floor_and_norms(instance: Instance) -> tuple[Reduction, np.ndarray, np.ndarray]:
    C = np.ascontiguousarray((instance.X @ instance.O).T)
    targets = np.einsum("dp,dp->p", instance.O, instance.O)
    return Reduction.of(instance.X, instance.modalities), C, targets


def _solve(reduction: Reduction, C: np.ndarray, targets: np.ndarray, lambdas: Lambdas) -> None:
    every = np.tile(lambdas, (C.shape[0], 1))
    Newton(tolerance=TOLERANCE).batch(reduction.G, reduction.K, C, targets, every)


def _summary(instance: Instance, lambdas: Lambdas) -> tuple[bool, int]:
    """Whether the label is proved, and how many templates were solved to the end."""
    found = _recognised(instance, lambdas)
    return found.verdict is Verdict.PROVED, int(found.answers.certified.sum())


def _recognised(instance: Instance, lambdas: Lambdas) -> Recognition:
    one, two, three = lambdas
    found = recognize(instance.X, instance.library, lambda1=one, lambda2=two, lambda3=three)
    _ = found.template().w, found.template().u
    return found
