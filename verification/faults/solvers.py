"""Faults in the solvers, in the reduction, in what is undone after them, and in batches."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from convexperc.problem.library import TemplateLibrary
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem
from convexperc.problem.reduced import ReducedData
from convexperc.problem.reduction import Reduction
from convexperc.problem.scaling import Scaling
from convexperc.solution import batch as many
from convexperc.solution import single as solving
from convexperc.solution.answers import Answers
from convexperc.solvers.conic import Model
from convexperc.solvers.newton.method import Newton
from convexperc.solvers.osqp import Quadratic
from verification.checks import clarabel
from verification.faults.fault import Fault, Plant, replaced, together, wrapped
from verification.faults.formulation import single


def with_lambdas(problem: Problem, one: float, two: float, three: float) -> Problem:
    """The same data with other lambdas."""
    return Problem(
        problem.X, problem.o, modalities=problem.modalities, lambda1=one, lambda2=two, lambda3=three
    )


def halved_penalties(problem: Problem) -> Problem:
    """lambda2 / 2 and lambda3 / 2."""
    return with_lambdas(problem, problem.lambda1, problem.lambda2 / 2, problem.lambda3 / 2)


def _without_lambda3(problem: Problem) -> Problem:
    return with_lambdas(problem, problem.lambda1, problem.lambda2, 0.0)


def result_of(solver: type, change: Callable[[Problem], Problem]) -> Plant:
    """Let a solver answer another problem than the one it is given."""
    original = solver.solve  # type: ignore[attr-defined]
    return replaced(solver, "solve", lambda self, problem: original(self, change(problem)))


def assigned(change: Callable[[Problem], Problem]) -> Plant:
    """Give the conic model another problem's numbers."""
    original = Model.assign
    return replaced(Model, "assign", lambda self, problem: original(self, change(problem)))


def stopped_after(steps: int) -> Plant:
    """Newton's method with few steps."""
    original = Newton.solve
    return replaced(
        Newton, "solve", lambda self, problem: original(replace(self, max_iterations=steps), problem)
    )


def called_again(target: Any, name: str, change: Callable[..., Any]) -> Plant:
    """As `wrapped`, where the change also needs the arguments by name."""
    original = getattr(target, name)
    return replaced(target, name, lambda *a, **k: change(original(*a, **k), *a, **k))


def reduction_with(change: Callable[[Reduction], Reduction]) -> Plant:
    """Change the Gram matrices that the reduced problem is made of."""
    return wrapped(Reduction, "of", lambda found, X, modalities: change(found))


def _in_single(true: Reduction) -> Reduction:
    K = single(true.K)
    return replace(true, K=K, G=K.sum(axis=0))


def _shifted_columns(true: Reduction) -> Reduction:
    """K_1 of the columns one further on."""
    first = Modalities.of(true.modalities.sizes, true.modalities.d).columns[0]
    block = np.roll(true.X, -1, axis=1)[:, first]
    K = true.K.copy()
    K[0] = block @ block.T
    return replace(true, K=K)


def _without_u_exponent(self: Scaling, w: Any, u: Any) -> Any:
    """The factor t / s for u as well, where t / s^2 is meant."""
    return np.ldexp(w, self.o - self.x), np.ldexp(u, self.o - self.x)


def _exchanged(found: Answers) -> Answers:
    """The intervals of the first and the last template exchanged."""
    order = np.arange(len(found))
    order[[0, -1]] = order[[-1, 0]]
    return replace(found, lower=found.lower[order], upper=found.upper[order], gap=found.gap[order])


def _narrower(found: Answers) -> Answers:
    """Intervals that begin a millionth too high."""
    return replace(found, lower=found.lower * (1.0 + 1e-6), upper=found.upper * (1.0 + 1e-6))


def _from_start(found: Answers, X: Any, O: Any, **given: Any) -> Answers:  # noqa: E741
    """The intervals of the answers that it was started from."""
    start = given.get("start")
    return found if start is None else replace(found, lower=start.lower, upper=start.upper, gap=start.gap)


