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
"""Number of robots in a scene, as in the paper."""
GOOD_VIEWS = 3
"""Number of good views in a scene, as in the paper."""

GOOD_VIEW_ANGLE = 40.0
"""Greatest angle in degrees between the directions of a good view and of the reference: the same side is
seen."""

TWO_SIDED = frozenset({"red-car", "gray-car"})
"""Objects whose opposite side looks like the side of the reference."""


def is_good(name: str, bearing: float, obstructed: Obstruction) -> bool:
    """Return whether a view is good: unobstructed, and from about the direction of the reference.

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
    aligned = off <= GOOD_VIEW_ANGLE or (name in TWO_SIDED and off >= 180.0 - GOOD_VIEW_ANGLE)
    return aligned and obstructed == "none"


def proposals(plan: Plan, thing: Model | MeshModel) -> Iterator[Proposal | None]:
    """Yield proposals without end; for the first scene of an object, its hand-made layout comes first."""
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
    """Return the azimuth in degrees of a good view, and the obstruction it must have."""
    behind = name in TWO_SIDED and random.random() < 0.35
    return float(random.uniform(3.0 - GOOD_VIEW_ANGLE, GOOD_VIEW_ANGLE - 3.0)) + 180.0 * behind, "none"


def _poor_view(random: np.random.Generator, hidden: bool) -> tuple[float, Obstruction | None]:
    """Return azimuth and obstruction of a hidden view from any direction, or of a view of the narrow side."""
    if hidden:
        kind: Obstruction = "full" if random.random() < 0.5 else "partial"
        return float(random.uniform(-180.0, 180.0)), kind
    side = float(random.choice([-1.0, 1.0]))
    return side * float(random.uniform(60.0, 120.0)), None
