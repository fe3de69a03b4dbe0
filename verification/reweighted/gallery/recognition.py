"""The paper's own loop: printed, corrected, smoothed."""

from typing import Any

import numpy as np

from verification.reweighted.gallery.case import Case, matrix, numbers, vector
from verification.reweighted.loops.loop import Loop
from verification.reweighted.objectives.objective import norm, norm1, squares, variable

OBJECTIVE = "||X'w - o||^2 + lambda1 ||X u - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||"
SOURCE = "Reily and Zhang, Simultaneous View and Feature Selection"


def _loop(data: dict[str, Any], of_w: str, of_u: str, widths: dict[str, str], order: str) -> Loop:
    X, o, lambdas = (
        np.array(data["X"]),
        np.array(data["o"]),
        (data["lambda1"], data["lambda2"], data["lambda3"]),
    )
    w, u = variable("w", X.shape[0]), variable("u", X.shape[1])
    F = squares(X.T @ w - o) + lambdas[0] * squares(X @ u - w)
    F = F + lambdas[1] * norm1(w, of_w, widths=widths) + lambdas[2] * norm(u, of_u, widths=widths)
    return Loop(F, [["w"], ["u"]], order)


def printed(**data: Any) -> Loop:
    """D^w = diag(1/(2 w_j)), D^u = blockdiag(I/(2 ||u^i||)), each halved by its place in the system."""
    return _loop(data, "1/(4*r)", "1/(4*r)", {}, "gauss_seidel")


def corrected(**data: Any) -> Loop:
    """With |w_j| and without the factor 1/2."""
    return _loop(data, "1/(2*abs(r))", "1/(2*r)", {}, "gauss_seidel")


def corrected_jacobi(**data: Any) -> Loop:
    """The same, both updates from the last iterate."""
    return _loop(data, "1/(2*abs(r))", "1/(2*r)", {}, "jacobi")


def smoothed(**data: Any) -> Loop:
    """The corrected one with sqrt(w_j^2 + e^2) and sqrt(||u^i||^2 + e^2)."""
    weight = "1/(2*sqrt(r**2 + e**2))"
    return _loop(data, weight, weight, {"e": "1/1000"}, "gauss_seidel")


_DATA = {
    "X": matrix(1, 1),
    "o": vector(1),
    **{name: numbers(1) for name in ("lambda1", "lambda2", "lambda3")},
}

CASES = (
    Case(
        "paper-printed",
        "Views and modalities, as printed",
        SOURCE,
        OBJECTIVE,
        "(XX' + lambda1 I + lambda2/2 D^w) w+ = X(o + lambda1 u), D^w = diag(1/(2 w_j)); for u likewise",
        printed,
        _DATA,
        "paper-corrected",
    ),
    Case(
        "paper-corrected",
        "Views and modalities, corrected",
        "docs/theorem.md",
        OBJECTIVE,
        "the same with |w_j| and without the factor 1/2",
        corrected,
        _DATA,
        "paper-smoothed, or the convex solver",
    ),
    Case(
        "paper-corrected-jacobi",
        "Views and modalities, corrected, both updates from the last iterate",
        "docs/theorem.md",
        OBJECTIVE,
        "the same; u+ from w",
        corrected_jacobi,
        _DATA,
        "paper-smoothed, or the convex solver",
    ),
    Case(
        "paper-smoothed",
        "Views and modalities, smoothed",
        "docs/theorem.md",
        OBJECTIVE,
        "the corrected one with sqrt(w_j^2 + e^2) and sqrt(||u^i||^2 + e^2)",
        smoothed,
        _DATA,
    ),
)
