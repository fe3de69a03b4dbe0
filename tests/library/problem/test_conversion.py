"""Numbers are taken as given at every door, or refused: masked ones, and those that float64 would change."""

import json
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from convexperc import Problem, TemplateLibrary, Tolerances, certify, enclose, recognize, solve_many
from convexperc.errors import FileFormatError, InputError, TemplateNameError
from convexperc.problem.columns import checked_names
from convexperc.problem.conversion import changed
from convexperc.problem.files import ProblemFile, read_answer, read_problem
from convexperc.problem.optimality import optimality_residual
from convexperc.solvers.paper import run

LAMBDAS = {"lambda1": 1.0, "lambda2": 0.5, "lambda3": 0.25}
X = np.array([[1.0, 2.0], [3.0, 4.0]])
PROBLEM = Problem(X, [1.0, 2.0], **LAMBDAS)
ODD = 2**53 + 1
LONG = np.longdouble(1) + np.longdouble(2) ** -60
WIDE = np.dtype(np.longdouble).itemsize > 8

DOORS = {
    "X": lambda row: Problem([row, [1.0, 2.0]], [1.0, 2.0], **LAMBDAS),
    "o": lambda row: Problem(X, row, **LAMBDAS),
    "O": lambda row: solve_many(X, [row, [1.0, 2.0]], **LAMBDAS),
    "O as an array": lambda row: solve_many(X, np.ma.stack([row, row]), **LAMBDAS),
    "a library": lambda row: TemplateLibrary.of({"a": row}),
    "references": lambda row: recognize(X, {"a": row, "b": [1.0, 2.0]}, **LAMBDAS),
    "w": lambda row: certify(PROBLEM, row, [1.0, 2.0]),
    "u": lambda row: certify(PROBLEM, [1.0, 2.0], row),
    "a": lambda row: certify(PROBLEM, [1.0, 2.0], [1.0, 2.0], dual=(row, [1.0, 2.0])),
    "start": lambda row: enclose(PROBLEM, start=(row, [1.0, 2.0])),
    "start of the paper's loop": lambda row: run(PROBLEM, start=(row, [1.0, 2.0])),
    "KKT": lambda row: optimality_residual(PROBLEM, row, [1.0, 2.0]),
    "lambda": lambda row: Problem(X, [1.0, 2.0], lambda1=row[0], lambda2=1, lambda3=1),
    "tolerance": lambda row: Tolerances(relative=row[0]),
    "sizes": lambda row: Problem(X, [1.0, 2.0], modalities=row.astype(int), **LAMBDAS),
    "columns": lambda row: Problem(X, [1, 2], modalities={"a": row[:1].astype(int), "b": [0]}, **LAMBDAS),
}


@pytest.mark.parametrize("door", DOORS)
def test_a_mask_is_refused_at_every_door(door):
    row = np.ma.array([1.0, 1.0], mask=[True, False])
    with pytest.raises(InputError, match="must not be masked; got 'a mask that hides"):
        DOORS[door](row)


def test_a_masked_entry_in_a_list_is_no_number():
    with pytest.raises(InputError, match="masked"):
        Problem([[1.0, np.ma.masked], [1, 2]], [1.0, 2.0], **LAMBDAS)
    with pytest.raises(InputError, match="masked"):
        recognize(X, {"a": [1.0, np.ma.masked], "b": [1.0, 2.0]}, **LAMBDAS)


ROUNDED = {
    "int64": np.array([ODD, 1]),
    "uint64": np.array([2**64 - 1, 1], dtype=np.uint64),
    "the least int64 but one": np.array([-(2**63) + 1, 1]),
    "long integers": [2**70 + 1, 1],
    "an integer among floats": [ODD, 0.5],
    "an integer of NumPy among floats": [np.int64(ODD), 0.5],
    **({"long double": np.array([LONG, 1])} if WIDE else {}),
}


@pytest.mark.parametrize("name", ROUNDED)
@pytest.mark.parametrize(
    "door", [door for door in DOORS if door not in ("O as an array", "sizes", "columns")]
)
def test_a_number_that_float64_would_round_is_refused_at_every_door(door, name):
    with pytest.raises(InputError, match="must be a number that float64 holds exactly"):
        DOORS[door](ROUNDED[name])


