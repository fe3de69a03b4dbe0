"""Commands of recognition: known objects, their thresholds, and which of them the views show."""

import math
import os
import time
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from convexperc import features, recognition, report
from convexperc.cli import stream_options, streams
from convexperc.cli.exits import exits
from convexperc.cli.options import (
    BUDGET,
    EPILOG,
    Json,
    Seconds,
    check_outputs,
    say_left_out,
    with_folders,
    write,
)
from convexperc.cli.progress import working
from convexperc.errors import CalibrationError, escaped
from convexperc.files import json_bytes

app = typer.Typer()


class DecisionName(StrEnum):
    """What decides the label; see `convexperc.recognition.decision`."""

    OBJECTIVE = "objective"
    EXPLAINED_FRACTION = "explained-fraction"
    EXPLAINED_SHARE = "explained-share"
    """The former name of the explained fraction."""


RECOGNIZE_HELP = (
    "Recognise the object that all views show.\n\n"
    "The label is the object with the lowest optimum, by proof. That does not say that the label is right, "
    "or that the object is among the references; thresholds of `calibrate` judge that with a stated coverage."
)


@app.command(help=RECOGNIZE_HELP, epilog=EPILOG)
@exits
def recognize(  # noqa: PLR0913, PLR0917 - the options of a command
    references: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder with OBJECT.png or OBJECT/*.png for each object, or a file of `library`.",
        ),
    ] = None,
    views: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder with one picture from each robot.")
    ] = None,
    sample: Annotated[
        bool, typer.Option("--sample", help="Use the pictures that come with the package.")
    ] = False,
    scene: Annotated[
        str | None, typer.Option(metavar="NAME", help="Scene of the sample; by default its first one.")
    ] = None,
    lambda1: Annotated[float, typer.Option(help="Weight of the coupling of views and features.")] = 0.1,
    lambda2: Annotated[float, typer.Option(help="Weight of the selection of views.")] = 1.0,
    lambda3: Annotated[float, typer.Option(help="Weight of the selection of modalities.")] = 0.1,
    decide: Annotated[
        DecisionName,
        typer.Option(help="What decides: the lowest optimum, or the largest fraction of ||o||^2 explained."),
    ] = DecisionName.OBJECTIVE,
    json: Json = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            "--picture", metavar="FILE", help="Draw the outcome: .png or .svg. Needs the extra plot."
        ),
    ] = None,
    configuration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Feature configuration (JSON), complete.")
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Thresholds of `calibrate`, which accept or refuse the label."),
    ] = None,
    each_view: Annotated[
        bool, typer.Option("--each-view", help="Also solve for each view alone, and add up the optima.")
    ] = False,
    seconds: Seconds = BUDGET,
    view: stream_options.View = None,
    region: stream_options.Part = None,
    mask: stream_options.MaskFile = None,
    slop: stream_options.Slop = stream_options.SLOP,
    every: stream_options.Every = None,
    rate: stream_options.Rate = stream_options.RATE,
    strict: stream_options.Strict = False,
    jsonl: stream_options.Jsonl = None,
    results: stream_options.Results = None,
    watch: stream_options.Watching = False,
) -> bool:
    """Run ``convexperc recognize``."""
    viewed = views is not None or bool(view)
    if sample == (references is not None or viewed) or (scene is not None and not sample):
        raise typer.BadParameter(
            "give --references and --views (or --view), or --sample (and optionally --scene)"
        )
    if (references is None) == viewed:
        raise typer.BadParameter("--references goes with --views or --view")
    _say_left_out(references=references, views=views)
    asked = streams.Asked(
        view or (), region or (), mask or (), slop, every, rate, strict, jsonl, results, watch
    )
    with working("working"):
        kind = None if figure is None else report.picture_kind(figure)
        read = {
            "--references": references, "--views": views, "--configuration": configuration,
            "--calibration": calibration,
        }  # fmt: skip
        outputs = {"--json": json, "--picture": figure}
        check_outputs(outputs, read, {"--references": 1})
        asked.check(outputs, with_folders(read, {"--references": 1}))
        heading, prepared, seen, told = _asked(references, views, scene, configuration, asked)
        recogniser = streams.Recogniser(
            prepared,
            {"lambda1": lambda1, "lambda2": lambda2, "lambda3": lambda3, "seconds": seconds,
             "decision": decide.value.replace("-", " ")},
            None if calibration is None else recognition.read_calibration(calibration),
        )  # fmt: skip
        if not isinstance(seen, streams.Stream):
            found, judged = recogniser.perceive(seen, None)
            alone = recognition.EachView.of(found) if each_view else None
            record = report.recognition_record(found, prepared.configuration, judged, alone)
            content = {} if json is None else {json: json_bytes(record)}
            if figure is not None and kind is not None:
                shown = {name: seen[name] for name in found.views}
                content[figure] = report.recognition_picture(found, shown, kind, judged)
    if isinstance(seen, streams.Stream):
        seen.check({**outputs, "--each-view": each_view})
        return seen.follow(recogniser, told)
    for line in told:
        typer.echo(escaped(line), err=True)
    write(content)
    tables = report.tables
    out = tables.console()
    out.print(escaped(heading))
    tables.show_recognition(out, found, judged, alone)
    accepted = judged is None or judged.accepted == (found.label,)
    return found.certified and found.label is not None and accepted


LIBRARY_HELP = (
    """Describe the pictures of known objects, and keep that in a file for `recognize --references`."""
)


@app.command(help=LIBRARY_HELP)
@exits
def library(
    references: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder with OBJECT.png or OBJECT/*.png for each object."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="Write the library; safetensors.")],
    configuration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Feature configuration (JSON), complete.")
    ] = None,
) -> bool:
    """Run ``convexperc library``."""
    _say_left_out(references=references)
    with working("describing"):
        check_outputs({"--out": out}, {"DIR": references, "--configuration": configuration}, {"DIR": 1})
        pictures = recognition.read_references(references)
        known = recognition.References.of(pictures, _configuration(configuration))
        known.save(out)
    count, place = len(known.names), escaped(os.fspath(out))
    typer.echo(
        f"{count} references of {len(known.objects)} objects, {known.library.d} features each, in {place}"
    )
    return True


CALIBRATE_HELP = (
    "Set the thresholds by which `recognize --calibration` accepts an object.\n\n"
    "Labelled scenes set them, or with --robots the references themselves. Scenes of objects that are not "
    "among the references set nothing; it is counted how many are refused."
)


@app.command(help=CALIBRATE_HELP)
@exits
def calibrate(
    references: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder of the known objects, or a file of `library`.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="Write the thresholds as JSON.")],
    scenes: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder with OBJECT/SCENE/*.png: one picture from each robot."),
    ] = None,
    robots: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            help="Set them by N references of an object at a time, left out of the library as if they were"
            " views; --scenes are then only counted.",
        ),
    ] = None,
    coverage: Annotated[
        float, typer.Option(help="Share of scenes of known objects whose object is to be accepted.")
    ] = 0.9,
    lambda1: Annotated[float, typer.Option(help="Weight of the coupling of views and features.")] = 0.1,
    lambda2: Annotated[float, typer.Option(help="Weight of the selection of views.")] = 1.0,
    lambda3: Annotated[float, typer.Option(help="Weight of the selection of modalities.")] = 0.1,
    decide: Annotated[
        DecisionName, typer.Option(help="What decides; see `recognize`.")
    ] = DecisionName.OBJECTIVE,
    configuration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Feature configuration (JSON), complete.")
    ] = None,
) -> bool:
    """Run ``convexperc calibrate``."""
    if scenes is None and robots is None:
        raise typer.BadParameter("give --scenes, or --robots to calibrate by the references themselves")
    _say_left_out(references=references, scenes=scenes)
    with working("calibrating"):
        read = {"--references": references, "--scenes": scenes, "--configuration": configuration}
        check_outputs({"--out": out}, read, {"--references": 1, "--scenes": 2})
        known, found = _known(references, configuration), []
        chosen, decision = (lambda1, lambda2, lambda3), decide.value.replace("-", " ")
        for truth, views in () if scenes is None else recognition.read_scenes(scenes):
            seen = recognition.perceive(
                views, known, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3, prune=False,
                decision=decision,
            )  # fmt: skip
            found.append((seen, truth))
        made, counts = _calibrated(known, found, robots, coverage, chosen, decision)
        if math.isinf(made.share):
            must = f"must be at least {recognition.fewest_scenes(coverage)} for a coverage of {coverage:g}"
            remedy = "Label more scenes, or lower --coverage."
            raise CalibrationError("scenes of known objects", value=made.scenes, must=must, remedy=remedy)
        content = {out: json_bytes(made.to_dict())}
    write(content)
    for line in dict.fromkeys(warning for seen, _ in found for warning in seen.warnings):
        typer.echo(escaped(f"warning: {line}"), err=True)
    tables = report.tables
    tables.show_calibration(tables.console(), made, counts)
    return True


def _calibrated(
    known: "recognition.References",
    found: "list[tuple[recognition.Recognition, str]]",
    robots: int | None,
    coverage: float,
    lambdas: tuple[float, float, float],
    decision: str,
) -> "tuple[recognition.Calibration, recognition.Counts | None]":
    """Set the thresholds, by labelled scenes or held-out references, and count how the former fare."""
    if robots is None:
        return recognition.calibrated(found, coverage)
    lambda1, lambda2, lambda3 = lambdas
    scenes = recognition.held_out_scenes(
        known.library, robots, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3, decision=decision
    )
    made = recognition.Calibration.of(scenes, coverage, known.library)
    return made, recognition.counted(made, found) if found else None


WARM_HELP = (
    "Compile ahead of time what is otherwise compiled once that pays (needs the extra fast).\n\n"
    "The machine code is kept beside the package, or in the user's cache folder if that cannot be written; "
    "CONVEXPERC_CACHE_DIR names another folder."
)


@app.command(help=WARM_HELP)
@exits
def warm() -> bool:
    """Run ``convexperc warm``."""
    began = time.perf_counter()
    with working("compiling"):
        places = recognition.warm()
    if not places:
        return False  # a warning has said that no folder can be written
    folders = sorted({str(path.parent) for path in places})
    took = time.perf_counter() - began
    typer.echo(f"machine code of {len(places)} kernels in {escaped(', '.join(folders))}, {took:.1f} s")
    return True


def _asked(
    references: Path | None,
    views: Path | None,
    scene: str | None,
    configuration: Path | None,
    asked: streams.Asked,
) -> "tuple[str, recognition.References, Mapping[str, Any] | streams.Stream, list[str]]":
    """Return the heading, the known objects, the views or what delivers them, and what to tell of these."""
    if references is not None and asked.view:
        taken, told = asked.take(views)
        known = _known(references, configuration)
        heading = f"{len(taken)} named views, {len(known.objects)} objects in {references}"
        return heading, known, taken, told
    if references is not None and views is not None:
        known, seen = _known(references, configuration), recognition.read_pictures(views)
        heading = f"{len(seen)} views in {views}, {len(known.objects)} objects in {references}"
        return heading, known, seen, []
    names = recognition.sample_names()
    shown = recognition.sample_scene(names[0] if scene is None else scene)
    others = ", ".join(f"--scene {name}" for name in names if name != shown.name)
    heading = f"Sample: {len(shown.views)} robots look at {shown.name} (other scenes: {others})"
    known = recognition.References.of(shown.references, _configuration(configuration))
    return heading, known, shown.views, []


def _known(references: Path, configuration: Path | None) -> "recognition.References":
    """Read the known objects from a folder, or from a file that holds them already described."""
    if not references.is_file():
        pictures = recognition.read_references(references)
        return recognition.References.of(pictures, _configuration(configuration))
    if configuration is not None:
        raise typer.BadParameter("leave out --configuration: the file of --references has its own")
    return recognition.References.load(references)


def _configuration(file: Path | None) -> "features.FeatureConfiguration":
    return features.FeatureConfiguration() if file is None else features.read_configuration(file)


def _say_left_out(
    *, references: Path | None = None, views: Path | None = None, scenes: Path | None = None
) -> None:
    """Say in a line for each folder what of it is not read, and why, before anything fails for want of it."""
    for folder in (references, views, scenes):
        if folder is None or folder.is_file():
            continue
        say_left_out(
            folder, recognition.left_out(folder, references=folder is references, scenes=folder is scenes)
        )
