"""Which object is it: one solve a template, and a label that is proved or not claimed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.arrays import euclidean_length, real_array
from convexperc.critical import zero_is_optimal
from convexperc.enclosure import enclose
from convexperc.errors import ProblemError
from convexperc.problem import Problem
from convexperc.solution import Solution
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import Solver
from convexperc.solving import solve

NARROW = 1e-30
"""Relative width asked of overlapping intervals; what is reported is limited by float64, about 1e-16."""
NORM_FACTOR = 1.1
"""Templates whose norms differ by more than this factor are warned about: F* <= ||o||^2, so a short template
wins by its length."""


class Verdict(Enum):
    """What is known of the label."""

    PROVED = "proved"
    """The best optimum lies below every other one, by proof."""
    UNDECIDED = "undecided"
    """The intervals of several templates overlap."""
    TIE = "tie"
    """No effort could decide: identical templates, or every optimum is w = u = 0."""


@dataclass(frozen=True, eq=False)
class Template:
    """One object's name and the solution of its problem."""

    name: str
    solution: Solution

    @property
    def interval(self) -> tuple[float, float]:
        """Proved bounds of F*."""
        return self.solution.certificate.lower, self.solution.certificate.upper


@dataclass(frozen=True)
class Ranked:
    """A robot or a modality with its weight.

    Attributes
    ----------
    name : str
    weight : float
        w_i of a robot, ||u^i||_2 of a modality.
    share : float
        |weight| divided by the sum over all; 0 where all are 0.
    proved_zero : bool
        No optimum uses it, by proof.
    """

    name: str
    weight: float
    share: float
    proved_zero: bool


@dataclass(frozen=True, eq=False)
class Recognition:
    """The outcome for one set of views.

    Attributes
    ----------
    verdict : Verdict
    label : str or None
        The recognised object; None unless the verdict is `PROVED`.
    candidates : tuple of str
        The templates that may have the lowest optimum, best first.
    reason : str
        Why the verdict is what it is.
    templates : tuple of Template
        In the order given.
    views : tuple of str
        Names of the robots, in the order of the rows of X.
    warnings : tuple of str
        What a user should know before trusting the label.
    """

    verdict: Verdict
    label: str | None
    candidates: tuple[str, ...]
    reason: str
    templates: tuple[Template, ...]
    views: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def certified(self) -> bool:
        """Whether every template's answer is certified."""
        return all(template.solution.certificate.certified for template in self.templates)

    def template(self, name: str | None = None) -> Template:
        """One template by its name; without one, the first candidate."""
        wanted = self.candidates[0] if name is None else name
        for template in self.templates:
            if template.name == wanted:
                return template
        raise ProblemError(
            "template", value=wanted, must=f"must be one of {[t.name for t in self.templates]}"
        )

    def ranked_views(self, name: str | None = None) -> tuple[Ranked, ...]:
        """Robots by |w_i|, largest first, for one template (default: the first candidate)."""
        solution = self.template(name).solution
        return _ranked(self.views, solution.w, solution.certificate.zero_views)

    def ranked_modalities(self, name: str | None = None) -> tuple[Ranked, ...]:
        """Modalities by ||u^i||_2, largest first, for one template (default: the first candidate)."""
        solution = self.template(name).solution
        names = solution.problem.modalities.names
        return _ranked(names, solution.modality_norms, solution.certificate.zero_modalities)


def _ranked(
    names: Sequence[str], weights: NDArray[np.float64], zeros: NDArray[np.bool_]
) -> tuple[Ranked, ...]:
    total = float(np.abs(weights).sum())
    order = np.argsort(-np.abs(weights), kind="stable")
    shares = np.abs(weights) / total if total > 0.0 else np.zeros_like(weights)
    return tuple(Ranked(names[i], float(weights[i]), float(shares[i]), bool(zeros[i])) for i in order)