@pytest.mark.parametrize(
    "kind", [np.int64, np.uint64, np.longdouble, np.float32, np.float16, ">f4", ">i8", bool]
)
def test_numbers_that_float64_holds_are_taken_in_any_type(kind):
    given_ = np.array([[1, 0], [3, 1]]).astype(kind)
    for found in (Problem(given_, [1, 0], **LAMBDAS).X, solve_many(X, given_, **LAMBDAS).data.library.O):
        assert (found == given_).all()
    for end in (2**63 - 1024, -(2**63), 2**53):
        assert not changed(np.array([float(end)]), np.array([end])).any()


@given(st.integers(-(2**63), 2**63 - 1) | st.integers(-(2**54), 2**54))
def test_an_integer_is_changed_where_its_float_is_another_number(value):
    source = np.array([value], dtype=np.int64)
    assert changed(source.astype(np.float64), source)[0] == (int(float(value)) != value)


@pytest.mark.parametrize(
    "make",
    [
        lambda: recognize(X, {0: [1, 1], 1: [1, 1]}, **LAMBDAS),
        lambda: TemplateLibrary.of({0: [1, 1], 1: [1, 1]}),
        lambda: checked_names([0, 1], 2, TemplateNameError, "names", "templates"),
        lambda: checked_names((0,), 1, TemplateNameError, "views", "rows of X"),
    ],
)
def test_names_that_are_no_strings_are_refused(make):
    with pytest.raises(TemplateNameError, match="by strings that are not empty"):
        make()


def written(tmp_path, number):
    """A problem file with the text of a number in every place that takes one, and an answer file."""
    record = f'"lambda1": {number}, "lambda2": 1, "lambda3": 1'
    place, answer = tmp_path / "problem.json", tmp_path / "answer.json"
    place.write_text(f'{{"X": [[{number}]], "o": [{number}], {record}}}', encoding="utf-8")
    answer.write_text(f'{{"w": [{number}], "u": [1]}}', encoding="utf-8")
    return place, answer


REFUSED = {
    "9007199254740993": "float64 holds exactly",
    str(10**23): "float64 holds exactly",
    '"0x1.00000000000008p+0"': "float64 holds exactly",
    '"0x1p-1075"': "float64 holds exactly",
    '"0x1.fffffffffffff8p+1022"': "float64 holds exactly",
    '"0x1p+1024"': "finite number",
    f'"0x1p+{"9" * 5000}"': "finite number",
    "1e-400": "finite number",
    "-0.001e-330": "finite number",
    "1e400": "finite number",
    str(10**400): "finite number",
    "NaN": "finite number",
    "true": "finite number",
}


@pytest.mark.parametrize("number", REFUSED)
def test_a_number_that_float64_would_change_is_refused_in_a_file(tmp_path, number):
    place, answer = written(tmp_path, number)
    with pytest.raises(FileFormatError, match=REFUSED[number]) as caught:
        read_problem(place)
    assert caught.value.what.endswith("X[0][0]")
    with pytest.raises(FileFormatError, match=REFUSED[number]) as caught:
        read_answer(answer, ProblemFile(None, Problem([[1]], [1], **LAMBDAS)))
    assert caught.value.what.endswith("w[0]")


READ = {
    "0.1": 0.1,
    "9007199254740993.0": 9007199254740992.0,
    "1e23": 1e23,
    "0e-400": 0.0,
    "4.9e-324": 5e-324,
    "9007199254740992": 2.0**53,
    '"0x1.0000000000000000000000p+0"': 1.0,
    '"0X.8"': 0.5,
    '"0x1p-1074"': 5e-324,
    '"0x0.00p-99999"': 0.0,
    '"0x1.fffffffffffffp+1023"': sys.float_info.max,
}


@pytest.mark.parametrize("number", READ)
def test_other_numbers_are_read_as_they_are_meant(tmp_path, number):
    place, _ = written(tmp_path, number)
    found = read_problem(place).problem
    assert (found.X[0, 0], found.o[0], found.lambda1) == (READ[number],) * 3


@given(st.integers(0, 2**60), st.integers(0, 15), st.integers(-1120, 1030))
def test_a_hex_float_is_read_where_float64_holds_it(tmp_path_factory, whole, places, power):
    text, exact = f"0x{whole:x}.{places:x}p{power}", Fraction(16 * whole + places, 16) * Fraction(2) ** power
    try:
        held = Fraction(float(exact)) == exact
    except OverflowError:
        held = False
    place, _ = written(tmp_path_factory.mktemp("hex"), json.dumps(text))
    if held:
        assert Fraction(read_problem(place).problem.o[0]) == exact
    else:
        with pytest.raises(FileFormatError):
            read_problem(place)
