"""Frames as robots deliver them: BGR, shared buffers, masks, robots without a frame."""

import cv2
import numpy as np
import pytest
from test_references import KNOWN, LAMBDAS, QUICK, picture

from convexperc.errors import ImageError, InputError, RobotNameError
from convexperc.features import Region, as_rgb, extract
from convexperc.recognition import References, Verdict, perceive

REFERENCES = References.of(KNOWN, QUICK)
FRAMES = {"husky-1": picture("disc", 2), "husky-2": picture("disc", 3), "husky-3": picture("board", 5)}


def seen(views, references=REFERENCES, **options):
    """What decides, of every template, and the names of the robots."""
    found = perceive(views, references, **LAMBDAS, **options)
    return found.views, found.answers.lower.tolist(), found.answers.upper.tolist()


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_bgr_is_what_opencv_means_by_it(kind, channels):
    given = np.random.default_rng(0).integers(0, np.iinfo(kind).max, (9, 11, channels)).astype(kind)
    codes = {1: cv2.COLOR_GRAY2RGB, 3: cv2.COLOR_BGR2RGB, 4: cv2.COLOR_BGRA2RGBA}
    wanted = as_rgb(cv2.cvtColor(given, codes[channels]), "by OpenCV")
    found = as_rgb(given, "given", "BGR")
    assert np.array_equal(found, wanted)
    assert not found.flags.writeable
    if channels > 1:
        assert not np.array_equal(found, as_rgb(given, "given")), "the channels do not matter"


def test_frames_and_references_in_bgr_give_what_they_give_in_rgb():
    turned = {name: np.ascontiguousarray(each[..., ::-1]) for name, each in FRAMES.items()}
    known = References.of({name: each[..., ::-1] for name, each in KNOWN.items()}, QUICK, channels="BGR")
    assert np.array_equal(known.O, REFERENCES.O)
    assert seen(turned, known, channels="BGR") == seen(FRAMES)
    assert seen(turned) != seen(FRAMES)


def test_another_order_of_channels_is_refused(untyped):
    with pytest.raises(ImageError, match=r"channels must be 'RGB' or 'BGR'; got 'bgr8'"):
        perceive(FRAMES, REFERENCES, **LAMBDAS, channels="bgr8")


def test_frames_may_be_views_of_a_buffer_that_is_used_again():
    views = {}
    for name, frame in FRAMES.items():
        message = bytearray(frame.tobytes())  # as a ROS message has it
        views[name] = np.frombuffer(message, np.uint8).reshape(frame.shape)
        views[name].flags.writeable = False
    wanted = seen(FRAMES)
    assert seen(views) == wanted
    reversed_twice = {name: each[:, ::-1, ::-1].copy()[:, ::-1, ::-1] for name, each in FRAMES.items()}
    assert all(min(each.strides) < 0 for each in reversed_twice.values())
    assert seen(reversed_twice) == wanted
    message = bytearray(FRAMES["husky-1"].tobytes())
    view = np.frombuffer(message, np.uint8).reshape(FRAMES["husky-1"].shape)
    first = seen({"one": view})
    message[:] = FRAMES["husky-3"].tobytes()
    assert seen({"one": view}) == seen({"one": FRAMES["husky-3"]}) != first, "the frame before was kept"


def test_frames_without_names_are_called_by_their_places():
    names, *bounds = seen(list(FRAMES.values()))
    assert names == ("robot 1", "robot 2", "robot 3")
    assert bounds == list(seen(FRAMES)[1:])
    assert seen(np.stack(list(FRAMES.values())))[1:] == tuple(bounds)
    assert seen([None, FRAMES["husky-2"]])[0] == ("robot 2",)
    with pytest.raises(ImageError, match="must be several frames, not one"):
        perceive(FRAMES["husky-1"], REFERENCES, **LAMBDAS)


def test_a_robot_without_a_frame_is_left_out_by_name():
    found = perceive(FRAMES | {"husky-2": None}, REFERENCES, **LAMBDAS)
    alone = perceive({name: FRAMES[name] for name in ("husky-1", "husky-3")}, REFERENCES, **LAMBDAS)
    assert found.views == ("husky-1", "husky-3")
    assert np.array_equal(found.answers.upper, alone.answers.upper)
    assert found.warnings == (*alone.warnings, "robot 'husky-2' is left out: it has no usable frame")
    with pytest.raises(ImageError, match=r"the frame of one robot at least.*husky-1"):
        perceive(dict.fromkeys(FRAMES), REFERENCES, **LAMBDAS)


