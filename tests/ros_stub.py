"""A stand-in for what the documents use of ROS 2: no other names, arguments and fields than it has.

Held beside rclpy (after Jazzy), common_interfaces and vision_msgs 4.1.1: an argument by another name or in
another place, a field that a message has not, and a value of another type fail here as they do there.
"""

import array
import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any, ClassVar


class Duration:
    """Nanoseconds, which may be negative."""

    def __init__(self, *, seconds: float = 0, nanoseconds: int = 0) -> None:
        self._nanoseconds = int(seconds * 10**9) + nanoseconds

    @property
    def nanoseconds(self) -> int:
        return self._nanoseconds


class Time:
    """A time of one clock: times of two clocks are not compared."""

    def __init__(self, *, seconds: float = 0, nanoseconds: int = 0, clock_type: str = "SYSTEM_TIME") -> None:
        self._nanoseconds, self._clock_type = int(seconds * 10**9) + nanoseconds, clock_type

    @property
    def nanoseconds(self) -> int:
        return self._nanoseconds

    @classmethod
    def from_msg(cls, msg: "Stamp", clock_type: str = "ROS_TIME") -> "Time":
        if not isinstance(msg, Stamp):
            raise TypeError(msg)
        return cls(nanoseconds=msg.sec * 10**9 + msg.nanosec, clock_type=clock_type)

    def to_msg(self) -> "Stamp":
        seconds, rest = divmod(self._nanoseconds, 10**9)
        return Stamp(sec=seconds, nanosec=rest)

    def __sub__(self, other: "Time | Duration") -> "Time | Duration":
        if isinstance(other, Time):
            if other._clock_type != self._clock_type:
                raise TypeError("two clocks")
            return Duration(nanoseconds=self._nanoseconds - other._nanoseconds)
        return Time(nanoseconds=self._nanoseconds - other.nanoseconds, clock_type=self._clock_type)


Fields = dict[str, Callable[[], Any]]
"""Each field's name, and what makes its default."""


class Message:
    """Fields of fixed types, by keyword, as rosidl makes them."""

    __slots__ = ()
    FIELDS: ClassVar[Fields] = {}

    def __init__(self, **fields: Any) -> None:
        unknown = fields.keys() - self.FIELDS.keys()
        assert not unknown, f"invalid arguments: {unknown}"
        for name, make in self.FIELDS.items():
            setattr(self, name, fields.get(name, make()))

    def __setattr__(self, name: str, value: Any) -> None:
        assert name in self.FIELDS, f"{type(self).__name__} has no field {name}"
        kind = type(self.FIELDS[name]())
        assert isinstance(value, kind), f"{name} must be {kind.__name__}, not {type(value).__name__}"
        object.__setattr__(self, name, value)


def _bytes() -> array.array:
    return array.array("B")


class Stamp(Message):
    __slots__ = ("nanosec", "sec")
    FIELDS: ClassVar[Fields] = {"sec": int, "nanosec": int}


class Header(Message):
    __slots__ = ("frame_id", "stamp")
    FIELDS: ClassVar[Fields] = {"stamp": Stamp, "frame_id": str}


class CompressedImage(Message):
    __slots__ = ("data", "format", "header")
    FIELDS: ClassVar[Fields] = {"header": Header, "format": str, "data": _bytes}


class Image(Message):
    __slots__ = ("data", "encoding", "header", "height", "is_bigendian", "step", "width")
    FIELDS: ClassVar[Fields] = {
        "header": Header, "height": int, "width": int, "encoding": str, "is_bigendian": int, "step": int,
        "data": _bytes,
    }  # fmt: skip


class ObjectHypothesis(Message):
    __slots__ = ("class_id", "score")
    FIELDS: ClassVar[Fields] = {"class_id": str, "score": float}


class Classification(Message):
    __slots__ = ("header", "results")
    FIELDS: ClassVar[Fields] = {"header": Header, "results": list}


