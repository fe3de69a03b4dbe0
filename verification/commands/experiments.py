"""The command that does the paper's experiments again; no mathematics."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from convexperc.errors import require
from convexperc.files import check_apart, check_place
from verification.commands.console import console, say
from verification.commands.misuse import OPEN, misuse
from verification.commands.progress import progress
from verification.commands.stored import survey_table

if TYPE_CHECKING:
    from verification.experiments.record.collection import Collection


EXPERIMENTS_HELP = (
    "Do the paper's experiments again, on simulated scenes and on photographs, in many configurations.\n\n"
    "Writes OUT/experiments.json, its pages, figures and contact sheets. Without --simulation and "
    "--case-study the scenes are drawn first. A run that is broken off goes on where it was when it is "
    "started again. Exit code 0: done; 2: misuse; 3: broken off."
)


def experiments(
    simulation: Annotated[
        Path | None,
        typer.Option(help="Folder of `convexperc simulate physical`.", file_okay=False, exists=True),
    ] = None,
    case_study: Annotated[
        Path | None,
        typer.Option(help="Folder of `convexperc simulate case-study`.", file_okay=False, exists=True),
    ] = None,
    photos: Annotated[
        Path | None,
        typer.Option(
            help="Photographs: DIR/OBJECT/VIEW.png, with DIR/OBJECT/masks/VIEW.png where there are masks;"
            " whole numbers as names are azimuths in degrees.",
            file_okay=False,
            exists=True,
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the record and its pages.", file_okay=False)] = Path(
        "build/experiments"
    ),
    configurations: Annotated[
        int, typer.Option(min=1, help="How many choices of what the paper leaves open; 128 is all.")
    ] = 128,
    workers: Annotated[int, typer.Option(min=1, help="Processes; the record does not depend on it.")] = 2,
    simulate: Annotated[
        bool, typer.Option("--simulate/--no-simulate", help="Whether simulated scenes are judged at all.")
    ] = True,
    seed: Annotated[int, typer.Option(min=0, help="Two runs of one seed find the same.")] = 0,
    repetitions: Annotated[
        int, typer.Option(min=1, help="Random subsets for each scene and number of views.")
    ] = 10,
    cache: Annotated[
        Path | None,
        typer.Option(help="Folder of drawn pictures and features; default OUT/.journal.", file_okay=False),
    ] = None,
) -> None:
    """Run the command ``experiments``."""
    from convexperc.simulation import backends as simulation_backends  # noqa: PLC0415 - keeps --help quick

    if simulate and simulation is None:  # asked before the imports below, so that one line names both extras
        require("mujoco", "sim,verify", "drawing the scenes")
        simulation_backends.choose_backend()
    from verification.experiments.design import Design  # noqa: PLC0415
    from verification.experiments.measure.configurations import first  # noqa: PLC0415
    from verification.experiments.record.reading import read_experiments  # noqa: PLC0415
    from verification.experiments.record.record import NAME, write_record  # noqa: PLC0415
    from verification.experiments.record.run import run  # noqa: PLC0415
    from verification.report.experiments.pages import publish  # noqa: PLC0415
    from verification.report.experiments.sheets import contact_sheets  # noqa: PLC0415

    design = Design(seed, repetitions)
    if (simulation is None) != (case_study is None) or (simulation is not None and not simulate):
        raise typer.BadParameter("--simulation and --case-study go together, and without --no-simulate")
    if photos is None and not simulate:
        raise typer.BadParameter("nothing is left to be judged", param_hint="--no-simulate")
    folder = cache or out / ".journal"
    _check_outputs(out, folder, {"--simulation": simulation, "--case-study": case_study, "--photos": photos})
    with misuse("--out"):
        out.mkdir(parents=True, exist_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        check_place(out / NAME)
    with misuse("--configurations"):
        chosen = first(configurations)
    try:
        if simulate and (simulation is None or case_study is None):
            simulation, case_study = _drawn(folder, seed, workers)
        sets = list(_collections(simulation, case_study, photos, seed))
        with progress() as show:
            data = run(
                sets, chosen, design, cache=folder / "features", journal=out / ".journal" / "readings",
                workers=workers, progress=show,
            )  # fmt: skip
    except KeyboardInterrupt:
        say("broken off; the same command goes on from there")
        raise typer.Exit(OPEN) from None
    given = {"--simulation": simulation, "--case-study": case_study, "--photos": photos}
    data["volatile"]["command"] = _command(given, configurations, seed, repetitions)
    with misuse("--out"):
        place = write_record(out, data)
        found = read_experiments(place, with_sheets=False)
        folders = [folder for folder in (simulation, case_study) if folder is not None]
        pages = publish(replace(found, sheets=contact_sheets(found.content, folders)), out)
    console().print(survey_table(found.surveys, f"record {found.digest[:12]}"))
    say(f"wrote {place} and, beside it, {len(pages)} files: pages, figures, contact sheets")


EXPERIMENTS_PAGES_HELP = (
    "Write the pages of the record of the experiments that comes with the verifier; measure nothing."
)


def experiments_pages(
    out: Annotated[Path, typer.Option(help="Folder of the pages.", file_okay=False)] = Path(
        "reports/experiments"
    ),
) -> None:
    """Run the command ``experiments-pages``."""
    from verification.report.experiments.pages import publish_packaged  # noqa: PLC0415 - keeps --help quick

    with misuse("--out"):
        pages = publish_packaged(out)
    say(f"wrote {len(pages)} files into {out}")


def _check_outputs(out: Path, cache: Path, inputs: dict[str, Path | None]) -> None:
    """Refuse folders of pictures that lie where something is written, or where it would be read with them."""
    from verification.experiments.record.record import NAME  # noqa: PLC0415 - keeps --help quick

    files = {f"{name} of --out": out / name for name in (NAME, "experiments.html", "experiments.md")}
    folders = {f"{name} of --out": out / name for name in ("figures", "sheets", ".journal/readings")}
    folders["features of --cache"] = cache / "features"
    check_apart(files, folders=folders, inputs=inputs)


def _drawn(folder: Path, seed: int, workers: int) -> tuple[Path, Path]:
    """Draw both simulated sets, or what is missing of them."""
    from verification.experiments.scenes.simulated import draw  # noqa: PLC0415 - keeps --help quick

    with misuse("--cache"), progress() as show:
        return draw(folder, seed, workers, show)


def _collections(
    simulation: Path | None, case_study: Path | None, photos: Path | None, seed: int
) -> "Iterator[Collection]":
    from verification.experiments.record.collection import Collection  # noqa: PLC0415 - keeps --help quick

    if simulation is not None and case_study is not None:
        with misuse("--simulation, --case-study"):
            yield Collection.simulated(simulation, case_study)
    if photos is not None:
        with misuse("--photos"):
            yield Collection.photographed(photos, seed)


def _command(given: dict[str, Path | None], configurations: int, seed: int, repetitions: int) -> str:
    """The command again, with folders by what they are: a path of this machine says nothing."""
    words = ["python -m verification experiments"]
    words += [f"{name} {name.strip('-').upper()}" for name, folder in given.items() if folder is not None]
    return " ".join([*words, f"--configurations {configurations} --seed {seed} --repetitions {repetitions}"])
