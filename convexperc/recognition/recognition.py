"""The outcome for one set of views: the label of the lowest optimum, by proof or none, and the rankings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.typing import NDArray

from convexperc.caching import cached_property
from convexperc.certificate.data_bounds import Intervals
from convexperc.certificate.rounding import Ball, squared_norm
from convexperc.errors import TemplateNameError, check_type
from convexperc.problem.arrays import FeatureVector, Vector, euclidean_length, lowest
from convexperc.problem.scaling import Scaling
from convexperc.recognition.decision import Decision, costs
from convexperc.recognition.rules import Rules
from convexperc.solution.answers import Answers
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution, Status

SMALLEST_SQUARED = 1e-140
"""Lengths below this, or above its inverse, are not squared."""


class Verdict(Enum):
    """What is known of the lowest optimum; none of them says that the object in view is the one named."""

    PROVED = "proved"
    """One object's optimum lies below every other one, by proof."""
    UNDECIDED = "undecided"
    """The intervals of several templates overlap."""
    TIE = "tie"
    """No effort could decide: interchangeable templates, or every optimum is w = u = 0."""


PROVED_OF = {
    Decision.OBJECTIVE: "lowest optimum",
    Decision.EXPLAINED_FRACTION: "largest explained fraction",
}
"""What a proof is about."""


@dataclass(frozen=True, eq=False)
class Template:
    """One reference of an object, and its answer.

    Attributes
    ----------
    name : str
    object : str
        What it shows; its own name where the object has one reference.
    answers : Answers
    index : int
        Its place in `answers`.
    excluded : bool
        Proved not to be the best; it may then have been left without a certified answer.
    cost : (float, float)
        Proved bounds of what decides, the lowest being best: F*, or F* / ||o||^2.
    """

    name: str
    object: str
    answers: Answers
    index: int
    excluded: bool
    cost: tuple[float, float]

    @property
    def interval(self) -> tuple[float, float]:
        """Proved bounds of F*."""
        return float(self.answers.lower[self.index]), float(self.answers.upper[self.index])

    @property
    def gap(self) -> float:
        """Upper bound of F(w, u) - F*."""
        return float(self.answers.gap[self.index])

    @property
    def status(self) -> Status:
        """What is known of its answer."""
        return self.answers.status(self.index)

    @property
    def w(self) -> Vector:
        """Weights of the views, shape (n,)."""
        return np.asarray(self.answers.w[self.index])

    @property
    def u(self) -> FeatureVector:
        """Weights of the features, shape (d,)."""
        return self.answers.u(self.index)

    @property
    def modality_norms(self) -> Float[np.ndarray, " m"]:
        """||u^i||_2 of each modality."""
        return np.asarray(self.answers.modality_norms[self.index])

    @property
    def proportions(self) -> tuple[Vector, Float[np.ndarray, " m"]]:
        """The |w_i| and the ||u^i||, in a unit of their own where float64 does not hold them otherwise."""
        views, modalities = np.abs(self.w), self.modality_norms
        held = [bool(np.isfinite(part).all()) for part in (views, modalities)]
        if all(held):
            return views, modalities
        problem, tolerances = self.answers.problem(self.index), self.answers.tolerances
        normal = solve(
            Scaling.of(problem).normalise(problem),
            relative_tolerance=tolerances.relative,
            absolute_tolerance=tolerances.absolute,
        )
        return views if held[0] else np.abs(normal.w), modalities if held[1] else normal.modality_norms

    @property
    def solution(self) -> Solution:
        """The answer with a certificate of its own, made on demand; see `Answers.solution`."""
        return self.answers.solution(self.index)


@dataclass(frozen=True)
class Ranked:
    """A robot or a modality with its weight.

    Attributes
    ----------
    name : str
    weight : float
        w_i of a robot, ||u^i||_2 of a modality; infinite beyond the range of float64.
    share : float
        |weight| divided by the sum over all, whatever their size; what is proved to be 0 counts as 0, so that
        what is left of it by rounding has no share. 0 where all are 0.
    proved_zero : bool
        No optimum uses it, by proof.
    """

    name: str
    weight: float
    share: float
    proved_zero: bool


