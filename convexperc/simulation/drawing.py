"""Drawing of scenes and references: pictures and masks as files, and their manifest entries."""

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
from convexperc.simulation.manifest import overhead_size
from convexperc.simulation.mujoco_xml import Group
from convexperc.simulation.proposing import Obstruction, Plan, Proposal, obstruction
from convexperc.simulation.rendering import SceneRenderer, View, png
from convexperc.simulation.scenes import Scene

PROBE_SIZE = ImageSize(80, 60, 1)
"""Size in pixels at which the visible shares of a proposal are measured: fast, and fine enough."""

PROBE_SHARES: dict[Obstruction, tuple[float, float]] = {
    "full": (0.0, 0.02),
    "partial": (0.12, 0.8),
    "none": (0.94, 1.0),
}
"""Visible share that a view must have at `PROBE_SIZE`: well inside the limits for the finished view, which
`proposing` states."""

MAX_DRAWS = 2000
"""Number of proposals after which the search for a scene fails."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """Drawn files and their manifest entry.

    Attributes
    ----------
    entry : dict
        The manifest's entry, plain JSON values.
    files : dict of str to bytes
        Content by path, relative to the data set, with forward slashes.
    """

    entry: dict[str, Any]
    files: dict[str, bytes]


def draw_reference(scene: Scene, size: ImageSize, objects: Catalogue) -> Drawn:
    """Draw a scene's object alone in its surroundings, as the reference camera sees it.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `SceneRenderer`.
    """
    with SceneRenderer(scene, size, objects) as renderer:
        view = renderer.view("reference", size, (Group.OBJECT, Group.SURROUNDINGS))
    named, files = _files(f"references/{scene.object}.png", view)
    return Drawn({"object": scene.object, **named, "description": scene_record(scene)}, files)


def draw_scene(scene: Scene, size: ImageSize, objects: Catalogue, level: str = "") -> Drawn:
    """Draw every robot's view of a scene, its mask, and the scene from above.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `SceneRenderer`.
    """
    above = overhead_size(size)
    with SceneRenderer(scene, above, objects) as renderer:
        views = {name: renderer.view(name, size) for name in scene.views()}
        return _drawn(scene, level, views, png(renderer.picture("overhead", above)))


def find_scene(
    proposals: Iterable[Proposal | None], size: ImageSize, objects: Catalogue, plan: Plan
) -> Drawn:
    """Draw the first scene proposed for a plan whose measured obstructions are the wanted ones.

    Raises
    ------
    InputError
        None of the first `MAX_DRAWS` proposals is suitable.
    MissingExtraError, RenderingError
        See `SceneRenderer`.
    """
    above = overhead_size(size)
    for proposal in islice(proposals, MAX_DRAWS):
        if proposal is None:
            continue
        scene = proposal.scene
        with SceneRenderer(scene, above, objects) as renderer:
            if not _promises(renderer, proposal):
                continue
            views = {name: renderer.view(name, size) for name in scene.views()}
            found = (obstruction(view.visible_share) for view in views.values())
            if all(want in (None, is_) for want, is_ in zip(proposal.wanted, found, strict=True)):
                return _drawn(scene, plan.level, views, png(renderer.picture("overhead", above)))
    must, remedy = (
        "must be attainable",
        "Choose another object or seed, or meshes of a size and shape that is more usual in this set.",
    )
    raise InputError(
        f"scene {plan.name}: level {plan.level!r}",
        value=f"none in {MAX_DRAWS} draws",
        must=must,
        remedy=remedy,
    )


def _promises(renderer: SceneRenderer, proposal: Proposal) -> bool:
    """Return whether every view clearly has the wanted obstruction, measured at `PROBE_SIZE`."""
    for name, want in zip(proposal.scene.views(), proposal.wanted, strict=True):
        if want is not None:
            low, high = PROBE_SHARES[want]
            if not low <= renderer.visible_share(name, PROBE_SIZE) <= high:
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
    """Return position and heading of a robot, in metres and degrees."""
    x, y, _ = camera.position().tolist()
    heading = (camera.azimuth + camera.pan) % 360.0 - 180.0
    pose = {"azimuth": camera.bearing(), "distance": camera.distance, "height": camera.height}
    pose |= {"x": x, "y": y, "heading": heading}
    return {key: round(value, 4) for key, value in pose.items()}


def sha256(content: bytes) -> str:
    """Return a file's hash, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()
