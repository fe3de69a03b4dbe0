"""Files: exact numbers both ways, refusals that name the place, and no file half-written."""

import json
import os
import stat

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from convexperc.certificate.certificate import certify
from convexperc.errors import FileFormatError, InputError
from convexperc.features import FeatureConfiguration
from convexperc.features.configuration import read_configuration
from convexperc.files import check_place, write_atomic, write_json
from convexperc.problem.files import problem_record, read_answer, read_problem
from convexperc.problem.modalities import Modalities
from convexperc.problem.optimality import optimality_residual
from convexperc.problem.problem import Problem, same_data
from convexperc.recognition.label import recognize
from convexperc.report.records import certificate_record, recognition_record, solution_record
from convexperc.solution.single import solve
from convexperc.solvers.interface import SolverResult

X = [[1.0, 0.5, -2.0], [0.25, 3.0, 1.0]]
GOOD = {"X": X, "o": [1.0, 0.0, -1.0], "lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
DOUBLES = st.floats(allow_nan=False, allow_infinity=False)


class LeastSquares:
    """A solver that is wrong in general, but quick: u = 0 and w by least squares."""

    name = "least squares"

    def solve(self, problem):
        w = np.linalg.lstsq(problem.X.T, problem.o, rcond=None)[0]
        return SolverResult(w, np.zeros(problem.d), "perfect, trust me", 1)


def small(modalities=None):
    return Problem(X, [1.0, 0.0, -1.0], modalities=modalities, lambda1=0.1, lambda2=0.2, lambda3=0.3)


def put(folder, content, name="file.json"):
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def refusal(read, path, *needed):
    with pytest.raises(FileFormatError) as caught:
        read(path)
    for text in (path.name, *needed):
        assert text in str(caught.value), (text, str(caught.value))


@given(hnp.arrays(np.float64, (2, 4), elements=DOUBLES), st.floats(0, 1e308), st.integers(0, 3))
def test_every_double_and_partition_comes_back(tmp_path_factory, data, lambda1, which):
    partition = ([3, 1], {"a": [0, 2], "b": [3, 1]}, None, {"a": [2, 3], "b": [0, 1]})[which]
    problem = Problem(data, data[1], modalities=partition, lambda1=lambda1, lambda2=0.1, lambda3=5e-324)
    path = tmp_path_factory.getbasetemp() / f"trip-{os.getpid()}.json"
    write_json(path, problem_record(problem, "trip"))
    back = read_problem(path)
    assert back.id == "trip"
    assert same_data(problem, back.problem), (problem_record(problem), problem_record(back.problem))
    assert back.problem.modalities.names == problem.modalities.names
    assert np.signbit(back.problem.X).tolist() == np.signbit(problem.X).tolist()


def test_numbers_may_be_json_or_hex(tmp_path):
    record = {**GOOD, "X": [["0x1p+0", 0.5, "-0X1.0P1"], ["0x.4", 3, "0x1."]], "n": 2, "d": 3, "id": "é"}
    found = read_problem(put(tmp_path, "\ufeff" + json.dumps(record, ensure_ascii=False)))
    assert found.id == "é"
    assert found.problem.X.tolist() == X
    assert found.problem.modalities.sizes == (3,)


REFUSED = {
    "NaN": ('"X": [[1, 2, 3], [1, 2, NaN]]', "X[1][2]", "'NaN'", "finite"),
    "Infinity": ('"X": [[1, 2, 3], [1, -Infinity, 3]]', "X[1][1]", "'-Infinity'"),
    "too large": ('"o": [1e999, 0, 0]', "o[0]", "inf"),
    "integer too large": (f'"o": [1{"0" * 400}, 0, 0]', "o[0]", "finite"),
    "hex too large": ('"o": ["0x1p99999", 0, 0]', "o[0]"),
    "word": ('"lambda1": "nan"', "lambda1", "'nan'"),
    "decimal in a string": ('"lambda1": "0.1"', "lambda1", "hex"),
    "hex without 0x": ('"lambda1": "1.8p1"', "lambda1"),
    "hex with blanks": ('"lambda1": " 0x1p1"', "lambda1"),
    "true": ('"lambda1": true', "lambda1", "True"),
    "null": ('"lambda1": null', "lambda1"),
    "negative": ('"lambda2": -1', "lambda2", ">= 0"),
    "twice": ('"lambda1": 1, "lambda1": 2', "key", "'lambda1'", "once"),
    "modality twice": ('"modalities": {"a": 1, "a": 2}', "key", "'a'", "once"),
    "unknown": ('"lamda1": 1, "mode": 2', "lamda1", "mode"),
    "n": ('"n": 3', "n must be 2"),
    "d as a float": ('"d": 3.0', "d must be 3"),
    "n as a boolean": ('"X": [[1, 2, 3]], "n": true', "n must be 1"),
    "ragged": ('"X": [[1, 2, 3], [1, 2]]', "X[1]", "3 entries"),
    "flat": ('"X": [1, 2, 3]', "X[0]", "list of numbers"),
    "empty": ('"X": []', "X", "at least one row"),
    "o": ('"o": [1, 2]', "o must have"),
    "modalities": ('"modalities": [2, 2]', "modalities", "sum to the 3"),
    "no modalities": ('"modalities": null', "modalities"),
    "overlap": ('"modalities": {"a": [0, 1], "b": [1, 2]}', "overlap"),
    "id": ('"id": 7', "id must be a string"),
    "id NaN": ('"id": NaN', "id must be a string"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_bad_problem_is_refused_with_its_place(tmp_path, case):
    change, *needed = REFUSED[case]
    keys = json.loads(f"{{{change}}}", parse_constant=str)
    rest = json.dumps({key: value for key, value in GOOD.items() if key not in keys})[1:]
    refusal(read_problem, put(tmp_path, f"{{{change}, {rest}"), *needed)


@pytest.mark.parametrize(
    ("content", "needed"),
    [
        ("", "JSON"),
        ('{"X": [1,}', "line 1 column"),
        ("[" * 100_000, "JSON"),
        ("[1, 2]", "JSON object"),
        ("NaN", "JSON object"),
        (f'{{"X": {"1" * 5000}}}', "JSON"),
        (json.dumps({"X": X}), "must have the keys o, lambda1, lambda2, lambda3"),
    ],
)
def test_what_is_no_problem_at_all_is_refused(tmp_path, content, needed):
    refusal(read_problem, put(tmp_path, content), needed)


def test_unreadable_places_are_refused(tmp_path):
    refusal(read_problem, tmp_path / "absent.json", "No such file")
    refusal(read_problem, tmp_path, "directory")
    (tmp_path / "latin.json").write_bytes(b'{"id": "\xe9"}')
    refusal(read_problem, tmp_path / "latin.json", "utf-8")


def test_an_answer_is_read_and_its_claims_are_not(tmp_path):
    asked = read_problem(put(tmp_path, {**GOOD, "id": "a"}))
    claims = {"status": {"any": "thing"}, "objective": "NaN"}
    answer = read_answer(put(tmp_path, {"id": "a", "w": [1, "0x1p-1"], "u": [0, 0, 1.5], **claims}), asked)
    assert (answer.w.tolist(), answer.u.tolist()) == ([1.0, 0.5], [0.0, 0.0, 1.5])
    assert not answer.w.flags.writeable
    assert set(vars(answer)) == {"id", "w", "u"}


@pytest.mark.parametrize(
    ("change", "needed"),
    [
        ({"id": "b"}, "must be the problem's id 'a'"),
        ({"w": [1]}, "w must have 2 entries"),
        ({"u": [1, 2, float("nan")]}, "u[2]"),
        ({"u": [[1, 2, 3]]}, "u[0]"),
        ({"gap": 0}, "gap"),
    ],
)
def test_a_bad_answer_is_refused_with_its_place(tmp_path, change, needed):
    asked = read_problem(put(tmp_path, {**GOOD, "id": "a"}, "problem.json"))
    path = put(tmp_path, {"w": [1, 2], "u": [0, 0, 0], **change})
    refusal(lambda place: read_answer(place, asked), path, needed)


def test_a_configuration_comes_back_and_must_be_complete(tmp_path):
    wanted = FeatureConfiguration(color_bins=16, working_size=(64, 48))
    write_json(tmp_path / "c.json", wanted.to_dict())
    assert read_configuration(tmp_path / "c.json") == wanted
    refusal(read_configuration, put(tmp_path, {"color_bins": 16}), "missing")
    refusal(read_configuration, put(tmp_path, {**wanted.to_dict(), "color_bins": 7}), "color_bins", "7")


def numbers(record, place=""):
    """Every {decimal, hex} in a record, with its place."""
    if isinstance(record, dict):
        if set(record) == {"decimal", "hex"}:
            yield place, record["decimal"], record["hex"]
        for key, value in record.items():
            yield from numbers(value, f"{place}.{key}")
    elif isinstance(record, list):
        for i, value in enumerate(record):
            yield from numbers(value, f"{place}[{i}]")


def test_records_hold_the_same_number_twice_and_exactly(tmp_path):
    solution = solve(small({"a": [0, 2], "b": [1]}), LeastSquares())
    recognition = recognize(X, {"p": [1.0, 0, 2], "q": [0.0, 1, 0]}, lambda1=1.0, lambda2=0.0, lambda3=1.0)
    certificate = solution.certificate
    for record in (
        solution_record(solution),
        recognition_record(recognition),
        certificate_record(certificate),
    ):
        write_json(tmp_path / "r.json", record)
        back = json.loads((tmp_path / "r.json").read_text(encoding="ascii"))
        assert back == record
        found = list(numbers(back))
        assert len(found) >= 5, found
        for place, decimal, text in found:
            pairs = zip(decimal, text, strict=True) if isinstance(text, list) else [(decimal, text)]
            for number, hexadecimal in pairs:
                assert float(number) == float.fromhex(hexadecimal), (place, number, hexadecimal)
    record = solution_record(solution)
    assert record["w"]["decimal"] == solution.w.tolist()
    assert [float.fromhex(x) for x in record["u"]["hex"]] == solution.u.tolist()
    assert record["status"] == "not certified"
    assert record["solver"]["claim"] == "perfect, trust me"
    assert (record["certificate"]["lower"]["decimal"], record["certificate"]["upper"]["decimal"]) == (
        certificate.lower,
        certificate.upper,
    )
    partition = Modalities.of(record["problem"]["modalities"], 3)
    assert [np.r_[c].tolist() for c in partition] == [[0, 2], [1]]


def test_a_recognition_record_says_what_the_recognition_says():
    recognition = recognize(X, {"p": [1.0, 0, 2], "q": [0.0, 1, 0]}, lambda1=1.0, lambda2=0.1, lambda3=1.0)
    record = recognition_record(recognition, FeatureConfiguration())
    assert (record["verdict"], record["label"]) == (recognition.statement, recognition.label)
    assert [entry["name"] for entry in record["ranked_views"]] == [r.name for r in recognition.ranked_views()]
    assert [template["name"] for template in record["templates"]] == ["p", "q"]
    assert FeatureConfiguration.from_dict(record["features"]) == FeatureConfiguration()
    assert record["schema"] == "convexperc/recognition/5"


def test_every_template_has_its_own_bounds_gap_and_proved_zeros():
    objects = {"p": [1.0, 0, 2], "q": [0.0, 1, 0], "r": [0.0, 1, 0]}
    lambdas = {"lambda1": 1.0, "lambda2": 0.1, "lambda3": 0.2}
    found = recognize(X, objects, **lambdas, modalities=[1, 1, 1], prune=False)
    answers, record, (lower, upper) = found.answers, recognition_record(found), found.costs
    best = found.candidates[0]
    assert record["ranked_for"] == {"object": best, "template": best}
    assert record["solution"]["w"]["decimal"] == found.template(best).solution.w.tolist()
    assert best != found.candidates[-1]
    assert len(set(map(tuple, answers.zero_modalities.tolist()))) > 1, answers.zero_modalities
    assert len(set(answers.gap.tolist())) > 1, answers.gap
    for j, (name, row) in enumerate(zip(found.names, record["templates"], strict=True)):
        cost = row["cost"]["lower"]["decimal"], row["cost"]["upper"]["decimal"]
        assert cost == (lower[j], upper[j]), name
        assert (row["object"], row["gap"]["decimal"]) == (name, answers.gap[j])
        assert cost[0] < cost[1], (name, cost)
        assert found.template(name).gap == answers.gap[j], name
        proved = {each.name: each.proved_zero for each in found.ranked_modalities(name)}
        assert proved == dict(zip(("m1", "m2", "m3"), answers.zero_modalities[j].tolist(), strict=True)), name


def test_what_is_infinite_is_a_word_that_c_reads(tmp_path):
    problem = small()
    certificate = certify(problem, [np.nan, 0.0], np.zeros(3))
    record = certificate_record(certificate, optimality_residual(problem, [0, 0], [0, 0, 0]))
    write_json(tmp_path / "c.json", record)
    back = json.loads((tmp_path / "c.json").read_text(), parse_constant=pytest.fail)
    assert back["gap"] == {"decimal": "inf", "hex": "inf"}
    assert back["certified"] is False
    assert len(back["kkt_residual"]["views"]) == 2


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "out.json"
    write_atomic(path, b"old")

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left"):
        write_atomic(path, b"new and longer")
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.json"]


def test_a_written_file_has_the_usual_mode_and_a_link_stays_one(tmp_path):
    (tmp_path / "plain").touch()
    write_atomic(tmp_path / "real.json", b"1")
    assert stat.S_IMODE((tmp_path / "real.json").stat().st_mode) == stat.S_IMODE(
        (tmp_path / "plain").stat().st_mode
    )
    (tmp_path / "link.json").symlink_to(tmp_path / "real.json")
    write_atomic(tmp_path / "link.json", b"2")
    assert (tmp_path / "link.json").is_symlink()
    assert (tmp_path / "real.json").read_bytes() == b"2"


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for path in (
        tmp_path,
        tmp_path / "none" / "a.json",
        tmp_path / "pipe",
        tmp_path / "loop" / "x",
        "/dev/null",
        "/dev/stdout",
    ):
        with pytest.raises(InputError, match="must be a file that can be written"):
            check_place(path)
        with pytest.raises(InputError, match="must be a file that can be written"):
            write_json(path, {})
    with pytest.raises(InputError, match="must be a file that can be written"):
        write_json(tmp_path / ("x" * 300), {})
