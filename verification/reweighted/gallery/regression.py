"""Regression with other losses than the square: absolute deviations, quantiles, M-estimators."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from hypothesis import strategies as st

from verification.reweighted.gallery.case import Case, matrix, numbers, vector
from verification.reweighted.loops.loop import Loop
from verification.reweighted.objectives.objective import each_loss, norm1, variable

ROWS, COLUMNS = 4, 2


def _residual(A: Any, y: Any) -> Any:
    return np.array(A) @ variable("x", COLUMNS) - np.array(y)


def absolute_deviations(A: Any, y: Any) -> Loop:
    """Weights 1 / |r_i|."""
    return Loop(norm1(_residual(A, y)))


def absolute_deviations_floored(A: Any, y: Any) -> Loop:
    """Weights 1 / max(|r_i|, 1e-6), and the end where a step is at most 1e-6."""

    def stop(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
        return float(np.abs(after["x"] - before["x"]).max()) <= 1e-6

    return Loop(norm1(_residual(A, y), "1/(2*max(abs(r), 0.000001))"), stop=stop)


def quantile(y: Any) -> Loop:
    """Weights q / |r_i| above, (1 - q) / |r_i| below, q = 1/4; no regressor but a constant."""
    loss = "q*r if r >= 0 else (q - 1)*r"
    weight = "q/(2*abs(r)) if r >= 0 else (1 - q)/(2*abs(r))"
    residual = np.ones((len(y), 1), dtype=int) @ variable("x", 1) - np.array(y)
    return Loop(each_loss(residual, loss, weight, widths={"q": "1/4"}))


def huber(A: Any, y: Any) -> Loop:
    """Weights min(1, c / |r_i|)."""
    loss, weight = "r**2/2 if abs(r) <= c else c*abs(r) - c**2/2", "1 if abs(r) <= c else c/abs(r)"
    return Loop(each_loss(_residual(A, y), loss, weight, square="r**2/2", widths={"c": 1}))


def huber_doubled(A: Any, y: Any) -> Loop:
    """The weights of Huber's loss, with the width squared where it compares."""
    loss, weight = "r**2/2 if abs(r) <= c else c*abs(r) - c**2/2", "1 if abs(r) <= c**2 else c**2/abs(r)"
    return Loop(each_loss(_residual(A, y), loss, weight, square="r**2/2", widths={"c": 2}))


def cauchy(A: Any, y: Any) -> Loop:
    """Weights 1 / (1 + (r_i / c)^2)."""
    loss, weight = "c**2/2*log(1 + (r/c)**2)", "1/(1 + (r/c)**2)"
    return Loop(each_loss(_residual(A, y), loss, weight, square="r**2/2", widths={"c": 1}))


def tukey(A: Any, y: Any) -> Loop:
    """Weights (1 - (r_i / c)^2)^2 within c, 0 beyond."""
    loss = "c**2/6*(1 - (1 - (r/c)**2)**3) if abs(r) <= c else c**2/6"
    weight = "(1 - (r/c)**2)**2 if abs(r) <= c else 0"
    return Loop(each_loss(_residual(A, y), loss, weight, square="r**2/2", widths={"c": 4}))


_DATA = {"A": matrix(ROWS, COLUMNS), "y": vector(ROWS)}

CASES = (
    Case(
        "absolute-deviations",
        "Least absolute deviations by reweighted squares",
        "Schlossmacher 1973",
        "||A x - y||_1",
        "weights 1 / |r_i|; residuals of 0 stay 0",
        absolute_deviations,
        _DATA,
        "a linear program, or smoothed weights",
    ),
    Case(
        "absolute-deviations-floored",
        "Least absolute deviations with an absolute floor and an absolute stop",
        "as in several programs",
        "||A x - y||_1",
        "weights 1 / max(|r_i|, 1e-6); stop where the step is at most 1e-6",
        absolute_deviations_floored,
        _DATA,
        "a floor and a stop that are shares of the size of y",
    ),
    Case(
        "quantile",
        "Quantile regression by reweighted squares",
        "as in several programs; Hunter and Lange 2000 add the linear part that a square lacks",
        "sum_i q max(r_i, 0) + (1 - q) max(-r_i, 0), r_i = x - y_i",
        "weights q / |r_i| above, (1 - q) / |r_i| below",
        quantile,
        {"y": st.lists(numbers(-9, 9), min_size=2, max_size=5)},
        "the majoriser of Hunter and Lange, or a linear program",
    ),
    Case(
        "huber",
        "Huber's M-estimator",
        "Huber 1981; Holland and Welsch 1977",
        "sum_i rho(r_i), r = A x - y",
        "weights min(1, c / |r_i|)",
        huber,
        _DATA,
    ),
    Case(
        "huber-wrong-width",
        "Huber's M-estimator, its width compared with a squared one",
        "planted: a fault of units",
        "sum_i rho(r_i), r = A x - y",
        "weights min(1, c^2 / |r_i|)",
        huber_doubled,
        _DATA,
        "huber",
    ),
    Case(
        "cauchy",
        "M-estimator with Cauchy's loss",
        "Holland and Welsch 1977",
        "sum_i c^2/2 log(1 + (r_i / c)^2), r = A x - y",
        "weights 1 / (1 + (r_i / c)^2)",
        cauchy,
        _DATA,
    ),
    Case(
        "tukey",
        "Tukey's biweight",
        "Beaton and Tukey 1974",
        "sum_i rho(r_i), r = A x - y",
        "weights (1 - (r_i / c)^2)^2 within c, 0 beyond",
        tukey,
        _DATA,
        "a start at which enough weights are positive",
    ),
)
