"""Which object is it: from the views and the templates to a label that is proved or not claimed."""

import functools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypedDict, Unpack

import numpy as np

from convexperc import recognition
from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.data_bounds import DataBounds
from convexperc.certificate.lambda_max import zero_is_optimal
from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.enclosure.budget import SECONDS, Budget
from convexperc.errors import InputError, ProblemError, RobotNameError, StartError, check_type, entries
from convexperc.problem.arrays import euclidean_length, lowest
from convexperc.problem.columns import checked_names
from convexperc.problem.penalties import Penalties
from convexperc.problem.reduced import ReducedData
from convexperc.recognition.decision import Decision
from convexperc.recognition.pruning import prune as prune_by_bounds
from convexperc.recognition.recognition import Recognition, Verdict, cost_bounds
from convexperc.recognition.ties import all_interchangeable
from convexperc.solution.answers import Answers
from convexperc.solution.batch import BatchSolver
from convexperc.solvers.interface import Solver

NORM_FACTOR = 1.1
"""Templates whose norms differ by more than this factor are warned about: F* <= ||o||^2, so a short template
wins by its length."""


class Options(TypedDict, total=False):
    """How a recognition is made; each may be left out.

    Attributes
    ----------
    decision : {"objective", "explained fraction"} or Decision
        What the templates are compared by: F*, as in the paper (the default), or the fraction of
        ||o||^2 that is explained.
    prune : bool
        Solve only the templates that lower bounds do not exclude (the default).
    solver : Solver or None
        Solve every template by this one. Without, all are solved at once; see
        `convexperc.recognition.pruning`.
    escalate : bool
        Answer by ball arithmetic where the named solver's answer is not certified, and narrow the intervals
        by it where they overlap (the default).
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.Tolerances`.
    seconds : float
        For the ball arithmetic of all templates together; see `convexperc.enclosure.budget.Budget`.
    """

    decision: Decision | str
    prune: bool
    solver: Solver | None
    escalate: bool
    relative_tolerance: float
    absolute_tolerance: float
    seconds: float


@dataclass(frozen=True)
class _Settings:
    """The options, complete and checked."""

    decision: Decision
    prune: bool
    solver: Solver | None
    escalate: bool
    tolerances: Tolerances
    seconds: float

    @classmethod
    def of(cls, function: str, options: Options) -> "_Settings":
        """Fill in what is left out; an unknown option is refused as the function would."""
        if not options:
            return DEFAULT
        for name in options:
            if name not in Options.__annotations__:
                known = ", ".join(Options.__annotations__)
                unknown = f"{function}() got an unexpected keyword argument {name!r}"
                raise TypeError(f"{unknown}; its options are {known}")
        for name in ("prune", "escalate"):
            check_type(options.get(name, True), bool, name)
        return cls(
            Decision.of(options.get("decision", Decision.OBJECTIVE)),
            options.get("prune", True),
            options.get("solver"),
            options.get("escalate", True),
            Tolerances(
                options.get("relative_tolerance", RELATIVE), options.get("absolute_tolerance", ABSOLUTE)
            ),
            Budget(options.get("seconds", SECONDS)).seconds,
        )


DEFAULT = _Settings(
    Decision.OBJECTIVE, prune=True, solver=None, escalate=True, tolerances=Tolerances(), seconds=SECONDS
)


def recognize(
    X: Any,
    references: Any,
    *,
    lambda1: Any,
    lambda2: Any,
    lambda3: Any,
    modalities: Any = None,
    names: Sequence[str] | None = None,
    views: Sequence[str] | None = None,
    start: Recognition | None = None,
    **options: Unpack[Options],
) -> Recognition:
    """Recognise the object that n views show.

    Parameters
    ----------
    X : array_like (n, d)
        Row i is robot i's feature vector.
    references : TemplateLibrary, mapping of str to array_like, or array_like (d, p)
        The known objects: each one's name and reference features, one vector or several, or the columns of
        O; see `TemplateLibrary`. A library is checked and measured once, for any number of calls; an array
        may be memory-mapped.
    lambda1, lambda2, lambda3 : real number
    modalities : see `Modalities.of`; those of the library without
    names : sequence of p str, optional
        Names of the columns of an array; ``object 1`` ... without. Give several references by a library.
    views : sequence of n str, optional
        Names of the robots; ``robot 1`` ... without.
    start : Recognition, optional
        An earlier one, with as many robots, modalities and templates. With the same `TemplateLibrary`, views
        that have not changed since are not multiplied again.
    **options
        ``decision``, ``prune``, ``solver``, ``escalate``, ``relative_tolerance``, ``absolute_tolerance``,
        ``seconds``: see `Options`.

    Returns
    -------
    Recognition

    Raises
    ------
    ProblemError, ModalityError
        See `Problem`; also no reference at all.
    TemplateNameError, RobotNameError, DecisionError, ToleranceError, BudgetError, StartError
        An argument of that name does not fit.
    InputError
        `prune` or `escalate` is neither True nor False.
    SolverError
        The named solver gave no point for a template.

    Notes
    -----
    Paper: Algorithm 1, line 9 and its return: the label is the category with the lowest objective.
    """
    settings, penalties = _Settings.of("recognize", options), Penalties(lambda1, lambda2, lambda3)
    if start is not None and not isinstance(start, Recognition):
        must = "must be an earlier Recognition"
        raise StartError(
            "start", value=type(start).__name__, must=must, remedy="Pass what recognize returned."
        )
    answers = None if start is None else start.answers
    with np.errstate(all="ignore"):  # what overflows is bounded by infinity
        bounds = _bounds(X, references, modalities, names, answers)
        return _recognised(bounds, penalties, _robots(views, bounds.data.n), settings, answers)


