"""Recognition as an estimator: what it keeps, what it answers, and what it refuses."""

import pickle

import cvxpy as cp
import numpy as np
import pytest
from sklearn.calibration import CalibratedClassifierCV
from sklearn.datasets import load_digits
from sklearn.exceptions import NotFittedError
from sklearn.linear_model import Lasso
from sklearn.model_selection import GridSearchCV, cross_val_score, train_test_split
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer

from convexperc import FeatureConfiguration, TemplateLibrary, extract, recognize
from convexperc.classifier import MultiViewClassifier, UnprovedLabelWarning
from convexperc.errors import (
    BudgetError,
    DecisionError,
    InputError,
    ModalityError,
    ProblemError,
    TemplateNameError,
)
from convexperc.recognition import Verdict, sample_names, sample_scene

ROBOTS, D = 3, 6
SIZES = [2, 4]


def samples(seed=0, count=12, classes=("cat", "dog", "emu")):
    """Rows of three views, and their classes in no order."""
    rng = np.random.default_rng(seed)
    y = np.array(classes)[rng.permutation(np.arange(count) % len(classes))]
    centers = dict(zip(classes, rng.random((len(classes), D)), strict=True))
    X = np.stack([[centers[label] + 0.2 * rng.random(D) for _ in range(ROBOTS)] for label in y])
    return X.reshape(count, ROBOTS * D), y


def fitted(**parameters):
    X, y = samples()
    return MultiViewClassifier(**{"robots": ROBOTS, "modalities": SIZES, **parameters}).fit(X, y)


def references_of(X, y, kind):
    """The references of each class, from the definition, in a loop."""
    views = X.reshape(len(X), ROBOTS, D)
    found = {}
    for label in sorted(set(y)):
        own = [views[i] for i in range(len(y)) if y[i] == label]
        found[label] = {
            "view": [view for sample in own for view in sample],
            "sample": [sum(sample) / ROBOTS for sample in own],
            "class": [sum(sum(sample) for sample in own) / (ROBOTS * len(own))],
        }[kind]
    return found


def optimum(X, o, lambda1, lambda2, lambda3):
    """F* by CVXPY and Clarabel, from the formula."""
    w, u = cp.Variable(len(X)), cp.Variable(D)
    parts = cp.norm(u[: SIZES[0]]) + cp.norm(u[SIZES[0] :])
    F = cp.sum_squares(X.T @ w - o) + lambda1 * cp.sum_squares(X @ u - w)
    return cp.Problem(cp.Minimize(F + lambda2 * cp.norm1(w) + lambda3 * parts)).solve(solver="CLARABEL")


@pytest.mark.parametrize("kind", ["view", "sample", "class"])
def test_the_values_are_minus_the_optima_that_clarabel_finds(kind):
    X, y = samples()
    rows, _ = samples(seed=1, count=2)
    found = fitted(references=kind, lambda3=0.3)
    known = references_of(X, y, kind)
    expected = [
        [-min(optimum(row.reshape(ROBOTS, D), o, 0.1, 0.1, 0.3) for o in known[label]) for label in known]
        for row in rows
    ]
    assert found.decision_function(rows) == pytest.approx(np.array(expected), rel=1e-6)
    assert found.predict(rows).tolist() == [list(known)[int(np.argmax(each))] for each in expected]


def test_without_a_coupling_the_values_are_those_of_a_lasso_of_scikit_learn():
    X, y = samples()
    found = fitted(lambda1=0.0, lambda2=0.05, references="sample")
    row = samples(seed=2, count=1)[0]
    views, expected = row.reshape(ROBOTS, D), []
    for references in references_of(X, y, "sample").values():
        values = []
        for o in references:
            lasso = Lasso(alpha=0.05 / (2 * D), fit_intercept=False, tol=1e-12, max_iter=100_000)
            w = lasso.fit(views.T, o).coef_
            values.append(np.sum((views.T @ w - o) ** 2) + 0.05 * np.abs(w).sum())
        expected.append(-min(values))
    assert found.decision_function(row)[0] == pytest.approx(np.array(expected), rel=1e-6)


def test_an_explained_fraction_is_the_share_of_least_squares_where_nothing_is_penalised():
    X, y = samples()
    found = fitted(lambda1=0.0, lambda2=0.0, lambda3=0.0, references="class", decision="explained fraction")
    row = samples(seed=3, count=1)[0]
    views, expected = row.reshape(ROBOTS, D), []
    for (o,) in references_of(X, y, "class").values():
        expected.append(-np.linalg.lstsq(views.T, o)[1][0] / (o @ o))
    assert found.decision_function(row)[0] == pytest.approx(np.array(expected), rel=1e-6)


