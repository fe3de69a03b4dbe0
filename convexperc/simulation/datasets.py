"""Drawing of data sets into folders, with several processes; interrupted runs are continued."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.errors import InputError, require
from convexperc.files import json_bytes
from convexperc.simulation import case_study, physical
from convexperc.simulation.catalogue import catalogue, mesh_sha256, object_of
from convexperc.simulation.descriptions import scene_record
from convexperc.simulation.drawing import draw_reference, draw_scene, find_scene, sha256
from convexperc.simulation.folder import begin, close_folder, keep, open_folder, part_name
from convexperc.simulation.image_size import ImageSize
from convexperc.simulation.layouts import SCENES
from convexperc.simulation.light import BRIGHT
from convexperc.simulation.manifest import manifest_head
from convexperc.simulation.meshes import MeshModel
from convexperc.simulation.objects import Model
from convexperc.simulation.opengl import engine
from convexperc.simulation.proposing import Plan, Propose, base_scene
from convexperc.simulation.request import Request, SetName
from convexperc.simulation.scenes import Scene
from convexperc.simulation.setting import LAB, PARK, Setting

# The proposals and the setting of each kind of data set.
PROPOSE: dict[SetName, Propose] = {"physical": physical.proposals, "case-study": case_study.proposals}
SETTINGS: dict[SetName, Setting] = {"physical": LAB, "case-study": PARK}


@dataclass(frozen=True, slots=True)
class Written:
    """The result of a run.

    Attributes
    ----------
    manifest : mapping
        Content of ``manifest.json``, plain JSON values.
    drawn : frozenset of str
        Names of the parts that this run drew, see `part_name`; the others existed.
    """

    manifest: Mapping[str, Any]
    drawn: frozenset[str]

    @property
    def pictures(self) -> int:
        """Number of views and references, without masks and overhead pictures."""
        return sum(self._counts().values())

    @property
    def drawn_pictures(self) -> int:
        """Number of those that this run drew."""
        return sum(count for part, count in self._counts().items() if part in self.drawn)

    def _counts(self) -> dict[str, int]:
        parts = [*self.manifest["references"], *self.manifest["scenes"]]
        return {part_name(entry): len(entry.get("views", [entry])) for entry in parts}


def write_data_set(
    folder: Path,
    request: Request,
    *,
    meshes: Mapping[str, MeshModel] | None = None,
    workers: int = 1,
    progress: Callable[[str, int], None] | None = None,
) -> Written:
    """Draw a data set, or its missing parts; the files do not depend on the number of workers.

    Parameters
    ----------
    folder : Path
        Output folder: absent, empty, or left by a run of the same request.
    request : Request
        What to draw.
    meshes : mapping of str to MeshModel
        Objects made of meshes, which replace those of the same name.
    workers : int
        Number of processes, at least 1.
    progress : callable
        Called with the name of each finished part and the number of all parts.

    Returns
    -------
    Written

    Raises
    ------
    InputError
        The folder cannot be used, an object is unknown, or a scene cannot be found.
    MissingExtraError
        MuJoCo or joblib is not installed.
    RenderingError
        There is no OpenGL library, or it failed.
    """
    if workers < 1:
        raise InputError("workers", value=workers, must="must be at least 1")
    require("joblib", "sim", "drawing a data set")
    from joblib import Parallel, delayed  # noqa: PLC0415 - it is an optional dependency

    objects = catalogue(meshes)
    head = request.record(engine(), objects)
    parts = _parts(request)
    report = progress or (lambda part, count: None)
    entries = {part: entry for part, entry in open_folder(folder, head).items() if part in parts}
    missing = [part for part in parts if part not in entries]
    for part in entries:
        report(part, len(parts))
    if missing:
        begin(folder, head, entries)
    jobs = (
        delayed(_make)(folder, request, objects[name], plan) for name, plan in map(parts.__getitem__, missing)
    )
    for entry in Parallel(n_jobs=workers, return_as="generator_unordered")(jobs):
        entries[part_name(entry)] = entry
        report(part_name(entry), len(parts))
    return _finish(folder, head, [entries[part] for part in parts], missing)


def _parts(request: Request) -> dict[str, tuple[str, Plan | None]]:
    """Return the parts of a data set by name: the object and, for a scene, its plan."""
    parts: dict[str, tuple[str, Plan | None]] = {
        f"references/{name}": (name, None) for name in request.objects
    }
    return parts | {f"scenes/{plan.name}": (name, plan) for name, plan in request.plans()}


def _finish(
    folder: Path, head: Mapping[str, Any], entries: Sequence[dict[str, Any]], drawn: Iterable[str]
) -> Written:
    """Write the manifest."""
    references = [entry for entry in entries if "views" not in entry]
    manifest = {**head, "references": references, "scenes": [entry for entry in entries if "views" in entry]}
    close_folder(folder, manifest)
    return Written(manifest, frozenset(drawn))


def write_scene(
    folder: Path, scene: Scene, size: ImageSize, *, meshes: Mapping[str, MeshModel] | None = None
) -> Written:
    """Draw one scene and its reference into a folder of the same layout as a data set.

    Parameters
    ----------
    folder : Path
        Output folder: absent, empty, or left by a run of the same scene.
    scene : Scene
        What to draw.
    size : ImageSize
        Size of the views.
    meshes : mapping of str to MeshModel
        Objects made of meshes.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `write_data_set`; `InputError` also if the scene has no robot.
    """
    if not scene.robots:
        raise InputError("robots", value=scene.robots, must="must hold at least one robot")
    objects = catalogue(meshes)
    object_of(scene, objects)
    head = manifest_head("scene", scene.seed, [scene.object], size, engine(), objects)
    head |= {"description_sha256": sha256(json_bytes(scene_record(scene)))}
    drawn = [
        draw_reference(scene, size, objects),
        draw_scene(scene, size, objects, level="as described"),
    ]
    begin(folder, head, open_folder(folder, head))
    entries = [keep(folder, part) for part in drawn]
    return _finish(folder, head, entries, map(part_name, entries))


def _make(folder: Path, request: Request, thing: Model | MeshModel, plan: Plan | None) -> dict[str, Any]:
    """Draw one part into the folder and return its manifest entry; runs in a worker process."""
    objects = {thing.name: thing}
    if plan is None:
        return keep(folder, draw_reference(reference_scene(request.set, thing), request.size, objects))
    proposals = PROPOSE[request.set](plan, thing)
    return keep(folder, find_scene(proposals, request.size, objects, plan))


def reference_scene(kind: SetName, thing: Model | MeshModel) -> Scene:
    """Return the scene, without robots, in which the reference of an object is taken.

    Parameters
    ----------
    kind : {"physical", "case-study"}
        Determines the setting.
    thing : Model or MeshModel
        The object.
    """
    for scene in SCENES:
        if kind == "case-study" and scene.object == thing.name and not mesh_sha256(thing):
            return replace(scene, robots=(), obstacles=())
    plan = Plan(thing.name, 0, "reference", (0,))
    base = base_scene(plan, thing, SETTINGS[kind], np.random.default_rng(0))
    return replace(base, turn=0.0, light=BRIGHT, seed=0)
