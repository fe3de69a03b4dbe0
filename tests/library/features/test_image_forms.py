"""Forms of picture files: each is read to the pixels that were written, or refused; OpenCV decodes too."""

import struct
import warnings
import zlib

import cv2
import numpy as np
import pytest
from picture_files import (
    DEEP,
    DEEP_RGB,
    DEEP_RGBA,
    GRAY,
    HEIGHT,
    MASKS,
    RGB,
    RGBA,
    SMOOTH,
    WIDTH,
    bmp,
    by_opencv,
    by_pillow,
    check,
    chunk,
    outcome,
    packed,
    png,
    read,
    refusal,
    scaled,
    tiff,
)
from PIL import Image, ImageFile, PngImagePlugin

from convexperc.errors import PictureWarning
from convexperc.features.pictures import as_rgb

# PNG -----------------------------------------------------------------------------------------------------


def interlaced(pixels):
    passes = [
        (0, 0, 8, 8),
        (4, 0, 8, 8),
        (0, 4, 4, 8),
        (2, 0, 4, 4),
        (0, 2, 2, 4),
        (1, 0, 2, 2),
        (0, 1, 1, 2),
    ]
    parts = [pixels[top::down, left::across] for left, top, across, down in passes]
    return b"".join(b"\0" + row.tobytes() for part in parts for row in part)


@pytest.mark.parametrize("bits", [1, 2, 4, 8])
def test_png_gray_and_palette_of_every_depth_with_and_without_transparency(tmp_path, bits):
    levels, colors = GRAY >> (8 - bits), 2**bits
    palette, alpha = RGB.reshape(-1, 3)[:colors], RGBA.reshape(-1)[:colors]
    rows, table = packed(levels, bits), chunk(b"PLTE", palette.tobytes())
    check(tmp_path, png(rows, bits, 0), scaled(levels, bits), "gray")
    for level in {0, 1, colors - 1}:
        data = png(rows, bits, 0, chunk(b"tRNS", struct.pack(">H", level)))
        check(tmp_path, data, np.where(levels == level, 0, scaled(levels, bits)), ("level", level))
    check(tmp_path, png(rows, bits, 3, table), palette[levels], "palette")
    for opacities in (alpha, alpha[:1], np.where(np.arange(colors) == 1, 0, 255).astype(np.uint8)):
        full = np.full(colors, 255, np.uint8)
        full[: len(opacities)] = opacities
        data = png(rows, bits, 3, table + chunk(b"tRNS", opacities.tobytes()))
        check(tmp_path, data, as_rgb(np.dstack([palette[levels], full[levels]]), "palette"), opacities)


@pytest.mark.parametrize("big", ["u1", ">u2"])
def test_png_color_and_alpha_of_both_depths_with_one_transparent_color_and_interlaced(tmp_path, big):
    gray, rgb, rgba = (GRAY, RGB, RGBA) if big == "u1" else (DEEP, DEEP_RGB, DEEP_RGBA)
    bits = 8 * np.dtype(big).itemsize
    key, level = rgb[3, 4], gray[3, 4]
    pair = rgba[..., :2]
    clear = np.where((rgb == key).all(axis=2, keepdims=True), 0, rgb).astype(rgb.dtype)
    forms = {
        "gray": (gray, 0, b"", gray),
        "color": (rgb, 2, b"", rgb),
        "gray and alpha": (pair, 4, b"", pair[..., [0, 0, 0, 1]]),
        "color and alpha": (rgba, 6, b"", rgba),
        "a color": (rgb, 2, chunk(b"tRNS", struct.pack(">HHH", *key.tolist())), clear),
        "a level": (gray, 0, chunk(b"tRNS", struct.pack(">H", level)), np.where(gray == level, 0, gray)),
    }
    for what, (pixels, color, before, expected) in forms.items():
        stored, meant = pixels.astype(big), as_rgb(expected.astype(rgb.dtype), what)
        check(tmp_path, png(stored, bits, color, before), meant, what)
        check(tmp_path, png(interlaced(stored), bits, color, before, interlace=1), meant, what)
        dark = np.zeros_like(stored)
        if color in (4, 6):
            dark[..., -1] = 2**bits - 1
        check(tmp_path, png(dark, bits, color), np.zeros_like(GRAY), what)
        for picture in (stored, dark):
            for raw in (picture[:-1], interlaced(picture)[: -picture[0].nbytes - 1]):
                data = png(raw, bits, color, before, interlace=int(isinstance(raw, bytes)))
                assert outcome(tmp_path, data) is None, what