class World:
    """What the node is given, and what it does."""

    def __init__(self) -> None:
        self.now = 0
        self.initialised = False
        self.nodes: list[Node] = []
        self.callbacks: dict[str, tuple[type[Message], Callable[[Any], None]]] = {}
        self.timers: list[tuple[float, Callable[[], None]]] = []
        self.published: list[tuple[str, Message]] = []
        self.logged: list[tuple[str, str]] = []
        self.during_spin: Callable[[], None] = lambda: None

    def deliver(self, topic: str, message: Message) -> None:
        """Give a message to who has subscribed."""
        kind, callback = self.callbacks[topic]
        assert isinstance(message, kind), (topic, message)
        callback(message)

    def tick(self) -> None:
        """Let every timer ring once."""
        for _, callback in self.timers:
            callback()


WORLD = World()
"""The one of the test that runs; see `installed`."""


class Publisher:
    def __init__(self, kind: type[Message], topic: str) -> None:
        self._kind, self._topic = kind, topic

    def publish(self, msg: Message) -> None:
        if not isinstance(msg, self._kind):
            raise TypeError(msg)
        for each in getattr(msg, "results", ()):
            assert isinstance(each, ObjectHypothesis), each
        WORLD.published.append((self._topic, msg))


class Logger:
    def info(self, message: str) -> bool:
        WORLD.logged.append(("info", message))
        return True

    def warning(self, message: str) -> bool:
        WORLD.logged.append(("warning", message))
        return True


class Clock:
    def now(self) -> Time:
        return Time(nanoseconds=WORLD.now, clock_type="ROS_TIME")


QOS = object()


class Node:
    """Its arguments have the names and places of rclpy's; it has no attribute of theirs that is not here."""

    def __init__(self, node_name: str) -> None:
        assert WORLD.initialised, "rclpy.init() comes first"
        assert node_name.isidentifier(), node_name
        WORLD.nodes.append(self)

    def create_publisher(self, msg_type: type[Message], topic: str, qos_profile: object) -> Publisher:
        assert qos_profile is QOS or isinstance(qos_profile, int)
        return Publisher(msg_type, topic)

    def create_subscription(
        self, msg_type: type[Message], topic: str, callback: Callable[[Any], None], qos_profile: object
    ) -> None:
        assert qos_profile is QOS or isinstance(qos_profile, int)
        inspect.signature(callback).bind(object())
        assert topic not in WORLD.callbacks, topic
        WORLD.callbacks[topic] = msg_type, callback

    def create_timer(self, timer_period_sec: float, callback: Callable[[], None]) -> None:
        WORLD.timers.append((timer_period_sec, callback))

    def get_logger(self) -> Logger:
        return Logger()

    def get_clock(self) -> Clock:
        return Clock()


def init(*, args: list[str] | None = None) -> None:
    del args
    WORLD.initialised = True


def spin(node: Node, executor: object = None) -> None:
    assert executor is None
    assert node in WORLD.nodes
    WORLD.during_spin()


@contextmanager
def installed() -> Iterator[World]:
    """Let the modules be imported that the documents use; yield what drives them."""
    global WORLD
    names: dict[str, dict[str, Any]] = {
        "rclpy": {"init": init, "spin": spin},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"qos_profile_sensor_data": QOS},
        "rclpy.time": {"Time": Time},
        "rclpy.duration": {"Duration": Duration},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"CompressedImage": CompressedImage, "Image": Image},
        "vision_msgs": {},
        "vision_msgs.msg": {"Classification": Classification, "ObjectHypothesis": ObjectHypothesis},
    }
    before, WORLD = {name: sys.modules.get(name) for name in names}, World()
    for name, content in names.items():
        module = ModuleType(name)
        vars(module).update(content)
        sys.modules[name] = module
        parent, _, own = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], own, module)
    try:
        yield WORLD
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
