"""All templates at once: the same answers as one by one, whatever the scale, the block or the order."""

import pickle
from fractions import Fraction

import numpy as np
import pytest

import convexperc.problem.library
from convexperc import Problem, recognize, solve, solve_many, solve_path
from convexperc.certificate.certificate import certify
from convexperc.certificate.data_bounds import DataBounds
from convexperc.certificate.rounding import gamma
from convexperc.errors import ModalityError, ProblemError
from convexperc.problem.reduced import ReducedData
from convexperc.recognition.recognition import Verdict
from convexperc.recognition.ties import interchangeable
from convexperc.solution.solution import Status
from verification.problems.families import EXTREME, ORDINARY_DEGENERATE, RANDOM, seeded

LAMBDAS = {"lambda1": 0.3, "lambda2": 0.2, "lambda3": 0.1}
SIZES = [5, 9, 6]


def library(p: int = 40, n: int = 4, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    X = rng.random((n, 20))
    return X, X.T @ rng.dirichlet(np.ones(n), p).T + 0.2 * rng.random((20, p))


def problem(X, o, modalities=SIZES, **lambdas) -> Problem:
    return Problem(X, o, modalities=modalities, **{**LAMBDAS, **lambdas})


def agrees(found, j, alone) -> bool:
    """Whether two proved intervals, and what is proved zero, can both be true."""
    proof = alone.certificate
    return found.lower[j] <= proof.upper and proof.lower <= found.upper[j] and found.gap[j] >= 0


@pytest.mark.parametrize("family", sorted({*RANDOM, *ORDINARY_DEGENERATE, *EXTREME}))
def test_every_family_is_answered_as_by_solve(family):
    for index in range(3):
        one = seeded(family, 4, index)
        two = seeded(family, 5, index).o
        places = (0, 1, 0) if index == 0 else (0, 1)  # a template twice, once in each family
        O = np.stack([one.o, np.resize(two, one.d)], axis=1)[:, places]
        answers = [solve(one.for_template(o)) for o in O.T[:2]]
        names = dict(zip(LAMBDAS, one.lambdas, strict=True))
        found = solve_many(one.X, O, modalities=one.modalities, **names)
        for j, place in enumerate(places):
            alone = answers[place]
            assert agrees(found, j, alone), (family, index, j, found.lower[j], found.upper[j], alone)
            assert found.status(j) is not Status.NOT_CERTIFIED, (family, index, j)
            again = certify(alone.problem, found.w[j], found.u(j))
            assert again.objective[0] <= found.upper[j] or found.status(j) is Status.ENCLOSED, (again, j)
            assert not (found.zero_views[j] & (np.abs(alone.w) > 1e-3 * np.abs(alone.w).max())).any()


def test_a_solution_is_made_on_demand_with_a_certificate_of_its_own():
    X, O = library()
    found = solve_many(X, O, modalities=SIZES, **LAMBDAS)
    for j in (0, 7, 39):
        alone = found.solution(j)
        assert alone.status is Status.CERTIFIED
        assert np.array_equal(alone.problem.o, O[:, j])
        assert alone.w == pytest.approx(found.w[j], abs=1e-15)
        assert alone.modality_norms == pytest.approx(found.modality_norms[j], rel=1e-9, abs=1e-12)
        assert found.lower[j] <= alone.certificate.objective[1] <= found.upper[j] * (1 + 1e-12)


@pytest.mark.parametrize("scale", [1e-150, 1e-40, 1e-8, 1e8, 1e40, 1e150])
def test_the_scale_of_views_and_templates_does_not_matter(scale):
    X, O = library(6)
    base = solve_many(X, O, modalities=SIZES, **LAMBDAS)
    lambdas = {"lambda1": 0.3, "lambda2": 0.2 * scale, "lambda3": 0.1 * scale}
    found = solve_many(X, scale * O, modalities=SIZES, **lambdas)
    assert found.certified.all(), found.status(0)
    assert found.w / scale == pytest.approx(base.w, rel=1e-3, abs=1e-6)


def test_templates_of_all_scales_in_one_library():
    X, O = library(5)
    O = O * np.array([1e-170, 1e-12, 1.0, 1e12, 1e150])
    O[:, 2] = 0.0
    found = solve_many(X, O, modalities=SIZES, **LAMBDAS)
    assert found.certified.all()
    assert set(found.singles) >= {0, 2, 4}, found.singles
    assert found.upper[2] == 0.0


@pytest.mark.parametrize("block", [1, 60, 2**19])
@pytest.mark.parametrize("order", ["C", "F"])
def test_blocks_memory_maps_and_layouts_change_nothing_but_rounding(tmp_path, monkeypatch, block, order):
    X, O = library()
    base = solve_many(X, O, modalities=SIZES, **LAMBDAS)
    monkeypatch.setattr(convexperc.problem.library, "BLOCK", block)
    stored = np.lib.format.open_memmap(
        tmp_path / "library.npy", mode="w+", dtype=np.float64, shape=O.shape, fortran_order=order == "F"
    )
    stored[:] = O
    stored.flush()
    mapped = np.load(tmp_path / "library.npy", mmap_mode="r")
    found = solve_many(X, mapped, modalities=SIZES, **LAMBDAS)
    assert isinstance(found.data.library.O, np.memmap)
    assert (found.lower <= base.upper).all()
    assert (base.lower <= found.upper).all()
    assert found.certified.all()


def test_a_warm_start_needs_no_step_and_a_path_few():
    X, O = library()
    cold = solve_many(X, O, modalities=SIZES, **LAMBDAS)
    warm = solve_many(X, O, modalities=SIZES, start=cold, **LAMBDAS)
    assert warm.certified.all()
    assert warm.iterations.sum() <= 0.1 * cold.iterations.sum(), (warm.iterations, cold.iterations)
    grid = [(0.3, 0.2 * 1.05**k, 0.1 * 1.05**k) for k in range(6)]
    path = list(solve_path(X, O, grid, modalities=SIZES))
    assert [found.lambdas for found in path] == grid
    apart = [solve_many(X, O, modalities=SIZES, lambda1=a, lambda2=b, lambda3=c) for a, b, c in grid]
    for one, other in zip(path, apart, strict=True):
        assert one.certified.all()
        assert (one.lower <= other.upper).all()
        assert (other.lower <= one.upper).all()
    steps = sum(found.iterations.sum() for found in path[1:])
    assert steps < sum(found.iterations.sum() for found in apart[1:]), steps


@pytest.mark.parametrize(
    "lambdas", [(0, 0.2, 0.1), (0.3, 0, 0.1), (0.3, 0.2, 0), (0.3, 0, 0), (0, 0, 0), (1e-40, 1, 1)]
)
def test_lambdas_of_zero_are_answered_too(lambdas):
    X, O = library(4)
    names = dict(zip(LAMBDAS, lambdas, strict=True))
    found = solve_many(X, O, modalities=SIZES, **names)
    assert found.certified.all()
    for j in range(4):
        assert agrees(found, j, solve(problem(X, O[:, j], **names))), (j, found.lower[j], found.upper[j])


def test_answers_are_frozen_and_pickle():
    X, O = library(5)
    found = pickle.loads(pickle.dumps(solve_many(X, O, modalities=SIZES, **LAMBDAS)))
    assert found.certified.all()
    with pytest.raises(ValueError, match="read-only"):
        found.lower[0] = 0.0
    with pytest.raises(AttributeError):
        found.lower = found.upper
    assert found.stages.total > 0.0
    assert found.solution(3).status is Status.CERTIFIED


@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"O": np.zeros((19, 3))}, ProblemError, "20 rows"),
        ({"O": np.zeros((20, 0))}, ProblemError, "at least one column"),
        ({"O": np.zeros(20)}, ProblemError, "2 dimension"),
        ({"O": np.where(np.arange(60).reshape(20, 3) == 31, np.nan, 1.0)}, ProblemError, r"O\[:, 1\]\[10\]"),
        ({"O": np.full((20, 2), "a")}, ProblemError, "real numbers"),
        ({"X": np.full((4, 20), np.nan)}, ProblemError, "finite"),
        ({"X": np.zeros((0, 20))}, ProblemError, "at least one row"),
        ({"modalities": [3, 4]}, ModalityError, "20 columns"),
        ({"lambda3": -1}, ProblemError, "lambda3"),
        ({"relative_tolerance": np.nan}, ValueError, "relative_tolerance"),
    ],
)  # fmt: skip
def test_bad_input_is_named(changes, error, text):
    X, O = library(3)
    arguments = {"X": X, "O": O, "modalities": SIZES, **LAMBDAS, **changes}
    with pytest.raises(error, match=text):
        solve_many(arguments.pop("X"), arguments.pop("O"), **arguments)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("p", [3, 40, 600])