def recognize_each(found: Recognition) -> tuple[Recognition, ...]:
    """Recognise from each view of a recognition alone, with its library, lambdas and decision.

    Every reference has an answer; the products of views and references are those that are known already.
    """
    settings = replace(DEFAULT, decision=found.decision, prune=False)
    with np.errstate(all="ignore"):
        return tuple(
            _recognised(
                DataBounds.of(found.answers.data.alone(i)), found.answers.penalties, (name,), settings, None
            )
            for i, name in enumerate(found.views)
        )


def recognize_path(
    X: Any,
    references: Any,
    grid: Iterable[Penalties | tuple[Any, Any, Any]],
    *,
    modalities: Any = None,
    names: Sequence[str] | None = None,
    views: Sequence[str] | None = None,
    **options: Unpack[Options],
) -> Iterator[Recognition]:
    """`recognize` for each choice of the lambdas in a grid; the data are read once.

    Each recognition is that of `recognize`, to the bit: none starts from the one before.

    Parameters
    ----------
    X, references, modalities, names, views, **options
        See `recognize`.
    grid : iterable of Penalties or (lambda1, lambda2, lambda3)

    Yields
    ------
    Recognition
        In the order of the grid.

    Raises
    ------
    ProblemError, ModalityError, TemplateNameError, RobotNameError, DecisionError, ToleranceError, BudgetError
        See `recognize`.
    """
    settings = _Settings.of("recognize_path", options)
    with np.errstate(all="ignore"):
        bounds = _bounds(X, references, modalities, names)
    robots = _robots(views, bounds.data.n)
    for triple in entries(grid, "grid", ProblemError):
        with np.errstate(all="ignore"):
            found = _recognised(bounds, Penalties.of(triple), robots, settings, None)
        yield found


def _bounds(
    X: Any,
    references: Any,
    modalities: Any,
    names: Sequence[str] | None,
    start: Answers | None = None,
) -> DataBounds:
    """The data, read once, with bounds of their rounding; what an earlier answer knows is kept."""
    earlier = None if start is None else start.data
    data = ReducedData.of(X, references, modalities, names=names, earlier=earlier)
    return DataBounds.of(data)


def _recognised(
    bounds: DataBounds,
    penalties: Penalties,
    robots: tuple[str, ...],
    settings: _Settings,
    start: Answers | None,
) -> Recognition:
    """Solve as far as the label needs, or to the end, and draw the verdict."""
    budget = Budget(settings.seconds)
    batch = BatchSolver.of(bounds, penalties, settings.tolerances, start, budget)
    if settings.solver is not None:
        batch.fall_back(np.arange(bounds.data.p), settings.solver, escalate=settings.escalate)
    elif settings.prune:
        prune_by_bounds(batch, settings.decision)
    else:
        batch.finish()
    found = decide(batch.answers(), bounds.data.library.names, robots, settings.decision)
    return _narrowed(found, budget) if settings.escalate else found


def decided_by(found: Recognition, decision: Decision | str, *, seconds: float = SECONDS) -> Recognition:
    """Draw the verdict from the same answers by another decision.

    Parameters
    ----------
    found : Recognition
        Best of ``prune=False``: a template given up under one decision may be a rival under the other,
        and ball arithmetic then narrows its interval, which is slow.
    decision : {"objective", "explained fraction"} or Decision
    seconds : float
        For ball arithmetic; see `Options`.

    Returns
    -------
    Recognition
    """
    check_type(found, Recognition, "found")
    budget = Budget(seconds)
    with np.errstate(all="ignore"):
        own = decide(found.answers, found.names, found.views, found.decision).warnings
        other = _narrowed(decide(found.answers, found.names, found.views, Decision.of(decision)), budget)
    of_pictures = tuple(each for each in found.warnings if each not in own)
    return replace(other, warnings=other.warnings + of_pictures) if of_pictures else other


def _robots(given: Sequence[str] | None, n: int) -> tuple[str, ...]:
    """As many names as robots, all different, or else the default ones."""
    if given is None:
        return _numbered(n)
    return checked_names(given, n, RobotNameError, "views", "rows of X")


@functools.lru_cache(maxsize=16)
def _numbered(n: int) -> tuple[str, ...]:
    return tuple(f"robot {i}" for i in range(1, n + 1))


