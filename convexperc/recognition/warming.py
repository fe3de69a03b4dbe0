"""Machine code of all kernels ahead of time: for a container's image, for CI, or before the first frame."""

from pathlib import Path

import numpy as np

from convexperc.certificate.lasso import lasso_bounding_kernel
from convexperc.certificate.reduced import bounding_kernel
from convexperc.errors import require
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.extraction import extract
from convexperc.features.hog import summing_kernel
from convexperc.features.lbp import comparing_kernel
from convexperc.kernels import machine_code
from convexperc.problem.problem import Problem
from convexperc.recognition.label import recognize
from convexperc.solution.advancing import advancing_kernel, ranking_kernel
from convexperc.solution.single import solve
from convexperc.solvers.newton.loop import newton_kernel
from convexperc.solvers.newton.subproblem import lasso_kernel

KERNELS = (
    ranking_kernel,
    advancing_kernel,
    newton_kernel,
    lasso_kernel,
    bounding_kernel,
    lasso_bounding_kernel,
    comparing_kernel,
    summing_kernel,
)


def warm() -> tuple[Path, ...]:
    """Load the machine code of all kernels into this process; what is not there yet is compiled and kept.

    Without it, the solver is interpreted, and scikit-image describes the pictures, until that has taken as
    long as this would take: about a second where the machine code exists, about ten where it does not.

    Returns
    -------
    tuple of pathlib.Path
        Where the machine code lies; empty if no folder can be written.

    Raises
    ------
    MissingExtraError
        Numba is not installed.
    """
    require("numba", "fast", "machine code")
    for kernel in KERNELS:
        kernel.demand()
    extract([np.zeros((16, 16, 3), dtype=np.uint8)], FeatureConfiguration())
    X, library = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5]]), np.random.default_rng(0).random((3, 96))
    for lambda1 in (0.1, 0.0):
        problem = Problem(X, library[:, 0], lambda1=lambda1, lambda2=0.1, lambda3=0.1, modalities=[1, 2])
        one, two, three = problem.penalties
        recognize(X, library, lambda1=one, lambda2=two, lambda3=three)  # enough templates for a prediction
        solve(problem)
    return tuple(path for kernel in KERNELS for path in machine_code.places(kernel.name))
