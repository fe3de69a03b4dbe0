"""What was recognised, written to a ROS 2 bag (extra `ros`)."""

import json
import math
import os
import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from convexperc.errors import InputError, check_type, entries, is_integer, require
from convexperc.files import check_json, check_place, given_path
from convexperc.inputs.frames import real

CLASSIFICATION, HYPOTHESIS, TEXT = (
    "vision_msgs/msg/Classification",
    "vision_msgs/msg/ObjectHypothesis",
    "std_msgs/msg/String",
)
DEFINITIONS = {
    HYPOTHESIS: "string class_id\nfloat64 score\n",
    CLASSIFICATION: "std_msgs/Header header\nvision_msgs/ObjectHypothesis[] results\n",
}
"""The messages of vision_msgs 4 (ROS 2 Humble and later), by type."""
SCHEMA = "convexperc/intervals/1"
_STORAGES = {".mcap": "MCAP", ".db3": "SQLITE3"}
_LAST = 2**31 * 10**9
"""The first time, in nanoseconds, that a ROS 2 header does not hold."""


@dataclass(frozen=True)
class Hypothesis:
    """One object, and what is proved of its optimum.

    Attributes
    ----------
    object : str
        Its name.
    lower, upper : float
        lower <= F* <= upper, of the reference of the object that decides.
    unexplained : float
        F* / ||o||^2 <= unexplained, of that reference; >= 0.
    """

    object: str
    lower: float
    upper: float
    unexplained: float

    def __post_init__(self) -> None:
        numbers = self.lower, self.upper, self.unexplained
        check_type(self.object, str, "the object of a hypothesis")
        must = "must be a finite number, with finite lower <= upper, and unexplained >= 0"
        for name in ("lower", "upper", "unexplained"):
            real(getattr(self, name), f"hypothesis {self.object!r}: {name}", must)
        if self.lower > self.upper or self.unexplained < 0:
            must = "must have finite lower <= upper, and unexplained >= 0"
            raise InputError(f"hypothesis {self.object!r}", value=numbers, must=must)

    @property
    def score(self) -> float:
        """A proved lower bound of the explained fraction 1 - F*/||o||^2, within 0 and 1.

        It is no probability: the scores of the objects do not add up to 1, and a high one says that the views
        explain the object's features, not how surely it is that object.
        """
        return max(0.0, math.nextafter(1.0 - self.unexplained, -math.inf))


