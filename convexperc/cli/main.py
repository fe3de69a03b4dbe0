"""The command line: options in, tables out, no mathematics.

NumPy, OpenCV, scikit-image, Matplotlib and CVXPY take seconds to load; `Later` puts them off until a command
needs them, so that ``--help`` answers at once.
"""

from enum import StrEnum
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from convexperc.cli import simulate as simulate_command
from convexperc.cli.exits import CERTIFIED, exits
from convexperc.cli.later import Later
from convexperc.cli.progress import progress
from convexperc.report import tables

if TYPE_CHECKING:
    from convexperc.certificate import certificate
    from convexperc.features import configuration as features
    from convexperc.problem import files as problem_files
    from convexperc.problem import optimality
    from convexperc.recognition import references as perception
    from convexperc.recognition.references import Named
    from convexperc.report import figure as picture
    from convexperc.report import proof as proof_file
    from convexperc.report import records
    from convexperc.solution import single as solving
    from convexperc.solvers import conic
    from convexperc.solvers import osqp as qp
    from convexperc.solvers.interface import Solver
    from convexperc.solvers.newton import method as newton
else:
    certificate, optimality, perception = (
        Later("certificate.certificate"),
        Later("problem.optimality"),
        Later("recognition.references"),
    )
    picture, problem_files, records = Later("report.figure"), Later("problem.files"), Later("report.records")
    solving, conic, qp = Later("solution.single"), Later("solvers.conic"), Later("solvers.osqp")
    newton, proof_file = Later("solvers.newton.method"), Later("report.proof")
    features = Later("features.configuration")

FIRST_RUN = "working; the first run of an installation compiles, half a minute"
EPILOG = (
    "Exit codes: 0 proved; 1 not proved (solve, certify: the answer is not certified; recognize: that of the"
    " label is not, or no label is proved because objects are undecided or tied); 2 the input cannot be"
    " used; 70 a fault of this program; 130 interrupted."
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
    """Which solver answers; the certificate judges either."""

    CONIC = "conic"
    NEWTON = "newton"
    QP = "qp"


class DecisionName(StrEnum):
    """What decides the label; see `convexperc.recognition.decision`."""

    OBJECTIVE = "objective"
    EXPLAINED_SHARE = "explained-share"


Json = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the full record as JSON.")]
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
        str | None, typer.Option(metavar="NAME", help="Scene of the sample; its first one without.")
    ] = None,
    lambda1: Annotated[float, typer.Option(help="Weight of the coupling of views and features.")] = 0.1,
    lambda2: Annotated[float, typer.Option(help="Weight of the selection of views.")] = 1.0,
    lambda3: Annotated[float, typer.Option(help="Weight of the selection of modalities.")] = 0.1,
    decide: Annotated[
        DecisionName,
        typer.Option(help="What decides: the lowest optimum, or the largest share of ||o||^2 explained."),
    ] = DecisionName.OBJECTIVE,
    json: Json = None,
    figure: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE", help="Draw the outcome: .png or .svg.")
    ] = None,
    configuration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Feature configuration (JSON), complete.")
    ] = None,
) -> bool:
    """Recognise the object that all views show.

    Exit code 0 means: the label's answer is certified,
    and its optimum is proved to lie below every other one.
    Whether the features tell the objects apart is not proved.
    """
    if sample == (references is not None or views is not None) or (scene is not None and not sample):
        raise typer.BadParameter("give --references and --views, or --sample (and --scene, if you like)")
    if (references is None) != (views is None):
        raise typer.BadParameter("--references and --views go together")
    with progress(FIRST_RUN, "solved") as (expect, step):
        kind = None if figure is None else picture.picture_kind(figure)
        for file in (json, figure):
            if file is not None:
                records.check_place(file)
        chosen = features.FeatureConfiguration()
        if configuration is not None:
            chosen = problem_files.read_configuration(configuration)
        heading, known, seen = _pictures(references, views, scene)
        prepared = perception.References.of(known, chosen)
        expect(len(known))
        recognition = perception.perceive(
            seen, prepared, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3, prune=False,
            decision=decide.value.replace("-", " "), progress=step,
        )  # fmt: skip
    if json is not None:
        _write(json, records.recognition_record(recognition, chosen))
    if figure is not None and kind is not None:
        records.write_whole(figure, picture.recognition_picture(recognition, seen, kind))
        typer.echo(f"wrote {figure}", err=True)
    out = tables.console()
    out.print(heading)
    tables.show_recognition(out, recognition)
    return recognition.certified and recognition.label is not None


