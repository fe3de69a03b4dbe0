"""The interval of a CVXPY problem after it was solved, and for which problems it can be given."""

from collections.abc import Iterator
from typing import Any

import cvxpy as cp
from cvxpy.atoms.affine.affine_atom import AffAtom
from cvxpy.atoms.quad_form import QuadForm

from convexperc.conic.certified import Certified, Outcome
from convexperc.conic.proof import ConicInterval, nothing
from convexperc.errors import InputError

EXACT_REDUCTIONS = frozenset({
    "EvalParams", "FlipObjective", "Dcp2Cone", "CvxAttr2Constr", "EliminateZeroSized", "ConeMatrixStuffing",
})  # fmt: skip
"""Steps of CVXPY that leave the optimal value as it is, but for its sign."""
EXACT_ATOMS = frozenset({
    "abs", "huber", "max", "maximum", "min", "minimum", "norm1", "norm_inf", "Pnorm", "PnormApprox", "power",
    "Power", "PowerApprox", "quad_over_lin", "QuadForm", "sum_largest",
})  # fmt: skip
"""Atoms beside the affine ones whose canonical form was derived; norms and powers with exponent 2 alone."""


def interval(problem: Any) -> ConicInterval:
    """Return what `Certified` proved of the optimal value of a problem when it was solved last.

    It holds for the numbers that CVXPY handed to the solver: its own float64 arithmetic on constants and
    parameters, such as the product of two constant matrices, comes before them and is not covered.

    Parameters
    ----------
    problem : cvxpy.Problem

    Returns
    -------
    ConicInterval
        In the sense of the problem, which may be maximised.

    Raises
    ------
    InputError
        The problem was not solved by `Certified`.
    """
    stats = getattr(problem, "solver_stats", None)
    outcome = getattr(stats, "extra_stats", None)
    if not isinstance(outcome, Outcome):
        remedy = "Solve it first: problem.solve(solver=Certified(cp.CLARABEL))."
        raise InputError("problem", value=problem, must="must have been solved by Certified", remedy=remedy)
    found = outcome.interval
    reason = _not_covered(problem)
    if reason:
        return nothing(reason, found.relative_tolerance)
    return found.negated() if isinstance(problem.objective, cp.Maximize) else found


def _not_covered(problem: Any) -> str:
    """Why the optimal value of the problem may not be that of the program solved; empty where it is."""
    chain = getattr(getattr(problem, "_cache", None), "solving_chain", None)
    reductions = getattr(chain, "reductions", None)
    if not reductions or not isinstance(reductions[-1], Certified):
        return "it is not known how CVXPY reduced the problem"
    for step in reductions[:-1]:
        if type(step).__name__ not in EXACT_REDUCTIONS:
            return f"CVXPY's reduction {type(step).__name__} is not covered"
    objective = problem.objective.expr
    for atom, quadratic in [*_atoms(objective, True), *(a for c in problem.constraints for a in _of(c))]:
        if type(atom).__name__ not in EXACT_ATOMS:
            return f"the atom {type(atom).__name__} is not covered"
        exponent = getattr(atom, "p", 2)
        if float(getattr(exponent, "value", exponent)) not in (1.0, 2.0):
            return f"the atom {type(atom).__name__} is covered with the exponent 2 alone"
        if isinstance(atom, QuadForm) and not (quadratic and reductions[-1].supports_quad_obj()):
            return "quad_form is factorised in float64 here; write sum_squares(R @ x) with your own R"
    return ""


def _of(constraint: Any) -> Iterator[tuple[Any, bool]]:
    for part in constraint.args:
        yield from _atoms(part, False)


def _atoms(expression: Any, quadratic: bool) -> Iterator[tuple[Any, bool]]:
    """The atoms that are not affine, and whether all above them in the objective are."""
    affine = isinstance(expression, AffAtom)
    if getattr(expression, "args", None) and not affine:
        yield expression, quadratic
    for part in getattr(expression, "args", []):
        yield from _atoms(part, quadratic and affine)