def recognize(
    X: Any,
    references: Mapping[str, Any],
    *,
    lambda1: Any,
    lambda2: Any,
    lambda3: Any,
    modalities: Any = None,
    views: Sequence[str] | None = None,
    solver: Solver | None = None,
    escalate: bool = True,
    progress: Callable[[str], None] | None = None,
) -> Recognition:
    """Recognise the object that n views show.

    Parameters
    ----------
    X : array_like (n, d)
        Row i is robot i's feature vector.
    references : mapping of str to array_like (d,)
        Each known object's name and reference features: the columns of O.
    lambda1, lambda2, lambda3 : real number
    modalities : see `Modalities.of`
    views : sequence of n str, optional
        Names of the robots; ``robot 1`` ... without.
    solver : Solver, optional
        `Conic` without.
    escalate : bool
        Answer by ball arithmetic where the solver's answer is not certified, and narrow the intervals by it
        where they overlap.
    progress : callable, optional
        Called with each template's name when it is done.

    Returns
    -------
    Recognition

    Raises
    ------
    ProblemError, ModalityError
        See `Problem`; also no reference at all, or names that do not fit X.
    SolverError
        The solver gave no point for a template.

    Notes
    -----
    Paper: Algorithm 1, line 9 and its return: the label is the category with the lowest objective.
    """
    if not references:
        raise ProblemError("references", value=references, must="must name at least one object")
    judge = Conic() if solver is None else solver
    names = _view_names(X, views)
    templates, solved = [], {}
    for name, o in references.items():
        problem = Problem(X, o, modalities=modalities, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3)
        data = problem.o.tobytes()
        if data not in solved:
            solved[data] = solve(problem, judge, escalate=escalate)
        templates.append(Template(name, solved[data]))
        if progress is not None:
            progress(name)
    found = decide(tuple(templates), names)
    if escalate and found.verdict is Verdict.UNDECIDED:
        return decide(tuple(_narrowed(t, t.name in found.candidates) for t in templates), names)
    return found


def _narrowed(template: Template, rival: bool) -> Template:
    """A rival with the narrowest interval that ball arithmetic gives; another template as it is."""
    if not rival:
        return template
    solution = template.solution
    found = enclose(solution.problem, relative_tolerance=NARROW, absolute_tolerance=NARROW)
    certificate = solution.certificate
    lower, upper = max(found.lower, certificate.lower), min(found.upper, certificate.upper)
    narrow = replace(certificate, lower=lower, upper=upper)
    return replace(template, solution=replace(solution, certificate=narrow))


def _view_names(X: Any, views: Sequence[str] | None) -> tuple[str, ...]:
    """The robots' names, one for each row of X, all different."""
    n = real_array(X, "X", 2).shape[0]
    names = tuple(f"robot {i}" for i in range(1, n + 1)) if views is None else tuple(views)
    if len(names) != n or len(set(names)) != n:
        raise ProblemError("views", value=names, must=f"must name each of the {n} rows of X once")
    return names


def decide(templates: tuple[Template, ...], views: tuple[str, ...]) -> Recognition:
    """Draw the verdict from the intervals alone.

    Parameters
    ----------
    templates : tuple of Template
        At least one.
    views : tuple of str

    Returns
    -------
    Recognition
    """
    best = min(template.interval[1] for template in templates)
    rivals = sorted((t for t in templates if not t.interval[0] > best), key=lambda t: t.interval[1])
    candidates = tuple(t.name for t in rivals)
    warnings = _norm_warning(templates)
    if len(templates) > 1 and all(zero_is_optimal(t.solution.problem) for t in templates):
        names = tuple(t.name for t in templates)
        reason = "every optimum is w = u = 0, so that F* = ||o||^2 says nothing of the views; lower lambda2"
        return Recognition(Verdict.TIE, None, names, reason, templates, views, warnings)
    if len(rivals) == 1:
        reason = "its optimum lies below every other one, by proof"
        return Recognition(Verdict.PROVED, candidates[0], candidates, reason, templates, views, warnings)
    first = rivals[0].solution.problem.o
    if all(np.array_equal(t.solution.problem.o, first) for t in rivals[1:]):
        reason = f"the templates {', '.join(candidates)} are identical"
        return Recognition(Verdict.TIE, None, candidates, reason, templates, views, warnings)
    reason = f"the intervals of {', '.join(candidates)} overlap"
    return Recognition(Verdict.UNDECIDED, None, candidates, reason, templates, views, warnings)


def _norm_warning(templates: tuple[Template, ...]) -> tuple[str, ...]:
    norms = {t.name: euclidean_length(t.solution.problem.o) for t in templates}
    short, long = min(norms, key=norms.__getitem__), max(norms, key=norms.__getitem__)
    if norms[long] <= NORM_FACTOR * norms[short]:
        return ()
    return (
        f"the norms of the templates differ by more than a factor of {NORM_FACTOR}: {short} has "
        f"{norms[short]:.4g}, {long} has {norms[long]:.4g}. F* <= ||o||^2 favours the short one; "
        "normalise the features.",
    )
