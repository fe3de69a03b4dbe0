"""The checker of proof files: bad proofs planted one by one, each rejected for its own reason."""

import ast
import copy
import hashlib
import json
import math
import struct
import sys
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from verification import proof_checker as checker
from verification.__main__ import app
from verification.proof_checker import Verdict, check

RUNNER = CliRunner(env={"COLUMNS": "80", "TERM": "dumb", "NO_COLOR": "1"})
TINY = "-0x1p-2000"
"""Far smaller than any float64, and still too much."""


def digest(problem):
    """The digest as the format defines it, written here a third time."""
    rows, sizes, d = problem["X"], problem["modalities"], problem["d"]
    numbers = [
        *(text for row in rows for text in row),
        *problem["o"],
        *(problem[f"lambda{i}"] for i in (1, 2, 3)),
    ]
    data = b"convexperc/proof/1\0" + struct.pack("<qqq", problem["n"], d, len(sizes))
    data += b"".join(struct.pack("<d", float.fromhex(text)) for text in numbers)
    start = 0
    for part in sizes.values():
        columns = part if isinstance(part, list) else list(range(start, start + part))
        start += len(columns)
        data += struct.pack("<q", len(columns)) + b"".join(struct.pack("<q", c) for c in columns)
    return hashlib.sha256(data).hexdigest()


def proof(X, o, modalities, lambdas, claim, primal, dual):
    """A proof file's record from plain numbers."""

    def text(values):
        return [text(v) if isinstance(v, list) else float(v).hex() for v in values]

    problem = {"n": len(X), "d": len(o), "modalities": modalities, "X": text(X), "o": text(o)}
    problem |= dict(zip(("lambda1", "lambda2", "lambda3"), text(lambdas), strict=True))
    return {
        "schema": "convexperc/proof/1",
        "problem": problem,
        "sha256": digest(problem),
        "claim": dict(zip(("lower", "upper"), text(claim), strict=True)),
        "primal": {"w": text(primal[0]), "u": text(primal[1])},
        "dual": {"a": text(dual[0]), "b": text(dual[1])},
    }


def scalar():
    """X = 1, o = 1, lambda = (1, 1/2, 1/4): F* = 19/32, proved with nothing to spare in any inequality."""
    return proof(
        [[1]], [1], {"m": 1}, (1, 0.5, 0.25), (19 / 32, 19 / 32), ([5 / 8], [1 / 2]), ([-3 / 4], [-1 / 4])
    )


def pair():
    """Two such problems side by side with o = (1, 2) and two modalities: F* = 19/32 + 71/32."""
    points = ([5 / 8, 13 / 8], [1 / 2, 3 / 2]), ([-3 / 4, -3 / 4], [-1 / 4, -1 / 4])
    return proof([[1, 0], [0, 1]], [1, 2], {"p": 1, "q": 1}, (1, 0.5, 0.25), (62 / 32, 62 / 32), *points)


def uncoupled():
    """X = 1, o = 1, lambda = (0, 1/2, 0): F* = 7/16."""
    return proof([[1]], [1], {"m": 1}, (0, 0.5, 0), (7 / 16, 7 / 16), ([3 / 4], [0]), ([-1 / 2], [0]))


def ungrouped():
    """X = 1, o = 1, lambda = (1, 1/2, 0): F* = 7/16 at u = w."""
    return proof([[1]], [1], {"m": 1}, (1, 0.5, 0), (7 / 16, 7 / 16), ([3 / 4], [3 / 4]), ([-1 / 2], [0]))


GOOD = {make.__name__: make for make in (scalar, pair, uncoupled, ungrouped)}


@pytest.mark.parametrize("name", GOOD)
def test_a_tight_proof_is_accepted(name):
    record = GOOD[name]()
    verdict = check(json.dumps(record))
    assert verdict.proved, verdict
    assert verdict.sha256 == record["sha256"], verdict


