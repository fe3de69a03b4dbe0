import json
import math
import pickle
from dataclasses import asdict, dataclass, replace

import numpy as np
import pytest

from convexperc.errors import (
    ModalityError,
    ProblemError,
    RobotNameError,
    SolverError,
    StartError,
    TemplateNameError,
)
from convexperc.files import json_bytes
from convexperc.problem.library import TemplateLibrary
from convexperc.recognition.label import decide, recognize
from convexperc.recognition.recognition import Recognition, Verdict, _shares
from convexperc.report.records import recognition_record
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult

LAMBDAS = {"lambda1": 0.5, "lambda2": 0.1, "lambda3": 0.1}
CAR, CAT, DOG = np.eye(6)[[0, 2, 4]] + 0.1
VIEWS = np.stack([CAR, 0.8 * CAR + 0.1 * CAT, np.zeros(6)])
OBJECTS = {"cat": CAT, "car": CAR, "dog": DOG}


def recognized(X=VIEWS, references=None, **changes):
    settings = {"modalities": [2, 2, 2], **LAMBDAS, **changes}
    return recognize(X, OBJECTS if references is None else references, **settings)


@dataclass(frozen=True)
class Poor:
    """Says nothing useful about any problem, and claims the best of it."""

    name: str = "poor"

    def solve(self, problem):
        return SolverResult(np.full(problem.n, 0.01), np.zeros(problem.d), "optimal", 0)


def test_the_label_of_separated_templates_is_proved():
    found = recognized()
    assert (found.verdict, found.label, found.candidates) == (Verdict.PROVED, "car", ("car",))
    assert found.certified, [t.solution.certificate.relative_gap for t in found.templates]
    assert [t.name for t in found.templates] == list(OBJECTS)
    best = found.template()
    assert best.name == "car"
    assert all(best.interval[1] < t.interval[0] for t in found.templates if t.name != "car"), found.templates
    assert found.warnings == ("all features are 0 of robot 3: such a view shows nothing",)


@pytest.mark.parametrize("others", [1.0, 1e-170])
def test_a_view_whose_square_underflows_is_not_called_zero(others):
    X = np.array([[others, 0.0], [0.0, 1e-190], [0.0, 0.0]])
    found = recognize(X, {"a": [1, 0], "b": [0, 2]}, lambda1=1.0, lambda2=0.1, lambda3=0.1)
    silent = [each for each in found.warnings if "shows nothing" in each]
    assert silent == ["all features are 0 of robot 3: such a view shows nothing"]


def test_a_template_orthogonal_to_every_view_keeps_its_whole_norm():
    found = recognize([[1, 0], [1, 0]], {"a": [1, 0], "b": [0, 1]}, lambda1=1.0, lambda2=0.1, lambda3=0.1)
    assert (found.verdict, found.label) == (Verdict.PROVED, "a")
    low, high = found.template("b").interval
    assert low == pytest.approx(1.0, rel=1e-14)
    assert high == pytest.approx(1.0, rel=1e-14)
    assert found.template("a").interval[1] < 0.5, found.template("a").interval


def test_one_template_is_its_own_proof():
    found = recognized(references={"car": CAR})
    assert (found.verdict, found.label) == (Verdict.PROVED, "car")


def test_identical_templates_tie_only_when_they_are_the_best():
    twins = recognized(references={"car": CAR, "cat": CAT, "auto": CAR.copy()})
    assert (twins.verdict, twins.label) == (Verdict.TIE, None)
    assert set(twins.candidates) == {"car", "auto"}
    assert "identical" in twins.reason, twins.reason
    others = recognized(references={"cat": CAT, "car": CAR, "kitten": CAT.copy()})
    assert (others.verdict, others.label) == (Verdict.PROVED, "car")


