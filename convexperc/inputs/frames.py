"""A picture with its time, and what gives one after the other."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import TracebackType

import numpy as np

from convexperc.errors import InputError, check_type
from convexperc.features.pictures import Picture


def real(
    value: object, what: str, must: str = "must be a finite number", error: type[InputError] = InputError
) -> float:
    """Return a real number of Python or of NumPy as a float.

    Raises
    ------
    InputError
        Of the class given: anything else, NaN, infinity, or an integer beyond float64.
    """
    try:
        if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool):
            found = float(value)
            if math.isfinite(found):
                return found
    except OverflowError:
        pass
    raise error(what, value=value, must=must)


class Frame:
    """A picture of one robot with its time; decoded when it is first asked for.

    Parameters
    ----------
    time : float
        Seconds, on the clock of the source.
    decode : callable
        Returns the picture, or raises an `InputError` that says why there is none.
    nanoseconds : int, optional
        The time, where it is known exactly: float64 holds present seconds since the epoch to 0.24 us.

    Raises
    ------
    InputError
        A time that is no finite number, nanoseconds that are no integer, or `decode` cannot be called.
    """

    def __init__(self, time: float, decode: Callable[[], Picture], nanoseconds: int | None = None) -> None:
        self.time = real(time, "time")
        if not callable(decode):
            raise InputError("decode", value=decode, must="must be a function without arguments")
        if nanoseconds is None:
            nanoseconds = round(real(self.time * 10**9, "time in nanoseconds"))
        check_type(nanoseconds, int, "nanoseconds")
        self.nanoseconds = nanoseconds
        self._decode: Callable[[], Picture] | None = decode
        self._outcome: Picture | InputError | None = None

    @property
    def picture(self) -> Picture | None:
        """The picture as 8-bit RGB, read-only; None if it cannot be read."""
        found = self.decoded()
        return None if isinstance(found, InputError) else found

    @property
    def error(self) -> InputError | None:
        """What is wrong with the picture; None if there is one."""
        found = self.decoded()
        return found if isinstance(found, InputError) else None

    @property
    def reason(self) -> str:
        """Why there is no picture; empty if there is one."""
        return "" if self.error is None else str(self.error)

    def decoded(self) -> Picture | InputError:
        """Decode the picture, unless that has been done; not by two threads at a time."""
        if self._outcome is None:
            assert self._decode is not None
            try:
                self._outcome = self._decode()
            except InputError as error:
                self._outcome = error
            self._decode = None  # what it holds on to, such as the encoded bytes, is freed
        return self._outcome


@dataclass(frozen=True)
class Silence:
    """A recording has been read as far as this time, in seconds, without a further frame of one robot."""

    time: float


class Source(ABC):
    """Frames of one robot, in the order of their times, and a context manager that closes what it reads from.

    A recording can be iterated again, each time from its beginning.

    Attributes
    ----------
    text : str
        As the user gave it.
    name : str
        How errors and remarks call it.
    live : bool
        A camera or a stream: the newest frame wins.
    still : bool
        One picture, valid at every moment.
    """

    live = False
    still = False

    def __init__(self, text: str, name: str) -> None:
        self.text = text
        self.name = name

    @abstractmethod
    def __iter__(self) -> Iterator[Frame]:
        """Read the frames.

        Raises
        ------
        SourceError
            While reading: it breaks off.
        """

    def events(self) -> Iterator[Frame | Silence]:
        """Read the frames, and where a recording of several robots goes on without one of this, how far."""
        return iter(self)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What has to be told of it so far, for example where the times come from; a sentence each."""
        return ()

    def close(self) -> None:  # noqa: B027 - most have nothing to close
        """Close it; more than once does no harm."""

    def __enter__(self) -> "Source":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
