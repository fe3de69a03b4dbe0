"""A simulated park and lab in which robots look at an object, partly hidden by obstacles.

`Scene` says what is where, `mjcf` writes it as MuJoCo's XML, `SceneRenderer` draws it, and `write_data_set`
makes whole folders of pictures with masks. Only drawing needs MuJoCo, and imports it.
"""

from convexperc.simulation.backends import RenderingError
from convexperc.simulation.camera import Camera
from convexperc.simulation.datasets import Written, write_data_set, write_scene
from convexperc.simulation.descriptions import read_scene, scene_of_record, scene_record
from convexperc.simulation.image_size import Frame
from convexperc.simulation.layouts import GRAY_CAR, ICA_SIGN, RED_CAR, SCENES
from convexperc.simulation.light import LIGHTS, Light
from convexperc.simulation.meshes import MeshModel, read_meshes
from convexperc.simulation.mjcf import Group, mjcf
from convexperc.simulation.rendering import SceneRenderer, View
from convexperc.simulation.request import OBJECTS_OF, Request, SetName
from convexperc.simulation.scenes import Obstacle, Robot, Scene

__all__ = [
    "GRAY_CAR",
    "ICA_SIGN",
    "LIGHTS",
    "OBJECTS_OF",
    "RED_CAR",
    "SCENES",
    "Camera",
    "Frame",
    "Group",
    "Light",
    "MeshModel",
    "Obstacle",
    "RenderingError",
    "Request",
    "Robot",
    "Scene",
    "SceneRenderer",
    "SetName",
    "View",
    "Written",
    "mjcf",
    "read_meshes",
    "read_scene",
    "scene_of_record",
    "scene_record",
    "write_data_set",
    "write_scene",
]
