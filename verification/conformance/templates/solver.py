"""A solver that the conformance kit can judge: replace the body of `solve` by your own.

convexperc-verification conform --module solver:solve
"""

import numpy as np

from convexperc import Problem
from convexperc import solve as certified


def solve(X, o, modalities, *, lambda1, lambda2, lambda3):
    """Return (w, u) that minimise F; X is float64 (n, d), o (d,), modalities the sizes of the blocks of u.

    A mapping with "w", "u" and perhaps "objective" (F at w, u) and "trace" (F by iteration) will do as well.
    Raise NotImplementedError for what your solver is not made for, any other exception for malformed data.
    """
    answer = certified(
        Problem(X, o, modalities=modalities, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3)
    )
    return np.array(answer.w), np.array(answer.u)
