"""The console script ``convexperc``, also ``python -m convexperc``."""

import signal
import sys
import traceback
from typing import NoReturn

from convexperc.cli.exits import INTERRUPTED
from convexperc.cli.main import app

FAULT = 70
"""EX_SOFTWARE of sysexits.h, for an unexpected exception: Python's 1 means "not certified" here."""


def main() -> NoReturn:
    """Run the command line and exit with its code.

    0 proved, 1 not proved, 2 the input cannot be used (see `convexperc.cli.main`), 70 an internal error, with
    its traceback, 130 interrupted. If the reader closes the pipe, SIGPIPE ends the process.
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