@dataclass(frozen=True, eq=False, repr=False)
class Recognition:
    """The outcome for one set of views.

    Attributes
    ----------
    verdict : Verdict
    label : str or None
        The object with the lowest optimum; None unless the verdict is `PROVED`.
    candidates : tuple of str
        The objects that may be the best, best first.
    reason : str
        Why the verdict is what it is.
    names : tuple of str
        The templates, in the order given.
    answers : Answers
        In the same order.
    views : tuple of str
        Names of the robots, in the order of the rows of X.
    warnings : tuple of str
        What a user should know before trusting the label.
    decision : Decision
        What the templates are compared by.
    """

    verdict: Verdict
    label: str | None
    candidates: tuple[str, ...]
    reason: str
    names: tuple[str, ...]
    answers: Answers
    views: tuple[str, ...]
    warnings: tuple[str, ...]
    decision: Decision = Decision.OBJECTIVE

    def __repr__(self) -> str:
        """What it says, without the arrays behind it."""
        said = f"{self.statement}, candidates {list(self.candidates)}, views {list(self.views)}"
        return f"<Recognition of {len(self.objects)} objects: {said}>"

    @property
    def statement(self) -> str:
        """The verdict with what it is about, as in "proved: lowest optimum"."""
        about = f": {PROVED_OF[self.decision]}" if self.verdict is Verdict.PROVED else ""
        return f"{self.verdict.value}{about}"

    @cached_property
    def costs(self) -> Intervals:
        """Proved bounds of what decides, the lowest being best: F*, or F* / ||o||^2."""
        return cost_bounds(self.answers, self.decision)

    @cached_property
    def unexplained(self) -> Intervals:
        """Proved bounds of F* / ||o||^2, the share of each template that the views leave unexplained."""
        return cost_bounds(self.answers, Decision.EXPLAINED_FRACTION)

    @property
    def explained(self) -> tuple[float, float]:
        """Proved bounds of 1 - F* / ||o||^2 of the best template of the first candidate, in [0, 1]."""
        lower, upper = (float(end[self.template().index]) for end in self.unexplained)
        return _complement(upper, -math.inf), _complement(lower, math.inf)

    @cached_property
    def excluded(self) -> Bool[np.ndarray, " p"]:
        """Which templates are proved not to be the best."""
        return np.asarray(self.costs[0] > self._least)

    @property
    def certified(self) -> bool:
        """Whether every template is excluded or has a certified answer."""
        return bool((self.excluded | self.answers.certified).all())

    @cached_property
    def rules(self) -> Rules:
        """What other rules say of the same views and references."""
        return Rules.of(self.answers.data, self.views, self.candidates[0])

    @property
    def objects(self) -> tuple[str, ...]:
        """The known objects, in the order of their first templates."""
        return self.answers.data.library.objects

    @property
    def templates(self) -> tuple[Template, ...]:
        """All templates, in the order given."""
        return tuple(map(self._template, range(len(self.names))))

    @property
    def best_templates(self) -> tuple[Template, ...]:
        """Of each object the template that costs least, as far as is known."""
        return tuple(map(self._template, self._best.tolist()))

    def template(self, name: str | None = None) -> Template:
        """One template by its name, or the best one of an object; without a name, of the first candidate."""
        check_type(name, (str, type(None)), "template", TemplateNameError)
        wanted, library = self.candidates[0] if name is None else name, self.answers.data.library
        if wanted in library.objects:
            shown = library.shown[self.names.index(wanted)] if name in self.names else wanted
            if shown != wanted:
                must = f"must not be the name both of an object and of a reference of {shown!r}"
                remedy = "Take it from `templates` or `best_templates`."
                raise TemplateNameError("template", value=wanted, must=must, remedy=remedy)
            return self._template(int(self._best[library.objects.index(wanted)]))
        if wanted not in self.names:
            known = [*library.objects, *self.names] if library.given_objects else list(self.names)
            raise TemplateNameError("template", value=wanted, must=f"must be one of {known}")
        return self._template(self.names.index(wanted))

    @cached_property
    def runner_up(self) -> str | None:
        """The object next to the first candidate, as far as is known; None where there is no other."""
        others = [each for each in self.best_templates if each.object != self.candidates[0]]
        return min(others, key=lambda each: each.cost[1]).object if others else None

    @cached_property
    def margin(self) -> tuple[float, float] | None:
        """Proved bounds of the relative margin max(0, 1 - c1 / c2); None where there is one object.

        c1 is what the first candidate costs, c2 the least that another object costs. With ``prune=True`` the
        other objects are bounded only as far as the label needs, and so is the margin.
        """
        library = self.answers.data.library
        return margin_of(self.costs, library.owners == library.objects.index(self.candidates[0]))

    @cached_property
    def _best(self) -> Int[np.ndarray, " objects"]:
        """Of each object the template with the lowest upper bound; the first of them."""
        library, upper = self.answers.data.library, self.costs[1]
        if library.given_objects is None:
            return library.owners
        order = np.lexsort((upper, library.owners))
        return np.asarray(order[np.unique(library.owners[order], return_index=True)[1]])

    @cached_property
    def _least(self) -> float:
        """What the best one costs at most."""
        return lowest(self.costs[1])

    def _template(self, j: int) -> Template:
        lower, upper = self.costs
        cost, shown = (float(lower[j]), float(upper[j])), self.answers.data.library.shown[j]
        return Template(self.names[j], shown, self.answers, j, cost[0] > self._least, cost)

    def ranked_views(self, name: str | None = None) -> tuple[Ranked, ...]:
        """Robots by |w_i|, largest first, for one template (default: the first candidate)."""
        template = self.template(name)
        sizes = template.proportions[0]
        return _ranked(self.views, template.w, sizes, self.answers.zero_views[template.index])

    def ranked_modalities(self, name: str | None = None) -> tuple[Ranked, ...]:
        """Modalities by ||u^i||_2, largest first, for one template (default: the first candidate)."""
        template, names = self.template(name), self.answers.data.views.modalities.names
        sizes, zeros = template.proportions[1], self.answers.zero_modalities[template.index]
        return _ranked(names, template.modality_norms, sizes, zeros)


