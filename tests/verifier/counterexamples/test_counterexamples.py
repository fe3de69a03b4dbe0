"""The catalogue: every record is confirmed exactly, is as small as it says, and is stale once repaired."""

import json
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from smallest import smallest_lock, smallest_rise
from whole_numbers import Batch, problems, whole_problem

from convexperc.errors import FileFormatError, InputError, SolverError
from convexperc.problem.problem import Problem
from convexperc.solvers.paper.loop import run
from verification.checks.catalogue import CHECKS
from verification.checks.interface import Check, Observation, Recorder
from verification.checks.operations import eliminate
from verification.counterexamples.confirmation import agree, enclosure, text
from verification.counterexamples.fields import KINDS, names
from verification.counterexamples.files import catalogue, load, load_all, save, schema
from verification.counterexamples.found import case_record, rise_record
from verification.counterexamples.kinds import BY_KIND, completed, confirm, refutation
from verification.counterexamples.record import Record, magnitude, parse
from verification.exact.algorithm import ORDERS, SIZES, Update
from verification.exact.loop import iterates, start
from verification.exact.numbers import Enclosure
from verification.exact.problem import ExactProblem
from verification.ledger.claims import PARTS
from verification.ledger.evidence import Outcome
from verification.problems.sources import Seeded, Source

RECORDS = {record.id: record for record in catalogue()}
FOLDER = Path(__file__).parents[3] / "verification" / "counterexamples" / "catalogue"
REFUTED = {
    *(f"T1a/{name}/{order}" for name, order in product(SIZES, ORDERS) if name != "corrected"),
    *(f"T1b/{name}/{order}" for name, order in product(SIZES, ORDERS)),
    *("D1/printed", "D2/printed", "L2/inequality", "A1/objective", "A2/substitution"),
    *("N1/w_system", "N1/u_system", "F4/similar", "R1/defined", "C1/step6", "C1/step7", "S1/optimal"),
}
CHECKED = {check.name: check for check in CHECKS}
SCHEMA = jsonschema.Draft202012Validator(schema())


def changed(record: Record, **changes: Any) -> Record:
    return replace(record, fields=dict(record.fields) | changes, expect={})


def posed(record: Record, **changes: Any) -> Record:
    assert record.problem is not None
    numbers = {name: Fraction(value) for name, value in changes.items()}
    return replace(record, problem=replace(record.problem, **numbers), expect={})


@pytest.mark.parametrize("name", RECORDS)
def test_every_record_is_confirmed(name: str) -> None:
    result = confirm(RECORDS[name], CHECKED)
    assert result.confirmed, result.finding
    assert result.found.keys() == RECORDS[name].expect.keys(), result.found
    assert refutation(RECORDS[name], result).confirmed, result


@pytest.mark.parametrize("name", RECORDS)
def test_every_record_follows_its_schema_and_goes_round(name: str, tmp_path: Path) -> None:
    record = RECORDS[name]
    assert list(SCHEMA.iter_errors(record.as_json())) == [], record.id
    place = save(record, tmp_path)
    assert place.read_bytes() == (FOLDER / f"{name}.json").read_bytes(), place
    assert load(place) == record
    assert record.size.number == magnitude(record.problem) if record.problem else record.size.number > 0


def test_every_refuted_part_has_a_record_and_no_other() -> None:
    assert {record.part for record in RECORDS.values()} == REFUTED
    assert set(PARTS) >= REFUTED
    assert {record.kind for record in RECORDS.values()} == {*BY_KIND, "case"}
    assert set(KINDS) == {*BY_KIND, "case"}


