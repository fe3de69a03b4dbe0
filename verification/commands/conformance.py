"""The commands of the conformance kit: conform, and its export, template and vectors; no mathematics."""

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from convexperc.files import write_atomic, write_json
from verification.commands.console import console, say
from verification.commands.misuse import FAILED, OPEN, check_places, misuse
from verification.commands.progress import progress

if TYPE_CHECKING:
    from verification.conformance.profiles import Profile

WRITTEN = ("report.html", "report.json", "junit.xml")
CONFORM_HELP = """Judge a solver in any language: every request of the vectors asked, every answer judged.

Exit code 0: nothing failed but what is known to; 1: something failed; 2: misuse; 3: nothing failed, but
the solver declined requests, or a verdict stayed undecided.
"""
EXPORT_HELP = (
    """Write the requests for a solver that runs elsewhere; `conform --results` reads its answers."""
)
TEMPLATE_HELP = """Print a solver to start from, in C or Python."""
FINDINGS_HELP = """Judge the solvers that are installed, and write what is found as a page and as JSON."""
VECTORS_HELP = """Make the vectors anew, or with --check derive again all that those of the package say."""

Filter = Annotated[
    str, typer.Option("--filter", metavar="PATTERN", help="Only ids like zero-*, or those with a flag.")
]
ProfileName = Annotated[str, typer.Option("--profile", help="float64 or float32.")]


def conform(
    context: typer.Context,
    module: Annotated[str, typer.Option(metavar="PACKAGE:FUNCTION", help="A Python function.")] = "",
    command: Annotated[
        str, typer.Option(metavar="COMMAND", help="A program that reads and writes lines.")
    ] = "",
    results: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Answers that were made elsewhere.", file_okay=False)
    ] = None,
    profile: ProfileName = "float64",
    only: Filter = "",
    known: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Known failures: lines ID LEVEL # why.", dir_okay=False),
    ] = None,
    timeout: Annotated[float, typer.Option(help="Seconds for one answer; 30 more for the first.")] = 10.0,
    max_examples: Annotated[
        int, typer.Option(min=0, help="Requests to search beyond the vectors; what fails is shrunk.")
    ] = 0,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write report.html, report.json, junit.xml.", file_okay=False),
    ] = None,
) -> None:
    """Run the command ``conform``."""
    if context.invoked_subcommand:
        return
    from verification.conformance import outputs  # noqa: PLC0415 - keeps --help quick
    from verification.conformance.doors import Command, Door, Module, Results  # noqa: PLC0415
    from verification.conformance.searching import search  # noqa: PLC0415
    from verification.conformance.suite import Selection, read_known, run  # noqa: PLC0415
    from verification.conformance.vectors import all_vectors  # noqa: PLC0415

    _check_doors(module, command, results, max_examples)
    selection = Selection(_profile(profile), only)
    with misuse("--known"):
        failures = read_known(known) if known is not None else {}
    _check_out(out)

    def door() -> Door:
        if results is not None:
            return Results(results, all_vectors().ids)
        return Module(module, seconds=timeout) if module else Command(command, seconds=timeout)

    searched = None
    with misuse("--module, --command, --results, --timeout or --filter"), progress() as show:
        report = run(door(), selection, known=failures, progress=lambda done, all: show("vectors", done, all))  # noqa: A006
        if max_examples and not report.given_up:
            searched = search(
                door(),
                selection.profile,
                max_examples,
                progress=lambda done, all: show("search", done, all),  # noqa: A006
            )
    console().print(outputs.table(report))
    for line in [] if searched is None else outputs.searched_lines(searched):
        say(line)
    if max_examples and searched is None:
        say("search: not begun, since the solver was given up")
    if out is not None:
        with misuse("--out"):
            html, record, junit = (out / name for name in WRITTEN)
            write_json(record, outputs.as_json(report, searched))
            write_atomic(junit, outputs.junit(report))
            write_atomic(html, outputs.page(report, searched))
        say(f"wrote {out / 'report.html'}, report.json and junit.xml")
    found, left = (searched.found, searched.undecided or searched.broken) if searched else ((), False)
    if report.unexpected or found:
        raise typer.Exit(FAILED)
    raise typer.Exit(OPEN if report.open or left or report.reached is None else 0)