@pytest.mark.parametrize("dog", [DOG, 3 * DOG])
def test_all_zero_optima_tie_whatever_the_norms(dog):
    found = recognized(references={"car": CAR, "dog": dog}, lambda2=100.0)
    assert (found.verdict, found.label) == (Verdict.TIE, None)
    assert set(found.candidates) == {"car", "dog"}
    assert "w = u = 0" in found.reason, found.reason
    assert not found.template("car").solution.w.any(), found.template("car").solution.w


@pytest.mark.parametrize(
    ("X", "references"),
    [
        ([[1, 0.5, 0, 0]], {"a": [1, 0, 0, 0.5], "b": [1, 0, 0.5, 0]}),
        ([[1, 0, 0]], {"a": [1, 0, 0], "b": [0.5, 0, 0.75**0.5]}),
    ],
)
def test_just_below_the_critical_lambda2_of_one_template_not_every_optimum_is_zero(X, references):
    critical = 2.0 * np.abs(np.array(X) @ np.array(list(references.values())).T).max()
    above, below = (
        recognize(X, references, lambda1=1.0, lambda2=factor * critical, lambda3=1.0)
        for factor in (1 + 1e-9, 1 - 1e-9)
    )
    assert "w = u = 0" in above.reason, above.reason
    assert "w = u = 0" not in below.reason, below.reason


def test_poor_answers_leave_the_label_undecided():
    found = recognized(solver=Poor(), escalate=False)
    assert (found.verdict, found.label) == (Verdict.UNDECIDED, None)
    assert "overlap" in found.reason, found.reason
    assert "car" in found.candidates, found.candidates
    assert not found.certified, found.templates
    tops = [found.template(name).interval[1] for name in found.candidates]
    assert tops == sorted(tops), tops
    good = recognized()
    for name in OBJECTS:
        low, high = found.template(name).interval
        assert low <= good.template(name).interval[1], (name, low)
        assert good.template(name).interval[0] <= high, (name, high)


def test_decide_reads_the_intervals_alone():
    found = recognized()
    lower, upper = found.answers.lower.copy(), found.answers.upper.copy()
    swapped = replace(found.answers, lower=lower[[1, 0, 2]], upper=upper[[1, 0, 2]])
    assert decide(swapped, found.names, found.views).label == "cat"
    lower[0] = upper[1]
    touching = decide(replace(found.answers, lower=lower, upper=upper), found.names, found.views)
    assert (touching.verdict, touching.candidates) == (Verdict.UNDECIDED, ("car", "cat"))


def test_views_and_modalities_are_ranked_by_weight_with_proved_zeros():
    found = recognized(VIEWS[[2, 0, 1]], views=("cid", "ann", "bob"))
    views, modalities = found.ranked_views(), found.ranked_modalities()
    solution = found.template().solution
    assert views[0].name == "ann", views
    assert abs(views[-1].weight) < 1e-12, views
    assert next(v for v in views if v.name == "cid").proved_zero, views
    assert not views[0].proved_zero, views
    assert modalities[0].name == "m1", modalities
    for ranked, weights in ((views, solution.w), (modalities, solution.modality_norms)):
        sizes = [abs(r.weight) for r in ranked]
        assert sizes == pytest.approx(sorted(np.abs(weights), reverse=True), rel=1e-14)
        assert sum(r.share for r in ranked) == pytest.approx(1.0)
        assert [r.share for r in ranked] == pytest.approx(np.array(sizes) / sum(sizes))
    assert {r.name for r in found.ranked_views("dog")} == {"ann", "bob", "cid"}


def test_a_negative_weight_ranks_by_its_size():
    found = recognize([[1, 0], [0, -1]], {"a": [1, 2]}, lambda1=0.0, lambda2=0.1, lambda3=0.1)
    first, second = found.ranked_views()
    assert (first.name, second.name) == ("robot 2", "robot 1")
    assert first.weight == pytest.approx(-1.95), first
    assert first.share == pytest.approx(1.95 / 2.9), first
    assert all(r.proved_zero for r in found.ranked_modalities()), found.ranked_modalities()


