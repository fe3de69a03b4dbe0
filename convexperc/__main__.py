"""The console script ``convexperc``, also ``python -m convexperc``."""

import signal
import sys
import traceback
from typing import NoReturn

from convexperc.cli.exits import INTERRUPTED
from convexperc.cli.main import app

FAULT = 70
"""EX_SOFTWARE: an exception that nobody foresaw. Python's own 1 would read as "not certified"."""


def main() -> NoReturn:
    """Run the command line and exit with its code.

    0 proved, 1 not proved, 2 the input cannot be used (`convexperc.cli.main` says which is which), 70 a fault of
    the program, with its traceback, 130 interrupted. A reader that closes the pipe ends it by SIGPIPE.
    """
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except Exception:
        traceback.print_exc()
    sys.exit(FAULT)


if __name__ == "__main__":
    main()
