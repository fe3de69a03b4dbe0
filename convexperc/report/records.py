"""Certificates, solutions and recognitions as plain JSON values, with exact numbers."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from jaxtyping import Float

from convexperc.certificate.certificate import Certificate
from convexperc.errors import check_type
from convexperc.features.configuration import FeatureConfiguration
from convexperc.problem.files import LAMBDAS, hex_floats, partition_record
from convexperc.problem.optimality import OptimalityResidual
from convexperc.recognition.calibration import Judgement
from convexperc.recognition.each_view import EachView
from convexperc.recognition.recognition import Ranked, Recognition, Template
from convexperc.solution.solution import Solution


def certificate_record(
    certificate: Certificate, residual: OptimalityResidual | None = None
) -> dict[str, Any]:
    """Return a certificate as plain JSON values, with the KKT residual if one is given.

    Bounds and answers are given as ``{"decimal": ..., "hex": ...}``, both exact: the decimal has as many
    digits as identify the float64, 17 at most. An infinite number is the string ``"inf"``, because JSON has
    none. `terms` are on normalised data, where ||o|| is about 1.
    """
    check_type(certificate, Certificate, "certificate")
    check_type(residual, (OptimalityResidual, type(None)), "residual")
    lower, upper = certificate.objective
    names = ("relative_gap", "share_of_target", "relative_tolerance", "absolute_tolerance")
    record = {
        "schema": "convexperc/certificate/1",
        "certified": certificate.certified,
        "lower": _exact(certificate.lower),
        "upper": _exact(certificate.upper),
        "objective": {"lower": _exact(lower), "upper": _exact(upper)},
        "gap": _exact(certificate.gap),
        **{name: _plain(getattr(certificate, name)) for name in names},
        "terms": None if certificate.terms is None else _named(asdict(certificate.terms)),
        "method": certificate.method,
        "zero_views": certificate.zero_views.tolist(),
        "zero_modalities": certificate.zero_modalities.tolist(),
    }
    if residual is not None:
        blocks = {"views": residual.views, "modalities": residual.modalities}
        parts = {name: [_plain(x) for x in block.tolist()] for name, block in blocks.items()}
        record["kkt_residual"] = {"worst": _plain(residual.worst), **parts}
    return record


def solution_record(solution: Solution) -> dict[str, Any]:
    """Return a solution as plain JSON values: sizes, lambdas, (w, u), certificate; times under ``volatile``.

    X and o are left out; `problem_record` gives them. Numbers are written as in `certificate_record`.
    """
    check_type(solution, Solution, "solution")
    problem = solution.problem
    partition = problem.modalities
    seconds = _named({**asdict(solution.timings), "total": solution.timings.total})
    return {
        "schema": "convexperc/solution/1",
        "problem": {
            **{"n": problem.n, "d": problem.d, "modalities": partition_record(partition)},
            **{name: _exact(value) for name, value in zip(LAMBDAS, problem.lambdas, strict=True)},
        },
        "status": solution.status.value,
        "reason": solution.reason,
        "solver": {
            "name": solution.solver,
            "claim": solution.solver_status,
            "iterations": solution.iterations,
        },
        "w": _vector(solution.w),
        "u": _vector(solution.u),
        "modality_norms": _named(dict(zip(partition.names, solution.modality_norms.tolist(), strict=True))),
        "certificate": certificate_record(solution.certificate),
        "volatile": {"seconds": seconds},
    }


def recognition_record(
    recognition: Recognition,
    configuration: FeatureConfiguration | None = None,
    judgement: Judgement | None = None,
    each_view: EachView | None = None,
) -> dict[str, Any]:
    """Return a recognition as plain JSON values: verdict, rankings for the best template, every interval.

    The lowest ``cost`` decides. The solution is that of the best template; `Template.solution` makes others.
    `configuration` is that of the features, if they were extracted from pictures.
    """
    check_type(recognition, Recognition, "recognition")
    check_type(configuration, (FeatureConfiguration, type(None)), "configuration")
    check_type(judgement, (Judgement, type(None)), "judgement")
    check_type(each_view, (EachView, type(None)), "each_view")
    best = recognition.template()
    return {
        "schema": "convexperc/recognition/5",
        "decision": recognition.decision.value,
        "verdict": recognition.statement,
        "label": recognition.label,
        "candidates": list(recognition.candidates),
        "reason": recognition.reason,
        "certified": recognition.certified,
        "warnings": list(recognition.warnings),
        "features": None if configuration is None else configuration.to_dict(),
        "views": list(recognition.views),
        "acceptance": None if judgement is None else judgement_record(judgement),
        "margin": None if recognition.margin is None else _interval(recognition.margin),
        "explained": _interval(recognition.explained),
        "runner_up": recognition.runner_up,
        "rules": rules_record(recognition),
        "each_view": None if each_view is None else _each_view(each_view),
        "ranked_for": {"object": best.object, "template": best.name},
        "ranked_views": _ranked(recognition.ranked_views()),
        "ranked_modalities": _ranked(recognition.ranked_modalities()),
        "solution": solution_record(best.solution),
        "objects": [_object(template) for template in recognition.best_templates],
        "templates": [_template(template) for template in recognition.templates],
    }


def _plain(value: float) -> float | str:
    return float(value) if math.isfinite(value) else str(float(value))


def _named(values: Mapping[str, float]) -> dict[str, float | str]:
    return {name: _plain(value) for name, value in values.items()}


def _exact(value: float) -> dict[str, float | str]:
    return {"decimal": _plain(value), "hex": float(value).hex()}


def _each_view(found: EachView) -> dict[str, Any]:
    """The sums of the optima of single views, by object."""
    ends = zip(found.objects, *(end.tolist() for end in found.costs), strict=True)
    return {
        "label": found.label,
        "candidates": list(found.candidates),
        "margin": None if found.margin is None else _interval(found.margin),
        "labels": {robot: alone.label for robot, alone in zip(found.views, found.recognitions, strict=True)},
        "sums": {name: _interval((lower, upper)) for name, lower, upper in ends},
    }


def rules_record(found: Recognition) -> dict[str, Any]:
    """Return what other rules say as plain JSON values; see `Rules`."""
    rules = found.rules
    named = {name: getattr(rules, name) for name in ("mean", "best_view", "vote", "votes")}
    nearest = dict(zip(found.views, rules.nearest, strict=True))
    return {**named, "nearest": nearest, "disagreeing": list(rules.disagreeing)}


def judgement_record(judgement: Judgement) -> dict[str, Any]:
    """Return what a calibration says as plain JSON values."""
    return {
        "verdict": judgement.acceptance.value,
        "accepted": list(judgement.accepted),
        "reason": judgement.reason,
    }


def _interval(ends: tuple[float, float]) -> dict[str, Any]:
    return {"lower": _exact(ends[0]), "upper": _exact(ends[1])}


def _vector(values: Float[np.ndarray, " length"]) -> dict[str, list[Any]]:
    return {"decimal": [_plain(value) for value in values.tolist()], "hex": hex_floats(values)}


def _ranked(ranking: Iterable[Ranked]) -> list[dict[str, Any]]:
    return [asdict(entry) | {"weight": _plain(entry.weight)} for entry in ranking]


def _object(template: Template) -> dict[str, Any]:
    """An object by its best template."""
    return {"name": template.object, "best": template.name, "excluded": template.excluded}


def _template(template: Template) -> dict[str, Any]:
    lower, upper = template.interval
    return {
        "name": template.name,
        "object": template.object,
        "excluded": template.excluded,
        "status": template.status.value,
        "lower": _exact(lower),
        "upper": _exact(upper),
        "gap": _exact(template.gap),
        "cost": _interval(template.cost),
    }
