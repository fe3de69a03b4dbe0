"""A request: one problem as the JSON line that a solver under judgement reads."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from pydantic_core import to_json

from convexperc.errors import InputError
from convexperc.problem.problem import Problem

LAMBDAS = ("lambda1", "lambda2", "lambda3")


@dataclass(frozen=True, eq=False)
class Request:
    """One problem with an id.

    Attributes
    ----------
    id : str
    problem : Problem
        Its modalities are consecutive columns.
    """

    id: str
    problem: Problem

    def __post_init__(self) -> None:
        if not all(isinstance(columns, slice) for columns in self.problem.modalities):
            must = "must be consecutive columns, since a request gives their sizes alone"
            raise InputError("modalities", value=self.problem.modalities, must=must)

    def as_json(self) -> dict[str, Any]:
        """``id``, ``n``, ``d``, ``modalities`` (sizes), ``X``, ``o``, ``lambda1`` .. ``lambda3``.

        Numbers are the shortest decimals that float64 reads back to the same bits.
        """
        problem = self.problem
        sizes = list(map(int, problem.modalities.sizes))
        data = {"id": self.id, "n": problem.n, "d": problem.d, "modalities": sizes}
        data |= {"X": problem.X.tolist(), "o": problem.o.tolist()}
        return data | dict(zip(LAMBDAS, problem.lambdas, strict=True))

    @cached_property
    def line(self) -> str:
        """The request as one line, without its end.

        pydantic-core finds the decimals more than ten times as fast as `json`.
        """
        return to_json(self.as_json()).decode()


def in_float32(problem: Problem) -> Problem | None:
    """The problem with every number rounded to float32; None where one overflows or becomes subnormal or 0.

    A solver in float32 then reads the data exactly, and is judged by the optimum of what it read.
    """
    numbers = np.concatenate([problem.X.ravel(), problem.o, problem.lambdas])
    with np.errstate(over="ignore", under="ignore"):
        rounded = numbers.astype(np.float32).astype(np.float64)
    smallest = float(np.finfo(np.float32).smallest_normal)
    if not np.isfinite(rounded).all() or (np.abs(rounded)[numbers != 0.0] < smallest).any():
        return None
    X, o, lambdas = np.split(rounded, [problem.X.size, problem.X.size + problem.d])
    weights = dict(zip(LAMBDAS, map(float, lambdas), strict=True))
    return Problem(X.reshape(problem.X.shape), o, modalities=problem.modalities, **weights)


def holds_float32(problem: Problem) -> bool:
    """Whether every number of the problem is a float32, and normal or 0."""
    rounded = in_float32(problem)
    return rounded is not None and all(
        np.array_equal(a, b) for a, b in zip(_numbers(problem), _numbers(rounded), strict=True)
    )


def _numbers(problem: Problem) -> tuple[Any, ...]:
    return problem.X, problem.o, problem.lambdas