def test_pruning_changes_neither_label_nor_truth(p, seed):
    X, O = library(p, 3, seed)
    whole = recognize(X, O, modalities=SIZES, prune=False, **LAMBDAS)
    quick = recognize(X, O, modalities=SIZES, **LAMBDAS)
    assert (quick.verdict, quick.label) == (whole.verdict, whole.label)
    assert whole.answers.certified.all()
    assert (quick.answers.lower <= whole.answers.upper).all()
    assert (whole.answers.lower <= quick.answers.upper).all()
    assert quick.certified
    if p == 600:
        assert quick.answers.certified.mean() < 0.5, quick.answers.certified.sum()
    again = recognize(X, O, modalities=SIZES, start=quick, **LAMBDAS)
    assert (again.verdict, again.label) == (whole.verdict, whole.label)


def test_permuted_templates_tie():
    X = np.array([[1.0, 1.0, 0.3, 0.7], [0.5, 0.5, 0.9, 0.1]])
    templates = {"a": [1.0, 2.0, 0.5, 0.5], "b": [2.0, 1.0, 0.5, 0.5], "c": [9.0, 9.0, 9.0, 9.0]}
    found = recognize(X, templates, modalities=[2, 2], lambda1=1, lambda2=0.1, lambda3=0.1)
    assert (found.verdict, set(found.candidates)) == (Verdict.TIE, {"a", "b"})
    assert "order of the data" in found.reason, found.reason


