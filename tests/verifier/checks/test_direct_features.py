"""The direct computations of HOG and LBP, on pictures whose features can be told by hand."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from convexperc.features.configuration import FeatureConfiguration
from verification.checks.pictures import UNIT, cell_histograms, code, hog, lbp, neighbours, normalised

SETTINGS = FeatureConfiguration(
    working_size=(16, 16), hog_pixels_per_cell=(8, 8), hog_cells_per_block=(2, 2),
    lbp_points=4, lbp_radius=1.0, lbp_bins=6,
)  # fmt: skip
ACROSS = np.tile(np.arange(0, 160, 10, dtype=np.uint8), (16, 1))
"""Brighter by 10 from one column to the next."""


def test_the_gradient_of_a_slope_is_in_one_bin_and_0_at_the_border() -> None:
    cells = cell_histograms(ACROSS.astype(np.float64), SETTINGS)
    # 7 of the 8 columns of a cell have the gradient (0, 20), those at the border none: 20 * 56 / 64
    assert np.array_equal(cells[:, :, 0], np.full((2, 2), 17.5)), cells[:, :, 0]
    assert not cells[:, :, 1:].any(), cells
    down = cell_histograms(ACROSS.T.astype(np.float64), SETTINGS)
    assert np.array_equal(down[:, :, 4], np.full((2, 2), 17.5)), "90 degrees lie in 80 .. 100"


def test_blocks_are_normalised_as_their_names_say() -> None:
    block = np.array([3.0, 4.0, 0.0])
    assert normalised(block, "L2") == pytest.approx([0.6, 0.8, 0.0], abs=1e-10)
    assert normalised(block, "L1") == pytest.approx([3 / 7, 4 / 7, 0.0], abs=1e-5)
    assert normalised(block, "L1-sqrt") == pytest.approx(np.sqrt([3 / 7, 4 / 7, 0.0]), abs=1e-5)
    assert normalised(block, "L2-Hys") == pytest.approx(np.sqrt([0.5, 0.5, 0.0]), abs=1e-8), "cut at 0.2"
    assert not normalised(np.zeros(3), "L2-Hys").any()
    assert hog(ACROSS, SETTINGS).reshape(4, 9)[:, 0] == pytest.approx(0.5), "four equal cells"


def test_neighbours_lie_on_the_circle_and_their_shares_add_up() -> None:
    for corners in neighbours(8, 1.5):
        total = sum(share for _, _, share in corners)
        assert total == UNIT**2, corners
        y, x = (sum(Fraction(at[k] * at[2], total) for at in corners) for k in (0, 1))
        assert abs(float(y * y + x * x) - 2.25) < 1e-4, (y, x)
    assert neighbours(4, 1.0) == [
        [(0, 1, UNIT**2)],
        [(-1, 0, UNIT**2)],
        [(0, -1, UNIT**2)],
        [(1, 0, UNIT**2)],
    ]


@pytest.mark.parametrize(
    ("bits", "uniform", "default"),
    [("0000", 0, 0), ("1111", 4, 15), ("1100", 2, 3), ("1001", 2, 9), ("1010", 5, 5), ("0100", 1, 2)],
)
def test_codes(bits: str, uniform: int, default: int) -> None:
    pattern = tuple(bit == "1" for bit in bits)
    assert (code(pattern, "uniform"), code(pattern, "default")) == (uniform, default), bits


def test_a_slope_and_a_flat_picture_have_one_pattern() -> None:
    for picture, expected in ((ACROSS, 3), (np.full((16, 16), 9, dtype=np.uint8), 4)):
        least, most = lbp(picture, SETTINGS)
        assert np.array_equal(least, most), (least, most)
        assert least[expected] == 14 * 14, (expected, least)


def test_a_bit_that_rounding_decides_is_left_open() -> None:
    settings = replace(SETTINGS, lbp_points=8, lbp_bins=10)
    picture = (np.add.outer(np.arange(16), -np.arange(16)) + 100).astype(np.uint8)
    # along a diagonal the interpolated neighbour equals the centre, although its four pixels differ
    least, most = lbp(picture, settings)
    assert least.sum() == 0.0, least
    assert most.max() == 14 * 14, most
