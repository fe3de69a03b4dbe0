"""JPEGs: what libjpeg would fill in or guess is refused; what cameras leave in sound ones does no harm."""

import io
import re
import struct

import cv2
import numpy as np
import pytest
from picture_files import GRAY, HEIGHT, RGB, SMOOTH, WIDTH, by_pillow, check, outcome, refusal, tiff
from PIL import Image

SCENE = cv2.resize(SMOOTH, (120, 88), interpolation=cv2.INTER_CUBIC)
SCENE[20:60:3, 30:90] = RGB[:14, :20].repeat(3, axis=1)
FORMS = {
    "baseline": (SCENE, {}),
    "gray": (SCENE[..., 1], {}),
    "progressive": (SCENE, {"progressive": True}),
    "optimized": (SCENE, {"optimize": True, "quality": 40}),
    "restarts": (SCENE, {"restart_marker_blocks": 3}),
    "rgb": (SCENE, {"keep_rgb": True}),
    "inks": (Image.fromarray(SCENE).convert("CMYK"), {}),
}
SAMPLINGS = (0x411111, 0x221111, 0x211111, 0x121111, 0x111111)
END = b"\xff\xd9"


def jpeg(form):
    picture, options = FORMS[form]
    return by_pillow(picture, "JPEG", **options)


def scans(data):
    """Where the scans begin."""
    return [found.start() for found in re.finditer(b"\xff\xda", data)]


