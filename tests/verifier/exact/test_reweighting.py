"""The general update in exact numbers: against NumPy, what is held, and what has no solution."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flint import arb, fmpq

from verification.exact.balls import UnresolvedError, precision
from verification.exact.reweighting import (
    SingularStepError,
    Square,
    System,
    UndefinedUpdateError,
    WeightedSquares,
)


def square(matrix: Any, constant: Any) -> Square:
    rows = [{k: fmpq(int(a)) for k, a in enumerate(row) if a} for row in matrix]
    return list(zip(rows, (fmpq(int(b)) for b in constant), strict=True))


def equations(matrix: list[list[int]], right: list[int]) -> System:
    entries = [[fmpq(a) for a in row] for row in matrix]
    return System(entries, [fmpq(-b) for b in right], [], [fmpq(0)] * len(right))


@pytest.mark.parametrize("balls", [False, True])
def test_an_update_is_the_weighted_least_squares_of_its_block(balls: bool) -> None:
    random = np.random.default_rng(3)
    for _ in range(20):
        shapes = [(4, 6), (3, 6), (1, 6), (2, 6)]
        A = [random.integers(-3, 4, shape) for shape in shapes]
        b = [random.integers(-3, 4, shape[0]) for shape in shapes]
        k, weights, point = 3, [fmpq(2), fmpq(1, 5)], random.integers(-2, 3, 6)
        given = [square(*each) for each in zip(A, b, strict=True)]
        squares = WeightedSquares(6, [(fmpq(1), given[0]), (fmpq(k), given[1])], given[2:])
        block, others = [0, 2, 5], [1, 3, 4]
        with precision(256):
            number = arb if balls else fmpq
            system = squares.system(block, [number(int(x)) for x in point], weights)
            found = [float(arb(x).mid()) for x in system.solved("z")]
        roots = np.sqrt(np.repeat([1, k, 2, 0.2], [shape[0] for shape in shapes]))[:, None]
        rows = roots * np.vstack(A)
        right = -rows[:, others] @ point[others] - roots[:, 0] * np.concatenate(b)
        np.testing.assert_allclose(found, np.linalg.lstsq(rows[:, block], right)[0], rtol=1e-9, atol=1e-12)


def test_what_is_held_keeps_its_value_and_the_rest_is_the_best_beside_it() -> None:
    # z0 + 2 z1 is held at 5 from (1, 2, 0): of ||z||^2 + (z2 - 3)^2 there (1, 2) is the least, and z2 = 3/2
    squares = WeightedSquares(
        3, [(fmpq(1), square(np.eye(3), [0, 0, 0])), (fmpq(1), square([[0, 0, 1]], [-3]))],
        [square([[1, 2, 0]], [-5])],
    )  # fmt: skip
    for point in ([1, 2, 0], [5, 0, 7]):
        found = squares.system([0, 1, 2], [fmpq(x) for x in point], [None]).solved("z")
        assert found == [1, 2, fmpq(3, 2)], point


def test_of_a_ball_around_zero_nothing_is_lost() -> None:
    squares = WeightedSquares(2, [(fmpq(1), square([[1, 1]], [0]))], [square([[1, 2]], [0])])
    around = arb(0, 1)
    fixed = squares.system([0], [fmpq(0), around], [fmpq(0)]).solved("z")[0]
    weighted = squares.system([0], [fmpq(0), around], [fmpq(1)]).solved("z")[0]  # z = -(x + 2 x)/2
    for found, ends in ((fixed, (-1, 1)), (weighted, (fmpq(-3, 2), fmpq(3, 2)))):
        assert all(found.contains(arb(end)) for end in ends), found


def test_a_singular_system_is_an_error_or_leaves_what_is_free_as_it_is() -> None:
    solvable, unsolvable = equations([[1, 1], [1, 1]], [2, 2]), equations([[1, 1], [1, 1]], [2, 3])
    assert solvable.solved("z") == [2, 0]
    assert replace(solvable, point=[fmpq(9), fmpq(5)]).solved("z") == [-3, 5]
    root = arb(5).sqrt()
    first, second = replace(solvable, point=[fmpq(9), root]).solved("z")
    assert (first - 2 + root).contains(0)
    assert (second - root).contains(0)
    held = System([[fmpq(0)] * 2] * 2, [fmpq(0)] * 2, [[fmpq(1), fmpq(2)]], [fmpq(7), fmpq(3)])
    assert held.solved("z") == [7, 3]
    with pytest.raises(UndefinedUpdateError, match="the update of z must have a solution"):
        unsolvable.solved("z")
    in_balls = replace(solvable, linear=[arb(-2), arb(-2)])
    for system in (solvable, in_balls):
        with pytest.raises(SingularStepError, match="must have full rank 2; got 'rank 1'") as caught:
            system.solved("z", unique=True)
        assert (caught.value.system, caught.value.order, caught.value.rank) == ("z", 2, 1)


def test_balls_that_hold_a_singular_matrix_are_not_resolved() -> None:
    system = System([[arb(0, 1)]], [fmpq(1)], [], [fmpq(0)])
    with pytest.raises(UnresolvedError, match="invertible throughout"):
        system.solved("z")
