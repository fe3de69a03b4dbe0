"""The command line of the verifier."""

from typing import Any

import typer

from convexperc.cli.exits import FAILURES
from convexperc.cli.program import Program
from convexperc.errors import require
from verification.commands import (
    accuracy,
    campaign,
    claims,
    conformance,
    experiments,
    faults,
    kernels,
    lassos,
    replay,
    reports,
    reweighted,
    solvers,
)

VERIFY = (
    "cvc5",
    "hypothesis",
    "jinja2",
    "joblib",
    "jsonschema",
    "matplotlib",
    "pydantic_core",
    "sympy",
    "z3",
)
"""Modules that the extra `verify` brings; a command imports what it needs before it does anything."""


class Verifier(Program):
    """The commands of the verifier, which name the extra that one of them lacks."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command; see `Program`."""
        try:
            return super().invoke(ctx)
        except ModuleNotFoundError as error:
            if error.name in VERIFY:
                require(error.name, "verify", "this command")
            raise


app = typer.Typer(
    name="convexperc-verification",
    cls=Verifier,
    pretty_exceptions_enable=False,
    add_completion=False,
    no_args_is_help=True,
    help="Judge the paper's claims, the library, and other solvers.",
    epilog=f"Exit codes: 0, 1 and 3 as each command says; 2 misuse; {FAILURES}",
)
report = typer.Typer(add_completion=False, invoke_without_command=True, help=claims.REPORT_HELP)
report.callback()(claims.report)
report.command("diff", help=claims.DIFF_HELP)(claims.diff)

conform = typer.Typer(add_completion=False, invoke_without_command=True, help=conformance.CONFORM_HELP)
conform.callback()(conformance.conform)
conform.command("export", help=conformance.EXPORT_HELP)(conformance.export)
conform.command("template", help=conformance.TEMPLATE_HELP)(conformance.template)
conform.command("findings", help=conformance.FINDINGS_HELP)(conformance.found)
conform.command("vectors", help=conformance.VECTORS_HELP)(conformance.made)

app.command("list", help=claims.LISTED_HELP)(claims.listed)
app.command(help=claims.RUN_HELP)(claims.run)
app.add_typer(report, name="report")
app.add_typer(conform, name="conform")
app.command(help=replay.REPLAY_HELP)(replay.replay)
app.command(help=faults.FAULTS_HELP)(faults.faults)
app.command(help=experiments.EXPERIMENTS_HELP)(experiments.experiments)
app.command(help=experiments.EXPERIMENTS_PAGES_HELP)(experiments.experiments_pages)
app.command(help=accuracy.ACCURACY_HELP)(accuracy.accuracy)
app.command(help=reports.REPORTS_HELP)(reports.reports)
app.command(help=solvers.FAMILIES_HELP)(solvers.families)
app.command(help=campaign.CAMPAIGN_HELP)(campaign.campaign)
app.command(help=lassos.LASSOS_HELP)(lassos.lassos)
app.command(help=reweighted.LOOPS_HELP)(reweighted.loops)
app.command(help=reweighted.PACKAGES_HELP)(reweighted.packages)
app.command(help=kernels.KERNELS_HELP)(kernels.kernels)
app.command(help=solvers.CHECK_HELP)(solvers.check)
app.command(help=solvers.BENCH_HELP)(solvers.bench)


def main() -> None:
    """Run the command line and exit with its code; see `convexperc.cli.exits`."""
    app()


if __name__ == "__main__":
    main()
