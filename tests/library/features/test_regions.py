"""The part of a picture that shows the object."""

import cv2
import numpy as np
import pytest

from convexperc.errors import ImageError
from convexperc.features import Region, cropped, masked, read_mask

PICTURE = np.random.default_rng(0).integers(1, 256, (20, 30, 3), dtype=np.uint8)


def ellipse() -> np.ndarray:
    rows, columns = np.mgrid[:20, :30]
    return ((rows - 9) / 6) ** 2 + ((columns - 14) / 9) ** 2 <= 1


def test_a_region_is_cut_out():
    part = cropped(PICTURE, Region(3, 5, 12, 9))
    np.testing.assert_array_equal(part, PICTURE[5:14, 3:15])
    assert not part.flags.writeable
    np.testing.assert_array_equal(cropped(PICTURE, Region(0, 0, 30, 20)), PICTURE)


def test_what_a_mask_leaves_out_is_black_and_its_bounding_box_is_cut_out():
    mask = ellipse()
    part = masked(PICTURE, mask)
    whole = np.where(mask[..., np.newaxis], PICTURE, 0)
    np.testing.assert_array_equal(part, whole[3:16, 5:24])
    assert Region.around(mask) == Region(5, 3, 19, 13)
    assert PICTURE.all()
    assert not part.flags.writeable


def test_a_mask_is_read_from_a_picture_where_it_is_not_black(tmp_path):
    mask = ellipse()
    path = tmp_path / "mask.png"
    for value in (1, 255):
        assert cv2.imwrite(str(path), np.where(mask, value, 0).astype(np.uint8))
        np.testing.assert_array_equal(read_mask(path), mask)
    assert cv2.imwrite(str(path), np.where(mask[..., np.newaxis], (0, 0, 9), 0).astype(np.uint8))
    np.testing.assert_array_equal(read_mask(path), mask)


@pytest.mark.parametrize("region", [Region(19, 0, 12, 8), Region(0, 13, 8, 8), Region(30, 20, 8, 8)])
def test_a_region_outside_of_the_picture_is_refused(region):
    with pytest.raises(ImageError, match=r"within the picture of 30 x 20 pixels \(width x height\)"):
        cropped(PICTURE, region, "view of a")


@pytest.mark.parametrize(
    "text", ["", "1,2,3", "1,2,3,4,5", "a,2,9,9", "-1,2,9,9", "1.5,2,9,9", "1,2,9,٩", "1,2,9," + "9" * 5000]
)
def test_a_region_is_four_integers(text):
    with pytest.raises(ImageError, match="x,y,width,height"):
        Region.parse(text)


def test_a_region_is_written_as_it_is_read():
    assert Region.parse(" 1, 2,30,40") == Region(1, 2, 30, 40)
    assert Region.parse(str(Region(1, 2, 30, 40))) == Region(1, 2, 30, 40)


def test_a_region_is_at_least_as_large_as_a_picture():
    assert Region(0, 0, 8, 8)
    with pytest.raises(ImageError, match="at least 8"):
        Region(0, 0, 7, 8)


def test_an_empty_a_small_and_a_foreign_mask_are_refused():
    mask = np.zeros((20, 30), dtype=np.bool_)
    with pytest.raises(ImageError, match="mark the object"):
        masked(PICTURE, mask)
    mask[3:10, 3:20] = True
    with pytest.raises(ImageError, match="17 x 7"):
        masked(PICTURE, mask)
    with pytest.raises(ImageError, match=r"size of the picture, \(20, 30\)"):
        masked(PICTURE, np.ones((30, 20), dtype=np.bool_))
