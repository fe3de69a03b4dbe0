"""The template library, checked and measured once for many sets of views; the lambdas; the tolerances."""

import gc
import pickle
import tracemalloc
import weakref

import numpy as np
import pytest

from convexperc import (
    Penalties,
    Problem,
    TemplateLibrary,
    Tolerances,
    recognize,
    recognize_path,
    solve,
    solve_many,
    solve_path,
)
from convexperc.certificate.data_bounds import DataBounds
from convexperc.errors import (
    ModalityError,
    ProblemError,
    StartError,
    TemplateNameError,
    ToleranceError,
)
from convexperc.problem import library as module
from convexperc.problem.reduced import ReducedData
from convexperc.problem.reduction import Reduction
from convexperc.solution.batch import BatchSolver
from convexperc.solution.solution import Status

LAMBDAS = {"lambda1": 0.3, "lambda2": 0.2, "lambda3": 0.1}
SIZES = {"color": 5, "hog": 9, "lbp": 6}
GRID = [(0.3, 0.2, 0.1), Penalties(0.1, 0.4, 0.1)]


def data(p=12, n=4, seed=0):
    rng = np.random.default_rng(seed)
    X = rng.random((n, 20))
    return X, X.T @ rng.dirichlet(np.ones(n), p).T + 0.1 * rng.random((20, p))


def same(first, second):
    """Whether two answers are equal to the bit."""
    parts = ("w", "lower", "upper", "gap", "modality_norms", "zero_views", "zero_modalities")
    return all(np.array_equal(getattr(first, part), getattr(second, part)) for part in parts)


def test_a_library_gives_the_answers_of_its_array_to_the_bit():
    X, O = data()
    names = [f"object {i}" for i in range(1, 13)]
    known = TemplateLibrary.of(O, modalities=SIZES)
    for views in (X, 1.5 * X[::-1]):
        assert same(solve_many(views, known, **LAMBDAS), solve_many(views, O, modalities=SIZES, **LAMBDAS))
        one = recognize(views, known, **LAMBDAS)
        other = recognize(views, O, modalities=SIZES, **LAMBDAS)
        assert (one.label, one.verdict, list(one.names)) == (other.label, other.verdict, names)
        assert same(one.answers, other.answers)
    for one, other in zip(solve_path(X, known, GRID), solve_path(X, O, GRID, modalities=SIZES), strict=True):
        assert same(one, other)
    pairs = zip(recognize_path(X, known, GRID), recognize_path(X, O, GRID, modalities=SIZES), strict=True)
    assert all(same(one.answers, other.answers) for one, other in pairs)


@pytest.mark.parametrize("mapped", [False, True])
def test_the_templates_are_measured_once(mapped, monkeypatch, tmp_path):
    X, O = data()
    if mapped:
        np.save(tmp_path / "O.npy", O)
        O = np.load(tmp_path / "O.npy", mmap_mode="r")
    seen = []
    real = module.squared_lengths
    for place in (module, __import__("convexperc.problem.reduced").problem.reduced):
        monkeypatch.setattr(place, "squared_lengths", lambda *a: seen.append(a[1]) or real(*a))
    known = TemplateLibrary.of(O, modalities=SIZES)
    assert np.shares_memory(known.O, O) == mapped, "what could be written is copied"
    assert not known.measured
    for _ in range(3):
        recognize(X, known, **LAMBDAS)
    assert known.measured
    assert seen == [0], seen


def test_a_mapping_is_a_library_with_its_names():
    X, O = data(3)
    objects = dict(zip(("cat", "car", "dog"), O.T, strict=True))
    known = TemplateLibrary.of(objects, modalities=SIZES)
    assert known.names == ("cat", "car", "dog")
    assert len(known) == 3
    assert np.array_equal(known.template(1), objects["car"])
    assert repr(known) == "TemplateLibrary(p=3, d=20, modalities={'color': 5, 'hog': 9, 'lbp': 6})"
    found = recognize(X, known, **LAMBDAS)
    assert found.names == known.names
    again = pickle.loads(pickle.dumps(known))
    assert recognize(X, again, **LAMBDAS).label == found.label


