"""The objects that robots look at, each made of simple parts.

`OBJECTS` holds them by name: two cars and a sign, as large as real ones, for the scenes in the park.
"""

from collections.abc import Mapping
from types import MappingProxyType

from convexperc.simulation.objects.cars import ESTATE, SALOON, car
from convexperc.simulation.objects.model import Model, model
from convexperc.simulation.objects.sign import sign

CASE_STUDY: tuple[Model, ...] = (
    model("red-car", car(SALOON, "red")),
    model("gray-car", car(ESTATE, "gray")),
    model("ica-sign", sign()),
)
"""The three objects of the scenes in the park. Paper: Section IV-A."""

OBJECTS: Mapping[str, Model] = MappingProxyType({one.name: one for one in CASE_STUDY})
"""Every object by its name."""

__all__ = ["CASE_STUDY", "OBJECTS", "Model", "model"]
