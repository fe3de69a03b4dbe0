"""From pictures to recognition: names, folders, references, and the sample."""

from importlib.resources import files

import cv2
import numpy as np
import pytest

from convexperc import TemplateLibrary
from convexperc.errors import (
    ConvexpercError,
    FeatureError,
    FileFormatError,
    ImageError,
    InputError,
    PictureWarning,
)
from convexperc.features import FeatureConfiguration, extract
from convexperc.recognition import decided_by, recognize
from convexperc.recognition.recognition import Verdict
from convexperc.recognition.references import References, left_out, perceive, read_pictures
from convexperc.recognition.sample import sample_names, sample_scene

QUICK = FeatureConfiguration(
    working_size=(32, 32), color_bins=8, hog_pixels_per_cell=(8, 8), lbp_points=8, lbp_radius=1.0, lbp_bins=10
)
LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}


def picture(kind, shift=0):
    """Stripes, a disc or a chequerboard in red, green or blue, without randomness."""
    rows, columns = np.mgrid[:40, :48]
    shapes = {
        "stripes": (columns + shift) // 6 % 2,
        "disc": (rows - 20) ** 2 + (columns - 24 - shift) ** 2 < 180,
        "board": ((rows + shift) // 8 + columns // 8) % 2,
    }
    planes = np.full((40, 48, 3), 30 + shift, dtype=np.uint8)
    planes[..., list(shapes).index(kind)] += (180 * shapes[kind]).astype(np.uint8)
    return planes


def save(folder, name, kind, shift=0):
    folder.mkdir(exist_ok=True)
    done, data = cv2.imencode(name[name.rindex(".") :], picture(kind, shift)[..., ::-1])
    assert done, name
    (folder / name).write_bytes(data.tobytes())


NAMES = [
    "Screenshot 2024-05-01 at 9.41.00\u202fAM",
    "no\u00a0break",
    "全角\u3000空白",
    "👩\u200d🚀",
    "line\nbreak",
    "\x1b[31mred",
    "\u202egnp.elif",
    "byte\udce9",
]
"""Names of files: of macOS and of emoji; and such as would change what is printed, or are no UTF-8."""
KNOWN = {kind: picture(kind) for kind in ("stripes", "disc", "board")}


def test_each_reference_is_a_column_and_the_views_find_theirs():
    references = References.of(KNOWN, QUICK)
    assert references.names == ("stripes", "disc", "board")
    assert references.O.shape == (sum(QUICK.modality_sizes.values()), 3)
    assert not references.O.flags.writeable
    for j, kind in enumerate(references.names):
        assert np.array_equal(references.O[:, j], extract([KNOWN[kind]], QUICK)[0]), kind
        views = {"left": picture(kind, 2), "right": picture(kind, 3)}
        found = perceive(views, references, **LAMBDAS)
        assert (found.verdict, found.label) == (Verdict.PROVED, kind), (kind, found.label, found.reason)
        assert found.views == ("left", "right")
        assert found.templates[0].solution.problem.modalities.names == ("color", "hog", "lbp")


def test_one_view_is_enough_and_no_view_is_not():
    references = References.of(KNOWN, QUICK)
    assert perceive({"only": picture("disc", 2)}, references, **LAMBDAS).label == "disc"
    with pytest.raises(FeatureError, match="at least one picture"):
        perceive({}, references, **LAMBDAS)


def test_views_of_one_color_are_named_in_a_warning_also_under_another_decision():
    references = References.of(KNOWN, QUICK)
    black, white = np.zeros((40, 40, 3), np.uint8), np.full((40, 40), 255, np.uint8)
    views = {"ann": picture("disc", 2), "bob": black, "cid": picture("disc", 3), "dan": white}
    found = perceive(views, references, **LAMBDAS, prune=False)
    said = [each for each in found.warnings if "of one color are the views of bob, dan:" in each]
    assert len(said) == 1, found.warnings
    assert said[0] in decided_by(found, "explained fraction").warnings
    alone = perceive({"ann": views["ann"]}, references, **LAMBDAS)
    assert not [each for each in alone.warnings if "color" in each]


def test_references_of_one_color_are_named_in_a_warning():
    known = {**KNOWN, "night": {"a": KNOWN["disc"], "b": np.zeros((40, 40), np.uint8)}}
    with pytest.warns(PictureWarning, match="of one color are the references night/b: they show nothing"):
        References.of(known, QUICK)


def test_robots_without_features_are_named_in_a_warning():
    X = np.vstack([np.zeros((2, 600)), np.ones(600)])
    X[1, 599] = 1e-300
    objects = {"a": np.ones(600), "b": np.r_[np.ones(599), 2.0]}
    found = recognize(X, objects, views=("ann", "bob", "cid"), **LAMBDAS)
    assert "all features are 0 of ann: such a view shows nothing" in found.warnings


def test_what_a_folder_of_scenes_leaves_out_is_named(tmp_path):
    for place in ("cup/one/a.png", "cup/one/b.gif", "cup/loose.png", "top.jpg", "cup/one/more/c.png"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_bytes(b"x")
    (tmp_path / "box").mkdir()
    (tmp_path / "notes.txt").write_text("x")
    assert set(left_out(tmp_path, scenes=True)) == {
        "notes.txt (no picture by its name)",
        "top.jpg (a picture outside of a scene)",
        "box (a folder without a scene)",
        "cup/loose.png (a picture outside of a scene)",
        "cup/one/b.gif (GIF is not read; convert it to PNG)",
        "cup/one/more (a folder)",
    }


def test_one_reference_is_refused():
    with pytest.raises(InputError, match=r"at least two objects.*recognised in any view"):
        References.of({"disc": KNOWN["disc"]}, QUICK)


RECORD = QUICK.to_dict()
FOREIGN = {
    "nothing": ({}, "more must hold the configuration of its features, as References.save writes it"),
    "null": ({"features": None}, "feature configuration must be a mapping .* got None"),
    "a list": ({"features": [1]}, r"feature configuration must be a mapping .* got \[1\]"),
    "a string": ({"features": "QUICK"}, "feature configuration must be a mapping"),
    "a part of another type": ({"features": {**RECORD, "color_bins": True}}, "color_bins must be an integer"),
    "a part that is a list": ({"features": {**RECORD, "normalisation": [1]}}, "normalisation must be one of"),
    "a huge number": ({"features": {**RECORD, "lbp_radius": 10**400}}, "lbp_radius must be a finite number"),
    "a network of another type": ({"features": {**RECORD, "network": [1]}}, "network must be a mapping"),
    "other features": ({"features": {**RECORD, "color_bins": 4}}, "modalities"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_a_library_with_other_features_than_it_says_is_refused(tmp_path, name):
    more, said = FOREIGN[name]
    References.of(KNOWN, QUICK).library.save(tmp_path / "known", more)
    with pytest.raises(FileFormatError, match=said):
        References.load(tmp_path / "known")


def test_a_file_of_one_object_is_refused(tmp_path):
    library = References.of(KNOWN, QUICK).library
    one = TemplateLibrary({"disc": library.O.T[:2]}, modalities=library.modalities)
    References(one, QUICK).save(tmp_path / "known")
    with pytest.raises(FileFormatError, match=r"objects must name at least two objects.*got \['disc'\]"):
        References.load(tmp_path / "known")


def test_equal_references_tie():
    references = References.of({"a": KNOWN["disc"], "b": KNOWN["disc"], "c": KNOWN["board"]}, QUICK)
    found = perceive({"only": picture("disc", 2)}, references, **LAMBDAS)
    assert (found.verdict, found.label, set(found.candidates)) == (Verdict.TIE, None, {"a", "b"})


def test_a_folder_names_its_pictures_by_their_stems(tmp_path):
    save(tmp_path, "b.car.png", "disc")
    save(tmp_path, "a [red] $x$.bmp", "board")
    (tmp_path / "notes.txt").write_text("no picture")
    found = read_pictures(tmp_path)
    assert list(found) == ["a [red] $x$", "b.car"]
    assert np.array_equal(found["b.car"], picture("disc"))


def test_two_files_of_one_stem_are_refused_by_name(tmp_path):
    save(tmp_path, "car.png", "disc")
    save(tmp_path, "car.jpg", "board")
    with pytest.raises(ImageError, match=r"car\.png must not have the stem of car\.jpg"):
        read_pictures(tmp_path)


@pytest.mark.parametrize("stem", NAMES)
def test_every_name_of_a_file_is_a_name(tmp_path, stem):
    save(tmp_path, "fine.png", "disc")
    (tmp_path / "fine.png").rename(tmp_path / f"{stem}.png")
    assert list(read_pictures(tmp_path)) == [stem]


def test_empty_and_absent_folders_are_refused(tmp_path):
    for folder in (tmp_path, tmp_path / "absent"):
        with pytest.raises(ImageError, match="folder"):
            read_pictures(folder)


def test_the_sample_holds_what_its_record_says():
    names = sample_names()
    assert set(names) == {"red-car", "gray-car", "ica-sign"}
    for name in names:
        scene = sample_scene(name)
        assert list(scene.references) == list(names), (name, list(scene.references))
        assert list(scene.views) == [f"robot-{i}" for i in range(1, 6)], (name, list(scene.views))
        for other, found in scene.references.items():
            place = files("convexperc") / "sample" / "references" / f"{other}.png"
            wanted = cv2.imdecode(np.frombuffer(place.read_bytes(), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
            assert np.array_equal(found, wanted), (name, other)
        pictures = [*scene.references.values(), *scene.views.values()]
        assert len({p.tobytes() for p in pictures}) == len(pictures), name
        assert all(p.dtype == np.uint8 and p.shape[2] == 3 for p in pictures)
    with pytest.raises(ConvexpercError, match="nowhere"):
        sample_scene("nowhere")
