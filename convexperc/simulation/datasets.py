"""Draws whole data sets into folders, with several processes, and goes on where a run was stopped."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from convexperc.errors import InputError
from convexperc.records import json_bytes
from convexperc.simulation import case_study, physical
from convexperc.simulation.catalogue import Catalogue, catalogue, mesh_sha256, object_of
from convexperc.simulation.descriptions import scene_record
from convexperc.simulation.drawing import Drawn, draw_reference, draw_scene, find_scene, sha256
from convexperc.simulation.folder import close_folder, keep, kept_entry, open_folder
from convexperc.simulation.frame import Frame
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

PROPOSE: dict[SetName, Propose] = {"physical": physical.proposals, "case-study": case_study.proposals}
SETTINGS: dict[SetName, Setting] = {"physical": LAB, "case-study": PARK}
REFERENCE = "reference-of-"
"""Stands before an object's name where its reference is one part among scenes."""


@dataclass(frozen=True, slots=True)
class Written:
    """What a run left.

    Parameters
    ----------
    manifest : mapping
        What ``manifest.json`` holds, plain JSON values.
    drawn : frozenset of str
        Names of the scenes that were drawn now, and ``reference-of-`` objects; the others were there.
    """

    manifest: Mapping[str, Any]
    drawn: frozenset[str]

    @property
    def pictures(self) -> int:
        """Number of views and references, without masks and overhead pictures."""
        return self._count(lambda title: True)

    @property
    def drawn_pictures(self) -> int:
        """Number of those that were drawn now."""
        return self._count(self.drawn.__contains__)

    def _count(self, counts: Callable[[str], bool]) -> int:
        references = [counts(f"{REFERENCE}{one['object']}") for one in self.manifest["references"]]
        views = [len(scene["views"]) for scene in self.manifest["scenes"] if counts(scene["name"])]
        return sum(references) + sum(views)


def write_data_set(
    folder: Path,
    request: Request,
    *,
    meshes: Mapping[str, MeshModel] | None = None,
    workers: int = 1,
    progress: Callable[[str, int], None] | None = None,
) -> Written:
    """Draw a data set, or what is missing of it. Any number of workers gives the same bytes.

    Parameters
    ----------
    folder : Path
        Where it goes; absent, empty, or what a run of the same request left.
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
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or it failed.
    """
    if workers < 1:
        raise InputError("workers", value=workers, must="must be at least 1")
    objects = catalogue(meshes)
    head = request.record(engine(), objects)
    open_folder(folder, head)
    parts: list[tuple[str, Plan | None]] = [(name, None) for name in request.objects]
    parts += list(request.plans())
    entries: dict[str, dict[str, Any]] = {}
    missing = []
    for name, plan in parts:
        title = _title(name, plan)
        entry = kept_entry(folder, title)
        if entry is None:
            missing.append((name, plan))
        else:
            entries[title] = entry
            if progress is not None:
                progress(title, len(parts))
    jobs = (delayed(_make)(folder, request, name, plan, {name: objects[name]}) for name, plan in missing)
    for title, entry in Parallel(n_jobs=workers, return_as="generator_unordered")(jobs):
        entries[title] = entry
        if progress is not None:
            progress(title, len(parts))
    references = [entries[_title(name, None)] for name in request.objects]
    scenes = [entries[plan.name] for _, plan in request.plans()]
    manifest = {**head, "references": references, "scenes": scenes}
    close_folder(folder, manifest)
    return Written(manifest, frozenset(_title(*part) for part in missing))


def write_scene(
    folder: Path, scene: Scene, frame: Frame, *, meshes: Mapping[str, MeshModel] | None = None
) -> Written:
    """Draw one scene and its reference into a folder of the same form.

    Parameters
    ----------
    folder : Path
        Where it goes; absent, empty, or what a run of the same scene left.
    scene : Scene
        What to draw.
    frame : Frame
        Size of the views.
    meshes : mapping of str to MeshModel
        Objects made of meshes.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `write_data_set`; also when the scene has no robot.
    """
    if not scene.robots:
        raise InputError("robots", value=scene.robots, must="must hold at least one robot")
    objects = catalogue(meshes)
    object_of(scene, objects)
    head = manifest_head("scene", scene.seed, [scene.object], frame, engine(), objects)
    digest = sha256(json_bytes(scene_record(scene)))
    open_folder(folder, head | {"description_sha256": digest})
    reference = keep(folder, _title(scene.object, None), draw_reference(scene, frame, objects))
    entry = keep(folder, scene.name, draw_scene(scene, frame, objects, level="as described"))
    manifest = {**head, "references": [reference], "scenes": [entry]}
    close_folder(folder, manifest)
    return Written(manifest, frozenset({_title(scene.object, None), scene.name}))


def _title(name: str, plan: Plan | None) -> str:
    """Name of a scene, or of an object's reference, among the records."""
    return f"{REFERENCE}{name}" if plan is None else plan.name


def _make(
    folder: Path, request: Request, name: str, plan: Plan | None, objects: Catalogue
) -> tuple[str, dict[str, Any]]:
    """Draw one part and put it in its place; runs in a worker."""
    thing = objects[name]
    if plan is None:
        drawn: Drawn = draw_reference(reference_scene(request.set, thing), request.frame, objects)
    else:
        found = PROPOSE[request.set](plan, thing)
        drawn = find_scene(found, request.frame, objects, plan.level)
    title = _title(name, plan)
    return title, keep(folder, title, drawn)


def reference_scene(kind: SetName, thing: Model | MeshModel) -> Scene:
    """Return the scene, without robots, in which the reference of an object is taken.

    Parameters
    ----------
    kind : {"physical", "case-study"}
        Says where.
    thing : Model or MeshModel
        The object.
    """
    for scene in SCENES:
        if kind == "case-study" and scene.object == thing.name and not mesh_sha256(thing):
            return replace(scene, robots=(), obstacles=())
    plan = Plan(thing.name, 0, "reference", (0,))
    base = base_scene(plan, thing, SETTINGS[kind], np.random.default_rng(0))
    return replace(base, turn=0.0, light=BRIGHT, seed=0)
