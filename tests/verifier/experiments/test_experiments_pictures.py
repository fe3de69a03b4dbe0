"""Where the experiments' pictures come from: folders of simulated sets, and photographs with obstacles."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from made_up_pictures import COLOURS, drawn, picture_set, write_folder

from convexperc.errors import ConvexpercError, FileFormatError, ImageError, InputError
from verification.experiments.measure.features import without_background
from verification.experiments.scenes.folder import read_case_study, read_physical
from verification.experiments.scenes.obstacles import cover_fully, cover_partly
from verification.experiments.scenes.photos import SCENES, draw_photographs
from verification.experiments.scenes.pictures import CASE_STUDY, LEVELS, PictureSet, Scene, View

OBJECTS = ("red", "green")


# ---------- folders


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_folder(tmp_path / "set", picture_set(OBJECTS, levels=True))


def change(folder: Path, alter: object) -> None:
    place = folder / "manifest.json"
    manifest = json.loads(place.read_text())
    alter(manifest)
    place.write_text(json.dumps(manifest))


def test_a_folder_is_read_as_it_was_written(folder: Path, tmp_path: Path) -> None:
    wanted, found = picture_set(OBJECTS, levels=True), read_physical(folder)
    assert found.layout == wanted.layout, "the digest is over pictures, masks and all that is known of them"
    pairs = zip(found.pictures, wanted.pictures, strict=True)
    assert all(np.array_equal(one, other) for one, other in pairs)
    study = picture_set(OBJECTS, levels=False)
    assert read_case_study(write_folder(tmp_path / "study", study)).layout == study.layout


def test_a_changed_picture_is_seen(folder: Path) -> None:
    place = folder / "views" / "red-2" / "robot-3.png"
    picture = cv2.imread(str(place))
    picture[0, 0, 0] ^= 1
    cv2.imwrite(str(place), picture)
    with pytest.raises(FileFormatError, match=r"robot-3\.png must have the hash"):
        read_physical(folder)


@pytest.mark.parametrize(
    ("alter", "message"),
    [
        (lambda m: m.update(set="case-study"), "the other set"),
        (lambda m: m.update(format=2), "format 1"),
        (lambda m: m["scenes"][0].pop("object"), "KeyError: 'object'"),
        (lambda m: m["scenes"][0].update(level="two full"), "must be one of none"),
        (lambda m: m["scenes"][0].update(level="one full"), "as its level"),
        (lambda m: m["scenes"][0]["views"].pop(), "must have 6 views"),
        (lambda m: m["scenes"][0]["views"][0].update(visible_share=0.5), "must be 'partial'"),
        (lambda m: m["scenes"][1].update(name=m["scenes"][0]["name"]), "all named differently"),
        (lambda m: m["scenes"][0].update(object="pink"), "must be one of red, green"),
        (lambda m: m["scenes"][0]["views"][0].update(file="nowhere.png"), "must be there"),
    ],
)
def test_a_wrong_manifest_is_told(folder: Path, alter: object, message: str) -> None:
    change(folder, alter)
    with pytest.raises(ConvexpercError, match=message):
        read_physical(folder)


def test_an_unfinished_folder_is_told(folder: Path) -> None:
    (folder / "manifest.json").unlink()
    with pytest.raises(FileFormatError, match="has finished"):
        read_physical(folder)


@pytest.mark.parametrize(
    ("azimuth", "name", "good"),
    [(40, "sign", True), (-41, "sign", False), (175, "sign", False), (175, "red-car", True)],
)
def test_a_good_view_is_clear_and_from_a_side_that_tells(
    tmp_path: Path, azimuth: float, name: str, good: bool
) -> None:
    place = write_folder(tmp_path / "set", picture_set(OBJECTS, levels=False))

    def alter(manifest: dict) -> None:
        for each in [*manifest["references"], *manifest["scenes"]]:
            each["object"] = name if each["object"] == "red" else each["object"]
        for view in manifest["scenes"][0]["views"]:
            view["azimuth"] = azimuth

    change(place, alter)
    if good:
        assert sum(view.good for view in read_case_study(place).layout.scenes[0].views) == 3
    else:
        with pytest.raises(FileFormatError, match="3 of them clear"):
            read_case_study(place)


def test_pictures_and_layout_must_fit() -> None:
    found = picture_set(OBJECTS, levels=False)
    with pytest.raises(InputError, match="must be 12 each"):
        PictureSet(found.layout, found.pictures[1:], found.masks)
    with pytest.raises(InputError, match="size of its picture"):
        PictureSet(found.layout, found.pictures, (found.masks[0][1:], *found.masks[1:]))
    with pytest.raises(InputError, match="all named differently"):
        Scene("twice", "red", "none", (View("a", 1.0), View("a", 1.0)))
    with pytest.raises(InputError, match=r"must be 0\.\.1"):
        View("a", 1.5)


def test_without_background_only_the_object_is_left() -> None:
    picture, mask = drawn("red", "partial", np.random.default_rng(0))
    found = without_background(picture, mask)
    assert (found[~mask] == 128).all()
    assert np.array_equal(found[mask], picture[mask])


# ---------- photographs


def album(folder: Path, names: list[str], *, masks: bool = True) -> Path:
    rng = np.random.default_rng(0)
    for name in COLOURS:
        (folder / name / "masks").mkdir(parents=True)
        for view in names:
            picture, mask = drawn(name, "none", rng)
            cv2.imwrite(str(folder / name / f"{view}.png"), picture[..., ::-1])
            if masks:
                cv2.imwrite(str(folder / name / "masks" / f"{view}.png"), mask.astype(np.uint8) * 255)
    return folder


AZIMUTHS = [f"{azimuth:03d}" for azimuth in range(10, 360, 20)]


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return album(tmp_path_factory.mktemp("photographs"), AZIMUTHS)


def test_photographs_are_drawn_by_level(photographs: Path) -> None:
    physical, study = draw_photographs(photographs, 0)
    scenes = physical.layout.scenes
    assert len(scenes) == len(COLOURS) * len(LEVELS) * SCENES
    for scene in scenes:
        partial, full = LEVELS[scene.level]
        shares = [view.visible_share for view in scene.views]
        assert len({view.azimuth for view in scene.views}) == 6, "six different photographs"
        named = [f"{scene.object}/{int(view.azimuth + 90) % 360:03d}" for view in scene.views]
        assert [view.photograph for view in scene.views] == named, "what is resampled"
        assert 0.0 not in {view.azimuth for view in scene.views}, "never the reference"
        assert sum(share == 0.0 for share in shares) == full, scene
        assert sum(0.25 <= share <= 0.75 for share in shares) == partial, scene
        assert sum(share == 1.0 for share in shares) == 6 - partial - full, scene
    assert physical.source["references"] == dict.fromkeys(sorted(COLOURS), "090")
    assert len(study.layout.scenes) == len(COLOURS) * SCENES


def test_a_case_study_of_photographs_has_three_good_views(photographs: Path) -> None:
    kinds = set()
    for scene in draw_photographs(photographs, 0)[1].layout.scenes:
        assert scene.level == CASE_STUDY
        good = [view for view in scene.views if view.good]
        other = [view for view in scene.views if not view.good]
        assert (len(good), len(other)) == (3, 2)
        assert all(abs(view.azimuth) <= 45 and view.obstruction == "none" for view in good), scene
        assert all(abs(view.azimuth) > 90 or view.obstruction == "full" for view in other), scene
        kinds |= {view.obstruction for view in other}
    assert kinds == {"none", "full"}


def test_the_seed_decides(photographs: Path) -> None:
    digests = [draw_photographs(photographs, seed)[0].layout.digest for seed in (0, 0, 1)]
    assert digests[0] == digests[1] != digests[2]


def test_without_azimuths_and_masks_the_middle_is_the_object(tmp_path: Path) -> None:
    place = album(tmp_path, [f"view-{letter}" for letter in "abcdefgh"], masks=False)
    physical, study = draw_photographs(place, 0)
    assert physical.source["references"] == dict.fromkeys(sorted(COLOURS), "view-a")
    assert physical.masks[0].sum() == 26 * 26
    assert all(view.azimuth is None for scene in study.layout.scenes for view in scene.views)
    assert all(sum(view.good for view in scene.views) == 3 for scene in study.layout.scenes)


def test_bad_albums_are_told(tmp_path: Path) -> None:
    place = album(tmp_path / "few", AZIMUTHS[:6])
    with pytest.raises(InputError, match="at least 7 pictures"):
        draw_photographs(place, 0)
    with pytest.raises(ImageError, match="must be readable"):
        draw_photographs(tmp_path / "nowhere", 0)
    (tmp_path / "one" / "red").mkdir(parents=True)
    with pytest.raises(InputError, match="at least two objects"):
        draw_photographs(tmp_path / "one", 0)
    place = album(tmp_path / "behind", [f"{azimuth:03d}" for azimuth in (90, 180, 200, 220, 240, 260, 280)])
    with pytest.raises(InputError, match="within 45 degrees"):
        draw_photographs(place, 0)
    place = album(tmp_path / "mask", AZIMUTHS)
    cv2.imwrite(str(place / "red" / "masks" / "010.png"), np.zeros((32, 32), dtype=np.uint8))
    with pytest.raises(ImageError, match="show something"):
        draw_photographs(place, 0)


def test_obstacles_cover_what_they_say() -> None:
    picture, mask = drawn("blue", "none", np.random.default_rng(1))
    for seed in range(30):
        rng = np.random.default_rng(seed)
        full, partial = cover_fully(picture, mask, rng), cover_partly(picture, mask, rng)
        assert not full.mask.any()
        assert full.visible_share == 0.0
        assert partial.visible_share == partial.mask.sum() / mask.sum()
        assert 0.25 <= partial.visible_share <= 0.75
        untouched = (partial.picture == picture).all(axis=2)
        assert untouched[partial.mask].all(), "what is still seen is as it was"
        assert not untouched[mask & ~partial.mask].all()
    with pytest.raises(InputError, match="large enough"):
        cover_partly(picture, np.arange(32 * 32).reshape(32, 32) == 500, np.random.default_rng(0))