@pytest.mark.parametrize(
    ("templates", "options", "error", "text"),
    [
        (np.zeros((0, 3)), {}, ProblemError, "at least one row"),
        (np.zeros((3, 0)), {}, ProblemError, "at least one column"),
        (np.zeros(3), {}, ProblemError, "2 dimension"),
        (np.zeros((3, 2), complex), {}, ProblemError, "real numbers"),
        ({}, {}, ProblemError, "at least one object"),
        ({"a": [1.0, 2.0], "b": [1.0]}, {}, ProblemError, "2 entries that reference 'a' has"),
        ({"a": [1.0, 2.0]}, {"names": ["b"]}, TemplateNameError, "mapping, or be its keys"),
        (np.eye(3), {"names": ["a", "b"]}, TemplateNameError, "each of the 3 templates once"),
        (np.eye(3), {"names": ["a", "a", "b"]}, TemplateNameError, "once"),
        (np.eye(3), {"names": "abc"}, TemplateNameError, "by strings"),
        (np.eye(3), {"names": ["a", "", "b"]}, TemplateNameError, "not empty"),
        ({1: [1.0, 2.0]}, {}, TemplateNameError, "by strings"),
        (np.ma.masked_greater(np.eye(3), 0.5), {}, ProblemError, "a mask that hides 3 entries"),
        (np.eye(3), {"modalities": [2, 2]}, ModalityError, "sum to the 3 columns"),
    ],
)
def test_what_is_no_library_is_refused(templates, options, error, text):
    for make in (TemplateLibrary, TemplateLibrary.of):
        with pytest.raises(error, match=text):
            make(templates, **options)


def test_a_library_keeps_its_names_and_modalities():
    X, O = data(3)
    known = TemplateLibrary.of(O, names=("a", "b", "c"), modalities=SIZES)
    assert recognize(X, known, modalities=[5, 9, 6], names=["a", "b", "c"], **LAMBDAS).label is not None
    for other in ([10, 10], {"colour": 5, "hog": 9, "lbp": 6}):
        with pytest.raises(ModalityError, match="must be those of the library"):
            recognize(X, known, modalities=other, **LAMBDAS)
    with pytest.raises(TemplateNameError, match="the library has names"):
        recognize(X, known, names=["x", "y", "z"], **LAMBDAS)
    with pytest.raises(ProblemError, match="X must have 20 columns"):
        recognize(X[:, :7], known, **LAMBDAS)


def test_a_number_that_is_not_finite_is_found_by_the_first_pass():
    X, O = data(3)
    O[4, 1] = np.nan
    known = TemplateLibrary.of(O, modalities=SIZES)
    for _ in range(2):
        with pytest.raises(ProblemError, match=r"O\[:, 1\]\[4\] must be finite"):
            solve_many(X, known, **LAMBDAS)
    with pytest.raises(ProblemError, match=r"O\[:, 1\]\[4\] must be finite"):
        _ = known.lengths


def test_penalties_are_three_numbers():
    assert tuple(Penalties.of((1, 0, np.float32(0.5)))) == (1.0, 0.0, 0.5)
    assert Penalties.of(Penalties(1, 2, 3)) == Penalties(1.0, 2.0, 3.0)
    assert Penalties(0, 1, 1).uncoupled
    assert Penalties(1, 1, 0).uncoupled
    assert not Penalties(1, 0, 1).uncoupled
    for bad, text in (((1, 2), "three numbers"), (3.0, "three numbers"), ((1, -1, 1), "lambda2 must be")):
        with pytest.raises(ProblemError, match=text):
            Penalties.of(bad)


def test_the_tolerances_are_one_rule():
    rule = Tolerances(1e-3, 1e-6)
    assert rule.met(1e-3, 1.0, 0.0)
    assert not rule.met(1.1e-3, 1.0, 1.0)
    assert rule.met(1e-6, 0.0, 1.0)
    assert not rule.met(np.nan, 1.0, 1.0)
    assert rule.met(np.array([0.0, 2e-3]), np.ones(2), np.ones(2)).tolist() == [True, False]
    assert rule.met_by_shares(1e-3, np.inf)
    assert not rule.met_by_shares(np.nan, np.nan)
    X, O = data(3)
    problem = Problem(X, O[:, 0], modalities=SIZES, **LAMBDAS)
    for bad in (-1.0, np.inf, np.nan):
        for call in (
            lambda tolerance: Tolerances(relative=tolerance),
            lambda tolerance: solve(problem, relative_tolerance=tolerance),
            lambda tolerance: solve_many(X, O, modalities=SIZES, absolute_tolerance=tolerance, **LAMBDAS),
            lambda tolerance: recognize(X, O, modalities=SIZES, relative_tolerance=tolerance, **LAMBDAS),
        ):
            with pytest.raises(ToleranceError, match="_tolerance must be a finite real number >= 0"):
                call(bad)


