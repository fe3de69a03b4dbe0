"""What is proved of each vector is checked without the library, and they are made the same again."""

import gzip
import json
from collections import Counter
from importlib.resources import files

import jsonschema
import pytest

from convexperc.errors import ConvexpercError
from convexperc.problem.problem import Problem
from verification.conformance.making import _recipes, _set_entry, problem_entry, zeros
from verification.conformance.malformed import malformed_requests
from verification.conformance.request import holds_float32, in_float32
from verification.conformance.vectors import FAULTS, FLAGS, NAMES, all_vectors, proofs
from verification.exact.referee import optimum
from verification.problems.families import FAMILIES
from verification.proof_checker import check

FOLDER = files("verification.conformance") / "vectors"


def test_there_are_enough_of_each_kind():
    found = all_vectors()
    assert len(found.problems) >= 400
    assert len(found.recognition) == 60
    assert len(found.malformed) >= 40
    assert len(found.ids) == len(found.problems) + len(found.malformed) + sum(
        len(s.templates) for s in found.recognition
    )
    families = {each.id.rpartition("-")[0].replace("-", "_") for each in found.problems}
    assert set(FAMILIES) <= families
    assert {flag for each in (*found.problems, *found.recognition) for flag in each.flags} == set(FLAGS)
    assert {each.fault for each in found.malformed} == set(FAULTS)
    assert sum(bool(each.zero_views or each.zero_modalities) for each in found.problems) >= 100
    assert Counter("float64" in each.flags for each in found.problems)[False] >= 300


def test_they_are_small_and_follow_the_schema():
    texts = {name: (FOLDER / f"{name}.json").read_bytes() for name in NAMES}
    assert sum(len(gzip.compress(text)) for text in texts.values()) < 5_000_000
    schema = json.loads((FOLDER / "vectors.schema.json").read_bytes())
    for text in texts.values():
        jsonschema.validate(json.loads(text), schema)


def test_every_proof_holds():
    for name, proof in proofs(all_vectors()):
        verdict = check(json.dumps(proof))
        assert verdict.proved, (name, verdict)


def test_every_interval_is_narrower_than_what_is_asked_of_it():
    for each in all_vectors().problems:
        assert each.upper - each.lower <= 2 * (each.lower + each.target / 10**4) / 10**11, each.id


def test_zeros_are_zeros_of_the_exact_referee():
    seen = 0
    for each in all_vectors().problems:
        if not each.zero_views or each.request.problem.X.size > 100 or "extreme" in each.flags:
            continue
        truth = optimum(each.request.problem)
        for j in each.zero_views:
            seen += 1
            assert abs(truth.w[j]) <= 1e-6 * max(abs(truth.w).max(), 1e-300), each.id
    assert seen > 100


def test_a_zero_needs_a_slack_beyond_the_gap():
    case = next(
        each for each in all_vectors().problems if each.zero_views and each.request.problem.lambda1 > 0.0
    )
    proof = next(proof for name, proof in proofs(all_vectors()) if name == case.id)
    assert zeros(case.request.problem, proof)[0] == list(case.zero_views)
    wide = proof | {"claim": proof["claim"] | {"upper": (4.0 * float(case.upper) + 1.0).hex()}}
    assert zeros(case.request.problem, wide)[0] == []


@pytest.mark.parametrize("family", ["random", "scaled_data", "critical-lambda2"])
def test_problems_are_made_the_same_again(family: str):
    name, problem, flags, comment = next(r for r in _recipes() if r[0].startswith(family.replace("_", "-")))
    stored = next(each for each in all_vectors().records["problems"]["problems"] if each["id"] == name)
    assert problem_entry(name, problem, flags, comment)["proof"]["problem"] == stored["proof"]["problem"]
    assert (stored["flags"], stored["comment"]) == (flags, comment)


def test_sets_and_malformed_requests_are_made_the_same_again():
    stored = all_vectors().records["recognition"]["sets"]
    for k in (0, 29):
        made = _set_entry(k)
        assert made["views"] == stored[k]["views"]
        assert made["labels"] == stored[k]["labels"]
    assert list(malformed_requests()) == all_vectors().records["malformed"]["requests"]


def test_flags_say_whether_float32_holds_the_numbers():
    for each in all_vectors().problems:
        assert "float64" in each.flags or holds_float32(each.request.problem), each.id


def test_rounding_to_float32_refuses_what_it_would_lose():
    def problem(x: float) -> Problem:
        return Problem([[x]], [1.0], lambda1=1.0, lambda2=0.1, lambda3=0.0)

    assert in_float32(problem(1e-40)) is None
    assert in_float32(problem(1e39)) is None
    rounded = in_float32(problem(0.1))
    assert rounded is not None
    assert rounded.lambda2 == pytest.approx(0.1, rel=1e-7)
    assert rounded.X[0, 0] != 0.1


def test_every_malformed_request_is_refused_by_the_library():
    for each in all_vectors().malformed:
        if not each.callable:
            continue
        data = json.loads(each.line)
        weights = {name: data[name] for name in ("lambda1", "lambda2", "lambda3")}
        with pytest.raises((ConvexpercError, ValueError)):
            Problem(data["X"], data["o"], modalities=data["modalities"], **weights)
