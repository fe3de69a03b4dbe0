"""Commands of one problem file: solve it, or certify an answer to it."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from convexperc import certificate, report, solution, solvers
from convexperc import problem as problems
from convexperc.cli.exits import exits
from convexperc.cli.options import BUDGET, EPILOG, Json, Seconds, check_outputs, write
from convexperc.cli.progress import working
from convexperc.files import json_bytes

app = typer.Typer()


class SolverName(StrEnum):
    """The solver; the certificate does not depend on it."""

    CONIC = "conic"
    NEWTON = "newton"
    QP = "qp"


Problem = Annotated[Path, typer.Argument(metavar="PROBLEM", help="Problem file (JSON).")]


def _solver(name: SolverName) -> "solvers.Solver":
    """Return the solver of that name, imported on demand."""
    if name is SolverName.NEWTON:
        return solvers.Newton()
    return solvers.Quadratic() if name is SolverName.QP else solvers.Conic()


SOLVE_HELP = """Solve a problem file and certify the answer."""


@app.command(help=SOLVE_HELP, epilog=EPILOG)
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
    """Run ``convexperc solve``."""
    with working("working"):
        check_outputs({"--json": json, "--proof": proof}, {"PROBLEM": problem})
        asked = problems.read_problem(problem)
        if solver is SolverName.QP and not solvers.is_quadratic(asked.problem):
            raise typer.BadParameter("qp needs lambda3 = 0 or one-column modalities; use --solver conic")
        answer = solution.solve(asked.problem, _solver(solver), escalate=escalate, seconds=seconds)
        content = {} if json is None else {json: _record(report.solution_record(answer), asked.id)}
        proved = None if proof is None else report.proof_record(answer, seconds=seconds)
        if proof is not None and proved is not None:
            content[proof] = json_bytes(proved)
    write(content)
    tables = report.tables
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


CERTIFY_HELP = """Certify an answer from any source; only its w and u are used."""


@app.command(help=CERTIFY_HELP, epilog=EPILOG)
@exits
def certify(
    problem: Problem,
    answer: Annotated[Path, typer.Argument(metavar="ANSWER", help="Answer file (JSON) with w and u.")],
    json: Json = None,
) -> bool:
    """Run ``convexperc certify``."""
    with working("working"):
        check_outputs({"--json": json}, {"PROBLEM": problem, "ANSWER": answer})
        asked = problems.read_problem(problem)
        point = problems.read_answer(answer, asked)
        found = certificate.certify(asked.problem, point.w, point.u)
        residual = problems.optimality_residual(asked.problem, point.w, point.u)
    if json is not None:
        write({json: _record(report.certificate_record(found, residual), asked.id)})
    tables = report.tables
    out = tables.console()
    out.print(tables.problem_line(asked.problem, asked.id))
    tables.show_blocks(out, asked.problem, point.w, point.u, found, residual)
    tables.show_terms(out, found)
    worst = f"largest residual {residual.worst:.3g}; not a proof: it is discontinuous where a weight is 0"
    tables.show_facts(out, "Certificate", [*tables.certificate_facts(found), ("KKT", worst)])
    return found.certified


def _record(record: dict[str, Any], name: str | None) -> bytes:
    """Return a record as JSON, with the id of its problem if that has one."""
    return json_bytes(record if name is None else {"id": name, **record})
