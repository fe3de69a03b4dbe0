"""What an outcome depends on beside the data: source files and the versions of packages."""

from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from verification.environment import versions

TOP = Path(__file__).parents[2]
PICTURES = "opencv-python-headless"
SIMULATION = Path("convexperc/simulation")
"""Left out: it makes pictures, whose own digest counts."""


@cache
def of_features() -> str:
    """SHA-256 of all that describes pictures."""
    files = [TOP / "convexperc/features/pictures.py", *(TOP / "convexperc/features").glob("*.py")]
    return _digest([*files, Path(__file__).with_name("features.py")])


@cache
def of_everything() -> str:
    """SHA-256 of the library and of the experiments."""
    library = (TOP / "convexperc").rglob("*.py")
    kept = [file for file in library if not file.relative_to(TOP).is_relative_to(SIMULATION)]
    return _digest([*kept, *Path(__file__).parent.glob("*.py")])


def _digest(files: Iterable[Path]) -> str:
    sha = sha256(repr(sorted((versions() | {PICTURES: version(PICTURES)}).items())).encode())
    for file in sorted(files):
        sha.update(file.relative_to(TOP).as_posix().encode() + b"\0" + file.read_bytes())
    return sha.hexdigest()
