"""The command that compares the method with simple rules on the same features; no mathematics."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from convexperc.errors import require
from convexperc.files import write_atomic, write_json
from verification.commands.console import say
from verification.commands.misuse import check_places, misuse
from verification.commands.progress import Show, progress

if TYPE_CHECKING:
    from verification.experiments.scenes.album import Album

SCHEMA = "convexperc/accuracy/1"
ACCURACY_HELP = (
    "Measure how often the method names the right object, beside nearest neighbours, votes and a linear SVM "
    "on the same features and scenes; what its margin says; and what calibrated acceptance gives.\n\n"
    "Needs the extra `bench`. Exit code 0: measured; 2: misuse."
)


def accuracy(
    photos: Annotated[
        Path | None,
        typer.Option(
            help="Photographs: DIR/OBJECT/VIEW.png, with DIR/OBJECT/masks/VIEW.png where there are masks."
            " If all objects are named by category and number, as cup1, categories are recognised too.",
            file_okay=False,
            exists=True,
        ),
    ] = None,
    simulation: Annotated[
        Path | None,
        typer.Option(
            help="Folder of `convexperc simulate physical`: its clear views serve as photographs.",
            file_okay=False,
            exists=True,
        ),
    ] = None,
    configuration: Annotated[
        list[Path] | None,
        typer.Option(
            help="Features (JSON); may be given several times. Without, the defaults.", dir_okay=False
        ),
    ] = None,
    references: Annotated[
        int, typer.Option(min=1, help="References of an object, where it has several.")
    ] = 5,
    scenes: Annotated[
        int, typer.Option(min=1, help="Scenes of each object and draw; of each condition.")
    ] = 6,
    draws: Annotated[
        int, typer.Option(min=1, help="How often references and views of scenes are drawn anew.")
    ] = 3,
    seed: Annotated[int, typer.Option(min=0, help="Two runs of one seed find the same.")] = 0,
    resamples: Annotated[int, typer.Option(min=1, help="Of the bootstrap.")] = 2000,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write everything to this file.", dir_okay=False)
    ] = None,
    markdown: Annotated[
        Path | None,
        typer.Option(help="Write the tables to this file; else they are printed.", dir_okay=False),
    ] = None,
) -> None:
    """Run the command ``accuracy``."""
    require("sklearn", "bench", "the comparison with a linear SVM")
    from convexperc.features import FeatureConfiguration, read_configuration  # noqa: PLC0415 - keeps --help quick
    from convexperc.recognition import warm  # noqa: PLC0415
    from verification.accuracy.measure import measure  # noqa: PLC0415
    from verification.accuracy.record import design_record, pictures_record  # noqa: PLC0415
    from verification.accuracy.scenes import Sizes  # noqa: PLC0415
    from verification.accuracy.tables import pages  # noqa: PLC0415
    from verification.experiments.design import Design  # noqa: PLC0415
    from verification.provenance import installed, stamp  # noqa: PLC0415

    if photos is None and simulation is None:
        raise typer.BadParameter("one of them, or both, must be given", param_hint="--photos, --simulation")
    files = configuration or []
    inputs = {"--photos": photos, "--simulation": simulation} | {
        f"--configuration {k}": file for k, file in enumerate(files, 1)
    }
    check_places(inputs, json=json_file, markdown=markdown)
    made = stamp("accuracy")  # before the work, during which files may change
    made["versions"]["scikit-learn"] = installed("scikit-learn")
    with misuse("--configuration"):
        chosen = {file.stem: read_configuration(file) for file in files} or {
            "default": FeatureConfiguration()
        }
    if len(chosen) < len(files):
        raise typer.BadParameter("files must have different names", param_hint="--configuration")
    sizes, design = Sizes(seed, draws, scenes, references), Design(seed, 1, resamples)
    warm()
    results: list[dict[str, Any]] = []
    with progress() as show:
        for kind, albums in _albums(photos, simulation).items():
            for name, features in chosen.items():
                told_of = partial(_show, show, f"{kind}, {name}")
                with misuse(f"--{kind}"):
                    found = measure(albums, features, sizes, design, told_of)
                by = {"configuration name": name, "configuration": features.to_dict()}
                results.append({"pictures": pictures_record(kind, albums), **by, **found})
    record = {
        "schema": SCHEMA,
        "command": _command(
            {"photos": photos, "simulation": simulation}, list(chosen), files, sizes, resamples
        ),
        "design": design_record(sizes, design),
        "results": results,
        "made": made,
    }
    if json_file is not None:
        with misuse("--json"):
            write_json(json_file, record)
    if markdown is None:
        say(pages(record))
    else:
        with misuse("--markdown"):
            write_atomic(markdown, pages(record).encode())


def _show(show: Show, of: str, stage: str, done: int, total: int) -> None:
    show(f"{of}: {stage}", done, total)


def _albums(photos: Path | None, simulation: Path | None) -> "dict[str, tuple[Album, ...]]":
    """The photographs of each collection, by the name of its option."""
    from verification.accuracy.scenes import simulated_albums  # noqa: PLC0415 - keeps --help quick
    from verification.experiments.scenes.album import read_albums  # noqa: PLC0415
    from verification.experiments.scenes.folder import read_physical  # noqa: PLC0415

    found = {}
    if photos is not None:
        with misuse("--photos"):
            found["photos"] = read_albums(photos)
    if simulation is not None:
        with misuse("--simulation"):
            found["simulation"] = simulated_albums(read_physical(simulation))
    return found


def _command(
    given: dict[str, Path | None], names: list[str], files: list[Path], sizes: Any, resamples: int
) -> str:
    """The command again, with folders and files by what they are: a path of this machine says nothing."""
    words = ["convexperc-verification accuracy"]
    words += [f"--{name} {name.upper()}" for name, folder in given.items() if folder is not None]
    words += [f"--configuration {name}.json" for name in names if files]
    words += [f"--references {sizes.references} --scenes {sizes.scenes} --draws {sizes.draws}"]
    return " ".join([*words, f"--seed {sizes.seed} --resamples {resamples}"])
