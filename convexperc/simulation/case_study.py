"""Scenes of the case study: five huskies in a park, of which exactly three have a good view of the object.

Paper: Section IV-A, the multi-robot simulation (the layouts are ours).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from convexperc.simulation.layouts import SCENES
from convexperc.simulation.meshes import MeshModel
from convexperc.simulation.objects import Model
from convexperc.simulation.proposing import Obstruction, Plan, Proposal, assemble, base_scene, random_camera
from convexperc.simulation.scenes import Scene
from convexperc.simulation.setting import PARK

LEVEL = "case study"
ROBOTS = 5
GOOD_VIEWS = 3

GOOD_WITHIN = 40.0
"""Greatest angle in degrees between the directions of a good view and of the reference."""

TWO_SIDED = frozenset({"red-car", "gray-car"})
"""Objects whose opposite side is as good as the side of the reference."""


def is_good(name: str, bearing: float, obstructed: Obstruction) -> bool:
    """Tell whether a view is a good one.

    Parameters
    ----------
    name : str
        The object.
    bearing : float
        The view's azimuth, in degrees.
    obstructed : {"none", "partial", "full"}
        How much of the object is hidden.
    """
    off = abs((bearing + 180.0) % 360.0 - 180.0)
    aligned = off <= GOOD_WITHIN or (name in TWO_SIDED and off >= 180.0 - GOOD_WITHIN)
    return aligned and obstructed == "none"


def proposals(plan: Plan, thing: Model | MeshModel) -> Iterator[Proposal | None]:
    """Yield one proposal after another: the hand-made layout of the object first, if it is number 1."""
    for scene in SCENES:
        if plan.number == 1 and scene.object == thing.name and not isinstance(thing, MeshModel):
            yield Proposal(replace(scene, name=plan.name), (None,) * len(scene.robots))
    random = np.random.default_rng(plan.seed)
    base = base_scene(plan, thing, PARK, random)
    while True:
        yield _propose(base, thing, random)


def _propose(scene: Scene, thing: Model | MeshModel, random: np.random.Generator) -> Proposal | None:
    views = [_good_view(thing.name, random) for _ in range(GOOD_VIEWS)]
    views += [
        _poor_view(random, hidden=bool(k == 0 or random.random() < 0.5)) for k in range(ROBOTS - GOOD_VIEWS)
    ]
    order = random.permutation(ROBOTS)
    cameras = [random_camera(views[k][0], scene.reference, PARK, random) for k in order]
    return assemble(scene, cameras, tuple(views[k][1] for k in order), thing, PARK, random)


def _good_view(name: str, random: np.random.Generator) -> tuple[float, Obstruction | None]:
    """Return a direction in degrees and the obstruction that is wanted there."""
    behind = name in TWO_SIDED and random.random() < 0.35
    return float(random.uniform(3.0 - GOOD_WITHIN, GOOD_WITHIN - 3.0)) + 180.0 * behind, "none"


def _poor_view(random: np.random.Generator, hidden: bool) -> tuple[float, Obstruction | None]:
    """Return a hidden view from anywhere, or a view of the narrow side."""
    if hidden:
        kind: Obstruction = "full" if random.random() < 0.5 else "partial"
        return float(random.uniform(-180.0, 180.0)), kind
    side = float(random.choice([-1.0, 1.0]))
    return side * float(random.uniform(60.0, 120.0)), None
