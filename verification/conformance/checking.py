"""What the vectors say is derived again from their data and their proofs."""

import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from convexperc.errors import ConvexpercError
from verification.conformance import making
from verification.conformance.malformed import fault_of
from verification.conformance.profiles import FLOAT32
from verification.conformance.request import holds_float32
from verification.conformance.vectors import (
    DIGESTS,
    SCHEMA,
    VERSION,
    RecognitionSet,
    Vector,
    Vectors,
    place,
    proofs,
    read,
)
from verification.problems.families import EXTREME, RANDOM
from verification.proof_checker import check

COUNTS = {"problems": 434, "recognition sets": 60, "malformed requests": 48}
PREFIXES = {"critical": "critical", "large": "large", "real": "real"}
"""Ids that begin with a flag's word; every other id is that of a family, or `sensitive`."""


def rejections(
    texts: Mapping[str, bytes], progress: Callable[[int, int], None] = lambda done, total: None
) -> Iterator[str]:
    """What is wrong with the three files, given by name; nothing where all holds.

    Digests, the schema, counts, ids, every proof, the width of each interval, zeros, flags, labels, ties and
    margins, and that each malformed line has the fault that it is said to have.
    """
    for name, text in texts.items():
        if hashlib.sha256(text).hexdigest() != DIGESTS[name]:
            yield f"{name}.json: is not the file of version {VERSION}: its SHA-256 differs"
    try:
        records = {name: json.loads(text) for name, text in texts.items()}
        _check_schema(records)
        vectors = read(records)
    except (ValueError, LookupError, TypeError, AttributeError, OverflowError, ConvexpercError) as problem:
        yield f"cannot be read: {type(problem).__name__}: {str(problem)[:300]}"
        return
    yield from _counts(vectors)
    every, proved = list(proofs(vectors)), []
    for done, (id, proof) in enumerate(every, 1):  # noqa: A001
        verdict = check(json.dumps(proof))
        proved.append(verdict.proved)
        if not verdict.proved:
            yield f"{id}: {verdict.reason}"
        progress(done, len(every))
    for case, (_, proof), holds in zip(vectors.problems, every, proved, strict=False):  # sets come after them
        yield from (f"{case.id}: {each}" for each in (_problem(case, proof) if holds else ()))
    for found in vectors.recognition:
        yield from (f"{found.id}: {each}" for each in _set(found))
    for line in vectors.malformed:
        if (fault := fault_of(line.line)) != line.fault:
            yield f"{line.id}: is said to have the fault {line.fault!r}, and has {fault!r}"


def stored() -> dict[str, bytes]:
    """The files that come with the package."""
    return {name: place(name).read_bytes() for name in DIGESTS}


def _check_schema(records: Mapping[str, Any]) -> None:
    import jsonschema  # type: ignore[import-untyped]  # noqa: PLC0415 - comes with an extra

    schema = json.loads(place("vectors.schema").read_bytes())
    for name, record in records.items():
        try:
            jsonschema.validate(record, schema)
        except jsonschema.ValidationError as problem:
            where = "/".join(map(str, problem.absolute_path))
            raise ValueError(f"{name}.json: {where}: {problem.message[:200]}") from None
        if (record["schema"], record["version"]) != (SCHEMA, VERSION):
            raise ValueError(f"{name}.json: is of another schema or version")


def _counts(vectors: Vectors) -> Iterator[str]:
    parts = vectors.problems, vectors.recognition, vectors.malformed
    for (what, count), part in zip(COUNTS.items(), parts, strict=True):
        if len(part) != count:
            yield f"there are {len(part)} {what}, not {count}"
    ids = Counter(each.id for part in parts for each in part)
    ids.update(each.id for found in vectors.recognition for each in found.templates)
    yield from (f"{id}: is the id of several" for id, count in ids.items() if count > 1)  # noqa: A001


def _problem(case: Vector, proof: Mapping[str, Any]) -> Iterator[str]:
    yield from _interval(case)
    if (list(case.zero_views), list(case.zero_modalities)) != making.zeros(case.request.problem, dict(proof)):
        yield "its zeros are not those that follow from its dual point"
    if case.flags != (flags := _flags(case, dict(proof))):
        yield f"its flags are {sorted(case.flags)}, due are {sorted(flags)}"


def _interval(case: Vector) -> Iterator[str]:
    relative, absolute = making.NARROW
    widest = 2 * (Fraction(relative) * case.lower + Fraction(absolute) * case.target)
    if not 0 <= case.upper - case.lower <= widest:
        yield "its interval is wider than it was made"


def _flags(case: Vector, proof: dict[str, Any]) -> frozenset[str]:
    kind = case.id.rpartition("-")[0]
    family, own = kind.replace("-", "_"), {flag for word, flag in PREFIXES.items() if kind.startswith(word)}
    if not own and family != "sensitive":
        own = set() if family in RANDOM else {"degenerate"}
        own |= {"extreme"} if family in EXTREME else set()
    single = holds_float32(case.request.problem) and making.is_attainable(
        case.request.problem, proof, FLOAT32
    )
    return frozenset(own | (set() if single and family not in {"sensitive", *EXTREME} else {"float64"}))


def _set(found: RecognitionSet) -> Iterator[str]:
    for template in found.templates:
        yield from (f"{template.id}: {each}" for each in _interval(template))
    cases = dict(zip(found.names, found.templates, strict=True))
    objects = {name: case.request.problem.o for name, case in cases.items()}
    lower, upper = ({name: getattr(case, end) for name, case in cases.items()} for end in ("lower", "upper"))
    labels, margin = making.ranked(objects, lower, upper)
    if list(found.labels) != labels:
        yield f"its label is {' or '.join(found.labels)}; the intervals give {' or '.join(labels)}"
    if margin <= making.MARGIN or found.margin != making.rounded_down(margin):
        yield f"its margin is {found.margin}; the intervals give {float(margin)}"
    if found.flags != ({"tie"} if len(found.labels) > 1 else set()):
        yield "its flag does not say whether it has a tie"
