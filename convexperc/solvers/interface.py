"""What every solver looks like: a frozen bundle of named parameters with one method."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class SolverResult:
    """A solver's answer to one problem; nothing is proved of it yet.

    Attributes
    ----------
    w : float64 (n,)
    u : float64 (d,)
    solver_status : str
        What the solver says of its answer, word for word; nothing relies on it.
    iterations : int
    dual : pair of float64 (d,) and (n,), or None
        The solver's own dual point (a, b), to be tried by the certificate.
    """

    w: Vector
    u: FeatureVector
    solver_status: str
    iterations: int
    dual: tuple[FeatureVector, Vector] | None = None


@runtime_checkable
class Solver(Protocol):
    """Answers one normalised problem; judges nothing."""

    @property
    def name(self) -> str:
        """Short name, for reports."""

    def solve(self, problem: Problem) -> SolverResult:
        """Answer `problem`.

        Raises
        ------
        SolverError
            The solver raised, returned no point, or cannot treat this kind of problem.
        """
