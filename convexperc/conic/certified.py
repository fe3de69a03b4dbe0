"""Solvers of CVXPY whose answers come with a proved interval of the optimal value."""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
from cvxpy import settings
from cvxpy.reductions.solvers.conic_solvers.clarabel_conif import CLARABEL
from cvxpy.reductions.solvers.conic_solvers.scs_conif import SCS
from cvxpy.reductions.solvers.qp_solvers.osqp_qpif import OSQP
from cvxpy.reductions.solvers.qp_solvers.qp_solver import QpSolver
from cvxpy.reductions.solvers.solver import Solver

from convexperc.conic.exchange import point_of, program_of, with_heights
from convexperc.conic.program import Floats, NoBoundError
from convexperc.conic.proof import ConicInterval, nothing, prove
from convexperc.errors import InputError, ToleranceError
from convexperc.problem.arrays import nonnegative_number

INTERFACES: dict[str, type[Any]] = {"CLARABEL": CLARABEL, "SCS": SCS, "OSQP": OSQP}
"""CVXPY's interfaces of the solvers whose answers are read."""
CAPABILITIES = (
    "SUPPORTED_CONSTRAINTS",
    "REQUIRES_CONSTR",
    "SOC_DIM3_ONLY",
    "DIR_CONE_KINDS",
    "PSD_TRIANGLE_KIND",
    "PSD_SQRT2_SCALING",
    "EXP_CONE_ORDER",
)
"""What CVXPY asks of an interface before it makes the data; integer variables are not among it."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What `problem.solver_stats.extra_stats` holds.

    Attributes
    ----------
    interval : ConicInterval
        Of the optimal value of the program that CVXPY handed to the solver, which is always minimised.
    solver : object
        What the solver's own interface puts there.
    """

    interval: ConicInterval
    solver: Any


@dataclass(frozen=True, eq=False)
class _Answer:
    """A solver's answer with the data that it answers."""

    raw: Any
    data: dict[str, Any]
    again: Callable[[dict[str, Any]], Any]


class Certified(Solver):  # type: ignore[misc]
    """A solver for CVXPY that solves as another one does and proves an interval of the optimal value.

    ``problem.solve(solver=Certified(cp.CLARABEL))`` gives the status and the values that
    ``problem.solve(solver=cp.CLARABEL)`` gives; then `convexperc.conic.interval` returns
    lower <= p* <= upper, rounding included, or the reason why a side is missing. A status is no evidence: of
    an answer that is called optimal nothing is believed, and one that is called infeasible has no interval.
    Options of the solver are passed to `solve` as usual.

    Parameters
    ----------
    solver : str
        ``cp.CLARABEL``, ``cp.SCS`` or ``cp.OSQP``.
    relative_tolerance : float
        An interval is `certified` if it is no wider than this share of its least magnitude.

    Raises
    ------
    InputError
        The answers of the solver cannot be read.
    ToleranceError
        The tolerance is not a finite number >= 0.
    """

    def __new__(cls, solver: str, relative_tolerance: float = 1e-6) -> "Certified":
        """Return an object that CVXPY takes for a QP solver where the solver is one."""
        kind = _CertifiedQp if _interface(solver) is OSQP else Certified
        made: Certified = super().__new__(kind)
        return made

    def __init__(self, solver: str, relative_tolerance: float = 1e-6) -> None:
        self._solver = _interface(solver)()
        self.relative_tolerance = nonnegative_number(
            relative_tolerance, "relative_tolerance", error=ToleranceError
        )
        for name in CAPABILITIES:
            if hasattr(self._solver, name):
                setattr(self, name, getattr(self._solver, name))

    def name(self) -> str:
        """Return the name that `problem.solver_stats` shows."""
        return f"CERTIFIED {self._solver.name()}"

    def import_solver(self) -> None:
        """Import the solver's package."""
        self._solver.import_solver()

    def supports_quad_obj(self) -> bool:
        """Return whether the solver takes quadratic objectives."""
        return bool(self._solver.supports_quad_obj())

    def accepts(self, problem: Any) -> bool:
        """Return whether the solver takes this problem."""
        return bool(self._solver.accepts(problem))

    def apply(self, problem: Any) -> Any:
        """Return the solver's data, and what turns its answer back."""
        return self._solver.apply(problem)

    def cite(self, data: Any) -> Any:
        """Return the solver's citation."""
        return self._solver.cite(data)

    def solve_via_data(
        self, data: Any, warm_start: bool, verbose: bool, solver_opts: Any, solver_cache: Any = None
    ) -> _Answer:
        """Solve, and keep the data beside the answer."""
        options = copy.deepcopy(solver_opts)
        raw = self._solver.solve_via_data(data, warm_start, verbose, solver_opts, solver_cache)

        def again(other: dict[str, Any]) -> Any:
            return self._solver.solve_via_data(other, False, False, copy.deepcopy(options), None)

        return _Answer(raw, dict(data), again)

    def invert(self, solution: _Answer, inverse_data: Any) -> Any:
        """Return CVXPY's solution, with an `Outcome` among its attributes."""
        found = self._solver.invert(solution.raw, inverse_data)
        given = found.attr.get(settings.EXTRA_STATS)
        interval = self._interval(solution, str(found.status), float(inverse_data[settings.OFFSET]))
        found.attr[settings.EXTRA_STATS] = Outcome(interval, given)
        return found

    def _interval(self, answer: _Answer, status: str, offset: float) -> ConicInterval:
        if status not in settings.SOLUTION_PRESENT:
            return nothing(f"the solver gave no solution; it says {status!r}", self.relative_tolerance)
        x, z = point_of(answer.raw)
        try:
            program = program_of(answer.data, offset)
        except NoBoundError as reason:
            return nothing(str(reason), self.relative_tolerance)
        if x.size != program.n or z.size <= program.kept.max(initial=-1):
            return nothing("the solver's answer does not fit the data", self.relative_tolerance)

        def again(b: Floats) -> Floats | None:
            try:
                return point_of(answer.again(with_heights(answer.data, program.kept, b)))[0]
            except (cp.error.SolverError, ValueError, ArithmeticError):
                return None  # then there is no other point, which `prove` says

        return prove(program, x, z[program.kept], again, self.relative_tolerance)


class _CertifiedQp(Certified, QpSolver):  # type: ignore[misc]
    """The same for solvers that CVXPY gives the data of a quadratic program."""


def _interface(solver: object) -> type[Any]:
    found = INTERFACES.get(solver.upper()) if isinstance(solver, str) else None
    if found is None:
        raise InputError("solver", value=solver, must="must be one of " + ", ".join(map(repr, INTERFACES)))
    return found
