"""Files that go out: records as plain JSON values, exact, and written whole or not at all."""

import json
import math
import os
import secrets
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from convexperc.certificate.certificate import Certificate
from convexperc.errors import InputError
from convexperc.features.configuration import FeatureConfiguration
from convexperc.problem.files import LAMBDAS
from convexperc.problem.modalities import Modalities
from convexperc.problem.optimality import OptimalityResidual
from convexperc.problem.problem import Problem
from convexperc.recognition.recognition import Ranked, Recognition, Template
from convexperc.solution.solution import Solution, Status


def problem_record(problem: Problem, name: str | None = None) -> dict[str, Any]:
    """What `problem_files.read_problem` reads: exact, with hex floats throughout."""
    record: dict[str, Any] = {} if name is None else {"id": name}
    record |= {"n": problem.n, "d": problem.d, "modalities": _partition(problem.modalities)}
    record |= {"X": [_hex(row) for row in problem.X], "o": _hex(problem.o)}
    return record | dict(zip(LAMBDAS, _hex(problem.lambdas), strict=True))


def certificate_record(
    certificate: Certificate, residual: OptimalityResidual | None = None
) -> dict[str, Any]:
    """Plain JSON values of a certificate, with the KKT residual if one is given.

    A number that counts is given as ``{"decimal": ..., "hex": ...}``, both exact; a decimal has as many of 17
    digits as it needs. Where it is infinite the string ``"inf"`` stands, which JSON has no number for.
    `terms` are in units where ||o|| is about 1.
    """
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
    """Plain JSON values of a solution: sizes and lambdas, (w, u), the certificate; times under ``volatile``.

    X and o are not repeated; `problem_record` gives them. Numbers are written as in `certificate_record`.
    """
    problem = solution.problem
    partition = problem.modalities
    seconds = _named({**asdict(solution.timings), "total": solution.timings.total})
    return {
        "schema": "convexperc/solution/1",
        "problem": {
            **{"n": problem.n, "d": problem.d, "modalities": _partition(partition)},
            **{name: _exact(value) for name, value in zip(LAMBDAS, problem.lambdas, strict=True)},
        },
        "status": solution.status.value,
        "solver": {
            "name": solution.solver,
            "claim": solution.claim,
            "iterations": solution.iterations,
        },
        "w": _vector(solution.w),
        "u": _vector(solution.u),
        "modality_norms": _named(dict(zip(partition.names, solution.modality_norms.tolist(), strict=True))),
        "certificate": certificate_record(solution.certificate),
        "volatile": {"seconds": seconds},
    }


def recognition_record(
    recognition: Recognition, configuration: FeatureConfiguration | None = None
) -> dict[str, Any]:
    """Plain JSON values of a recognition: the verdict, the ranking for the best template, every interval.

    ``cost`` is what decides, the lowest being best. A template that was excluded before it was certified has
    no solution. `configuration` says what the features were made of, if they were made of pictures.
    """
    return {
        "schema": "convexperc/recognition/3",
        "decision": recognition.decision.value,
        "verdict": recognition.verdict.value,
        "label": recognition.label,
        "candidates": list(recognition.candidates),
        "reason": recognition.reason,
        "certified": recognition.certified,
        "warnings": list(recognition.warnings),
        "features": None if configuration is None else configuration.to_dict(),
        "views": list(recognition.views),
        "ranked_for": recognition.candidates[0],
        "ranked_views": _ranked(recognition.ranked_views()),
        "ranked_modalities": _ranked(recognition.ranked_modalities()),
        "templates": [_template(template) for template in recognition.templates],
    }


def write_json(path: str | os.PathLike[str], record: Mapping[str, Any]) -> None:
    """Write `record` as JSON, a line for each innermost list; see `write_whole`."""
    write_whole(path, json_bytes(record))


def json_bytes(record: Mapping[str, Any]) -> bytes:
    """Return what `write_json` writes."""
    return (_layout(record, "") + "\n").encode()