def _narrowed(found: Recognition, budget: Budget) -> Recognition:
    """Where intervals overlap, narrow those of the rivals by ball arithmetic until the verdict is settled."""
    if found.verdict is not Verdict.UNDECIDED or broken_assumption():
        return found
    for answers in recognition.narrowed_answers(found, budget):
        found = decide(answers, found.names, found.views, found.decision)
        if found.verdict is not Verdict.UNDECIDED:
            return found
    return replace(found, reason=f"{found.reason}; {budget.reason}") if budget.spent else found


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

    Raises
    ------
    InputError
        `answers` are no `Answers`, or `names` or `views` no tuples of as many names.
    DecisionError
        There is no such decision.
    """
    _check_names(answers, names, views)
    decision = Decision.of(decision)
    lower, upper = cost_bounds(answers, decision)
    rivals = (lower <= lowest(upper)).nonzero()[0]
    if rivals.size > 1:
        rivals = rivals[np.argsort(upper[rivals], kind="stable")]
    library = answers.data.library
    candidates = tuple(dict.fromkeys(map(library.shown.__getitem__, rivals.tolist())))
    broken = broken_assumption()
    warnings: tuple[str, ...] = (broken,) if broken else ()
    if decision is Decision.OBJECTIVE and not broken:
        warnings = _norm_warning(answers, names)
    warnings += _zero_warning(answers, views)

    def verdict(kind: Verdict, reason: str) -> Recognition:
        label = candidates[0] if kind is Verdict.PROVED else None
        return Recognition(kind, label, candidates, reason, names, answers, views, warnings, decision)

    if len(library.objects) > 1 and _all_zero(answers):
        order = library.owners[np.argsort(upper, kind="stable")].tolist()
        candidates = tuple(library.objects[owner] for owner in dict.fromkeys(order))
        reason = "every optimum is w = u = 0, so that F* = ||o||^2 says nothing of the views; lower lambda2"
        return verdict(Verdict.TIE, reason)
    if len(candidates) == 1:
        if decision is Decision.EXPLAINED_FRACTION:
            return verdict(Verdict.PROVED, "more of it is explained than of every other one, by proof")
        return verdict(Verdict.PROVED, "its optimum lies below every other one, by proof")
    first, *others = (library.template(int(j)) for j in rivals)
    ordered = sorted(rivals.tolist())
    templates = ", ".join(names[j] for j in ordered)
    tied = tuple(dict.fromkeys(library.shown[j] for j in ordered))
    views_of = answers.data.views
    if all(np.array_equal(first, other) for other in others):
        candidates = tied
        return verdict(Verdict.TIE, f"the templates {templates} are identical")
    if all_interchangeable(views_of.X, views_of.modalities, first, others):
        candidates = tied
        return verdict(Verdict.TIE, f"the templates {templates} are the same but for the order of the data")
    return verdict(Verdict.UNDECIDED, f"the intervals of {', '.join(candidates)} overlap")


def _check_names(answers: Answers, names: Any, views: Any) -> None:
    check_type(answers, Answers, "answers")
    for what, given, count in (("names", names, answers.lower.size), ("views", views, answers.data.n)):
        if not isinstance(given, tuple) or len(given) != count:
            raise InputError(what, value=given, must=f"must be a tuple of {count} names")


def _all_zero(answers: Answers) -> bool:
    """Whether w = u = 0 is proved to be an optimum for every template."""
    if np.count_nonzero(answers.upper < answers.bounds.squares[0]):
        return False  # the common case, decided at once
    proved, sound = answers.bounds.zero_is_optimal(answers.penalties), answers.data.sound
    if not proved[sound].all():
        return False
    return all(zero_is_optimal(answers.problem(int(j))) for j in (~sound).nonzero()[0])


def _zero_warning(answers: Answers, views: tuple[str, ...]) -> tuple[str, ...]:
    """Name the robots whose features are all 0."""
    X, squares = answers.data.views.X, answers.data.G.diagonal()
    if squares.all():
        return ()  # the usual case, without a look at X: a square of 0 may have underflowed
    silent = [views[i] for i in np.flatnonzero(squares == 0.0).tolist() if not X[i].any()]
    return (f"all features are 0 of {', '.join(silent)}: such a view shows nothing",) if silent else ()


def _norm_warning(answers: Answers, names: tuple[str, ...]) -> tuple[str, ...]:
    data = answers.data
    if data.sound is data.library.lengths.sound and data.library.lengths.spread <= NORM_FACTOR**2:
        return ()
    norms = np.sqrt(answers.bounds.squares[0])
    for j in (~data.sound).nonzero()[0].tolist():
        norms[j] = euclidean_length(data.library.template(j))
    short, long = int(norms.argmin()), int(norms.argmax())
    if norms[long] <= NORM_FACTOR * norms[short]:
        return ()
    return (
        f"the norms of the templates differ by more than a factor of {NORM_FACTOR}: {names[short]} has "
        f"{norms[short]:.4g}, {names[long]} has {norms[long]:.4g}. F* <= ||o||^2 favours the short one; "
        "normalise the features.",
    )