def pillow_pixels(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


@pytest.mark.parametrize("form", FORMS)
def test_a_jpeg_that_is_cut_and_closed_with_an_end_marker_is_refused(tmp_path, form):
    whole = jpeg(form)
    check(tmp_path, whole, pillow_pixels(whole), form)
    first = scans(whole)[0]
    for cut in [*range(first, len(whole) - 2, max(1, (len(whole) - first) // 60)), len(whole) - 6]:
        assert outcome(tmp_path, whole[:cut] + END) is None, (form, cut, len(whole))


@pytest.mark.parametrize("form", FORMS)
def test_a_jpeg_in_which_bytes_are_no_code_is_refused(tmp_path, form):
    whole = jpeg(form)
    first = scans(whole)[-1] + 20
    for share in (0.1, 0.5, 0.8):
        place = first + int((len(whole) - first) * share)
        data = whole[:place] + b"\xff\0" * 30 + whole[place + 60 :]
        assert "Corrupt JPEG data" in refusal(tmp_path, data), (form, share)


def test_a_jpeg_without_its_last_scans_is_refused(tmp_path):
    whole = jpeg("progressive")
    starts = scans(whole)
    assert len(starts) == 10, starts
    for start in starts:
        tables = whole.rfind(b"\xff\xc4", 0, start)
        cut = tables if tables > whole.rfind(b"\xff\xda", 0, start) else start
        for end in (cut, start):
            assert "truncated" in refusal(tmp_path, whole[:end] + END), (start, end)


def separate_scans(gray):
    """A JPEG with a scan for each of three components, all of them as in a gray one."""
    place = gray.index(b"\xff\xc0")
    start = scans(gray)[0]
    head = gray[:place] + struct.pack(">BBHBHHB", 0xFF, 0xC0, 17, 8, *gray_size(gray), 3)
    head += bytes((1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0)) + gray[place + 13 : start]
    code = gray[start + 10 : -2]
    parts = [bytes((0xFF, 0xDA, 0, 8, 1, number, 0, 0, 63, 0)) + code for number in (1, 2, 3)]
    return head, parts


def gray_size(data):
    return struct.unpack_from(">HH", data, data.index(b"\xff\xc0") + 5)


def test_a_jpeg_with_a_scan_for_each_component_needs_them_all(tmp_path):
    head, parts = separate_scans(jpeg("gray"))
    whole = head + b"".join(parts) + END
    check(tmp_path, whole, pillow_pixels(whole), "whole")
    for number in (0, 1, 2):
        assert "truncated" in refusal(tmp_path, head + b"".join(parts[:number]) + END)
    assert outcome(tmp_path, head + b"".join(parts[1:]) + END) is None


@pytest.mark.parametrize("progressive", [0, 1])
@pytest.mark.parametrize("sampling", [None, *SAMPLINGS])
def test_every_usual_sampling_is_read_as_pillow_and_opencv_do(tmp_path, sampling, progressive):
    for quality in (30, 75, 95, 100):
        for picture in (SCENE, RGB):
            flags = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_PROGRESSIVE, progressive]
            flags += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling] if sampling else []
            flags += [cv2.IMWRITE_JPEG_RST_INTERVAL, 0 if quality == 75 else 2]
            stored = picture[..., ::-1] if sampling else picture[..., 0]
            data = cv2.imencode(".jpg", np.ascontiguousarray(stored), flags)[1].tobytes()
            check(tmp_path, data, pillow_pixels(data), (sampling, quality))
            other = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB)
            check(tmp_path, data, other, (sampling, quality))


@pytest.mark.parametrize("gray", [False, True])
@pytest.mark.parametrize("padding", [b"\xff\0", b"\0", b"\xff\0\xff\0", b"\0" * 90, b"\xff" * 7])
def test_padding_that_cameras_insert_before_markers_changes_nothing(tmp_path, padding, gray):
    picture = SCENE[..., 0] if gray else SCENE
    for restart in ({"restart_marker_blocks": 2}, {"restart_marker_rows": 1}, {}):
        whole = by_pillow(picture, "JPEG", quality=60, **restart)
        start = scans(whole)[0]
        padded = whole[:start] + re.sub(b"(\xff[\xd0-\xd7\xd9])", padding + rb"\1", whole[start:])
        assert padded.count(padding) > 4 or not restart, restart
        check(tmp_path, padded, pillow_pixels(whole), (padding, restart))
        cut = whole[: (start + len(whole)) // 2]
        assert outcome(tmp_path, cut + padding * 20 + END) is None, (padding, restart)


def test_other_bytes_left_over_behind_the_code_are_refused(tmp_path):
    for form in ("baseline", "restarts"):
        whole = jpeg(form)
        assert "extraneous bytes" in refusal(tmp_path, whole[:-2] + b"Z" * 20 + END), form
    assert outcome(tmp_path, jpeg("restarts").replace(b"\xff\xd1", b"Z" * 20 + b"\xff\xd1", 1)) is None


@pytest.mark.parametrize(
    "extra",
    [
        b"\xff\xe2\0\x10ICC_PROFILE\0\2\1",
        b"\xff\xe0\0\x10JFIF\0\3\1\0\0\1\0\1\0\0",
        b"\xff\xe1\0\x0aExif\0\0II",
        b"\xff\xe0\0\x0aAVI1\0\0\0\0",
        b"\xff\xfe\0\2",
        b"bytes between segments \xff\0",
        b"\xff" * 9,
    ],
)
def test_faults_of_other_segments_and_bytes_between_segments_change_nothing(tmp_path, extra):
    for form in ("baseline", "gray", "inks"):
        whole = jpeg(form)
        place = whole.index(b"\xff\xdb")
        check(tmp_path, whole[:place] + extra + whole[place:], pillow_pixels(whole), (form, extra))


def test_tables_that_cameras_leave_out_are_the_usual_ones(tmp_path):
    whole = jpeg("baseline")
    bare = re.sub(rb"\xff\xc4(\0\x1f|\0\xb5).*?(?=\xff[\xc4\xda])", b"", whole, flags=re.DOTALL)
    assert len(bare) < len(whole) - 400, (len(bare), len(whole))
    check(tmp_path, bare, pillow_pixels(whole), "without Huffman tables")


def test_long_runs_of_the_same_byte_take_no_time(tmp_path):
    whole = jpeg("baseline")
    start, run = scans(whole)[0], 2**21
    for filling in (b"\xff", b"\0", b"\xff\0", b"\xff\xd0", b"\xff\xfe\0\2"):
        for place in (2, start, start + 40, len(whole) - 2):
            outcome(tmp_path, whole[:place] + filling * run + b"\1\0" + whole[place:])
            outcome(tmp_path, whole[:place] + filling * run)


@pytest.mark.parametrize(
    ("place", "value", "part"),
    [(1, 0xC9, "0xc9"), (1, 0xC3, "0xc3"), (4, 12, "0c bits"), (5, 0, "0 x 120"), (11, 0x31, "sampling")],
)
def test_frames_of_other_forms_are_refused(tmp_path, place, value, part):
    whole = jpeg("baseline")
    frame = whole.index(b"\xff\xc0")
    data = bytearray(whole)
    data[frame + place] = value
    if place == 5:
        data[frame + 6] = 0
    assert part in refusal(tmp_path, bytes(data)), (place, value)


def jpeg_tiff(strip, height=HEIGHT):
    return tiff([strip], [8, 8, 8], 6, method=7, t530=[2, 2], t278=[height])


def test_a_tiff_with_a_jpeg_that_is_cut_and_closed_is_refused(tmp_path):
    whole = by_pillow(SMOOTH, "JPEG", quality=90)
    check(tmp_path, jpeg_tiff(whole), pillow_pixels(whole), "whole")
    start = scans(whole)[0]
    for cut in range(start, len(whole) - 2, 40):
        assert outcome(tmp_path, jpeg_tiff(whole[:cut] + END)) is None, cut
    for size in ((WIDTH, HEIGHT - 8), (WIDTH - 8, HEIGHT), (WIDTH + 8, HEIGHT)):
        other = by_pillow(cv2.resize(SMOOTH, size), "JPEG", quality=90)
        assert "another size" in refusal(tmp_path, jpeg_tiff(other)), size
    assert "another size" in refusal(tmp_path, jpeg_tiff(by_pillow(GRAY, "JPEG")))