def test_interchangeable_means_a_permutation_of_the_whole_problem():
    X = np.array([[1.0, 2.0, 3.0, 4.0], [3.0, 4.0, 1.0, 2.0]])
    two = problem(X, X[0], [2, 2]).modalities
    one = problem(X, X[0], [4]).modalities
    first, second = np.array([5.0, 6.0, 7.0, 8.0]), np.array([7.0, 8.0, 5.0, 6.0])
    assert interchangeable(X, two, first, second), "rows and modalities swapped together"
    assert interchangeable(X, one, first, second)
    assert not interchangeable(X, two, first, second[::-1].copy())
    assert not interchangeable(X[:1], two, first, second)
    assert not interchangeable(X, problem(X, X[0], [1, 3]).modalities, first, second)


@pytest.mark.parametrize("order", ["C", "F"])
def test_long_sums_keep_within_the_roundings_that_they_are_charged_with(order):
    d = 300_000
    o = np.full(d, 2.0**-27)
    o[0] = 1.0
    X = np.asarray(np.stack([o, o[::-1]]))
    found = DataBounds.of(ReducedData.of(X, np.asarray(np.stack([o, 2.0 * o]).T, order=order), [1, d - 1]))
    reduction = found.data.views.reduction
    depth = reduction.depth
    assert depth < d / 50
    exact = 1 + (d - 1) * Fraction(1, 2**54)
    for value, scale in ((found.squares, 1), (reduction.G[0], 1)):
        middle = value[0][0] if isinstance(value, tuple) else value[0]
        assert abs(Fraction(float(middle)) / exact - 1) <= 2 * Fraction(gamma(depth + 200)), (middle, scale)
    assert Fraction(float(found.squares[0][0])) <= exact <= Fraction(float(found.squares[1][0]))
    assert Fraction(float(found.squares[0][1])) <= 4 * exact <= Fraction(float(found.squares[1][1]))
