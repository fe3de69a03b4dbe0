"""The command ``convexperc simulate``: draws data sets and single scenes into folders."""

import os
import shlex
from enum import StrEnum
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer

from convexperc import simulation
from convexperc.cli.exits import exits
from convexperc.cli.options import say_left_out
from convexperc.cli.progress import progress
from convexperc.errors import escaped
from convexperc.files import check_apart, json_bytes

app = typer.Typer(
    name="simulate",
    no_args_is_help=True,
    help="Draw pictures of simulated robots' views, with masks of the object. Needs the extra sim.",
)

START = "starting to draw"


class Example(StrEnum):
    """A scene that was laid out by hand."""

    RED_CAR = "red-car"
    GRAY_CAR = "gray-car"
    ICA_SIGN = "ica-sign"


Folder = Annotated[
    Path,
    typer.Argument(
        metavar="DIR", help="Output folder: a new one, or that of an interrupted run, which is continued."
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of the layouts.")]
Workers = Annotated[int, typer.Option(help="Number of processes; the pictures do not depend on it.")]
Width = Annotated[int, typer.Option(help="Width of a view in pixels.")]
Height = Annotated[int, typer.Option(help="Height of a view in pixels.")]
Objects = Annotated[
    str | None,
    typer.Option(
        metavar="NAMES", help="Names of objects, with commas between them. By default those of the set."
    ),
]
MESHES = "Folder with a folder of OBJ files for each object, in place of the package's of that name;"
Meshes = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help=f"{MESHES} others are drawn if --objects names them."),
]
MeshesOfScene = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help=f"{MESHES} another is drawn if the description names it."),
]


PHYSICAL_HELP = """Draw small objects in a lab, seen by six rovers at five levels of obstruction."""


@app.command(help=PHYSICAL_HELP)
@exits
def physical(
    folder: Folder,
    seed: Seed = 0,
    scenes: Annotated[int, typer.Option(help="Scenes of each object and level.")] = 6,
    workers: Workers = 2,
    width: Width = 160,
    height: Height = 120,
    objects: Objects = None,
    meshes: Meshes = None,
) -> bool:
    """Run ``convexperc simulate physical``."""
    return _write_set("physical", folder, seed, scenes, workers, (width, height), objects, meshes)


CASE_STUDY_HELP = "Draw two cars and a sign in a park, seen by five robots of which three have a good view."


@app.command(help=CASE_STUDY_HELP)
@exits
def case_study(
    folder: Folder,
    seed: Seed = 0,
    scenes: Annotated[int, typer.Option(help="Scenes of each object.")] = 8,
    workers: Workers = 2,
    width: Width = 160,
    height: Height = 120,
    objects: Objects = None,
    meshes: Meshes = None,
) -> bool:
    """Run ``convexperc simulate case-study``."""
    return _write_set("case-study", folder, seed, scenes, workers, (width, height), objects, meshes)


SCENE_HELP = """Draw one scene that a file describes."""


@app.command(help=SCENE_HELP)
@exits
def scene(
    description: Annotated[
        Path, typer.Argument(metavar="FILE", help="Description (JSON); see `simulate example`.")
    ],
    folder: Folder,
    width: Width = 160,
    height: Height = 120,
    meshes: MeshesOfScene = None,
) -> bool:
    """Run ``convexperc simulate scene``."""
    start = perf_counter()
    check_apart({}, folders={"DIR": folder}, inputs={"FILE": description, "--meshes": meshes})
    known = None if meshes is None else simulation.read_meshes(meshes)
    asked = simulation.read_scene(description)
    _say_left_out(meshes, known, (asked.object,))
    written = simulation.write_scene(folder, asked, simulation.ImageSize(width, height), meshes=known)
    _report(folder, written, perf_counter() - start)
    return True


EXAMPLE_HELP = (
    "Print the description of a scene, to start from; each scene in a manifest.json has one as well."
)


@app.command(help=EXAMPLE_HELP)
@exits
def example(
    name: Annotated[Example, typer.Argument(metavar="NAME", help="red-car, gray-car or ica-sign.")] = (
        Example.RED_CAR
    ),
) -> bool:
    """Run ``convexperc simulate example``."""
    found = next(one for one in simulation.SCENES if one.name == name.value)
    typer.echo(json_bytes(simulation.scene_record(found)), nl=False)
    return True


def _write_set(
    kind: "simulation.SetName",
    folder: Path,
    seed: int,
    scenes: int,
    workers: int,
    size: tuple[int, int],
    objects: str | None,
    meshes: Path | None,
) -> bool:
    start = perf_counter()
    check_apart({}, folders={"DIR": folder}, inputs={"--meshes": meshes})
    known = None if meshes is None else simulation.read_meshes(meshes)
    names = simulation.OBJECTS_OF[kind] if objects is None else tuple(objects.split(","))
    request = simulation.Request(kind, seed, scenes, names, simulation.ImageSize(*size))
    _say_left_out(meshes, known, names)
    with progress(START, "drew") as (expect, step):

        def advance(name: str, parts: int) -> None:
            expect(parts)
            step(name)

        written = simulation.write_data_set(folder, request, meshes=known, workers=workers, progress=advance)
    _report(folder, written, perf_counter() - start)
    return True


def _say_left_out(
    folder: Path | None, known: "dict[str, simulation.MeshModel] | None", names: tuple[str, ...]
) -> None:
    """Say in one line what of a folder of meshes is not drawn, and why."""
    if folder is None or known is None:
        return
    said = [each for name in names if name in known for each in known[name].left_out]
    said += [f"{name} (no object of that name is drawn)" for name in known if name not in names]
    said += simulation.unread_meshes(folder)
    say_left_out(folder, said)


def _report(folder: Path, written: "simulation.Written", seconds: float) -> None:
    """Print what was drawn, how fast, and a command to try it with."""
    manifest = written.manifest
    count = f"{written.pictures} views and references with masks of {len(manifest['scenes'])} scenes"
    typer.echo(escaped(f"{count} in {os.fspath(folder)}"))
    hidden = [scene["name"] for scene in manifest["scenes"] if _is_hidden(scene)]
    if hidden:
        typer.echo(escaped(f"warning: no robot sees the object in {', '.join(hidden)}"), err=True)
    if written.drawn_pictures:
        each = seconds / written.drawn_pictures
        typer.echo(f"drew {written.drawn_pictures} of them in {seconds:.1f} s, {each:.3f} s a picture")
    else:
        typer.echo("all of them were there already")
    if len(manifest["references"]) > 1:
        views = folder / "views" / manifest["scenes"][0]["name"]
        arguments = ["--references", os.fspath(folder / "references"), "--views", os.fspath(views)]
        typer.echo(escaped(f"try: convexperc recognize {shlex.join(arguments)}"))


def _is_hidden(scene: dict[str, Any]) -> bool:
    """Whether no view of a scene in a manifest shows a part of the object."""
    return not any(view["visible_share"] for view in scene["views"])