def _in_first_units(found: Answers) -> Answers:
    """Every interval in the units of the first template."""
    exponents = found.data.exponents
    shift = 2 * (exponents[0] - exponents)
    lower, upper, gap = (np.ldexp(x, shift) for x in (found.lower, found.upper, found.gap))
    return replace(found, lower=lower, upper=upper, gap=gap)


def _kept_by_library(setter: Any) -> None:
    """The reduced data of a library's first views for all later ones."""
    original = ReducedData.of
    seen: dict[int, tuple[Any, Any]] = {}

    def of(X: Any, templates: Any, *rest: Any, **named: Any) -> Any:
        if not isinstance(templates, TemplateLibrary):
            return original(X, templates, *rest, **named)
        key = id(templates)
        if key not in seen or seen[key][0] is not templates:
            seen[key] = templates, original(X, templates, *rest, **named)
        return seen[key][1]

    setter.setattr(ReducedData, "of", staticmethod(of))


def _first_lambdas(setter: Any) -> None:
    """The lambdas of the first step for the whole path."""
    original = many.solve_path

    def path(X: Any, templates: Any, grid: Any, **given: Any) -> Any:
        steps = list(grid)
        return original(X, templates, steps[:1] * len(steps), **given)

    setter.setattr(many, "solve_path", path)


SOLVERS = (
    Fault("lambda2 and lambda3 halved in the conic model", "F2/conic", assigned(halved_penalties)),
    Fault("lambda3 left out of the conic model", "F2/conic", assigned(_without_lambda3)),
    Fault(
        "lambda2 and lambda3 halved for Newton's method",
        "F2/reduced",
        result_of(Newton, halved_penalties),
    ),
    Fault("Newton's method stops after one step", "F2/reduced", stopped_after(1)),
    Fault("one modality's columns shifted in the reduction", "F2/reduced", reduction_with(_shifted_columns)),
    Fault(
        "OSQP's answer is another problem's",
        "F2/quadratic",
        result_of(Quadratic, halved_penalties),
    ),
    Fault(
        "the scaling of u undone as that of w",
        "F2/reduced",
        replaced(Scaling, "point_back", _without_u_exponent),
    ),
    Fault(
        "Clarabel's value off by 1e-4",
        "S1/optimal",
        wrapped(
            clarabel,
            "solve_directly",
            lambda found, *a: replace(found, value=found.value and found.value * 1.0001),
        ),
    ),
)

ANSWERS = (
    Fault(
        "F* scaled back by half of the exponent",
        "B1/scaling",
        replaced(
            Scaling, "value_back", lambda self, bounds: tuple(float(np.ldexp(x, self.o)) for x in bounds)
        ),
    ),
    Fault(
        "Newton stops at once and nothing follows",
        "B2/answered",
        together(
            result_of(Newton, halved_penalties),
            replaced(solving, "_escalate", lambda problem, answer, budget: (answer, "")),
        ),
    ),
    Fault(
        "Gram matrices in single precision",
        "B2/batch",
        reduction_with(_in_single),
    ),
    Fault("u of a batch is half as large", "B2/batch", wrapped(Answers, "u", lambda u, *a: 0.5 * u)),
    Fault(
        "answers of two templates exchanged",
        "B2/batch",
        wrapped(many, "solve_many", lambda found, *a: _exchanged(found)),
    ),
    Fault(
        "answers of the start returned by a warm start",
        "B2/batch",
        called_again(many, "solve_many", _from_start),
    ),
    Fault("a library's first views kept for the next", "B2/batch", _kept_by_library),
    Fault("the first lambdas of a path kept for the next", "B2/batch", _first_lambdas),
    Fault(
        "intervals in the units of the first template",
        "B2/batch",
        wrapped(many, "solve_many", lambda found, *a: _in_first_units(found)),
    ),
    Fault(
        "lambdas in the units of the first template",
        "B2/batch",
        wrapped(ReducedData, "normalised", lambda rows, *a: np.tile(rows[:1], (len(rows), 1))),
    ),
    Fault(
        "intervals of a batch a millionth too high",
        "B2/batch",
        wrapped(many, "solve_many", lambda found, *a: _narrower(found)),
    ),
)
