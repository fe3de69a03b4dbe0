"""Programs in interpreters of their own, forked from one that has imported the dependencies once."""

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parent.parent

LOOP = """
import gc, json, os, sys
import clarabel, cv2, cvxpy, flint, osqp, scipy, typer
gc.freeze()

for line in sys.stdin:
    program, sys.argv[1:], streams = json.loads(line)
    child = os.fork()
    if child == 0:
        for number, (path, flags) in enumerate(zip(streams, (os.O_RDONLY, os.O_WRONLY, os.O_WRONLY))):
            os.dup2(os.open(path, flags | os.O_CREAT), number)
        break
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
else:
    sys.exit()
exec(program)
"""
"""Reads programs; each runs in a fork, which has none of this project's modules, until it ends by itself.

Frozen objects are not visited by the garbage collector, so that the forks share them.
"""


class Interpreter:
    """Runs programs as ``python -c`` does, none of which sees what another imported or changed.

    Parameters
    ----------
    head : str
        What runs before the dependencies are imported, and so before every program.
    arguments : str
        The arguments of the head.
    """

    def __init__(self, head: str = "", *arguments: str) -> None:
        plain = os.environ | {"COLUMNS": "140", "NO_COLOR": "1", "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-c", head + LOOP, *arguments]
        self._parent = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=plain
        )

    def run(
        self, program: str, *arguments: object, folder: Path | None = None
    ) -> subprocess.CompletedProcess[str]:
        """What the program returns and prints in this folder."""
        assert self._parent.stdin is not None
        assert self._parent.stdout is not None
        with TemporaryDirectory() as place:
            out, err = (f"{place}/{name}" for name in ("out", "err"))
            where = f"import os\nos.chdir({str(folder or ROOT)!r})\n"
            asked = where + program, [str(each) for each in arguments], [os.devnull, out, err]
            print(json.dumps(asked), file=self._parent.stdin, flush=True)
            code = int(self._parent.stdout.readline())
            return subprocess.CompletedProcess(
                program, code, *(Path(path).read_text("utf-8") for path in (out, err))
            )

    def close(self) -> None:
        """End the parent, which ends with its input."""
        self._parent.communicate()
        assert self._parent.returncode == 0, self._parent.returncode
