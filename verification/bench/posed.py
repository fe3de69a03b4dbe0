"""A solver with its set-up done, as the benchmark sees it; and the library's own."""

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from convexperc.problem.arrays import Vector
from convexperc.solvers.newton.method import Batch, Newton
from verification.bench.instances import Instance, Lambdas

Answer = tuple[float, Any]
"""Seconds, and what the solver returned."""


class Posed(ABC):
    """A solver with its set-up done."""

    def __init__(self, instance: Instance, lambdas: Lambdas, tolerance: float) -> None:
        self.instance, self.lambdas, self.tolerance = instance, lambdas, tolerance
        self._pose()

    def _pose(self) -> None:  # noqa: B027 - nothing, unless a solver has set-up
        """Do what all templates share."""

    def _load(self, template: int) -> None:  # noqa: B027 - nothing, unless data are read in
        """Read a template's data in; its time is not counted."""

    @abstractmethod
    def _solve(self, template: int) -> Any:
        """Solve one template."""

    def point(self, found: Any) -> tuple[Vector, Vector]:
        """(w, u) of what `solve` returned; its time is not counted."""
        return self.instance.reduced.point(np.asarray(found, dtype=np.float64))

    def run(self, templates: Sequence[int]) -> list[Answer]:
        """Time the templates one by one."""
        answers = []
        for template in templates:
            self._load(template)
            start = time.perf_counter()
            found = self._solve(template)
            answers.append((time.perf_counter() - start, found))
        return answers


class Ours(Posed):
    """All templates of the frame in one call; each takes its share of the time."""

    def _pose(self) -> None:
        self.solver = Newton(tolerance=self.tolerance)
        self.each = np.tile(self.lambdas, (self.instance.shape.p, 1))

    def _batch(self, templates: slice) -> Batch:
        C, targets = self.instance.C[templates], self.instance.targets[templates]
        reduction = self.instance.reduced.reduction
        return self.solver.batch(reduction.G, reduction.K, C, targets, self.each[templates])

    def _solve(self, template: int) -> tuple[Vector, Vector, Vector]:
        batch = self._batch(slice(template, template + 1))
        return batch.W[0], batch.T[0], batch.Q[0]

    def point(self, found: Any) -> tuple[Vector, Vector]:
        """(w, u) by u^i = t_i X_i' q."""
        w, t, q = found
        return w, self.instance.reduced.reduction.recover(t, q)

    def run(self, templates: Sequence[int]) -> list[Answer]:
        """Time the whole frame; the answers are those of the templates asked for."""
        start = time.perf_counter()
        batch = self._batch(slice(None))
        each = (time.perf_counter() - start) / self.instance.shape.p
        return [(each, (batch.W[j], batch.T[j], batch.Q[j])) for j in templates]


class OursAlone(Ours):
    """One template a call, from a cold start."""

    def run(self, templates: Sequence[int]) -> list[Answer]:
        """Time the templates one by one."""
        return Posed.run(self, templates)
