"""Objects with several references: the label, ties and tables are by object."""

import numpy as np
import pytest

from convexperc import Problem, TemplateLibrary, recognize, solve
from convexperc.errors import ProblemError, TemplateNameError
from convexperc.features.configuration import FeatureConfiguration
from convexperc.recognition.recognition import Verdict
from convexperc.recognition.references import References, left_out, perceive, read_references

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
SIZES = [5, 7]


def views(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).random((4, 12))


def known(seed: int = 1) -> dict[str, object]:
    rng, X = np.random.default_rng(seed), views()
    return {
        "cup": rng.random((3, 12)),
        "box": X.mean(axis=0) + 0.01 * rng.random((2, 12)),
        "can": rng.random(12),
        "tin": {"front": rng.random(12), "back": list(rng.random(12))},
    }


NAMES = ("cup/1", "cup/2", "cup/3", "box/1", "box/2", "can", "tin/front", "tin/back")


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("prune", [True, False])
def test_the_label_is_the_object_of_the_reference_with_the_lowest_optimum(seed, prune):
    found = recognize(views(), known(seed), modalities=SIZES, prune=prune, **LAMBDAS)
    library = found.answers.data.library
    optima = [
        solve(Problem(views(), library.template(j), modalities=SIZES, **LAMBDAS)).certificate.upper
        for j in range(len(library))
    ]
    assert found.names == NAMES
    assert found.objects == ("cup", "box", "can", "tin")
    best = int(np.argmin(optima))
    label = library.shown[best]
    assert (found.verdict, found.label, found.candidates) == (Verdict.PROVED, label, (label,))
    assert (found.template().name, found.template().object) == (NAMES[best], found.label)
    if not prune:
        for template, place in zip(found.best_templates, range(4), strict=True):
            own = [j for j in range(len(library)) if library.owners[j] == place]
            assert template.index == min(own, key=lambda j: optima[j]), template.name


def test_the_same_references_of_one_object_are_no_tie_and_of_two_are_one():
    X = views()
    O = np.column_stack([X[0], X[0], np.ones(12)])
    one = recognize(X, TemplateLibrary(O, objects=["a", "a", "b"], modalities=SIZES), **LAMBDAS)
    assert (one.verdict, one.label, one.template().object) == (Verdict.PROVED, "a", "a")
    two = recognize(X, TemplateLibrary(O, objects=["a", "b", "b"], modalities=SIZES), **LAMBDAS)
    assert (two.verdict, two.label, two.candidates) == (Verdict.TIE, None, ("a", "b"))
    assert "a, b/1 are identical" in two.reason


def test_a_reference_is_found_by_its_name_and_an_object_by_its_best_one():
    found = recognize(views(), known(), modalities=SIZES, prune=False, **LAMBDAS)
    assert found.template("tin/front").object == "tin"
    assert found.template("tin").name in {"tin/front", "tin/back"}
    with pytest.raises(TemplateNameError, match="must be one of"):
        found.template("tin/side")


def test_one_reference_an_object_is_as_it_was():
    X, O = views(), {"a": np.ones(12), "b": views(3)[0]}
    plain = TemplateLibrary(O, modalities=SIZES)
    rows = TemplateLibrary({name: o[None] for name, o in O.items()}, modalities=SIZES)
    assert plain.names == rows.names == plain.objects == rows.objects == ("a", "b")
    assert (plain.several, rows.several) == (False, False)
    one, two = (recognize(X, library, **LAMBDAS) for library in (plain, rows))
    assert one.answers.lower.tobytes() == two.answers.lower.tobytes()


