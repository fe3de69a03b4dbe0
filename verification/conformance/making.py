"""The vectors are made here, the same at every run: problems of every family, and what is proved of each.

What is proved rests on the proof file of a problem alone (`convexperc.report.proof`), which
`verification.proof_checker` checks without this library: its interval, and the zeros that follow from its
dual point.
"""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.certificate.lambda_max import lambda2_max, lambda3_max
from convexperc.errors import SolverError
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.extraction import extract
from convexperc.files import write_atomic
from convexperc.problem.problem import Problem
from convexperc.recognition.sample import sample_names, sample_scene
from convexperc.report.proof import proof_record
from convexperc.solution.single import solve
from verification.conformance.judge import attainable
from verification.conformance.malformed import malformed_requests
from verification.conformance.profiles import FLOAT32, FLOAT64, PROFILES, Profile
from verification.conformance.request import LAMBDAS, Request, holds_float32, in_float32
from verification.conformance.vectors import FAULTS, FLAGS, NAMES, SCHEMA, VERSION, Vector, read
from verification.exact.numbers import square_root, squares
from verification.exact.problem import ExactProblem
from verification.problems.families import EXTREME, FAMILIES, RANDOM, seeded
from verification.problems.summaries import SUMMARIES
from verification.proof_checker import exact_pair

SEED = 16
SMALL, USUAL = (4, 12), (8, 48)
"""Largest n and d."""

EACH, IN_FLOAT64, OF_EXTREME = 11, 3, 6
"""Problems of a family in float32, more of those whose point float32 would lose, of an extreme one."""

NARROW = 1e-11, 1e-15
"""Tolerances of the proofs, relative to F* and to ||o||^2."""

PATIENCE = 3600.0
"""Seconds for one proof: a busy machine must make the same as a quiet one."""

NEEDS_FLOAT64 = (
    "near_duplicate_rows",
    "nearly_rank_deficient",
    "near_duplicates_without_lambdas",
    "subnormal_entries",
)
"""Families whose point lies in the last digits of float64."""

SENSITIVE = 6
SETS, ATTEMPTS, MARGIN = 60, 50, Fraction(1, 1000)
"""Recognition sets, tries for each, and how far the lowest optimum is below the next, as a share of it."""

REAL = 15
"""Of these, how many are photographs of the sample."""


def make(folder: Path, progress: Callable[[int, int], None] = lambda done, total: None) -> None:
    """Write the three files of vectors into `folder`."""
    recipes = list(_recipes())
    problems = []
    for k, (name, problem, flags, comment) in enumerate(recipes):
        entry = problem_entry(name, problem, flags, comment)
        problems += [] if entry is None else [entry]
        progress(k + 1, len(recipes) + SETS)
    sets = []
    for k in range(SETS):
        sets.append(_set_entry(k))
        progress(len(recipes) + k + 1, len(recipes) + SETS)
    contents: dict[str, dict[str, Any]] = {
        "problems": {"flags": FLAGS, "problems": problems},
        "recognition": {"sets": sets},
        "malformed": {"faults": FAULTS, "requests": list(malformed_requests())},
    }
    for name in NAMES:
        record = {"schema": SCHEMA, "version": VERSION} | contents[name]
        write_atomic(folder / f"{name}.json", _lines(record))
    read(contents | {"problems": contents["problems"] | {"version": VERSION}})


def problem_entry(name: str, problem: Problem, flags: list[str], comment: str) -> dict[str, Any] | None:
    """One problem with its proof and the zeros that follow from it.

    None where no float64 point near the optimum is optimal within the tolerance of L2. Where that is so of
    float32 alone, the problem is asked of float64 alone.
    """
    proof = _proof(problem)
    types = [profile.name for profile in PROFILES.values() if is_attainable(problem, proof, profile)]
    if FLOAT64.name not in types:
        return None
    views, modalities = zeros(problem, proof)
    return {
        "id": name,
        "comment": comment,
        "flags": flags if FLOAT32.name in types or "float64" in flags else [*flags, "float64"],
        "zero_views": views,
        "zero_modalities": modalities,
        "proof": proof,
    }


