"""The geometric median: Weiszfeld's loop, its repair, and floors that are absolute."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from verification.reweighted.gallery.case import Case, points
from verification.reweighted.loops.loop import Loop
from verification.reweighted.objectives.objective import Objective, norm, variable

OBJECTIVE = "sum_i ||x - a_i||"


def _distances(points: Sequence[Sequence[int]], weight: str) -> Objective:
    x = variable("x", len(points[0]))
    return sum((norm(x - np.array(point), weight) for point in points), Objective(()))


def weiszfeld(points: Sequence[Sequence[int]]) -> Loop:
    """Weights 1 / ||x - a_i||; at a point of the data it rests, which is the limit of the update."""
    return Loop(_distances(points, "1/r"))


def weiszfeld_as_printed(points: Sequence[Sequence[int]]) -> Loop:
    """The same, and no update at a point of the data."""
    return Loop(_distances(points, "1/r"), at_zero="undefined")


def vardi_zhang(points: Sequence[Sequence[int]]) -> Loop:
    """The same; at a point of the data the step of the others, shortened by what this point pulls back."""
    return Loop(_distances(points, "1/(2*r)"), at_zero="leave")


def smoothed(points: Sequence[Sequence[int]]) -> Loop:
    """Weights 1 / sqrt(||x - a_i||^2 + e^2), with e in the unit of the data."""
    x = variable("x", len(points[0]))
    weight, widths = "1/(2*sqrt(r**2 + e**2))", {"e": "1/100"}
    terms = (norm(x - np.array(point), weight, widths=widths) for point in points)
    return Loop(sum(terms, Objective(())))


def floored(points: Sequence[Sequence[int]]) -> Loop:
    """Weights 1 / max(||x - a_i||, 1e-6), and the end where a step is at most 1e-6."""

    def stop(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
        return float(np.linalg.norm(after["x"] - before["x"])) <= 1e-6

    return Loop(_distances(points, "1/(2*max(r, 0.000001))"), stop=stop)


CASES = (
    Case(
        "weiszfeld",
        "Geometric median, Weiszfeld's loop",
        "Weiszfeld 1937; convergence claimed by Kuhn 1973, refuted by Chandrasekaran and Tamir 1989",
        OBJECTIVE,
        "x+ = sum_i a_i / ||x - a_i|| / sum_i 1 / ||x - a_i||",
        weiszfeld,
        {"points": points()},
        "vardi-zhang",
    ),
    Case(
        "weiszfeld-as-printed",
        "Geometric median, without a rule at a point of the data",
        "Weiszfeld 1937",
        OBJECTIVE,
        "x+ = sum_i a_i / ||x - a_i|| / sum_i 1 / ||x - a_i||",
        weiszfeld_as_printed,
        {"points": points()},
        "vardi-zhang",
    ),
    Case(
        "vardi-zhang",
        "Geometric median, Vardi and Zhang's loop",
        "Vardi and Zhang 2000",
        OBJECTIVE,
        "x+ = x + max(0, 1 - eta / ||R||) (T - x) at a point of the data, T and R of the other points",
        vardi_zhang,
        {"points": points()},
    ),
    Case(
        "median-smoothed",
        "Geometric median, smoothed weights",
        "a smoothing in the manner of Charbonnier et al. 1997",
        OBJECTIVE,
        "weights 1 / (2 sqrt(||x - a_i||^2 + e^2))",
        smoothed,
        {"points": points()},
    ),
    Case(
        "median-floored",
        "Geometric median with an absolute floor and an absolute stop",
        "as in several programs",
        OBJECTIVE,
        "weights 1 / (2 max(||x - a_i||, 1e-6)); stop where the step is at most 1e-6",
        floored,
        {"points": points()},
        "a floor and a stop that are shares of the spread of the data, or vardi-zhang",
    ),
)