def test_a_start_of_another_size_is_refused():
    X, O = data(3)
    start = solve_many(X, O[:, :2], modalities=SIZES, **LAMBDAS)
    with pytest.raises(StartError, match=r"start must be answers of \(p, n\)"):
        solve_many(X, O, modalities=SIZES, start=start, **LAMBDAS)


def test_an_unknown_option_is_a_type_error():
    X, O = data(3)
    with pytest.raises(TypeError, match=r"recognize.*prunee.*its options are decision, prune"):
        recognize(X, O, modalities=SIZES, prunee=False, **LAMBDAS)


def test_the_templates_of_one_set_of_views_share_them():
    X, O = data()
    reduced = ReducedData.of(X, O, SIZES)
    problems = [reduced.problem(j, Penalties(0.3, 0.2, 0.1)) for j in range(3)]
    assert all(problem.X is reduced.views.X for problem in problems)
    assert problems[0].for_template(O[:, 1]).views is reduced.views


def test_gram_matrices_are_made_once_for_all_templates_that_fall_back(monkeypatch):
    X, O = data()
    bounds = DataBounds.of(ReducedData.of(X, O, SIZES))
    batch = BatchSolver.of(bounds, Penalties(0.3, 0.2, 0.1), Tolerances())
    made = []
    real = Reduction.of.__func__
    monkeypatch.setattr(Reduction, "of", classmethod(lambda cls, *a: made.append(1) or real(cls, *a)))
    batch.fall_back(np.arange(len(O.T)))
    assert batch.answers().certified.all()
    assert len(made) <= 1, f"{len(made)} times for {len(O.T)} templates"


def test_solve_copies_x_once(monkeypatch):
    monkeypatch.setenv("CONVEXPERC_KERNELS", "interpreted")  # machine code is not to be loaded meanwhile
    rng = np.random.default_rng(3)
    X = 3.0 * rng.random((100, 8000))
    problem = Problem(X, X[0] + rng.random(8000), modalities=[4000, 4000], **LAMBDAS)
    solve(Problem(X[:, :10], X[0, :10], **LAMBDAS))
    tracemalloc.start()
    solve(problem)
    peak = tracemalloc.get_traced_memory()[1] / X.nbytes
    tracemalloc.stop()
    assert peak < 2.6, f"{peak} times X; the normalised copy and |X| are 2 of them"


def test_many_modality_names_are_checked_in_linear_time():
    names = {f"m{i}": 1 for i in range(10_000)}
    looked = []

    class Counted(str):
        __slots__ = ()

        def __eq__(self, other):
            looked.append(1)
            return str.__eq__(self, other)

        __hash__ = str.__hash__

    problem = Problem(
        np.ones((1, 10_000)), np.ones(10_000), modalities={Counted(k): v for k, v in names.items()}, **LAMBDAS
    )
    assert problem.m == 10_000
    assert len(looked) < 100_000, len(looked)


def test_a_library_does_not_follow_the_array_that_it_was_made_of():
    X, O = data()
    known = TemplateLibrary.of(O, modalities=SIZES)
    before = recognize(X, known, **LAMBDAS)
    O *= 100.0
    O[:, ::-1] = O.copy()
    after = recognize(X, known, **LAMBDAS)
    assert (after.label, after.verdict) == (before.label, before.verdict)
    assert same(after.answers, before.answers)