def nudge(text, sign):
    return math.nextafter(float.fromhex(text), sign * math.inf).hex()


def put(make, *path, to, renew=False):
    """A good record with one entry replaced, by a value or by a function of the old one."""
    record = make()
    place = record
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = to(place[path[-1]]) if callable(to) else to
    if renew:
        record["sha256"] = digest(record["problem"])
    return record


def up(text):
    return nudge(text, 1)


def down(text):
    return nudge(text, -1)


def without(*path):
    record = pair()
    place = record
    for key in path[:-1]:
        place = place[key]
    del place[path[-1]]
    return record


X00 = ("problem", "X", 0, 0)
SIZES = ("problem", "modalities")
LENGTHS = "problem.X[1]: must have 2 entries, has 1"
PLANTED = {
    # the dual point
    "a one ulp outside": (put(scalar, "dual", "a", 0, to=down), "exceeds lambda2 in row 0"),
    "second a one ulp outside": (put(pair, "dual", "a", 1, to=down), "exceeds lambda2 in row 1"),
    "b one ulp outside": (put(scalar, "dual", "b", 0, to=down), "exceeds lambda3 in modality 0"),
    "second b one ulp outside": (put(pair, "dual", "b", 1, to=down), "exceeds lambda3 in modality 1"),
    "b with its sign flipped": (put(scalar, "dual", "b", 0, to="0x1p-2"), "exceeds lambda2 in row 0"),
    "b where lambda1 = 0": (put(uncoupled, "dual", "b", 0, to=TINY), "dual.b: must be 0 where lambda1 is 0"),
    "b where lambda3 = 0": (put(ungrouped, "dual", "b", 0, to=TINY), "exceeds lambda3 in modality 0"),
    "a one ulp inside": (put(scalar, "dual", "a", 0, to=up), "claim.lower: exceeds D(a, b)"),
    "a 2^-100 inside": (put(scalar, "dual", "a", 0, to=f"-0xb{'f' * 24}p-100"), "claim.lower: exceeds D"),
    # the primal point
    "w one ulp off": (put(scalar, "primal", "w", 0, to=up), "claim.upper: is below F(w, u)"),
    "u one ulp off": (put(pair, "primal", "u", 1, to=down), "claim.upper: is below F(w, u)"),
    # the claim
    "lower one ulp too high": (put(pair, "claim", "lower", to=up), "claim.lower: exceeds D(a, b)"),
    "upper one ulp too low": (put(pair, "claim", "upper", to=down), "claim.upper: is below F(w, u)"),
    # the data, with the digest left as it was
    "X one ulp off": (put(pair, "problem", "X", 1, 0, to=up), "sha256: the data have"),
    "zero of X negated": (put(pair, "problem", "X", 1, 0, to="-0x0.0p+0"), "sha256: the data have"),
    "o one ulp off": (put(pair, "problem", "o", 1, to=up), "sha256: the data have"),
    "lambda1 one ulp off": (put(pair, "problem", "lambda1", to=up), "sha256: the data have"),
    "modalities swapped": (put(pair, *SIZES, to={"p": [1], "q": [0]}), "sha256: the data have"),
    "modalities merged": (put(pair, *SIZES, to={"p": 2}), "sha256: the data have"),
    "wrong hash": (put(pair, "sha256", to="0" * 64), "sha256: the data have"),
    "hash in capitals": (put(pair, "sha256", to=str.upper), "sha256: the data have"),
    # the data, with the digest renewed: an honest file of another problem, which it does not prove
    "another X": (put(scalar, *X00, to=up, renew=True), "exceeds lambda2 in row 0"),
    "another, smaller o": (put(scalar, "problem", "o", 0, to=down, renew=True), "claim.lower: exceeds D"),
    "another, larger o": (put(scalar, "problem", "o", 0, to=up, renew=True), "claim.upper: is below F"),
    "smaller lambda1": (put(scalar, "problem", "lambda1", to=down, renew=True), "claim.lower: exceeds D"),
    "larger lambda1": (put(scalar, "problem", "lambda1", to=up, renew=True), "claim.upper: is below F"),
    "smaller lambda2": (put(scalar, "problem", "lambda2", to=down, renew=True), "exceeds lambda2 in row 0"),
    "larger lambda2": (put(scalar, "problem", "lambda2", to=up, renew=True), "claim.upper: is below F"),
    "smaller lambda3": (put(scalar, "problem", "lambda3", to=down, renew=True), "exceeds lambda3"),
    "larger lambda3": (put(scalar, "problem", "lambda3", to=up, renew=True), "claim.upper: is below F"),
    "one modality of two": (put(pair, *SIZES, to={"p": 2}, renew=True), "exceeds lambda3 in modality 0"),
    "negative lambda": (put(pair, "problem", "lambda2", to="-0x1p-1", renew=True), "must not be negative"),
    # shapes and partitions
    "empty modality": (put(pair, *SIZES, to={"p": 2, "q": 0}), "modalities['q']: is empty"),
    "empty list of columns": (put(pair, *SIZES, to={"p": [0, 1], "q": []}), "modalities['q']: is empty"),
    "overlapping columns": (put(pair, *SIZES, to={"p": [0], "q": [0, 1]}), "column 0 is given twice"),
    "missing column": (put(pair, *SIZES, to={"p": [0]}), "problem.modalities: must cover every column"),
    "column out of range": (put(pair, *SIZES, to={"p": [0], "q": [2]}), "there is no column 2"),
    "sizes too small": (put(pair, *SIZES, to={"p": 1}), "problem.modalities: must cover every column"),
    "sizes too large": (put(pair, *SIZES, to={"p": 1, "q": 2}), "modalities['q']: there are only 2 columns"),
    "negative size": (put(pair, *SIZES, to={"p": 3, "q": -1}), "there are only 2 columns"),
    "boolean size": (put(pair, *SIZES, to={"p": True, "q": 1}), "modalities['p']: must be an integer"),
    "sizes and columns": (put(pair, *SIZES, to={"p": 1, "q": [1]}), "modalities['p']: must be a list"),
    "no modality": (put(pair, *SIZES, to={}), "problem.modalities: must be a non-empty object"),
    "short row": (put(pair, "problem", "X", 1, to=["0x0p+0"]), LENGTHS),
    "one row too few": (without("problem", "X", 1), "problem.X: must have 2 entries, has 1"),
    "n of 0": (put(pair, "problem", "n", to=0), "n and d must be at least 1"),
    "n that is a boolean": (put(scalar, "problem", "n", to=True), "problem.n: must be an integer"),
    "short a": (without("dual", "a", 1), "dual.a: must have 2 entries, has 1"),
    "long w": (put(pair, "primal", "w", to=lambda w: [*w, "0x0p+0"]), "primal.w: must have 2 entries, has 3"),
    "X that is no list": (put(pair, "problem", "X", to="0x1p+0"), "problem.X: must be a list"),
    # numbers
    "NaN as a string": (put(pair, "dual", "a", 0, to="nan"), "dual.a[0]: must be a hex float"),
    "infinity as a string": (put(pair, "claim", "upper", to="inf"), "claim.upper: must be a hex float"),
    "decimal string": (put(pair, "problem", "o", 0, to="1.0"), "problem.o[0]: must be a hex float"),
    "JSON integer": (put(pair, *X00, to=1), "problem.X[0][0]: must be a hex float in a string, not int"),
    "boolean as number": (put(pair, *X00, to=True), "must be a hex float in a string, not bool"),
    "null as number": (put(pair, "dual", "b", 1, to=None), "dual.b[1]: must be a hex float"),
    "space in a number": (put(pair, "dual", "b", 1, to=" 0x1p+0"), "dual.b[1]: must be a hex float"),
    "digits of another script": (
        put(pair, "dual", "b", 1, to="0x\u0661p+0"),
        "dual.b[1]: must be a hex float",
    ),
    "data with 54 bits": (put(pair, *X00, to="0x1.00000000000008p+0"), "is no float64"),
    "data beyond float64": (put(pair, "problem", "o", 0, to="0x1p+1024"), "is no float64"),
    "claim beyond float64": (put(pair, "claim", "upper", to="0x1p+1024"), "is no float64"),
    "data below float64": (put(pair, "problem", "o", 0, to="0x1p-1075"), "is no float64"),
    "huge exponent": (put(pair, "dual", "a", 0, to="0x1p+9999999"), "dual.a[0]: the exponent is beyond"),
    # keys
    "missing key": (without("dual"), "the file: key 'dual' is missing"),
    "missing key inside": (without("problem", "lambda3"), "problem: key 'lambda3' is missing"),
    "missing bound": (without("claim", "lower"), "claim: key 'lower' is missing"),
    "extra key": (put(pair, "status", to="optimal"), "the file: key 'status' is unknown"),
    "extra key inside": (put(pair, "dual", "v", to=[]), "dual: key 'v' is unknown"),
    "another schema": (put(pair, "schema", to="convexperc/proof/2"), "schema: must be"),
    "no object": ([], "the file: must be an object"),
    "no object inside": (put(pair, "primal", to=[]), "primal: must be an object"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_fault_is_rejected_for_its_own_reason(name):
    record, reason = PLANTED[name]
    verdict = check(json.dumps(record))
    assert not verdict.proved, name
    assert reason in verdict.reason, (reason, verdict.reason)
    assert verdict.sha256 == "", verdict


TEXT = json.dumps(pair())
BROKEN = {
    "truncated": (TEXT[:-1], "not JSON"),
    "truncated in the middle": (TEXT[: len(TEXT) // 2], "not JSON"),
    "empty": ("", "not JSON"),
    "more after the end": (TEXT + "{}", "not JSON"),
    "NaN": (TEXT.replace('"claim": {"lower": "', '"claim": {"lower": NaN, "was": "'), "number NaN"),
    "infinity": (TEXT.replace('"sha256": ', '"sha256": -Infinity, "was": '), "number -Infinity"),
    "JSON decimal": (TEXT.replace('"n": 2', '"n": 2.0'), "number 2.0"),
    "duplicate key": (TEXT.replace('"n": 2', '"n": 2, "n": 2'), "key 'n' is given twice"),
    "duplicate modality": (TEXT.replace('{"p": 1, "q": 1}', '{"p": 1, "p": 1}'), "key 'p' is given twice"),
    "deeper than any proof": ("[" * 100_000, "not JSON"),
    "lone surrogate": (TEXT + "\ud800", "not JSON"),
    "integer without end": (TEXT.replace('"n": 2', f'"n": {"1" * 5000}'), "not JSON"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_text_is_rejected_for_its_own_reason(name):
    text, reason = BROKEN[name]
    assert text != TEXT
    verdict = check(text)
    assert not verdict.proved, name
    assert verdict.reason.startswith(reason), verdict.reason


@given(st.integers(0, len(TEXT)), st.integers(0, 12), st.text("0123456789abcdefpx+-.[]{}:,\"' N", max_size=4))
def test_no_edit_of_a_file_makes_the_checker_fail(start, length, new):
    verdict = check(TEXT[:start] + new + TEXT[start + length :])
    assert isinstance(verdict, Verdict)
    assert verdict.reason, verdict


def wide(d, digits):
    """A small file with a feasible dual point, whose numbers are long once they are brought to one unit."""
    record = proof(
        [[1.0] * d], [1.0] * d, {"m": d}, (1, 0.5, 0.25), (-1, 4 * d), ([0], [0] * d), ([0] * d, [0])
    )
    record["primal"]["u"][0], record["primal"]["u"][-1] = f"0x{'1' * digits}p+262144", "0x1p-262144"
    return record


DEAR = {
    "memory": (wide(8192, 1), "primal.u: not checked: beyond the limit of 2147483648 bits"),
    "time": (wide(2000, 1), "not checked: its numbers have 524289 bits, beyond the limit of work"),
    "long digits": (
        wide(20, 200_000),
        "not checked: its numbers have 1324285 bits, beyond the limit of work",
    ),
}


@pytest.mark.parametrize("name", DEAR)
def test_a_file_that_is_dear_to_check_is_rejected_by_a_stated_limit(name, tmp_path):
    record, reason = DEAR[name]
    assert check(json.dumps(record)) == Verdict(False, reason)
    place = tmp_path / "dear.json"
    place.write_text(json.dumps(record), encoding="utf-8")
    result = RUNNER.invoke(app, ["check", str(place)])
    assert result.exit_code == 1, result.output
    assert " ".join(result.output.split()) == f"rejected: {reason}", result.output
    assert len(result.output.splitlines()) <= 2, result.output


def test_a_want_of_memory_is_a_rejection_too(monkeypatch):
    def exhausted(problem, w, u):
        raise MemoryError

    monkeypatch.setattr(checker, "_objective", exhausted)
    assert check(TEXT) == Verdict(False, "not checked: it takes more memory than there is")


def test_a_byte_order_mark_before_the_text_is_no_part_of_it(tmp_path):
    assert check("\ufeff" + TEXT).proved
    place = tmp_path / "proof.json"
    place.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())
    assert check(place).proved
    assert not check("\ufeff\ufeff" + TEXT).proved


def test_a_looser_claim_and_an_inner_dual_point_are_accepted():
    record = scalar()
    record["claim"] = {"lower": "0x1p-1", "upper": "0x1p+0"}
    record["dual"] = {"a": ["-0xbfffffffffffffffffffffffp-96"], "b": ["-0x3fffffffffffffffffffffffp-96"]}
    verdict = check(json.dumps(record))
    assert verdict.proved, verdict
    assert verdict.reason == "0x1p-1 <= F* <= 0x1p+0", verdict


@pytest.mark.parametrize("square", ["0", "1/4", "9", "2", "1/3", "7/1048576"])
def test_the_root_is_rounded_up_and_exact_where_it_can_be(square):
    value = Fraction(square)
    root = checker._root_up(value)
    assert root * root >= value, root
    below = root * (1 - Fraction(1, 2**250))
    assert root == 0 or below * below < value, root
    assert square not in ("0", "1/4", "9") or root * root == value, root


def test_the_checker_is_small_and_imports_the_standard_library_alone():
    source = Path(checker.__file__).read_text(encoding="utf-8")
    assert len(source.splitlines()) < 325, len(source.splitlines())
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, node.module
            names.add(str(node.module).split(".")[0])
    assert names <= set(sys.stdlib_module_names), names - set(sys.stdlib_module_names)
    assert "importlib" not in names, names
    assert "__import__" not in source, source


def test_the_command_says_proved_rejected_or_misuse(tmp_path):
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text(TEXT, encoding="utf-8")
    record = copy.deepcopy(pair())
    record["claim"]["lower"] = up(record["claim"]["lower"])
    bad.write_text(json.dumps(record), encoding="utf-8")
    for file, code, start in ((good, 0, "proved: 0x1.f"), (bad, 1, "rejected: claim.lower: exceeds D(a, b)")):
        result = RUNNER.invoke(app, ["check", str(file)])
        assert result.exit_code == code, result.output
        assert result.stdout.startswith(start), result.output
    for missing in (tmp_path / "none.json", tmp_path):
        result = RUNNER.invoke(app, ["check", str(missing)])
        assert result.exit_code == 2, result.output
        assert "cannot read" in " ".join(result.output.split()), result.output
    assert RUNNER.invoke(app, ["check"]).exit_code == 2