@pytest.mark.parametrize(
    ("factor", "warned"), [(1.0, False), (1.09, False), (1.11, True), (100.0, True), (0.0, True)]
)
def test_templates_of_unequal_norm_are_warned_about(factor, warned):
    found = recognize(VIEWS[:2], {"car": CAR, "long": factor * CAR}, **LAMBDAS)
    assert bool(found.warnings) == warned, found.warnings
    assert not warned or ("car" in found.warnings[0] and "long" in found.warnings[0]), found.warnings


@pytest.mark.parametrize("scale", [1e-170, 1e-100, 1e100, 1e170])
def test_the_warning_does_not_depend_on_the_scale(scale):
    settings = {"lambda1": 0.5, "lambda2": 0.1 * scale, "lambda3": 0.1 * scale}
    found = recognize(VIEWS[:2], {"car": scale * CAR, "long": 2 * scale * CAR}, **settings)
    assert len(found.warnings) == 1, found.warnings


@pytest.mark.parametrize("order", [(2, 0, 1), (1, 2, 0)])
def test_the_order_of_robots_templates_and_modalities_does_not_matter(order):
    base = recognized()
    names = [list(OBJECTS)[i] for i in order]
    robots = recognized(VIEWS[list(order)], views=[f"robot {i + 1}" for i in order])
    objects = recognized(references={name: OBJECTS[name] for name in names})
    parts = {f"m{i + 1}": [2 * i, 2 * i + 1] for i in order}
    modalities = recognized(modalities=parts)
    for moved in (robots, objects, modalities):
        assert (moved.verdict, moved.label) == (base.verdict, base.label)
        for name in OBJECTS:
            a, b = base.template(name).interval, moved.template(name).interval
            assert a[0] <= b[1], (name, a, b)
            assert b[0] <= a[1], (name, a, b)
        for ranks in ("ranked_views", "ranked_modalities"):
            expected = {r.name: r.weight for r in getattr(base, ranks)()}
            found = {r.name: r.weight for r in getattr(moved, ranks)()}
            assert found == pytest.approx(expected, abs=1e-4), ranks


@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"references": {}}, ProblemError, "at least one object"),
        ({"views": ["a", "b"]}, RobotNameError, "3 rows of X"),
        ({"views": ["a", "a", "b"]}, RobotNameError, "once"),
        ({"references": {"car": CAR[:5]}}, ProblemError, "6 columns of X"),
        ({"references": {"car": np.full(6, np.nan)}}, ProblemError, "finite"),
        ({"references": np.eye(6), "names": ["a", "b"]}, TemplateNameError, "each of the 6 templates once"),
        ({"references": np.full((6, 2), np.nan)}, ProblemError, r"O\[:, 0\]\[0\] must be finite"),
        ({"references": np.zeros((5, 2))}, ProblemError, "6 rows"),
        ({"references": np.zeros((6, 2), complex)}, ProblemError, "real numbers"),
        ({"start": recognized(references={"car": CAR})}, StartError, "start must be answers"),
        ({"X": np.full((3, 6), np.inf)}, ProblemError, "finite"),
        ({"modalities": [2, 2]}, ModalityError, "6 columns"),
        ({"lambda2": -1.0}, ProblemError, "lambda2"),
    ],
)
def test_bad_calls_are_refused(changes, error, text):
    with pytest.raises(error, match=text):
        recognized(**changes)


def test_an_unknown_template_is_refused_by_name():
    with pytest.raises(
        TemplateNameError, match=r"template must be one of \['cat', 'car', 'dog'\]; got 'cow'"
    ):
        recognized().template("cow")


def test_a_failing_solver_is_heard():
    class Broken(Poor):
        def solve(self, problem):
            raise SolverError("broken", value=1, must="must not fail")

    with pytest.raises(SolverError, match="broken"):
        recognized(solver=Broken(), escalate=False)
    assert recognized(solver=Broken()).label == recognized().label


def test_a_recognition_pickles():
    found = recognized(solver=Conic())
    again = pickle.loads(pickle.dumps(found))
    assert (again.verdict, again.label, again.candidates) == (found.verdict, found.label, found.candidates)
    assert again.ranked_views() == found.ranked_views()


