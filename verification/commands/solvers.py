"""Commands about solvers and proofs: families, campaign, check, bench; no mathematics."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from rich.console import Console
from rich.table import Table as Grid

from verification.commands.misuse import misuse

Seed = Annotated[int, typer.Option(min=0, help="Seed of every family's stream.")]
File = Annotated[Path | None, typer.Option("--json", help="Write everything to this file.", dir_okay=False)]


def families() -> None:
    """List the families of problems."""
    from verification.problems.families import FAMILIES, RANDOM, SUMMARIES  # noqa: PLC0415 - keeps --help quick

    grid = Grid("family", "group", "what it is")
    for name in FAMILIES:
        grid.add_row(name, "random" if name in RANDOM else "degenerate", SUMMARIES[name])
    _console().print(grid)


def campaign(  # noqa: PLR0913, PLR0917 - one for each option
    random: Annotated[int, typer.Option(min=0, help="Random problems.")] = 2000,
    degenerate: Annotated[
        int, typer.Option(min=0, help="Degenerate problems, scales 1e-8..1e8 among them.")
    ] = 2000,
    extreme: Annotated[int, typer.Option(min=0, help="Problems with scales 1e-150..1e150.")] = 0,
    seed: Seed = 0,
    solver: Annotated[Literal["newton", "conic"], typer.Option(help="What answers.")] = "newton",
    escalate: Annotated[
        bool, typer.Option(help="Use ball arithmetic where the solver's answer is not certified.")
    ] = True,
    referee: Annotated[
        int, typer.Option(min=0, help="Exact referee on every k-th problem of a family; 0: none.")
    ] = 20,
    raw: Annotated[
        int, typer.Option(min=0, help="Raw CVXPY + Clarabel on every k-th problem of a family; 0: none.")
    ] = 0,
    json_file: File = None,
    resume: Annotated[
        Path | None,
        typer.Option(help="Continue the campaign of this --json file, with its settings.", dir_okay=False),
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Worker processes.")] = 1,
) -> None:
    """Solve, certify and referee problems; exit code 1 if one is not certified or a proof is false."""
    from verification.search.campaign.file import Settings, load  # noqa: PLC0415 - keeps --help quick
    from verification.search.campaign.run import run  # noqa: PLC0415 - keeps --help quick
    from verification.search.campaign.screen import Watch, details, families_table, raw_table  # noqa: PLC0415

    command = ["convexperc-verification", *sys.argv[1:]]
    settings = Settings(random, degenerate, extreme, seed, solver, escalate, referee, raw)
    state = settings.fresh()
    if resume is not None:
        try:
            command, settings, state = load(resume)
        except (OSError, ValueError) as problem:
            raise typer.BadParameter(f"cannot resume {resume}: {problem}", param_hint="--resume") from None
        json_file = json_file or resume
    if not len(settings.plan):
        raise typer.BadParameter("at least one problem is needed: a run that checks nothing proves nothing")
    watch = Watch(settings, command, json_file)
    try:
        watch(state)
        report = run(settings.plan, settings.rules, jobs=jobs, state=state, progress=watch)
    except OSError as problem:
        raise typer.BadParameter(
            f"cannot write {json_file}: {problem.strerror}", param_hint="--json"
        ) from None
    console = _console()
    console.print(families_table(report))
    if report.raw:
        console.print(raw_table(report))
    for line in details(report):
        console.print(line, highlight=False, markup=False)
    raise typer.Exit(0 if report.clean else 1)


def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Proof of `convexperc solve --proof`.")],
) -> None:
    """Check a proof file by exact arithmetic; exit code 0 if it proves its claim, 1 if it is rejected."""
    from verification.proof_checker import check as checked  # noqa: PLC0415 - keeps --help quick

    try:
        verdict = checked(file)
    except OSError as problem:
        raise typer.BadParameter(f"cannot read {file}: {problem.strerror}", param_hint="FILE") from None
    data = f"\ndata: sha256 {verdict.sha256}" if verdict.proved else ""
    typer.echo(f"{'proved' if verdict.proved else 'rejected'}: {verdict.reason}{data}")
    raise typer.Exit(0 if verdict.proved else 1)


PROVED = "S"
"""The instance whose proofs are timed."""


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
    """Time the library beside other solvers, all held to the same gap by the same judge."""
    from convexperc.files import write_atomic  # noqa: PLC0415
    from convexperc.report import picture_kind  # noqa: PLC0415 - keeps --help quick
    from verification.bench import screen as report  # noqa: PLC0415
    from verification.bench.floor import growth as grow  # noqa: PLC0415
    from verification.bench.instances import SHAPES, Instance  # noqa: PLC0415
    from verification.bench.picture_frames import picture_times  # noqa: PLC0415
    from verification.bench.proof_times import proof_times  # noqa: PLC0415
    from verification.bench.run import one_thread, run  # noqa: PLC0415

    if plot is not None and not growth:
        raise typer.BadParameter("--plot needs --growth")
    with misuse("--plot"):
        kind = None if plot is None else picture_kind(plot)
    names = instances.split(",")
    if unknown := [name for name in names if name not in SHAPES]:
        raise typer.BadParameter(f"unknown: {', '.join(unknown)}; known: {', '.join(SHAPES)}")
    console, outcomes, frames, proofs = _console(), {}, {}, {}
    with one_thread():
        seen = picture_times(repeat) if pictures else None
        if seen is not None:
            console.print(report.pictures_table(seen))
        for name in names:
            outcomes[name], frames[name] = run(SHAPES[name], peers, templates, repeat, limit)
            console.print(report.peers_table(SHAPES[name], outcomes[name]))
            if name == PROVED:
                proofs[name] = proof_times(Instance.of(SHAPES[name]), repeat)
                console.print(report.proofs_table(name, proofs[name]))
        console.print(report.frames_table(frames))
        grown = grow(repeat) if growth else []
    if growth:
        console.print(report.growth_table(grown))
    if plot is not None and kind is not None:
        from verification.bench.growth_plot import growth_plot  # noqa: PLC0415 - Matplotlib comes with an extra

        write_atomic(plot, growth_plot(grown, kind))
    console.print_json(data=report.machine())
    _write(json_file, report.as_json(outcomes, frames, grown, proofs, seen))


def _console() -> Console:
    return Console(file=sys.stdout, width=None if sys.stdout.isatty() else 140)


def _write(file: Path | None, data: dict[str, Any]) -> None:
    if file is None:
        return
    try:
        file.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as problem:
        raise typer.BadParameter(f"cannot write {file}: {problem.strerror}", param_hint="--json") from None
