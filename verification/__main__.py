"""The command line of the verifier."""

import typer

from verification.commands import claims, experiments, replay, solvers

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
app.command()(claims.faults)
app.command()(experiments.experiments)
app.command()(solvers.families)
app.command()(solvers.campaign)
app.command()(solvers.check)
app.command()(solvers.bench)


def main() -> None:
    """Entry point of the console script."""
    app()


if __name__ == "__main__":
    main()
