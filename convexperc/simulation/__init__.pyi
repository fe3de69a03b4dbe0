from .backends import RenderingError
from .camera import Camera
from .datasets import Written, write_data_set, write_scene
from .descriptions import read_scene, scene_of_record, scene_record
from .image_size import ImageSize
from .layouts import GRAY_CAR, ICA_SIGN, RED_CAR, SCENES
from .light import LIGHTS, Light
from .meshes import MeshModel, Piece, read_meshes, unread_meshes
from .mujoco_xml import Group, mjcf
from .rendering import SceneRenderer, View
from .request import OBJECTS_OF, Request, SetName
from .scenes import Obstacle, Robot, Scene

__all__ = [
    "GRAY_CAR",
    "ICA_SIGN",
    "LIGHTS",
    "OBJECTS_OF",
    "RED_CAR",
    "SCENES",
    "Camera",
    "Group",
    "ImageSize",
    "Light",
    "MeshModel",
    "Obstacle",
    "Piece",
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
    "unread_meshes",
    "write_data_set",
    "write_scene",
]