def repaired() -> Iterable[tuple[str, Record]]:
    """One record of each kind, changed so that the claim is true there or the proof has a hole."""
    rise, limit = RECORDS["rise-absolute-gauss-seidel"], RECORDS["limit-absolute-gauss-seidel"]
    yield "rise: the corrected update", changed(rise, reading="corrected")
    yield "rise: one iteration early", changed(rise, iterations=11)
    yield "rise: no iteration", changed(rise, iterations=0)
    yield "limit: the corrected update", changed(limit, reading="corrected")
    yield "limit: not yet in the box", changed(limit, iterations=2)
    yield "limit: not the fixed point", changed(limit, limit={"w": ["751/1000"], "u": ["751/1000"]})
    tiny = {"w": [["7499/10000", "7501/10000"]], "u": [["7499/10000", "7501/10000"]]}
    yield "limit: the box is too small for this iterate", changed(limit, box=tiny)
    yield (
        "limit: a box with the optimum in it",
        changed(limit, box={"w": [["1/4", "1"]], "u": [["1/4", "1"]]}),
    )
    yield "limit: no repetition", changed(RECORDS["limit-printed-sign"], iterations=1)
    locked = RECORDS["locked-w-gauss-seidel"]
    yield "locked: another entry", changed(locked, zero=[0])
    yield "locked: not the best", changed(locked, best={"w": ["1/5", "0"], "u": ["0", "0"]})
    yield "locked: nothing better", changed(locked, better=locked.fields["best"])
    yield "locked: the zero belongs there", posed(locked, lambda2=2)
    yield "locked: no penalty holds it", posed(locked, lambda2=0)
    singular = RECORDS["singular-w-printed"]
    yield "singular: another lambda2", posed(singular, lambda2=7)
    yield "singular: with |w_i|", changed(singular, reading="absolute")
    yield "singular: the other system", changed(singular, system="u")
    yield "singular: with lambda3", posed(RECORDS["singular-u-no-modality-norm"], lambda3=1)
    yield "inequality: v = t", changed(RECORDS["l1-analogue"], t=["1", "0"])
    yield "inequality: Lemma 1 itself", changed(RECORDS["l1-analogue"], v=["1"], t=["3"])
    yield "substitution: one entry", changed(RECORDS["appendix-substitution"], v=["2"], w=["3"])
    yield "objective: lambda1 = 1", posed(RECORDS["appendix-objective"], lambda1=1)
    yield "derivative: no penalty", posed(RECORDS["derivative-w-factor"], lambda2=0)
    yield "derivative: a step that tells nothing", changed(RECORDS["derivative-u-factor"], h="4")
    similar = RECORDS["similarity-one-view"]
    yield "similarity: not optimal", posed(similar, lambda2=1)
    yield "similarity: one lambda3", changed(similar, optima=similar.fields["optima"][:1])
    tie = RECORDS["tie-permuted-templates"]
    one = tie.fields["templates"][0]
    yield "tie: alone", changed(tie, templates=[one])
    yield "tie: not optimal", changed(tie, templates=[one, one | {"o": ["2", "0"]}])
    zero = RECORDS["tie-all-zero"]
    longer = {"o": ["1/2"], "w": ["0"], "u": ["0"]}
    yield "tie: another length", changed(zero, templates=[zero.fields["templates"][0], longer])
    yield "exponent: cubic is claimed", changed(RECORDS["exponent-step6"], claimed=3)
    yield "exponent: sizes do not double", changed(RECORDS["exponent-step6"], sizes=[8, 24])


@pytest.mark.parametrize(("what", "record"), list(repaired()), ids=lambda x: x if isinstance(x, str) else "")
def test_a_record_that_no_longer_fails_is_stale(what: str, record: Record) -> None:
    result = confirm(record, {})
    assert not result.confirmed, (what, result.finding)
    assert not refutation(record, result).confirmed
    with pytest.raises(FileFormatError, match="confirmed in exact arithmetic"):
        completed(record, {})


@pytest.mark.parametrize("name", RECORDS)
def test_other_numbers_than_expected_are_stale(name: str) -> None:
    record = RECORDS[name]
    for key, value in record.expect.items():
        wrong = ["77777"] * len(value) if isinstance(value, list) else "77777"
        result = confirm(record.expecting(dict(record.expect) | {key: wrong}), CHECKED)
        assert not result.confirmed, (name, key)
        assert f"not what the record expects of {key}" in result.finding, result.finding
    missing = confirm(record.expecting({"other": "1"}), CHECKED)
    assert not missing.confirmed, missing.finding


