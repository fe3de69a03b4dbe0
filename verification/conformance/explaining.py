"""Why an answer fails: the four terms of F at the answer, and at a point that is better."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem

ENTRIES, DIGITS = 8, 6
"""Entries of a vector, and digits of a number, that one line shows."""


@dataclass(frozen=True, eq=False)
class Point:
    """A point and the terms of F there, in float64.

    Attributes
    ----------
    w : float64 (n,)
    u : float64 (d,)
    terms : tuple of float
        ||X'w - o||^2, lambda1 ||Xu - w||^2, lambda2 ||w||_1, lambda3 sum_i ||u^i||.
    """

    w: Vector
    u: Vector
    terms: tuple[float, ...]

    @classmethod
    def of(cls, problem: Problem, w: Vector, u: Vector) -> "Point":
        """Evaluate the terms at (w, u)."""
        with np.errstate(all="ignore"):
            loss, coupling = problem.X.T @ w - problem.o, problem.X @ u - w
            norms = sum(float(np.linalg.norm(u[columns])) for columns in problem.modalities)
            sums = loss @ loss, coupling @ coupling, np.abs(w).sum(), norms
        return cls(w, u, tuple(float(x * y) for x, y in zip((1.0, *problem.lambdas), sums, strict=True)))

    @property
    def text(self) -> str:
        """One line."""
        terms = " + ".join(f"{x:.{DIGITS}g}" for x in self.terms)
        return f"w {_short(self.w)}, u {_short(self.u)}; F = {terms} = {sum(self.terms):.{DIGITS}g}"

    def as_json(self) -> dict[str, Any]:
        """Plain data; a term beyond float64 is null."""
        terms = [x if np.isfinite(x) else None for x in self.terms]
        return {"w": self.w.tolist(), "u": self.u.tolist(), "terms": terms}


@dataclass(frozen=True, eq=False)
class Explanation:
    """What was answered, and what is better."""

    answered: Point
    better: Point

    @property
    def lines(self) -> tuple[str, str]:
        """Two lines."""
        return f"answered: {self.answered.text}", f"better:   {self.better.text}"

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"answered": self.answered.as_json(), "better": self.better.as_json()}


def explain(problem: Problem, w: Vector, u: Vector, better: tuple[Vector, Vector]) -> Explanation:
    """Compare an answer (w, u) with a better point."""
    return Explanation(Point.of(problem, w, u), Point.of(problem, *better))


def _short(x: Vector) -> str:
    shown = ", ".join(f"{value:.{DIGITS}g}" for value in x[:ENTRIES])
    return f"[{shown}{', ...' if x.size > ENTRIES else ''}]"
