"""The command line: options in, tables out, no mathematics.

NumPy, OpenCV, scikit-image, Matplotlib and CVXPY take seconds to load; `_Later` is the one place where they
are put off until a command needs them, so that ``--help`` answers at once.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from enum import StrEnum
from functools import wraps
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, ParamSpec

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from convexperc.errors import ConvexpercError, InputError, MissingExtraError

if TYPE_CHECKING:
    from convexperc import certificate, optimality, perception, picture, records
    from convexperc import solve as solving
    from convexperc.arrays import Vector
    from convexperc.certificate import Certificate
    from convexperc.features import configuration as features
    from convexperc.optimality import OptimalityResidual
    from convexperc.perception import Named
    from convexperc.problem import Problem as ProblemData
    from convexperc.recognition import Ranked, Recognition
    from convexperc.solution import Solution
    from convexperc.solvers import conic, qp
else:

    class _Later:
        """A module that is imported when something of it is first asked for."""

        def __init__(self, name):
            self._name = name

        def __getattr__(self, attribute):
            return getattr(import_module(f"convexperc.{self._name}"), attribute)

    certificate, optimality, perception = _Later("certificate"), _Later("optimality"), _Later("perception")
    picture, records, solving = _Later("picture"), _Later("records"), _Later("solve")
    features, conic, qp = _Later("features.configuration"), _Later("solvers.conic"), _Later("solvers.qp")

CERTIFIED, NOT_CERTIFIED, MISUSE, INTERRUPTED = 0, 1, 2, 130
MOST_ROWS = 30
EPILOG = (
    "Exit codes: 0 proved; 1 not proved (solve, certify: the answer is not certified; recognize: an answer is"
    " not certified, or no label is proved because objects are undecided or tied); 2 the input cannot be"
    " used; 70 a fault of this program; 130 interrupted."
)
Arguments = ParamSpec("Arguments")
app = typer.Typer(
    name="convexperc",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    epilog=EPILOG,
)


class SolverName(StrEnum):
    """Which solver answers; the certificate judges either."""

    CONIC = "conic"
    QP = "qp"


Json = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the full record as JSON.")]
Problem = Annotated[Path, typer.Argument(metavar="PROBLEM", help="Problem file (JSON).")]


def _exits(command: Callable[Arguments, bool]) -> Callable[Arguments, None]:
    """Turn a command that returns whether all is proved into one that exits with the code for it."""

    @wraps(command)
    def run(*args: Arguments.args, **options: Arguments.kwargs) -> None:
        try:
            code = CERTIFIED if command(*args, **options) else NOT_CERTIFIED
        except ConvexpercError as error:
            typer.echo(f"error: {error}", err=True)
            code = MISUSE if isinstance(error, (InputError, MissingExtraError)) else NOT_CERTIFIED
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            code = INTERRUPTED
        raise typer.Exit(code)

    return run


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
@_exits
def recognize(
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
    lambda2: Annotated[float, typer.Option(help="Weight of the selection of views.")] = 0.1,
    lambda3: Annotated[float, typer.Option(help="Weight of the selection of modalities.")] = 0.1,
    json: Json = None,
    figure: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE", help="Draw the outcome: .png or .svg.")
    ] = None,
    configuration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Feature configuration (JSON), complete.")
    ] = None,
) -> bool:
    """Recognise the object that all views show.

    Exit code 0 means: every object's answer is certified,
    and the label's optimum is proved to lie below every other one.
    Whether the features tell the objects apart is not proved.
    """
    if sample == (references is not None or views is not None) or (scene is not None and not sample):
        raise typer.BadParameter("give --references and --views, or --sample (and --scene, if you like)")
    if (references is None) != (views is None):
        raise typer.BadParameter("--references and --views go together")
    with _progress() as (expect, step):
        kind = None if figure is None else picture.picture_kind(figure)
        for file in (json, figure):
            if file is not None:
                records.check_place(file)
        chosen = features.FeatureConfiguration()
        if configuration is not None:
            chosen = records.read_configuration(configuration)
        heading, known, seen = _pictures(references, views, scene)
        prepared = perception.References.of(known, chosen)
        expect(len(known))
        recognition = perception.perceive(
            seen, prepared, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3, progress=step
        )
    if json is not None:
        _write(json, records.recognition_record(recognition, chosen))
    if figure is not None and kind is not None:
        records.write_whole(figure, picture.recognition_picture(recognition, seen, kind))
        typer.echo(f"wrote {figure}", err=True)
    out = _console()
    out.print(heading)
    _show_recognition(out, recognition)
    return recognition.certified and recognition.label is not None


@app.command(epilog=EPILOG)
@_exits
def solve(
    problem: Problem,
    solver: Annotated[
        SolverName, typer.Option(help="conic: any problem. qp: lambda3 = 0 or one-column modalities.")
    ] = SolverName.CONIC,
    json: Json = None,
) -> bool:
    """Solve a problem file and certify the answer."""
    with _progress():
        if json is not None:
            records.check_place(json)
        asked = records.read_problem(problem)
        if solver is SolverName.QP and not qp.is_quadratic(asked.problem):
            raise typer.BadParameter("qp needs lambda3 = 0 or one-column modalities; use --solver conic")
        solution = solving.solve(asked.problem, qp.Quadratic() if solver is SolverName.QP else conic.Conic())
    if json is not None:
        _write(json, records.solution_record(solution), asked.id)
    out = _console()
    found = solution.certificate
    out.print(_sizes(asked.problem, asked.id))
    _show_blocks(out, asked.problem, solution.w, solution.u, found)
    _show_facts(out, "Certificate", [*_facts(found), ("solver", _said(solution))])
    return found.certified


@app.command(epilog=EPILOG)
@_exits
def certify(
    problem: Problem,
    answer: Annotated[Path, typer.Argument(metavar="ANSWER", help="Answer file (JSON) with w and u.")],
    json: Json = None,
) -> bool:
    """Judge an answer from anywhere; what it claims of itself is not looked at."""
    with _progress():
        if json is not None:
            records.check_place(json)
        asked = records.read_problem(problem)
        point = records.read_answer(answer, asked)
        found = certificate.certify(asked.problem, point.w, point.u)
        residual = optimality.optimality_residual(asked.problem, point.w, point.u)
    if json is not None:
        _write(json, records.certificate_record(found, residual), asked.id)
    out = _console()
    out.print(_sizes(asked.problem, asked.id))
    _show_blocks(out, asked.problem, point.w, point.u, found, residual)
    _show_terms(out, found)
    worst = f"largest residual {residual.worst:.3g}; no proof: it jumps where a weight is tiny but not 0"
    _show_facts(out, "Certificate", [*_facts(found), ("KKT", worst)])
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


@contextmanager
def _progress() -> Iterator[tuple[Callable[[int], None], Callable[[str], None]]]:
    """A bar on stderr, on a terminal only; gives a function for the number of steps and one for each step."""
    console = Console(stderr=True)
    columns = TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("working", total=None)

        def expect(steps: int) -> None:
            bar.update(task, description="solving", total=steps)

        def step(name: str) -> None:
            bar.update(task, description=f"solved {name}", advance=1)

        yield expect, step


def _write(path: Path, record: dict[str, Any], name: str | None = None) -> None:
    records.write_json(path, record if name is None else {"id": name, **record})
    typer.echo(f"wrote {path}", err=True)


def _console() -> Console:
    """Names are printed as they are; a pipe is as wide as the tables need."""
    console = Console(markup=False, highlight=False, emoji=False, soft_wrap=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = 160
    return console


def _show_recognition(out: Console, recognition: "Recognition") -> None:
    best = recognition.template()
    out.print(_sizes(best.solution.problem, None))
    rows = []
    for template in sorted(recognition.templates, key=lambda entry: entry.interval[1]):
        found = template.solution.certificate
        verdict = "excluded"
        if template.name in recognition.candidates:
            verdict = "candidate" if recognition.label is None else "label"
        bounds = _below(found.lower), _above(found.upper), _above(found.gap, 3)
        rows.append((template.name, *bounds, "yes" if found.certified else "NO", verdict))
    columns = "object", ">F* at least", ">F* at most", ">gap", "certified", "verdict"
    _show_table(out, "Objects, lowest optimum first", columns, rows)
    _show_ranking(out, best.name, "robot", ">w", recognition.ranked_views())
    _show_ranking(out, best.name, "modality", ">||u^i||", recognition.ranked_modalities())
    count = sum(template.solution.certificate.certified for template in recognition.templates)
    facts = [
        ("label", recognition.label or f"none; candidates: {', '.join(recognition.candidates)}"),
        ("verdict", f"{recognition.verdict.value}: {recognition.reason}"),
        *_facts(best.solution.certificate),
        ("objects", f"{count} of {len(recognition.templates)} have a certified answer"),
        ("solver", _said(best.solution)),
        *(("warning", warning) for warning in recognition.warnings),
        ("scope", "proved for these features and lambdas, not that they tell the objects apart"),
    ]
    _show_facts(out, f"Certificate for {best.name}", facts)


def _show_ranking(out: Console, best: str, what: str, weight: str, ranking: "Iterable[Ranked]") -> None:
    rows = []
    for i, entry in enumerate(ranking, 1):
        zero = "yes" if entry.proved_zero else ""
        rows.append((str(i), entry.name, _weight(entry.weight), f"{100 * entry.share:.1f} %", zero))
    _show_table(out, f"Ranking by {what} for {best}", (">rank", what, weight, ">share", "proved zero"), rows)


def _sizes(problem: "ProblemData", name: str | None) -> str:
    """One line on a problem."""
    parts = zip(problem.modalities.names, problem.modalities.sizes, strict=True)
    sizes = ", ".join(f"{part} {size}" for part, size in parts)
    lambdas = ", ".join(f"lambda{i} = {value:g}" for i, value in enumerate(problem.lambdas, 1))
    head = "" if name is None else f"{name}: "
    return f"{head}n = {problem.n} views, d = {problem.d} features ({sizes}), {lambdas}"


def _show_blocks(
    out: Console,
    problem: "ProblemData",
    w: "Vector",
    u: "Vector",
    found: "Certificate",
    residual: "OptimalityResidual | None" = None,
) -> None:
    """Every view and modality: its weight, its KKT residual if there is one, whether it is proved zero."""
    views = [f"row {i}" for i in range(problem.n)], w, found.zero_views
    norms = problem.modalities.norms(u)
    modalities = problem.modalities.names, norms, found.zero_modalities
    errors = (None, None) if residual is None else (residual.views, residual.modalities)
    for title, weight, block, error in (
        ("view", ">w", views, errors[0]),
        ("modality", ">||u^i||", modalities, errors[1]),
    ):
        columns = [title, weight, *([] if error is None else [">KKT residual"]), "proved zero"]
        rows = []
        for i, (name, value, zero) in enumerate(zip(*block, strict=True)):
            measure = [] if error is None else [f"{error[i]:.3g}"]
            rows.append((name, _weight(value), *measure, "yes" if zero else ""))
        _show_table(out, "Views" if title == "view" else "Modalities", columns, rows)


def _show_terms(out: Console, found: "Certificate") -> None:
    if found.terms is None:
        return
    names = "loss", "coupling", "view_norm", "modality_norm"
    rows = [(name.replace("_", " "), _above(getattr(found.terms, name), 3)) for name in names]
    _show_table(out, "Gap by term, in units where ||o|| is about 1", ("term", ">at most"), rows)


def _facts(found: "Certificate") -> list[tuple[str, str]]:
    """What a certificate proves, in words."""
    word = "certified" if found.certified else "NOT CERTIFIED"
    relative, absolute = found.relative_tolerance, found.absolute_tolerance
    return [
        ("optimum", f"{_below(found.lower)} <= F* <= {_above(found.upper)}"),
        ("answer", f"{_below(found.objective[0])} <= F(w, u) <= {_above(found.objective[1])}"),
        ("gap", f"F(w, u) - F* <= {_above(found.gap, 3)}, that is {_above(found.relative_gap, 3)} of F*"),
        ("method", found.method),
        ("status", f"{word} (at most {relative:g} of F*, or {absolute:g} of ||o||^2)"),
    ]


def _said(solution: "Solution") -> str:
    return f"{solution.solver}; its own word, not relied on: {solution.claim}"


def _show_facts(out: Console, title: str, facts: Iterable[tuple[str, str]]) -> None:
    grid = Table.grid(padding=(0, 2))
    grid.add_column(no_wrap=True)
    grid.add_column(overflow="fold")
    for name, fact in facts:
        grid.add_row(f"  {name}", fact)
    out.print(Text(title, style="bold"))
    out.print(grid)


def _show_table(out: Console, title: str, columns: Sequence[str], rows: Sequence[tuple[str, ...]]) -> None:
    """Columns that start with ``>`` hold numbers; the first other one, of names, may fold."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    names = next(column for column in columns if not column.startswith(">"))
    for column in columns:
        side: Literal["left", "right"] = "right" if column.startswith(">") else "left"
        table.add_column(column.removeprefix(">"), justify=side, no_wrap=column != names, overflow="fold")
    for row in rows[:MOST_ROWS]:
        table.add_row(*row)
    out.print(Text(title, style="bold"))
    out.print(table)
    if len(rows) > MOST_ROWS:
        out.print(f"... and {len(rows) - MOST_ROWS} more; --json has them all")
    out.print()


def _weight(value: float) -> str:
    return f"{value:.6f}" if value == 0.0 or 1e-6 <= abs(value) < 1e6 else f"{value:.3g}"


def _below(value: float, digits: int = 12) -> str:
    """A bound from below, rounded down."""
    return f"{Context(prec=digits, rounding=ROUND_FLOOR).create_decimal_from_float(value):g}"


def _above(value: float, digits: int = 12) -> str:
    """A bound from above, rounded up."""
    return f"{Context(prec=digits, rounding=ROUND_CEILING).create_decimal_from_float(value):g}"