def test_the_labels_of_the_sample_scenes_are_those_of_recognize():
    configuration, lambdas = FeatureConfiguration(), {"lambda1": 0.1, "lambda2": 1.0, "lambda3": 0.1}
    sizes = configuration.modality_sizes
    scenes = [sample_scene(name) for name in sample_names()]
    known = {name: extract([picture], configuration)[0] for name, picture in scenes[0].references.items()}
    views = [extract(list(scene.views.values()), configuration) for scene in scenes]
    robots = len(views[0])
    X = np.stack([np.tile(o, robots) for o in known.values()])
    classifier = MultiViewClassifier(robots, modalities=sizes, **lambdas).fit(X, list(known))
    rows = np.stack([each.ravel() for each in views])
    library = TemplateLibrary(known, modalities=sizes)
    expected = [recognize(each, library, prune=False, **lambdas) for each in views]
    assert classifier.predict(rows).tolist() == [each.label for each in expected] == list(sample_names())
    assert classifier.score(rows, sample_names()) == 1.0
    found = classifier.recognize(rows)
    assert [each.statement for each in found] == ["proved: lowest optimum"] * len(scenes)
    order = [expected[0].objects.index(name) for name in classifier.classes_]
    upper = np.array([each.answers.upper[order] for each in expected])
    assert -classifier.decision_function(rows) == pytest.approx(upper, rel=1e-8)


def test_references_are_named_by_class_row_and_robot():
    X, y = samples()
    views = fitted().library_
    assert views.objects == ("cat", "dog", "emu")
    assert len(views) == ROBOTS * len(y)
    for j, name in enumerate(views.names):
        label, row, robot = name.split("/")
        i, k = int(row.removeprefix("row ")), int(robot.removeprefix("robot ")) - 1
        assert y[i] == label == views.shown[j]
        assert (views.template(j) == X[i, k * D : (k + 1) * D]).all()
    assert set(fitted(references="sample").library_.names) == {f"{y[i]}/row {i}" for i in range(len(y))}
    assert fitted(references="class").library_.names == ("cat", "dog", "emu")


def test_the_reference_that_decides_is_told():
    X, y = samples()
    found = fitted(lambda1=0.0, lambda2=0.0, lambda3=0.0, references="class").recognize(X)
    assert [each.label for each in found] == [each.template().name for each in found]
    (one,) = MultiViewClassifier(lambda1=0.0, lambda2=0.0, lambda3=0.0).fit(X, y).recognize(X[4:5])
    assert one.template().name == f"{y[4]}/row 4/robot 1"


@pytest.mark.parametrize("classes", [(3, 1), (2.0, -1.0), (True, False), ("b", "a"), ("é", "/")])
def test_labels_keep_their_type_and_two_classes_have_one_value(classes):
    X, y = samples(classes=classes)
    found = MultiViewClassifier(ROBOTS).fit(X, y)
    assert found.classes_.dtype == found.predict(X).dtype == y.dtype
    value = found.decision_function(X)
    assert value.shape == (len(X),)
    assert (found.classes_[(value > 0).astype(int)] == found.predict(X)).all()
    (both,) = found.recognize(X[:1], prune=False)
    first, second = (each.cost[1] for each in both.best_templates)
    assert value[0] == first - second


def test_one_class_is_always_the_best():
    X, y = samples(classes=("cat",))
    found = MultiViewClassifier(ROBOTS).fit(X, y)
    assert found.predict(X).tolist() == ["cat"] * len(X)
    assert found.decision_function(X).shape == (len(X), 1)


def test_references_that_are_the_same_in_two_classes_are_told():
    X, y = samples(classes=("a", "b"))
    found = MultiViewClassifier(ROBOTS, references="sample").fit(np.vstack([X, X]), [*y, *y[::-1]])
    with pytest.warns(UnprovedLabelWarning, match=r"of \d+ of 12 samples is undecided or tied"):
        labels = found.predict(X)
    assert (labels == found.classes_[(found.decision_function(X) > 0).astype(int)]).all()
    ties = [each for each in found.recognize(X) if each.verdict is Verdict.TIE]
    assert ties
    assert {(each.label, each.candidates) for each in ties} == {(None, ("a", "b"))}


def test_where_all_weights_are_zero_every_label_is_told():
    X, _ = samples()
    found = fitted(lambda2=1e6)
    with pytest.warns(UnprovedLabelWarning, match="of 12 of 12 samples"):
        labels = found.predict(X)
    assert (labels == found.classes_[found.decision_function(X).argmax(axis=1)]).all()
    assert {each.verdict for each in found.recognize(X)} == {Verdict.TIE}


def test_a_label_that_is_proved_is_not_warned_about(recwarn):
    fitted().predict(samples()[0])
    assert not recwarn.list


def test_what_it_learned_is_its_own():
    X, y = samples()
    found = MultiViewClassifier(ROBOTS).fit(X, y)
    before = found.decision_function(samples(seed=1)[0])
    X[:] = 0.0
    assert (found.decision_function(samples(seed=1)[0]) == before).all()
    assert not found.library_.O.flags.writeable


def test_a_pickled_one_gives_the_same_bits():
    found, rows = fitted(), samples(seed=1)[0]
    again = pickle.loads(pickle.dumps(found))
    assert again.decision_function(rows).tobytes() == found.decision_function(rows).tobytes()


