"""From what a user writes to a source."""

import glob
import math
import os
import stat
from collections.abc import Mapping
from pathlib import Path

from convexperc.errors import InputError, SourceError
from convexperc.features.folders import SUFFIXES
from convexperc.inputs.bags import Bag, Topic, is_bag
from convexperc.inputs.frames import Source
from convexperc.inputs.grammar import GRAMMAR, SCHEMES, VIDEOS
from convexperc.inputs.live import open_live
from convexperc.inputs.stored import PictureSequence, Still, Video, open_folder

_PATTERN = "*?["


def open_source(text: str, *, rate: float = 30.0, timeout: float = 5.0) -> Source:
    """Open what a robot's pictures come from; `GRAMMAR` lists the forms.

    A file or folder that exists is taken for itself, whatever its name holds; ``./0`` is one of the name 0.

    Parameters
    ----------
    text : str
        For example ``"run.mcap#/husky1/camera/image/compressed"``.
    rate : float
        Frames a second of pictures whose names are no times, and of videos without time stamps.
    timeout : float
        Seconds after which a camera or stream without a picture counts as stopped.

    Raises
    ------
    SourceError
        It is nothing of these, or cannot be opened.
    MissingExtraError
        It is a bag, and `rosbags` (extra `ros`) is not installed.
    InputError
        `rate` or `timeout` is not a finite number > 0.
    """
    return open_sources({"": text}, rate=rate, timeout=timeout)[""]


def open_sources(texts: Mapping[str, str], *, rate: float = 30.0, timeout: float = 5.0) -> dict[str, Source]:
    """Open the sources of several robots, see `open_source`; topics of one bag are read in one pass.

    Raises
    ------
    SourceError, MissingExtraError, InputError
        See `open_source`. The sources that have been opened are closed.
    """
    for name, value in (("rate", rate), ("timeout", timeout)):
        if not 0 < value < math.inf:
            raise InputError(name, value=value, must="must be a finite number > 0")
    sources, bags = dict[str, Source](), dict[Path, Bag]()
    try:
        for robot, text in texts.items():
            sources[robot] = _open(text, rate, timeout, bags)
    except BaseException:
        for source in sources.values():
            source.close()
        raise
    return sources


def _open(text: str, rate: float, timeout: float, bags: dict[Path, Bag]) -> Source:
    scheme, separator, _ = text.partition("://")
    if separator and scheme.lower() in SCHEMES:
        return open_live(text, f"stream {text}", text, timeout)
    number = text.removeprefix("camera:")
    if number.isascii() and number.isdigit():
        return open_live(text, f"camera {number}", int(number), timeout)
    if _there(text):
        return _open_path(text, Path(text), rate)
    place, hash_sign, topic = text.rpartition("#/")
    if hash_sign and place:
        return _open_topic(text, Path(place), f"/{topic}", bags)
    if any(sign in text for sign in _PATTERN):
        return _open_pattern(text, rate)
    raise _unknown(text)


def _there(text: str) -> bool:
    try:
        return bool(text) and os.path.lexists(text)
    except (OSError, ValueError):
        return False


def _unknown(text: str) -> SourceError:
    forms = ", ".join(form for form, _ in GRAMMAR)
    must = f"must be a file or folder that exists, or another of the forms {forms}"
    return SourceError("source", value=text, must=must, remedy="Check the path.")


def _open_path(text: str, path: Path, rate: float) -> Source:
    kind = _kind(path)
    if is_bag(path):
        raise _needs_topic(path)
    if stat.S_ISDIR(kind):
        return open_folder(text, path, rate)
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return Still(text, path)
    if suffix in VIDEOS:
        return Video(text, path, rate)
    must = (
        f"must be a picture ({', '.join(sorted(SUFFIXES))}), a video ({', '.join(sorted(VIDEOS))}) or a bag"
    )
    raise SourceError(f"source {path}", value=suffix or "no suffix", must=must)


def _kind(path: Path) -> int:
    """What a path is, a file or a folder."""
    name, must = f"source {path}", "must be a file or folder that can be read"
    try:
        status = path.stat()
    except OSError as problem:
        value = "a link to nothing" if path.is_symlink() else problem.strerror
        raise SourceError(name, value=value, must=must) from None
    if not stat.S_ISREG(status.st_mode) and not stat.S_ISDIR(status.st_mode):
        raise SourceError(name, value="neither", must=must, remedy="Pipes and devices cannot be read.")
    if stat.S_ISREG(status.st_mode) and not status.st_size:
        raise SourceError(name, value="0 bytes", must="must not be empty")
    return status.st_mode


def _needs_topic(path: Path) -> SourceError:
    types = Bag(path).types
    topics = ", ".join(f"{topic} ({', '.join(sorted(each))})" for topic, each in types.items()) or "none"
    must = f"must be followed by a topic, {path}#/topic; its topics are {topics}"
    return SourceError("source", value=os.fspath(path), must=must)


def _open_topic(text: str, path: Path, topic: str, bags: dict[Path, Bag]) -> Source:
    _kind(path)
    if not is_bag(path):
        must = "must be a bag before #: FILE.mcap, FILE.db3, FILE.bag or a folder with metadata.yaml"
        raise SourceError("source", value=text, must=must)
    place = path.resolve()
    if place not in bags:
        bags[place] = Bag(path)
    return Topic(text, bags[place], topic)


def _open_pattern(text: str, rate: float) -> Source:
    found = [Path(name) for name in glob.glob(text, recursive=True)]  # noqa: PTH207 - also absolute
    pictures = [path for path in found if path.suffix.lower() in SUFFIXES and not path.is_dir()]
    if not pictures:
        must = f"must match a picture ({', '.join(sorted(SUFFIXES))})"
        raise SourceError(f"pattern {text}", value=f"{len(found)} other files and folders", must=must)
    omitted = tuple(sorted(os.fspath(path) for path in set(found) - set(pictures)))
    return PictureSequence(text, f"pattern {text}", pictures, rate, omitted)
