"""The console script ``convexperc``, also ``python -m convexperc``."""

from convexperc.cli.main import app


def main() -> None:
    """Run the command line and exit with its code; see `convexperc.cli.exits`."""
    app()


if __name__ == "__main__":
    main()
