"""What a folder of pictures holds: pictures, sub-folders, and what is left out, with the reason."""

import os
import stat
from dataclasses import dataclass
from pathlib import Path

from convexperc.errors import ImageError
from convexperc.files import given_path

SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".jpe", ".jfif", ".bmp", ".tif", ".tiff", ".webp"})
"""Suffixes, in lower case, of the files that are read as pictures."""
OTHER_PICTURES = frozenset(
    {
        ".apng", ".arw", ".avif", ".cr2", ".cr3", ".dng", ".exr", ".gif", ".hdr", ".heic", ".heif", ".ico",
        ".j2k", ".jp2", ".jxl", ".jxr", ".nef", ".pbm", ".pcx", ".pfm", ".pgm", ".pnm", ".ppm", ".psd",
        ".raw", ".rw2", ".svg", ".tga", ".xcf",
    }
)  # fmt: skip
"""Suffixes of pictures in forms that are not read."""


@dataclass(frozen=True)
class Folder:
    """The entries of one folder, each kind sorted by name (code points); hidden ones do not count.

    Attributes
    ----------
    path : pathlib.Path
    pictures : tuple of pathlib.Path
        Files with one of `SUFFIXES`, in any case.
    folders : tuple of pathlib.Path
        Sub-folders.
    others : tuple of (str, str)
        The name of each other entry, and why it is left out.
    """

    path: Path
    pictures: tuple[Path, ...]
    folders: tuple[Path, ...]
    others: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, folder: str | os.PathLike[str]) -> "Folder":
        """Look at a folder.

        Raises
        ------
        ImageError
            It is not a readable directory.
        """
        place = given_path(folder, "folder", ImageError)
        try:
            entries = sorted(place.iterdir(), key=lambda entry: entry.name)
        except (OSError, ValueError) as problem:
            name, must = f"folder {os.fspath(folder)}", "must be a readable folder"
            raise ImageError(name, value=str(problem), must=must) from None
        pictures, folders, others = list[Path](), list[Path](), list[tuple[str, str]]()
        for entry in entries:
            if entry.name.startswith("."):
                continue
            reason = _why_not_a_picture(entry)
            if not reason:
                pictures.append(entry)
            elif reason == FOLDER:
                folders.append(entry)
            else:
                others.append((entry.name, reason))
        return cls(place, tuple(pictures), tuple(folders), tuple(others))


FOLDER = "a folder"


def _why_not_a_picture(entry: Path) -> str:
    """Why an entry is not read as a picture; empty for one, and for what is named like one but unreadable."""
    try:
        mode = entry.stat().st_mode
    except OSError as problem:
        if not _reason(entry.suffix.lower()):
            return ""  # reading it will fail, and say why
        missing = isinstance(problem, FileNotFoundError)
        return "a link to nothing" if missing else problem.strerror or "not readable"
    if not stat.S_ISREG(mode):
        return FOLDER if stat.S_ISDIR(mode) else "not a file"
    return _reason(entry.suffix.lower())


def _reason(suffix: str) -> str:
    """Why a file of this suffix is not read as a picture; empty if it is."""
    if suffix in SUFFIXES:
        return ""
    if suffix in OTHER_PICTURES:
        return f"{suffix.removeprefix('.').upper()} is not read; convert it to PNG"
    return "no picture by its name"