def test_one_template_is_looked_up_without_making_all(monkeypatch):
    found = recognized()
    wanted = found.templates[1]
    monkeypatch.setattr(Recognition, "templates", property(lambda _: pytest.fail("all were made")))
    for name in ("car", None):
        one = found.template(name)
        assert (one.name, one.index, one.cost, one.excluded) == (
            wanted.name,
            wanted.index,
            wanted.cost,
            wanted.excluded,
        )
    assert found.ranked_views()[0].name == found.views[0]


@pytest.mark.parametrize(("x", "o"), [(-530, 520), (-330, 520), (-330, 830)])
def test_weights_beyond_float64_keep_their_ranking_and_their_shares(x, o):
    """F is homogeneous: X = 2^x X_ and o = 2^o o_ give w = 2^(o - x) w_."""
    rng = np.random.default_rng(0)
    X, O = rng.random((3, 6)), rng.random((6, 3))
    plain = recognize(X, O, modalities=[2, 4], lambda1=1.0, lambda2=0.01, lambda3=0.01, prune=False)
    found = recognize(
        np.ldexp(X, x), np.ldexp(O, o), modalities=[2, 4], lambda1=math.ldexp(1.0, 2 * x),
        lambda2=math.ldexp(0.01, x + o), lambda3=math.ldexp(0.01, 2 * x + o),
    )  # fmt: skip
    record = json.loads(json_bytes(recognition_record(found)))
    for name in found.names:
        for mine, reference in (
            (found.ranked_views(name), plain.ranked_views(name)),
            (found.ranked_modalities(name), plain.ranked_modalities(name)),
        ):
            assert [one.name for one in mine] == [one.name for one in reference], (mine, reference)
            assert [one.share for one in mine] == pytest.approx([one.share for one in reference], rel=1e-5)
    best = found.ranked_modalities()
    assert math.isinf(best[0].weight)
    assert record["ranked_modalities"][0] == {**asdict(best[0]), "weight": "inf"}


@pytest.mark.parametrize(
    ("sizes", "shares"),
    [
        ([0.0, 0.0], [0.0, 0.0]),
        ([1.0, 3.0], [0.25, 0.75]),
        ([1e308, 1e308, 0.0], [0.5, 0.5, 0.0]),
        ([math.inf, 1.0, math.inf], [0.5, 0.0, 0.5]),
    ],
)
def test_shares_of_any_size(sizes, shares):
    assert _shares(np.array(sizes)).tolist() == shares


@pytest.mark.parametrize("lambda3", [0.1, 0.0])
def test_what_is_proved_zero_has_no_share(lambda3):
    """With lambda2 so large that w = u = 0, rounding left norms of 1e-45 and shares of a third each."""
    rng = np.random.default_rng(5)
    X, library = rng.random((4, 9)), TemplateLibrary(rng.random((9, 3)), modalities=[3, 3, 3])
    found = recognize(X, library, lambda1=0.1, lambda2=100.0, lambda3=lambda3)
    again = recognize(X, library, lambda1=0.1, lambda2=100.0, lambda3=lambda3, start=recognize(
        X, library, lambda1=0.1, lambda2=0.01, lambda3=lambda3))  # fmt: skip
    for each in (found, again):
        ranked = (*each.ranked_views(), *each.ranked_modalities())
        assert all(entry.share == 0.0 for entry in ranked if entry.proved_zero)
        assert all(entry.proved_zero for entry in each.ranked_views())
    assert {entry.weight for entry in found.ranked_modalities()} == {0.0}


def test_a_recognition_is_printed_in_a_line():
    found = recognize(np.eye(2), {"a": [1.0, 0.0], "b": [0.0, 2.0]}, lambda1=1.0, lambda2=0.1, lambda3=0.1)
    assert repr(found) == (
        "<Recognition of 2 objects: proved: lowest optimum, candidates ['a'], views ['robot 1', 'robot 2']>"
    )
