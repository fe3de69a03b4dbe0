"""What a run depends on: versions, for its settings, and the machine, for what may vary between two runs."""

import importlib
import platform
import subprocess
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

DECIDING = (
    "numpy",
    "scipy",
    "scikit-image",
    "clarabel",
    "cvxpy",
    "osqp",
    "hypothesis",
    "python-flint",
    "z3-solver",
    "numba",
)
"""Packages whose version may change an outcome."""
UNKNOWN = "unknown"
SECONDS = 10
"""Longest wait for git."""


def versions() -> dict[str, str]:
    """Versions that the outcome may depend on; "not installed" where a package is absent."""
    found = {"python": platform.python_version(), "convexperc": _version("convexperc")}
    return found | {name: _version(name) for name in DECIDING}


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
    top = (folder or Path(__file__).parent.parent).resolve()
    try:
        if Path(_git(top, "rev-parse", "--show-toplevel")).resolve() != top:
            return "not a checkout"
        changed = ", with changes" if _git(top, "status", "--porcelain") else ""
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


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _git(top: Path, *command: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(top), *command], capture_output=True, text=True, check=True, timeout=SECONDS
    )
    return done.stdout.strip()
