"""Draws whole scenes and references: the pictures and masks as files, and what a manifest says of them."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from typing import Any

from convexperc.errors import InputError
from convexperc.simulation.camera import Camera
from convexperc.simulation.catalogue import Catalogue
from convexperc.simulation.descriptions import scene_record
from convexperc.simulation.image_size import ImageSize
from convexperc.simulation.manifest import overhead_frame
from convexperc.simulation.mujoco_xml import Group
from convexperc.simulation.proposing import Obstruction, Proposal, obstruction
from convexperc.simulation.rendering import SceneRenderer, View, png
from convexperc.simulation.scenes import Scene

PROBE = ImageSize(80, 60, 1)
"""Size at which the visible shares of a proposal are judged."""

CLEAR: dict[Obstruction, tuple[float, float]] = {
    "full": (0.0, 0.02),
    "partial": (0.12, 0.8),
    "none": (0.94, 1.0),
}
"""Visible share that a proposed view must have, well inside the limits that hold for the finished one."""

DRAWS = 2000
"""After so many draws a scene is given up."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """Files and what is known of them.

    Parameters
    ----------
    entry : dict
        The manifest's entry, plain JSON values.
    files : dict of str to bytes
        Content by path, relative to the data set, with forward slashes.
    """

    entry: dict[str, Any]
    files: dict[str, bytes]


def draw_reference(scene: Scene, frame: ImageSize, objects: Catalogue) -> Drawn:
    """Draw a scene's object alone in its surroundings, as the reference camera sees it.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `SceneRenderer`.
    """
    with SceneRenderer(scene, frame, objects) as renderer:
        view = renderer.view("reference", frame, (Group.OBJECT, Group.SURROUNDINGS))
    named, files = _files(f"references/{scene.object}.png", view)
    return Drawn({"object": scene.object, **named, "description": scene_record(scene)}, files)


def draw_scene(scene: Scene, frame: ImageSize, objects: Catalogue, level: str = "") -> Drawn:
    """Draw every robot's view of a scene, its mask, and the scene from above.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `SceneRenderer`.
    """
    above = overhead_frame(frame)
    with SceneRenderer(scene, above, objects) as renderer:
        views = {name: renderer.view(name, frame) for name in scene.views()}
        return _drawn(scene, level, views, png(renderer.picture("overhead", above)))


def find_scene(
    proposals: Iterable[Proposal | None], frame: ImageSize, objects: Catalogue, level: str
) -> Drawn:
    """Draw the first proposed scene whose views are as wanted, judged by measuring.

    Raises
    ------
    InputError
        None of the proposals will do.
    MissingExtraError, RenderingError
        See `SceneRenderer`.
    """
    above = overhead_frame(frame)
    for proposal in islice(proposals, DRAWS):
        if proposal is None:
            continue
        scene = proposal.scene
        with SceneRenderer(scene, above, objects) as renderer:
            if not _promises(renderer, proposal):
                continue
            views = {name: renderer.view(name, frame) for name in scene.views()}
            found = (obstruction(view.visible_share) for view in views.values())
            if all(want in (None, is_) for want, is_ in zip(proposal.wanted, found, strict=True)):
                return _drawn(scene, level, views, png(renderer.picture("overhead", above)))
    must, remedy = "must be attainable", "Choose another object or seed, or meshes of a more usual shape."
    raise InputError(f"level {level!r}", value=f"none in {DRAWS} draws", must=must, remedy=remedy)


def _promises(renderer: SceneRenderer, proposal: Proposal) -> bool:
    """Tell whether every view is clearly as wanted, at the size of a probe."""
    for name, want in zip(proposal.scene.views(), proposal.wanted, strict=True):
        if want is not None:
            low, high = CLEAR[want]
            if not low <= renderer.visible_share(name, PROBE) <= high:
                return False
    return True


def _drawn(scene: Scene, level: str, views: dict[str, View], overhead: bytes) -> Drawn:
    files = {f"overhead/{scene.name}.png": overhead}
    entries = []
    for name, camera in scene.views().items():
        named, contents = _files(f"views/{scene.name}/{name}.png", views[name])
        files |= contents
        seen = {
            "visible_share": round(views[name].visible_share, 4),
            "obstruction": obstruction(views[name].visible_share),
        }
        entries.append({"name": name, **named, **seen, **_pose(camera)})
    head = {"name": scene.name, "object": scene.object, "level": level, "light": scene.light.name}
    head |= {"overhead": f"overhead/{scene.name}.png", "overhead_sha256": sha256(overhead)}
    return Drawn(head | {"description": scene_record(scene), "views": entries}, files)


def _files(path: str, view: View) -> tuple[dict[str, str], dict[str, bytes]]:
    """Return the names and hashes of a view's picture and mask, and their contents by name."""
    picture, mask = png(view.picture), png(view.mask)
    named = {"file": path, "mask": f"masks/{path}", "sha256": sha256(picture), "mask_sha256": sha256(mask)}
    return named, {path: picture, f"masks/{path}": mask}


def _pose(camera: Camera) -> dict[str, float]:
    """Where a robot stands and where it faces, in metres and degrees."""
    x, y, _ = camera.position().tolist()
    heading = (camera.azimuth + camera.pan) % 360.0 - 180.0
    pose = {"azimuth": camera.bearing(), "distance": camera.distance, "height": camera.height}
    pose |= {"x": x, "y": y, "heading": heading}
    return {key: round(value, 4) for key, value in pose.items()}


def sha256(content: bytes) -> str:
    """Return a file's hash, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()
