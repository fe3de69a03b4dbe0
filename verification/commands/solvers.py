"""Commands about solvers and proofs: families, check, bench; no mathematics."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table as Grid

from convexperc.files import write_atomic, write_json
from verification.commands.console import console, say
from verification.commands.misuse import check_places, misuse

File = Annotated[Path | None, typer.Option("--json", help="Write everything to this file.", dir_okay=False)]


FAMILIES_HELP = """List the families of problems."""


def families() -> None:
    """Run the command ``families``."""
    from verification.problems.families import FAMILIES, RANDOM  # noqa: PLC0415 - keeps --help quick
    from verification.problems.summaries import SUMMARIES  # noqa: PLC0415

    grid = Grid("family", "group", "what it is")
    for name in FAMILIES:
        grid.add_row(name, "random" if name in RANDOM else "degenerate", SUMMARIES[name])
    console().print(grid)


CHECK_HELP = (
    "Check a proof file by exact arithmetic; exit code 0 if it proves its claim, 1 if it is rejected."
)


def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Proof of `convexperc solve --proof`.")],
) -> None:
    """Run the command ``check``."""
    from verification.proof_checker import check as checked  # noqa: PLC0415 - keeps --help quick

    try:
        verdict = checked(file)
    except OSError as problem:
        raise typer.BadParameter(f"cannot read {file}: {problem.strerror}", param_hint="FILE") from None
    say(f"{'proved' if verdict.proved else 'rejected'}: {verdict.reason}")
    if verdict.proved:
        say(f"data: sha256 {verdict.sha256}")
    raise typer.Exit(0 if verdict.proved else 1)


PROVED = "S"
"""The instance whose proofs are timed."""


BENCH_HELP = """Time the library beside other solvers, all held to the same gap by the same judge."""


def bench(
    instances: Annotated[str, typer.Option(help="Names, with commas between: S, M, L, XL, P.")] = "S,M",
    peers: Annotated[str, typer.Option(help="Only peers whose name contains this.")] = "",
    templates: Annotated[int, typer.Option(min=1, help="Templates judged for each choice of lambdas.")] = 4,
    repeat: Annotated[int, typer.Option(min=1, help="Timings of which the median counts.")] = 5,
    limit: Annotated[float, typer.Option(min=0.0, help="Seconds a peer may take on an instance.")] = 60.0,
    growth: Annotated[bool, typer.Option("--growth", help="Also fit the growth with n, d, m and p.")] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the growth: .png or .svg; with --growth.", dir_okay=False)
    ] = None,
    pictures: Annotated[bool, typer.Option("--pictures", help="Also time frames from pictures.")] = False,
    json_file: File = None,
) -> None:
    """Run the command ``bench``."""
    from convexperc.report import picture_kind  # noqa: PLC0415 - keeps --help quick
    from verification.bench import screen as report  # noqa: PLC0415
    from verification.bench.floor import growth as grow  # noqa: PLC0415
    from verification.bench.instances import SHAPES, Instance  # noqa: PLC0415
    from verification.bench.picture_frames import picture_times  # noqa: PLC0415
    from verification.bench.proof_times import proof_times  # noqa: PLC0415
    from verification.bench.run import one_thread, run  # noqa: PLC0415
    from verification.provenance import stamp  # noqa: PLC0415

    if plot is not None and not growth:
        raise typer.BadParameter("--plot needs --growth")
    with misuse("--plot"):
        kind = None if plot is None else picture_kind(plot)
    names, made = instances.split(","), stamp("benchmark")  # before the work, during which files may change
    if unknown := [name for name in names if name not in SHAPES]:
        raise typer.BadParameter(f"unknown: {', '.join(unknown)}; known: {', '.join(SHAPES)}")
    check_places(plot=plot, json=json_file)
    screen, outcomes, frames, proofs = console(), {}, {}, {}
    with one_thread():
        seen = picture_times(repeat) if pictures else None
        if seen is not None:
            screen.print(report.pictures_table(seen))
        for name in names:
            outcomes[name], frames[name] = run(SHAPES[name], peers, templates, repeat, limit)
            screen.print(report.peers_table(SHAPES[name], outcomes[name]))
            if name == PROVED:
                proofs[name] = proof_times(Instance.of(SHAPES[name]), repeat)
                screen.print(report.proofs_table(name, proofs[name]))
        screen.print(report.frames_table(frames))
        grown = grow(repeat) if growth else []
    if growth:
        screen.print(report.growth_table(grown))
    if plot is not None and kind is not None:
        from verification.bench.growth_plot import growth_plot  # noqa: PLC0415 - Matplotlib comes with an extra

        with misuse("--plot"):
            write_atomic(plot, growth_plot(grown, kind))
    screen.print_json(data=report.machine())
    if json_file is not None:
        with misuse("--json"):
            write_json(json_file, report.as_json(outcomes, frames, grown, proofs, seen, made))
