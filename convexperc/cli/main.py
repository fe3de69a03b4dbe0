"""The command line: options in, tables out, no mathematics.

NumPy, OpenCV, scikit-image, Matplotlib and CVXPY take seconds to load. The packages import them lazily, when
a command needs them, so that ``--help`` answers at once.
"""

from typing import Annotated

import typer

from convexperc import __version__
from convexperc.cli import recognize as recognize_command
from convexperc.cli import simulate as simulate_command
from convexperc.cli import solve as solve_command
from convexperc.cli.exits import CERTIFIED
from convexperc.cli.options import EPILOG
from convexperc.cli.program import Program

app = typer.Typer(
    name="convexperc",
    cls=Program,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    epilog=EPILOG,
)
app.add_typer(recognize_command.app)
app.add_typer(solve_command.app)
app.add_typer(simulate_command.app)


def _print_version(wanted: bool) -> bool:
    if wanted:
        typer.echo(f"convexperc {__version__}")
        raise typer.Exit(CERTIFIED)
    return wanted


CONVEXPERC_HELP = "Recognise an object from several robots' views, with a proof of how good the answer is."


@app.callback(help=CONVEXPERC_HELP)
def convexperc(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Run a command of ``convexperc``."""
