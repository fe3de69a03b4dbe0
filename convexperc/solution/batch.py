"""All templates of one frame at once, for one choice of the lambdas or for many."""

from collections.abc import Iterable, Iterator
from typing import Any

from convexperc.certificate.certificate import ABSOLUTE, RELATIVE
from convexperc.problem.library import Projection
from convexperc.solution.answers import Answers
from convexperc.solution.run import Run, read_lambdas


def solve_many(
    X: Any,
    O: Any,  # noqa: E741 - the paper's symbol
    *,
    lambda1: Any,
    lambda2: Any,
    lambda3: Any,
    modalities: Any = None,
    start: Answers | None = None,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
) -> Answers:
    """Minimise F for every template of a library, and prove how well.

    Parameters
    ----------
    X : array_like (n, d)
        Row i is robot i's feature vector.
    O : array_like (d, p)
        Column j is template j's reference features. It is read block by block and not copied: it may be
        memory-mapped.
    lambda1, lambda2, lambda3 : real number
    modalities : see `Modalities.of`
    start : Answers, optional
        Earlier answers to as many templates, robots and modalities: of the last frame, or other lambdas.
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.certificate.Certificate`.

    Returns
    -------
    Answers

    Raises
    ------
    ProblemError, ModalityError
        As `Problem` on X and each column of O.
    """
    projection = Projection.of(X, O, modalities)
    lambdas = read_lambdas(lambda1, lambda2, lambda3)
    run = Run.of(projection, lambdas, relative_tolerance, absolute_tolerance, start)
    run.finish()
    return run.answers()


def solve_path(
    X: Any,
    O: Any,  # noqa: E741 - the paper's symbol
    grid: Iterable[tuple[Any, Any, Any]],
    *,
    modalities: Any = None,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
) -> Iterator[Answers]:
    """`solve_many` for each (lambda1, lambda2, lambda3) of a grid; the data are read once.

    Each answer starts the next, so an order in which neighbours follow each other is the fastest.

    Yields
    ------
    Answers
        In the order of the grid.
    """
    projection = Projection.of(X, O, modalities)
    last = None
    for triple in grid:
        run = Run.of(projection, read_lambdas(*triple), relative_tolerance, absolute_tolerance, last)
        run.finish()
        last = run.answers()
        yield last
