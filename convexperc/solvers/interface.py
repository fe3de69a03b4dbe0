"""The interface of every solver: frozen parameters, a name and one method."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class SolverResult:
    """A solver's answer to one problem; no bound of its error is proved yet.

    Attributes
    ----------
    w : float64 (n,)
    u : float64 (d,)
    solver_status : str
        The solver's own status text, verbatim; no certificate uses it.
    iterations : int
        As the solver counts them.
    dual : pair of float64 (d,) and (n,), or None
        The solver's dual point (a, b), which the certificate may use.
    """

    w: Vector
    u: FeatureVector
    solver_status: str
    iterations: int
    dual: tuple[FeatureVector, Vector] | None = None


@runtime_checkable
class Solver(Protocol):
    """Answers one normalised problem; the certificate bounds its error."""

    @property
    def name(self) -> str:
        """Short name, for reports."""

    def solve(self, problem: Problem) -> SolverResult:
        """Answer `problem`.

        Raises
        ------
        SolverError
            The solver raised, returned no point, or does not support this kind of problem.
        """
