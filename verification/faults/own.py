"""Faults in the verifier itself, and the catalogue of all."""

from fractions import Fraction
from typing import Any

from convexperc.problem.formulation import objective
from convexperc.problem.problem import Problem
from convexperc.solvers.paper.variants import UpdateVariant
from verification.checks import cost, descent, loop
from verification.exact import formulation as oracle
from verification.exact import referee
from verification.exact.numbers import Enclosure
from verification.faults import certificates, features, formulation, recognition, solvers
from verification.faults import descent as limits
from verification.faults import loop as algorithm
from verification.faults.fault import Fault, replaced, together, wrapped
from verification.faults.solvers import with_lambdas

MILLIONTH = Fraction(1, 10**6)
OBJECTIVE, OWN = oracle.objective, descent.own_objective


def _halved_lambda3(problem: Problem, w: Any, u: Any) -> Enclosure:
    """F with a half of its modality norm."""
    return OBJECTIVE(with_lambdas(problem, problem.lambda1, problem.lambda2, problem.lambda3 / 2), w, u)


def _moved(found: referee.Optimum, factor: Fraction) -> referee.Optimum:
    """An optimum that is not where it is."""
    value = Enclosure(found.value.lower * factor, found.value.upper * factor)
    return referee.Optimum(value, found.w, found.views, found.modalities)


def _whole_penalties(problem: Problem, trace: Any, w: Any, u: Any) -> Fraction:
    """F itself for what the absolute update descends."""
    return OBJECTIVE(problem, w, u).lower


OWN_FAULTS = (
    Fault("lambda3 halved in the oracle", "F2/group_lasso", replaced(oracle, "objective", _halved_lambda3)),
    Fault(
        "the referee's optimum a millionth too low",
        "B1/dual",
        wrapped(referee, "optimum", lambda found, *a: _moved(found, 1 - MILLIONTH)),
    ),
    Fault(
        "the referee's optimum a millionth too high",
        "B2/true",
        wrapped(referee, "optimum", lambda found, *a: _moved(found, 1 + MILLIONTH)),
    ),
    Fault(
        "half of lambda where the check asks for lambda",
        "B3/step",
        replaced(loop, "FACTORS", dict.fromkeys(loop.FACTORS, Fraction(1, 2))),
    ),
    Fault(
        "the absolute update said to descend F",
        "T1c/absolute",
        together(
            replaced(UpdateVariant, "own_objective", lambda self, p, w, u: objective(p, w, u)),
            replaced(descent, "own_objective", _whole_penalties),
        ),
    ),
)

COST = (
    Fault("Woodbury's identity not used", "C1/woodbury", replaced(cost, "woodbury", cost.step7)),
    Fault("nothing is reduced", "C1/reduction", replaced(cost.Iterate, "reduced", lambda self: self)),
    Fault(
        "of a system the diagonal alone is solved",
        "C1/step6",
        replaced(
            cost, "eliminated", lambda A, b: [x / row[i] for i, (row, x) in enumerate(zip(A, b, strict=True))]
        ),
        also=("C1/step7",),
    ),
)

FAULTS: tuple[Fault, ...] = (
    *formulation.OBJECTIVE,
    *formulation.DERIVATION,
    *algorithm.UPDATES,
    *algorithm.TRACE,
    *limits.DESCENT,
    *certificates.DUAL,
    *certificates.WORDS,
    *solvers.SOLVERS,
    *solvers.ANSWERS,
    *recognition.LABEL,
    *features.PICTURE,
    *OWN_FAULTS,
    *COST,
)
