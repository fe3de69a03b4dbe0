"""What a test calls is checked against its types and shapes."""

import numpy as np
import pytest
import typed
from jaxtyping import TypeCheckError

from convexperc.problem.arrays import binary_exponent

ROWS = np.ones((2, 3))


@pytest.mark.parametrize("wrong", [ROWS[0], ROWS.astype(int), ROWS.tolist()], ids=["1-d", "int", "list"])
def test_a_wrong_shape_and_a_wrong_type_are_seen(wrong: object) -> None:
    with pytest.raises(TypeCheckError, match="binary_exponent"):
        binary_exponent(wrong)


def test_the_first_calls_of_every_test_are_checked() -> None:
    whole = ROWS.astype(int)
    for _ in range(typed.MOST):
        binary_exponent(ROWS)
    assert binary_exponent(whole) == binary_exponent(ROWS), "no longer checked"
    typed.begin()
    with pytest.raises(TypeCheckError):
        binary_exponent(whole)
