"""Faults in the judge: in its dual points, its rounding, its bounds and its words."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from convexperc.certificate import certificate, duality, evaluation, lambda_max, rounding
from convexperc.certificate import screening as optimum
from convexperc.certificate.certificate import Certificate
from convexperc.certificate.data_bounds import DataBounds
from convexperc.certificate.tolerances import Tolerances
from convexperc.problem.penalties import Penalties
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solvers.newton.method import Newton
from verification.exact import referee
from verification.faults.fault import Fault, Plant, replaced, together, wrapped


def frame_with(**factors: float) -> Plant:
    """Multiply the normalised lambdas that the judge sees."""
    original = evaluation.NormalizedData.of

    def of(problem: Problem, scaling: Scaling) -> evaluation.NormalizedData:
        true = original(problem, scaling)
        changed = {key: _times(factor, getattr(true, key)) for key, factor in factors.items()}
        return replace(true, **changed)

    return replaced(evaluation.NormalizedData, "of", of)


def _times(factor: float, bounds: tuple[float, float]) -> Any:
    return factor * bounds[0], factor * bounds[1]


def _zeros(views: Callable[[Any], Any], modalities: Callable[[Any], Any]) -> Plant:
    """Other zeros than those that are proved."""
    return wrapped(certificate, "proved_zeros", lambda zeros, *a: (views(zeros[0]), modalities(zeros[1])))


def _kept(zeros: Any) -> Any:
    return zeros


def _loosely(self: Tolerances, gap: Any, lower: Any, target: Any) -> Any:
    """`Tolerances.met` with 1e-7 for the absolute tolerance."""
    return (gap <= self.relative * lower) | (gap <= 1e-7 * target)


def _optimal_from_half(self: DataBounds, penalties: Penalties) -> Any:
    """lambda2 >= ||X o_j||_inf."""
    lambda2 = self.data.normalised(penalties)[:, 1]
    return self.data.sound & (lambda2 >= np.abs(self.data.C).max(axis=1))


def _stopped_early(self: Newton, problem: Problem) -> Any:
    return SOLVE(replace(self, tolerance=1e-3), problem)


def _with_slack(found: referee.Optimum, *arguments: Any) -> referee.Optimum:
    """A dual point that says nothing against any zero."""
    return replace(found, views=found.views * Fraction(0), modalities=())


SOLVE = Newton.solve

LOOSE = together(
    replaced(Tolerances, "met", _loosely),
    replaced(Tolerances, "met_by_shares", lambda self, F, o: self.relative >= F or o <= 1e-7),
)


def _without_coupling(frame: Any, a: Any, b: Any) -> Any:
    """The parts of the dual value at b = 0."""
    linear = rounding.inner(rounding.Ball.exact(a), frame.target)
    square = 0.25 * float(a @ a)
    return (-linear[1], -linear[0]), (square * (1 - 1e-15), square * (1 + 1e-15))


TURNED = together(
    replaced(rounding, "gamma", lambda k: 0.0),
    replaced(duality, "up", rounding.down),
    replaced(duality, "down", rounding.up),
    replaced(certificate, "up", rounding.down),
    replaced(certificate, "down", rounding.up),
)

DUAL = (
    Fault(
        "no scaling into the feasible set, excess not seen",
        "B1/dual",
        together(
            replaced(duality, "_ratio", lambda limit, norm: np.inf),
            replaced(duality, "_excess", lambda s, norm, limit: 0.0),
        ),
    ),
    Fault(
        "excess of a dual point not charged",
        "B1/dual",
        replaced(certificate, "_cost", lambda frame, candidate, upper: 0.0),
    ),
    Fault(
        "terms of the gap left out",
        "B1/dual",
        wrapped(certificate, "gap_terms", lambda t, *a: replace(t, loss=0.25 * t.loss, view_norm=0.0)),
    ),
    Fault(
        "modality term left out of the gap",
        "B1/dual",
        replaced(duality, "_modality_term", lambda frame, point, dual: 0.0),
    ),
    Fault(
        "coupling term left out of the gap",
        "B1/dual",
        replaced(duality, "_coupling_term", lambda frame, point, dual: 0.0),
    ),
    Fault(
        "Q of the dual value halved",
        "B1/dual",
        wrapped(duality, "_value_parts", lambda parts, *a: (parts[0], _times(0.5, parts[1]))),
    ),
    Fault(
        "weights of the charge taken as 0",
        "B1/dual",
        together(
            replaced(certificate, "view_weight_bound", lambda frame, upper: 0.0),
            replaced(certificate, "modality_weight_bound", lambda frame, upper: 0.0),
        ),
    ),
    Fault(
        "bounds of the dual value swapped",
        "B1/dual",
        wrapped(certificate, "dual_value", lambda found, *a: (found[1] * (1 + 1e-15), found[0])),
    ),
    Fault(
        "coupling left out of the dual value",
        "B1/dual",
        replaced(duality, "_value_parts", _without_coupling),
    ),
    Fault(
        "norms of the modalities taken as 0",
        "B1/dual",
        wrapped(evaluation, "norms_by_group", lambda found, *a: _times(0.0, found)),
    ),
    Fault("lambda1 halved for the judge", "B1/dual", frame_with(lambda1=0.5)),
    Fault(
        "lambda2 halved for the judge",
        "B1/dual",
        frame_with(lambda2=0.5),
    ),
    Fault(
        "lambda3 halved for the judge",
        "B1/dual",
        frame_with(lambda3=0.5),
    ),
    Fault(
        "bounds of the objective swapped",
        "B1/dual",
        wrapped(evaluation, "objective_bounds", lambda bounds, *a: (bounds[1], bounds[0])),
    ),
    Fault("rounding dropped and directed inward", "B1/dual", TURNED),
    Fault(
        "proved zeros without their radius",
        "B1/dual",
        replaced(certificate, "proved_zeros", lambda f, point, gap: optimum.proved_zeros(f, point, 0.0)),
    ),
    Fault(
        "exact least squares off by 2^-40",
        "B1/dual",
        wrapped(certificate, "exact_optimum", lambda found, *a: found and found * (1 + 2**-40)),
    ),
)

CRITICAL = (
    Fault(
        "zero said to be optimal from ||X o||_inf on",
        "F3/critical_lambda2",
        replaced(lambda_max, "zero_is_optimal", lambda p: p.lambda2 >= 0.5 * lambda_max.lambda2_max(p)[1]),
    ),
    Fault(
        "zero said to be optimal from ||X o||_inf on, for a library",
        "F3/critical_lambda2",
        replaced(DataBounds, "zero_is_optimal", _optimal_from_half),
    ),
    Fault(
        "the critical lambda2 of the first template for the whole library",
        "F3/critical_lambda2",
        wrapped(DataBounds, "zero_is_optimal", lambda found, *a: np.full_like(found, found[0])),
    ),
)

ACCEPTED = (
    Fault("an absolute tolerance of 1e-7 ||o||^2", "B1/dual", LOOSE),
    Fault(
        "an absolute tolerance of 1e-7 ||o||^2, and a solver that stops there",
        "B2/true",
        together(LOOSE, replaced(Newton, "solve", _stopped_early)),
    ),
    Fault(
        "views proved zero for nothing, with slack in every constraint",
        "B2/zeros",
        together(_zeros(np.ones_like, _kept), wrapped(referee, "optimum", _with_slack)),
        also=("B2/true",),
        may=("B2/answered",),
    ),
    Fault(
        "modalities proved zero for nothing, with slack in every constraint",
        "B2/zeros",
        together(_zeros(_kept, np.ones_like), wrapped(referee, "optimum", _with_slack)),
        also=("B2/true",),
        may=("B2/answered",),
    ),
    Fault(
        "views of a batch proved zero for nothing",
        "B2/batch",
        wrapped(DataBounds, "settled", lambda b, *a: b._replace(zero_views=np.ones_like(b.zero_views))),
    ),
    Fault(
        "modalities of a batch proved zero for nothing",
        "B2/batch",
        wrapped(
            DataBounds, "settled", lambda b, *a: b._replace(zero_modalities=np.ones_like(b.zero_modalities))
        ),
    ),
)

WORDS = (
    *CRITICAL,
    *ACCEPTED,
    Fault(
        "lambda2 doubled for the judge",
        "B2/true",
        frame_with(lambda2=2.0),
        may=("B2/answered", "B2/zeros"),
    ),
    Fault("every answer is called certified", "B1/dual", replaced(Certificate, "certified", True)),
    Fault(
        "modalities proved zero for nothing",
        "B2/zeros",
        _zeros(_kept, np.ones_like),
        also=("B2/true",),
        may=("B2/answered",),
    ),
    Fault(
        "views proved zero for nothing",
        "B2/zeros",
        _zeros(np.ones_like, _kept),
        also=("B2/true",),
        may=("B2/answered",),
    ),
)