class ResultBag:
    """A new ROS 2 bag with a classification for each moment; a context manager, which writes all or nothing.

    * `topic`: `vision_msgs/msg/Classification`; `results` holds the hypotheses, `class_id` the object's name,
      `score` as `Hypothesis.score`, descending.
    * `details`: `std_msgs/msg/String`, a JSON object with the schema ``convexperc/intervals/1``:
      `nanoseconds` as in the header, `objects` with the proved interval of each optimum, and `details`.

    Parameters
    ----------
    path : path-like
        ``NAME.mcap`` or ``NAME.db3`` for one file, which replaces an earlier one; otherwise a new folder,
        with ``metadata.yaml`` and one MCAP file.
    topic, details : str
        Names of the topics.
    frame_id : str
        Of the headers.

    Raises
    ------
    MissingExtraError
        `rosbags` is not installed.
    InputError
        It cannot be written there, or the folder exists.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        topic: str = "/convexperc/classification",
        details: str = "/convexperc/intervals",
        frame_id: str = "",
    ) -> None:
        require("rosbags", "ros", "a bag of results")
        place = given_path(path, "output", InputError)
        for what, text in (("topic", topic), ("details", details), ("frame_id", frame_id)):
            check_type(text, str, what)
        self._single = place.suffix.lower() in _STORAGES
        if not self._single and os.path.lexists(place):
            raise _unwritable(place, "it exists", "Choose a new name.")
        self._place = check_place(place)
        self._topics, self._frame_id = (topic, details), frame_id
        self._parts: Path | None = None
        self._writer: Any = None
        self._last = -1

    def __enter__(self) -> "ResultBag":
        from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415 - an extra
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415

        store = get_typestore(Stores.ROS2_HUMBLE)
        for msgtype, definition in DEFINITIONS.items():
            store.register(get_types_from_msg(definition, msgtype))
        self._store: Any = store
        self._parts = self._place.with_name(f".{os.urandom(6).hex()}.part")
        plugin = StoragePlugin[_STORAGES.get(self._place.suffix.lower(), "MCAP")]
        name = self._place.stem if self._single else self._place.name
        try:
            self._writer = Writer(self._parts / name, version=8, storage_plugin=plugin)
            self._writer.open()
            self._connections = [
                self._writer.add_connection(topic, msgtype, typestore=store)
                for topic, msgtype in zip(self._topics, (CLASSIFICATION, TEXT), strict=True)
            ]
        except BaseException as problem:
            self._discard()
            raise self._failed(problem) from None
        return self

    def write(
        self, nanoseconds: int, hypotheses: Sequence[Hypothesis], details: Mapping[str, Any] | None = None
    ) -> None:
        """Write what was recognised at one moment.

        Parameters
        ----------
        nanoseconds : int
            Time of the moment, `Moment.nanoseconds`; of the header and of the recording.
        hypotheses : sequence of Hypothesis
            At most one for each object; none if no robot had a picture, or if no object is accepted.
        details : mapping, optional
            JSON values, for example the verdict and the robots that were left out.

        Raises
        ------
        InputError
            A time that a header does not hold, or an object twice; writing fails.
        """
        if not is_integer(nanoseconds) or not 0 <= nanoseconds < _LAST:
            must = f"must be an integer of at least 0 and less than {_LAST}"
            raise InputError("nanoseconds", value=nanoseconds, must=must)
        hypotheses = list(entries(hypotheses, "hypotheses"))
        for each in hypotheses:
            check_type(each, Hypothesis, "an entry of hypotheses")
        check_type(details, (Mapping, type(None)), "details")
        check_json(dict(details or {}), "details")
        names = [each.object for each in hypotheses]
        if len(set(names)) < len(names):
            raise InputError("hypotheses", value=names, must="must name each object once")
        store, types = self._store, self._store.types
        ordered = sorted(hypotheses, key=lambda each: -each.score)
        stamp = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
        header = types["std_msgs/msg/Header"](stamp, self._frame_id)
        results = [types[HYPOTHESIS](each.object, each.score) for each in ordered]
        text = json.dumps(
            {
                "schema": SCHEMA,
                "nanoseconds": nanoseconds,
                "objects": [
                    {
                        "class_id": each.object, "lower": each.lower, "upper": each.upper,
                        "unexplained": each.unexplained,
                    }
                    for each in ordered
                ],
                "details": dict(details or {}),
            },
            allow_nan=False,
        )  # fmt: skip
        messages = types[CLASSIFICATION](header, results), types[TEXT](text)
        for connection, message in zip(self._connections, messages, strict=True):
            data = store.serialize_cdr(message, connection.msgtype)
            try:
                self._writer.write(connection, nanoseconds, data)
            except Exception as problem:
                raise self._failed(problem) from None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self._discard()
            return
        try:
            self._writer.close()
            assert self._parts is not None
            if self._single:
                written = self._parts / self._place.stem / f"{self._place.stem}{self._place.suffix.lower()}"
                written.replace(self._place)
            else:
                (self._parts / self._place.name).rename(self._place)
        except BaseException as problem:
            raise self._failed(problem) from None
        finally:
            self._discard()

    def _discard(self) -> None:
        """Remove what was written and not moved to its place."""
        if self._writer is not None:
            with suppress(Exception):
                self._writer.abort()
        if self._parts is not None:
            shutil.rmtree(self._parts, ignore_errors=True)

    def _failed(self, problem: BaseException) -> BaseException:
        """An error of the disk or of `rosbags` as ours; anything else as it is."""
        if isinstance(problem, OSError) or type(problem).__module__.partition(".")[0] in (
            "rosbags",
            "sqlite3",
        ):
            return _unwritable(self._place, str(problem), "Choose another place.")
        return problem


def _unwritable(path: Path, found: str, remedy: str) -> InputError:
    return InputError(f"output {path}", value=found, must="must be a bag that can be written", remedy=remedy)
