"""What was measured comes back from plain data to the last bit, and is judged the same."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_up_pictures import measured

from verification.experiments.design import Design
from verification.experiments.measure.arrays import packed, unpacked
from verification.experiments.measure.configurations import first
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.trials import Tried
from verification.experiments.record.judged import judged

DESIGN = Design(seed=3, repetitions=4, resamples=200)


def drawn(shape: tuple[int, ...]) -> Tried:
    rng = np.random.default_rng(shape)
    return Tried(rng.integers(0, 4, shape), rng.random(shape), rng.integers(-1, 3, shape))


@pytest.fixture
def given() -> Measured:
    settings = drawn((15, 4, 6, DESIGN.repetitions))
    found = measured(settings, drawn((15, 5, 5, 2)), DESIGN, w=np.array([0.3, -0.1, 0, 1e-300, 2, 1 / 3]))
    return replace(found, explained=settings)


@pytest.mark.parametrize(
    "array",
    [np.array([0.1, -0.0, 5e-324, np.inf, np.nan]), np.arange(-3, 3).reshape(2, 3), np.zeros((0, 4)),
     np.arange(12.0).reshape(3, 4).T, np.array([1, 2], dtype=">i4")],
    ids=["special", "integers", "empty", "transposed", "big-endian"],
)  # fmt: skip
def test_an_array_comes_back_to_the_last_bit(array: np.ndarray) -> None:
    found = unpacked(json.loads(json.dumps(packed(array))))
    assert found.shape == array.shape
    assert found.dtype == array.dtype.newbyteorder("<")
    np.testing.assert_array_equal(found, array)
    assert np.array_equal(np.signbit(found.astype(float)), np.signbit(array.astype(float)))


def test_what_was_measured_comes_back_and_is_judged_the_same(given: Measured) -> None:
    data = json.loads(json.dumps(given.as_json()))
    back = Measured.from_json(data, given.design, given.layout, given.study)
    assert back.as_json() == given.as_json()
    assert judged(back, first(1)[0]) == judged(given, first(1)[0])


def test_only_the_default_configuration_is_told_in_full(given: Measured) -> None:
    assert "default" in judged(given, first(1)[0])
    other = replace(given, explained=None)
    assert "default" not in judged(other, first(2)[1])
    assert other.as_json()["explained"] is None
