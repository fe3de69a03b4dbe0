import dataclasses
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from convexperc.errors import ModalityError, PointError, ProblemError
from convexperc.problem.optimality import optimality_residual
from convexperc.problem.problem import Problem, same_data

LAMBDAS = {"lambda1": 1.0, "lambda2": 0.5, "lambda3": 0.25}


@pytest.mark.parametrize(
    ("X", "o", "spec"),
    [
        (np.ones((2, 5)), np.ones(5), [2, 3]),
        (np.ones((5, 2)), np.ones(2), [1, 1]),
        (np.ones((1, 4)), np.ones(4), {"a": [0, 2], "b": [1, 3]}),
        (np.ones((3, 1)), np.ones(1), None),
        ([[1, 2], [3, 4]], [5, 6], None),
        ([[True, False]], [True, True], None),
        (np.asfortranarray(np.arange(6.0).reshape(2, 3)), np.arange(6.0)[::2], [3]),
        (np.float32([[0.1, 0.2]]), np.float16([0.5, 0.25]), None),
        (np.array([[1, 2]], dtype=">i4"), np.array([3, 4], dtype=np.uint8), None),
        ([[2**70, -(2**64)]], [2**1000, 1], None),
        (np.zeros((2, 2)), np.zeros(2), None),
        ([[1e308, 5e-324]], [1e308, -1e308], None),
        (np.ones((4, 3))[::2], np.ones(3), None),
    ],
)
def test_legal_data_become_float64_of_the_same_numbers(X, o, spec):
    problem = Problem(X, o, modalities=spec, **LAMBDAS)
    for found, given_ in ((problem.X, X), (problem.o, o)):
        assert found.dtype == np.float64
        assert found.flags.c_contiguous, found.flags
        assert found.tolist() == [list(map(float, r)) if np.ndim(r) else float(r) for r in given_]
    assert (problem.n, problem.d) == np.shape(X)
    assert problem.m == (1 if spec is None else len(spec))
    assert sum(block.shape[1] for block in problem.blocks()) == problem.d
    assert f"n={problem.n}, d={problem.d}" in repr(problem)


@pytest.mark.parametrize(
    "value", [0, 0.0, -0.0, 1, 2**60, 1e300, 5e-324, np.float32(0.5), np.int8(3), np.array(2.0)]
)
@pytest.mark.parametrize("name", LAMBDAS)
def test_legal_lambdas(name, value):
    problem = Problem([[1.0]], [1.0], **{**LAMBDAS, name: value})
    found = getattr(problem, name)
    assert type(found) is float
    assert found == float(value)
    assert math.copysign(1.0, found) == 1.0, found
    assert problem.lambdas == (problem.lambda1, problem.lambda2, problem.lambda3)


X2 = [[1.0, 2.0], [3.0, 4.0]]
ILLEGAL = [
    ({"X": [[1, math.nan], [3, 4]]}, "X[0, 1]", math.nan),
    ({"X": [[1, 2], [-math.inf, 4]]}, "X[1, 0]", -math.inf),
    ({"o": [1, math.inf]}, "o[1]", math.inf),
    ({"X": np.array([[1, 2], [3, np.finfo(np.longdouble).max]])}, "X[1, 1]", None),
    ({"X": [1.0, 2.0]}, "X", (2,)),
    ({"X": [[X2]]}, "X", (1, 1, 2, 2)),
    ({"X": 1.0}, "X", ()),
    ({"X": np.zeros((0, 2))}, "X", (0, 2)),
    ({"X": np.zeros((2, 0)), "o": []}, "X", (2, 0)),
    ({"X": [[1, 2], [3]]}, "X", [[1, 2], [3]]),
    ({"X": [[1j, 2], [3, 4]]}, "X", "complex128"),
    ({"X": [["1", "2"]]}, "X", "str32"),
    ({"X": "x"}, "X", "str32"),
    ({"X": [[None, 1.0]]}, "X", None),
    ({"X": None}, "X", None),
    ({"X": [[b"1", b"2"]]}, "X", None),
    ({"X": np.array([["2020-01-01", "2020-01-02"]], dtype="datetime64[D]")}, "X", "datetime64[D]"),
    ({"X": [[True, 2**70]]}, "X", True),
    ({"X": [[10**400, 1]]}, "X", 10**400),
    ({"X": [[1.5, 10**400]]}, "X", None),
    ({"X": [[1.0, "a"]]}, "X", None),
    ({"X": {"a": 1}}, "X", {"a": 1}),
    ({"o": [1.0]}, "o", (1,)),
    ({"o": X2}, "o", (2, 2)),
    ({"o": 3.0}, "o", ()),
    ({"o": ["a", "b"]}, "o", "str32"),
    ({"o": None}, "o", None),
    *(
        ({name: value}, name, value)
        for name in LAMBDAS
        for value in (-1.0, -5e-324, math.nan, math.inf, 10**400, True, np.True_, "1", None, 1j, [1.0])
    ),
    ({"lambda1": 10**5000}, "lambda1", None),
    ({"X": [[10**5000, 1]]}, "X", None),
]