def test_penalties_may_change_without_another_fit_and_robots_stay():
    found, rows = fitted(), samples(seed=1)[0]
    found.set_params(lambda2=0.4, robots=1, references="class")
    expected = fitted(lambda2=0.4).decision_function(rows)
    assert found.decision_function(rows).tobytes() == expected.tobytes()


def test_it_is_searched_piped_calibrated_and_validated():
    X, y = samples(count=60)
    pipe = make_pipeline(
        FunctionTransformer(np.sqrt), MultiViewClassifier(ROBOTS, references="class", modalities=SIZES)
    )
    grid = {"multiviewclassifier__lambda2": [1e-3, 1e3], "multiviewclassifier__decision": ["objective"]}
    with pytest.warns(UnprovedLabelWarning):
        search = GridSearchCV(pipe, grid, cv=3).fit(X, y)
    assert search.best_params_["multiviewclassifier__lambda2"] == 1e-3, "at 1e3 all weights are 0"
    assert search.best_score_ > 0.9
    assert cross_val_score(pipe, X, y == "cat", scoring="roc_auc", cv=3).min() > 0.9
    shares = CalibratedClassifierCV(pipe, cv=3).fit(X, y).predict_proba(X)
    assert (shares.argmax(axis=1) == np.searchsorted(search.classes_, y)).mean() > 0.9


def half_covered(images, rng):
    """Four views of each digit, two of them half covered, each of length 1."""
    views = np.repeat(images[:, None], 4, axis=1)
    views = np.clip(views + rng.normal(0.0, 2.0, views.shape), 0.0, None)
    halves = [np.s_[:4, :], np.s_[4:, :], np.s_[:, :4], np.s_[:, 4:]]
    for sample in views:
        for robot in rng.permutation(4)[:2]:
            sample[robot][halves[rng.integers(4)]] = 0.0
    rows = views.reshape(len(views), 4, 64)
    return (rows / np.linalg.norm(rows, axis=2, keepdims=True)).reshape(len(views), 256)


def test_digits_half_covered_in_two_of_four_views_are_named_as_well_as_by_the_nearest_neighbor():
    digits, rng = load_digits(), np.random.default_rng(0)
    known, seen, y, truth = train_test_split(
        digits.images, digits.target, train_size=200, test_size=100, stratify=digits.target, random_state=0
    )
    X, rows = half_covered(known, rng), half_covered(seen, rng)
    own = MultiViewClassifier(4, references="sample").fit(X, y).score(rows, truth)
    nearest = KNeighborsClassifier(1).fit(X, y).score(rows, truth)
    assert own > 0.8, own
    assert own > nearest - 0.05, (own, nearest)


@pytest.mark.parametrize(
    ("parameters", "error", "said"),
    [
        ({"robots": 0}, InputError, "robots must be an integer >= 1; got 0"),
        ({"robots": True}, InputError, "robots must be an integer >= 1; got True"),
        ({"robots": 1.5}, InputError, "robots must be an integer >= 1; got 1.5"),
        ({"robots": 4}, InputError, "columns of X must be a multiple of robots = 4"),
        ({"robots": 2}, ModalityError, "modalities must sum to the 9 columns of X; got 6"),
        ({"references": "each"}, InputError, "references must be one of 'view', 'sample', 'class'"),
        ({"references": None}, InputError, "references must be one of"),
        ({"lambda1": -1}, ProblemError, "lambda1 must be a finite real number >= 0"),
        ({"lambda2": "1"}, ProblemError, "lambda2 must be a finite real number >= 0"),
        ({"lambda3": np.nan}, ProblemError, "lambda3 must be a finite real number >= 0"),
        ({"decision": "vote"}, DecisionError, "decision must be one of 'objective'"),
        ({"seconds": 0}, BudgetError, "seconds"),
        ({"modalities": [3, 4]}, ModalityError, "modalities must sum to the 6 columns"),
    ],
)
def test_parameters_that_cannot_be_used_are_refused_by_fit(parameters, error, said):
    with pytest.raises(error, match=said):
        fitted(**parameters)


def test_data_that_cannot_be_used_are_refused():
    X, y = samples()
    found = MultiViewClassifier(ROBOTS).fit(X, y)
    with pytest.raises(ValueError, match="X has 12 features, but MultiViewClassifier is expecting 18"):
        found.predict(X[:, :12])  # one robot less
    with pytest.raises(ValueError, match="NaN"):
        found.predict(np.where(np.arange(18) == 4, np.nan, X))
    with pytest.raises(NotFittedError):
        MultiViewClassifier().predict(X)
    with pytest.raises(ProblemError, match="lambda2 must be"):
        found.set_params(lambda2=-1.0).predict(X)
    found.set_params(lambda2=0.1)
    with pytest.raises(TemplateNameError, match="strings that are not empty"):
        found.fit(X, ["", *y[1:]])
    with pytest.raises(ProblemError, match="exactly"):
        found.fit(np.full((2, 3), 2**53 + 1), ["a", "b"])


def test_means_that_overflow_are_refused_at_once():
    with pytest.raises(ProblemError, match="finite"):
        MultiViewClassifier(2, references="sample").fit(np.full((2, 4), 1.7e308), ["a", "b"])
