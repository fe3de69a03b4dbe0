"""Makes the sample again: ``python -m convexperc.simulation OUTPUT_DIR``."""

from pathlib import Path
from typing import Annotated

import typer

from convexperc.errors import ConvexpercError
from convexperc.simulation.sample import write_sample


def main(
    output_dir: Annotated[Path, typer.Argument(help="Directory for the pictures and sample.json.")],
) -> None:
    """Draw a reference and five robots' views of each of three objects, and record how."""
    try:
        files = write_sample(output_dir)
    except ConvexpercError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(1) from None
    for file in files:
        typer.echo(f"{file.stat().st_size:8d} bytes  {file}")


if __name__ == "__main__":
    typer.run(main)