def test_a_mask_is_never_ignored():
    X, O = data(3)
    masked = np.ma.masked_array(X, mask=np.zeros_like(X))
    assert recognize(masked, O, modalities=SIZES, **LAMBDAS).label is not None
    masked[0, 0] = np.ma.masked
    for call in (
        lambda: recognize(masked, O, modalities=SIZES, **LAMBDAS),
        lambda: Problem(masked, O[:, 0], modalities=SIZES, **LAMBDAS),
        lambda: Problem(X, np.ma.masked_less(O[:, 0], 1.0), modalities=SIZES, **LAMBDAS),
        lambda: solve_many(X, np.ma.masked_less(O, 1.0), modalities=SIZES, **LAMBDAS),
    ):
        with pytest.raises(ProblemError, match="must not be masked"):
            call()


def test_what_was_known_before_is_not_mixed_with_what_came_later():
    X, O = data()
    batch = BatchSolver.of(DataBounds.of(ReducedData.of(X, O, SIZES)), Penalties(0.3, 0.2, 0.1), Tolerances())
    batch.finish()
    found = batch.answers()
    assert found.certified.all()
    with pytest.raises(ValueError, match="read-only"):
        batch.advance(np.arange(2))
    with pytest.raises(ValueError, match="read-only"):
        found.reduced.T[:] = 0.0


def test_the_normalised_copy_of_x_lives_as_long_as_it_is_used():
    X, O = data()
    problem = Problem(3.0 * X, O[:, 0], modalities=SIZES, **LAMBDAS)
    held = problem.views.normalised
    assert problem.views.normalised is held
    gone = weakref.ref(held)
    del held
    gc.collect()
    assert gone() is None
    assert solve(problem).status is Status.CERTIFIED


def test_the_reference_that_does_not_fit_is_named():
    X, O = data(2)
    for references in ({"a": O[1:, 0], "b": O[:, 1]}, {"b": O[:, 1], "a": O[1:, 0]}):
        with pytest.raises(
            ProblemError, match="reference 'a' must have one entry for each of the 20 columns"
        ):
            recognize(X, references, **LAMBDAS)


@pytest.mark.parametrize("changed", [[], [1], [0, 3]])
def test_views_that_have_not_changed_are_not_multiplied_again(changed, monkeypatch):
    rng = np.random.default_rng(5)
    X, O = rng.random((5, 5000)), rng.random((5000, 4))
    library = TemplateLibrary(O, modalities=[4500, 500])
    first = recognize(X, library, **LAMBDAS)
    again = X.copy()
    again[changed] = 100.0 * rng.random((len(changed), 5000))
    anew = recognize(again, library, **LAMBDAS)
    whole, multiplied = anew.answers.data, []
    product = Reduction.product
    monkeypatch.setattr(Reduction, "of", None)
    monkeypatch.setattr(
        Reduction, "product", lambda self, O, rows: multiplied.extend(rows) or product(self, O, rows)
    )
    found = recognize(again, library, start=first, **LAMBDAS)
    assert multiplied == changed
    data = found.answers.data
    for name in ("G", "K", "C"):
        one, two = getattr(data, name), getattr(whole, name)
        assert np.allclose(one, two, rtol=1e-14, atol=0.0), (name, one, two)
    assert all(np.array_equal(matrix, matrix.T) for matrix in (data.G, *data.K))
    assert (found.certified, found.verdict, found.label) == (True, anew.verdict, anew.label)


def test_a_product_that_is_kept_by_mistake_would_be_seen():
    """The planted fault: rows that have changed are taken for the earlier ones."""
    rng = np.random.default_rng(6)
    X, library = rng.random((4, 30)), TemplateLibrary(rng.random((30, 3)))
    earlier = ReducedData.of(X, library)
    kept = earlier.views.reduction.replaced(2.0 * X, np.array([0]))
    assert not np.allclose(kept.G, (2.0 * X) @ (2.0 * X).T)


@pytest.mark.parametrize("other", ["library", "size", "most rows"])
def test_what_does_not_fit_is_multiplied_anew(other):
    rng = np.random.default_rng(7)
    X, O = rng.random((4, 30)), rng.random((30, 3))
    library = TemplateLibrary(O)
    earlier = ReducedData.of(X, library)
    if other == "library":
        library = TemplateLibrary(rng.random((30, 3)))
    X = X[:3] if other == "size" else rng.random(X.shape)
    found, whole = ReducedData.of(X, library, earlier=earlier), ReducedData.of(X, library)
    for name in ("G", "K", "C"):
        assert getattr(found, name).tobytes() == getattr(whole, name).tobytes(), name