def test_png_transparency_of_another_length_and_chunks_without_a_name_are_refused(tmp_path):
    table = chunk(b"PLTE", RGB.reshape(-1, 3)[:16].tobytes())
    forms = {0: (GRAY, b""), 2: (RGB, b""), 3: (GRAY >> 4, table), 4: (RGBA[..., :2], b""), 6: (RGBA, b"")}
    lengths = {0: [2], 2: [6], 3: range(1, 17), 4: [], 6: []}
    for color, (rows, before) in forms.items():
        for length in range(20):
            data = png(rows, 8, color, before + chunk(b"tRNS", b"\1" * length))
            assert (outcome(tmp_path, data) is not None) == (length in lengths[color]), (color, length)
    for name in (b"t\xceNS", b"t\1NS", b"\xf4RNS", b"tR S"):
        assert "not of letters" in refusal(tmp_path, png(GRAY, 8, 0, chunk(name, b"\0\1"))), name


@pytest.mark.parametrize(
    "extra",
    [
        chunk(b"tEXt", b""),
        chunk(b"zTXt", b"key\0\0" + zlib.compress(b"a" * 2**21)),
        chunk(b"iCCP", b"profile\0\0" + zlib.compress(b"a" * 2**21)),
        chunk(b"gAMA", b"") + chunk(b"pHYs", b""),
        chunk(b"gAMA", struct.pack(">I", 100_000)) + chunk(b"sBIT", b"\5\5\5"),
        chunk(b"eXIf", b"neither byte order"),
        chunk(b"xyZw", b"private"),
    ],
)
def test_png_chunks_that_state_no_pixels_do_no_harm(tmp_path, extra):
    check(tmp_path, png(RGB, 8, 2, extra), RGB, extra[:8])
    check(tmp_path, png(RGB, 8, 2, b"", extra) + b"more bytes", RGB, extra[:8])
    damaged = bytearray(png(RGB, 8, 2, b"", extra))
    damaged[-13] ^= 1
    assert "checksum" in refusal(tmp_path, bytes(damaged)), extra[:8]


@pytest.mark.parametrize("default", [False, True])
def test_of_several_pictures_in_a_file_the_first_is_read_and_that_is_said(tmp_path, default):
    more = {"save_all": True, "append_images": [Image.fromarray(255 - RGB)]}
    for data in (
        by_pillow(RGB, "PNG", default_image=default, **more),
        by_pillow(RGB, "WEBP", lossless=True, **more),
        by_pillow(RGB, "TIFF", **more),
    ):
        with pytest.warns(PictureWarning, match=r"picture\.bin holds several pictures; the first is read"):
            check(tmp_path, data, RGB, data[:4])


# BMP -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fourth", [0, 255, None])
@pytest.mark.parametrize("header", [40, 52, 56, 108, 124])
def test_bmp_of_32_bits_has_alpha_only_if_a_mask_says_so(tmp_path, header, fourth):
    last = RGBA[..., 3] if fourth is None else np.full_like(GRAY, fourth)
    stored = np.dstack([RGB[..., ::-1], last])
    check(tmp_path, bmp(stored, 32, header), RGB, "no masks")
    check(tmp_path, bmp(stored, 32, header, 3, MASKS[3]), RGB, "masks of three colors")
    check(tmp_path, bmp(stored[::-1], 32, header, 3, MASKS[3], height=-HEIGHT), RGB, "from top to bottom")
    swapped = bmp(stored[..., [3, 0, 1, 2]], 32, header, 3, (0xFF000000, 0xFF0000, 0xFF00))
    check(tmp_path, swapped, RGB, "the unused byte first")
    if header > 52:
        data = bmp(stored, 32, header, 3, MASKS[4])
        if fourth == 0:
            assert "transparent everywhere" in refusal(tmp_path, data)
        else:
            check(tmp_path, data, as_rgb(np.dstack([RGB, last]), "alpha"), "a mask of alpha")
    assert "masks" in refusal(tmp_path, bmp(stored, 32, header, 3, (0, 0, 0)))
    assert "bitfields" in refusal(tmp_path, bmp(stored, 32, header, 3, (0xFF, 0xFF00, 0xFF0000)))


