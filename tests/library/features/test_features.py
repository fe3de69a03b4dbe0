"""Features: what each modality counts, and what it must not depend on."""

import json
import math
import pickle

import numpy as np
import pytest
from drawn_features import gray_views, records, views
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import convexperc.features
from convexperc.errors import FeatureError, ImageError
from convexperc.features import FeatureConfiguration, extract, unit_length
from convexperc.features.color import color_histogram
from convexperc.features.extraction import normalise, raw_blocks
from convexperc.features.hog import hog_descriptor
from convexperc.features.lbp import lbp_histogram
from convexperc.features.pictures import as_rgb, resize, to_gray

EPSILON = float(np.finfo(np.float64).eps)
# scikit-image accumulates HOG cells in single precision: 2^-24 a sum of up to 256 pixels, then a division.
HOG_TOLERANCE = 2e-6
SEEDS = st.integers(0, 2**32 - 1)
SMALL = {"working_size": (24, 20), "hog_pixels_per_cell": (4, 5), "color_bins": 16}


SYMMETRIES = {
    "half turn": lambda a: a[::-1, ::-1],
    "quarter turn": np.rot90,
    "mirror": lambda a: a[:, ::-1],
    "transpose": lambda a: a.swapaxes(0, 1),
}


def lbp_exactly(gray, points, radius):
    """Bits in integers, positions rounded to 5 decimals, and the pixels where an equality is interpolated."""
    unit, margin = 10**5, math.ceil(radius)
    height, width = gray.shape
    bits = np.zeros((height - 2 * margin, width - 2 * margin, points), int)
    doubtful = np.zeros(bits.shape[:2], bool)
    for row, column, k in np.ndindex(bits.shape):
        angle = 2 * math.pi * k / points
        r = (row + margin) * unit + round(round(-radius * math.sin(angle), 5) * unit)
        c = (column + margin) * unit + round(round(radius * math.cos(angle), 5) * unit)
        (r0, dr), (c0, dc) = divmod(r, unit), divmod(c, unit)
        weights = {(0, 0): (unit - dr) * (unit - dc), (0, 1): (unit - dr) * dc}
        weights |= {(1, 0): dr * (unit - dc), (1, 1): dr * dc}
        center = int(gray[row + margin, column + margin])
        excess = sum(w * (int(gray[r0 + i, c0 + j]) - center) for (i, j), w in weights.items() if w)
        bits[row, column, k] = excess >= 0
        doubtful[row, column] |= excess == 0 and (dr > 0 or dc > 0)
    return bits, doubtful


def lbp_codes(bits, method):
    points = bits.shape[2]
    if method == "uniform":
        changes = (bits != np.roll(bits, 1, axis=2)).sum(axis=2)
        return np.where(changes <= 2, bits.sum(axis=2), points + 1)
    turns = [np.roll(bits, k, axis=2) @ 2 ** np.arange(points) for k in range(points)]
    return turns[0] if method == "default" else np.min(turns, axis=0)


