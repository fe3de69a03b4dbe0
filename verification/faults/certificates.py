"""Faults in the judge: in its dual points, its rounding, its bounds and its words."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from convexperc.certificate import certificate, duality, evaluation, rounding
from convexperc.certificate import screening as optimum
from convexperc.certificate.certificate import Certificate
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from verification.faults.fault import Fault, Plant, replaced, together, wrapped

EXACT = ("lambda2_lambda3_zero",)
"""Where the optimum is least squares over the rationals."""


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
        families=EXACT,
    ),
)

WORDS = (
    Fault("lambda2 doubled for the judge", "B2/true", frame_with(lambda2=2.0), also=("B2/answered",)),
    Fault("every answer is called certified", "B1/dual", replaced(Certificate, "certified", True)),
    Fault(
        "modalities proved zero for nothing",
        "F3/exact_zeros",
        _zeros(_kept, np.ones_like),
        also=("B2/true", "B2/answered"),
    ),
    Fault(
        "views proved zero for nothing",
        "F3/exact_zeros",
        _zeros(np.ones_like, _kept),
        also=("B2/true", "B2/answered"),
    ),
)
