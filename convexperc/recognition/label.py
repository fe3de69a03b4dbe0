"""Which object is it: from the views and the templates to a label that is proved or not claimed."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from convexperc.certificate.certificate import ABSOLUTE, RELATIVE
from convexperc.certificate.lambda_max import zero_is_optimal
from convexperc.enclosure.enclosure import enclose, finite_start
from convexperc.errors import ProblemError
from convexperc.problem.arrays import euclidean_length, real_array
from convexperc.problem.library import Projection
from convexperc.recognition.decision import Decision
from convexperc.recognition.pruning import race
from convexperc.recognition.recognition import Recognition, Verdict, cost_bounds
from convexperc.recognition.ties import interchangeable
from convexperc.solution.answers import Answers
from convexperc.solution.run import Run, read_lambdas
from convexperc.solvers.interface import Solver

NARROW = 1e-30
"""Relative width asked of overlapping intervals; what is reported is limited by float64, about 1e-16."""
NORM_FACTOR = 1.1
"""Templates whose norms differ by more than this factor are warned about: F* <= ||o||^2, so a short template
wins by its length."""


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
        Solve every template by this one. Without, all are solved at once, see `convexperc.recognition.pruning`.
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
        See `convexperc.certificate.certificate.Certificate`.
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
    lambdas, rule = read_lambdas(lambda1, lambda2, lambda3), Decision.of(decision)
    projection, objects, robots = _read(X, references, modalities, names, views)
    tolerances = relative_tolerance, absolute_tolerance
    run = Run.of(projection, lambdas, *tolerances, None if start is None else start.answers)
    if solver is not None:
        run.fall_back(np.arange(len(objects)), solver, escalate=escalate)
    else:
        _solve(run, rule, prune=prune)
    if progress is not None:
        for name in objects:
            progress(name)
    return _decided(run, objects, robots, rule, escalate=escalate)


def recognize_path(
    X: Any,
    references: Any,
    grid: Iterable[tuple[Any, Any, Any]],
    *,
    modalities: Any = None,
    names: Sequence[str] | None = None,
    views: Sequence[str] | None = None,
    prune: bool = True,
    decision: Decision | str = Decision.OBJECTIVE,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
) -> Iterator[Recognition]:
    """`recognize` for each (lambda1, lambda2, lambda3) of a grid; the data are read once.

    Each recognition is that of `recognize`, to the bit: none starts from the one before.

    Yields
    ------
    Recognition
        In the order of the grid.

    Raises
    ------
    ProblemError, ModalityError
        See `recognize`.
    """
    rule = Decision.of(decision)
    projection, objects, robots = _read(X, references, modalities, names, views)
    for triple in grid:
        run = Run.of(projection, read_lambdas(*triple), relative_tolerance, absolute_tolerance)
        _solve(run, rule, prune=prune)
        yield _decided(run, objects, robots, rule, escalate=True)


def _read(
    X: Any, references: Any, modalities: Any, names: Sequence[str] | None, views: Sequence[str] | None
) -> tuple[Projection, tuple[str, ...], tuple[str, ...]]:
    """The frame, the names of its templates, and those of its robots."""
    if isinstance(references, Mapping):
        names, references = tuple(references), _columns(X, references)
    projection = Projection.of(X, references, modalities)
    robots = _names(views, projection.C.shape[1], "robot", "views", "rows of X")
    return projection, _names(names, projection.p, "object", "names", "columns"), robots


def _solve(run: Run, rule: Decision, *, prune: bool) -> None:
    """Every template to the end, or only as far as the label needs."""
    if prune:
        race(run, rule)
    else:
        run.finish()


def _decided(
    run: Run, names: tuple[str, ...], views: tuple[str, ...], rule: Decision, *, escalate: bool
) -> Recognition:
    """The verdict on what is known; where intervals overlap, ball arithmetic narrows them."""
    found = decide(run.answers(), names, views, rule)
    return _narrowed(found) if escalate else found


def decided_by(found: Recognition, decision: Decision | str) -> Recognition:
    """Draw the verdict from the same answers by another decision.

    Parameters
    ----------
    found : Recognition
        Best of ``prune=False``: a template given up under one decision may be a rival under the other,
        and ball arithmetic then narrows its interval, which is slow.
    decision : {"objective", "explained share"} or Decision

    Returns
    -------
    Recognition
    """
    return _narrowed(decide(found.answers, found.names, found.views, Decision.of(decision)))


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


def _narrowed(found: Recognition) -> Recognition:
    """Where intervals overlap, give the rivals the narrowest that ball arithmetic gives, and decide again."""
    if found.verdict is not Verdict.UNDECIDED:
        return found
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
    answers = replace(found.answers, lower=lower, upper=upper)
    return decide(answers, found.names, found.views, found.decision)


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
    lower, upper = cost_bounds(answers, decision)
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
        "normalise the features.",
    )
