"""The figure: what it shows for few and many views and objects, and that it is the same each time."""

import importlib.util
import warnings
from html import unescape
from xml.etree import ElementTree

import cv2
import matplotlib as mpl
import numpy as np
import pytest

from convexperc.errors import InputError
from convexperc.recognition.calibration import Acceptance, Judgement
from convexperc.recognition.label import recognize
from convexperc.recognition.recognition import Verdict
from convexperc.report.figure import MOST_VIEWS
from convexperc.report.picture import picture_kind, recognition_picture

SVG = "{http://www.w3.org/2000/svg}"


def scene(n=3, objects=2, lambda2=0.1, name="object", o=None):
    """A recognition with n views of 6 features and pictures of several shapes."""
    rng = np.random.default_rng(n)
    X = np.abs(rng.normal(size=(n, 6)))
    columns = {f"{name} {i}": X[0] * (1.0 + i) if o is None else o for i in range(objects)}
    names = [f"robot {i}" for i in range(n)]
    found = recognize(
        X,
        columns,
        lambda1=0.1,
        lambda2=lambda2,
        lambda3=0.1,
        modalities={"color": 3, "shape": 2, "texture": 1},
        views=names,
    )
    shapes = ((30, 40), (40, 20), (8, 500))
    pictures = {
        view: np.full((*shapes[i % 3], 3), 40 + 8 * i % 200, dtype=np.uint8) for i, view in enumerate(names)
    }
    return found, pictures