def write_whole(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file so that nobody ever sees half of it: beside its place first, then moved there.

    Raises
    ------
    InputError
        See `check_place`; also a full disc.
    """
    place = check_place(path)
    beside = place.with_name(f".{secrets.token_hex(6)}.part")
    try:
        try:
            with beside.open("xb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            beside.replace(place)
        except BaseException:
            with suppress(OSError):
                beside.unlink(missing_ok=True)
            raise
    except OSError as problem:
        raise _unwritable(path, problem.strerror) from None


def check_place(path: str | os.PathLike[str]) -> Path:
    """Return the real place of a file to be written, after asking whether it could be: for long work's start.

    Raises
    ------
    InputError
        There is no such folder, it cannot be written, something other than a file is in the place, or it
        is one like ``/dev/stdout``, behind which another's open file may be that would be replaced.
    """
    try:
        place = Path(path).resolve()
        device = Path(path).absolute().parts[1:2] in (("dev",), ("proc",))
        if device or (place.exists() and not place.is_file()):
            raise _unwritable(path, "no ordinary file")
    except (OSError, ValueError, RuntimeError) as problem:
        if isinstance(problem, InputError):
            raise
        raise _unwritable(path, str(problem)) from None
    if not place.parent.is_dir():
        raise _unwritable(path, "no such folder")
    if not os.access(place.parent, os.W_OK | os.X_OK):
        raise _unwritable(path, "no permission in its folder")
    return place


def _unwritable(path: str | os.PathLike[str], found: str | None) -> InputError:
    must = "must be a file that can be written"
    return InputError(f"output {os.fspath(path)}", value=found, must=must, remedy="Choose another place.")


def _partition(modalities: Modalities) -> dict[str, int | list[int]]:
    """Sizes where the modalities follow each other, else columns: what `Modalities.of` reads."""
    start = 0
    for columns, size in zip(modalities, modalities.sizes, strict=True):
        if not isinstance(columns, slice) or columns.start != start:
            each = [np.arange(modalities.d)[columns].tolist() for columns in modalities]
            return dict(zip(modalities.names, each, strict=True))
        start += size
    return dict(zip(modalities.names, modalities.sizes, strict=True))


def _hex(values: Iterable[float]) -> list[str]:
    return [float(value).hex() for value in values]


def _plain(value: float) -> float | str:
    return float(value) if math.isfinite(value) else str(float(value))


def _named(values: Mapping[str, float]) -> dict[str, float | str]:
    return {name: _plain(value) for name, value in values.items()}


def _exact(value: float) -> dict[str, float | str]:
    return {"decimal": _plain(value), "hex": float(value).hex()}


def _vector(values: Float[np.ndarray, " length"]) -> dict[str, list[Any]]:
    return {"decimal": [_plain(value) for value in values.tolist()], "hex": _hex(values)}


def _ranked(ranking: Iterable[Ranked]) -> list[dict[str, Any]]:
    return [asdict(entry) for entry in ranking]


def _template(template: Template) -> dict[str, Any]:
    lower, upper = template.interval
    record = {"name": template.name, "excluded": template.excluded, "status": template.status.value}
    record |= {"lower": _exact(lower), "upper": _exact(upper)}
    record |= {"cost": {"lower": _exact(template.cost[0]), "upper": _exact(template.cost[1])}}
    if template.excluded and template.status is Status.NOT_CERTIFIED:
        return record | {"solution": None}
    return record | {"solution": solution_record(template.solution)}


def _layout(value: Any, indent: str) -> str:
    """JSON with a line for each entry, but innermost lists and pairs in one line."""
    deeper = indent + "  "
    if isinstance(value, Mapping) and (len(value) > 2 or _nested(value.values())):
        parts = [f"{json.dumps(key)}: {_layout(entry, deeper)}" for key, entry in value.items()]
        return "{\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}}}"
    if isinstance(value, list) and _nested(value):
        parts = [deeper + _layout(entry, deeper) for entry in value]
        return "[\n" + ",\n".join(parts) + f"\n{indent}]"
    return json.dumps(value, allow_nan=False)


def _nested(values: Iterable[Any]) -> bool:
    return any(isinstance(value, (Mapping, list)) for value in values)
