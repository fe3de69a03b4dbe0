"""Scenes of the physical set: six rovers in a lab around a small object, some of their views obstructed.

Paper: Section IV-B, the experiments with physical robots and their levels of obstruction (the layouts are
ours).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from convexperc.simulation.meshes import MeshModel
from convexperc.simulation.objects import Model
from convexperc.simulation.proposing import Obstruction, Plan, Proposal, assemble, base_scene, random_camera
from convexperc.simulation.setting import LAB

ROBOTS = 6
"""Number of rovers in a scene, as in the paper."""


@dataclass(frozen=True, slots=True)
class Level:
    """A level of obstruction of the six views.

    Attributes
    ----------
    name : str
        Its name in the manifest.
    partial, full : int
        Number of partially and of fully obstructed views.
    """

    name: str
    partial: int
    full: int


LEVELS = (
    Level("none", 0, 0),
    Level("one partial", 1, 0),
    Level("one full", 0, 1),
    Level("one full, one partial", 1, 1),
    Level("two full, two partial", 2, 2),
)
"""From no obstruction to obstructions of most views."""


def proposals(plan: Plan, thing: Model | MeshModel) -> Iterator[Proposal | None]:
    """Yield proposals without end.

    Parameters
    ----------
    plan : Plan
        Its level is the name of one of `LEVELS`.
    thing : Model or MeshModel
        The object.
    """
    level = next(one for one in LEVELS if one.name == plan.level)
    random = np.random.default_rng(plan.seed)
    base = base_scene(plan, thing, LAB, random)
    clear = ROBOTS - level.partial - level.full
    counts: dict[Obstruction, int] = {"partial": level.partial, "full": level.full, "none": clear}
    kinds = [kind for kind, count in counts.items() for _ in range(count)]
    while True:
        wanted = tuple(kinds[k] for k in random.permutation(ROBOTS))
        first = float(random.uniform(-180.0, 180.0))
        turns = first + 60.0 * np.arange(ROBOTS) + random.uniform(-18.0, 18.0, ROBOTS)
        cameras = [random_camera(float(turn), base.reference, LAB, random) for turn in turns]
        yield assemble(base, cameras, wanted, thing, LAB, random)
