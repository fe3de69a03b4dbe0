"""The command line: options in, tables out, no mathematics.

NumPy, OpenCV, scikit-image, Matplotlib and CVXPY take seconds to load. The packages import them lazily, when
a command needs them, so that ``--help`` answers at once.
"""

from enum import StrEnum
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import typer

from convexperc import certificate, features, recognition, report, solution, solvers
from convexperc import problem as problems
from convexperc.cli import simulate as simulate_command
from convexperc.cli.exits import CERTIFIED, exits
from convexperc.cli.progress import working
from convexperc.files import check_place, write_atomic, write_json
from convexperc.report import tables

FIRST_RUN = "working; the first run of an installation compiles, half a minute"
# Shown below the help of every command.
EPILOG = (
    "Exit codes: 0 proved; 1 not proved (solve, certify: the answer is not certified; recognize: the answer"
    " for the label is not certified, or no label is proved because objects are undecided or tied); 2 the"
    " input cannot be used; 70 an internal error; 130 interrupted."
)
app = typer.Typer(
    name="convexperc",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    epilog=EPILOG,
)
app.add_typer(simulate_command.app)


class SolverName(StrEnum):
    """The solver; the certificate does not depend on it."""

    CONIC = "conic"
    NEWTON = "newton"
    QP = "qp"


class DecisionName(StrEnum):
    """What decides the label; see `convexperc.recognition.decision`."""

    OBJECTIVE = "objective"
    EXPLAINED_FRACTION = "explained-fraction"
    EXPLAINED_SHARE = "explained-share"
    """The former name of the explained fraction."""


Json = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the full record as JSON.")]
Seconds = Annotated[
    float, typer.Option(metavar="S", help="Budget in seconds for ball arithmetic and exact numbers; or inf.")
]
BUDGET = 60.0
"""`convexperc.enclosure.budget.SECONDS`, which is not loaded for ``--help``."""
Problem = Annotated[Path, typer.Argument(metavar="PROBLEM", help="Problem file (JSON).")]


def _print_version(wanted: bool) -> bool:
    if wanted:
        typer.echo(f"convexperc {version('convexperc')}")
        raise typer.Exit(CERTIFIED)
    return wanted


