"""The proof of bounds of F* as a file that can be checked without this library.

A proof holds the problem, the claim lower <= F* <= upper, and two exact witnesses: a primal point
(w, u) with F(w, u) <= upper, and an exactly feasible dual point (a, b) with D(a, b) >= lower. Every
number is a C99 hex float; those of the witnesses may have more digits than float64 holds.
`verification.proof_checker` checks it in integer arithmetic, without any code of this library.
"""

import hashlib
import math
from fractions import Fraction
from typing import Any

import numpy as np

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.enclosure.budget import SECONDS, Budget
from convexperc.enclosure.witness import Data, witnesses
from convexperc.errors import ConvexpercError, ProblemError, check_type
from convexperc.problem.files import problem_record
from convexperc.problem.problem import Problem
from convexperc.solution.solution import Solution

SCHEMA = "convexperc/proof/1"
"""Name and version of the file format."""


def proof_record(solution: Solution, *, seconds: float = SECONDS) -> dict[str, Any]:
    """Prove bounds of F* by exact witnesses, as plain JSON values.

    The interval is as narrow as the certificate's tolerances, or as the certificate's interval if that is
    wider. Where float64 points do not suffice, an interior point of higher precision is used, for as long as
    the budget allows; the claim says what was reached.

    Parameters
    ----------
    solution : Solution
    seconds : float
        For ball arithmetic and exact numbers; see `convexperc.enclosure.budget.Budget`.

    Returns
    -------
    dict
        ``schema``; ``problem``, itself a problem file; ``sha256``, see `data_digest`; ``claim`` with
        ``lower`` and ``upper``; ``primal`` with ``w`` and ``u``; ``dual`` with ``a`` and ``b``.

    Raises
    ------
    ProblemError
        F* may exceed the largest float64, so that its upper bound cannot be written.
    ConvexpercError
        The arithmetic of this thread is not what bounds assume, see docs/rounding.md.
    BudgetError
        `seconds` is no number > 0.
    """
    if reason := broken_assumption():
        must = "must round to nearest and keep subnormal numbers"
        remedy = "Undo what another library set, or prove in another process."
        raise ConvexpercError("floating-point arithmetic", value=reason, must=must, remedy=remedy)
    check_type(solution, Solution, "solution")
    problem, data = solution.problem, Data.of(solution.problem, Budget(seconds))
    best = witnesses(data, (solution.w, solution.u), solution.certificate)
    (high, w, u), (low, a, b) = best.primal, best.dual
    upper = _rounded_up(high)
    if upper is None:
        must = "must have an optimum below 1.8e308 for a claim in float64"
        raise ProblemError("problem", value=problem, must=must, remedy="Scale o, lambda2 and lambda3 down.")
    return {
        "schema": SCHEMA,
        "problem": problem_record(problem),
        "sha256": data_digest(problem),
        "claim": {"lower": _rounded_down(low).hex(), "upper": upper.hex()},
        "primal": {"w": w.strings(), "u": u.strings()},
        "dual": {"a": a.strings(), "b": b.strings()},
    }


def data_digest(problem: Problem) -> str:
    """Return the SHA-256 of the data, in hexadecimal.

    The bytes are: the schema's name in ASCII and a zero byte; n, d, m as int64; X row by row, o, lambda1,
    lambda2, lambda3 as float64; for each modality the number of its columns and the columns as int64; all
    little-endian.
    """
    check_type(problem, Problem, "problem")
    columns = [np.arange(problem.d)[c] for c in problem.modalities]
    parts = [
        SCHEMA.encode("ascii") + b"\0",
        np.array([problem.n, problem.d, problem.m], dtype="<i8").tobytes(),
        *(np.ascontiguousarray(v, dtype="<f8").tobytes() for v in (problem.X, problem.o, problem.lambdas)),
        *(np.array([c.size, *c], dtype="<i8").tobytes() for c in columns),
    ]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def _rounded_down(value: Fraction) -> float:
    try:
        near = float(value)
    except OverflowError:
        return math.nextafter(math.inf, 0.0)
    return near if Fraction(near) <= value else math.nextafter(near, -math.inf)


def _rounded_up(value: Fraction) -> float | None:
    """Return the least float64 that is not below the value; None if there is none."""
    try:
        near = float(value)
    except OverflowError:
        return None
    near = near if Fraction(near) >= value else math.nextafter(near, math.inf)
    return near if math.isfinite(near) else None
