"""Draws whole data sets into folders, with several processes, and goes on where a run was stopped."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from convexperc.errors import InputError
from convexperc.simulation import case_study, physical
from convexperc.simulation.catalogue import Catalogue, catalogue
from convexperc.simulation.drawing import Drawn, draw_reference, find_scene
from convexperc.simulation.folder import close_folder, keep, kept_entry, open_folder
from convexperc.simulation.layouts import SCENES
from convexperc.simulation.light import BRIGHT
from convexperc.simulation.meshes import MeshModel
from convexperc.simulation.objects import Model
from convexperc.simulation.opengl import engine
from convexperc.simulation.proposing import Plan, Propose, base_scene
from convexperc.simulation.request import Request, SetName
from convexperc.simulation.scenes import Scene
from convexperc.simulation.setting import LAB, PARK, Setting

PROPOSE: dict[SetName, Propose] = {"physical": physical.proposals, "case-study": case_study.proposals}
SETTINGS: dict[SetName, Setting] = {"physical": LAB, "case-study": PARK}


@dataclass(frozen=True, slots=True)
class Written:
    """What a run left.

    Parameters
    ----------
    manifest : mapping
        What ``manifest.json`` holds, plain JSON values.
    drawn, kept : int
        Scenes and references that were drawn now, and that were there already.
    """

    manifest: Mapping[str, Any]
    drawn: int
    kept: int

    @property
    def pictures(self) -> int:
        """Number of views and references, without masks and overhead pictures."""
        scenes = self.manifest["scenes"]
        return len(self.manifest["references"]) + sum(len(scene["views"]) for scene in scenes)


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
    kept = len(entries)
    jobs = (
        delayed(_make)(folder, request, name, plan, {name: objects[name]}) for name, plan in missing
    )
    for title, entry in Parallel(n_jobs=workers, return_as="generator_unordered")(jobs):
        entries[title] = entry
        if progress is not None:
            progress(title, len(parts))
    references = [entries[_title(name, None)] for name in request.objects]
    scenes = [entries[plan.name] for _, plan in request.plans()]
    manifest = {**head, "references": references, "scenes": scenes}
    close_folder(folder, manifest)
    return Written(manifest, len(missing), kept)


def _title(name: str, plan: Plan | None) -> str:
    """Name of a scene, or of an object's reference, among the records."""
    return f"reference-of-{name}" if plan is None else plan.name


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
    sha256 = thing.sha256 if isinstance(thing, MeshModel) else ""
    for scene in SCENES:
        if kind == "case-study" and scene.object == thing.name and not sha256:
            return Scene(
                scene.name, scene.object, scene.target_height, scene.reference, (), overhead=scene.overhead
            )
    plan = Plan(thing.name, 0, "reference", (0,))
    base = base_scene(plan, thing, SETTINGS[kind], np.random.default_rng(0))
    return Scene(
        base.name,
        base.object,
        base.target_height,
        base.reference,
        (),
        overhead=base.overhead,
        surroundings=base.surroundings,
        light=BRIGHT,
        mesh_sha256=sha256,
    )