def words(svg):
    """The texts of an SVG, which Matplotlib leaves in comments above their outlines."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.fromstring(svg, parser)
    return [unescape(str(node.text)).strip() for node in root.iter() if node.tag is ElementTree.Comment]


@pytest.mark.parametrize(("n", "objects"), [(1, 1), (3, 8), (12, 3), (MOST_VIEWS + 3, 17)])
def test_the_figure_shows_every_view_modality_and_optimum(n, objects):
    found, pictures = scene(n, objects)
    shown = words(recognition_picture(found, pictures, "svg"))
    for place, view in enumerate(found.ranked_views()[:MOST_VIEWS], 1):
        assert f"{place}  {view.name}" in shown, (view, shown)
        if not view.proved_zero:
            assert f"{100 * view.share:.1f} %   w = {view.weight:+.3g}" in shown, (view, shown)
    for entry in found.ranked_modalities():
        assert entry.name in shown, (entry, shown)
    for template in sorted(found.templates, key=lambda t: t.interval[1])[:8]:
        assert template.name in shown, (template.name, shown)
    zeros = [*found.ranked_views()[:MOST_VIEWS], *found.ranked_modalities()]
    assert shown.count("proved zero") == sum(entry.proved_zero for entry in zeros), shown
    more = [text for text in shown if text.endswith(f"the first {MOST_VIEWS} of {n}")]
    assert len(more) == (n > MOST_VIEWS), shown


def test_a_png_is_a_picture_of_the_stated_width():
    found, pictures = scene(5, 3)
    image = cv2.imdecode(
        np.frombuffer(recognition_picture(found, pictures, "png"), np.uint8), cv2.IMREAD_COLOR
    )
    assert image is not None
    assert image.shape[1] == 1650
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 10


def test_the_title_is_the_label_only_when_it_is_proved():
    found, pictures = scene(3, 2)
    assert found.verdict is Verdict.PROVED
    assert found.label in words(recognition_picture(found, pictures, "svg"))
    tied, pictures = scene(3, 2, o=np.ones(6))
    assert tied.verdict is Verdict.TIE
    shown = words(recognition_picture(tied, pictures, "svg"))
    assert "No label: tie" in shown, shown
    assert f"tie: {tied.reason}" in shown, shown


def test_the_title_is_what_a_calibration_says_where_that_is_not_the_label():
    found, pictures = scene(3, 4)
    label, other = found.label, found.runner_up
    for acceptance, accepted, title in (
        (Acceptance.RECOGNISED, (label,), label),
        (Acceptance.UNKNOWN, (), "Unknown"),
        (Acceptance.AMBIGUOUS, (label, other), f"Ambiguous: {label} or {other}"),
        (Acceptance.RECOGNISED, (other,), f"Recognised: {other}"),
    ):
        shown = words(
            recognition_picture(found, pictures, "svg", Judgement(acceptance, accepted, "a reason"))
        )
        assert title in shown, shown
        assert any(text.endswith(f"{acceptance.value} by the calibration") for text in shown), shown
        assert f"proved: lowest optimum of 4 objects: {label}" in shown, shown
        assert any(f"below the runner-up {other} · " in text for text in shown), shown


def test_views_that_are_nearest_to_another_object_say_so():
    objects = np.eye(6)[:, :2]
    X = np.array([[1.0, 0, 0, 0, 0, 0], [0.9, 0, 0, 0, 0, 0], [0, 0.5, 0, 0, 0, 0]])
    found = recognize(X, {"a": objects[:, 0], "b": objects[:, 1]}, lambda1=0.1, lambda2=0.1, lambda3=0.1)
    pictures = {view: np.zeros((8, 8, 3), dtype=np.uint8) for view in found.views}
    shown = words(recognition_picture(found, pictures, "svg"))
    assert (found.label, [text for text in shown if text.startswith("nearest")]) == ("a", ["nearest to b"])


def test_all_zero_is_drawn():
    found, pictures = scene(3, 2, lambda2=1e3)
    shown = words(recognition_picture(found, pictures, "svg"))
    assert shown.count("proved zero") == 6, shown


def test_digits_of_the_optimum_are_its_own():
    found, pictures = scene(3, 1)
    lower, upper = found.templates[0].interval
    shown = words(recognition_picture(found, pictures, "svg"))
    numbers = [text for text in shown if text.startswith(f"{upper:.6g}"[:6]) and len(text) >= 10]
    assert len(numbers) == 1, (upper, shown)
    assert abs(float(numbers[0]) - upper) <= max(10 * (upper - lower), 1e-10 * upper), (numbers, lower, upper)
    assert f"{upper - lower:.1e}" in shown, shown


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_the_same_recognition_gives_the_same_bytes(kind):
    found, pictures = scene(3, 2)
    first, second = (recognition_picture(found, pictures, kind) for _ in range(2))
    assert first == second
    assert b"dc:date" not in first


def test_long_and_odd_names_are_drawn_as_they_are():
    name = "$\\frac$ -- <b> & 車 " + "very " * 40 + "long"
    found, pictures = scene(2, 2, name=name)
    shown = words(recognition_picture(found, pictures, "svg"))
    assert any(text.startswith("$\\frac$ - - <b> &") and "…" in text for text in shown), shown
    assert all(len(text) < 160 for text in shown if not text.startswith("Warning")), shown


def test_names_without_a_glyph_stay_different_and_nothing_is_warned_of():
    found, pictures = scene(2, 2, name="車\n\u202e")
    for kind in ("png", "svg"):
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            drawn = recognition_picture(found, pictures, kind)
        assert not heard, heard
    shown = words(drawn)
    names = {f"\\u8eca\\n\\u202e {i}" for i in range(2)}
    assert names <= set(shown), shown


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_the_settings_of_the_caller_neither_matter_nor_change(kind):
    found, pictures = scene(3, 2)
    plain = recognition_picture(found, pictures, kind)
    theirs = {"axes.grid": True, "font.size": 20, "savefig.bbox": "tight", "axes.facecolor": "red"}
    theirs |= {"text.usetex": True, "svg.hashsalt": "theirs", "backend": "svg"}
    with mpl.rc_context():
        mpl.rcParams.update(theirs)
        before, filters = dict(mpl.rcParams), list(warnings.filters)
        assert recognition_picture(found, pictures, kind) == plain
        assert (dict(mpl.rcParams), warnings.filters) == (before, filters)
    mpl.rcParams["backend"] = "agg"


@pytest.mark.parametrize("backend", ["module://matplotlib_inline.backend_inline", "nonsense", "svg", ""])
def test_a_backend_of_the_environment_is_not_needed_and_stays(interpreter, backend):
    code = (
        f"import os, sys\nos.environ['MPLBACKEND'] = {backend!r}\n"
        "from convexperc.report.backend import load_matplotlib\nload_matplotlib()\n"
        "import convexperc.report.figure, matplotlib\n"
        "print(os.environ['MPLBACKEND'], matplotlib.get_backend(auto_select=False))\n"
        "print('matplotlib.pyplot' in sys.modules)"
    )
    done = interpreter.run(code)
    inline = backend if importlib.util.find_spec("matplotlib_inline") else None
    kept = {"svg": "svg", "": None, "nonsense": None}.get(backend, inline)
    assert done.stdout.splitlines() == [f"{backend} {kept}", "False"], done


def test_what_cannot_be_drawn_is_refused():
    found, pictures = scene(2, 2)
    with pytest.raises(InputError, match="robot 1"):
        recognition_picture(found, {"robot 0": pictures["robot 0"]}, "png")
    with pytest.raises(InputError, match="pdf"):
        recognition_picture(found, pictures, "pdf")
    with pytest.raises(InputError, match=r"\.png or \.svg"):
        picture_kind("out.pdf")
    assert [picture_kind(name) for name in ("a.b.PNG", "x.svg")] == ["png", "svg"]


def test_pyplot_and_its_global_state_stay_out(interpreter):
    code = "import sys, convexperc.report.figure; print('matplotlib.pyplot' in sys.modules)"
    done = interpreter.run(code)
    assert done.stdout.strip() == "False", done
