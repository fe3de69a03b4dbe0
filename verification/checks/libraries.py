"""Small template libraries, and the ways in which one comes to their answers.

An answer may depend on nothing but its own views, template and lambdas: not on what a solver, a library or an
earlier answer was asked before, nor on the size of the other templates.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from convexperc.problem.library import TemplateLibrary
from convexperc.problem.problem import Problem
from convexperc.recognition import label as recognizing
from convexperc.recognition.recognition import Recognition
from convexperc.solution import batch as many
from convexperc.solution.answers import Answers
from verification.exact.problem import ExactProblem
from verification.problems.sources import Source

FRESH, COPY = "another template", "the same again"
NEGATED = "the first one negated"
"""Its optimum is that of the first one, at (-w, -u): no interval can separate them, and no order either."""
NEAR = "the first one, its last entry changed in the last digits"
"""Its first entries are those of the first one, and the intervals of the two overlap."""
SCALED = "another template of another size"
SWAPPED = "two columns of equal data exchanged"
DIGITS = (44, 30, 40)
"""A near template differs from the first one by 2^-this of its largest entry."""
KINDS = (FRESH, COPY, NEGATED, SCALED, NEAR, NEAR)
"""Near ones twice: only with the first one among the best do their intervals overlap where it matters."""
SIZES = (2.0**20, 1e6, 1e-6, 2.0**-20)
ALONE, WARM, PATH, SHARED = "alone", "from other answers", "on a path", "with a library used before"
WAYS = (ALONE, WARM, PATH, SHARED)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A problem whose X may have two equal columns, its templates, and those that are the first one again."""

    problem: Problem
    templates: tuple[np.ndarray, ...]
    twins: tuple[int, ...]

    @property
    def problems(self) -> list[Problem]:
        """One for each template."""
        return [self.problem.for_template(o) for o in self.templates]

    @property
    def O(self) -> np.ndarray:  # noqa: E743, N802 - the paper's symbol
        """One column a template."""
        return np.stack(self.templates).T


def drawn_templates(problem: Problem, source: Source) -> Drawn:
    """Draw up to three more templates, most of them made of the first one."""
    group = next((g for g in ExactProblem.of(problem).groups if len(g) > 1), None)
    templates, twins, X = [problem.o], [0], problem.X
    kinds = (*KINDS, SWAPPED) if group else KINDS
    for j in range(1, source.integer(2, 4)):
        kind, o = source.choice(kinds), problem.o.copy()
        if kind in (FRESH, SCALED):
            o = source.matrix(1, problem.d)[0]
        if kind == SCALED:
            o *= source.choice(SIZES)
        if kind == NEGATED:
            o = -o
        if kind == NEAR:
            o[-1] += np.abs(o).max() * 2.0 ** -source.choice(DIGITS)
        if kind == SWAPPED and group:
            X = X.copy()
            X[:, group[1]] = X[:, group[0]]
            o[[group[0], group[1]]] = o[[group[1], group[0]]]
        if kind in (COPY, SWAPPED):
            twins.append(j)
        templates.append(o)
    return Drawn(_with_views(problem, X), tuple(templates), tuple(twins))


def _with_views(problem: Problem, X: np.ndarray) -> Problem:
    lambda1, lambda2, lambda3 = problem.lambdas
    return Problem(
        X, problem.o, modalities=problem.modalities, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3
    )


def _posed(problem: Problem) -> dict[str, Any]:
    """Modalities and lambdas as arguments."""
    names = ("lambda1", "lambda2", "lambda3")
    return {"modalities": problem.modalities} | dict(zip(names, problem.lambdas, strict=True))


def solved(drawn: Drawn, source: Source) -> tuple[Answers, str]:
    """Solve all templates in one of the `WAYS`."""
    posed, way = _posed(drawn.problem), source.choice(WAYS)
    X, O = drawn.problem.X, drawn.O  # noqa: E741
    if way == PATH:
        grid = [_other(drawn.problem), drawn.problem.lambdas]
        return list(many.solve_path(X, O, grid, modalities=drawn.problem.modalities))[-1], way
    found = _asked(many.solve_many, drawn, way)
    return found(X, O, **posed), way


def recognized(drawn: Drawn, source: Source, **options: Any) -> tuple[Recognition, str]:
    """Recognise in one of the `WAYS`."""
    posed, way = _posed(drawn.problem), source.choice(WAYS)
    X, O = drawn.problem.X, drawn.O  # noqa: E741
    if way == PATH:
        grid = [_other(drawn.problem), drawn.problem.lambdas]
        found = recognizing.recognize_path(X, O, grid, modalities=drawn.problem.modalities, **options)
        return list(found)[-1], way
    asked = _asked(recognizing.recognize, drawn, way)
    return asked(X, O, **posed, **options), way


def _asked(function: Callable[..., Any], drawn: Drawn, way: str) -> Callable[..., Any]:
    """The function, after it was asked something else: the templates backwards, or the views negated."""

    def asked(X: np.ndarray, O: np.ndarray, **given: Any) -> Any:  # noqa: E741
        if way == WARM:
            return function(X, O, **given, start=function(X, O[:, ::-1], **given))
        if way == SHARED:
            library = TemplateLibrary.of(O, modalities=drawn.problem.modalities)
            function(-X[::-1], library, **given)
            return function(X, library, **given)
        return function(X, O, **given)

    return asked


def _other(problem: Problem) -> tuple[float, float, float]:
    """Other lambdas, 0 where these are."""
    one, two, three = problem.lambdas
    return one, 2.0 * two, 0.5 * three
