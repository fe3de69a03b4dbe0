"""The kernel that ranks, solves and bounds, against its pieces and NumPy."""

import numpy as np
import pytest

from convexperc.certificate.cases import AnswerBounds
from convexperc.certificate.data_bounds import DataBounds, Points
from convexperc.certificate.tolerances import Tolerances
from convexperc.problem.penalties import Penalties
from convexperc.problem.reduced import ReducedData
from convexperc.solution.advancing import advance, rank
from convexperc.solution.batch import LEAST_TOLERANCE, SOLVER_PART, BatchSolver
from convexperc.solvers.newton.lapack import ARGUMENTS
from convexperc.solvers.newton.loop import NO_PRUNING, Pruning, Rules
from convexperc.solvers.newton.method import MAX_ITERATIONS, Batch, Newton
from convexperc.solvers.newton.ridge import REGULARISATION
from convexperc.solvers.newton.workspace import Grams, Rows, Templates, new_memory, workspace


def begun(n: int, p: int, seed: int = 0) -> BatchSolver:
    """p templates of which nothing is solved yet; the last two are the same."""
    rng = np.random.default_rng(seed)
    X, O = rng.random((n, 4 * n)), rng.random((4 * n, p))
    O[:, -1] = O[:, -2]
    sizes = [n, 3 * n]
    return BatchSolver.of(DataBounds.of(ReducedData.of(X, O, sizes)), Penalties(0.3, 0.1, 0.2), Tolerances())


@pytest.mark.parametrize(("n", "p"), [(1, 2), (3, 7), (6, 40), (20, 300)])
@pytest.mark.parametrize("units", ["equal", "different"])
def test_templates_are_ranked_by_what_ridge_regression_leaves(n, p, units):
    batch = begun(n, p)
    data, scale = batch.data, np.ones(p) if units == "equal" else np.ldexp(1.0, np.arange(p) % 3)
    ridge = data.G + (batch.normalised[0, 0] + REGULARISATION * n) * np.eye(n)
    left = (data.targets - np.einsum("pn,pn->p", data.C, np.linalg.solve(ridge, data.C.T).T)) * scale
    order = np.random.default_rng(1).permutation(p)
    batch.rank(order, Pruning(scale, np.inf, 0.0))
    assert np.array_equal(np.sort(order), np.arange(p))
    assert (np.diff(left[order]) > -1e-12).all(), left[order]
    assert np.isinf(batch.proved.gap).all()
    if units == "equal":
        place = order.tolist()
        assert place.index(p - 2) + 1 == place.index(p - 1), "equal templates keep their order"


def test_a_gram_matrix_that_is_not_definite_leaves_the_order_of_the_lengths():
    n, p = 3, 4
    C, targets = np.ones((p, n)), np.array([3.0, 1.0, 2.0, 1.0])
    templates, order = Templates(C, targets, np.zeros((p, 3))), np.arange(p)
    rank(-np.eye(n), templates, order, np.ones(p), new_memory(n, 1), np.empty(p))
    assert order.tolist() == [1, 3, 2, 0]


@pytest.mark.parametrize(("n", "p"), [(2, 3), (6, 8), (20, 4)])
def test_one_call_gives_the_bits_of_solving_and_then_bounding(n, p):
    batch = begun(n, p)
    data, tolerances = batch.data, batch.tolerances
    batch.advance(np.arange(p))
    solver = Newton(max(SOLVER_PART * tolerances.relative, LEAST_TOLERANCE), MAX_ITERATIONS)
    solved = solver.batch(data.G, data.K, data.C, data.targets, batch.normalised)
    bounded = batch.bounds.of_points(
        np.arange(p), batch.normalised, Points(solved.W, solved.T, solved.Q),
        AnswerBounds.unknown(p, n, data.m), tolerances=tolerances, uncoupled=False,
    )  # fmt: skip
    for one, two in zip(vars(batch.reduced).values(), vars(solved).values(), strict=True):
        assert one.tobytes() == two.tobytes()
    for one, two in zip(batch.proved, bounded, strict=True):
        assert one.tobytes() == two.tobytes()


@pytest.mark.parametrize("content", [0.0, np.nan, -1e300])
def test_what_the_memory_held_before_has_no_effect(content):
    n, p = 6, 8
    found = []
    for number in (0.0, content):
        batch = begun(n, p)
        data, memory = batch.data, new_memory(n, batch.data.m)
        memory.numbers.fill(number)
        answers, bounds = Batch.new(p, n, data.m), AnswerBounds.unknown(p, n, data.m)
        advance(
            Grams.of(data.G, data.K), Templates(data.C, data.targets, batch.normalised), batch.normalised,
            np.arange(p), False, Rules(1e-11, 80, False), NO_PRUNING, memory, Rows(*vars(answers).values()),
            batch.bounds.shared, 1e-9, bounds,
        )  # fmt: skip
        found.append(b"".join(part.tobytes() for part in (*vars(answers).values(), *bounds)))
    assert found[0] == found[1]


def test_without_units_nothing_is_ranked():
    with pytest.raises(ValueError, match="ranked in the units"):
        begun(2, 3).advance(np.arange(3), ranked=True)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (6, 3), (40, 2)])
def test_a_workspace_takes_all_of_its_memory_and_no_more(n, m):
    memory = new_memory(n, m)
    room = workspace(memory, n, m)
    parts = room.points, room.matrices, room.vectors, room.sets, room.counts
    assert memory.numbers.size == ARGUMENTS + sum(part.size for part in parts)
