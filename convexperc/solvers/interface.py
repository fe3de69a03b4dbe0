"""What every solver looks like: a frozen bundle of named parameters with one method."""

from typing import Protocol, runtime_checkable

from convexperc.problem.problem import Problem
from convexperc.solution.solution import Candidate


@runtime_checkable
class Solver(Protocol):
    """Answers one normalised problem; judges nothing."""

    @property
    def name(self) -> str:
        """Short name, for reports."""

    def candidate(self, problem: Problem) -> Candidate:
        """Answer `problem`.

        Raises
        ------
        SolverError
            The solver raised, returned no point, or cannot treat this kind of problem.
        """
