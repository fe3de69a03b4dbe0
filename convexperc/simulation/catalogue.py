"""The known objects: those of the package, and those made of meshes."""

from collections.abc import Mapping

from convexperc.errors import InputError
from convexperc.simulation.meshes import MeshModel
from convexperc.simulation.objects import OBJECTS, Model
from convexperc.simulation.scenes import Scene

Catalogue = Mapping[str, Model | MeshModel]
"""Objects by name."""


def catalogue(meshes: Mapping[str, MeshModel] | None = None) -> Catalogue:
    """Return the objects of the package and `meshes`, which take precedence where names are equal."""
    return {**OBJECTS, **(meshes or {})}


def object_of(scene: Scene, objects: Catalogue) -> Model | MeshModel:
    """Return the object that a scene shows.

    Raises
    ------
    InputError
        There is none of this name, or its meshes differ from those of the scene's description.
    """
    if scene.object not in objects:
        remedy = "Give the folder of meshes that holds it, if it is not one of the package."
        must = f"must be one of {', '.join(objects)}"
        raise InputError("object", value=scene.object, must=must, remedy=remedy)
    found = objects[scene.object]
    sha256 = mesh_sha256(found)
    if scene.mesh_sha256 != sha256:
        must = f"must be {sha256!r}, the hash of the meshes of {scene.object} (empty where it has none)"
        remedy = "Give the folder of meshes that the scene was described with"
        remedy += ", or copy the hash into the description if these are the meshes that are meant."
        raise InputError("mesh_sha256", value=scene.mesh_sha256, must=must, remedy=remedy)
    return found


def mesh_sha256(thing: Model | MeshModel) -> str:
    """Return the hash of an object's meshes, empty for an object of the package."""
    return thing.sha256 if isinstance(thing, MeshModel) else ""
