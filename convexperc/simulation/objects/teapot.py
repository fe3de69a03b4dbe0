"""A teapot."""

from collections.abc import Iterator

from convexperc.simulation.parts import Part, blob
from convexperc.simulation.skins import swept, turned


def teapot() -> Iterator[Part]:
    """Yield a teapot 0.3 m long, its spout to +y and its handle to -y."""
    body = [(0.055, 0.0), (0.06, 0.008), (0.06, 0.012), (0.088, 0.04), (0.1, 0.08), (0.092, 0.118)]
    yield turned("teapot", [*body, (0.07, 0.143), (0.058, 0.148)], steps=40)
    yield turned("toy-white", [(0.1005, 0.068), (0.1025, 0.08), (0.0995, 0.094)], steps=40)
    lid = [(0.064, 0.146), (0.066, 0.15), (0.05, 0.163), (0.02, 0.172), (0.0, 0.174)]
    yield turned("teapot", lid)
    yield blob("toy-white", (0.032, 0.032, 0.03), (0.0, 0.0, 0.185))
    spout = [(0.0, 0.075, 0.05), (0.0, 0.12, 0.066), (0.0, 0.146, 0.11), (0.0, 0.178, 0.15)]
    yield swept("teapot", spout, (0.034, 0.027, 0.018, 0.013), steps=20)
    yield swept("toy-white", [(0.0, 0.172, 0.143), (0.0, 0.183, 0.156)], (0.0155, 0.015), steps=20)
    handle = [(0.0, -0.075, 0.125), (0.0, -0.125, 0.137), (0.0, -0.155, 0.105), (0.0, -0.13, 0.06)]
    yield swept("teapot", [*handle, (0.0, -0.085, 0.04)], (0.011, 0.011, 0.012, 0.011, 0.01), steps=16)
