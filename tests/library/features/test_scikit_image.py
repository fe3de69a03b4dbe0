"""LBP and HOG by machine code are those of scikit-image, to the last bit."""

import numpy as np
import pytest
from drawn_features import gray_views, records
from hypothesis import given, settings
from skimage.feature import hog, local_binary_pattern

from convexperc.features import FeatureConfiguration, resize, to_gray
from convexperc.features import hog as shape
from convexperc.features import lbp as texture
from convexperc.kernels.kernel import CHOICE_VARIABLE
from convexperc.recognition.sample import sample_scene

DEFAULT = FeatureConfiguration()
KERNELS = (texture.comparing_kernel, shape.summing_kernel)


@pytest.fixture(scope="module", autouse=True)
def machine_code():
    """Machine code for all work."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(CHOICE_VARIABLE, "compiled")
        assert all(kernel.replaces(0.0) for kernel in KERNELS)
        yield


def patterns_by_scikit_image(gray, configuration):
    codes = local_binary_pattern(
        gray, P=configuration.lbp_points, R=configuration.lbp_radius, method=configuration.lbp_method
    )
    margin = configuration.lbp_margin
    inner = codes[margin:-margin, margin:-margin].astype(int)
    return np.bincount(inner.ravel(), minlength=configuration.lbp_bins).astype(float)


def gradients_by_scikit_image(gray, configuration):
    return hog(
        gray,
        orientations=configuration.hog_orientations,
        pixels_per_cell=configuration.hog_pixels_per_cell,
        cells_per_block=configuration.hog_cells_per_block,
        block_norm=configuration.hog_block_norm,
        transform_sqrt=configuration.hog_transform_sqrt,
    )


def differences(gray, configuration):
    """Of which modality some value is not scikit-image's."""
    found = {
        "lbp": texture.lbp_histogram(gray, configuration),
        "hog": shape.hog_descriptor(gray, configuration),
    }
    expected = {
        "lbp": patterns_by_scikit_image(gray, configuration),
        "hog": gradients_by_scikit_image(gray, configuration),
    }
    return [modality for modality in found if found[modality].tobytes() != expected[modality].tobytes()]


def ramp(down, across):
    rows, columns = np.mgrid[:128, :128]
    return (down * rows + across * columns).astype(np.uint8)


RANDOM = np.random.default_rng(7)
DOTS = np.full((128, 128), 77, np.uint8)
DOTS[RANDOM.integers(0, 128, 300), RANDOM.integers(0, 128, 300)] = RANDOM.integers(0, 256, 300)
PICTURES = {
    "noise": RANDOM.integers(0, 256, (128, 128), dtype=np.uint8),
    "faint noise": RANDOM.integers(100, 103, (128, 128), dtype=np.uint8),
    "dots": DOTS,
    "black and white": RANDOM.integers(0, 2, (128, 128), dtype=np.uint8) * np.uint8(255),
    "tiles": np.kron(RANDOM.integers(0, 256, (16, 16), dtype=np.uint8), np.ones((8, 8), np.uint8)),
    **{f"flat {value}": np.full((128, 128), value, np.uint8) for value in (0, 1, 3, 77, 200, 255)},
    **{f"ramp {steps}": ramp(*steps) for steps in ((1, 0), (0, 1), (1, 1), (2, -1), (3, 7))},
}


@given(gray=gray_views(high=40), record=records())
@settings(deadline=None, max_examples=150)
def test_every_configuration_gives_the_values_of_scikit_image(gray, record):
    configuration = FeatureConfiguration.from_dict(record)
    fitted = resize(np.dstack([gray] * 3), configuration.working_size)[..., 0]
    assert not differences(np.ascontiguousarray(fitted), configuration), record