def margin_of(costs: Intervals, own: Bool[np.ndarray, " p"]) -> tuple[float, float] | None:
    """Bound 1 - c1 / c2, c1 being the least cost among `own` and c2 the least of the others, if any."""
    if own.all():
        return None
    lower, upper = costs
    first, other = (lower[own].min(), upper[own].min()), (lower[~own].min(), upper[~own].min())
    return _beyond(float(first[1]), float(other[0]), -1.0), _beyond(float(first[0]), float(other[1]), 1.0)


def _beyond(first: float, other: float, way: float) -> float:
    """1 - first / other, rounded in a direction, in [0, 1]; what is not known is no margin."""
    if not 0.0 <= first < other:
        return 0.0
    if math.isinf(other):
        return 1.0
    return _complement(math.nextafter(first / other, -way * math.inf), way * math.inf)


def _complement(share: float, way: float) -> float:
    """1 - share, rounded in a direction, in [0, 1]."""
    return min(1.0, max(0.0, math.nextafter(1.0 - share, way)))


def _ranked(
    names: Sequence[str],
    weights: NDArray[np.float64],
    sizes: NDArray[np.float64],
    zeros: NDArray[np.bool_],
) -> tuple[Ranked, ...]:
    sizes = np.where(zeros, 0.0, sizes)
    order, shares = np.argsort(-sizes, kind="stable"), _shares(sizes)
    return tuple(Ranked(names[i], float(weights[i]), float(shares[i]), bool(zeros[i])) for i in order)


def _shares(sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each size divided by the sum of all; beside an infinite one, a finite one is nothing."""
    with np.errstate(over="ignore"):
        total = float(sizes.sum())
    if math.isinf(total):
        sizes = np.isinf(sizes).astype(np.float64) if np.isinf(sizes).any() else sizes / sizes.max()
        total = float(sizes.sum())
    return np.asarray(sizes / total) if total > 0.0 else np.zeros_like(sizes)


def cost_bounds(answers: Answers, decision: Decision) -> Intervals:
    """Bound what decides."""
    if decision is Decision.OBJECTIVE:
        return answers.lower, answers.upper
    return costs(decision, (answers.lower, answers.upper), compared_squares(answers))


def compared_squares(answers: Answers) -> Intervals:
    """Bound the ||o_j||^2; what the reduced data do not bound is computed here."""
    data = answers.data
    least, most = answers.bounds.squares
    if not data.sound.all():
        least, most = least.copy(), most.copy()
        for j in (~data.sound).nonzero()[0].tolist():
            length = euclidean_length(data.library.template(j))
            if length == 0.0 or SMALLEST_SQUARED < length < 1.0 / SMALLEST_SQUARED:
                least[j], most[j] = squared_norm(Ball.exact(data.library.template(j)))
    return least, most
