"""From what a user writes to a source."""

import glob
import os
import re
import stat
from collections.abc import Mapping
from pathlib import Path

from convexperc.errors import InputError, SourceError, check_type
from convexperc.features.folders import SUFFIXES
from convexperc.inputs.bags import Bag, Topic, is_bag
from convexperc.inputs.frames import Source, real
from convexperc.inputs.grammar import GRAMMAR, SCHEMES, VIDEOS
from convexperc.inputs.live import open_live
from convexperc.inputs.stored import PictureSequence, Still, Video, open_folder

LOWEST_RATE = 1e-6
"""Frames a second of pictures without times: one in 11 days."""
_PATTERN = "*?["
_DIGITS = 9
"""Of a camera's number at most, which OpenCV holds in 32 bits."""


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
        `rate` is not a finite number of at least `LOWEST_RATE`, or `timeout` not one > 0.
    """
    return open_sources({"": text}, rate=rate, timeout=timeout)[""]


def open_sources(texts: Mapping[str, str], *, rate: float = 30.0, timeout: float = 5.0) -> dict[str, Source]:
    """Open the sources of several robots, see `open_source`; topics of one bag are read in one pass.

    Raises
    ------
    SourceError, MissingExtraError, InputError
        See `open_source`. The sources that have been opened are closed.
    """
    for name, value, least in (("rate", rate, LOWEST_RATE), ("timeout", timeout, 0.0)):
        must = f"must be a finite number >= {least:g}" if least else "must be a finite number > 0"
        if not least <= real(value, name, must) or not value:
            raise InputError(name, value=value, must=must)
    check_type(texts, Mapping, "sources", SourceError)
    for text in texts.values():
        check_type(text, str, "source", SourceError)
    rate, timeout = float(rate), float(timeout)
    sources, bags = dict[str, Source](), dict[Path, Bag]()
    try:
        for robot, text in texts.items():
            sources[robot] = _open(text, rate, timeout, bags)
    except BaseException:
        for source in sources.values():
            source.close()
        raise
    return sources


def read_places(text: str) -> tuple[Path, ...]:
    """Return the files and folders that a source is read from: none of a camera, a stream, or what is none.

    Parameters
    ----------
    text : str
        See `open_source`; nothing is opened.
    """
    if _is_stream(text) or _camera(text):
        return ()
    if _there(text):
        return (Path(text),)
    place, _ = _topic(text)
    if place:
        return (Path(place),) if _there(place) else ()
    return tuple(_matches(text)) if _is_pattern(text) else ()


def _open(text: str, rate: float, timeout: float, bags: dict[Path, Bag]) -> Source:
    number = _camera(text)
    place, topic = _topic(text)
    if _is_stream(text):
        return open_live(text, f"stream {_without_password(text)}", text, timeout)
    if number:
        return _open_camera(text, number, timeout)
    if _there(text):
        return _open_path(text, Path(text), rate)
    if place:
        return _open_topic(text, Path(place), topic, bags)
    if _is_pattern(text):
        return _open_pattern(text, rate)
    raise _unknown(text)


def _is_stream(text: str) -> bool:
    scheme, separator, _ = text.partition("://")
    return bool(separator) and scheme.lower() in SCHEMES


def _without_password(address: str) -> str:
    """An address as it may be printed, and written beside the results."""
    return re.sub(r"(://[^/?#@]*?):[^/?#]*@", r"\1:***@", address)


def _camera(text: str) -> str:
    """The digits of a camera's number; empty if it is none."""
    number = text.removeprefix("camera:")
    return number if number.isascii() and number.isdigit() else ""


def _topic(text: str) -> tuple[str, str]:
    """The place of a bag, and the topic in it; an empty place if there is none."""
    place, _, topic = text.rpartition("#/")
    return place, f"/{topic}"


def _is_pattern(text: str) -> bool:
    return any(sign in text for sign in _PATTERN)


def _matches(text: str) -> list[Path]:
    return [Path(name) for name in glob.glob(text, recursive=True)]  # noqa: PTH207 - also absolute


def _open_camera(text: str, number: str, timeout: float) -> Source:
    """Open a camera; a file or folder of the same name may be what was meant."""
    if len(number) <= _DIGITS:
        try:
            return open_live(text, f"camera {number}", int(number), timeout)
        except SourceError as error:
            if not _there(text):
                raise
            what, value, must = error.what, error.value, error.must
    else:
        what, value, must = "camera", text, f"must be a number of at most {_DIGITS} digits"
    remedy = f"A file or folder of that name is ./{text}." if _there(text) else "Check the number."
    raise SourceError(what, value=value, must=must, remedy=remedy)


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
    found = _matches(text)
    pictures = [path for path in found if path.suffix.lower() in SUFFIXES and not path.is_dir()]
    if not pictures:
        must = f"must match a picture ({', '.join(sorted(SUFFIXES))})"
        raise SourceError(f"pattern {text}", value=f"{len(found)} other files and folders", must=must)
    omitted = tuple(sorted(os.fspath(path) for path in set(found) - set(pictures)))
    return PictureSequence(text, f"pattern {text}", pictures, rate, omitted)
