"""Pairs of programs, measured: rounding and jumps are not taken for faults, and planted faults are found."""

import math
import warnings

import numpy as np
import pytest

from convexperc.errors import InputError
from verification.reweighted import Word, judge_functions
from verification.reweighted.terms.measured import ROOTED, TOLERANCE
from verification.reweighted.terms.sampling import GRID, POINTS, callable_on_arrays, sampled

HALF, WHOLE = "r**2/2", "r**2"


def huber(r, c=1.3):
    return np.where(r < c, r * r / 2, c * r - c * c / 2)


def huber_weight(r, c=1.3):
    return np.where(r < c, 1.0, c / np.maximum(r, c))


SOUND = {
    "1 - exp": (lambda r: 1 - np.exp(-r * r), lambda r: np.exp(-r * r), WHOLE),
    "log(1 + x) with a great factor": (
        lambda r: 1e12 * np.log(1 + (r / 1e6) ** 2), lambda r: 1 / (1 + (r / 1e6) ** 2), WHOLE,
    ),
    "a great number added": (lambda r: 1e6 + r * r / 2, lambda r: 1.0 + 0 * r, HALF),
    "a loss that is a step of 1e-8 in float64": (
        lambda r: np.sqrt(1e16 + 1e8 * r * r) - 1e8, lambda r: 1e8 / np.sqrt(1e16 + 1e8 * r * r), HALF,
    ),
    "a weight that is a difference": (lambda r: r - np.log(1 + r), lambda r: (1 - 1 / (1 + r)) / r, HALF),
    "a noisy weight": (lambda r: r * r / (1 + r * r), lambda r: (1 - r * r / (1 + r * r)) ** 2, WHOLE),
    "a norm": (abs, lambda r: 1 / abs(r), HALF),
    "a power": (lambda r: r**0.5, lambda r: 0.5 * r**-1.5, HALF),
    "a kink in the weight": (huber, huber_weight, HALF),
    "a jump in the weight": (lambda r: np.minimum(r * r, 4), lambda r: 1.0 * (r < 2), WHOLE),
    "float32": (lambda r: np.log1p(np.float32(r) ** 2), lambda r: 1 / (1 + np.float32(r) ** 2), WHOLE),
    "numbers only": (
        lambda r: r * r / 2 if r < 1 else r - 0.5, lambda r: 1.0 if r < 1 else 1 / r, HALF,
    ),
    "math": (lambda r: math.log1p(r * r), lambda r: 1 / (1 + r * r), WHOLE),
    "a weight that is bool": (lambda r: np.minimum(r * r, 4), lambda r: np.less(r, 2), WHOLE),
}  # fmt: skip


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_program_is_not_accused(name):
    loss, weight, square = SOUND[name]
    answers = judge_functions(loss, weight, square, formula=False)
    assert answers.faults == (), str(answers)
    for question in ("tangent", "majorises", "sign"):
        assert answers[question].word is Word.YES, str(answers)
        assert answers[question].basis.startswith(f"{ROOTED}, not proved"), "a measurement is called one"
    assert f"{TOLERANCE:g}" in answers["tangent"].basis