def _solver(name: SolverName) -> "Solver":
    """The solver of that name, imported only now."""
    if name is SolverName.NEWTON:
        return newton.Newton()
    return qp.Quadratic() if name is SolverName.QP else conic.Conic()


@app.command(epilog=EPILOG)
@exits
def solve(
    problem: Problem,
    solver: Annotated[
        SolverName,
        typer.Option(help="newton, conic: any problem. qp: lambda3 = 0 or one-column modalities."),
    ] = SolverName.NEWTON,
    escalate: Annotated[
        bool, typer.Option(help="Use ball arithmetic where the solver's answer is not certified.")
    ] = True,
    json: Json = None,
    proof: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a proof that anybody can check (JSON).")
    ] = None,
) -> bool:
    """Solve a problem file and certify the answer."""
    with progress(FIRST_RUN, "solved"):
        for file in (json, proof):
            if file is not None:
                records.check_place(file)
        asked = problem_files.read_problem(problem)
        if solver is SolverName.QP and not qp.is_quadratic(asked.problem):
            raise typer.BadParameter("qp needs lambda3 = 0 or one-column modalities; use --solver conic")
        solution = solving.solve(asked.problem, _solver(solver), escalate=escalate)
        proved = None if proof is None else proof_file.proof_record(solution)
    if json is not None:
        _write(json, records.solution_record(solution), asked.id)
    if proof is not None and proved is not None:
        _write(proof, proved)
    out = tables.console()
    found = solution.certificate
    out.print(tables.problem_line(asked.problem, asked.id))
    tables.show_blocks(out, asked.problem, solution.w, solution.u, found)
    claim = "solver", tables.solver_claim(solution)
    tables.show_facts(out, "Certificate", [*tables.certificate_facts(found), claim])
    return found.certified


@app.command(epilog=EPILOG)
@exits
def certify(
    problem: Problem,
    answer: Annotated[Path, typer.Argument(metavar="ANSWER", help="Answer file (JSON) with w and u.")],
    json: Json = None,
) -> bool:
    """Judge an answer from anywhere; what it claims of itself is not looked at."""
    with progress(FIRST_RUN, "solved"):
        if json is not None:
            records.check_place(json)
        asked = problem_files.read_problem(problem)
        point = problem_files.read_answer(answer, asked)
        found = certificate.certify(asked.problem, point.w, point.u)
        residual = optimality.optimality_residual(asked.problem, point.w, point.u)
    if json is not None:
        _write(json, records.certificate_record(found, residual), asked.id)
    out = tables.console()
    out.print(tables.problem_line(asked.problem, asked.id))
    tables.show_blocks(out, asked.problem, point.w, point.u, found, residual)
    tables.show_terms(out, found)
    worst = f"largest residual {residual.worst:.3g}; no proof: it jumps where a weight is tiny but not 0"
    tables.show_facts(out, "Certificate", [*tables.certificate_facts(found), ("KKT", worst)])
    return found.certified


def _pictures(references: Path | None, views: Path | None, scene: str | None) -> "tuple[str, Named, Named]":
    """What to print first, the pictures of the known objects, and the views."""
    if references is not None and views is not None:
        known, seen = perception.read_pictures(references), perception.read_pictures(views)
        return f"{len(seen)} views in {views}, {len(known)} objects in {references}", known, seen
    names = perception.sample_names()
    shown = perception.sample_scene(names[0] if scene is None else scene)
    others = ", ".join(f"--scene {name}" for name in names if name != shown.name)
    heading = f"Sample: {len(shown.views)} robots look at {shown.name} (other scenes: {others})"
    return heading, shown.references, shown.views


def _write(path: Path, record: dict[str, Any], name: str | None = None) -> None:
    records.write_json(path, record if name is None else {"id": name, **record})
    typer.echo(f"wrote {path}", err=True)
