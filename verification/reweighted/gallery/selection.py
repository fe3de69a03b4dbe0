"""Selection of features and recovery of sparse signals: l2,1 norms, groups, logarithms."""

from typing import Any

import numpy as np

from verification.reweighted.gallery.case import Case, matrix, vector
from verification.reweighted.loops.loop import Loop
from verification.reweighted.objectives.objective import (
    Affine,
    Objective,
    each_loss,
    norm,
    norm1,
    squares,
    variable,
)

GAMMA = 1


def _rows(matrix: Affine, weight: str = "1/(2*r)") -> Objective:
    """||matrix||_{2,1}: the sum of the norms of the rows."""
    return sum((norm(matrix[i], weight) for i in range(matrix.shape[0])), Objective(()))


def robust_selection(X: Any, Y: Any) -> Loop:
    """D = diag(1 / (2 ||row||)) of the weights and of the residual."""
    W = variable("W", len(X[0]), len(Y[0]))
    return Loop(_rows(np.array(X) @ W - np.array(Y)) + GAMMA * _rows(W))


def selection(X: Any, Y: Any) -> Loop:
    """(X'X + gamma D) W+ = X'Y, D = diag(1 / (2 ||w^i||))."""
    W = variable("W", len(X[0]), len(Y[0]))
    return Loop(squares(np.array(X) @ W - np.array(Y)) + GAMMA * _rows(W))


def selection_doubled(X: Any, Y: Any) -> Loop:
    """The same with D = diag(1 / ||w^i||)."""
    W = variable("W", len(X[0]), len(Y[0]))
    return Loop(squares(np.array(X) @ W - np.array(Y)) + GAMMA * _rows(W, "1/r"))


def multi_task(X1: Any, X2: Any, y1: Any, y2: Any) -> Loop:
    """One regression a task, whose weights share their zeros; both updates from the last iterate."""
    w1, w2 = variable("w1", 2), variable("w2", 2)
    F = squares(np.array(X1) @ w1 - np.array(y1)) + squares(np.array(X2) @ w2 - np.array(y2))
    for i in range(2):
        pair = np.array([[1], [0]]) @ w1[[i]] + np.array([[0], [1]]) @ w2[[i]]
        F = F + GAMMA * norm(pair)
    return Loop(F, [["w1"], ["w2"]], "jacobi")


def overlapping_groups(A: Any, y: Any) -> Loop:
    """Groups (1, 2) and (2, 3), weights 1 / (2 ||x_g||)."""
    x = variable("x", 3)
    return Loop(squares(np.array(A) @ x - np.array(y)) + norm(x[:2]) + norm(x[1:]))


def log_sum(A: Any, y: Any) -> Loop:
    """Weights 1 / (x_j^2 + e^2)."""
    x = variable("x", 2)
    penalty = each_loss(x, "log(r**2 + e**2)", "1/(r**2 + e**2)", widths={"e": "1/10"})
    return Loop(squares(np.array(A) @ x - np.array(y)) + penalty)


def three_blocks(A: Any, y: Any) -> Loop:
    """A lasso of three entries, each updated from the last iterate."""
    names = ("a", "b", "c")
    parts = [variable(name, 1) for name in names]
    products = [np.array(A)[:, [j]] @ part for j, part in enumerate(parts)]
    F = squares(products[0] + products[1] + products[2] - np.array(y)) + sum(
        (norm1(part) for part in parts), Objective(())
    )
    return Loop(F, [[name] for name in names], "jacobi")


CASES = (
    Case(
        "robust-selection",
        "Robust selection of features, loss and penalty in the l2,1 norm",
        "Nie, Huang, Cai and Ding 2010",
        "||X W - Y||_{2,1} + gamma ||W||_{2,1}",
        "weights 1 / (2 ||row||) of both",
        robust_selection,
        {"X": matrix(3, 2), "Y": matrix(3, 1)},
        "smoothed weights, with e in the unit of each row",
    ),
    Case(
        "selection",
        "Selection of features, squares and the l2,1 norm",
        "as in many papers after 2010",
        "||X W - Y||_F^2 + gamma ||W||_{2,1}",
        "(X'X + gamma D) W+ = X'Y, D = diag(1 / (2 ||w^i||))",
        selection,
        {"X": matrix(3, 2), "Y": matrix(3, 2)},
        "smoothed weights, or the convex solver",
    ),
    Case(
        "selection-doubled",
        "The same with twice the weight",
        "planted: a factor that is often lost",
        "||X W - Y||_F^2 + gamma ||W||_{2,1}",
        "(X'X + gamma D) W+ = X'Y, D = diag(1 / ||w^i||)",
        selection_doubled,
        {"X": matrix(3, 2), "Y": matrix(3, 2)},
        "selection; it solves the problem with 2 gamma",
    ),
    Case(
        "multi-task",
        "Multi-task regression with shared zeros, both tasks from the last iterate",
        "in the manner of Argyriou, Evgeniou and Pontil 2008",
        "sum_t ||X_t w_t - y_t||^2 + gamma sum_i ||(w_1i, w_2i)||",
        "weights 1 / (2 ||(w_1i, w_2i)||)",
        multi_task,
        {"X1": matrix(2, 2), "X2": matrix(2, 2), "y1": vector(2), "y2": vector(2)},
        "smoothed weights, or the convex solver",
    ),
    Case(
        "overlapping-groups",
        "Group lasso with overlapping groups",
        "Jenatton, Audibert and Bach 2011 state the norm",
        "||A x - y||^2 + sum_g ||x_g||",
        "weights 1 / (2 ||x_g||), added where groups overlap",
        overlapping_groups,
        {"A": matrix(3, 3), "y": vector(3)},
        "smoothed weights, or the convex solver",
    ),
    Case(
        "log-sum",
        "Sparse recovery by reweighted squares",
        "Chartrand and Yin 2008; Daubechies et al. 2010",
        "||A x - y||^2 + sum_j log(x_j^2 + e^2)",
        "weights 1 / (x_j^2 + e^2)",
        log_sum,
        {"A": matrix(2, 2), "y": vector(2)},
    ),
    Case(
        "three-blocks",
        "A lasso of three blocks, each updated from the last iterate",
        "the limit of the theorem: two blocks are covered, three are not",
        "||A x - y||^2 + ||x||_1",
        "weights 1 / (2 |x_j|), every block from the last iterate",
        three_blocks,
        {"A": matrix(1, 3), "y": vector(1)},
        "the order of Gauss and Seidel",
    ),
)