@pytest.mark.parametrize("norm", ["L1", "L1-sqrt", "L2", "L2-Hys"])
@pytest.mark.parametrize("block", [(8, 1), (1, 8), (3, 5), (9, 1)])
def test_blocks_of_one_direction_have_the_values_of_scikit_image(block, norm):
    configuration = FeatureConfiguration(
        hog_orientations=1, hog_pixels_per_cell=(2, 2), hog_cells_per_block=block, hog_block_norm=norm
    )
    assert not differences(PICTURES["noise"], configuration)


@given(gray=gray_views(high=16), record=records())
@settings(deadline=None, max_examples=25)
def test_the_interpreted_kernels_give_the_values_of_scikit_image(gray, record):
    with pytest.MonkeyPatch.context() as patch:
        for kernel in KERNELS:
            patch.setattr(kernel, "compiled", kernel.interpreted)
        configuration = FeatureConfiguration.from_dict(record)
        fitted = resize(np.dstack([gray] * 3), configuration.working_size)[..., 0]
        assert not differences(np.ascontiguousarray(fitted), configuration), record


def test_little_work_is_done_by_scikit_image_and_much_by_machine_code(monkeypatch):
    monkeypatch.delenv(CHOICE_VARIABLE)
    gray, found = PICTURES["dots"], []
    for module, describe in ((texture, texture.lbp_histogram), (shape, shape.hog_descriptor)):
        for name in ("_by_scikit_image", "_by_machine_code"):
            monkeypatch.setattr(module, name, lambda g, c, name=name: found.append(name) or np.zeros(1))
        kernel = texture.comparing_kernel if module is texture else shape.summing_kernel
        monkeypatch.setattr(kernel, "_machine_code", None)
        for spent in (0.0, 60.0):
            monkeypatch.setattr(kernel, "_spent", spent)
            describe(gray, DEFAULT)
    assert found == ["_by_scikit_image", "_by_machine_code"] * 2


@pytest.mark.parametrize("name", PICTURES)
def test_flat_areas_edges_and_noise_give_the_values_of_scikit_image(name):
    for method, bins in (("uniform", 26), ("nri_uniform", 24 * 23 + 3)):
        configuration = FeatureConfiguration(lbp_method=method, lbp_bins=bins)
        assert not differences(PICTURES[name], configuration), method


def test_the_sample_has_the_values_of_scikit_image():
    scene = sample_scene("red-car")
    for name, picture in {**scene.views, **scene.references}.items():
        gray = to_gray(resize(picture, DEFAULT.working_size))
        assert not differences(gray, DEFAULT), name


def test_a_direction_at_the_edge_of_a_bin_belongs_to_the_bin_above():
    for bins in range(2, 181):
        step = 180.0 / bins
        edges = np.array([[step * b for b in range(bins)]])
        for degrees in (edges, np.nextafter(edges[:, 1:], 0.0)):
            sums = np.zeros((1, 1, bins), np.float32)
            shape.summing_kernel.compiled(np.ones(degrees.shape), degrees, 1, degrees.shape[1], step, sums)
            assert (sums[0, 0, : degrees.shape[1]] == 1.0).all(), (bins, sums)


@pytest.mark.parametrize("size", [(131, 97), (9, 300), (300, 11), (64, 640)])
def test_a_picture_in_bands_has_the_values_of_scikit_image(size, monkeypatch):
    gray = np.random.default_rng(3).integers(0, 9, size, dtype=np.uint8) * np.uint8(28)
    for radius, points, cell in ((1.0, 8, (2, 2)), (1.5, 16, (3, 5)), (3.3, 24, (8, 8))):
        configuration = FeatureConfiguration(
            working_size=size,
            lbp_points=points,
            lbp_radius=radius,
            lbp_bins=points + 2,
            hog_pixels_per_cell=cell,
            hog_cells_per_block=(1, 1),
        )
        for band in (1, 1_000, 2**18):
            monkeypatch.setattr(texture, "BAND", band)
            monkeypatch.setattr(shape, "BAND", band, raising=False)
            assert not differences(gray, configuration), (configuration, band)
