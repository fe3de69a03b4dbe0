"""Pictures: what a file's bytes must become, and which bytes must be refused."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import ImageFile
from PIL.WebPImagePlugin import WebPImageFile

from convexperc.errors import ImageError
from convexperc.features.decoding.sizes import MAX_PIXELS, MIN_SIDE
from convexperc.features.pictures import as_rgb, is_flat, list_images, read_image, resize, to_gray

SIDES = st.integers(MIN_SIDE, 24)
SEEDS = st.integers(0, 2**32 - 1)
LOSSLESS = {".png": [], ".bmp": [], ".tif": [], ".webp": [cv2.IMWRITE_WEBP_QUALITY, 101]}


@st.composite
def pictures(draw, channels=3, dtype=np.uint8):
    """Noise over the whole range, or over a few values including both ends."""
    shape = (draw(SIDES), draw(SIDES), *((channels,) if channels > 1 else ()))
    top, levels, seed = np.iinfo(dtype).max, draw(st.sampled_from([1, 2, 4, 256])), draw(SEEDS)
    values = np.linspace(0, top, levels).astype(dtype) if levels < 256 else np.arange(top + 1, dtype=dtype)
    return np.random.default_rng(seed).choice(values, shape)


def scene(height=40, width=56):
    """A picture with edges and shades, without randomness."""
    rows, columns = np.mgrid[:height, :width]
    planes = [(rows * 5) % 256, (columns * 4) % 256, ((rows // 7 + columns // 9) % 2) * 200]
    return np.stack(planes, axis=2).astype(np.uint8)


def encode(suffix, rgb, flags=()):
    order = {2: [0, 1, 2], 3: [2, 1, 0], 4: [2, 1, 0, 3]}[rgb.shape[2] if rgb.ndim == 3 else 2]
    stored = rgb if rgb.ndim == 2 else np.ascontiguousarray(rgb[..., order])
    done, data = cv2.imencode(suffix, stored, list(flags))
    assert done, (suffix, rgb.shape, rgb.dtype)
    return data.tobytes()


def read(folder, data, name="picture.bin"):
    path = Path(folder) / name
    path.write_bytes(data)
    return read_image(path)


def refusal(folder, data, name="picture.bin"):
    """Message of the error that reading `data` must raise."""
    with pytest.raises(ImageError) as caught:
        read(folder, data, name)
    assert name in str(caught.value), (name, str(caught.value))
    return str(caught.value)


def orientation_tiff(orientation):
    return b"II*\0" + struct.pack("<IHHHIHHI", 8, 1, 0x112, 3, 1, orientation, 0, 0)


def with_exif(jpeg, orientation, thumbnail=b""):
    payload = b"Exif\0\0" + orientation_tiff(orientation) + thumbnail
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(payload) + 2) + payload + jpeg[2:]


def png(height, width, kind, rows, extra=b""):
    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0))
    pixels = chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows)))
    transparency = chunk(b"tRNS", extra) if extra else b""
    return b"\x89PNG\r\n\x1a\n" + header + transparency + pixels + chunk(b"IEND", b"")


def tiff(rgb, orientation=1, order="<", declared=None):
    """An uncompressed RGB TIFF; `declared` overrides the (height, width) that it states."""
    height, width = declared or rgb.shape[:2]
    entries = [(256, 4, width), (257, 4, height), (258, 3, 8), (259, 3, 1), (262, 3, 2), (273, 4, 8)]
    entries += [(274, 3, orientation), (277, 3, 3), (278, 4, height), (279, 4, rgb.size), (284, 3, 1)]
    directory = struct.pack(order + "H", len(entries))
    for tag, kind, value in entries:
        packed = struct.pack(order + ("HH" if kind == 3 else "I"), *((value, 0) if kind == 3 else (value,)))
        directory += struct.pack(order + "HHI", tag, kind, 1) + packed
    start = b"II*\0" if order == "<" else b"MM\0*"
    return start + struct.pack(order + "I", 8 + rgb.size) + rgb.tobytes() + directory + b"\0\0\0\0"


TURNS = {
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
    8: np.rot90,
}


@pytest.mark.parametrize("suffix", LOSSLESS)
@given(rgb=pictures())
@settings(deadline=None, max_examples=25)
def test_lossless_files_give_back_their_pixels(tmp_path_factory, suffix, rgb):
    found = read(tmp_path_factory.getbasetemp(), encode(suffix, rgb, LOSSLESS[suffix]), f"same{suffix}")
    assert np.array_equal(found, rgb), (suffix, found, rgb)
    assert not found.flags.writeable, found.flags


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".tif"])
def test_a_gray_file_has_equal_channels(tmp_path, suffix):
    gray = scene()[..., 0]
    found = read(tmp_path, encode(suffix, gray))
    assert np.array_equal(found, np.stack([gray] * 3, axis=2)), (suffix, found[:2], gray[:2])


def test_a_gray_jpeg_has_equal_channels_and_a_color_jpeg_is_close(tmp_path):
    gray = read(tmp_path, encode(".jpg", scene()[..., 1], [cv2.IMWRITE_JPEG_QUALITY, 100]))
    worst = np.abs(gray.astype(int) - scene()[..., 1:2]).max()
    assert worst <= 3, worst
    assert np.array_equal(gray[..., 0], gray[..., 2]), gray[:2]
    smooth = cv2.GaussianBlur(scene(), (0, 0), 3)
    error = np.abs(
        read(tmp_path, encode(".jpg", smooth, [cv2.IMWRITE_JPEG_QUALITY, 100])).astype(int) - smooth
    )
    assert error.mean() < 3, error.mean()


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize("channels", [1, 3])
@given(data=st.data())
@settings(deadline=None, max_examples=15)
def test_sixteen_bits_lose_their_low_byte(tmp_path_factory, suffix, channels, data):
    deep = data.draw(pictures(channels, np.uint16))
    found = read(tmp_path_factory.getbasetemp(), encode(suffix, deep), f"deep{channels}{suffix}")
    expected = (deep // 256).reshape(*deep.shape[:2], -1)
    assert (found == expected).all(), (found, deep)


@given(rgb=pictures(), factor=st.sampled_from([256, 257]), order=st.sampled_from("<>"))
@settings(deadline=None, max_examples=50)
def test_eight_bits_stored_as_sixteen_come_back(rgb, factor, order):
    deep = (rgb.astype(np.uint16) * factor).astype(order + "u2")
    found = as_rgb(deep, "deep")
    assert np.array_equal(found, rgb), (factor, order, found, rgb)


@given(rgba=pictures(4))
@settings(deadline=None, max_examples=50)
def test_alpha_is_composited_on_black_to_the_nearest_integer(rgba):
    found = as_rgb(rgba, "rgba").astype(int)
    color, alpha = rgba[..., :3].astype(int), rgba[..., 3:].astype(int)
    off = np.abs(255 * found - color * alpha)
    assert off.max() <= 127, (off.max(), rgba, found)
    deep = as_rgb(rgba.astype(np.uint16) * 257, "rgba")
    assert np.array_equal(deep, found), (deep, found)


@pytest.mark.parametrize("suffix", [".png", ".webp"])
def test_alpha_of_a_file_is_composited(tmp_path, suffix):
    rgba = np.dstack([scene(), (scene()[..., 0] // 2 + 100)])
    found = read(tmp_path, encode(suffix, rgba, LOSSLESS[suffix]))
    assert np.array_equal(found, as_rgb(rgba, "rgba")), (suffix, found[:2], rgba[:2])


def test_a_transparent_color_or_gray_level_of_a_png_becomes_black(tmp_path):
    rgb = scene()
    key = rgb[3, 4]
    found = read(tmp_path, png(40, 56, 2, rgb, struct.pack(">HHH", *key.tolist())))
    expected = np.where((rgb == key).all(axis=2, keepdims=True), 0, rgb)
    assert np.array_equal(found, expected), (key, found[3, 4])
    gray = rgb[..., :1]
    found = read(tmp_path, png(40, 56, 0, gray, struct.pack(">H", gray[3, 4, 0])))
    assert np.array_equal(found, np.repeat(np.where(gray == gray[3, 4], 0, gray), 3, axis=2)), found[3, 4]
    assert np.array_equal(read(tmp_path, png(40, 56, 0, rgb[..., 0]))[..., 1], rgb[..., 0])


@pytest.mark.parametrize("orientation", TURNS)
def test_the_orientation_of_a_jpeg_is_honoured(tmp_path, orientation):
    jpeg = encode(".jpg", scene())
    plain = read(tmp_path, jpeg)
    turned = read(tmp_path, with_exif(jpeg, orientation))
    expected = TURNS[orientation](plain)
    assert turned.shape == expected.shape, (orientation, turned.shape, expected.shape)
    assert np.array_equal(turned, expected), (orientation, turned[:2], expected[:2])


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("orientation", TURNS)
def test_the_orientation_of_a_tiff_is_honoured(tmp_path, orientation, order):
    found = read(tmp_path, tiff(scene(), orientation, order))
    expected = TURNS[orientation](scene())
    assert np.array_equal(found, expected), (orientation, order, found.shape, expected.shape)


@pytest.mark.parametrize("name", ["köpfe und Töpfe.png", "苹果.jpg", "no suffix", "wrong suffix.txt"])
def test_any_file_name_is_read(tmp_path, name):
    found = read(tmp_path, encode(".png", scene()), name)
    assert np.array_equal(found, scene()), (name, found[:2])
    assert np.array_equal(read_image(str(tmp_path / name)), scene()), name


@pytest.mark.parametrize(
    ("suffix", "flags", "quiet"),
    [
        (".png", [], True),
        (".jpg", [], True),
        (".jpg", [cv2.IMWRITE_JPEG_PROGRESSIVE, 1], True),
        (".webp", [cv2.IMWRITE_WEBP_QUALITY, 80], True),
        (".webp", LOSSLESS[".webp"], True),
        (".bmp", [], False),
        (".tif", [], False),
        (".tif", [cv2.IMWRITE_TIFF_COMPRESSION, 1], False),
    ],
)
def test_a_truncated_file_is_refused_at_every_length(tmp_path, capfd, suffix, flags, quiet):
    whole = encode(suffix, scene(), flags)
    read(tmp_path, whole)
    cuts = sorted({*range(0, len(whole), max(1, len(whole) // 150)), *range(len(whole) - 20, len(whole))})
    for cut in cuts:
        refusal(tmp_path, whole[:cut], f"cut {cut}{suffix}")
    complaints = capfd.readouterr().err
    assert not (quiet and complaints), complaints


def test_an_end_marker_inside_a_thumbnail_does_not_hide_a_truncated_jpeg(tmp_path):
    jpeg = encode(".jpg", scene())
    thumbnail = encode(".jpg", scene(8, 8))
    whole = with_exif(jpeg, 1, thumbnail)
    assert np.array_equal(read(tmp_path, whole), read(tmp_path, jpeg)), len(whole)
    assert b"\xff\xd9" in whole[:-300], whole[-300:]
    assert "truncated" in refusal(tmp_path, whole[:-300])


@pytest.mark.parametrize(
    "padding", [b"\0" * 500, b"\xff" * 9, b"trailer \xff\xd8\xff\xe0 of another picture"]
)
def test_bytes_after_the_end_of_a_jpeg_do_no_harm(tmp_path, padding):
    jpeg = encode(".jpg", scene())
    assert np.array_equal(read(tmp_path, jpeg + padding), read(tmp_path, jpeg)), padding
    assert "truncated" in refusal(tmp_path, jpeg[:-2] + b"\0" * 500)


def test_a_png_with_one_wrong_bit_anywhere_is_refused_quietly(tmp_path, capfd):
    whole = encode(".png", scene(8, 12))
    for place in range(8, len(whole)):
        data = bytearray(whole)
        data[place] ^= 1 << (place % 8)
        refusal(tmp_path, bytes(data), f"bit {place}.png")
    complaints = capfd.readouterr().err
    assert not complaints, complaints


def test_a_bmp_from_top_to_bottom_is_read_like_one_from_bottom_to_top(tmp_path):
    data = bytearray(encode(".bmp", scene()))
    data[22:26] = struct.pack("<i", -40)
    found = read(tmp_path, bytes(data))
    assert np.array_equal(found, scene()[::-1]), (found[:2], scene()[::-1][:2])


@pytest.mark.parametrize(
    ("data", "part"),
    [
        (b"", "0 bytes"),
        (b"hello, this is no picture at all" * 9, "PNG, JPEG"),
        (b"GIF89a" + b"\0" * 99, "PNG, JPEG"),
        (b"RIFF\x40\0\0\0WAVEfmt " + b"\0" * 99, "not a WEBP"),
        (b"\xff\xd8\xff\xd9", "undamaged"),
        (b"BM" + b"\0" * 99, "header type"),
        (tiff(scene())[:-10] + b"\0" * 10, "undamaged"),
    ],
)
def test_what_is_no_picture_is_refused(tmp_path, data, part):
    message = refusal(tmp_path, data)
    assert part in message, (part, message)


def test_missing_files_folders_and_impossible_names_are_refused(tmp_path):
    for path, part in [
        (tmp_path / "none.png", "no such file"),
        (tmp_path, "a directory"),
        ("n" * 5000, "long"),
    ]:
        with pytest.raises(ImageError) as caught:
            read_image(path)
        assert part in str(caught.value), (part, str(caught.value))
        assert str(path) in caught.value.what, (path, caught.value.what)


@pytest.mark.parametrize("suffix", [".tif"])
@pytest.mark.parametrize(
    ("pixels", "part"),
    [
        (np.dstack([scene(), scene()[..., 0]]), "4 samples"),
        (scene()[..., 0].astype(np.float32) / 255, "floating-point"),
        (scene().astype(np.float32) / 255, "unsigned integers"),
        (scene()[..., 0].astype(np.int8), "signed"),
        (scene()[..., 0].astype(np.int16), "signed"),
        (scene()[..., 0].astype(np.int32), "signed"),
    ],
)
def test_tiffs_with_a_fourth_sample_of_no_stated_meaning_or_floats_are_refused(
    tmp_path, suffix, pixels, part
):
    message = refusal(tmp_path, encode(suffix, pixels))
    assert part in message, (part, message)


def bombs():
    side = 30000
    jpeg = bytearray(encode(".jpg", scene()))
    frame = jpeg.index(b"\xff\xc0")
    jpeg[frame + 5 : frame + 9] = struct.pack(">HH", side, side)
    bmp = bytearray(encode(".bmp", scene()))
    bmp[18:26] = struct.pack("<ii", side, -side)
    lossless, lossy = (bytearray(encode(".webp", scene(), [cv2.IMWRITE_WEBP_QUALITY, q])) for q in (101, 80))
    lossless[21:25] = struct.pack("<I", 16000 | 16000 << 14)
    lossy[26:30] = struct.pack("<HH", 16000, 16000)
    extended = bytearray(
        encode(".webp", np.dstack([scene(), scene()[..., 0]]), [cv2.IMWRITE_WEBP_QUALITY, 80])
    )
    assert extended[12:16] == b"VP8X", extended[12:16]
    extended[24:30] = (16000).to_bytes(3, "little") * 2
    empty = png(side, side, 0, [np.zeros(9, np.uint8)])
    return [empty, jpeg, bmp, lossless, lossy, extended, tiff(scene(), declared=(side, side))]


@pytest.mark.parametrize(
    "data", bombs(), ids=["png", "jpg", "bmp", "webp lossless", "webp", "webp alpha", "tif"]
)
def test_a_decompression_bomb_is_refused_before_it_is_decoded(tmp_path, monkeypatch, data):
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("decoded"))
    monkeypatch.setattr(ImageFile.ImageFile, "load", lambda *_: pytest.fail("decoded"))
    monkeypatch.setattr(WebPImageFile, "load", lambda *_: pytest.fail("decoded"))
    message = refusal(tmp_path, bytes(data))
    assert f"at most {MAX_PIXELS} pixels" in message, message
    assert "30000" in message or "1600" in message or "(2560" in message, message


@pytest.mark.parametrize("suffix", [*LOSSLESS, ".jpg"])
def test_the_smallest_side_is_eight(tmp_path, suffix):
    assert read(tmp_path, encode(suffix, scene(MIN_SIDE, 30))).shape == (MIN_SIDE, 30, 3), suffix
    for shape in [(MIN_SIDE - 1, 30), (30, MIN_SIDE - 1)]:
        message = refusal(tmp_path, encode(suffix, scene(*shape)))
        assert f"{shape[0]} x {shape[1]}" in message, message


@pytest.mark.parametrize(
    ("array", "part"),
    [
        (scene() / 255.0, "float64"),
        (scene().astype(np.float32), "texture"),
        (scene().astype(np.float16), "float16"),
        (scene().astype(np.int8), "int8"),
        (scene().astype(np.int64), "int64"),
        (scene().astype(np.uint32), "uint32"),
        (scene() > 9, "bool"),
        (scene().tolist(), "list"),
        (None, "NoneType"),
        (scene()[..., :2], "(40, 56, 2)"),
        (scene()[0, :, 0], "(56,)"),
        (scene()[np.newaxis], "(1, 40, 56, 3)"),
        (np.zeros((0, 20, 3), np.uint8), "0 x 20"),
        (np.zeros((20, 7), np.uint8), "20 x 7"),
        (np.broadcast_to(np.uint8(0), (2**13 + 1, 2**13, 3)), "at most"),
    ],
)
def test_arrays_that_are_no_picture_are_refused(array, part):
    with pytest.raises(ImageError) as caught:
        as_rgb(array, "view of robot 3")
    assert "view of robot 3" in str(caught.value), str(caught.value)
    assert part in str(caught.value), (part, str(caught.value))


def test_masked_pixels_are_refused_naming_the_mask():
    masked = np.ma.masked_array(scene(), mask=False)
    assert np.array_equal(as_rgb(masked, "view"), scene())
    masked[3, 4, 1] = np.ma.masked
    with pytest.raises(ImageError, match="view 7 must not be masked; got 'a mask that hides 1 values'"):
        as_rgb(masked, "view 7")


@pytest.mark.parametrize("order", ["<", ">"])
def test_pixels_of_any_layout_are_the_same(order):
    deep = scene().astype(np.uint16) * 257
    forms = [
        deep.astype(order + "u2"),
        np.asfortranarray(deep),
        np.ascontiguousarray(deep[::-1, ::-1])[::-1, ::-1],
        np.repeat(deep, 2, axis=1)[:, ::2],
        deep.view(type("Marked", (np.ndarray,), {})),
        np.ndarray(deep.shape, "u2", buffer=b"\0" + deep.tobytes(), offset=1),
    ]
    for pixels in forms:
        assert np.array_equal(as_rgb(pixels, "view"), scene()), pixels.strides
    assert np.array_equal(as_rgb(scene()[..., 0].view(np.matrix), "view")[..., 1], scene()[..., 0])
    with pytest.raises(ImageError, match="must hold uint8 or uint16"):
        as_rgb(np.zeros((9, 9), [("red", "u1")]), "view")
    with pytest.raises(ImageError, match="must hold uint8 or uint16"):
        as_rgb(scene().astype(object), "view")


@pytest.mark.parametrize("shape", [(9, 9), (9, 9, 3)])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_picture_of_one_color_is_flat_also_with_the_noise_of_a_sensor(shape, kind):
    unit = 1 if kind == np.uint8 else 256
    noise = np.random.default_rng(0).integers(0, 5, shape)
    for pixels in (noise, 251 + noise, 0 * noise, 255 + 0 * noise):
        assert is_flat((pixels * unit).astype(kind)), pixels[0]
    for place in ((0, 4), (8, 8)):
        marked = noise.copy()
        marked[(*place, 1)[: noise.ndim]] = 9
        assert not is_flat((marked * unit).astype(kind)), place
    gradient = np.zeros(shape)
    gradient[-1] = 5
    assert not is_flat((gradient * unit).astype(kind))
    assert is_flat(np.full((9, 9), 70, kind).view(np.matrix))
    hidden = np.zeros((9, 9, 4), kind)
    hidden[..., :3] = scene()[:9, :9]
    assert is_flat(hidden)
    hidden[..., 3] = np.iinfo(kind).max
    assert is_flat(hidden) == (kind == np.uint16), "an 8-bit scene is black in 16 bits"


def test_an_array_is_copied_and_frozen():
    given_array = scene()
    found = as_rgb(given_array[..., ::-1], "view")
    given_array[:] = 0
    assert np.array_equal(found, scene()[..., ::-1]), found[:2]
    assert not found.flags.writeable, found.flags
    assert np.array_equal(as_rgb(scene()[..., :1], "view"), as_rgb(scene()[..., 0], "view"))


@given(rgb=pictures())
@settings(deadline=None, max_examples=50)
def test_gray_is_the_rounded_luma_and_keeps_gray(rgb):
    gray = to_gray(rgb).astype(int)
    exact = rgb.astype(int) @ [299, 587, 114]
    assert np.abs(1000 * gray - exact).max() <= 500, (gray, rgb)
    same = to_gray(as_rgb(rgb[..., 1], "gray"))
    assert np.array_equal(same, rgb[..., 1]), (same, rgb[..., 1])


@given(rgb=pictures(), height=st.integers(8, 40), width=st.integers(8, 40), order=st.permutations(range(3)))
@settings(deadline=None, max_examples=50)
def test_resizing_keeps_range_channels_and_uniform_pictures(rgb, height, width, order):
    found = resize(rgb, (height, width))
    assert found.shape == (height, width, 3), found.shape
    assert rgb.min() <= found.min() <= found.max() <= rgb.max(), (rgb, found)
    swapped = resize(np.ascontiguousarray(rgb[..., order]), (height, width))
    assert np.array_equal(swapped, found[..., order]), (order, swapped, found)
    uniform = resize(np.full_like(rgb, rgb[0, 0]), (height, width))
    assert (uniform == rgb[0, 0]).all(), (rgb[0, 0], uniform)
    assert np.array_equal(resize(rgb, rgb.shape[:2]), rgb), rgb


@given(rgb=pictures(), down=st.integers(1, 4), across=st.integers(1, 4))
@settings(deadline=None, max_examples=50)
def test_shrinking_takes_the_mean_of_areas(rgb, down, across):
    fine = np.tile(rgb, (down, across, 1))
    found = resize(fine, rgb.shape[:2]).astype(int)
    total = fine.reshape(rgb.shape[0], down, rgb.shape[1], across, 3).astype(int).sum(axis=(1, 3))
    # A mean that lies half-way may go either way; 1/100 more allows for single precision.
    off = np.abs(100 * down * across * found - 100 * total)
    assert off.max() <= 51 * down * across, (off.max() / (100 * down * across), found, fine)


def test_one_side_shrinks_by_areas_while_the_other_grows():
    stripes = np.zeros((32, 8, 3), np.uint8)
    stripes[::4] = 200
    found = resize(stripes, (8, 16))
    assert (found == 50).all(), found[..., 0]
    bars = np.zeros((32, 8, 3), np.uint8)
    bars[:, ::2] = 100
    linear = np.interp((np.arange(16) + 0.5) / 2 - 0.5, np.arange(8), bars[0, :, 0])
    grown = resize(bars, (8, 16))
    assert (grown == linear[:, np.newaxis]).all(), (grown[0, :, 0], linear)


@pytest.mark.parametrize("size", [(7, 20), (20, 0), (-8, 8), (2**13 + 1, 2**13)])
def test_absurd_sizes_are_refused(size):
    with pytest.raises(ImageError) as caught:
        resize(scene(), size)
    assert f"{size[0]} x {size[1]}" in str(caught.value), str(caught.value)


def test_a_folder_lists_its_pictures_in_the_order_of_their_names(tmp_path):
    for name in [
        "b.PNG",
        "B.png",
        "a10.jpg",
        "a2.jpeg",
        "é.webp",
        "c.tif",
        "d.tiff",
        "e.bmp",
        "._b.png",
        "notes.txt",
    ]:
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "folder.png").mkdir()
    names = [path.name for path in list_images(tmp_path)]
    assert names == ["B.png", "a10.jpg", "a2.jpeg", "b.PNG", "c.tif", "d.tiff", "e.bmp", "é.webp"], names
    assert all(path.parent == tmp_path for path in list_images(str(tmp_path))), list_images(str(tmp_path))


def test_a_folder_that_is_missing_or_has_no_picture_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("x")
    for folder, part in [
        (tmp_path, "1 other"),
        (tmp_path / "none", "readable"),
        (tmp_path / "notes.txt", "readable"),
    ]:
        with pytest.raises(ImageError) as caught:
            list_images(folder)
        assert part in str(caught.value), (part, str(caught.value))
        assert str(folder) in str(caught.value), str(caught.value)
