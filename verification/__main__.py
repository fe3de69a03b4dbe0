"""The command line of the verifier."""

import sys

import typer

from convexperc.errors import MissingExtraError, require
from verification.commands import campaign, claims, experiments, faults, replay, reports, solvers

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    help="Judge the paper's claims, the library, and other solvers.",
)
report = typer.Typer(add_completion=False, invoke_without_command=True, help=claims.report.__doc__)
report.callback()(claims.report)
report.command("diff")(claims.diff)

app.command("list")(claims.listed)
app.command()(claims.run)
app.add_typer(report, name="report")
app.command()(replay.replay)
app.command()(faults.faults)
app.command()(experiments.experiments)
app.command()(experiments.experiments_pages)
app.command()(reports.reports)
app.command()(solvers.families)
app.command()(campaign.campaign)
app.command()(solvers.check)
app.command()(solvers.bench)


MISUSE = 2
"""Exit code of misuse, typer's own."""

VERIFY = ("cvc5", "hypothesis", "jinja2", "joblib", "jsonschema", "matplotlib", "z3")
"""Modules that the extra `verify` brings; a command imports what it needs before it does anything."""


def main() -> None:
    """Entry point of the console script; a missing extra ends it with one line."""
    try:
        try:
            app()
        except ModuleNotFoundError as error:
            if error.name in VERIFY:
                require(error.name, "verify", "this command")
            raise
    except MissingExtraError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(MISUSE)


if __name__ == "__main__":
    main()
