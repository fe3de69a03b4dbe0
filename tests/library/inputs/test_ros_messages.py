"""Pictures in ROS messages, against OpenCV's and NumPy's own conversions."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from made_sources import jpeg, png

from convexperc.errors import ImageError
from convexperc.inputs.messages import ENCODINGS, compressed_picture, image_picture

RNG = np.random.default_rng(1)
RGB = RNG.integers(0, 256, (10, 13, 3), dtype=np.uint8)
GRAY = RGB[..., 0]
ALPHA = RNG.integers(0, 256, (10, 13, 1), dtype=np.uint8)


def message(pixels, kind, *, padding=0, big=False, **changes):
    """An Image message of an array (h, w) or (h, w, c) of uint8 or uint16."""
    height, width = pixels.shape[:2]
    stored = pixels.astype(f"{'>' if big else '<'}u{pixels.dtype.itemsize}")
    rows = np.frombuffer(np.ascontiguousarray(stored).tobytes(), np.uint8).reshape(height, -1)
    padded = np.pad(rows, ((0, 0), (0, padding)), constant_values=99)
    fields = {
        "height": height, "width": width, "encoding": kind, "is_bigendian": int(big),
        "step": padded.shape[1], "data": padded.reshape(-1),
    }  # fmt: skip
    return SimpleNamespace(**(fields | changes))


def deep(pixels):
    """16 bits of which the upper 8 are the picture."""
    return pixels.astype(np.uint16) * 256 + RNG.integers(0, 256, pixels.shape, dtype=np.uint16)


ARRAYS = {
    "rgb": (RGB, RGB),
    "bgr": (RGB[..., ::-1], RGB),
    "rgba": (np.concatenate([RGB, ALPHA], axis=2), RGB),
    "bgra": (np.concatenate([RGB[..., ::-1], ALPHA], axis=2), RGB),
    "mono": (GRAY, np.stack([GRAY] * 3, axis=2)),
}


@pytest.mark.parametrize("padding", [0, 3])
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("kind", ARRAYS)
def test_every_order_depth_and_padding_gives_the_same_picture(kind, depth, big, padding):
    stored, expected = ARRAYS[kind]
    made = message(deep(stored) if depth == 16 else stored, f"{kind}{depth}", padding=padding, big=big)
    np.testing.assert_array_equal(image_picture(made, "x"), expected)


@pytest.mark.parametrize(
    ("encoding", "stored", "expected"),
    [
        ("8UC1", GRAY, ARRAYS["mono"][1]),
        ("8UC3", RGB[..., ::-1], RGB),
        ("16UC1", deep(GRAY), ARRAYS["mono"][1]),
    ],
)
def test_opencv_names_of_encodings(encoding, stored, expected):
    np.testing.assert_array_equal(image_picture(message(stored, encoding), "x"), expected)


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_mosaic_of_one_colour_gives_that_colour(pattern, depth):
    """The pattern's letters are the colours of the upper left 2 x 2 pixels, row by row."""
    colour = dict(zip("rgb", (200, 120, 40), strict=True))
    tile = np.array([colour[letter] for letter in pattern], dtype=np.uint8).reshape(2, 2)
    mosaic = np.tile(tile, (6, 8))
    stored = deep(mosaic) // 256 * 256 if depth == 16 else mosaic
    made = image_picture(message(stored, f"bayer_{pattern}{depth}"), "x")
    np.testing.assert_array_equal(made, np.broadcast_to(np.array([200, 120, 40]), made.shape))