@pytest.mark.parametrize(("change", "what", "value"), ILLEGAL, ids=range(len(ILLEGAL)))
def test_illegal_input_is_refused_with_its_entry_and_value(change, what, value):
    data = {"X": X2, "o": [1.0, 2.0], **LAMBDAS, **change}
    with pytest.raises(ProblemError) as caught:
        Problem(data.pop("X"), data.pop("o"), **data)
    error = caught.value
    assert isinstance(error, ValueError), type(error)
    assert error.what == what
    shown = repr(value)[:20]
    assert value is None or shown in str(error), (shown, str(error))
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_an_error_about_a_value_that_cannot_be_pickled_still_pickles():
    with pytest.raises(ProblemError) as caught:
        Problem((row for row in X2), [1.0, 2.0], **LAMBDAS)
    assert type(pickle.loads(pickle.dumps(caught.value))) is ProblemError


def test_modalities_are_checked_against_x():
    with pytest.raises(ModalityError, match=r"sum to the 2 columns of X; got 3"):
        Problem(X2, [1.0, 2.0], modalities=[3], **LAMBDAS)


def test_a_problem_is_a_frozen_copy():
    X, o = np.array(X2), np.array([1.0, 2.0])
    problem = Problem(X, o, **LAMBDAS)
    X[:], o[:] = 7.0, 7.0
    assert problem.X.tolist() == X2
    assert problem.o.tolist() == [1.0, 2.0]
    for array in (problem.X, problem.o):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        problem.lambda1 = 2.0


@pytest.mark.parametrize("spec", [None, [1, 2], {"a": [0, 2], "b": [1]}])
def test_pickle_keeps_the_data_and_the_freeze(spec):
    problem = Problem([[0.1, -0.0, 5e-324]], [1.0, 2.0, 3.0], modalities=spec, **LAMBDAS)
    again = pickle.loads(pickle.dumps(problem))
    assert same_data(problem, again), (problem, again)
    assert again.X.tobytes() == problem.X.tobytes()
    assert again.modalities.names == problem.modalities.names
    arrays = [again.X, again.o, *(c for c in again.modalities if isinstance(c, np.ndarray))]
    assert [array.flags.writeable for array in arrays] == [False] * len(arrays)


@pytest.mark.parametrize(
    "change",
    [
        {"X": [[1, 2], [3, 5]]},
        {"o": [1, 3]},
        {"lambda1": 9},
        {"lambda2": 9},
        {"lambda3": 9},
        {"modalities": [1, 1]},
    ],
)
def test_same_data_sees_every_change(change):
    base = {"X": X2, "o": [1.0, 2.0], "modalities": {"a": [0, 1]}, **LAMBDAS}
    first, twin, other = (
        Problem(**base),
        Problem(**{**base, "modalities": [2]}),
        Problem(**{**base, **change}),
    )
    assert same_data(first, twin), (first, twin)
    assert not same_data(first, other), (first, other)


@given(hnp.arrays(np.float64, hnp.array_shapes(min_dims=1, max_dims=2, max_side=3), elements=st.floats()))
def test_any_float_array_is_taken_or_refused_as_ours(values):
    legal = values.ndim == 2 and bool(np.isfinite(values).all())
    try:
        found = Problem(values, np.zeros(values.shape[-1]), **LAMBDAS).X
    except ProblemError:
        assert not legal, values
    else:
        assert legal, values
        assert found.tobytes() == values.tobytes(), (found, values)


@pytest.mark.parametrize(
    ("w", "u", "what"),
    [
        ([1.0], [1.0, 2.0], "w"),
        ([1.0, 2.0], [1.0], "u"),
        ([1.0, math.nan], [1.0, 2.0], "w[1]"),
        ("ab", [1, 2], "w"),
    ],
)
def test_points_that_do_not_fit_are_refused(w, u, what):
    with pytest.raises(PointError) as caught:
        optimality_residual(Problem(X2, [1.0, 2.0], **LAMBDAS), w, u)
    assert caught.value.what == what
