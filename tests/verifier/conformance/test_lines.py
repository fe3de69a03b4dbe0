"""Lines that are written and read fast say what Python's own JSON says, and what is refused stays refused."""

import json
import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from convexperc.errors import FileFormatError
from convexperc.files import NoFloat, parse_json
from convexperc.problem.problem import Problem
from verification.conformance.answers import AnswerError, parsed, vector
from verification.conformance.doors import Function, Module
from verification.conformance.request import Request

FINITE = st.floats(allow_nan=False, allow_infinity=False)
EDGES = (
    "0", "-0", "-0.0", "0e0", "1e-400", "-1E-400", "1e400", "1E+400", "1e0000000400", "0e-400", "NaN",
    "-Infinity",
    "1" * 250, "1" * 400, "0." + "0" * 340 + "1", "0." + "0" * 250 + "1e-99", "1" * 250 + "e99", "4.9e-324",
    "01", "1.", ".5", "+1", "1e", "0x1p3", "true", "null", '"0x1p-2000"', '"nan"', '"a\\"b"', '"\\ud800"',
    '"\\u0041"', '"a\tb"', '"é"', "[]", "[[1.0]]", "{}", '{"w": 1, "w": 2}', "[true]", '["1"]', "[1, 2.5]",
)  # fmt: skip
NUMBERS = st.one_of(FINITE.map(repr), FINITE.map("{:.3E}".format), st.integers().map(str))
LISTS = st.lists(NUMBERS | st.sampled_from(EDGES), max_size=4).map(lambda items: f"[{', '.join(items)}]")
PAIRS = st.tuples(
    st.sampled_from(("id", "w", "u", "e", "\\u0077", "", 'a\\"')), st.sampled_from(EDGES) | NUMBERS | LISTS
)
OBJECTS = st.lists(PAIRS, max_size=4).map(lambda pairs: "{" + ",".join(f'"{k}":{v}' for k, v in pairs) + "}")
LINES = st.one_of(
    OBJECTS,
    OBJECTS.map(lambda text: f" {text}\r"),
    OBJECTS.map(lambda text: f"\ufeff{text}"),
    st.tuples(OBJECTS, OBJECTS).map("".join),
    LISTS,
    st.text(),
)


def spelt(value: Any) -> Any:
    """What tells two values apart to the bit and to the type."""
    if isinstance(value, dict):
        return [(key, spelt(entry)) for key, entry in value.items()]
    if isinstance(value, list):
        return [spelt(entry) for entry in value]
    return type(value), struct.pack("d", value) if type(value) is float else value


def strict(line: bytes) -> Any:
    value = parse_json(line, "line")
    if not isinstance(value, dict):
        raise FileFormatError("line", value=value, must="must be an object")
    return value


@given(LINES)
def test_a_line_is_read_as_strictly_as_a_file(text: str):
    line = text.encode("utf-8", "surrogatepass")
    try:
        expected = strict(line)
    except FileFormatError:
        with pytest.raises(AnswerError):
            parsed(line)
    else:
        assert spelt(parsed(line)) == spelt(expected)


@pytest.mark.parametrize("lost", ["1e-400", "1e400", "0." + "0" * 340 + "1", "NaN"])
def test_a_number_that_float64_does_not_hold_is_no_float(lost: str):
    read = parsed(f'{{"id": "a", "w": [0.5, {lost}], "u": [1e-05]}}')
    assert isinstance(read["w"][1], NoFloat), read
    with pytest.raises(AnswerError, match=r"w\[1\] must be finite"):
        vector(read["w"], "w", 2)


def test_a_key_twice_is_refused_in_a_plain_answer():
    for twice in (
        '"w": [1.0], "u": [0.5], "w": [1.0]',
        '"id": "a", "w": [1.0]',
        '"status": "x", "status": "y"',
    ):
        with pytest.raises(AnswerError, match="a key twice"):
            parsed(f'{{"id": "a", {twice}}}')


@given(st.lists(FINITE, min_size=1, max_size=6))
def test_a_request_has_the_shortest_decimals_with_the_same_bits(numbers: list[float]):
    problem = Problem([[1.0] * len(numbers)], numbers, lambda1=0.1, lambda2=1e-5, lambda3=1e16)
    line = Request("a", problem).line
    assert spelt(json.loads(line)) == spelt(json.loads(json.dumps(Request("a", problem).as_json())))
    own = line[line.index('"o":[') + 5 :].partition("]")[0].split(",")
    assert [digits(text) for text in own] == [digits(repr(x)) for x in problem.o.tolist()]


def digits(number: str) -> int:
    """How many digits a decimal has, zeros at its ends left out."""
    return len(number.lower().partition("e")[0].replace(".", "").lstrip("-").strip("0"))


ODD = {
    "{1.0}": "w must be a list of numbers",
    "'one'": "w must be a list of numbers",
    "np.array([1j])": "w[0] must be a number",
    "[Decimal('1.5')]": "w[0] must be a number",
    "[Fraction(1, 2)]": "w[0] must be a number",
    "[datetime(2020, 1, 1)]": "w[0] must be a number",
    "['\\ud800']": "w[0] must be a number",
    "[float('nan')]": "w[0] must be finite",
    "np.array([np.inf])": "w[0] must be finite",
}
"""What a solver may return as w, and what is told."""


def test_what_is_no_number_in_python_is_none_in_the_answer(tmp_path: Path):
    """In a process of its own, and in this one."""
    program = (
        "import numpy as np\nfrom datetime import datetime\nfrom decimal import Decimal\n"
        f"from fractions import Fraction\nVALUES = [{', '.join(ODD)}]\n"
        "def odd(X, o, modalities, *, lambda1, **weights):\n    return VALUES[int(lambda1)], [0.5]\n"
    )
    (tmp_path / "odd.py").write_text(program)
    here: dict[str, Any] = {}
    exec(program, here)
    with Module("odd:odd", folder=tmp_path) as door:
        for k, told in enumerate(ODD.values()):
            request = Request("a", Problem([[1.0]], [1.0], lambda1=float(k), lambda2=0.1, lambda3=0.1))
            for each in (door, Function(here["odd"])):
                reply = each.ask(request)
                assert reply.answer is None, (k, reply)
                assert told in reply.faults[0], (k, reply)