FAULTY = {
    "twice": (lambda r: np.log(1 + r * r), lambda r: 2 / (1 + r * r), WHOLE, "tangent"),
    "0.3 percent": (huber, lambda r: 1.003 * huber_weight(r), HALF, "tangent"),
    "unit of the width": (lambda r: np.log(1 + r * r / 9), lambda r: 1 / (1 + r * r / 9), WHOLE, "tangent"),
    "unit of an absolute floor": (lambda r: r, lambda r: 1 / np.maximum(r, 1e-6), HALF, "units"),
    "other function": (huber, lambda r: 1 / (1 + r * r), HALF, "tangent"),
    "threshold": (huber, lambda r: huber_weight(r, 2.6), HALF, "tangent"),
    "end of the weight": (lambda r: np.minimum(r * r, 4), lambda r: 1.0 * (r < 3), WHOLE, "tangent"),
    "rises": (
        lambda r: np.maximum(r - 1, 0) ** 2 / 2,
        lambda r: np.maximum(r - 1, 0) / np.maximum(r, 1),
        HALF,
        "majorises",
    ),
    "negative": (lambda r: -r * r / 2, lambda r: -1 + 0 * r, HALF, "sign"),
    "jump of the loss": (lambda r: r * r / 2 + 2 * (r > 1), lambda r: 1 + 0 * r, HALF, "majorises"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTY)
def test_a_planted_fault_is_named(name):
    loss, weight, square, question = FAULTY[name]
    answers = judge_functions(loss, weight, square, formula=False)
    assert answers[question].accuses, str(answers)
    assert answers[question].instance


def test_a_jump_of_the_loss_is_no_wrong_slope():
    loss, weight, square, _ = FAULTY["jump of the loss"]
    assert judge_functions(loss, weight, square, formula=False)["tangent"].word is Word.YES


def test_a_factor_is_told_only_where_it_is_one_number():
    loss, weight, square, _ = FAULTY["twice"]
    said = judge_functions(loss, weight, square, formula=False)["tangent"].statement
    assert "2 times the tangent one" in said
    for name in ("threshold", "end of the weight", "unit of an absolute floor"):
        loss, weight, square, _ = FAULTY[name]
        said = judge_functions(loss, weight, square, formula=False)["tangent"].statement
        assert "times the tangent" not in said


def test_both_signs_are_asked_for_a_residual_and_one_for_a_norm():
    asked = []

    def loss(r):
        asked.append(np.min(r))
        return 0.5 * r * r

    judge_functions(loss, lambda r: 1.0 + 0 * r, HALF, formula=False)
    assert min(asked) >= 0
    judge_functions(loss, lambda r: 1.0 + 0 * r, HALF, signed=True, formula=False)
    assert min(asked) < 0


def test_weights_that_differ_at_r_and_its_negative_do_not_majorise():
    def share(r):
        return np.where(r > 0, 0.3, 0.7)

    answers = judge_functions(lambda r: share(r) * r * r / 2, share, HALF, signed=True, formula=False)
    assert answers["tangent"].word is Word.YES
    assert answers["majorises"].accuses
    assert {"r", "-r"} <= set(answers["majorises"].instance)
    assert judge_functions(lambda r: share(r) * r * r / 2, share, HALF, formula=False).faults == ()


def test_what_happens_at_zero_is_told_and_no_fault():
    raised = judge_functions(abs, lambda r: 1 / r, HALF, formula=False)["at zero"]
    assert (raised.word, raised.accuses) == (Word.NO, False)
    assert "weight(0) raises ZeroDivisionError" in raised.statement
    infinite = judge_functions(np.abs, lambda r: 1 / np.abs(np.asarray(r)), HALF, formula=False)["at zero"]
    assert "weight(0) is inf" in infinite.statement
    assert judge_functions(huber, huber_weight, HALF, formula=False)["at zero"].word is Word.YES


def cauchy(width):
    return (lambda r: width**2 * np.log1p((r / width) ** 2)), (lambda r: 1 / (1 + (r / width) ** 2))


def switchable(width):
    def weight(r):
        return (2 * width / (width + np.maximum(r * r, width))) ** 2

    def loss(r):
        beyond = 3 * width - 4 * width**2 / (width + np.maximum(r * r, width))
        return np.where(r * r <= width, r * r, beyond)

    return loss, weight


def mistaken(width):
    return cauchy(width)[0], lambda r: 1 / (1 + r * r / width)


@pytest.mark.parametrize(
    ("make", "said"), [(cauchy, "the unit of r."), (switchable, "the unit of r squared.")]
)
def test_the_unit_of_a_width_is_told(make, said):
    answer = judge_functions(*make(1.0), WHOLE, make=make, formula=False)["units"]
    assert answer.word is Word.YES
    assert answer.statement.endswith(f"if the width has {said}")


def test_a_width_of_another_unit_in_the_weight_is_a_fault_though_the_pair_is_right_at_width_1():
    answers = judge_functions(*mistaken(1.0), WHOLE, make=mistaken, formula=False)
    assert answers["tangent"].word is Word.YES
    assert answers["units"].accuses


def test_a_formula_is_decided_exactly_if_it_is_that_of_the_function():
    answers = judge_functions(lambda r: r**2 / (1 + r**2), lambda r: 1 / (1 + r**2) ** 2, WHOLE)
    assert answers["tangent"].word is Word.YES
    assert "simplified by SymPy" in answers["tangent"].basis
    assert "formulas that the functions return" in answers["tangent"].basis


def test_rounded_numbers_of_a_formula_accuse_nobody():
    c = 1.345
    square = c * c + 1e-15  # not the exact square: the formulas differ, the functions do not
    answers = judge_functions(
        lambda r: square * r**2 / (square + r**2), lambda r: c**4 / (c * c + r**2) ** 2, WHOLE
    )
    assert answers.faults == ()
    assert answers["tangent"].basis.startswith(ROOTED)


def test_a_function_that_does_something_else_with_a_symbol_is_not_believed():
    def weight(r):
        return 1.0 + 0 * r if isinstance(r, (float, np.ndarray)) else 1 / (1 + r**2)

    answers = judge_functions(lambda r: r**2 / 2, weight, HALF)
    assert answers.faults == ()
    assert answers["tangent"].basis.startswith(ROOTED)


def test_functions_without_numbers_are_refused():
    with pytest.raises(InputError, match="one real number"):
        judge_functions(lambda r: "loss", lambda r: 1.0, HALF)
    with pytest.raises(InputError, match="square"):
        judge_functions(huber, huber_weight, "r")


def test_a_function_that_is_nowhere_finite_gets_no_verdict():
    answers = judge_functions(lambda r: r + math.inf, lambda r: 1.0 + 0 * r, HALF, formula=False)
    assert answers["tangent"].word is Word.UNDECIDED


def test_arrays_are_used_only_where_they_give_the_same_numbers():
    def totalled(r):
        return np.sum(r) + 0 * r

    called = callable_on_arrays(totalled)
    assert called(np.array([1.0, 2.0])).tolist() == [1.0, 2.0]


def test_warnings_and_changed_arguments_of_foreign_functions_stay_theirs():
    def loss(r):
        warnings.warn("foreign", stacklevel=1)
        value = r * r / 2
        if isinstance(r, np.ndarray):
            r *= 0
        return value

    before = GRID.copy()
    assert judge_functions(loss, lambda r: 1.0 + 0 * r, HALF, formula=False).faults == ()
    assert np.array_equal(before, GRID)


def test_the_estimated_noise_is_that_of_the_function():
    rng = np.random.default_rng(0)
    noisy = sampled(lambda r: r * r + 1e-4 * rng.standard_normal(np.shape(r)), 1.0, "change")
    middle = noisy.noise[40]
    assert np.all((middle > 3e-4) & (middle < 3e-2))
    exact = sampled(lambda r: r * r, 1.0, "change")
    assert np.all(exact.noise < 1e-11 * exact.values.max(axis=2))
    assert GRID.shape[2] == POINTS
