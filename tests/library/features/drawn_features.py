"""Configurations and small pictures, drawn by Hypothesis."""

import numpy as np
from hypothesis import strategies as st


@st.composite
def records(draw):
    """A legal configuration as plain JSON values."""
    size = draw(st.tuples(st.integers(8, 40), st.integers(8, 40)))
    cell = tuple(draw(st.integers(2, side)) for side in size)
    block = tuple(draw(st.integers(1, side // step)) for side, step in zip(size, cell, strict=True))
    method = draw(st.sampled_from(["uniform", "nri_uniform", "default", "ror"]))
    points = draw(st.integers(4, 24 if "uniform" in method else 10))
    codes = {"uniform": points + 2, "nri_uniform": points * (points - 1) + 3}
    histogram = draw(st.sampled_from(["by channel", "joint"]))
    return {
        "working_size": list(size),
        "color_histogram": histogram,
        "color_bins": 2 ** draw(st.integers(1, 8 if histogram == "by channel" else 4)),
        "hog_orientations": draw(st.integers(1, 18)),
        "hog_pixels_per_cell": list(cell),
        "hog_cells_per_block": list(block),
        "hog_block_norm": draw(st.sampled_from(["L1", "L1-sqrt", "L2", "L2-Hys"])),
        "hog_transform_sqrt": draw(st.booleans()),
        "lbp_points": points,
        "lbp_radius": draw(st.floats(1, (min(size) - 1) // 2) | st.integers(1, (min(size) - 1) // 2)),
        "lbp_method": method,
        "lbp_bins": codes.get(method, 2**points),
        "normalisation": draw(
            st.sampled_from(["unit length by modality", "sum one by modality", "unit length", "none"])
        ),
    }


@st.composite
def views(draw, low=8, high=30, top=255):
    """Noise, few levels (many equal neighbours), or blocks of one colour."""
    height, width = draw(st.integers(low, high)), draw(st.integers(low, high))
    seed, levels, block = (
        draw(st.integers(0, 2**32 - 1)),
        draw(st.sampled_from([1, 2, 5, 50])),
        draw(st.integers(1, 5)),
    )
    coarse = np.random.default_rng(seed).integers(0, levels, (height, width, 3)) * (top // max(levels - 1, 1))
    return np.kron(coarse, np.ones((block, block, 1), int))[:height, :width].astype(np.uint8)


@st.composite
def gray_views(draw, low=8, high=30, top=255):
    return np.ascontiguousarray(draw(views(low, high, top))[..., 0])