@pytest.mark.parametrize(
    ("templates", "more", "error", "said"),
    [
        ({"a": [[1.0, 2.0], [3.0]]}, {}, ProblemError, "rectangular"),
        ({"a": np.zeros((0, 3)), "b": [1.0, 2.0, 3.0]}, {}, ProblemError, "at least one reference"),
        ({"a": {}, "b": [1.0]}, {}, ProblemError, "at least one reference"),
        ({"a/1": [1.0, 2.0], "a": [[1.0, 2.0], [3.0, 4.0]]}, {}, TemplateNameError, "got 'a/1'"),
        ({"a": {"x": [1.0], 3: [2.0]}}, {}, TemplateNameError, "by strings"),
        ({"a": [[1.0, 2.0]], "b": [1.0]}, {}, ProblemError, "must have the 2 entries"),
        ({"a": [1.0]}, {"objects": ["a"]}, TemplateNameError, "must be left out"),
        (np.ones((2, 3)), {"objects": ["a", "b"]}, TemplateNameError, "each of the 3 templates"),
        (np.ones((2, 2)), {"objects": ["a", ""]}, TemplateNameError, "not empty"),
        (np.ones((2, 2)), {"objects": "ab"}, TemplateNameError, "objects"),
    ],
)
def test_what_does_not_fit_is_refused(templates, more, error, said):
    with pytest.raises(error, match=said):
        TemplateLibrary(templates, **more)


def test_a_library_keeps_its_objects():
    library = TemplateLibrary(np.ones((12, 2)), objects=["a", "a"], names=["x", "y"], modalities=SIZES)
    assert (library.names, library.objects, library.owners.tolist()) == (("x", "y"), ("a",), [0, 0])
    assert TemplateLibrary.of(library, objects=["a", "a"]) is library
    with pytest.raises(TemplateNameError, match="the library has objects"):
        TemplateLibrary.of(library, objects=["a", "b"])


def test_many_references_are_named_in_linear_time():
    count = 40_000
    library = TemplateLibrary(np.ones((1, count)), objects=[f"object {j % 8000}" for j in range(count)])
    assert (len(library.objects), library.names[-1]) == (8000, "object 7999/5")


def picture(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (24, 24, 3), dtype=np.uint8)


def test_pictures_of_references_are_read_from_files_and_folders(tmp_path):
    import cv2  # noqa: PLC0415

    (tmp_path / "cup").mkdir()
    (tmp_path / "empty").mkdir()
    for name in ("box.png", "cup/front.png", "cup/back.png"):
        assert cv2.imwrite(str(tmp_path / name), picture(len(name)))
    (tmp_path / "cup" / "notes.txt").write_text("x")
    found = read_references(tmp_path)
    assert list(found) == ["box", "cup"]
    assert list(found["cup"]) == ["back", "front"]
    said = "cup/notes.txt (no picture by its name)", "empty (a folder without a picture)"
    assert left_out(tmp_path, references=True) == said
    assert left_out(tmp_path) == ("cup (a folder)", "empty (a folder)")
    references = References.of(found, FeatureConfiguration())
    assert (references.names, references.objects) == (("box", "cup/back", "cup/front"), ("box", "cup"))
    seen = perceive({"one": found["cup"]["front"]}, references, **LAMBDAS)
    assert (seen.label, seen.template().name) == ("cup", "cup/front")


def test_candidates_of_a_tie_at_zero_come_in_the_order_of_their_costs():
    library = TemplateLibrary(
        np.array([[-2.0, 4], [-2, 4], [2, -4], [0, -4]]).T, objects=["o0", "o0", "o0", "o2"]
    )
    found = recognize(np.zeros((2, 2)), library, lambda1=0.1, lambda2=0.1, lambda3=0.1)
    assert (found.label, found.candidates, found.runner_up) == (None, ("o2", "o0"), "o0")
    lower, upper = found.margin
    assert lower <= 0.2 <= upper


def test_a_name_of_an_object_and_of_another_ones_reference_is_not_looked_up():
    library = TemplateLibrary({"a": {"1": [1.0, 0, 0], "2": [0, 1.0, 0]}, "a/1": {"x": [0, 0, 1.0]}})
    found = recognize(np.eye(3), library, lambda1=0.1, lambda2=0.1, lambda3=0.1)
    with pytest.raises(TemplateNameError, match="both of an object and of a reference of 'a'"):
        found.template("a/1")
    assert found.template("a/2").object == "a"
    assert {each.object for each in found.best_templates} == {"a", "a/1"}
