"""What an outcome depends on: versions, commit, machine, source files; and digests of files and of data."""

import ast
import hashlib
import importlib
import json
import platform
import subprocess
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

DECIDING = (
    "numpy",
    "scipy",
    "scikit-image",
    "opencv-python-headless",
    "pillow",
    "simplejpeg",
    "clarabel",
    "cvxpy",
    "osqp",
    "hypothesis",
    "python-flint",
    "z3-solver",
    "numba",
)
"""Packages whose version may change an outcome."""
PROVING = ("cvc5",)
"""Packages that proofs alone are checked by: a report depends on them, and nothing else does."""
TOP = Path(__file__).resolve().parents[1]
"""The folder that holds both packages."""
PACKAGES = ("convexperc", "verification")
SOLVING = tuple(
    f"convexperc/{name}"
    for name in (
        "problem",
        "solvers",
        "certificate",
        "enclosure",
        "solution",
        "caching.py",
        "errors.py",
        "faces.py",
        "files.py",
        "kernels",
    )
)
RECOGNIZING = (*SOLVING, "convexperc/features", "convexperc/recognition")
REFEREE = tuple(
    f"verification/exact/{name}.py"
    for name in (
        "__init__",
        "balls",
        "central_path",
        "formulation",
        "numbers",
        "problem",
        "reduced",
        "referee",
    )
)
"""Of the folder of exact arithmetic, what the referee of optima imports: it runs no loop."""
JUDGING = tuple(
    f"verification/{name}" for name in ("exact", "problems", "checks", "search", "ledger", "journal.py")
)
SUBJECTS: dict[str, tuple[str, ...]] = {
    "campaign": (
        *SOLVING,
        *REFEREE,
        *(f"verification/{name}" for name in ("problems", "journal.py")),
        *(f"verification/checks/{name}.py" for name in ("clarabel", "interface", "measures")),
        *(f"verification/ledger/{name}.py" for name in ("evidence", "surveys")),
        *(f"verification/search/{name}.py" for name in ("campaign", "certify", "tallies", "tasks")),
    ),
    "accuracy": (
        *RECOGNIZING,
        *(f"verification/{name}" for name in ("accuracy", "experiments/scenes", "experiments/design.py")),
        "verification/experiments/record/bootstrap.py",
        "verification/ledger",
    ),
    "lassos": (
        *SOLVING,
        "convexperc/lasso",
        *(f"verification/{name}" for name in ("lassos", "exact", "problems", "journal.py")),
        *(f"verification/{name}.py" for name in ("checks/measures", "search/tasks")),
    ),
    "kernels": (
        *(f"convexperc/{name}" for name in ("problem", "caching.py", "errors.py", "faces.py", "files.py")),
        *(f"verification/reweighted/{name}" for name in ("terms", "answers.py")),
        *(f"verification/{name}" for name in ("exact", "ledger", "problems", "journal.py")),
        "verification/proofs/checkers",
        *(f"verification/{name}.py" for name in ("checks/measures", "search/tasks")),
    ),
    "benchmark": (*RECOGNIZING, "verification/bench"),
    "faults": (*RECOGNIZING, *JUDGING, "verification/faults"),
    "report": (
        *RECOGNIZING,
        *JUDGING,
        *(f"verification/{name}" for name in ("counterexamples", "proofs", "run")),
    ),
}
"""The code on which each kind of generated file depends for what it says, though not for how its pages look:
when it changes, the file is to be made anew."""
CODE = (".py", ".toml", ".json", ".j2", ".css")
"""What counts as code; Python by its syntax, without comments and docstrings."""
GENERATED = "reports"
"""Folder of the files that are made one after the other from one commit: they are no change of it."""
UNKNOWN = "unknown"
SECONDS = 10
"""Longest wait for git."""


def canonical(data: Any) -> bytes:
    """One text for equal data: JSON with sorted keys, without blanks, in ASCII.

    Raises
    ------
    ValueError
        A number is not finite.
    """
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def digest(data: Any) -> str:
    """SHA-256 of the canonical text."""
    return hashlib.sha256(canonical(data)).hexdigest()


def record_digest(record: Mapping[str, Any]) -> str:
    """SHA-256 of a record without its own digest and without what may differ between two runs of one seed."""
    return digest({key: value for key, value in record.items() if key not in ("digest", "volatile")})


def stamp(subject: str) -> dict[str, Any]:
    """What made a generated file, to be written into it.

    Parameters
    ----------
    subject : str
        A key of `SUBJECTS`.

    Returns
    -------
    dict
        ``commit``, ``versions``, and ``code``: the digest of the code that the file speaks of.
    """
    return {"commit": commit(), "versions": versions(), "code": code_digest(*SUBJECTS[subject])}


