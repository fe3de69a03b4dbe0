"""What is proved of each vector is checked without the library, and they are made the same again."""

import gzip
import hashlib
import json
from collections import Counter
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import jsonschema
import pytest

from convexperc.errors import ConvexpercError, FileFormatError
from convexperc.problem.problem import Problem
from verification.conformance import checking
from verification.conformance.checking import rejections, stored
from verification.conformance.making import _recipes, _set_entry, problem_entry, zeros
from verification.conformance.malformed import GOOD, fault_of, malformed_requests
from verification.conformance.request import holds_float32, in_float32
from verification.conformance.vectors import DIGESTS, FAULTS, FLAGS, NAMES, all_vectors, proofs
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


def test_a_request_without_a_fault_has_none():
    for each in all_vectors().problems:
        assert fault_of(each.request.line) is None
    for each in all_vectors().malformed:
        assert fault_of(each.line) == each.fault, each


@pytest.fixture(scope="module")
def texts() -> dict[str, bytes]:
    """A few of the vectors, since every proof of all takes a while."""
    found = {name: json.loads(text) for name, text in stored().items()}
    some = [e for e in found["problems"]["problems"] if e["id"].startswith(("random-0", "zero-row-0"))]
    assert any(each["zero_views"] for each in some)
    found["problems"]["problems"] = some
    found["recognition"]["sets"] = found["recognition"]["sets"][-2:]
    return {name: json.dumps(record).encode() for name, record in found.items()}


@pytest.fixture
def wrong(monkeypatch: pytest.MonkeyPatch, texts: dict[str, bytes]) -> Callable[..., list[str]]:
    """What is wrong with the files after a change."""
    records = {name: json.loads(text) for name, text in texts.items()}
    counts = len(records["problems"]["problems"]), 2, len(records["malformed"]["requests"])
    monkeypatch.setattr(checking, "COUNTS", dict(zip(checking.COUNTS, counts, strict=True)))
    digests = {name: hashlib.sha256(text).hexdigest() for name, text in texts.items()}
    monkeypatch.setattr(checking, "DIGESTS", digests)

    def found(name: str, change: Callable[[dict[str, Any]], object]) -> list[str]:
        change(records[name])
        changed = json.dumps(records[name]).encode()
        if changed != texts[name]:
            assert f"{name}.json: is not the file of version" in next(
                iter(rejections(texts | {name: changed}))
            )
            monkeypatch.setitem(digests, name, hashlib.sha256(changed).hexdigest())
        return list(rejections(texts | {name: changed}))

    return found


def put(record: Any, *path: Any, to: Any) -> None:
    """Change one entry; a function is called with what is there."""
    for key in path[:-1]:
        record = record[key]
    record[path[-1]] = to(record[path[-1]]) if callable(to) else to


def times(factor: float) -> Callable[[str], str]:
    return lambda text: (float.fromhex(text) * factor).hex()


CLAIM = ("problems", 0, "proof", "claim")
DAMAGES: dict[str, tuple[str, Callable[[dict[str, Any]], object], str]] = {
    "a lower bound above F*": ("problems", lambda r: put(r, *CLAIM, "lower", to=times(1.01)), "claim.lower"),
    "an upper bound below F*": ("problems", lambda r: put(r, *CLAIM, "upper", to=times(0.99)), "claim.upper"),
    "a loose lower bound": ("problems", lambda r: put(r, *CLAIM, "lower", to=times(0.0)), "wider"),
    "a loose upper bound": ("problems", lambda r: put(r, *CLAIM, "upper", to=times(1.5)), "wider"),
    "another X": (
        "problems",
        lambda r: put(r, "problems", 0, "proof", "problem", "X", 0, 0, to=times(2.0)),
        "sha",
    ),
    "no hex float": ("problems", lambda r: put(r, *CLAIM, "lower", to="0xzz"), "cannot be read"),
    "zeros invented": ("problems", lambda r: put(r, "problems", 0, "zero_views", to=[0]), "its zeros"),
    "zeros left out": (
        "problems",
        lambda r: [put(e, "zero_views", to=[]) for e in r["problems"]],
        "its zeros",
    ),
    "another flag": ("problems", lambda r: put(r, "problems", 0, "flags", to=["degenerate"]), "its flags"),
    "one is missing": ("problems", lambda r: r["problems"].pop(), "there are"),
    "an id twice": ("problems", lambda r: put(r, "problems", 1, "id", to="random-00"), "the id of several"),
    "another label": (
        "recognition",
        lambda r: put(r, "sets", 0, "labels", to=[r["sets"][0]["templates"][-1]["name"]]),
        "its label",
    ),
    "another margin": ("recognition", lambda r: put(r, "sets", 0, "margin", to=times(2.0)), "its margin"),
    "no tie": ("recognition", lambda r: put(r, "sets", 1, "flags", to=[]), "a tie"),
    "a malformed line that is sound": (
        "malformed",
        lambda r: put(r, "requests", 0, "line", to=json.dumps({"id": "malformed-00"} | GOOD)),
        "malformed-00: is said",
    ),
    "a fault of another kind": ("malformed", lambda r: put(r, "requests", 0, "fault", to="type"), "is said"),
    "another version": ("malformed", lambda r: put(r, "version", to="0.0.1"), "version"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damage_is_rejected(name: str, wrong: Callable[..., list[str]]):
    file, change, told = DAMAGES[name]
    found = wrong(file, change)
    assert any(told in each for each in found), found


def test_sound_files_are_not_rejected_and_torn_ones_are(
    wrong: Callable[..., list[str]], texts: dict[str, bytes]
):
    assert wrong("malformed", lambda record: None) == []
    torn = list(rejections(texts | {"problems": texts["problems"][:10_000]}))
    assert torn[-1].startswith("cannot be read"), torn


def test_a_changed_file_judges_nobody(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(DIGESTS, "malformed", "0" * 64)
    all_vectors.cache_clear()
    with pytest.raises(FileFormatError, match="Install the package again"):
        all_vectors()
