"""One template from problem to proof: normalise, solve, undo, certify."""

import time

import numpy as np

from convexperc.certificate import ABSOLUTE, RELATIVE, Certificate, certify
from convexperc.problem import Problem
from convexperc.scaling import Scaling
from convexperc.solution import Candidate, Solution, Timings
from convexperc.solvers.interface import Solver


def solve(
    problem: Problem,
    solver: Solver,
    *,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
) -> Solution:
    """Minimise F and prove how well.

    The solver sees the exactly normalised problem; its answer is scaled back exactly and judged on the data
    as given. Where w = u = 0 is at least as good, by proof, that is the answer.

    Parameters
    ----------
    problem : Problem
    solver : Solver
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.Certificate`.

    Returns
    -------
    Solution
        Its `status` says whether it is certified; nothing else does.

    Raises
    ------
    SolverError
        The solver gave no point at all.
    """
    start = time.perf_counter()
    scaling = Scaling.of(problem)
    normal = scaling.normalise(problem)
    normalised = time.perf_counter()
    candidate = solver.candidate(normal)
    solved = time.perf_counter()
    w, u, certificate = _judge(problem, scaling, candidate, (relative_tolerance, absolute_tolerance))
    done = time.perf_counter()
    w.flags.writeable = u.flags.writeable = False
    timings = Timings(normalised - start, solved - normalised, done - solved)
    return Solution(problem, w, u, certificate, solver.name, candidate.claim, candidate.iterations, timings)


def _judge(
    problem: Problem, scaling: Scaling, candidate: Candidate, tolerances: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, Certificate]:
    """Certify the candidate, and the zero point; keep the one with the smaller proved gap."""
    relative, absolute = tolerances
    w, u = scaling.point_back(candidate.w, candidate.u)
    dual = None if candidate.dual is None else scaling.dual_back(*candidate.dual)
    found = certify(problem, w, u, dual=dual, relative_tolerance=relative, absolute_tolerance=absolute)
    zero = np.zeros(problem.n), np.zeros(problem.d)
    rest = certify(problem, *zero, dual=dual, relative_tolerance=relative, absolute_tolerance=absolute)
    if rest.gap <= found.gap or (rest.certified and not found.certified):
        return *zero, rest
    return w, u, found