def is_current(data: Mapping[str, Any], subject: str) -> bool:
    """Whether the stamp of a generated file, as plain data, is of the present code.

    Parameters
    ----------
    data : mapping
        The whole file; its stamp stands under ``made``, or under ``made`` of its ``volatile`` part.
    subject : str
        A key of `SUBJECTS`.
    """
    made = data.get("made") or data.get("volatile", {}).get("made") or {}
    return bool(made.get("code") == code_digest(*SUBJECTS[subject]))


def code_digest(*places: str, without: str = "") -> str:
    """SHA-256 of code that does not change with documentation: comments, docstrings and layout.

    Parameters
    ----------
    places : str
        Files and folders, relative to the folder that holds both packages; default: both packages.
    without : str
        A folder to leave out.
    """
    found = dict(file for place in places or PACKAGES for file in _files(place, _place(place)))
    chosen = sorted(name for name in found if not without or not name.startswith(f"{without}/"))
    return digest({name: _code(found[name]) for name in chosen})


def _place(name: str) -> Traversable:
    """A file or folder, also where the packages are in an archive."""
    package, *parts = name.split("/")
    return TOP.joinpath(name) if TOP.is_dir() else files(package).joinpath(*parts)


def _files(name: str, place: Traversable) -> Iterator[tuple[str, Traversable]]:
    """The files of code in a folder, or the file itself, by their names."""
    if place.is_dir():
        for each in place.iterdir():
            yield from _files(f"{name}/{each.name}", each)
    elif name.endswith(CODE):
        yield name, place


def _code(file: Traversable) -> str:
    if not file.name.endswith(".py"):
        return hashlib.sha256(file.read_bytes()).hexdigest()
    return digest(_syntax(ast.parse(file.read_bytes())))


def _syntax(node: Any) -> Any:
    """A syntax tree as plain data that is the same in every version of Python; empty fields are left out."""
    if isinstance(node, list):
        return [_syntax(each) for each in node if not _is_docstring(each)]
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = ((name, value) for name, value in ast.iter_fields(node) if value not in (None, []))
    return [
        type(node).__name__,
        {name: _syntax(value) for name, value in fields if name not in ("ctx", "kind")},
    ]


def _is_docstring(node: Any) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def versions() -> dict[str, str]:
    """Versions that the outcome may depend on; "not installed" where a package is absent."""
    found = {"python": platform.python_version(), "convexperc": installed("convexperc")}
    return found | {name: installed(name) for name in DECIDING}


def machine() -> dict[str, Any]:
    """The date, the commit, the processor, and which BLAS kernel NumPy uses here."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": commit(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": processor(),
        "blas": blas(),
        "blas kernel": blas_kernel(),
    }


def commit(folder: Path | None = None) -> str:
    """The commit of the project, marked where files differ from it; "not a checkout" if it is none.

    Parameters
    ----------
    folder : Path or None
        Top folder of the project; None for the one that this file is in.
    """
    top = (folder or TOP).resolve()
    try:
        if Path(_git(top, "rev-parse", "--show-toplevel")).resolve() != top:
            return "not a checkout"
        changed = ", with changes" if _git(top, "status", "--porcelain", "--", ".", f":!{GENERATED}") else ""
        return _git(top, "rev-parse", "HEAD") + changed
    except subprocess.CalledProcessError:
        return "not a checkout"
    except (OSError, subprocess.TimeoutExpired):
        return f"{UNKNOWN}: git cannot be run"


def processor(listing: Path = Path("/proc/cpuinfo")) -> str:
    """Name of the processor, as far as the system tells."""
    try:
        lines = listing.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    for line in lines:
        name, _, value = line.partition(":")
        if name.strip() == "model name":
            return value.strip()
    return platform.processor() or UNKNOWN


def blas() -> str:
    """Name and version of the BLAS that NumPy was built with."""
    config: Any = np.show_config(mode="dicts")
    library = config.get("Build Dependencies", {}).get("blas", {})
    return f"{library.get('name', UNKNOWN)} {library.get('version', '')}".strip()


def blas_kernel() -> str:
    """The kernels that were chosen for this processor; threadpoolctl (extra `bench`) can tell."""
    try:
        threadpoolctl = importlib.import_module("threadpoolctl")
    except ModuleNotFoundError:
        return f"{UNKNOWN}: threadpoolctl is not installed"
    pools = threadpoolctl.threadpool_info()
    names = {f"{pool['internal_api']} {pool['architecture']}" for pool in pools if "architecture" in pool}
    return ", ".join(sorted(names)) or UNKNOWN


def installed(name: str) -> str:
    """The version of a package, or "not installed"."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _git(top: Path, *command: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(top), *command], capture_output=True, text=True, check=True, timeout=SECONDS
    )
    return done.stdout.strip()
