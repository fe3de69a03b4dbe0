"""Interpreted and compiled kernels give the same bits."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from convexperc.certificate.lasso import lasso_bounding_kernel
from convexperc.certificate.reduced import bounding_kernel
from convexperc.kernels.kernel import Kernel
from convexperc.kernels.machine_code import FOLDER_VARIABLE
from convexperc.problem.problem import Problem
from convexperc.recognition.label import recognize
from convexperc.solution.advancing import advancing_kernel, ranking_kernel
from convexperc.solution.batch import solve_many
from convexperc.solution.single import solve
from convexperc.solvers.newton.loop import newton_kernel
from convexperc.solvers.newton.subproblem import lasso_kernel

KERNELS = (
    newton_kernel,
    lasso_kernel,
    bounding_kernel,
    lasso_bounding_kernel,
    advancing_kernel,
    ranking_kernel,
)
SHAPES = (
    (1, (1,), 1),
    (2, (1, 2), 3),
    (5, (3, 4, 2), 4),
    (6, (2, 2), 3),
    (20, (30, 5), 2),
    (33, (10, 20), 2),
)
"""n, the sizes of the modalities, p: fewer and more features than views, short and long vectors."""


def library(seed: int, n: int, d: int, p: int) -> tuple[np.ndarray, np.ndarray]:
    """Views and templates; every other library has equal views, a view of zeros, and tiny numbers."""
    rng = np.random.default_rng(seed)
    X = rng.standard_normal((n, d)) if seed % 2 else rng.random((n, d))
    O = X.T @ rng.standard_normal((n, p)) + 0.3 * rng.standard_normal((d, p))
    if seed % 4 > 1:
        X[-1] = X[0]
        X[n // 2] = 0.0
        X *= 1e-3
    return X, O


def answered(form: str, monkeypatch: pytest.MonkeyPatch, X: Any, O: Any, **named: Any) -> list[np.ndarray]:
    """Everything that the kernels compute, in this form."""
    monkeypatch.setenv("CONVEXPERC_KERNELS", form)
    with monkeypatch.context() as patch:
        for kernel in KERNELS:
            patch.setattr(kernel, "_machine_code", None)
        alone = solve(Problem(X, O[:, 0], **named))
        found = solve_many(X, O, **named), recognize(X, O, escalate=False, **named).answers
    parts = [alone.w, alone.u, np.array([alone.certificate.lower, alone.certificate.upper])]
    for each in found:
        parts += [each.lower, each.upper, each.gap, each.w, each.modality_norms, *vars(each.reduced).values()]
    return parts


@pytest.mark.parametrize("lambdas", [(1.0, 0.1, 0.1), (0.1, 2.0, 0.01), (0.0, 0.3, 1.0), (0.5, 0.3, 0.0)])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", range(4))
def test_both_forms_give_the_same_bits(
    seed: int, shape: Any, lambdas: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    n, sizes, p = shape
    X, O = library(seed, n, sum(sizes), p)
    named = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True), modalities=list(sizes))
    interpreted, compiled = (
        answered(form, monkeypatch, X, O, **named) for form in ("interpreted", "compiled")
    )
    for k, (one, two) in enumerate(zip(interpreted, compiled, strict=True)):
        assert one.tobytes() == two.tobytes(), (k, one, two)


@pytest.mark.parametrize("lambdas", [(1.0, 0.1, 0.1), (0.5, 0.3, 0.0)])
def test_both_forms_give_the_same_bits_where_answers_are_predicted(
    lambdas: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    X, O = library(1, 2, 3, 96)
    named = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True), modalities=[1, 2])
    interpreted, compiled = (
        answered(form, monkeypatch, X, O, **named) for form in ("interpreted", "compiled")
    )
    assert all(one.tobytes() == two.tobytes() for one, two in zip(interpreted, compiled, strict=True))


def _summed(x: np.ndarray) -> float:
    total = 0.0
    for k in range(x.size):
        total += x[k] * x[k]
    return total


def _fused(x: np.ndarray) -> float:
    return float(np.dot(x, x))


@pytest.mark.parametrize(("function", "same"), [(_summed, True), (_fused, False)])
def test_another_order_of_summation_would_be_seen(
    function: Callable[..., Any], *, same: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    kernel = Kernel(_summed, lambda x: 0.0, 1.0)
    rows = np.random.default_rng(0).random((50, 100))
    equal = [kernel.compiled(x) == function(x) for x in rows]
    assert all(equal) is same, equal