@pytest.mark.parametrize(
    ("yuv", "rgb"),
    [
        ((16, 128, 128), (0, 0, 0)), ((235, 128, 128), (255, 255, 255)), ((126, 128, 128), (128, 128, 128)),
        ((81, 90, 240), (255, 0, 0)), ((145, 54, 34), (0, 255, 0)), ((41, 240, 110), (0, 0, 255)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ["yuv422", "uyvy", "yuv422_yuy2", "yuyv"])
def test_colour_bars_of_the_standard(encoding, yuv, rgb):
    """Digital values of ITU-R BT.601 at 100 %, which it rounds to whole numbers."""
    y, u, v = yuv
    two = [u, y, v, y] if encoding in ("yuv422", "uyvy") else [y, u, y, v]
    stored = np.tile(np.array(two, dtype=np.uint8).reshape(2, 2), (8, 6, 1))
    made = image_picture(message(stored, encoding, padding=5), "x")
    assert made.shape == (8, 12, 3)
    assert np.abs(made.astype(int) - rgb).max() <= 2


def test_each_pixel_has_its_own_luma():
    y = RNG.integers(16, 236, (8, 12), dtype=np.uint8)
    for encoding, place in (("yuv422", 1), ("yuyv", 0)):
        stored = np.full((8, 12, 2), 128, dtype=np.uint8)
        stored[..., place] = y
        wanted = np.rint((y.astype(float) - 16) * 255 / 219)
        made = image_picture(message(stored, encoding), "x")
        assert np.abs(made - wanted[..., None]).max() <= 1


def test_an_odd_width_of_pairs_is_refused():
    stored = np.full((8, 13, 2), 128, dtype=np.uint8)
    with pytest.raises(ImageError, match="width must be a multiple of 2 with the encoding yuyv"):
        image_picture(message(stored, "yuyv"), "x")


def test_the_list_of_encodings_is_what_the_documents_say():
    assert set(ENCODINGS) == {
        *(f"{kind}{depth}" for kind in ARRAYS for depth in (8, 16)),
        *(f"bayer_{p}{depth}" for p in ("rggb", "bggr", "gbrg", "grbg") for depth in (8, 16)),
        "8UC1", "8UC3", "16UC1", "yuv422", "uyvy", "yuv422_yuy2", "yuyv",
    }  # fmt: skip


@pytest.mark.parametrize("encoding", ["32FC1", "nv12", "nv21", "16SC1", "", "RGB8"])
def test_other_encodings_are_refused_by_name(encoding):
    with pytest.raises(ImageError, match="encoding must be one of") as caught:
        image_picture(message(GRAY, "mono8", encoding=encoding), "topic /a")
    assert caught.value.value == encoding


def test_rows_that_are_short_or_missing_are_refused():
    with pytest.raises(ImageError, match="step must be at least 39 bytes"):
        image_picture(message(RGB, "rgb8", step=38), "x")
    with pytest.raises(ImageError, match="truncated"):
        image_picture(message(RGB, "rgb8", data=message(RGB, "rgb8").data[:-1]), "x")
    with pytest.raises(ImageError, match="truncated"):
        image_picture(message(RGB, "rgb8", data=np.empty(0, np.uint8)), "x")
    with pytest.raises(ImageError, match="sides"):
        image_picture(message(RGB, "rgb8", height=0), "x")
    with pytest.raises(ImageError, match="sides"):
        image_picture(message(RGB, "rgb8", height=2**20, width=2**20), "x")


def test_the_last_row_may_end_without_its_padding():
    made = message(RGB, "rgb8", padding=5)
    made.data = made.data[:-5]
    np.testing.assert_array_equal(image_picture(made, "x"), RGB)


def compressed(data, stated):
    return SimpleNamespace(format=stated, data=np.frombuffer(data, np.uint8))


@pytest.mark.parametrize("stated", ["png", "rgb8; png compressed bgr8", "bgr8; png compressed bgr8", ""])
def test_a_compressed_png_is_what_was_compressed(stated):
    np.testing.assert_array_equal(compressed_picture(compressed(png(RGB), stated), "x"), RGB)


def test_red_and_blue_are_exchanged_where_the_format_says_so():
    made = compressed_picture(compressed(png(RGB), "rgb8; png compressed rgb8"), "x")
    np.testing.assert_array_equal(made, RGB[..., ::-1])
    gray = compressed_picture(compressed(png(GRAY), "mono8; png compressed rgb8"), "x")
    np.testing.assert_array_equal(gray, ARRAYS["mono"][1])


@pytest.mark.parametrize("alpha", [0, 128, 255])
def test_the_alpha_of_a_camera_is_left_out_compressed_or_not(alpha):
    """Also where it is 0 everywhere, as some cameras have it."""
    pixels = np.dstack([RGB[..., ::-1], np.full(RGB.shape[:2], alpha, np.uint8)])
    data = np.frombuffer(cv2.imencode(".png", pixels)[1].tobytes(), np.uint8)
    packed = SimpleNamespace(format="bgra8; png compressed bgra8", data=data)
    np.testing.assert_array_equal(compressed_picture(packed, "x"), RGB)
    np.testing.assert_array_equal(image_picture(message(pixels, "bgra8"), "x"), RGB)


def test_data_may_be_bytes():
    """As rospy and some readers of bags give it."""
    for made in (message(RGB, "rgb8"), message(deep(GRAY), "mono16")):
        same = SimpleNamespace(**{**vars(made), "data": made.data.tobytes()})
        np.testing.assert_array_equal(image_picture(same, "x"), image_picture(made, "x"))


def test_a_compressed_jpeg_is_near_what_opencv_decodes():
    smooth = cv2.resize(RGB, (64, 48), interpolation=cv2.INTER_CUBIC)
    data = jpeg(smooth)
    made = compressed_picture(compressed(data, "rgb8; jpeg compressed bgr8"), "x")
    other = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert np.abs(made.astype(int) - other).max() <= 3


@pytest.mark.parametrize(
    "stated", ["16UC1; compressedDepth png", "32FC1; compressedDepth", "16UC1; compressedDepth rvl"]
)
def test_a_compressed_depth_is_refused_by_its_format(stated):
    with pytest.raises(ImageError, match="a depth has no colors"):
        compressed_picture(compressed(png(GRAY), stated), "x")


@pytest.mark.parametrize("data", [b"", b"\xff\xd8\xff\xe0", png(RGB)[:100], jpeg(RGB)[:-2], b"text"])
def test_an_empty_cut_or_foreign_picture_is_refused(data):
    with pytest.raises(ImageError):
        compressed_picture(compressed(data, "jpeg"), "x")