# --- how small they are ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "largest", "most"),
    [
        ("rise-printed-gauss-seidel", 3, 8),
        ("rise-printed-jacobi", 3, 8),
        ("rise-absolute-gauss-seidel", 3, 8),
        ("rise-appendix-half-gauss-seidel", 3, 8),
        ("rise-smoothed-jacobi", 3, 7),
        ("rise-smoothed-gauss-seidel", 3, 10),
        ("rise-appendix-full-jacobi", 4, 6),
    ],
)
def test_the_smallest_rise_is_found_again(name: str, largest: int, most: int) -> None:
    record = RECORDS[name]
    eps = Fraction(record.fields["eps"])
    found = smallest_rise(Update(record.fields["reading"], record.fields["order"], eps), largest, most)
    assert found is not None, name
    assert (found.problem, found.iteration) == (record.problem, record.fields["iterations"]), found
    assert found.tried > 1, found


@pytest.mark.parametrize("part", ["w", "u"])
def test_the_smallest_locked_zero_is_found_again(part: str) -> None:
    update = Update("corrected", "gauss_seidel")
    found = smallest_lock(update, 4, 7, part)
    assert found is not None
    assert found.problem == RECORDS[f"locked-{part}-gauss-seidel"].problem, found


def test_no_smaller_problem_is_singular_in_w() -> None:
    record, tried = RECORDS["singular-w-printed"], 0
    assert record.problem is not None
    for total in range(1, record.size.number - 2000 + 1):
        for numbers in problems(1, (1,), total):
            problem = whole_problem(1, (1,), np.array(numbers))
            (w,), _ = start(problem)
            singular = w != 0 and problem.X[0][0] ** 2 + problem.lambda1 + problem.lambda2 / (4 * w) == 0
            assert not singular or problem == record.problem, problem
            tried += 1
    assert tried > 1000, tried


def test_the_analogue_of_lemma_1_fails_first_in_two_entries() -> None:
    record = RECORDS["l1-analogue"]
    for v, t in product(range(1, 8), range(-8, 9)):
        assert not confirm(changed(record, v=[str(v)], t=[str(t)]), {}).confirmed, (v, t)
    failing = [
        sum(map(abs, (*v, *t)))
        for v, t in product(product(range(-2, 3), repeat=2), repeat=2)
        if any(v) and confirm(changed(record, v=[*map(str, v)], t=[*map(str, t)]), {}).confirmed
    ]
    assert min(failing) == 3 == sum(abs(int(x)) for name in "vt" for x in record.fields[name]), sorted(
        failing
    )[:5]


def test_the_screen_runs_the_same_loop() -> None:
    rows = [n for n in problems(2, (1, 1), 8) if all(n[-3:]) and n[2] and n[4]][:50]
    batch = Batch.of(2, (1, 1), np.array(rows))
    for name, order in product(SIZES, ORDERS):
        update = Update(name, order, Fraction(name == "smoothed"))
        w, u = batch.start()
        w, u = batch.step(update, *batch.step(update, w, u))
        for k, row in enumerate(rows):
            course = iterates(whole_problem(2, (1, 1), np.array(row)), update, None, 2)
            if len(course) == 3 and np.isfinite(w[k]).all() and np.isfinite(u[k]).all():
                exactly = [float(x.lower) for x in (*course[2].w, *course[2].u)]
                np.testing.assert_allclose([*w[k], *u[k]], exactly, rtol=1e-7, atol=1e-9, err_msg=f"{row}")
                F = batch.objective(w, u)[k]
                assert pytest.approx(float(course[2].F.lower), rel=1e-9) == F, (row, F)


def test_elimination_counts_what_it_does() -> None:
    for n in range(1, 14):
        assert 3 * eliminate(n) == n**3 + 3 * n**2 - n, n


# --- what a search finds -----------------------------------------------------------------------------------