@app.callback()
def convexperc(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Recognise an object from several robots' views, with a proof of how good the answer is."""


@app.command(epilog=EPILOG)
@exits
def recognize(  # noqa: PLR0913, PLR0917 - the options of a command
    references: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder with one picture of each object, named by its label."),
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
    seconds: Seconds = BUDGET,
) -> bool:
    """Recognise the object that all views show.

    Exit code 0 means that the answer for the label is certified
    and its optimum is proved to lie below every other one.
    Whether the features distinguish the objects is not proved.
    """
    if sample == (references is not None or views is not None) or (scene is not None and not sample):
        raise typer.BadParameter("give --references and --views, or --sample (and optionally --scene)")
    if (references is None) != (views is None):
        raise typer.BadParameter("--references and --views go together")
    with working(FIRST_RUN):
        kind = None if figure is None else report.picture_kind(figure)
        for file in (json, figure):
            if file is not None:
                check_place(file)
        chosen = features.FeatureConfiguration()
        if configuration is not None:
            chosen = features.read_configuration(configuration)
        heading, known, seen = _pictures(references, views, scene)
        prepared = recognition.References.of(known, chosen)
        found = recognition.perceive(
            seen, prepared, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3, prune=False,
            decision=decide.value.replace("-", " "), seconds=seconds,
        )  # fmt: skip
    if json is not None:
        _write(json, report.recognition_record(found, chosen))
    if figure is not None and kind is not None:
        write_atomic(figure, report.recognition_picture(found, seen, kind))
        typer.echo(f"wrote {figure}", err=True)
    out = tables.console()
    out.print(heading)
    tables.show_recognition(out, found)
    return found.certified and found.label is not None


def _solver(name: SolverName) -> "solvers.Solver":
    """Return the solver of that name, imported on demand."""
    if name is SolverName.NEWTON:
        return solvers.Newton()
    return solvers.Quadratic() if name is SolverName.QP else solvers.Conic()


@app.command(epilog=EPILOG)
@exits
def solve(
    problem: Problem,
    solver: Annotated[
        SolverName,
        typer.Option(help="newton, conic: any problem. qp: lambda3 = 0 or one-column modalities."),
    ] = SolverName.NEWTON,
    escalate: Annotated[
        bool, typer.Option(help="Use ball arithmetic if the solver's answer is not certified.")
    ] = True,
    json: Json = None,
    proof: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write a proof of the bounds of F* (JSON), which can be checked without this program.",
        ),
    ] = None,
    seconds: Seconds = BUDGET,
) -> bool:
    """Solve a problem file and certify the answer."""
    with working(FIRST_RUN):
        for file in (json, proof):
            if file is not None:
                check_place(file)
        asked = problems.read_problem(problem)
        if solver is SolverName.QP and not solvers.is_quadratic(asked.problem):
            raise typer.BadParameter("qp needs lambda3 = 0 or one-column modalities; use --solver conic")
        answer = solution.solve(asked.problem, _solver(solver), escalate=escalate, seconds=seconds)
        proved = None if proof is None else report.proof_record(answer, seconds=seconds)
    if json is not None:
        _write(json, report.solution_record(answer), asked.id)
    if proof is not None and proved is not None:
        _write(proof, proved)
    out = tables.console()
    found = answer.certificate
    out.print(tables.problem_line(asked.problem, asked.id))
    tables.show_blocks(out, asked.problem, answer.w, answer.u, found)
    status = "solver", tables.solver_status(answer)
    facts = [*tables.certificate_facts(found), status]
    if proved is not None:
        facts.append(("proof file", tables.claim(proved)))
    tables.show_facts(out, "Certificate", facts)
    return found.certified


@app.command(epilog=EPILOG)
@exits
def certify(
    problem: Problem,
    answer: Annotated[Path, typer.Argument(metavar="ANSWER", help="Answer file (JSON) with w and u.")],
    json: Json = None,
) -> bool:
    """Certify an answer from any source; only its w and u are used."""
    with working(FIRST_RUN):
        if json is not None:
            check_place(json)
        asked = problems.read_problem(problem)
        point = problems.read_answer(answer, asked)
        found = certificate.certify(asked.problem, point.w, point.u)
        residual = problems.optimality_residual(asked.problem, point.w, point.u)
    if json is not None:
        _write(json, report.certificate_record(found, residual), asked.id)
    out = tables.console()
    out.print(tables.problem_line(asked.problem, asked.id))
    tables.show_blocks(out, asked.problem, point.w, point.u, found, residual)
    tables.show_terms(out, found)
    worst = f"largest residual {residual.worst:.3g}; not a proof: it is discontinuous where a weight is 0"
    tables.show_facts(out, "Certificate", [*tables.certificate_facts(found), ("KKT", worst)])
    return found.certified


def _pictures(
    references: Path | None, views: Path | None, scene: str | None
) -> "tuple[str, recognition.NamedPictures, recognition.NamedPictures]":
    """Return the heading, the pictures of the known objects, and the views."""
    if references is not None and views is not None:
        known, seen = recognition.read_pictures(references), recognition.read_pictures(views)
        return f"{len(seen)} views in {views}, {len(known)} objects in {references}", known, seen
    names = recognition.sample_names()
    shown = recognition.sample_scene(names[0] if scene is None else scene)
    others = ", ".join(f"--scene {name}" for name in names if name != shown.name)
    heading = f"Sample: {len(shown.views)} robots look at {shown.name} (other scenes: {others})"
    return heading, shown.references, shown.views


def _write(path: Path, record: dict[str, Any], name: str | None = None) -> None:
    write_json(path, record if name is None else {"id": name, **record})
    typer.echo(f"wrote {path}", err=True)
