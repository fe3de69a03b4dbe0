"""Sources and bags that are made by code: pictures of one colour, whose colour says which they are."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from convexperc.errors import ImageError, SourceError
from convexperc.inputs.frames import Frame, Silence, Source

ROBOTS = ("Alpha", "Bob", "Carol")
"""As in S3E, whose topics are `/Alpha/left_camera/compressed` and so on."""
START = 1_700_000_000 * 10**9
"""Nanoseconds since the epoch."""


def picture(number: int, size: tuple[int, int] = (12, 16)) -> np.ndarray:
    """A picture of one colour that only this number has."""
    return np.full((*size, 3), (number % 256, number // 256 % 256, 77), dtype=np.uint8)


def number_of(image: np.ndarray) -> int:
    """The number of a picture that was stored without loss."""
    red, green, blue = map(int, image[0, 0])
    assert blue == 77, image[0, 0]
    return red + 256 * green


class Listed(Source):
    """Frames by their times; one whose number is among the broken has no picture."""

    def __init__(
        self, events: Sequence[float | Silence], broken: Sequence[int] = (), fails: str = ""
    ) -> None:
        super().__init__("listed", "listed")
        self.list, self.broken, self.fails = events, frozenset(broken), fails
        self.read = 0
        self.closed = False

    def events(self) -> Iterator[Frame | Silence]:
        number = 0
        for event in self.list:
            if isinstance(event, Silence):
                yield event
                continue
            self.read += 1
            yield Frame(event, lambda n=number: self._picture(n))
            number += 1
        if self.fails:
            raise SourceError("listed", value=self.fails, must="must go on")

    def __iter__(self) -> Iterator[Frame]:
        return (event for event in self.events() if isinstance(event, Frame))

    def _picture(self, number: int) -> np.ndarray:
        if number in self.broken:
            raise ImageError(f"frame {number}", value="nothing", must="must be a picture")
        return picture(number)

    def close(self) -> None:
        self.closed = True


class Lone(Source):
    """A still."""

    still = True

    def __init__(self, number: int = 7) -> None:
        super().__init__("still", "still")
        self.number = number

    def __iter__(self) -> Iterator[Frame]:
        yield Frame(0.0, lambda: picture(self.number))


def jpeg(image: np.ndarray) -> bytes:
    return cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()


def png(image: np.ndarray) -> bytes:
    return cv2.imencode(".png", image[..., ::-1] if image.ndim == 3 else image)[1].tobytes()


class BagMaker:
    """Writes a bag with `rosbags`: ROS 1 for ``.bag``, otherwise ROS 2 in a folder."""

    def __init__(self, path: Path, storage: str = "mcap", compress: bool = False) -> None:
        from rosbags import rosbag1, rosbag2  # noqa: PLC0415 - an extra
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

        self.first = path.suffix == ".bag"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.first else Stores.ROS2_HUMBLE)
        self.types = self.store.types
        if self.first:
            self.writer = rosbag1.Writer(path)
            if compress:
                self.writer.set_compression(self.writer.CompressionFormat.LZ4)
        else:
            plugin = {"mcap": rosbag2.StoragePlugin.MCAP, "db3": rosbag2.StoragePlugin.SQLITE3}[storage]
            self.writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
            if compress:
                self.writer.set_compression(rosbag2.CompressionMode.MESSAGE, rosbag2.CompressionFormat.ZSTD)
        self.connections = {}

    def __enter__(self) -> "BagMaker":
        self.writer.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.writer.close()

    def header(self, stamp: int):
        parts = (self.types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9)), "camera")
        return self.types["std_msgs/msg/Header"](*((0, *parts) if self.first else parts))

    def put(self, topic: str, message, recorded: int) -> None:
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        write = self.store.serialize_ros1 if self.first else self.store.serialize_cdr
        self.writer.write(self.connections[topic], recorded, write(message, kind))

    def compressed(
        self,
        topic: str,
        stamp: int,
        data: bytes,
        *,
        stated: str = "rgb8; png compressed bgr8",
        recorded: int = 0,
    ) -> None:
        kind = self.types["sensor_msgs/msg/CompressedImage"]
        message = kind(self.header(stamp), stated, np.frombuffer(data, np.uint8))
        self.put(topic, message, recorded or stamp)

    def text(self, topic: str, recorded: int) -> None:
        self.put(topic, self.types["std_msgs/msg/String"]("hello"), recorded)


def topic_of(robot: str) -> str:
    return f"/{robot}/left_camera/compressed"


def three_robots(path: Path, storage: str = "mcap", count: int = 10) -> dict[str, list[int]]:
    """Three robots at 10, 10 and 5 Hz with jitter, an IMU-like topic beside; return the stamps of each."""
    rng = np.random.default_rng(0)
    events = []
    for k, robot in enumerate(ROBOTS):
        step = 2 if robot == "Carol" else 1
        for number in range(0, count, step):
            jitter = int(rng.integers(-10, 10)) * 10**6
            events.append((START + number * 10**8 + jitter, robot, 1000 * k + number))
    stamps = {robot: [] for robot in ROBOTS}
    with BagMaker(path, storage) as bag:
        for stamp, robot, number in sorted(events):
            bag.compressed(topic_of(robot), stamp, png(picture(number)), recorded=stamp + 5 * 10**6)
            bag.text("/Alpha/note", stamp + 5 * 10**6)
            stamps[robot].append(stamp)
    return stamps


def file_of(folder: Path) -> Path:
    """The one file of a ROS 2 bag's folder."""
    return next(path for path in folder.iterdir() if path.suffix != ".yaml")