def test_a_rise_in_floats_becomes_a_record(tmp_path: Path) -> None:
    problem = Problem([[1, -3], [-1, 2]], [1, -4], lambda1=2, lambda2=2, lambda3=2, modalities=[1, 1])
    trace = run(problem, variant="absolute", keep_iterates=True)
    at = int(trace.rises()[0])
    update = Update("absolute", "gauss_seidel")
    record = rise_record(
        "found-1", problem, update, trace.path_w[at - 1], trace.path_u[at - 1], "search, seed 1"
    )
    assert confirm(load(save(record, tmp_path)), {}).confirmed, record
    assert list(SCHEMA.iter_errors(record.as_json())) == []
    with pytest.raises(FileFormatError, match="confirmed in exact arithmetic"):
        rise_record("found-2", problem, update, trace.path_w[0], trace.path_u[0], "search")


def observe_sum(problem: Problem, source: Source) -> list[Observation]:
    drawn = source.matrix(1, 2)[0] * source.integer(1, 3) * source.choice((1.0, 2.0))
    return [
        Observation.of("B1/objective", bool(drawn.sum() + problem.X.sum() < 0), detail=f"sum {drawn.sum()!r}")
    ]


def observe_badly(problem: Problem, source: Source) -> list[Observation]:
    raise ZeroDivisionError(f"{problem} {source}")


def test_a_failed_case_becomes_a_record_and_is_repeated(tmp_path: Path) -> None:
    check = Check("sum", ("B1/objective",), observe_sum)
    problem = Problem([[1e-3, 100.0]], [0.1, 5e-324], lambda1=0.1, lambda2=0.2, lambda3=1e150)
    recorder = Recorder(Seeded(np.random.default_rng(0), (4, 8)))
    seen = observe_sum(problem, recorder)
    record = case_record("sum-1", "B1/objective", problem, check, recorder.drawn, recorder.largest, "search")
    again = load(save(record, tmp_path))
    result = confirm(again, {"sum": check})
    assert result.confirmed, result
    assert result.finding == seen[0].detail, result
    assert list(SCHEMA.iter_errors(again.as_json())) == []
    mended = Check("sum", ("B1/objective",), lambda p, s: [Observation.of("B1/objective", True)])
    unsure = Check("sum", ("B1/objective",), lambda p, s: [Observation("B1/objective", Outcome.UNDECIDED)])
    silent = Check("sum", ("B1/objective",), lambda p, s: [])
    for checks, words in (
        ({"sum": mended}, "held now"),
        ({"sum": unsure}, "undecided now"),
        ({"sum": silent}, "says nothing"),
        ({}, "no check 'sum'"),
    ):
        stale = confirm(again, checks)
        assert not stale.confirmed, words
        assert words in stale.finding, stale.finding
    with pytest.raises(SolverError, match="must not raise"):
        confirm(again, {"sum": Check("sum", ("B1/objective",), observe_badly)})


# --- the files ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"schema": "convexperc/counterexample/2"}, "schema must be"),
        ({"id": "Rise_1"}, "id must be words of a-z"),
        ({"id": 3}, "id must be a string"),
        ({"kind": "hearsay"}, "kind must be one of rise"),
        ({"part": "T9/x"}, "must be a part of the ledger"),
        ({"claim": "T1b"}, "must be 'T1a', the claim of"),
        ({"fields": []}, "fields must be an object"),
        ({"fields": {"reading": "printed"}}, "must have reading, order, eps"),
        ({"problem": None}, "may be null in kinds"),
        ({"problem": {"X": [["1"]]}}, "problem and size as the schema says"),
        ({"size": {"text": "small"}}, "problem and size as the schema says"),
        ({"extra": 1}, "an object with keys"),
    ],
)
def test_a_malformed_record_is_named(change: dict[str, Any], words: str) -> None:
    data = RECORDS["rise-printed-jacobi"].as_json()
    with pytest.raises(FileFormatError, match=words):
        parse(data | change, "rise.json")


