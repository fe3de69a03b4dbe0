"""A simulated park and lab in which robots look at an object, partly hidden by obstacles.

`Scene` says what is where, `mjcf` writes it as MuJoCo's XML, `SceneRenderer` draws it, and `write_data_set`
makes whole folders of pictures with masks. Only drawing needs MuJoCo, and imports it.
"""

from convexperc.simulation.backends import RenderingError
from convexperc.simulation.camera import Camera
from convexperc.simulation.descriptions import read_scene, scene_of_record, scene_record
from convexperc.simulation.frame import Frame
from convexperc.simulation.layouts import GRAY_CAR, ICA_SIGN, RED_CAR, SCENES
from convexperc.simulation.light import LIGHTS, Light
from convexperc.simulation.mjcf import Group, mjcf
from convexperc.simulation.rendering import SceneRenderer, View
from convexperc.simulation.scenes import Obstacle, Robot, Scene

__all__ = [
    "GRAY_CAR",
    "ICA_SIGN",
    "LIGHTS",
    "RED_CAR",
    "SCENES",
    "Camera",
    "Frame",
    "Group",
    "Light",
    "Obstacle",
    "RenderingError",
    "Robot",
    "Scene",
    "SceneRenderer",
    "View",
    "mjcf",
    "read_scene",
    "scene_of_record",
    "scene_record",
]
