"""Which object is it: a label that is proved or not claimed, from all templates of a frame."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import NDArray

from convexperc.answers import Answers
from convexperc.arrays import FeatureVector, Vector, euclidean_length, real_array
from convexperc.certificate import ABSOLUTE, RELATIVE
from convexperc.critical import zero_is_optimal
from convexperc.decision import Decision, costs
from convexperc.enclosure import enclose, finite_start
from convexperc.errors import ProblemError
from convexperc.projection import Projection
from convexperc.race import race
from convexperc.run import Run, read_lambdas
from convexperc.solution import Solution, Status
from convexperc.solvers.interface import Solver
from convexperc.symmetry import interchangeable

NARROW = 1e-30
"""Relative width asked of overlapping intervals; what is reported is limited by float64, about 1e-16."""
SHORT, SLACK = 1e-140, 2.0**-30
"""Lengths below this, or above its inverse, are not squared; relative error charged to those that are."""
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
    """No effort could decide: interchangeable templates, or every optimum is w = u = 0."""


@dataclass(frozen=True, eq=False)
class Template:
    """One object's name and its answer.

    Attributes
    ----------
    name : str
    answers : Answers
    index : int
        Its place in `answers`.
    excluded : bool
        Proved not to be the best; it may then have been left without a certified answer.
    cost : (float, float)
        Proved bounds of what decides, the lowest being best: F*, or F* / ||o||^2.
    """

    name: str
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
        The templates that may be the best, best first.
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

    @property
    def costs(self) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
        """Proved bounds of what decides, the lowest being best: F*, or F* / ||o||^2."""
        return _costs(self.answers, self.decision)

    @property
    def excluded(self) -> Bool[np.ndarray, " p"]:
        """Which templates are proved not to be the best."""
        lower, upper = self.costs
        return np.asarray(lower > upper.min())

    @property
    def certified(self) -> bool:
        """Whether every template is excluded or has a certified answer."""
        return bool((self.excluded | self.answers.certified).all())

    @property
    def templates(self) -> tuple[Template, ...]:
        """All templates, in the order given."""
        excluded, (lower, upper) = self.excluded.tolist(), self.costs
        return tuple(
            Template(name, self.answers, j, excluded[j], (float(lower[j]), float(upper[j])))
            for j, name in enumerate(self.names)
        )

    def template(self, name: str | None = None) -> Template:
        """One template by its name; without one, the first candidate."""
        wanted = self.candidates[0] if name is None else name
        if wanted not in self.names:
            raise ProblemError("template", value=wanted, must=f"must be one of {list(self.names)}")
        return self.templates[self.names.index(wanted)]

    def ranked_views(self, name: str | None = None) -> tuple[Ranked, ...]:
        """Robots by |w_i|, largest first, for one template (default: the first candidate)."""
        template = self.template(name)
        return _ranked(self.views, template.w, self.answers.zero_views[template.index])

    def ranked_modalities(self, name: str | None = None) -> tuple[Ranked, ...]:
        """Modalities by ||u^i||_2, largest first, for one template (default: the first candidate)."""
        template = self.template(name)
        names = self.answers.projection.modalities.names
        return _ranked(names, template.modality_norms, self.answers.zero_modalities[template.index])


def _ranked(
    names: Sequence[str], weights: NDArray[np.float64], zeros: NDArray[np.bool_]
) -> tuple[Ranked, ...]:
    total = float(np.abs(weights).sum())
    order = np.argsort(-np.abs(weights), kind="stable")
    shares = np.abs(weights) / total if total > 0.0 else np.zeros_like(weights)
    return tuple(Ranked(names[i], float(weights[i]), float(shares[i]), bool(zeros[i])) for i in order)


def recognize(  # noqa: PLR0913 - each a choice of its own
    X: Any,
    references: Any,
    *,
    lambda1: Any,
    lambda2: Any,
    lambda3: Any,
    modalities: Any = None,
    names: Sequence[str] | None = None,
    views: Sequence[str] | None = None,
    solver: Solver | None = None,
    escalate: bool = True,
    prune: bool = True,
    start: Recognition | None = None,
    decision: Decision | str = Decision.OBJECTIVE,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
    progress: Callable[[str], None] | None = None,
) -> Recognition:
    """Recognise the object that n views show.

    Parameters
    ----------
    X : array_like (n, d)
        Row i is robot i's feature vector.
    references : mapping of str to array_like (d,), or array (d, p)
        Each known object's name and reference features: the columns of O. A large library is best given as
        one array, which may be memory-mapped, with `names`.
    lambda1, lambda2, lambda3 : real number
    modalities : see `Modalities.of`
    names : sequence of p str, optional
        Names of the columns of an array; ``object 1`` ... without.
    views : sequence of n str, optional
        Names of the robots; ``robot 1`` ... without.
    solver : Solver, optional
        Solve every template by this one. Without, all are solved at once, see `convexperc.race`.
    escalate : bool
        Answer by ball arithmetic where the named solver's answer is not certified, and narrow the intervals
        by it where they overlap.
    prune : bool
        Solve only the templates that lower bounds do not exclude.
    start : Recognition, optional
        That of the last frame, with as many robots, modalities and templates.
    decision : {"objective", "explained share"} or Decision
        What the templates are compared by: F*, as in the paper, or the share of ||o||^2 that is explained.
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.Certificate`.
    progress : callable, optional
        Called with each template's name when it is done.

    Returns
    -------
    Recognition

    Raises
    ------
    ProblemError, ModalityError
        See `Problem`; also no reference at all, names that do not fit, or no such decision.
    SolverError
        The named solver gave no point for a template.

    Notes
    -----
    Paper: Algorithm 1, line 9 and its return: the label is the category with the lowest objective.
    """
    if isinstance(references, Mapping):
        names, references = tuple(references), _columns(X, references)
    lambdas, rule = read_lambdas(lambda1, lambda2, lambda3), Decision.of(decision)
    projection = Projection.of(X, references, modalities)
    robots = _names(views, projection.C.shape[1], "robot", "views", "rows of X")
    objects = _names(names, projection.p, "object", "names", "columns")
    tolerances = relative_tolerance, absolute_tolerance
    run = Run.of(projection, lambdas, *tolerances, None if start is None else start.answers)
    if solver is not None:
        run.fall_back(np.arange(len(objects)), solver, escalate=escalate)
    elif prune:
        race(run, rule)
    else:
        run.finish()
    if progress is not None:
        for name in objects:
            progress(name)
    found = decide(run.answers(), objects, robots, rule)
    if escalate and found.verdict is Verdict.UNDECIDED:
        return decide(_narrowed(found), objects, robots, rule)
    return found


def _columns(X: Any, references: Mapping[str, Any]) -> Float[np.ndarray, "d p"]:
    """Each reference as a column."""
    if not references:
        raise ProblemError("references", value=references, must="must name at least one object")
    d = real_array(X, "X", 2).shape[1]
    rows = [real_array(o, f"reference {name!r}", 1) for name, o in references.items()]
    for name, row in zip(references, rows, strict=True):
        if row.size != d:
            must = f"must have one entry for each of the {d} columns of X"
            raise ProblemError(f"reference {name!r}", value=row.shape, must=must)
    return np.stack(rows).T


def _names(given: Sequence[str] | None, count: int, kind: str, field: str, what: str) -> tuple[str, ...]:
    """Return as many names, all different, or else the default ones."""
    names = tuple(f"{kind} {i}" for i in range(1, count + 1)) if given is None else tuple(given)
    if len(names) != count or len(set(names)) != count:
        raise ProblemError(field, value=names, must=f"must name each of the {count} {what} once")
    return names


def _narrowed(found: Recognition) -> Answers:
    """Rivals with the narrowest interval that ball arithmetic gives; other templates as they are."""
    lower, upper = found.answers.lower.copy(), found.answers.upper.copy()
    known: dict[bytes, tuple[float, float]] = {}
    for j in (~found.excluded).nonzero()[0].tolist():
        problem = found.answers.problem(j)
        data = problem.o.tobytes()
        if data not in known:
            start = finite_start(found.answers.w[j], found.answers.u(j))
            tight = enclose(problem, relative_tolerance=NARROW, absolute_tolerance=NARROW, start=start)
            known[data] = tight.lower, tight.upper
        lower[j], upper[j] = max(known[data][0], lower[j]), min(known[data][1], upper[j])
    return replace(found.answers, lower=lower, upper=upper)


def _costs(answers: Answers, decision: Decision) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
    """Bounds of what decides; squared lengths that the projection does not bound are computed one by one."""
    data = answers.projection
    least, most = (bound.copy() for bound in data.squares)
    if decision is Decision.EXPLAINED_SHARE:
        for j in (~data.sound).nonzero()[0].tolist():
            length = euclidean_length(data.template(j))
            if length == 0.0 or SHORT < length < 1.0 / SHORT:
                least[j], most[j] = length**2 * (1.0 - SLACK), length**2 * (1.0 + SLACK)
    return costs(decision, (answers.lower, answers.upper), (least, most))


def decide(
    answers: Answers,
    names: tuple[str, ...],
    views: tuple[str, ...],
    decision: Decision = Decision.OBJECTIVE,
) -> Recognition:
    """Draw the verdict from the intervals alone.

    Parameters
    ----------
    answers : Answers
    names, views : tuple of str
        Of the templates and of the robots.
    decision : Decision

    Returns
    -------
    Recognition
    """
    lower, upper = _costs(answers, decision)
    rivals = (lower <= upper.min()).nonzero()[0]
    rivals = rivals[np.argsort(upper[rivals], kind="stable")]
    candidates = tuple(names[j] for j in rivals)
    warnings = _norm_warning(answers, names) if decision is Decision.OBJECTIVE else ()

    def verdict(kind: Verdict, reason: str) -> Recognition:
        label = candidates[0] if kind is Verdict.PROVED else None
        return Recognition(kind, label, candidates, reason, names, answers, views, warnings, decision)

    if len(names) > 1 and _all_zero(answers):
        candidates = names
        reason = "every optimum is w = u = 0, so that F* = ||o||^2 says nothing of the views; lower lambda2"
        return verdict(Verdict.TIE, reason)
    if len(rivals) == 1:
        if decision is Decision.EXPLAINED_SHARE:
            return verdict(Verdict.PROVED, "more of it is explained than of every other one, by proof")
        return verdict(Verdict.PROVED, "its optimum lies below every other one, by proof")
    data = answers.projection
    first = data.template(int(rivals[0]))
    others = [data.template(int(j)) for j in rivals[1:]]
    ordered = tuple(names[j] for j in sorted(rivals.tolist()))
    if all(np.array_equal(first, other) for other in others):
        candidates = ordered
        return verdict(Verdict.TIE, f"the templates {', '.join(candidates)} are identical")
    if all(interchangeable(data.X, data.modalities, first, other) for other in others):
        candidates = ordered
        reason = f"the templates {', '.join(candidates)} are the same but for the order of the data"
        return verdict(Verdict.TIE, reason)
    return verdict(Verdict.UNDECIDED, f"the intervals of {', '.join(candidates)} overlap")


def _all_zero(answers: Answers) -> bool:
    """Whether w = u = 0 is proved to be an optimum for every template."""
    if (answers.upper < answers.projection.squares[0]).any():
        return False
    proved, sound = answers.projection.zero_is_optimal(answers.lambdas), answers.projection.sound
    if not proved[sound].all():
        return False
    return all(zero_is_optimal(answers.problem(int(j))) for j in (~sound).nonzero()[0])


def _norm_warning(answers: Answers, names: tuple[str, ...]) -> tuple[str, ...]:
    data = answers.projection
    norms = np.sqrt(data.squares[0])
    for j in (~data.sound).nonzero()[0].tolist():
        norms[j] = euclidean_length(data.template(j))
    short, long = int(norms.argmin()), int(norms.argmax())
    if norms[long] <= NORM_FACTOR * norms[short]:
        return ()
    return (
        f"the norms of the templates differ by more than a factor of {NORM_FACTOR}: {names[short]} has "
        f"{norms[short]:.4g}, {names[long]} has {norms[long]:.4g}. F* <= ||o||^2 favours the short one; "
        "normalise the features, or decide by the explained share.",
    )
