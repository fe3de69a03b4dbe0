"""A simulated park in which robots look at a car or a sign, partly hidden by obstacles.

`Scene` says what is where, `mjcf` writes it as MuJoCo's XML, `SceneRenderer` draws it, and `write_sample`
makes the pictures that the package carries. Only drawing needs MuJoCo, and imports it.
"""

from convexperc.simulation.backends import RenderingError
from convexperc.simulation.layouts import GRAY_CAR, ICA_SIGN, RED_CAR, SCENES
from convexperc.simulation.mjcf import Group, mjcf
from convexperc.simulation.rendering import Engine, SceneRenderer
from convexperc.simulation.sample import write_sample
from convexperc.simulation.scenes import Camera, Obstacle, Scene

__all__ = [
    "GRAY_CAR",
    "ICA_SIGN",
    "RED_CAR",
    "SCENES",
    "Camera",
    "Engine",
    "Group",
    "Obstacle",
    "RenderingError",
    "Scene",
    "SceneRenderer",
    "mjcf",
    "write_sample",
]