def is_attainable(problem: Problem, proof: dict[str, Any], profile: Profile) -> bool:
    """Whether the point of a proof, rounded to the profile's type of number, is optimal; see `attainable`."""
    lower, upper = (Fraction(float.fromhex(proof["claim"][end])) for end in ("lower", "upper"))
    w, u = (np.array([float(_exact(x)) for x in proof["primal"][key]]) for key in "wu")
    return attainable(Vector(Request("made", problem), lower, upper), w, u, profile)


def zeros(problem: Problem, proof: dict[str, Any]) -> tuple[list[int], list[int]]:
    """Views and modalities that no optimum uses, by the dual point of a proof, in exact numbers.

    D is strongly concave: ||a - a*||^2 + ||b - b*||^2 / lambda1 <= 4 (upper - D(a, b)) = r^2 for the dual
    optimum (a*, b*). By Cauchy and Schwarz |v_j - v*_j| <= sqrt(||X_j||^2 + lambda1) r for v = Xa - b, and
    ||X_i'(b - b*)|| <= ||X_i||_F sqrt(lambda1) r. Where |v*_j| < lambda2, w*_j = 0; where
    ||X_i'b*|| < lambda3, u*^i = 0.
    """
    exact = ExactProblem.of(problem)
    low, high = (Fraction(float.fromhex(proof["claim"][end])) for end in ("lower", "upper"))
    a, b = (np.array([_exact(x) for x in proof["dual"][key]], dtype=object) for key in "ab")
    r = square_root(4 * (high - low)).upper
    v = [sum(x * y for x, y in zip(row, a, strict=True)) - b[j] for j, row in enumerate(exact.X)]
    views = [
        j
        for j, row in enumerate(exact.X)
        if abs(v[j]) + square_root(squares(row) + exact.lambda1).upper * r < exact.lambda2
    ]
    modalities = []
    for i, group in enumerate(exact.groups):
        pull = [sum(x * y for x, y in zip(exact.columns[k], b, strict=True)) for k in group]
        block = [x for k in group for x in exact.columns[k]]
        reach = square_root(squares(block) * exact.lambda1).upper * r
        if square_root(squares(pull)).upper + reach < exact.lambda3:
            modalities.append(i)
    return views, modalities


def _exact(text: str) -> Fraction:
    mantissa, exponent = exact_pair(text, "proof")
    return mantissa * Fraction(2) ** exponent


def _proof(problem: Problem) -> dict[str, Any]:
    relative, absolute = NARROW
    found = solve(problem, relative_tolerance=relative, absolute_tolerance=absolute, seconds=PATIENCE)
    return proof_record(found, seconds=PATIENCE)


Recipe = tuple[str, Problem, list[str], str]


def _recipes() -> Iterator[Recipe]:
    for family in FAMILIES:
        yield from _of_family(family)
    yield from _sensitive()
    yield from _critical()
    yield from _large()
    yield from _real()


def _of_family(family: str) -> Iterator[Recipe]:
    """Some that float32 holds, small and usual ones in turn; then those that it does not."""
    summary = SUMMARIES[family]
    flags = [] if family in RANDOM else ["degenerate"]
    if family in EXTREME:
        for index in range(OF_EXTREME):
            problem = seeded(family, SEED, index, largest=SMALL)
            yield _named(family, index), problem, [*flags, "extreme", "float64"], summary
        return
    found = 0
    for index in range(4 * EACH):
        single = in_float32(seeded(family, SEED, index, largest=SMALL if index % 2 else USUAL))
        if single is not None and found < EACH:
            yield _named(family, found), single, flags, f"{summary} Rounded to float32."
            found += 1
    for index in range(IN_FLOAT64 if family in NEEDS_FLOAT64 else 1):
        problem = seeded(family, SEED + 1, index, largest=SMALL)
        own = flags if holds_float32(problem) else [*flags, "float64"]
        yield _named(family, EACH + index), problem, own, summary


def _named(family: str, index: int) -> str:
    return f"{family.replace('_', '-')}-{index:02}"


