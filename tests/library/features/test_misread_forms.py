"""Forms of picture files that decoders misread, or accept though they are damaged: right, or refused."""

import io
import itertools
import struct
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
from PIL import Image

from convexperc.errors import PictureWarning
from convexperc.features import as_rgb, read_image

# What a decoder need not know: samples as the specification lays them out, each form with its right pixels.

LEVELS, COLORS = GRAY >> 4, RGB.reshape(-1, 3)[:256]


def packbits(row):
    """Literal runs of at most 128 bytes."""
    parts = [row[start : start + 128] for start in range(0, len(row), 128)]
    return b"".join(bytes([len(part) - 1]) + part for part in parts)


def lzw(raw):
    """LZW of TIFF with codes of 9 bits only: the table is cleared before it would need more."""
    codes = [256]
    for place, byte in enumerate(raw):
        if place and place % 250 == 0:
            codes.append(256)
        codes.append(byte)
    codes.append(257)
    bits = "".join(f"{code:09b}" for code in codes)
    bits += "0" * (-len(bits) % 8)
    return int(bits, 2).to_bytes(len(bits) // 8, "big")


def reversed_bits(data):
    return bytes(int(f"{byte:08b}"[::-1], 2) for byte in data)


CODES = {
    1: b"".join,
    5: lambda rows: lzw(b"".join(rows)),
    8: lambda rows: zlib.compress(b"".join(rows)),
    32773: lambda rows: b"".join(map(packbits, rows)),
}


def forms():
    """Stored samples, bits of each, photometric interpretation, other tags, and the right pixels."""
    for bits in (1, 2, 4, 8):
        levels = GRAY >> (8 - bits)
        rows, gray = packed(levels, bits), scaled(levels, bits)
        deep = DEEP_RGB.reshape(-1, 3)[: 2**bits]
        yield f"black is 0, {bits}", rows, [bits], 1, {}, gray
        yield f"white is 0, {bits}", rows, [bits], 0, {}, 255 - gray
        yield f"palette {bits}", rows, [bits], 3, {"t320": deep.T.ravel().tolist()}, (deep >> 8)[levels]
        narrow = COLORS[: 2**bits]
        yield f"narrow palette {bits}", rows, [bits], 3, {"t320": narrow.T.ravel().tolist()}, narrow[levels]
    yield "gray 16", DEEP, [16], 1, {}, DEEP >> 8
    yield "white is 0, 16", DEEP, [16], 0, {}, 255 - (DEEP >> 8)
    yield "RGB", RGB, [8] * 3, 2, {}, RGB
    yield "RGB 16", DEEP_RGB, [16] * 3, 2, {}, DEEP_RGB >> 8
    yield "alpha", RGBA, [8] * 4, 2, {"t338": [2]}, as_rgb(RGBA, "alpha")
    yield "alpha 16", DEEP_RGBA, [16] * 4, 2, {"t338": [2]}, as_rgb(DEEP_RGBA, "alpha")
    yield "gray alpha", RGBA[..., :2], [8] * 2, 1, {"t338": [2]}, as_rgb(RGBA[..., [0, 0, 0, 1]], "alpha")
    ink = np.dstack([COLORS[RGBA[..., 0]], RGBA[..., 1]])
    wide = {"t320": (COLORS.astype(int) * 257).T.ravel().tolist(), "t338": [2]}
    yield "palette alpha", RGBA[..., :2], [8] * 2, 3, wide, as_rgb(ink, "alpha")
    yield "CMYK", RGBA, [8] * 4, 5, {}, None
    yield "CIELab", RGB, [8] * 3, 8, {}, None


READ_ALL = {"black is 0, 8", "gray 16", "RGB", "palette 8", "narrow palette 8", "alpha"}
"""Forms that are read in every byte order, compression and layout that is not said to be refused."""


@pytest.mark.parametrize("method", CODES)
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_tiff_of_any_form_is_read_as_it_was_written_or_refused(tmp_path, order, method):
    right = set()
    for (name, pixels, bits, kind, tags, meant), fill, layout in itertools.product(
        forms(), (1, 2), ("whole", "strips", "planes")
    ):
        parts = [pixels]
        if layout == "strips":
            parts = [pixels[top : top + 5] for top in range(0, HEIGHT, 5)]
        elif layout == "planes":
            parts = [pixels[..., c] for c in range(pixels.shape[2])] if pixels.ndim == 3 else [pixels]
        stored = [part.astype(part.dtype.newbyteorder(order)) for part in parts]
        strips = [CODES[method]([row.tobytes() for row in part]) for part in stored]
        more = {"t278": [5]} if layout == "strips" else {"t284": [2]} if layout == "planes" else {}
        if fill == 2:
            strips, more = [reversed_bits(strip) for strip in strips], more | {"t266": [2]}
        found = outcome(tmp_path, tiff(strips, bits, kind, order, method, **tags, **more))
        if found is None:
            continue
        assert meant is not None, (name, layout, fill)
        same = found == (meant[..., np.newaxis] if meant.ndim == 2 else meant)
        assert same.all(), (name, layout, fill, found[0, :2], meant[0, :2])
        if fill == 1:
            right.add((name, layout))
    assert right >= {(name, layout) for name in READ_ALL for layout in ("whole", "strips")}, right


@pytest.mark.parametrize("method", [1, 5, 8, 32773])
def test_a_tiff_with_a_predictor_is_read_where_the_compression_has_one(tmp_path, method):
    for pixels, bits, kind in ((GRAY, [8], 1), (RGB, [8] * 3, 2), (DEEP, [16], 1), (DEEP_RGB, [16] * 3, 2)):
        steps = pixels.copy()
        steps[:, 1:] -= pixels[:, :-1]
        strip = CODES[method]([row.tobytes() for row in steps.astype(steps.dtype.newbyteorder("<"))])
        data = tiff([strip], bits, kind, method=method, t317=[2])
        if method in (1, 32773):
            assert "predictor" in refusal(tmp_path, data), bits
        else:
            check(tmp_path, data, pixels if bits[0] == 8 else pixels >> 8, bits)
        floating = tiff([strip], bits, kind, method=method, t317=[3])
        assert outcome(tmp_path, floating) is None, bits


@pytest.mark.parametrize("across", [1, 2, 4])
@pytest.mark.parametrize("down", [1, 2])
@pytest.mark.parametrize("method", [1, 8])
def test_a_tiff_of_luma_and_subsampled_chroma_is_read(tmp_path, across, down, method):
    colors = np.zeros((24, 32, 3), np.uint8)
    colors[:12, :16], colors[12:, :16], colors[:12, 16:], colors[12:, 16:] = (
        *((200, 100, 50), (10, 200, 30), (30, 60, 220), (128, 128, 128)),
    )
    red, green, blue = np.moveaxis(colors.astype(float), 2, 0)
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    planes = [luma, (blue - luma) / 1.772 + 128, (red - luma) / 1.402 + 128]
    y, cb, cr = (np.rint(plane).astype(np.uint8) for plane in planes)
    units = [
        y[top : top + down, left : left + across].tobytes() + bytes([cb[top, left], cr[top, left]])
        for top in range(0, 24, down)
        for left in range(0, 32, across)
    ]
    tags = {"t256": [32], "t257": [24], "t278": [24], "t530": [across, down]}
    found = read(tmp_path, tiff([CODES[method](units)], [8] * 3, 6, method=method, **tags))
    assert np.abs(found.astype(int) - colors).max() <= 2, (across, down, found[0, 0], found[0, -1])
    assert outcome(tmp_path, tiff([CODES[method](units[:-1])], [8] * 3, 6, method=method, **tags)) is None
    for other in (5, 32773):
        message = refusal(tmp_path, tiff([CODES[other](units)], [8] * 3, 6, method=other, **tags))
        assert "not read" in message, other


def cut_strips():
    stored = [np.ascontiguousarray(part) for part in (GRAY, RGB, SMOOTH)]
    for method in CODES:
        for part in stored:
            yield method, [8] * (part.size // GRAY.size), [row.tobytes() for row in part], {}
        narrow = {"t320": COLORS.T.ravel().tolist()}
        yield method, [8], [row.tobytes() for row in GRAY], narrow


@pytest.mark.parametrize(("method", "bits", "rows", "tags"), list(cut_strips()))
def test_a_tiff_with_a_strip_that_is_missing_short_or_beyond_the_file_is_refused(
    tmp_path, method, bits, rows, tags
):
    kind = 3 if tags else 1 if len(bits) == 1 else 2
    strips = [CODES[method](rows[top : top + 8]) for top in range(0, HEIGHT, 8)]
    whole = tiff(strips, bits, kind, method=method, t278=[8], **tags)
    assert outcome(tmp_path, whole) is not None
    short = CODES[method](rows[8:15])
    for parts in (strips[:-1], [strips[0], short, strips[2]]):
        assert outcome(tmp_path, tiff(parts, bits, kind, method=method, t278=[8], **tags)) is None
    sizes = [len(strips[0]), len(strips[1]), len(whole)]
    assert outcome(tmp_path, tiff(strips, bits, kind, method=method, t278=[8], t279=sizes, **tags)) is None
    sizes = [len(strips[0]), len(strips[1]) // 2, len(strips[2])]
    assert outcome(tmp_path, tiff(strips, bits, kind, method=method, t278=[8], t279=sizes, **tags)) is None


def test_a_jpeg_in_a_tiff_is_that_jpeg_and_refused_where_it_is_cut(tmp_path):
    pixels = np.tile(SMOOTH, (2, 2, 1))[:32, :48]
    jpeg = by_pillow(pixels, "JPEG", quality=95)
    tags = {"t256": [48], "t257": [32], "t278": [32], "t530": [2, 2]}
    found = read(tmp_path, tiff([jpeg], [8] * 3, 6, method=7, **tags))
    assert np.array_equal(found, by_opencv(jpeg))
    for size in (len(jpeg) - 2, len(jpeg) - 9, len(jpeg) // 2):
        assert "end" in refusal(tmp_path, tiff([jpeg[:size]], [8] * 3, 6, method=7, **tags)), size


@pytest.mark.parametrize("method", ["group3", "group4", "tiff_ccitt", "lzma"])
def test_tiffs_whose_damage_would_not_be_seen_are_refused(tmp_path, method):
    data = by_pillow(Image.fromarray(GRAY > 99), "TIFF", compression=method)
    assert "compression" in refusal(tmp_path, data)


@pytest.mark.parametrize("method", [1, 5, 8, 32773])
def test_twelve_packed_bits_of_a_tiff_are_read(tmp_path, method):
    deep = DEEP >> 4
    bits = (deep[..., np.newaxis] >> np.arange(12)[::-1]) & 1
    rows = [np.packbits(row.ravel().astype(np.uint8)).tobytes() for row in bits]
    check(tmp_path, tiff([CODES[method](rows)], [12], 1, method=method), (deep >> 4).astype(np.uint8), "12")
    assert outcome(tmp_path, tiff([CODES[method](rows[:-2])], [12], 1, method=method)) is None


# Sixteen bits of which fewer are used -----------------------------------------------------------------


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_the_depth_that_a_file_states_is_used(tmp_path, bits):
    for deep, color in ((DEEP >> (16 - bits), 0), (DEEP_RGB >> (16 - bits), 2)):
        meant = (deep >> (bits - 8)).astype(np.uint8)
        count = 1 if color == 0 else 3
        said = chunk(b"sBIT", bytes([bits] * count))
        check(tmp_path, png(deep.astype(">u2"), 16, color, said), meant, ("sBIT", bits))
        kind, top = 1 if color == 0 else 2, [2**bits - 1]
        for order, tag in itertools.product("<>", ("t281", "t341")):
            strip = deep.astype(order + "u2").tobytes()
            data = tiff([strip], [16] * count, kind, order, **{tag: top * count})
            check(tmp_path, data, meant, (tag, bits))


def test_a_depth_that_the_values_exceed_or_fill_from_above_is_that_of_the_sensor(tmp_path):
    said = chunk(b"sBIT", b"\x0c")
    check(tmp_path, png(DEEP.astype(">u2"), 16, 0, said), DEEP >> 8, "as the specification has it")
    dark = (DEEP >> 12 << 8).astype(np.uint16)  # 4 of 12 bits, scaled to 16
    with pytest.warns(PictureWarning, match="no value of 16 bits is larger than 3840"):
        check(tmp_path, png(dark.astype(">u2"), 16, 0, said), dark >> 8, "dark, and scaled")


@pytest.mark.parametrize("bits", [9, 10, 12, 14])
@pytest.mark.parametrize("color", [0, 2])
def test_a_picture_of_16_bits_that_is_dark_throughout_is_read_with_a_warning(tmp_path, bits, color):
    deep = (DEEP if color == 0 else DEEP_RGB) >> (16 - bits)
    with pytest.warns(PictureWarning, match=rf"picture\.bin: .* {deep.max()},"):
        check(tmp_path, png(deep.astype(">u2"), 16, color), deep >> 8, bits)
    with pytest.warns(PictureWarning, match="view 3: no value of 16 bits"):
        as_rgb(deep, "view 3")


def test_no_warning_where_a_value_is_bright_or_all_are_black(tmp_path):
    bright = DEEP >> 3
    bright[0, 0] = 2**14
    check(tmp_path, png(bright.astype(">u2"), 16, 0), bright >> 8, "bright enough")
    check(tmp_path, png(np.zeros_like(bright), 16, 0), np.zeros_like(GRAY), "black")


# BMP --------------------------------------------------------------------------------------------------


def runs(rows, width=8):
    """Absolute runs for the first half of each row, then runs of equal pixels; with 4 or 8 bits a pixel."""
    out = b""
    for row in rows[::-1]:
        first, rest = row[:17], row[17:]
        stored = first.tobytes() if width == 8 else packed(first[np.newaxis], 4).tobytes()
        out += bytes([0, len(first)]) + stored + b"\0" * (len(stored) % 2)
        out += b"".join(bytes([1, int(pixel) << (8 - width) | int(pixel)]) for pixel in rest) + b"\0\0"
    return out + b"\0\1"


def with_runs(body, bits, palette, height=HEIGHT):
    quads = np.hstack([palette[:, ::-1], palette[:, :1] * 0]).tobytes()
    data = bmp([], bits, method={8: 1, 4: 2}[bits], palette=quads, colors=len(palette), height=height)
    return data + body


@pytest.mark.parametrize("bits", [4, 8])
@pytest.mark.parametrize("gray", [False, True])
def test_runs_of_a_bmp_are_read_where_they_fill_the_picture(tmp_path, bits, gray):
    levels = GRAY >> (8 - bits)
    palette = (
        np.repeat(np.arange(2**bits, dtype=np.uint8)[:, np.newaxis], 3, 1) if gray else COLORS[: 2**bits]
    )
    body = runs(levels, bits)
    check(tmp_path, with_runs(body, bits, palette), palette[levels], "runs")
    for wrong, why in (
        (body[:-2], "truncated"),
        (body[: len(body) // 2], "truncated"),
        (body[: len(body) // 2 // 2 * 2] + b"\0\1", "do not fill"),
        (b"\0\2\1\0" + body, "leave pixels out"),
        (runs(levels[1:], bits), "do not fill"),
        (runs(levels[:, 1:], bits), "do not fill"),
        (runs(np.hstack([levels, levels[:, :1]]), bits), "do not fill"),
        (b"\0\0" + body, "do not fill"),
    ):
        assert why in refusal(tmp_path, with_runs(wrong, bits, palette)), (why, wrong[:9])


@pytest.mark.parametrize("bits", [1, 4, 8])
def test_a_pixel_of_a_color_that_the_palette_lacks_is_refused(tmp_path, bits):
    levels, colors = GRAY >> (8 - bits), 2**bits - 1
    for palette in (COLORS[:colors], np.repeat(np.arange(colors, dtype=np.uint8)[:, np.newaxis], 3, 1)):
        quads = np.hstack([palette[:, ::-1], palette[:, :1] * 0])
        data = bmp(packed(levels, bits), bits, palette=quads.tobytes(), colors=colors)
        assert "more colors" in refusal(tmp_path, data), palette[:3]
        data = png(packed(levels, bits), bits, 3, chunk(b"PLTE", palette.tobytes()))
        assert "more colors" in refusal(tmp_path, data), palette[:3]


def test_masks_of_a_bmp_that_are_not_read_are_refused_never_black(tmp_path):
    stored = np.dstack([RGB[..., ::-1], np.zeros_like(GRAY)])
    for header, masks in itertools.product(
        (40, 56, 108),
        ((0x3FF00000, 0xFFC00, 0x3FF), (0xFF, 0xFF00, 0xFF0000), (0, 0, 0), (0xF800, 0x7E0, 0x1F)),
    ):
        assert refusal(tmp_path, bmp(stored, 32, header, 3, masks)), masks
    words = (RGB[..., 0].astype("<u2") << 7) & 0x7C00
    assert "alpha" in refusal(tmp_path, bmp(words, 16, 108, 3, (0x7C00, 0x3E0, 0x1F, 0x8000)))
    assert refusal(tmp_path, bmp(words, 16, 40, 3, (0xF00, 0xF0, 0xF)))


def test_a_fourth_byte_of_0_is_no_transparency(tmp_path):
    stored = np.empty((8, 8, 4), np.uint8)
    stored[:] = 50, 100, 200, 0
    header = struct.pack("<IiiHHIIiiII", 40, 8, 8, 1, 32, 3, 256, 2835, 2835, 0, 0)
    masks = struct.pack("<3I", *MASKS[3])
    data = b"BM" + struct.pack("<IHHI", 66 + 256, 0, 0, 66) + header + masks + stored.tobytes()
    assert (read(tmp_path, data) == (200, 100, 50)).all()


# PNG, JPEG and WebP -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("before", "after", "part"),
    [
        (chunk(b"ABCD", b"x"), b"", "affects its pixels"),
        (b"", chunk(b"tRNS", b"\0\1\0\2\0\3"), "tRNS"),
        (chunk(b"tRNS", b"\0\1\0\2\0\3") * 2, b"", "tRNS"),
        (b"", chunk(b"PLTE", b"\1\2\3"), "PLTE"),
        (chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH - 1, HEIGHT, 8, 2, 0, 0, 0)), b"", "IHDR"),
        (chunk(b"IDAT", b"\x78\x9c\x01"), b"", ""),
    ],
)
def test_a_png_with_chunks_that_decoders_take_differently_is_refused(tmp_path, before, after, part):
    assert part in refusal(tmp_path, png(RGB, 8, 2, before, after))


def test_a_palette_of_a_png_comes_before_its_transparency_and_once(tmp_path):
    table, clear = chunk(b"PLTE", COLORS.tobytes()), chunk(b"tRNS", b"\0" * 9)
    assert outcome(tmp_path, png(GRAY, 8, 3, table + clear)) is not None
    for before in (clear + table, table + table, b""):
        assert outcome(tmp_path, png(GRAY, 8, 3, before)) is None, before[:8]


@pytest.mark.parametrize("place", [26, 27, 28])
def test_a_png_with_an_unknown_method_is_refused(tmp_path, place):
    data = bytearray(png(RGB, 8, 2))
    data[place] = 7
    data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    assert "7" in refusal(tmp_path, bytes(data))


@pytest.mark.parametrize("place", [2, 30, 300, 900, -1])
def test_a_flipped_bit_inside_deflate_is_refused_though_the_chunk_has_its_checksum(tmp_path, place):
    stream = bytearray(zlib.compress(b"".join(b"\0" + row.tobytes() for row in RGB)))
    stream[place] ^= 4
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0))
    data = b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", bytes(stream)) + chunk(b"IEND", b"")
    assert outcome(tmp_path, data) is None
    strip = tiff([bytes(stream)], [8] * 3, 2, method=8)
    assert outcome(tmp_path, strip) is None


def test_four_inks_without_adobes_marker_are_refused(tmp_path):
    data = by_pillow(Image.fromarray(SMOOTH).convert("CMYK"), "JPEG", quality=95)
    place = data.index(b"\xff\xee")
    (size,) = struct.unpack_from(">H", data, place + 2)
    assert outcome(tmp_path, data) is not None
    assert "Adobe" in refusal(tmp_path, data[:place] + data[place + 2 + size :])


@pytest.mark.parametrize("precision", [12, 16])
def test_a_jpeg_of_more_than_8_bits_is_refused(tmp_path, precision):
    data = bytearray(by_pillow(SMOOTH, "JPEG"))
    data[data.index(b"\xff\xc0") + 4] = precision
    assert outcome(tmp_path, bytes(data)) is None


@pytest.mark.parametrize(
    "sampling",
    [
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_411,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_440,
    ],
)
def test_both_decoders_agree_on_jpegs_with_restarts_and_scans(tmp_path, sampling):
    for progressive, restart in itertools.product((0, 1), (0, 3)):
        options = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling, cv2.IMWRITE_JPEG_PROGRESSIVE, progressive]
        options += [cv2.IMWRITE_JPEG_RST_INTERVAL, restart]
        data = cv2.imencode(".jpg", SMOOTH[..., ::-1], options)[1].tobytes()
        assert np.array_equal(read(tmp_path, data), by_opencv(data)), (progressive, restart)
    colors = by_pillow(SMOOTH, "JPEG", keep_rgb=True, quality=95)
    assert np.array_equal(read(tmp_path, colors), by_opencv(colors))


@pytest.mark.parametrize("options", [{"lossless": True, "exact": True}, {"quality": 90}])
def test_both_decoders_agree_on_webps(tmp_path, options):
    for pixels in (SMOOTH, np.dstack([SMOOTH, GRAY | 1])):
        data = by_pillow(pixels, "WEBP", **options)
        found = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        other = found[..., [2, 1, 0, 3][: found.shape[2]]]
        check(tmp_path, data, as_rgb(other, "by OpenCV"), pixels.shape)


@pytest.mark.parametrize("kind", ["PNG", "WEBP", "TIFF"])
def test_a_picture_that_is_transparent_everywhere_is_refused(tmp_path, kind):
    clear = RGBA.copy()
    clear[..., 3] = 0
    options = {"lossless": True, "exact": True} if kind == "WEBP" else {}
    assert "transparent everywhere" in refusal(tmp_path, by_pillow(clear, kind, **options))
    clear[3, 5, 3] = 1
    assert outcome(tmp_path, by_pillow(clear, kind, **options)) is not None


def test_what_a_file_holds_counts_not_its_suffix(tmp_path):
    for name, kind in (("a.png", "BMP"), ("b.jpg", "PNG"), ("c.tif", "WEBP"), ("d.bmp", "TIFF")):
        stream = io.BytesIO()
        Image.fromarray(RGB).save(stream, kind, **({"lossless": True} if kind == "WEBP" else {}))
        (tmp_path / name).write_bytes(stream.getvalue())
        assert np.array_equal(read_image(tmp_path / name), RGB), name
