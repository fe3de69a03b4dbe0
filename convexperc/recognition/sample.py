"""The sample that the package carries: pictures of simulated robots' views, and of the known objects."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from typing import Any

from convexperc.errors import InputError, is_one_of
from convexperc.features.pictures import read_image
from convexperc.recognition.references import NamedPictures


@dataclass(frozen=True, eq=False)
class SampleScene:
    """One scene of the sample that the package carries.

    Attributes
    ----------
    name : str
        Also the name of the object that the views show.
    references, views : mapping of str to uint8 (h, w, 3)
        A picture of each object; a picture from each robot.
    """

    name: str
    references: NamedPictures
    views: NamedPictures


def sample_names() -> tuple[str, ...]:
    """Names of the sample's scenes."""
    return tuple(_sample())


def sample_scene(name: str) -> SampleScene:
    """Read one scene of the sample.

    Raises
    ------
    InputError
        There is no such scene.
    """
    scenes = _sample()
    if not is_one_of(name, scenes):
        raise InputError("scene", value=name, must=f"must be one of {', '.join(scenes)}")
    views = ((view["name"], view["file"]) for view in scenes[name]["views"])
    references = ((known["object"], known["file"]) for known in _manifest()["references"])
    return SampleScene(name, _pictures(references), _pictures(views))


def _sample() -> dict[str, dict[str, Any]]:
    """The sample's scenes by name."""
    return {scene["name"]: scene for scene in _manifest()["scenes"]}


@cache
def _manifest() -> dict[str, Any]:
    """What the sample says of itself."""
    record: dict[str, Any] = json.loads((_folder() / "manifest.json").read_text(encoding="utf-8"))
    return record


def _folder() -> Traversable:
    return files("convexperc").joinpath("sample")


def _pictures(named: Iterable[tuple[str, str]]) -> NamedPictures:
    pictures = {}
    for name, place in named:
        with as_file(_folder().joinpath(*place.split("/"))) as path:
            pictures[name] = read_image(path)
    return pictures