@pytest.mark.parametrize("name", RECORDS)
def test_the_schema_and_the_reader_agree_on_the_fields_of_a_kind(name: str) -> None:
    data = RECORDS[name].as_json()
    kind, given = data["kind"], data["fields"]
    optional = {"limit"} if kind == "wrong_limit" else set()
    for field in names(kind):
        fewer = data | {"fields": {key: value for key, value in given.items() if key != field}}
        valid = field not in given or field in optional
        assert SCHEMA.is_valid(fewer) == valid, (name, field)
        if not valid:
            with pytest.raises(FileFormatError, match=f"in kind {kind}, as the schema says"):
                parse(fewer, name)
    more = data | {"fields": given | {"extra": "1"}}
    assert not SCHEMA.is_valid(more)
    with pytest.raises(FileFormatError, match="as the schema says"):
        parse(more, name)


def test_a_malformed_field_is_named() -> None:
    rise, derivative = RECORDS["rise-printed-jacobi"], RECORDS["derivative-w-sign"]
    for record, words in (
        (changed(rise, start={"w": [1], "u": ["1"]}), "must be a string p/q"),
        (changed(rise, start={"w": "1", "u": ["1"]}), "must be a list of strings"),
        (changed(rise, start={"w": ["1"]}), "must have the fields of kind rise"),
        (changed(derivative, w=["0"]), "must have the fields of kind derivative"),
        (changed(RECORDS["l1-analogue"], relation="hope"), "must be one of l1-analogue"),
    ):
        with pytest.raises(FileFormatError, match=words):
            confirm(record, {})
    with pytest.raises(InputError, match="reading must be one of"):
        confirm(changed(rise, reading="hopeful"), {})


def test_files_are_read_and_written_whole(tmp_path: Path) -> None:
    record = RECORDS["l1-analogue"]
    save(record, tmp_path)
    save(RECORDS["appendix-objective"], tmp_path)
    assert [each.id for each in load_all(tmp_path)] == ["appendix-objective", "l1-analogue"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["appendix-objective.json", "l1-analogue.json"]
    (tmp_path / "other.json").write_text(json.dumps(record.as_json()))
    with pytest.raises(FileFormatError, match="the name of its file"):
        load_all(tmp_path)
    (tmp_path / "other.json").write_text("{")
    with pytest.raises(FileFormatError, match="must be JSON"):
        load(tmp_path / "other.json")
    with pytest.raises(FileFormatError, match="readable file"):
        load(tmp_path / "none.json")
    with pytest.raises(FileFormatError, match="folder of records"):
        load_all(tmp_path / "none")
    with pytest.raises(InputError, match="no such folder"):
        save(record, tmp_path / "none")


def test_numbers_are_written_exactly_or_outwards() -> None:
    third, long = Fraction(1, 3), Fraction(-(10**60) - 1, 3 * 10**55)
    assert text(Enclosure(third, third)) == "1/3"
    written = text(Enclosure(long, long))
    low, high = enclosure(written).lower, enclosure(written).upper
    assert low < long < high, written
    assert high - low < Fraction(1, 10**14), written
    assert agree(written, text(Enclosure(long, long)))
    assert agree(["1", "2", "3"], ["1", "2", "3"])
    assert not agree(["1", "2", "3"], ["1", "2", "4"])
    assert agree("3/2", ["1", "2"])
    assert not agree("5/2", ["1", "2"])
    assert not agree({"a": "1"}, {"b": "1"})


def test_problems_of_a_size_are_all_there() -> None:
    found = set(problems(1, (1,), 4))
    expected = {
        (x, o, *lambdas)
        for x, o, *lambdas in product(range(1, 5), range(-4, 5), range(1, 5), range(5), range(5))
        if x + abs(o) + sum(lambdas) == 4
    }
    assert found == expected, found ^ expected
    assert whole_problem(1, (1,), np.array([1, -1, 1, 1, 0])) == ExactProblem.small([[1]], [-1], [1], 1, 1, 0)
