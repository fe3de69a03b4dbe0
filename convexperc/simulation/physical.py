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


@dataclass(frozen=True, slots=True)
class Level:
    """How many of the six views are obstructed.

    Parameters
    ----------
    name : str
        In words.
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


def proposals(plan: Plan, thing: Model | MeshModel) -> Iterator[Proposal | None]:
    """Yield one proposal after another, without end.

    Parameters
    ----------
    plan : Plan
        Its level is the name of one of `LEVELS`.
    thing : Model or MeshModel
        What the robots look at.
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