def test_bmp_of_16_bits_reaches_the_whole_range(tmp_path):
    five, six = RGB >> 3, RGB[..., 1] >> 2
    words = five.astype("<u2") @ np.array([1 << 10, 1 << 5, 1], "<u2")
    check(tmp_path, bmp(words, 16), scaled(five, 5), "5 bits each")
    check(tmp_path, bmp(words, 16, 40, 3, (0x7C00, 0x3E0, 0x1F)), scaled(five, 5), "5 bits each, by masks")
    words = (five[..., 0].astype("<u2") << 11) | (six.astype("<u2") << 5) | five[..., 2]
    expected = np.dstack([scaled(five[..., 0], 5), scaled(six, 6), scaled(five[..., 2], 5)])
    check(tmp_path, bmp(words, 16, 40, 3, (0xF800, 0x7E0, 0x1F)), expected, "6 bits of green")


@pytest.mark.parametrize("header", [12, 40])
@pytest.mark.parametrize("bits", [1, 4, 8])
@pytest.mark.parametrize("used", ["all", "two"])
def test_bmp_palettes_of_colors_and_grays(tmp_path, bits, header, used):
    count = 2 if used == "two" else 2**bits
    levels = (GRAY >> (8 - bits)) % np.uint16(count)
    ramp = np.arange(count)
    for gray in (scaled(ramp, bits), ramp * 255 // (count - 1), 255 - ramp * 255 // (count - 1), ramp, None):
        palette = RGB.reshape(-1, 3)[:count] if gray is None else np.stack([gray] * 3, 1).astype(np.uint8)
        stored = palette[:, ::-1] if header == 12 else np.hstack([palette[:, ::-1], palette[:, :1] * 0])
        if header == 12:
            stored = np.vstack([stored, np.zeros((2**bits - count, 3), np.uint8)])
        data = bmp(packed(levels, bits), bits, header, palette=stored.tobytes(), colors=count)
        check(tmp_path, data, palette[levels], (bits, gray))


def test_a_bmp_cut_anywhere_is_refused_also_in_the_padding_of_its_last_row(tmp_path):
    data = bmp(RGB[..., ::-1], 24)
    check(tmp_path, data, RGB, "24 bits")
    for cut in (*range(0, len(data), 37), *range(len(data) - 5, len(data))):
        assert outcome(tmp_path, data[:cut]) is None, cut


# TIFF ----------------------------------------------------------------------------------------------------


METHODS = {1: bytes, 8: zlib.compress, 32946: zlib.compress}


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("method", METHODS)
def test_tiff_gray_of_every_depth_palette_color_and_alpha(tmp_path, order, method):
    def stored(pixels, bits, photometric, **tags):
        raw = pixels.astype(pixels.dtype.newbyteorder(order)).tobytes()
        return tiff([METHODS[method](raw)], bits, photometric, order, method, **tags)

    for bits in (1, 2, 4, 8):
        levels = GRAY >> (8 - bits)
        rows, gray = packed(levels, bits), scaled(levels, bits)
        check(tmp_path, stored(rows, [bits], 1), gray, (bits, "0 is black"))
        check(tmp_path, stored(rows, [bits], 0), 255 - gray, (bits, "0 is white"))
        colors = DEEP_RGB.reshape(-1, 3)[: 2**bits]
        data = stored(rows, [bits], 3, t320=colors.T.ravel().tolist())
        check(tmp_path, data, (colors >> 8)[levels], (bits, "palette"))
    narrow = RGB.reshape(-1, 3)[:256]
    check(tmp_path, stored(GRAY, [8], 3, t320=narrow.T.ravel().tolist()), narrow[GRAY], "8-bit palette")
    check(tmp_path, stored(DEEP, [16], 1), DEEP >> 8, "16-bit gray")
    check(tmp_path, stored(RGB, [8] * 3, 2), RGB, "color")
    check(tmp_path, stored(DEEP_RGB, [16] * 3, 2), DEEP_RGB >> 8, "16-bit color")
    check(tmp_path, stored(RGBA, [8] * 4, 2, t338=[2]), as_rgb(RGBA, "alpha"), "alpha")
    check(tmp_path, stored(DEEP_RGBA, [16] * 4, 2, t338=[2]), as_rgb(DEEP_RGBA, "alpha"), "16-bit alpha")
    pair = np.ascontiguousarray(RGBA[..., :2])
    check(tmp_path, stored(pair, [8] * 2, 1, t338=[2]), as_rgb(RGBA[..., [0, 0, 0, 1]], "gray"), "gray alpha")
    for kinds in ([0], [1], None):
        tags = {"t338": kinds} if kinds else {}
        assert "4 samples" in refusal(tmp_path, stored(RGBA, [8] * 4, 2, **tags)), kinds
    assert "4 samples" in refusal(tmp_path, stored(RGBA, [8] * 4, 5)), "CMYK"
    assert "0 for white" in refusal(tmp_path, stored(DEEP, [16], 0)) or order == ">", order
    for pixels, bits, form in [(GRAY, 8, 2), (DEEP, 16, 2), (DEEP, 16, 3), (DEEP_RGB[..., :2], 32, 1)]:
        data = stored(np.ascontiguousarray(pixels), [bits], 1, t339=[form])
        assert "unsigned" in refusal(tmp_path, data), (bits, form)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("method", METHODS)
def test_tiff_in_strips_tiles_and_planes(tmp_path, order, method):
    code = METHODS[method]
    strips = [code(RGB[top : top + 5].tobytes()) for top in range(0, HEIGHT, 5)]
    check(tmp_path, tiff(strips, [8] * 3, 2, order, method, t278=[5]), RGB, "strips")
    assert outcome(tmp_path, tiff(strips[:-1], [8] * 3, 2, order, method, t278=[5])) is None
    short = [*strips[:2], code(RGB[10:14].tobytes()), *strips[3:]]
    assert outcome(tmp_path, tiff(short, [8] * 3, 2, order, method, t278=[5])) is None
    padded = np.pad(RGB, ((0, 8), (0, 15), (0, 0)))
    corners = [(top, left) for top in range(0, HEIGHT, 16) for left in range(0, WIDTH, 16)]
    tiles = [code(padded[top : top + 16, left : left + 16].tobytes()) for top, left in corners]
    places = {"t322": [16], "t323": [16], "dropped": (273, 278, 279)}
    starts = [8 + sum(map(len, tiles[:number])) for number in range(len(tiles))]
    data = tiff(tiles, [8] * 3, 2, order, method, t324=starts, t325=list(map(len, tiles)), **places)
    check(tmp_path, data, RGB, "tiles")
    planes = [code(RGB[..., channel].tobytes()) for channel in range(3)]
    check(tmp_path, tiff(planes, [8] * 3, 2, order, method, t284=[2]), RGB, "planes")
    assert outcome(tmp_path, tiff(planes[:2], [8] * 3, 2, order, method, t284=[2])) is None
    deep = DEEP_RGB.astype(order + "u2")
    data = tiff([code(deep[..., c].tobytes()) for c in range(3)], [16] * 3, 2, order, method, t284=[2])
    assert "apart" in refusal(tmp_path, data)
    data = tiff([code(DEEP.astype(order + "u2").tobytes())], [16], 1, order, method, t284=[2])
    check(tmp_path, data, DEEP >> 8, "one plane of 16 bits")
    assert "planar 0" in refusal(tmp_path, tiff(strips, [8] * 3, 2, order, method, t278=[5], t284=[0]))


@pytest.mark.parametrize("method", ["raw", "tiff_lzw", "tiff_adobe_deflate", "packbits", "jpeg"])
def test_both_decoders_agree_on_tiffs(tmp_path, method):
    for picture in (Image.fromarray(GRAY), Image.fromarray(RGB), Image.fromarray(RGB).convert("YCbCr")):
        if picture.mode == "YCbCr" and method in ("tiff_lzw", "packbits"):
            continue  # refused
        data = by_pillow(picture, "TIFF", compression=method)
        assert np.array_equal(read(tmp_path, data), by_opencv(data)), (method, picture.mode)
    if method != "jpeg":
        deep = by_pillow(DEEP, "TIFF", compression=method)
        assert np.array_equal(read(tmp_path, deep)[..., 0], by_opencv(deep, cv2.IMREAD_UNCHANGED) >> 8), (
            method
        )
        colors = by_pillow(Image.fromarray(RGB).quantize(9), "TIFF", compression=method)
        assert np.array_equal(read(tmp_path, colors), by_opencv(colors)), method


# Damage --------------------------------------------------------------------------------------------------


SMALL, SMALL_GRAY = SMOOTH[:8, :9], np.ascontiguousarray(SMOOTH[:8, :9, 2])
SMALL_SIZE = {"t256": [9], "t257": [8]}


def sound_files():
    gray, color = (zlib.compress(part.tobytes()) for part in (SMALL_GRAY, SMALL))
    return {
        "png": by_pillow(SMALL_GRAY, "PNG"),
        "png palette": by_pillow(Image.fromarray(SMALL).quantize(7), "PNG"),
        "tiff gray": tiff([gray], [8], 1, method=8, **SMALL_SIZE),
        "tiff color": tiff([color], [8] * 3, 2, ">", 32946, **SMALL_SIZE),
    }


@pytest.mark.parametrize(("name", "data"), sound_files().items(), ids=sound_files())
def test_one_wrong_byte_of_what_has_a_checksum_is_refused_or_does_no_harm(tmp_path, name, data):
    """In a TIFF that is the strip, from byte 8 to the directory at the offset that byte 4 states."""
    expected = read(tmp_path, data)
    end = len(data) if "png" in name else struct.unpack_from("<I" if data[:1] == b"I" else ">I", data, 4)[0]
    for place in range(8, end - 1):
        damaged = bytearray(data)
        damaged[place] ^= (0x01, 0x80, 0xFF)[place % 3]
        found = outcome(tmp_path, bytes(damaged))
        assert found is None or np.array_equal(found, expected), (name, place)
        assert found is None or place == 9, (
            name,
            place,
        )  # the level of compression, which no checksum covers


@pytest.mark.parametrize("progressive", [False, True])
@pytest.mark.parametrize("gray", [False, True])
def test_a_jpeg_without_its_end_is_refused_wherever_it_is_cut(tmp_path, progressive, gray):
    whole = by_pillow(GRAY if gray else SMOOTH, "JPEG", progressive=progressive)
    assert np.array_equal(read(tmp_path, whole), by_opencv(whole)), (progressive, gray)
    for cut in (*range(0, len(whole), 7), *range(len(whole) - 40, len(whole))):
        assert outcome(tmp_path, whole[:cut]) is None, cut
        assert outcome(tmp_path, whole[:cut] + b"\0" * 999) is None, cut


def test_both_decoders_agree_on_jpegs(tmp_path):
    for picture in (GRAY, RGB, SMOOTH):
        for quality in (5, 60, 100):
            for sampling in (0, 1, 2):
                color = {"subsampling": sampling} if picture.ndim == 3 else {}
                data = by_pillow(picture, "JPEG", quality=quality, **color)
                assert np.array_equal(read(tmp_path, data), by_opencv(data)), (quality, sampling)


def test_four_inks_of_a_jpeg_are_within_a_level_of_opencv_and_white_is_white(tmp_path):
    data = by_pillow(Image.fromarray(SMOOTH).convert("CMYK"), "JPEG", quality=95)
    off = np.abs(read(tmp_path, data).astype(int) - by_opencv(data)).max()
    assert off <= 1, off
    white = by_pillow(Image.new("CMYK", (WIDTH, HEIGHT)), "JPEG")
    assert (read(tmp_path, white) == 255).all(), read(tmp_path, white)[0]


# Orientation and other modules' settings -----------------------------------------------------------------

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


@pytest.mark.parametrize("orientation", [*TURNS, 0, 9])
@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF", "WEBP"])
def test_exif_turns_a_picture_of_every_format(tmp_path, kind, orientation):
    exif = Image.Exif()
    exif[0x112] = orientation
    options = {"lossless": True} if kind == "WEBP" else {"quality": 95} if kind == "JPEG" else {}
    plain = read(tmp_path, by_pillow(SMOOTH, kind, **options))
    turned = read(tmp_path, by_pillow(SMOOTH, kind, exif=exif, **options))
    assert np.array_equal(turned, TURNS.get(orientation, TURNS[1])(plain)), (kind, orientation)
    assert turned.flags.c_contiguous, turned.strides


def test_exif_after_the_pixels_and_of_deep_or_transparent_pngs_is_honoured(tmp_path):
    orient = chunk(b"eXIf", b"II*\0" + struct.pack("<IHHHIHHI", 8, 1, 0x112, 3, 1, 6, 0, 0))
    check(tmp_path, png(RGB, 8, 2, b"", orient), np.rot90(RGB, -1), "after the pixels")
    key = chunk(b"tRNS", struct.pack(">HHH", *DEEP_RGB[0, 0].tolist()))
    data = png(DEEP_RGB.astype(">u2"), 16, 2, key + orient)
    clear = np.where((DEEP_RGB[0, 0] == DEEP_RGB).all(axis=2, keepdims=True), 0, DEEP_RGB >> 8)
    check(tmp_path, data, np.rot90(clear, -1), "a transparent color of 16 bits")


def test_exif_that_breaks_off_is_a_warning_and_states_nothing(tmp_path):
    data = png(RGB, 8, 2, chunk(b"eXIf", b"II*\0\x08\0\0\0\x09\0\x0f\x01\x03\0"))
    with pytest.warns(UserWarning, match="EXIF"):
        check(tmp_path, data, RGB, "a warning")
    assert "EXIF" in refusal(tmp_path, data), "a warning that is made an error"


@pytest.mark.parametrize("rest", [b"", b"\x1a\x01\x05\0\x01\0\0\0\xff\xff\0\0" + b"\0" * 4])
def test_damaged_exif_of_a_jpeg_still_turns_by_what_can_be_read(tmp_path, rest):
    payload = b"Exif\0\0II*\0" + struct.pack("<IHHHIHH", 8, 2, 0x112, 3, 1, 6, 0) + rest
    jpeg = by_pillow(SMOOTH, "JPEG", quality=95)
    data = jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(payload) + 2) + payload + jpeg[2:]
    check(tmp_path, data, np.rot90(read(tmp_path, jpeg), -1), rest)


def test_settings_of_pillow_are_left_alone_and_cannot_weaken_a_check(tmp_path, monkeypatch):
    data = by_pillow(RGB, "PNG")
    before = Image.MAX_IMAGE_PIXELS, ImageFile.LOAD_TRUNCATED_IMAGES, PngImagePlugin.MAX_TEXT_CHUNK
    with warnings.catch_warnings(record=True) as caught:
        check(tmp_path, data, RGB, "as it is")
    assert not caught, [str(each.message) for each in caught]
    after = Image.MAX_IMAGE_PIXELS, ImageFile.LOAD_TRUNCATED_IMAGES, PngImagePlugin.MAX_TEXT_CHUNK
    assert after == before, (before, after)
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 100)
    check(tmp_path, data, RGB, "a low limit of Pillow")
    assert "exceeds limit of" in refusal(tmp_path, tiff([RGB.tobytes()], [8] * 3, 2))
    monkeypatch.setattr(ImageFile, "LOAD_TRUNCATED_IMAGES", True)
    assert "LOAD_TRUNCATED_IMAGES must be False" in refusal(tmp_path, data)
