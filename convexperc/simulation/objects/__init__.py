"""The objects to be recognised, each made of simple parts.

`OBJECTS` holds them by name: two cars and a sign, life-size, for the scenes in the park, and eight objects of
0.2 to 0.5 m for those in the lab.
"""

from collections.abc import Mapping
from types import MappingProxyType

from convexperc.simulation.objects.cactus import cactus
from convexperc.simulation.objects.cars import ESTATE, SALOON, car
from convexperc.simulation.objects.chair import chair
from convexperc.simulation.objects.desk_lamp import desk_lamp
from convexperc.simulation.objects.helicopter import helicopter
from convexperc.simulation.objects.locomotive import locomotive
from convexperc.simulation.objects.model import Model, model
from convexperc.simulation.objects.rubber_duck import rubber_duck
from convexperc.simulation.objects.sign import sign
from convexperc.simulation.objects.teapot import teapot
from convexperc.simulation.objects.traffic_cone import traffic_cone

CASE_STUDY: tuple[Model, ...] = (
    model("red-car", car(SALOON, "red")),
    model("gray-car", car(ESTATE, "gray")),
    model("ica-sign", sign()),
)
"""The three objects of the scenes in the park. Paper: Section IV-A."""

PHYSICAL: tuple[Model, ...] = (
    model("helicopter", helicopter()),
    model("traffic-cone", traffic_cone()),
    model("rubber-duck", rubber_duck()),
    model("chair", chair()),
    model("cactus", cactus()),
    model("teapot", teapot()),
    model("locomotive", locomotive()),
    model("desk-lamp", desk_lamp()),
)
"""Eight toys and household objects for the scenes in the lab. Paper: Section IV-B (the choice is ours)."""

OBJECTS: Mapping[str, Model] = MappingProxyType({one.name: one for one in CASE_STUDY + PHYSICAL})
"""Every object by its name."""

__all__ = ["CASE_STUDY", "OBJECTS", "PHYSICAL", "Model", "model"]
