"""Terms: sound pairs are acquitted, and each planted fault is named by the question that is meant."""

from fractions import Fraction

import numpy as np
import pytest

from convexperc.errors import InputError
from verification.reweighted import Word, judge_functions, judge_term
from verification.reweighted.terms.losses import LOSSES

HUBER = "r**2/2 if r <= c else c*r - c**2/2"
HUBER_WEIGHT = "1 if r <= c else c/r"
CAUCHY = "c**2*log(1 + (r/c)**2)/2"
CAUCHY_WEIGHT = "1/(1 + (r/c)**2)"
GEMAN = "c**2*r**2/(c**2 + r**2)/2"
GEMAN_WEIGHT = "c**4/(c**2 + r**2)**2"
WELSCH = "c**2*(1 - exp(-(r/c)**2))/2"
TUKEY = "c**2*(1 - (1 - (r/c)**2)**3)/6 if r <= c else c**2/6"
TUKEY_WEIGHT = "(1 - (r/c)**2)**2 if r <= c else 0"
C = {"c": "2"}

FAULTS = {
    # name: (loss, weight, square, widths, signed, the question that names it)
    "norm, weight of r**2/2 used with r**2": ("r", "1/r", "r**2", {}, False, "tangent"),
    "norm, weight of r**2 used with r**2/2": ("r", "1/(2*r)", "r**2/2", {}, False, "tangent"),
    "norm, weight 1/r**2": ("r", "1/r**2", "r**2/2", {}, False, "tangent"),
    "norm, unit of 1/r**2": ("r", "1/r**2", "r**2/2", {}, False, "units"),
    "norm, sign": ("r", "-1/r", "r**2/2", {}, False, "sign"),
    "norm, absolute value missing": ("abs(r)", "1/r", "r**2/2", {}, True, "sign"),
    "norm, unit of an absolute floor": ("r", "1/max(r, 0.000001)", "r**2/2", {}, False, "units"),
    "norm, added absolute number": ("r", "1/(r + 0.000001)", "r**2/2", {}, False, "units"),
    "norm, weight of the square": ("r", "1", "r**2", {}, False, "tangent"),
    "square, weight of the norm": ("r**2", "1/(2*r)", "r**2", {}, False, "tangent"),
    "huber, twice": (HUBER, "2 if r <= c else 2*c/r", "r**2/2", C, False, "tangent"),
    "huber, half": (HUBER, "1/2 if r <= c else c/(2*r)", "r**2/2", C, False, "tangent"),
    "huber, weight of cauchy": (HUBER, CAUCHY_WEIGHT, "r**2/2", C, False, "tangent"),
    "huber, other threshold": (HUBER, "1 if r <= 2*c else 2*c/r", "r**2/2", C, False, "tangent"),
    "huber, threshold of the square": (HUBER, "1 if r <= c**2 else c**2/r", "r**2/2", C, False, "tangent"),
    "huber, unit of the threshold": (HUBER, "1 if r <= c**2 else c**2/r", "r**2/2", C, False, "units"),
    "huber, jump in the weight": (HUBER, "1 if r <= c else 2*c/r", "r**2/2", C, False, "majorises"),
    "huber, of one side only": (
        "r**2/2 if abs(r) <= 2 else 2*abs(r) - 2", "1 if r <= 2 else 2/r", "r**2/2", {}, True, "tangent",
    ),
    "cauchy, twice": (CAUCHY, "2/(1 + (r/c)**2)", "r**2/2", C, False, "tangent"),
    "cauchy, square missing": (CAUCHY, "1/(1 + r/c)", "r**2/2", C, False, "tangent"),
    "cauchy, width not squared": (CAUCHY, "1/(1 + r**2/c)", "r**2/2", C, False, "units"),
    "cauchy, width missing": ("log(1 + (r/c)**2)/2", "1/(1 + (r/c)**2)", "r**2/2", C, False, "tangent"),
    "cauchy, unit of the width missing": ("log(1 + (r/c)**2)/2", CAUCHY_WEIGHT, "r**2/2", C, False, "units"),
    "cauchy, sign": (CAUCHY, "1/(1 - (r/c)**2)", "r**2/2", C, False, "sign"),
    "geman, not squared": (GEMAN, "c**2/(c**2 + r**2)", "r**2/2", C, False, "tangent"),
    "geman, of a norm": (GEMAN, "c**4/(c**2 + r)**2", "r**2/2", C, False, "tangent"),
    "geman, weight rises": (GEMAN, "1 - c**4/(c**2 + r**2)**2", "r**2/2", C, False, "majorises"),
    "welsch, width twice": (WELSCH, "exp(-(r/c)**2/2)", "r**2/2", C, False, "tangent"),
    "welsch, one less the weight": (WELSCH, "1 - exp(-(r/c)**2)", "r**2/2", C, False, "majorises"),
    "tukey, not squared": (TUKEY, "1 - (r/c)**2 if r <= c else 0", "r**2/2", C, False, "tangent"),
    "tukey, without the end": (TUKEY, "(1 - (r/c)**2)**2", "r**2/2", C, False, "majorises"),
    "tukey, cut off late": (
        TUKEY, "(1 - (r/c)**2)**2 if r <= 2*c else 0", "r**2/2", C, False, "majorises",
    ),
    "fourth power": ("r**4", "2*r**2", "r**2", {}, False, "majorises"),
    "quantile": ("r if r >= 0 else -r/2", "1/r if r >= 0 else -1/(2*r)", "r**2/2", {}, True, "majorises"),
    "power, exponent of the norm": ("r**(1/2)", "1/(2*r)", "r**2/2", {}, False, "tangent"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_each_planted_fault_is_named(name):
    loss, weight, square, widths, signed, question = FAULTS[name]
    answers = judge_term(loss, weight, square=square, widths=widths, signed=signed)
    answer = answers[question]
    assert answer.accuses, str(answers)
    assert answer.instance, "a fault comes with numbers"
    assert answer in answers.faults


@pytest.mark.parametrize("loss", [each for each in LOSSES if each.majorises], ids=lambda each: each.name)
def test_no_known_pair_is_accused(loss):
    answers = judge_term(loss.term)
    assert answers.faults == (), str(answers)
    for question in ("tangent", "majorises", "sign"):
        assert answers[question].word is Word.YES, str(answers)


@pytest.mark.parametrize("loss", [each for each in LOSSES if not each.majorises], ids=lambda each: each.name)
def test_pairs_that_are_known_not_to_majorise_are_tangent_all_the_same(loss):
    answers = judge_term(loss.term)
    assert [fault.question for fault in answers.faults] == ["majorises"], str(answers)
    assert answers["tangent"].word is Word.YES


@pytest.mark.parametrize(("factor", "weight"), [(2, "1/r"), (Fraction(1, 2), "1/(4*r)"), (3, "3/(2*r)")])
def test_a_constant_factor_is_told(factor, weight):
    said = judge_term("r", weight, square="r**2")["tangent"].statement
    assert said.startswith(f"The weight is {factor} times the tangent one")


@pytest.mark.parametrize("weight", ["1/sqrt(r**2 + c**2)", "1/max(r, c)", "1/(r + c)"])
def test_a_smoothed_kink_is_described_and_not_accused(weight):
    """By formula, and measured; what it descends instead is told."""
    widths = {"c": "1/1000000"}
    answers = judge_term("r", weight, square="r**2/2", widths=widths)
    assert answers["tangent"].word is Word.NO
    assert answers["descends"].word is Word.NO
    assert not answers.faults
    given = {
        "1/sqrt(r**2 + c**2)": lambda r: 1 / np.sqrt(r * r + 1e-12),
        "1/max(r, c)": lambda r: 1 / np.maximum(r, 1e-6),
    }
    function = given.get(weight, lambda r: 1 / (r + 1e-6))
    found = judge_functions(np.abs, function, formula=False)
    assert found["tangent"].word is Word.NO
    assert not found["tangent"].accuses, str(found)


def test_a_bounded_weight_that_differs_far_away_is_accused():
    assert judge_functions(np.abs, lambda r: 1 / np.maximum(r, 1e-6) * 2, formula=False)["tangent"].accuses
    assert judge_functions(lambda r: r * r, lambda r: np.where(r < 1e-6, 1.0, 2.0), formula=False)[
        "tangent"
    ].accuses


@pytest.mark.parametrize(
    ("formula", "what"),
    [
        ("r*9**9**9", "powers"),
        ("1/s", "no names"),
        ("r if r else 1", "compare"),
        ("(lambda: r)()", "must not hold"),
    ],
)
def test_a_formula_is_read_and_never_run(formula, what):
    with pytest.raises(InputError, match=what):
        judge_term(formula, "1/r")


@pytest.mark.parametrize(
    "value", ["__import__('os').system('true')", "nan", "inf", float("inf"), "abc", None, 0, -1]
)
def test_a_width_is_a_positive_number(value):
    with pytest.raises(InputError):
        judge_term("c*r", "c/(2*r)", widths={"c": value})


def test_a_python_function_that_chooses_is_sent_to_the_measuring():
    with pytest.raises(InputError, match="judge_functions"):
        judge_term(lambda r: r if r > 1 else r * r, "1/r")
