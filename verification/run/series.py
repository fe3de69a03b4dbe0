"""Numbers for the plots: runs on chosen problems, and distributions over a campaign."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solvers.paper.loop import run
from verification.checks.catalogue import CHECKS
from verification.ledger.claims import ORDERS, READINGS
from verification.search.engine import Result
from verification.search.shards import UNBOUNDED

SHOWN = 12
"""Iterations shown of each update variant on the counterexample."""

LONG = 400
"""Iterations shown where the rate is the subject."""

DECADES = range(-16, 4)
"""Distances in (10^(k-1), 10^k] are counted for each k; what is smaller or larger goes to the ends."""

FLOOR = 1e-17
"""Gaps below this share of F* are rounding and are not drawn."""


def counterexample() -> dict[str, Any]:
    """F by iteration for each update variant where the printed update climbs from 4 to 9 and F* is 1."""
    problem = Problem([[1.0]], [-1.0], lambda1=1.0, lambda2=4.0, lambda3=0.0)
    proof = solve(problem).certificate
    runs = {
        variant: run(problem, variant=variant, max_iterations=SHOWN, tolerance=0.0).F.tolist()
        for variant in READINGS
    }
    title = "n = d = 1, X = 1, o = -1, lambda1 = 1, lambda2 = 4, lambda3 = 0"
    return {"title": title, "F_star": [proof.lower, proof.upper], "runs": runs}


def rate() -> dict[str, Any]:
    """F - F* by iteration, corrected and smoothed: where every zero is strict, and where not."""
    strict = Problem(
        [[2.0, 0.0, 1.0], [0.5, 1.0, -1.0]],
        [2.0, 1.0, 0.0],
        modalities=[1, 2],
        lambda1=1,
        lambda2=1,
        lambda3=1,
    )
    critical = Problem([[1.0]], [1.0], lambda1=1.0, lambda2=2.0, lambda3=1.0)
    curves = {
        "corrected, every zero strict": _gaps(strict, "corrected"),
        "smoothed, every zero strict": _gaps(strict, "smoothed"),
        "corrected, one zero not strict": _gaps(critical, "corrected"),
        "smoothed, one zero not strict": _gaps(critical, "smoothed"),
    }
    return {
        "title": "a problem of n = 2, d = 3, and X = o = lambda1 = lambda3 = 1, lambda2 = 2",
        "curves": curves,
        "reference": "1/(2k+1)^2",
    }


def _gaps(problem: Problem, variant: str) -> list[float]:
    """(F(k) - F*) / F* against the upper end of the proved interval, as long as it is more than rounding."""
    upper = solve(problem).certificate.upper
    F = run(problem, variant=variant, max_iterations=LONG, tolerance=0.0, on_singular="minimum_norm").F
    gaps = (F - upper) / upper
    end = int(np.argmax(gaps <= FLOOR)) or len(gaps)
    return [float(gap) for gap in gaps[:end]]


def distances(result: Result) -> dict[str, Any]:
    """Of each update variant and order: runs by the decade of (F(last) - F*) / F*, and how many have none.

    Undecided runs met the limit of iterations; undefined ones met a singular system, or diverged.
    """
    counts: dict[str, list[int]] = {}
    undecided: dict[str, int] = {}
    undefined: dict[str, int] = {}
    for variant in READINGS:
        for order in ORDERS:
            name = f"{variant}/{order}"
            tallies = [tally for (part, _), tally in result.tallies.items() if part == f"T1b/{name}"]
            total: Mapping[int, int] = _merged([tally.decades for tally in tallies])
            counts[name] = [_within(total, at) for at in DECADES]
            undefined[name] = total.get(UNBOUNDED, 0)
            undecided[name] = sum(tally.outcomes["undecided"] for tally in tallies)
    return {
        "edges": [float(10.0**k) for k in DECADES],
        "counts": counts,
        "undecided": undecided,
        "undefined": undefined,
    }


FORMULA_CHECKS = frozenset(check.name for check in CHECKS if not check.product)
"""Checks that evaluate formulas of the paper alone."""


def coverage(result: Result) -> dict[str, int]:
    """How many problems of each family were looked at, over all checks that run code that is judged."""
    problems: dict[str, int] = {}
    for (check, family), count in result.problems.items():
        if check in FORMULA_CHECKS:
            continue
        problems[family] = problems.get(family, 0) + count
    return dict(sorted(problems.items()))


def _merged(parts: list[dict[int, int]]) -> dict[int, int]:
    total: dict[int, int] = {}
    for part in parts:
        for decade, count in part.items():
            total[decade] = total.get(decade, 0) + count
    return total


def _within(total: Mapping[int, int], at: int) -> int:
    """How many lie in decade `at`; runs without a limit are not among them."""
    low = -UNBOUNDED if at == DECADES[0] else at
    high = UNBOUNDED if at == DECADES[-1] else at + 1
    return sum(count for decade, count in total.items() if low <= decade < high)
