"""Pictures in ROS 1 and ROS 2 bags, read by `rosbags` (extra `ros`)."""

from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from convexperc.errors import ConvexpercError, SourceError, require
from convexperc.features.pictures import Picture
from convexperc.inputs.frames import Frame, Silence, Source
from convexperc.inputs.messages import COMPRESSED, IMAGE, READERS, Stamp

SUFFIXES = frozenset({".bag", ".db3", ".mcap"})
"""Suffixes, in lower case, of files that are bags; a folder is one if it holds ``metadata.yaml``."""
HELD_BYTES = 2**28
"""Bytes of encoded messages above which no more is read for a topic that is silent: 256 MiB."""
_LIMIT = 2
"""How many times as many may wait, before the clocks are too far apart."""


def is_bag(path: Path) -> bool:
    """Whether a path is that of a bag, by its name or content."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix.lower() in SUFFIXES


class Bag:
    """One recording; its topics are read together, in one pass, in the order in which they were recorded.

    Raises
    ------
    MissingExtraError
        `rosbags` is not installed.
    SourceError
        It is not a bag, or is truncated or damaged.
    """

    def __init__(self, path: Path) -> None:
        require("rosbags", "ros", f"bag {path}")
        self.path, self.name = path, f"bag {path}"
        self._pass: Pass | None = None
        with self._reader() as reader:
            self.types: Mapping[str, frozenset[str]] = _types(reader.connections)
            self.stated = dict[str, int]()
            for each in reader.connections:
                self.stated[each.topic] = self.stated.get(each.topic, 0) + each.msgcount

    def _reader(self) -> "Reading":
        return Reading(self.path, self.name)

    def check(self, topic: str) -> None:
        """Raise unless the bag has a topic with pictures.

        Raises
        ------
        SourceError
            It has none of that name, or one of another type.
        """
        pictures = [name for name, types in self.types.items() if types <= READERS.keys()]
        known = f"those with pictures are {', '.join(pictures)}" if pictures else "none has pictures"
        if topic not in self.types:
            others = len(self.types) - len(pictures)
            must = f"must be in {self.name}; {known}" + (f", {others} others have none" if others else "")
            raise SourceError("topic", value=topic, must=must, remedy="Name one of them after #.")
        if topic not in pictures:
            found, must = ", ".join(sorted(self.types[topic])), f"must be of {IMAGE} or {COMPRESSED}; {known}"
            raise SourceError(f"topic {topic} of {self.name}", value=found, must=must)

    def join(self, topic: str) -> "Pass":
        """Return the pass over the bag that has not begun yet, with this topic in it."""
        if self._pass is None or self._pass.begun or topic in self._pass.waiting:
            self._pass = Pass(self._reader())
        self._pass.waiting[topic] = deque()
        return self._pass


def _types(connections: Any) -> dict[str, frozenset[str]]:
    found = dict[str, set[str]]()
    for each in connections:
        found.setdefault(each.topic, set()).add(each.msgtype)
    return {topic: frozenset(types) for topic, types in sorted(found.items())}


@dataclass(frozen=True)
class Message:
    """One message as recorded.

    Attributes
    ----------
    recorded : int
        Nanoseconds.
    data : bytes
    parse : callable
        Makes a message of the bytes.
    msgtype : str
    """

    recorded: int
    data: bytes
    msgtype: str
    parse: Callable[[bytes, str], Any]


class Reading:
    """An open bag, as a context manager; whatever goes wrong is a `SourceError`."""

    def __init__(self, path: Path, name: str) -> None:
        from rosbags import rosbag1, rosbag2  # noqa: PLC0415 - an extra
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

        self.name = name
        first = path.suffix.lower() == ".bag" and not path.is_dir()
        if path.suffix != path.suffix.lower() and not first and not path.is_dir():
            must = (
                f"must end in {path.suffix.lower()}, in lower case, which says how a bag of ROS 2 is stored"
            )
            raise SourceError(name, value=path.suffix, must=must, remedy="Rename it, or link to it.")
        # Types of pictures have been the same in every version; those in a bag may be of any others.
        store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
        self.parse: Callable[[bytes, str], Any] = store.deserialize_ros1 if first else store.deserialize_cdr
        self._reader: Any = self._safely(lambda: (rosbag1 if first else rosbag2).Reader(path))
        self._open = False

    def _safely(self, what: Callable[[], Any]) -> Any:
        """Call; damaged bags raise many types: ReaderError, struct.error, sqlite's own, OSError ..."""
        try:
            return what()
        except ConvexpercError:
            raise
        except Exception as problem:  # MemoryError, too: a damaged length asks for any size
            must = "must be a complete and undamaged ROS 1 or ROS 2 bag"
            remedy = "If the recording broke off: `mcap recover`, `ros2 bag reindex` or `rosbag reindex`."
            value = str(problem) or type(problem).__name__
            raise SourceError(self.name, value=value, must=must, remedy=remedy) from None

    def __enter__(self) -> "Reading":
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def open(self) -> None:
        """Open it and read its index."""
        self._safely(self._reader.open)
        self._open = True

    def close(self) -> None:
        """Close it; more than once does no harm."""
        if self._open:
            self._open = False
            self._reader.close()

    @property
    def connections(self) -> Any:
        """What was recorded: topics and types."""
        return self._reader.connections

    def messages(self, topics: Any) -> Iterator[tuple[str, Message]]:
        """Read the messages of topics, in the order in which they were recorded."""
        connections = [each for each in self.connections if each.topic in topics]
        parts = iter(self._reader.messages(connections=connections))
        while True:
            part = self._safely(lambda: next(parts, None))
            if part is None:
                return
            connection, recorded, data = part
            yield connection.topic, Message(recorded, bytes(data), connection.msgtype, self.parse)


