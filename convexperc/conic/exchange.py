"""The data that CVXPY hands to a solver, and the answers that solvers hand back."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from cvxpy import settings
from cvxpy.reductions.solvers.solver import Solver

from convexperc.conic.program import ConeProgram, Floats, NoBoundError


def program_of(data: dict[str, Any], offset: float) -> ConeProgram:
    """Return the program that the data of a conic or QP interface state.

    Raises
    ------
    NoBoundError
        It is not one of those that can be bounded.
    """
    for name in (settings.LOWER_BOUNDS, settings.UPPER_BOUNDS):
        if data.get(name) is not None:
            raise NoBoundError("bounds that are handed over apart from the constraints are not covered")
    P = data.get(settings.P)
    if settings.F in data:
        A = sp.vstack([data[settings.A], data[settings.F]])
        b = np.concatenate([data[settings.B], data[settings.G]])
        return ConeProgram.of(P, data[settings.Q], A, b, offset, data[Solver.DIMS])
    return ConeProgram.of(P, data[settings.C], data[settings.A], data[settings.B], offset, data[Solver.DIMS])


def with_heights(data: dict[str, Any], kept: Any, b: Floats) -> dict[str, Any]:
    """Return the data with another b in the rows that the program kept."""
    found = dict(data)
    heights = [np.asarray(data[name], dtype=np.float64) for name in (settings.B, settings.G) if name in data]
    full = np.concatenate(heights)
    full[kept] = b
    found[settings.B] = full[: heights[0].size]
    if settings.G in data:
        found[settings.G] = full[heights[0].size :]
    return found


def point_of(raw: Any) -> tuple[Floats, Floats]:
    """Return x and z with P x + q + A'z near 0 from the answer of Clarabel, SCS or OSQP."""
    if isinstance(raw, dict):
        x, z = raw["x"], raw["y"]
    else:
        x, z = raw.x, raw.z if hasattr(raw, "z") else raw.y
    return tuple(np.array([] if v is None else v, dtype=np.float64) for v in (x, z))  # type: ignore[return-value]
