import pickle

import numpy as np
import pytest

from convexperc.errors import ModalityError
from convexperc.problem.modalities import Modalities


def groups(modalities):
    return [np.r_[columns].tolist() for columns in modalities]


@pytest.mark.parametrize(
    ("spec", "d", "names", "expected"),
    [
        (None, 3, ("m1",), [[0, 1, 2]]),
        ([3], 3, ("m1",), [[0, 1, 2]]),
        ((1, 2), 3, ("m1", "m2"), [[0], [1, 2]]),
        (np.array([1, 2]), 3, ("m1", "m2"), [[0], [1, 2]]),
        ([np.int64(2), np.uint8(1)], 3, ("m1", "m2"), [[0, 1], [2]]),
        ({"hog": 2, "lbp": 1}, 3, ("hog", "lbp"), [[0, 1], [2]]),
        ({"a": [0, 2], "b": [1]}, 3, ("a", "b"), [[0, 2], [1]]),
        ({"a": [2, 0], "b": np.array([1], dtype=np.uint8)}, 3, ("a", "b"), [[2, 0], [1]]),
        ({"a": slice(1, None), "b": slice(1)}, 3, ("a", "b"), [[1, 2], [0]]),
        ({"a": slice(0, None, 2), "b": slice(1, None, 2)}, 5, ("a", "b"), [[0, 2, 4], [1, 3]]),
        ({"a": range(2), "b": (2,)}, 3, ("a", "b"), [[0, 1], [2]]),
        ([[0, 2], [1, 3]], 4, ("m1", "m2"), [[0, 2], [1, 3]]),
        ([1] * 4, 4, ("m1", "m2", "m3", "m4"), [[0], [1], [2], [3]]),
    ],
)
def test_every_usual_form_is_read(spec, d, names, expected):
    found = Modalities.of(spec, d)
    assert found.names == names
    assert groups(found) == expected
    assert found.sizes == tuple(map(len, expected))
    assert len(found) == len(expected)
    assert Modalities.of(found, d) is found


ILLEGAL = [
    ([], 3, ()),
    ({}, 3, ()),
    ([2, 2], 3, 4),
    ([1, 1], 3, 2),
    ([3, 0], 3, 0),
    ([4, -1], 3, -1),
    ([10**400], 3, 10**400),
    ([1.0, 2.0], 3, 1.0),
    ([True, 2], 3, True),
    ("12", 3, "12"),
    (3, 3, 3),
    ({1, 2}, 3, {1, 2}),
    ({"a": [], "b": [0, 1, 2]}, 3, []),
    ({"a": slice(0, 0), "b": [0, 1, 2]}, 3, None),
    ({"a": [0, 1], "b": [1, 2]}, 3, 1),
    ({"a": [0, 0], "b": [1, 2]}, 3, 0),
    ({"a": [0], "b": [2]}, 3, 1),
    ({"a": [0], "b": [1]}, 3, 2),
    ({"a": [0, 3], "b": [1, 2]}, 3, 3),
    ({"a": [0, -1], "b": [1]}, 3, -1),
    ({"a": [0.0], "b": [1, 2]}, 3, [0.0]),
    ({"a": ["0"], "b": [1, 2]}, 3, ["0"]),
    ({"a": None, "b": [1, 2]}, 3, None),
    ({"a": [True], "b": [1, 2]}, 3, [True]),
    ({"a": [[0, 1]], "b": [2]}, 3, [[0, 1]]),
    ({"a": [[0], [1, 2]], "b": [2]}, 3, [[0], [1, 2]]),
    ({"a": [10**400], "b": [1, 2]}, 3, [10**400]),
    ({"": 3}, 3, ""),
    ({1: 3}, 3, 1),
    (Modalities.of([3], 3), 4, 3),
    ({"a": slice(0, 3, 0)}, 3, slice(0, 3, 0)),
    ({"a": slice("x")}, 3, slice("x")),
]


@pytest.mark.parametrize(("spec", "d", "value"), ILLEGAL, ids=[repr(case[0])[:40] for case in ILLEGAL])
def test_what_is_no_partition_is_refused_with_the_value(spec, d, value):
    with pytest.raises(ModalityError) as caught:
        Modalities.of(spec, d)
    assert isinstance(caught.value, ValueError), type(caught.value)
    assert value is None or caught.value.value == value, caught.value.value
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_overlap_names_both_owners_and_the_column():
    with pytest.raises(
        ModalityError, match=r"modality 'b' must not overlap: column 1 already belongs to 'a'"
    ):
        Modalities.of({"a": [0, 1], "b": [1, 2]}, 3)


def test_a_duplicate_name_is_refused():
    class Pairs(dict):
        def keys(self):
            return ["a", "a"]

        def values(self):
            return [1, 2]

    with pytest.raises(ModalityError, match="given once") as caught:
        Modalities.of(Pairs(a=1), 3)
    assert caught.value.value == "a", caught.value.value


@pytest.mark.parametrize("scale", [2.0**-1070, 1e-200, 1.0, 1e200, 2.0**1000])
def test_norms_neither_overflow_nor_underflow(scale):
    u = np.array([3.0, 4.0, 0.0, 0.0, -5.0, 12.0]) * scale
    found = Modalities.of([2, 2, 2], 6).norms(u)
    assert found == pytest.approx(np.array([5.0, 0.0, 13.0]) * scale, rel=1e-15, abs=0.0)


def test_norms_follow_the_columns_and_the_order():
    modalities = Modalities.of({"a": [0, 2], "b": [3], "c": [1]}, 4)
    u = np.array([3.0, 7.0, 4.0, -2.0])
    assert modalities.norms(u).tolist() == [5.0, 2.0, 7.0]
    turned = modalities.permuted([2, 0, 1])
    assert turned.names == ("c", "a", "b")
    assert turned.norms(u).tolist() == [7.0, 5.0, 2.0]
    assert Modalities.of([2], 2).norms(np.array([np.inf, 0.0])).tolist() == [np.inf]


def test_explicit_columns_stay_read_only_through_pickle():
    modalities = Modalities.of({"a": [0, 2], "b": [1, 3]}, 4)
    for found in (modalities, pickle.loads(pickle.dumps(modalities))):
        flags = [columns.flags.writeable for columns in found]
        assert flags == [False, False], flags
        assert groups(found) == [[0, 2], [1, 3]]