def hog_slowly(gray, cell, block, orientations):
    """Dalal and Triggs' steps, one pixel at a time, with the L2-Hys block norm."""
    image = gray.astype(float)
    height, width = image.shape
    cells = np.zeros((height // cell, width // cell, orientations))
    for row, column in np.ndindex(cells.shape[0] * cell, cells.shape[1] * cell):
        down = image[row + 1, column] - image[row - 1, column] if 0 < row < height - 1 else 0.0
        across = image[row, column + 1] - image[row, column - 1] if 0 < column < width - 1 else 0.0
        direction = math.degrees(math.atan2(down, across)) % 180
        bin_ = int(direction / (180 / orientations)) % orientations
        cells[row // cell, column // cell, bin_] += math.hypot(down, across) / cell**2
    parts = []
    for row, column in np.ndindex(cells.shape[0] - block + 1, cells.shape[1] - block + 1):
        part = cells[row : row + block, column : column + block].ravel()
        part = np.minimum(part / math.sqrt((part**2).sum() + 1e-10), 0.2)
        parts.append(part / math.sqrt((part**2).sum() + 1e-10))
    return np.concatenate(parts)


def split(row, configuration):
    ends = np.cumsum(list(configuration.modality_sizes.values()))
    return dict(zip(configuration.modality_sizes, np.split(row, ends[:-1]), strict=True))


def test_the_defaults_have_the_natural_sizes():
    assert list(FeatureConfiguration().modality_sizes.items()) == [("color", 24), ("hog", 1764), ("lbp", 26)]


@given(record=records())
@settings(deadline=None, max_examples=50)
def test_a_configuration_survives_json_and_pickle(record):
    configuration = FeatureConfiguration.from_dict(record)
    assert configuration.to_dict() == record, (configuration.to_dict(), record)
    text = json.dumps(configuration.to_dict())
    again = FeatureConfiguration.from_dict(json.loads(text))
    assert again == configuration, (again, configuration)
    assert json.dumps(again.to_dict()) == text, (again.to_dict(), text)
    assert pickle.loads(pickle.dumps(configuration)) == configuration, configuration
    assert hash(again) == hash(configuration), (again, configuration)


def test_a_record_with_other_keys_is_refused():
    record = FeatureConfiguration().to_dict()
    for wrong, part in [
        (record | {"hog_bins": 9}, "Unknown: ['hog_bins']; missing: []"),
        ({k: v for k, v in record.items() if k != "lbp_bins"}, "Unknown: []; missing: ['lbp_bins']"),
        ({}, "working_size"),
        ([record], "mapping"),
        (None, "mapping"),
    ]:
        with pytest.raises(FeatureError) as caught:
            FeatureConfiguration.from_dict(wrong)
        assert part in str(caught.value), (part, str(caught.value))


WRONG = [
    ("working_size", [7, 128]),
    ("working_size", [128, 4097]),
    ("working_size", [128]),
    ("working_size", "ab"),
    ("working_size", 128),
    ("working_size", [128.0, 128]),
    ("color_histogram", "separate"),
    ("color_histogram", None),
    ("color_bins", 1),
    ("color_bins", 257),
    ("color_bins", 24),
    ("color_bins", True),
    ("color_bins", None),
    ("hog_orientations", 0),
    ("hog_orientations", "9"),
    ("hog_orientations", True),
    ("hog_cells_per_block", [True, 2]),
    ("hog_pixels_per_cell", [0, 8]),
    ("hog_pixels_per_cell", [65, 16]),
    ("hog_cells_per_block", [9, 2]),
    ("hog_cells_per_block", [2, 2, 2]),
    ("hog_block_norm", "l2"),
    ("hog_block_norm", None),
    ("hog_transform_sqrt", 1),
    ("lbp_points", 3),
    ("lbp_points", 25),
    ("lbp_radius", 0.5),
    ("lbp_radius", 64),
    ("lbp_radius", math.nan),
    ("lbp_radius", math.inf),
    ("lbp_radius", "3"),
    ("lbp_method", "var"),
    ("lbp_bins", 25),
    ("normalisation", "l2"),
    ("normalisation", True),
]


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_a_value_that_cannot_be_used_is_refused_by_name(name, value):
    with pytest.raises(FeatureError) as caught:
        FeatureConfiguration.from_dict(FeatureConfiguration().to_dict() | {name: value})
    assert name in caught.value.what, str(caught.value)


def test_other_forms_of_the_same_numbers_become_plain_ones():
    record = FeatureConfiguration().to_dict() | {
        "color_bins": np.int64(8),
        "working_size": (np.int32(64), 96),
    }
    configuration = FeatureConfiguration.from_dict(record | {"lbp_radius": 2})
    found = json.loads(json.dumps(configuration.to_dict()))
    assert found == record | {"color_bins": 8, "working_size": [64, 96], "lbp_radius": 2.0}, found
    kinds = [type(value) for value in (configuration.color_bins, configuration.lbp_radius)]
    assert kinds == [int, float], kinds


def test_values_that_do_not_fit_together_are_refused_at_construction():
    for wrong, part in [
        ({"working_size": (16, 16)}, "hog_pixels_per_cell"),
        ({"lbp_points": 8}, "must be 10"),
        ({"lbp_method": "nri_uniform"}, "must be 555"),
        ({"lbp_points": 8, "lbp_method": "ror"}, "must be 256"),
        ({"lbp_radius": 63.5}, "fit into working_size"),
        ({"color_bins": 3}, "divide 256"),
        ({"color_bins": 512}, "from 2 to 256"),
        ({"color_bins": 64, "color_histogram": "joint"}, "at most 32"),
    ]:
        with pytest.raises(FeatureError) as caught:
            FeatureConfiguration(**wrong)
        assert part in str(caught.value), (part, str(caught.value))


def test_the_package_offers_its_names_and_no_other():
    assert convexperc.features.extract is extract, convexperc.features.extract
    with pytest.raises(AttributeError, match="attribute nothing"):
        _ = convexperc.features.nothing


@given(view=views(), bins=st.integers(1, 8).map(lambda power: 2**power), seed=SEEDS)
@settings(deadline=None, max_examples=50)
def test_a_color_histogram_counts_every_pixel_wherever_it_lies(view, bins, seed):
    configuration = FeatureConfiguration(color_bins=bins)
    found = color_histogram(view, configuration)
    naive = [((view[..., c].astype(int) * bins) // 256 == b).sum() for c in range(3) for b in range(bins)]
    assert found.tolist() == naive, (found, naive)
    sums = found.reshape(3, bins).sum(axis=1)
    assert (sums == view.shape[0] * view.shape[1]).all(), (sums, view.shape)
    shuffled = np.random.default_rng(seed).permutation(view.reshape(-1, 3)).reshape(view.shape)
    for moved in [shuffled, view[::-1], view[:, ::-1], np.rot90(view), view.swapaxes(0, 1)]:
        other = color_histogram(moved, configuration)
        assert np.array_equal(other, found), (other, found)


@given(view=views(), bins=st.integers(1, 5).map(lambda power: 2**power))
@settings(deadline=None, max_examples=50)
def test_a_joint_color_histogram_counts_the_colors_and_has_the_others_as_its_sums(view, bins):
    joint = color_histogram(view, FeatureConfiguration(color_histogram="joint", color_bins=bins))
    naive = np.zeros((bins, bins, bins))
    for red, green, blue in view.reshape(-1, 3).astype(int) * bins // 256:
        naive[red, green, blue] += 1
    cube = joint.reshape(bins, bins, bins)
    assert np.array_equal(cube, naive), np.abs(cube - naive).max()
    sums = [cube.sum(axis=tuple({0, 1, 2} - {channel})) for channel in range(3)]
    by_channel = color_histogram(view, FeatureConfiguration(color_bins=bins))
    assert np.array_equal(np.concatenate(sums), by_channel), (sums, by_channel)


@given(view=views(), order=st.permutations(range(3)))
@settings(deadline=None, max_examples=50)
def test_swapped_channels_swap_the_histograms_and_gray_ones_are_equal(view, order):
    configuration = FeatureConfiguration(color_bins=32)
    found = color_histogram(view, configuration).reshape(3, 32)
    swapped = color_histogram(view[..., order], configuration).reshape(3, 32)
    assert np.array_equal(swapped, found[order]), (order, swapped, found)
    gray = color_histogram(as_rgb(view[..., 0], "gray"), configuration).reshape(3, 32)
    assert (gray == found[0]).all(), (gray, found)


@given(
    gray=gray_views(high=16),
    points=st.sampled_from([4, 8, 12, 24]),
    radius=st.sampled_from([1.0, 2.5, 3.0]),
    method=st.sampled_from(["uniform", "default", "ror"]),
)
@settings(deadline=None, max_examples=50)
def test_lbp_agrees_with_exact_arithmetic_where_no_equality_is_interpolated(gray, points, radius, method):
    points = min(points, 24 if method == "uniform" else 12)
    bins = points + 2 if method == "uniform" else 2**points
    bits, doubtful = lbp_exactly(gray, points, radius)
    configuration = FeatureConfiguration(
        lbp_points=points, lbp_radius=radius, lbp_method=method, lbp_bins=bins
    )
    found = lbp_histogram(gray, configuration)
    expected = np.bincount(lbp_codes(bits, method).ravel(), minlength=bins)
    assert found.sum() == doubtful.size, (found.sum(), doubtful.shape)
    off = np.abs(found - expected).sum()
    assert off <= 2 * doubtful.sum(), (off, doubtful.sum(), found, expected)


@given(gray=gray_views(), points=st.integers(4, 24))
@settings(deadline=None, max_examples=50)
def test_uniform_codes_are_the_other_uniform_codes_without_their_direction(gray, points):
    uniform = FeatureConfiguration(lbp_points=points, lbp_bins=points + 2)
    bins = points * (points - 1) + 3
    directed = FeatureConfiguration(lbp_points=points, lbp_bins=bins, lbp_method="nri_uniform")
    fine, coarse = lbp_histogram(gray, directed), lbp_histogram(gray, uniform)
    merged = [fine[0], *fine[1:-2].reshape(points - 1, points).sum(axis=1), fine[-2], fine[-1]]
    assert coarse.tolist() == merged, (coarse, merged)


@given(
    gray=gray_views(top=200), radius=st.integers(1, 3), method=st.sampled_from(["uniform", "ror"]), seed=SEEDS
)
@settings(deadline=None, max_examples=50)
def test_lbp_without_interpolation_ignores_symmetries_and_rising_brightness(gray, radius, method, seed):
    bins = {"uniform": 6, "ror": 16}[method]
    configuration = FeatureConfiguration(
        lbp_points=4, lbp_radius=float(radius), lbp_method=method, lbp_bins=bins
    )
    found = lbp_histogram(gray, configuration)
    rising = np.sort(np.random.default_rng(seed).permutation(256)[:201]).astype(np.uint8)
    for change, other in {
        **{name: turn(gray) for name, turn in SYMMETRIES.items() if method == "uniform" or "turn" in name},
        "brighter": gray + np.uint8(55),
        "rising": rising[gray],
    }.items():
        changed = lbp_histogram(np.ascontiguousarray(other), configuration)
        assert np.array_equal(changed, found), (change, changed, found)


@given(gray=gray_views(low=14, high=20, top=200), constant=st.integers(0, 55))
@settings(deadline=None, max_examples=20)
def test_default_lbp_ignores_a_constant_except_where_an_equality_is_interpolated(gray, constant):
    configuration = FeatureConfiguration()
    found = lbp_histogram(gray, configuration)
    brighter = lbp_histogram(gray + np.uint8(constant), configuration)
    _, doubtful = lbp_exactly(gray, 24, 3.0)
    assert np.abs(brighter - found).sum() <= 2 * doubtful.sum(), (brighter, found, doubtful.sum())


@given(gray=gray_views(low=12, high=26), orientations=st.sampled_from([4, 9]))
@settings(deadline=None, max_examples=40)
def test_hog_agrees_with_the_textbook_steps(gray, orientations):
    configuration = FeatureConfiguration(hog_pixels_per_cell=(6, 6), hog_orientations=orientations)
    found = hog_descriptor(gray, configuration)
    slow = hog_slowly(gray, 6, 2, orientations)
    worst = np.abs(found - slow).max()
    assert worst <= HOG_TOLERANCE, (worst, found, slow)


@pytest.mark.parametrize("step", [1, 2, 255])
def test_hog_is_taken_of_the_eight_bit_values(step):
    gray = np.zeros((24, 24), np.uint8)
    gray[10, 10] = step
    found = hog_descriptor(gray, FeatureConfiguration(hog_pixels_per_cell=(12, 12), hog_block_norm="L2"))
    # Two pixels each see a gradient of `step` across and down; 1e-5 is scikit-image's guard against zero.
    length = math.hypot(2 * step / 144, 2 * step / 144)
    expected = length / math.hypot(length, 1e-5)
    assert abs(np.linalg.norm(found) - expected) <= HOG_TOLERANCE, (np.linalg.norm(found), expected)


@given(gray=gray_views(low=12, top=200), constant=st.integers(0, 55))
@settings(deadline=None, max_examples=50)
def test_hog_ignores_a_constant_exactly_and_a_negative_nearly(gray, constant):
    configuration = FeatureConfiguration(hog_pixels_per_cell=(4, 4))
    found = hog_descriptor(gray, configuration)
    brighter = hog_descriptor(gray + np.uint8(constant), configuration)
    assert np.array_equal(brighter, found), (constant, np.abs(brighter - found).max())
    negative = hog_descriptor(255 - gray, configuration)
    assert np.abs(negative - found).max() <= HOG_TOLERANCE, np.abs(negative - found).max()
    lengths = np.linalg.norm(found.reshape(-1, 36), axis=1)
    assert found.min() >= 0, found.min()
    assert lengths.max() <= 1 + HOG_TOLERANCE, lengths.max()


@given(gray=gray_views(low=24, high=24))
@settings(deadline=None, max_examples=50)
def test_a_half_turn_reverses_the_cells_of_hog(gray):
    configuration = FeatureConfiguration(**SMALL | {"hog_pixels_per_cell": (4, 4)})
    found = hog_descriptor(gray, configuration).reshape(5, 5, 2, 2, 9)
    turned = hog_descriptor(np.ascontiguousarray(gray[::-1, ::-1]), configuration).reshape(found.shape)
    worst = np.abs(turned[::-1, ::-1, ::-1, ::-1] - found).max()
    assert worst <= HOG_TOLERANCE, worst


@given(view=views(), record=records())
@settings(deadline=None, max_examples=40)
def test_every_configuration_gives_the_promised_columns(view, record):
    configuration = FeatureConfiguration.from_dict(record)
    matrix = extract([view, view[::-1]], configuration)
    sizes = configuration.modality_sizes
    assert matrix.shape == (2, sum(sizes.values())), (matrix.shape, sizes)
    assert np.isfinite(matrix).all(), matrix
    assert matrix.min() >= 0, matrix.min()
    height, width = configuration.working_size
    for modality, block in split(matrix[0], configuration).items():
        if configuration.normalisation == "none":
            margin = configuration.lbp_margin
            histograms = 3 if configuration.color_histogram == "by channel" else 1
            counts = {
                "color": histograms * height * width,
                "lbp": (height - 2 * margin) * (width - 2 * margin),
            }
            assert block.sum() == counts.get(modality, block.sum()), (modality, block.sum(), counts)
        elif configuration.normalisation != "unit length":
            sums = configuration.normalisation == "sum one by modality"
            length = block.sum() if sums else np.linalg.norm(block)
            # A norm of k entries is off by at most about k / 2 roundings.
            legal = abs(length - 1) <= (block.size + 4) * EPSILON or (modality == "hog" and length == 0)
            assert legal, (modality, length)
    if configuration.normalisation == "unit length":
        assert abs(np.linalg.norm(matrix[0]) - 1) <= (matrix.shape[1] + 4) * EPSILON, matrix[0]


@given(batch=st.lists(views(), min_size=1, max_size=4), data=st.data())
@settings(deadline=None, max_examples=40)
def test_each_row_depends_on_its_view_alone(batch, data):
    configuration = FeatureConfiguration(**SMALL)
    matrix = extract(batch, configuration)
    order = data.draw(st.permutations(range(len(batch))))
    permuted = extract(tuple(batch[i] for i in order), configuration)
    assert np.array_equal(permuted, matrix[list(order)]), (order, permuted, matrix)
    again = extract(iter(batch), configuration)
    assert again.tobytes() == matrix.tobytes(), np.abs(again - matrix).max()


@given(view=views())
@settings(deadline=None, max_examples=40)
def test_the_same_picture_in_another_form_has_the_same_features(view):
    configuration = FeatureConfiguration(**SMALL)
    gray, deep = view[..., 0], view.astype(np.uint16) * 257
    opaque = np.dstack([view, np.full(view.shape[:2], 255, np.uint8)])
    for first, second in [(view, deep), (view, opaque), (gray, np.stack([gray] * 3, axis=2))]:
        found = extract([first, second], configuration)
        assert np.array_equal(found[0], found[1]), (
            first.dtype,
            second.dtype,
            np.abs(found[0] - found[1]).max(),
        )


@pytest.mark.parametrize("value", [0, 1, 77, 254, 255])
def test_black_and_uniform_pictures_are_legal(value):
    configuration = FeatureConfiguration()
    view = np.full((60, 80, 3), value, np.uint8)
    blocks = split(extract([view], configuration)[0], configuration)
    color = blocks["color"].reshape(3, configuration.color_bins)
    filled = color[:, value * configuration.color_bins // 256]
    assert np.allclose(filled, 1 / math.sqrt(3), rtol=4 * EPSILON), filled
    assert np.count_nonzero(color) == 3, np.nonzero(color)
    assert not blocks["hog"].any(), blocks["hog"].max()
    assert abs(np.linalg.norm(blocks["lbp"]) - 1) <= 30 * EPSILON, blocks["lbp"]
    # On the axes nothing is interpolated, so every neighbour equals the centre on every processor.
    axes = FeatureConfiguration(lbp_points=4, lbp_bins=6)
    assert np.array_equal(extract([view], axes)[0, -6:], np.eye(6)[4]), extract([view], axes)[0, -6:]


def test_the_blocks_are_the_modalities_of_the_resized_picture():
    view = np.random.default_rng(5).integers(0, 256, (90, 70, 3), dtype=np.uint8)
    configuration = FeatureConfiguration(**SMALL, normalisation="none")
    picture = resize(view, (24, 20))
    expected = {
        "color": color_histogram(picture, configuration),
        "hog": hog_descriptor(to_gray(picture), configuration),
        "lbp": lbp_histogram(to_gray(picture), configuration),
    }
    raw = extract([view], configuration)
    unit = split(extract([view], FeatureConfiguration(**SMALL))[0], configuration)
    for modality, block in split(raw[0], configuration).items():
        assert np.array_equal(block, expected[modality]), (modality, block, expected[modality])
        assert np.array_equal(unit[modality], unit_length(block)), (modality, unit[modality])
        assert np.array_equal(raw_blocks(view, configuration)[modality], block), modality
        summed = split(normalise(expected, "sum one by modality"), configuration)[modality]
        assert np.array_equal(summed, block / block.sum()), (modality, summed)
    assert np.array_equal(normalise(expected, "unit length"), unit_length(raw[0])), raw
    dark = {"color": np.ones(3), "hog": np.zeros(4)}
    assert normalise(dark, "sum one by modality").tolist() == [1 / 3, 1 / 3, 1 / 3, 0, 0, 0, 0]
    assert not raw.flags.writeable, raw.flags


def test_what_is_not_several_pictures_is_refused():
    view = np.zeros((20, 20, 3), np.uint8)
    for images, kind, part in [
        ([], FeatureError, "at least one"),
        (view, FeatureError, "not one"),
        (view[..., 0], FeatureError, "not one"),
        ([view, view / 2.0], ImageError, "images[1]"),
        ([view, view, view[:5]], ImageError, "images[2]"),
        ("photo.png", ImageError, "images[0]"),
    ]:
        with pytest.raises(kind) as caught:
            extract(images, FeatureConfiguration(**SMALL))
        assert part in str(caught.value), (part, str(caught.value))
    assert extract(np.stack([view, view]), FeatureConfiguration(**SMALL)).shape[0] == 2


MAGNITUDES = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)


@given(vector=hnp.arrays(np.float64, st.integers(0, 12), elements=MAGNITUDES))
@settings(deadline=None, max_examples=200)
def test_unit_length_holds_from_subnormal_to_the_largest_numbers(vector):
    unit = unit_length(vector)
    if not vector.any():
        assert not unit.any(), unit
        return
    assert abs(math.hypot(*unit) - 1) <= (vector.size + 4) * EPSILON, (math.hypot(*unit), vector)
    largest = np.abs(vector).argmax()
    assert np.abs(unit).argmax() == largest or np.abs(unit).max() == np.abs(unit[largest]), (unit, vector)
    assert (unit * np.sign(vector) >= 0).all(), (unit, vector)
    assert np.array_equal(unit_length(-vector), -unit), (vector, unit)


@given(vector=hnp.arrays(np.float64, 5, elements=st.floats(1e-3, 1e3)), power=st.integers(-900, 900))
@settings(deadline=None, max_examples=50)
def test_unit_length_ignores_a_power_of_two_exactly(vector, power):
    scaled = unit_length(np.ldexp(vector, power))
    assert np.array_equal(scaled, unit_length(vector)), (power, scaled, unit_length(vector))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_unit_length_refuses_what_is_not_finite(value):
    with pytest.raises(FeatureError, match="must be finite"):
        unit_length(np.array([1.0, value]))
