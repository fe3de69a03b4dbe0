"""Random scenes: proposals, each with the obstructions that its views must have, to be measured."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from convexperc.simulation.camera import Camera
from convexperc.simulation.light import LIGHTS, Light
from convexperc.simulation.meshes import MeshModel
from convexperc.simulation.objects import Model
from convexperc.simulation.placing import Cover, hiding_obstacle, stand_apart
from convexperc.simulation.scenes import Obstacle, Robot, Scene
from convexperc.simulation.setting import Setting

Obstruction = Literal["none", "partial", "full"]

FULL_SHARE, UNOBSTRUCTED_SHARE = 0.05, 0.9
"""Visible shares up to which a view is fully obstructed, and from which it is not obstructed."""

LIGHT_SHARES: Mapping[str, float] = {"bright": 0.64, "dim": 0.14, "warm": 0.12, "green": 0.1}
"""Probability of each light."""


def obstruction(visible_share: float) -> Obstruction:
    """Return the obstruction of a view from its visible share, in [0, 1]."""
    if visible_share <= FULL_SHARE:
        return "full"
    return "none" if visible_share >= UNOBSTRUCTED_SHARE else "partial"


@dataclass(frozen=True, slots=True)
class Proposal:
    """A scene and the obstructions that its views must have.

    Attributes
    ----------
    scene : Scene
        The proposed scene.
    wanted : tuple of {"none", "partial", "full"} or None
        Obstruction that each robot's view must have; None where any is allowed.
    """

    scene: Scene
    wanted: tuple[Obstruction | None, ...]


@dataclass(frozen=True, slots=True)
class Plan:
    """Which scene of a data set is to be drawn.

    Attributes
    ----------
    name : str
        Name of the scene.
    number : int
        Its number among the scenes of this object and level, from 1.
    level : str
        Name of its level of obstruction.
    seed : tuple of int
        Seed of its random numbers.
    """

    name: str
    number: int
    level: str
    seed: tuple[int, ...]


Propose = Callable[[Plan, Model | MeshModel], Iterator[Proposal | None]]
"""Yields proposals for a plan and an object, without end; None for a draw with overlapping things."""


def base_scene(plan: Plan, thing: Model | MeshModel, setting: Setting, random: np.random.Generator) -> Scene:
    """Return a scene of the setting without robots and obstacles, in a random light."""
    away, up = setting.overhead
    return Scene(
        name=plan.name,
        object=thing.name,
        target_height=round(thing.height / 2, 4),
        reference=reference_camera(thing, setting),
        robots=(),
        overhead=Camera(azimuth=-28.0, distance=away, height=up, field_of_view=39.0),
        surroundings=setting.surroundings,
        turn=round(float(random.uniform(-180.0, 180.0)), 2),
        light=random_light(random),
        seed=int(random.integers(2**31)),
        mesh_sha256=thing.sha256 if isinstance(thing, MeshModel) else "",
    )


def reference_camera(thing: Model | MeshModel, setting: Setting) -> Camera:
    """Return the camera that takes the reference of an object."""
    low, high = setting.lens
    distance = round(setting.distance_of(thing.radius, thing.height), 3)
    height, view = round((low + high) / 2, 3), setting.field_of_view
    return Camera(azimuth=0.0, distance=distance, height=height, field_of_view=view, noise=setting.noise)


def random_light(random: np.random.Generator) -> Light:
    """Return one of the lights, from a random direction."""
    name = str(random.choice(list(LIGHT_SHARES), p=list(LIGHT_SHARES.values())))
    azimuth = round(float(random.uniform(-180.0, 180.0)), 1)
    return replace(LIGHTS[name], azimuth=azimuth)


def random_camera(azimuth: float, reference: Camera, setting: Setting, random: np.random.Generator) -> Camera:
    """Return a robot's camera at an azimuth (degrees), at about the distance of the reference."""
    return Camera(
        azimuth=round((azimuth + 180.0) % 360.0 - 180.0, 3),
        distance=round(reference.distance * float(random.uniform(0.94, 1.22)), 4),
        height=round(float(random.uniform(*setting.lens)), 4),
        field_of_view=setting.field_of_view,
        pan=round(float(random.uniform(-2.0, 2.0)), 3),
        exposure=round(float(random.normal(0.0, 0.12)), 3),
        blur=round(float(random.uniform(0.0, 0.5)), 3),
        noise=setting.noise,
    )


def hide(
    cameras: list[Camera],
    wanted: tuple[Obstruction | None, ...],
    thing: Model | MeshModel,
    setting: Setting,
    random: np.random.Generator,
) -> list[Obstacle] | None:
    """Return an obstacle for each view that is to be obstructed; None if there is no space for one."""
    found = []
    for camera, kind in zip(cameras, wanted, strict=True):
        if kind in ("partial", "full"):
            cover: Cover = "all" if kind == "full" else ("side", "side", "foot")[int(random.integers(3))]
            one = hiding_obstacle(camera, thing.radius, thing.height, setting, random, cover)
            if one is None:
                return None
            found.append(one)
    return found


def scatter(setting: Setting, random: np.random.Generator) -> list[Obstacle]:
    """Return zero to two solid obstacles in the background."""
    return [
        Obstacle(
            setting.solid,
            azimuth=round(float(random.uniform(-180.0, 180.0)), 3),
            distance=round(float(random.uniform(*setting.yard)), 4),
            width=round(setting.widest * float(random.uniform(0.5, 1.0)), 4),
            height=round(setting.widest * float(random.uniform(0.4, 1.0)), 4),
            turn=round(float(random.uniform(-45.0, 45.0)), 3),
        )
        for _ in range(int(random.integers(3)))
    ]


def assemble(
    base: Scene,
    cameras: list[Camera],
    wanted: tuple[Obstruction | None, ...],
    thing: Model | MeshModel,
    setting: Setting,
    random: np.random.Generator,
) -> Proposal | None:
    """Return the scene with robots and obstacles, or None if any of them would overlap."""
    hiding = hide(cameras, wanted, thing, setting, random)
    things = None if hiding is None else [*hiding, *scatter(setting, random)]
    if things is None or not stand_apart(cameras, things, setting):
        return None
    robots = tuple(Robot(setting.robot, camera) for camera in cameras)
    return Proposal(replace(base, robots=robots, obstacles=tuple(things)), wanted)