class Pass:
    """One pass over a bag, shared by topics that are read at the same time.

    Attributes
    ----------
    begun : bool
        Whether a message has been read; no topic can join any more.
    waiting : dict of str to deque of Message
        By topic, what was read and is to be asked for.
    """

    def __init__(self, reading: Reading) -> None:
        self.begun = False
        self.waiting = dict[str, deque[Message]]()
        self._reading = reading
        self._held = 0
        self._recorded = 0
        self._messages: Iterator[tuple[str, Message]] = iter(())
        self._failure: SourceError | None = None

    def next(self, topic: str) -> Message | int | None:
        """Return the next message of a topic; None at the end; how far, in ns, it is read where it is silent.

        Raises
        ------
        SourceError
            The bag breaks off, or more waits than may: see `HELD_BYTES`.
        """
        waiting = self.waiting[topic]
        while not waiting:
            over = self._held > HELD_BYTES
            if not self._read():
                return None
            if over and not waiting:
                return self._recorded
        message = waiting.popleft()
        self._held -= len(message.data)
        return message

    def _read(self) -> bool:
        """Read one message; false at the end."""
        if not self.begun:
            self.begun = True
            self._reading.open()
            self._messages = self._reading.messages(frozenset(self.waiting))
        if self._failure is not None:
            raise self._failure
        if self._held > _LIMIT * HELD_BYTES:
            must = f"must not be so far apart that {_LIMIT * HELD_BYTES} bytes lie between them"
            remedy = "Set right the clock of one robot, or read its topic from a bag of its own."
            raise SourceError(
                f"{self._reading.name}: time stamps of the topics",
                value=f"{self._held} bytes",
                must=must,
                remedy=remedy,
            )
        try:
            found = next(self._messages, None)
        except SourceError as error:
            self._failure = error
            self._reading.close()
            raise
        if found is None:
            self._reading.close()
            return False
        topic, message = found
        self._recorded = message.recorded
        if topic in self.waiting:
            self.waiting[topic].append(message)
            self._held += len(message.data)
        return True

    def leave(self, topic: str) -> None:
        """Read no more of a topic; after the last one the bag is closed."""
        left = self.waiting.pop(topic, ())
        self._held -= sum(len(message.data) for message in left)
        if not self.waiting:
            self._reading.close()


class Topic(Source):
    """The pictures of one topic of a bag.

    The time of a frame is that of its header, or that of the recording where the header has none above 0.
    """

    def __init__(self, text: str, bag: Bag, topic: str) -> None:
        bag.check(topic)
        super().__init__(text, f"topic {topic} of {bag.name}")
        self.bag, self.topic = bag, topic
        self._open = list[tuple[Pass, Generator[Frame | Silence]]]()
        self._frames = self._unstamped = 0
        self._uncertain = False

    @property
    def remarks(self) -> tuple[str, ...]:
        """How many frames have the time of the recording, and whether the channels are named."""
        said = list[str]()
        if self._unstamped:
            said.append(
                f"{self._unstamped} of {self._frames} frames have no time stamp above 0: "
                "their time is that of the recording"
            )
        if self._uncertain:
            said.append("encoding 8UC3 does not name its channels: they are taken for B, G, R")
        return tuple(said)

    def __iter__(self) -> Iterator[Frame]:
        return (event for event in self.events() if isinstance(event, Frame))

    def events(self) -> Iterator[Frame | Silence]:
        """Read the frames; see `Source.events`. Topics that are asked before any is read share one pass."""
        shared = self.bag.join(self.topic)
        events = self._read(shared)
        self._open.append((shared, events))
        return events

    def _read(self, shared: "Pass") -> Generator[Frame | Silence]:
        self._frames = self._unstamped = 0
        lag = 0
        try:
            while True:
                found = shared.next(self.topic)
                if found is None:
                    break
                if isinstance(found, int):
                    yield Silence((found - lag) / 10**9)
                    continue
                frame, lag = self._frame(found)
                yield frame
        finally:
            shared.leave(self.topic)
        stated = self.bag.stated[self.topic]
        if self._frames < stated:
            must = f"must hold the {stated} messages that its index states"
            raise SourceError(self.name, value=f"{self._frames} messages", must=must, remedy="It is damaged.")

    def _frame(self, found: Message) -> tuple[Frame, int]:
        """A message's frame, and by how many nanoseconds it was recorded after its time."""
        self._frames += 1
        name = f"{self.name}, message {self._frames}"
        try:
            message = found.parse(found.data, found.msgtype)
            stamp = Stamp.of(message).nanoseconds
        except Exception as problem:  # bytes that are no such message raise many types
            error = SourceError(name, value=str(problem), must=f"must be a {found.msgtype}")
            self._unstamped += 1
            return Frame(found.recorded / 10**9, _raiser(error), found.recorded), 0
        if stamp <= 0:  # none was set, or ROS would refuse it
            self._unstamped += 1
            stamp = found.recorded
        self._uncertain |= getattr(message, "encoding", "") == "8UC3"
        read = READERS[found.msgtype]
        return Frame(stamp / 10**9, lambda: read(message, name), stamp), found.recorded - stamp

    def close(self) -> None:
        """End the passes over the bag."""
        for shared, events in self._open:
            events.close()
            shared.leave(self.topic)  # also where nothing has been read
        self._open.clear()


def _raiser(error: SourceError) -> Callable[[], Picture]:
    def fail() -> Picture:
        raise error

    return fail