def _check_doors(module: str, command: str, results: Path | None, max_examples: int) -> None:
    if sum((bool(module), bool(command), results is not None)) != 1:
        raise typer.BadParameter("give one of --module, --command, --results", param_hint="conform")
    if results is not None and max_examples:
        asked = "needs a solver that can be asked: --module or --command"
        raise typer.BadParameter(asked, param_hint="--max-examples")


def _check_out(out: Path | None) -> None:
    if out is not None:
        with misuse("--out"):
            out.mkdir(parents=True, exist_ok=True)
        for name in WRITTEN:
            check_places(out=out / name)


def _profile(name: str) -> "Profile":
    from verification.conformance.profiles import PROFILES  # noqa: PLC0415

    if name not in PROFILES:
        raise typer.BadParameter(f"must be one of {', '.join(PROFILES)}", param_hint="--profile")
    return PROFILES[name]


def export(
    out: Annotated[Path, typer.Option(metavar="FILE", help="Write one request a line.", dir_okay=False)],
    profile: ProfileName = "float64",
    only: Filter = "",
) -> None:
    """Run the command ``conform export``."""
    from verification.conformance.suite import Selection, lines  # noqa: PLC0415 - keeps --help quick

    with misuse("--filter"):
        found = lines(Selection(_profile(profile), only))
    with misuse("--out"):
        write_atomic(out, "".join(f"{line}\n" for line in found).encode())
    say(f"wrote {len(found)} requests, one a line, to {out}")


def template(
    language: Annotated[str, typer.Argument(metavar="LANGUAGE", help="c or python.")],
) -> None:
    """Run the command ``conform template``."""
    from importlib.resources import files  # noqa: PLC0415 - keeps --help quick

    names = {"c": "solver.c", "python": "solver.py"}
    if language not in names:
        raise typer.BadParameter(f"must be one of {', '.join(names)}", param_hint="LANGUAGE")
    text = (files("verification.conformance") / "templates" / names[language]).read_text("utf-8")
    typer.echo(text, nl=False)


def found(
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Write conformance.md and conformance.json.", file_okay=False)
    ] = Path("reports"),
    python: Annotated[
        list[str] | None,
        typer.Option(metavar="PACKAGE=PYTHON", help="The Python of an environment that has a lasso package."),
    ] = None,
) -> None:
    """Run the command ``conform findings``."""
    from verification.conformance.findings import findings, markdown  # noqa: PLC0415 - keeps --help quick

    pythons = dict(each.partition("=")[::2] for each in python or [])
    if missing := [each for each in pythons.values() if shutil.which(each) is None]:
        raise typer.BadParameter(f"{missing[0]!r} is no program", param_hint="--python")
    with misuse("--out"), progress() as show:
        out.mkdir(parents=True, exist_ok=True)
        record = findings(pythons=pythons, progress=show)
        write_json(out / "conformance.json", record)
        write_atomic(out / "conformance.md", markdown(record).encode())
    say(f"wrote {out / 'conformance.md'} and conformance.json")


def made(
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Make them into this folder.", file_okay=False)
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Check the proof of every vector, and all that follows.")
    ] = False,
) -> None:
    """Run the command ``conform vectors``."""
    if check == (out is not None):
        raise typer.BadParameter("give one of --out and --check")
    if out is not None:
        from verification.conformance.making import make  # noqa: PLC0415 - keeps --help quick

        with misuse("--out"), progress() as show:
            out.mkdir(parents=True, exist_ok=True)
            make(out, lambda done, total: show("vectors", done, total))
        return
    from verification.conformance.checking import rejections, stored  # noqa: PLC0415 - keeps --help quick

    with misuse("--check"):
        texts = stored()
    with progress() as show:
        wrong = list(rejections(texts, lambda done, total: show("proofs", done, total)))
    for each in wrong:
        say(f"rejected: {each}")
    say(
        f"{len(wrong)} faults of the vectors"
        if wrong
        else "every proof holds, and all else follows from them"
    )
    raise typer.Exit(FAILED if wrong else 0)
