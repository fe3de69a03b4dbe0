"""Damaged entries of a TIFF's directory: what decoders skip, guess or read wrong is refused."""

import struct
import zlib

import numpy as np
import pytest
from picture_files import (
    DEEP,
    GRAY,
    HEIGHT,
    RGB,
    SMOOTH,
    WIDTH,
    bmp,
    by_pillow,
    check,
    outcome,
    refusal,
    tiff,
)

LZW = by_pillow(SMOOTH, "TIFF", compression="tiff_lzw", tiffinfo={317: 2})
DEFLATED = by_pillow(GRAY, "TIFF", compression="tiff_adobe_deflate", tiffinfo={317: 2})
PACKED = by_pillow(SMOOTH, "TIFF", compression="packbits")
PLAIN = tiff([RGB.tobytes()], [8, 8, 8], 2)
FILES = {
    "lzw": (LZW, SMOOTH),
    "deflate": (DEFLATED, GRAY),
    "packbits": (PACKED, SMOOTH),
    "plain": (PLAIN, RGB),
}
AFFECT_PIXELS = {256, 257, 258, 259, 262, 273, 277, 278, 279, 284, 317, 339}


def entries(data):
    """The place of each entry by its tag."""
    (start,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, start)
    places = range(start + 2, start + 2 + 12 * count, 12)
    return {struct.unpack_from("<H", data, place)[0]: place for place in places}


def changed(data, place, layout, value):
    copy = bytearray(data)
    struct.pack_into(layout, copy, place, value)
    return bytes(copy)


@pytest.mark.parametrize("form", FILES)
def test_every_entry_of_another_type_or_number_is_refused(tmp_path, form):
    data, pixels = FILES[form]
    check(tmp_path, data, pixels, form)
    places = entries(data)
    assert len(AFFECT_PIXELS & places.keys()) >= 9, places
    for tag in AFFECT_PIXELS & places.keys():
        for kind in (0, 2, 5, 7, 12, 127, 200, 259):
            assert outcome(tmp_path, changed(data, places[tag] + 2, "<H", kind)) is None, (tag, kind)
        for number in (0, 2, 8, 200, 2**31):
            assert outcome(tmp_path, changed(data, places[tag] + 4, "<I", number)) is None, (tag, number)


@pytest.mark.parametrize("form", FILES)
def test_an_entry_whose_tag_is_lost_or_doubled_gives_the_same_pixels_or_none(tmp_path, form):
    data, pixels = FILES[form]
    places = entries(data)
    for tag in AFFECT_PIXELS - {262, 317} & places.keys():
        for other in places:
            found = outcome(tmp_path, changed(data, places[tag], "<H", other))
            assert found is None or np.array_equal(found[..., 0], pixels.reshape(HEIGHT, WIDTH, -1)[..., 0])
    for tag in AFFECT_PIXELS & places.keys():
        other = max(places.keys() - {tag})
        assert "twice" in refusal(tmp_path, changed(data, places[other], "<H", tag)), (tag, other)


def test_samples_of_different_depths_are_refused(tmp_path):
    for bits in ([8, 8, 520], [8, 16, 8], [8, 8, 7]):
        assert "bits" in refusal(tmp_path, tiff([RGB.tobytes()], bits, 2)), bits


def test_strips_that_hold_more_than_is_stated_are_refused(tmp_path):
    for method in (1, 8):
        stored = DEEP.astype("<u2").tobytes()
        strip = stored if method == 1 else zlib.compress(stored)
        check(tmp_path, tiff([strip], [16], 1, method=method), DEEP >> 8, method)
        for bits in (8, 4, 2, 1):
            assert outcome(tmp_path, tiff([strip], [bits], 1, method=method)) is None, (method, bits)
        narrow = tiff([strip], [16], 1, method=method, t256=[WIDTH - 8])
        assert outcome(tmp_path, narrow) is None, method
        spare = stored + b"\0" * 3 if method == 1 else zlib.compress(stored + b"\0" * 3)
        check(tmp_path, tiff([spare], [16], 1, method=method), DEEP >> 8, "aligned")


def test_strips_that_overlap_are_refused_and_equal_ones_may_be_stored_once(tmp_path):
    rows = [RGB[top : top + 8].tobytes() for top in (0, 8, 16)]
    data = tiff(rows, [8] * 3, 2, t278=[8])
    check(tmp_path, data, RGB, "apart")
    (places,) = struct.unpack_from("<I", data, entries(data)[273] + 8)
    for number in range(3):
        for wrong in (1, 8 + len(rows[0]) // 2, 8 + len(rows[0]) + 4):
            assert "overlap" in refusal(tmp_path, changed(data, places + 4 * number, "<I", wrong)), number
    same = changed(data, places + 4, "<I", 8)
    check(tmp_path, same, np.vstack([RGB[:8], RGB[:8], RGB[16:]]), "stored once")


def test_a_tile_larger_than_any_picture_is_refused_before_it_is_decoded(tmp_path):
    without = (273, 278, 279)
    for method, strip in ((5, b"\x80\0" * 50), (32773, b"\x81\0" * 100), (8, zlib.compress(b"\0" * 100))):
        tags = {"t322": [2**14], "t323": [2**13], "t324": [8], "t325": [len(strip)]}
        message = refusal(tmp_path, tiff([strip], [8], 1, method=method, dropped=without, **tags))
        assert "a tile of more than" in message, (method, message)


def test_compressed_samples_whose_bits_are_not_stated_are_refused(tmp_path):
    for form in ("lzw", "packbits"):
        data, _ = FILES[form]
        assert outcome(tmp_path, changed(data, entries(data)[258], "<H", 60000)) is None, form
    data = by_pillow(GRAY, "TIFF", compression="packbits")
    assert "bits" in refusal(tmp_path, changed(data, entries(data)[258], "<H", 250)), "gray"


def test_a_bmp_whose_pixels_would_lie_in_its_header_is_refused(tmp_path):
    masked = {"method": 3, "masks": (0xFF0000, 0xFF00, 0xFF)}
    for bits, options, head in ((24, {}, 54), (32, masked, 66), (24, {"header": 12}, 26)):
        rows = RGB if bits == 24 else np.dstack([RGB, RGB[..., 0]])
        data = bmp(rows, bits, **options)
        assert outcome(tmp_path, data) is not None, options
        for start in (1, 14, 30, head - 1):
            if start < head:
                assert "header" in refusal(tmp_path, changed(data, 10, "<I", start)), (options, start)
