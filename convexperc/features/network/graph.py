"""EfficientNet-Lite0 up to its last layer of features, as an ONNX model made of its weights.

The architecture is that of Tan and Le, *EfficientNet: Rethinking Model Scaling for Convolutional Neural
Networks* (2019), in its Lite form: no squeeze-and-excitation, and ReLU6 for every activation.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import onnx
from jaxtyping import Float32
from numpy.typing import NDArray
from onnx import helper, numpy_helper

INPUT, OUTPUT = "picture", "features"
EPSILON = 1e-3
"""What batch normalisation adds to each variance."""
OPSET, IR_VERSION = 13, 8
"""Versions of the operators and of the format: old enough for every OpenCV from 4.10 on."""
STAGES = ((1, 1), (2, 2), (2, 2), (3, 2), (3, 1), (4, 2), (1, 1))
"""Of each stage its number of blocks, and the stride of the first of them; the others have stride 1."""

Arrays = Mapping[str, NDArray[np.generic]]


def onnx_model(weights: Arrays, side: int) -> bytes:
    """Return the network as an ONNX model, batch normalisation multiplied into the convolutions.

    Parameters
    ----------
    weights : mapping of str to ndarray
        As `read_weights` returns those of EfficientNet-Lite0. The shapes of its convolutions give the widths.
    side : int
        s, height and width of the picture in pixels: a multiple of 32.

    Returns
    -------
    bytes
        Input ``picture``, float32 (1, 3, s, s): R, G, B. Output ``features``, float32
        (1, 1280, s / 32, s / 32), in 0..6.
    """
    graph = _Graph(weights, side)
    graph.convolve("_conv_stem", "_bn0", stride=2)
    block = 0
    for count, stride in STAGES:
        for i in range(count):
            graph.block(f"_blocks.{block}.", stride if i == 0 else 1)
            block += 1
    graph.convolve("_conv_head", "_bn1")
    return graph.model()


class _Graph:
    """A chain of convolutions, which grows at its end."""

    def __init__(self, weights: Arrays, side: int) -> None:
        self._weights = weights
        self._nodes: list[onnx.NodeProto] = []
        self._constants = [
            numpy_helper.from_array(np.array(bound, np.float32), name)
            for bound, name in ((0, "lowest"), (6, "highest"))
        ]
        self._given = helper.make_tensor_value_info(INPUT, onnx.TensorProto.FLOAT, [1, 3, side, side])
        self._end, self._channels, self._side = INPUT, 3, side

    def block(self, prefix: str, stride: int) -> None:
        """Append an inverted bottleneck; where it keeps the shape, its input is added to its output."""
        begin, channels = self._end, self._channels
        if f"{prefix}_expand_conv.weight" in self._weights:
            self.convolve(f"{prefix}_expand_conv", f"{prefix}_bn0")
        self.convolve(f"{prefix}_depthwise_conv", f"{prefix}_bn1", stride=stride)
        self.convolve(f"{prefix}_project_conv", f"{prefix}_bn2", activation=False)
        if stride == 1 and channels == self._channels:
            self._append("Add", [begin, self._end], f"{prefix}sum")

    def convolve(self, convolution: str, norm: str, *, stride: int = 1, activation: bool = True) -> None:
        """Append a convolution with its batch normalisation and, if wanted, ReLU6."""
        kernel, bias = _normalised(self._weights, convolution, norm)
        groups = self._channels // kernel.shape[1]
        before, after = _padding(self._side, kernel.shape[2], stride)
        names = [f"{convolution}.kernel", f"{convolution}.bias"]
        self._constants += [
            numpy_helper.from_array(array, name) for array, name in zip((kernel, bias), names, strict=True)
        ]
        self._append(
            "Conv", [self._end, *names], convolution, group=groups, kernel_shape=kernel.shape[2:],
            strides=[stride] * 2, pads=[before, before, after, after],
        )  # fmt: skip
        self._channels, self._side = len(kernel), math.ceil(self._side / stride)
        if activation:
            self._append("Clip", [self._end, "lowest", "highest"], f"{convolution}.relu6")

    def model(self) -> bytes:
        """Return the model as far as it has grown."""
        self._nodes[-1].output[0] = OUTPUT
        shape = [1, self._channels, self._side, self._side]
        found = helper.make_tensor_value_info(OUTPUT, onnx.TensorProto.FLOAT, shape)
        graph = helper.make_graph(self._nodes, "efficientnet-lite0", [self._given], [found], self._constants)
        opsets = [helper.make_opsetid("", OPSET)]
        model = helper.make_model(graph, opset_imports=opsets, ir_version=IR_VERSION)
        onnx.checker.check_model(model)
        return bytes(model.SerializeToString())

    def _append(self, operator: str, inputs: list[str], output: str, **attributes: Any) -> None:
        self._nodes.append(helper.make_node(operator, inputs, [output], **attributes))
        self._end = output


def _normalised(
    weights: Arrays, convolution: str, norm: str
) -> tuple[Float32[np.ndarray, "out in k k"], Float32[np.ndarray, " out"]]:
    """Return the kernel and the bias of a convolution followed by batch normalisation, rounded once."""
    names = ("weight", "bias", "running_mean", "running_var")
    gain, shift, mean, variance = (weights[f"{norm}.{name}"].astype(np.float64) for name in names)
    gain = gain / np.sqrt(variance + EPSILON)
    kernel = weights[f"{convolution}.weight"].astype(np.float64) * gain[:, np.newaxis, np.newaxis, np.newaxis]
    return kernel.astype(np.float32), (shift - mean * gain).astype(np.float32)


def _padding(side: int, kernel: int, stride: int) -> tuple[int, int]:
    """Return how many zeros stand before and after a side of a picture: as TensorFlow's "SAME" has it.

    The output has the side ``ceil(side / stride)``; an odd zero stands after.
    """
    zeros = max((math.ceil(side / stride) - 1) * stride + kernel - side, 0)
    return zeros // 2, zeros - zeros // 2