def test_a_robot_may_lose_its_frame_and_have_it_again_from_a_start():
    start, wanted = None, seen(FRAMES)
    for missing in ("", "husky-2", "husky-2", "husky-1", ""):
        start = perceive(
            FRAMES | dict.fromkeys([missing] if missing else []), REFERENCES, **LAMBDAS, start=start
        )
        assert start.verdict is Verdict.PROVED
        assert len(start.views) == len(FRAMES) - bool(missing)
    lower, upper = start.answers.lower, start.answers.upper
    assert (lower <= np.array(wanted[2])).all()
    assert (np.array(wanted[1]) <= upper).all()


def test_what_is_outside_of_a_region_is_cut_away():
    mask = np.zeros(FRAMES["husky-1"].shape[:2], dtype=bool)
    mask[4:30, 10:40] = True
    black = np.where(mask[..., None], FRAMES["husky-1"], 0).astype(np.uint8)
    wanted = seen(FRAMES | {"husky-1": black[4:30, 10:40]})
    assert wanted != seen(FRAMES)
    for given in (mask, mask.astype(np.uint8) * 255, mask[..., None], np.asfortranarray(mask)):
        assert seen(FRAMES, regions={"husky-1": given}) == wanted
    assert seen(FRAMES, regions={"husky-1": Region(10, 4, 30, 26)}) == wanted, "the mask is a rectangle"
    everything = {name: np.ones(frame.shape[:2], np.uint8) for name, frame in FRAMES.items()}
    assert seen(FRAMES, regions=everything) == seen(FRAMES)
    row = extract([black[4:30, 10:40]], QUICK)
    assert np.array_equal(perceive([FRAMES["husky-1"]], REFERENCES, **LAMBDAS, regions={"robot 1": mask})
                          .answers.data.views.X, row)  # fmt: skip


@pytest.mark.parametrize(
    ("mask", "said"),
    [
        (np.ones((48, 40), np.uint8), r"robot 'husky-2': mask must have the size of the picture, \(40, 48\)"),
        (np.ones((40, 48, 3), np.uint8), r"robot 'husky-2': mask must have the size of the picture"),
        (
            np.ones((40, 48)),
            r"robot 'husky-2': mask must be a NumPy array of bool or uint8, or a .*; got 'float64'",
        ),
        ([[True]], r"robot 'husky-2': mask must be .* Region\(x, y, width, height\); got 'list'"),
        ((1, 1, 20, 20), r"robot 'husky-2': mask must be .* Region\(x, y, width, height\); got 'tuple'"),
    ],
)
def test_a_mask_that_does_not_fit_is_refused_with_its_robot(untyped, mask, said):
    with pytest.raises(ImageError, match=said):
        perceive(FRAMES, REFERENCES, **LAMBDAS, regions={"husky-2": mask})


def test_robots_are_named_by_strings(untyped):
    with pytest.raises(RobotNameError, match="views must name robots by strings; got 1"):
        perceive({1: FRAMES["husky-1"]}, REFERENCES, **LAMBDAS)


def test_a_file_is_no_references(untyped):
    with pytest.raises(
        InputError, match=r"must be References; got 'known.safetensors'.*References.load\(path\)"
    ):
        perceive(FRAMES, "known.safetensors", **LAMBDAS)


def test_a_mask_for_a_robot_that_is_not_there_is_refused():
    mask = np.ones((40, 48), bool)
    with pytest.raises(RobotNameError, match=r"robots husky-1, husky-2, husky-3; got 'husky-9'"):
        perceive(FRAMES, REFERENCES, **LAMBDAS, regions={"husky-9": mask})
    without = perceive(FRAMES | {"husky-2": None}, REFERENCES, **LAMBDAS, regions={"husky-2": mask})
    assert without.views == ("husky-1", "husky-3"), "a robot that has lost its frame may keep its mask"


def test_a_frame_that_cannot_be_used_is_refused_with_its_robot(untyped):
    for frame in (FRAMES["husky-2"].astype(float), FRAMES["husky-2"][:4], "frame.png"):
        with pytest.raises(ImageError, match="the frame of robot 'husky-2' must"):
            perceive(FRAMES | {"husky-2": frame}, REFERENCES, **LAMBDAS)
    with pytest.raises(ImageError, match="the picture of reference 'cup/left' must"):
        References.of({"cup": {"left": KNOWN["disc"][:3]}, "box": KNOWN["board"]}, QUICK)