def _sensitive() -> Iterator[Recipe]:
    """Two nearly equal views whose difference the object needs: rounding the data to float32 is far off."""
    for index in range(SENSITIVE):
        rng = np.random.default_rng([SEED, 500 + index])
        n, d = 2 + index % 3, 4 + 2 * index
        X = rng.standard_normal((n, d))
        X[1] = X[0] + rng.standard_normal(d) / 1024.0
        o = 1000.0 * (X[0] - X[1]) + 0.5 * X[-1] + rng.standard_normal(d) / 1024.0
        problem = _posed(X, o, (0.1, 1e-6, 1e-6), [d // 2, d - d // 2])
        yield (
            f"sensitive-{index:02}",
            problem,
            ["float64"],
            "two nearly equal views with weights near 1000 and -1000",
        )


def _critical() -> Iterator[Recipe]:
    """lambda2 and lambda3 at the value from which on nothing is used, and beside it."""
    shares = ((1 - 2.0**-20, "just below"), (1.0, "at"), (1 + 2.0**-20, "just above"), (0.5, "half of"))
    for index in range(4):
        base = _single(seeded("random", SEED + 2, index, largest=SMALL))
        for k, (share, word) in enumerate(shares):
            second = lambda2_max(base)[1] * share
            problem = _single(_with(base, lambda2=second))
            comment = f"lambda2 {word} the value from which on w = 0, rounded to float32"
            yield f"critical-lambda2-{4 * index + k:02}", problem, ["critical"], comment
            third = lambda3_max(base, solve) * share
            if third > 0.0:
                problem = _single(_with(base, lambda3=third))
                comment = f"lambda3 {word} the value from which on u = 0, rounded to float32"
                yield f"critical-lambda3-{4 * index + k:02}", problem, ["critical"], comment


def _single(problem: Problem) -> Problem:
    rounded = in_float32(problem)
    if rounded is None:
        raise SolverError("vector", value=problem, must="must fit into float32")
    return rounded


def _with(problem: Problem, **weights: float) -> Problem:
    given = dict(zip(LAMBDAS, problem.lambdas, strict=True)) | weights
    return Problem(problem.X, problem.o, modalities=problem.modalities, **given)


def _large() -> Iterator[Recipe]:
    shapes = ((40, 30), (64, 12), (24, 200), (3, 1200), (12, 400), (1, 600))
    for index, (n, d) in enumerate(shapes):
        rng = np.random.default_rng([SEED, index])
        X = rng.integers(-512, 513, (n, d)) / 256.0
        o = (X.T @ (rng.integers(-64, 65, n) / 64.0) + rng.integers(-256, 257, d) / 256.0).astype(np.float32)
        sizes = [d // 2, d // 3, d - d // 2 - d // 3]
        for k, weights in enumerate(((0.125, 1.0, 0.5), (1.0, 0.25 * d, 0.0625 * d))):
            problem = _posed(X, o, weights, sizes)
            yield f"large-{2 * index + k:02}", problem, ["large"], f"{n} robots, {d} features"


CONFIGURATION = FeatureConfiguration(
    working_size=(32, 32), hog_pixels_per_cell=(16, 16), hog_cells_per_block=(1, 1), hog_orientations=9
)
"""Few columns, so that a vector stays short: 24 of colour, 36 of HOG, 26 of LBP."""
SIZES = list(CONFIGURATION.modality_sizes.values())


def _real() -> Iterator[Recipe]:
    """Photographs of the sample: the object in view, its template, three choices of lambdas."""
    for index, name in enumerate(sample_names()):
        X, objects = _described(name)
        for k, weights in enumerate(((0.1, 1.0, 0.1), (0.01, 0.1, 1.0), (10.0, 0.01, 0.01))):
            problem = _single(_posed(X, objects[name], weights, SIZES))
            yield (
                f"real-{3 * index + k:02}",
                problem,
                ["real"],
                f"the sample's scene {name}, rounded to float32",
            )


def _described(name: str) -> tuple[Any, dict[str, Any]]:
    scene = sample_scene(name)
    views, known = (extract(list(each.values()), CONFIGURATION) for each in (scene.views, scene.references))
    X, templates = (np.asarray(each, dtype=np.float32).astype(np.float64) for each in (views, known))
    return X, dict(zip(scene.references, templates, strict=True))


def _posed(X: Any, o: Any, weights: Sequence[float], sizes: Sequence[int]) -> Problem:
    return Problem(X, o, modalities=list(sizes), **dict(zip(LAMBDAS, weights, strict=True)))


Objects = dict[str, Any]
"""Names and templates o."""


def _set_entry(index: int) -> dict[str, Any]:
    """A recognition set whose label, or tie, is proved with a margin."""
    if index < REAL:
        found = _set_of(f"set-{index:02}", *_photographed(index))
        if found is not None:
            return found
    for attempt in range(ATTEMPTS):
        found = _set_of(f"set-{index:02}", *_drawn(index, attempt))
        if found is not None:
            return found
    raise SolverError(
        "recognition set", value=index, must=f"must have a proved label within {ATTEMPTS} attempts"
    )


def _photographed(index: int) -> tuple[Any, list[int], Objects, tuple[float, ...], str]:
    names, weights = sample_names(), ((0.1, 1.0, 0.1), (0.01, 0.1, 0.01), (1.0, 0.5, 0.5))
    name = names[index % len(names)]
    X, objects = _described(name)
    lambdas = tuple(float(np.float32(x)) for x in weights[index // len(names) % len(weights)])
    return X, SIZES, objects, lambdas, f"the sample's scene {name}"


def _drawn(index: int, attempt: int) -> tuple[Any, list[int], Objects, tuple[float, ...], str]:
    """Objects of 256ths, and views of the first with noise; of a tie, two objects are equal."""
    rng = np.random.default_rng([SEED, 1000 + index, attempt])
    n, p = int(rng.integers(1, 7)), int(rng.integers(2, 6))
    sizes = [int(k) for k in rng.integers(1, 9, int(rng.integers(1, 4)))]
    objects = rng.integers(0, 257, (p, sum(sizes))) / 256.0
    comment = "all robots see the object"
    X = np.clip(objects[0] + rng.integers(-64, 65, (n, sum(sizes))) / 256.0, 0.0, None)
    if n > 1 and index % 3 == 0:
        X[-1], comment = rng.integers(0, 257, sum(sizes)) / 256.0, "one robot sees something else"
    if index % 10 == 9:
        objects[-1], comment = objects[0], f"{comment}; two templates are equal"
    lambdas = tuple(float(np.float32(rng.choice([0.0, 0.01, 0.1, 1.0, 10.0]))) for _ in range(3))
    return X, sizes, {f"object-{k}": o for k, o in enumerate(objects)}, lambdas, comment


def _set_of(
    name: str, X: Any, sizes: list[int], objects: Objects, lambdas: tuple[float, ...], comment: str
) -> dict[str, Any] | None:
    """The set, or None where the lowest optimum is 0 or not far enough below the next."""
    found = {key: _proof(_posed(X, o, lambdas, sizes)) for key, o in objects.items()}
    lower, upper = (
        {key: Fraction(float.fromhex(proof["claim"][end])) for key, proof in found.items()}
        for end in ("lower", "upper")
    )
    labels, margin = ranked(objects, lower, upper)
    if margin <= MARGIN:
        return None
    best = labels[0]
    shared = {key: value for key, value in found[best]["problem"].items() if key != "o"}
    own = ("schema", "sha256", "claim", "primal", "dual")
    templates = [
        {"name": key, "o": proof["problem"]["o"], "proof": {part: proof[part] for part in own}}
        for key, proof in found.items()
    ]
    return {
        "id": name,
        "comment": comment,
        "flags": ["tie"] if len(labels) > 1 else [],
        "labels": labels,
        "margin": rounded_down(margin).hex(),
        "views": shared,
        "templates": templates,
    }


def ranked(
    objects: Objects, lower: Mapping[str, Fraction], upper: Mapping[str, Fraction]
) -> tuple[list[str], Fraction]:
    """The templates of the lowest optimum, and how far the others are above it, as a share of it.

    The share is 0 where it is unknown: where there is no other, or the lowest may be 0.
    """
    best = min(upper, key=lambda key: upper[key])
    labels = [key for key, o in objects.items() if np.array_equal(o, objects[best])]
    others = [lower[key] for key in objects if key not in labels]
    if not others or upper[best] <= 0:
        return labels, Fraction(0)
    return labels, (min(others) - upper[best]) / upper[best]


def rounded_down(margin: Fraction) -> float:
    """The margin as it is stored, a little lower."""
    return math.nextafter(float(margin), 0.0)


def _lines(record: dict[str, Any]) -> bytes:
    """JSON with one vector a line."""
    parts = []
    for key, value in record.items():
        if isinstance(value, list):
            entries = ",\n".join(json.dumps(entry) for entry in value)
            parts.append(f"{json.dumps(key)}: [\n{entries}\n]")
        else:
            parts.append(f"{json.dumps(key)}: {json.dumps(value)}")
    return ("{\n" + ",\n".join(parts) + "\n}\n").encode()
