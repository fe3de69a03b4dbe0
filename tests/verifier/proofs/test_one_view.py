"""R1/one_view beside the library: with one view and references of one length no lambda changes the label."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from convexperc import recognize
from convexperc.recognition.recognition import Verdict

LAMBDAS = st.sampled_from([0.0, 0.01, 0.1, 1.0])


def references(rng: np.random.Generator, lengths: np.ndarray) -> np.ndarray:
    """Four references with these lengths, shape (9, 4)."""
    O = rng.random((9, 4))
    return O / np.linalg.norm(O, axis=0) * lengths


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.tuples(st.sampled_from([0.1, 1.0, 10.0]), LAMBDAS, LAMBDAS))
def test_the_label_is_that_of_the_largest_product(seed: int, lambdas: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(seed)
    O, x = references(rng, np.ones(4)), rng.random((1, 9))
    products = np.abs(x @ O)[0]
    found = recognize(x, O, **dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True)))
    if lambdas[1] >= 2 * products.max():
        assert found.verdict is Verdict.TIE, "every optimum is 0"
    else:
        assert found.label == found.names[products.argmax()], (products, found)


@pytest.mark.parametrize("lambda2", [0.1, 1.0])
def test_with_references_of_unequal_lengths_the_lambdas_do_count(lambda2: float) -> None:
    O = references(np.random.default_rng(0), np.array([1.0, 1.2, 3.0, 1.1]))
    x = O[:, 2:3].T / 30
    weak = recognize(x, O, lambda1=0.1, lambda2=0.0, lambda3=0.0)
    strong = recognize(x, O, lambda1=0.1, lambda2=lambda2, lambda3=0.1)
    assert weak.label == weak.names[2], weak
    assert strong.label != weak.label, strong
