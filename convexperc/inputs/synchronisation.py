"""Which pictures of several robots belong to one moment, by their times."""

from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np
from jaxtyping import UInt8

from convexperc.errors import ImageError, InputError, RobotNameError, SourceError, check_type
from convexperc.features.pictures import Picture
from convexperc.features.regions import Mask, Region, cut_out
from convexperc.inputs.frames import Frame, Source, real
from convexperc.inputs.leading import grid, led
from convexperc.inputs.live import Live, arrivals
from convexperc.inputs.tracks import Counts, Track

SHORTEST = 1e-6
"""Seconds: float64 would not tell times that are nearer, about 0.24 us, since the epoch."""
Views = Mapping[str, UInt8[np.ndarray, "_ _ 3"]]
"""Pictures by the names of the robots, each of its own size."""
Regions = Mapping[str, Region | Mask]
"""The part of a robot's pictures that shows the object."""


@dataclass(frozen=True, eq=False)
class Moment:
    """The pictures of one moment.

    Attributes
    ----------
    time : float
        Seconds, on the clock that the sources share.
    nanoseconds : int
        The same time, exactly that of the frame that leads where its source gives nanoseconds.
    views : mapping of str to uint8 (h, w, 3)
        Each robot's picture, in the order of the sources. There may be none.
    times : mapping of str to float
        The time of each of these pictures; that of a still is the moment's.
    missing : mapping of str to str
        Every other robot, and why it is left out.
    """

    time: float
    nanoseconds: int
    views: Views
    times: Mapping[str, float]
    missing: Mapping[str, str]


class Moments(Iterator[Moment]):
    """The moments of several sources; see `moments`. A context manager that closes the sources.

    They are closed at the end of the iteration, too, and where it ends with an error.

    Attributes
    ----------
    empty : int
        Moments without any robot so far, those included that a run of them stands for.
    """

    def __init__(
        self,
        sources: Mapping[str, Source],
        *,
        slop: float,
        every: float | None,
        strict: bool,
        regions: Regions,
    ) -> None:
        self.empty = 0
        self._sources, self._slop, self._every, self._strict = dict(sources), slop, every, strict
        self._regions = dict(regions)
        self._fitting = set[str]()
        self._tracks = dict[str, Track]()
        self._stills = dict[str, Frame]()
        self._live = {name: source for name, source in sources.items() if isinstance(source, Live)}
        self._moments = self._run()

    def __iter__(self) -> "Moments":
        return self

    def __next__(self) -> Moment:
        try:
            return next(self._moments)
        except BaseException:  # also at the end
            self.close()
            raise

    def close(self) -> None:
        """Close the sources; the iteration is over. More than once does no harm."""
        self._moments.close()
        for source in self._sources.values():
            source.close()

    def __enter__(self) -> "Moments":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def counts(self) -> Mapping[str, Counts]:
        """What became of the frames of each robot so far; a still's is in the first moment and all others."""
        found = dict[str, Counts]()
        for robot in self._sources:
            if robot in self._tracks:
                found[robot] = self._tracks[robot].counts
            elif robot in self._live:
                found[robot] = self._live[robot].counts
            else:
                broken = robot in self._stills and self._stills[robot].error is not None
                found[robot] = Counts(frames=1, used=int(not broken), unreadable=int(broken))
        return found

    @property
    def remarks(self) -> tuple[str, ...]:
        """What has to be told of the robots' sources and frames so far, a line each; final at the end."""
        said = list[str]()
        for robot, counts in self.counts.items():
            lines = [*self._sources[robot].remarks]
            if counts.ended:
                lines.append(f"broke off: {counts.ended}")
            for number, what in (
                (counts.unused, "not used: no moment was near, or another frame was nearer"),
                (counts.unreadable, "without a readable picture"),
                (
                    counts.disordered,
                    "left out: their times are out of order, or they came too late",
                ),
                (counts.dropped, "dropped for newer ones"),
            ):
                if number:
                    lines.append(f"{number} of {counts.frames} frames {what}")
            said += [f"{robot}: {line}" for line in lines]
        return tuple(said)

    def _run(self) -> Generator[Moment]:
        for robot, source in self._sources.items():
            if source.still:
                self._stills[robot] = next(iter(source))
        if self._live:
            yield from self._of_the_living()
        elif len(self._stills) == len(self._sources):
            yield self._moment(0.0, 0, {})
        else:
            yield from self._recorded()

    def _recorded(self) -> Iterator[Moment]:
        for robot, source in self._sources.items():
            if not source.still:
                self._tracks[robot] = Track(robot, source, strict=self._strict)
        tracks = tuple(self._tracks.values())
        if self._every is None:
            times: Iterator[tuple[float | None, int]] = ((time, 0) for time in led(tracks, self._slop))
        else:
            times = grid(tracks, self._slop, self._every)
        for time, empty in times:
            if time is None:
                self.empty += empty
                continue
            yield self._at(time)
            for track in tracks:
                track.forget(time, self._slop)
        for track in tracks:
            track.over = True
        failures = [track.failure for track in tracks if track.failure is not None]
        if failures and not any(track.frames for track in tracks):
            raise failures[0]

    def _at(self, time: float) -> Moment:
        """The moment of recorded frames: of each robot the nearest one that has a picture."""
        chosen = dict[str, Frame | InputError | str]()
        leader: Frame | None = None
        for robot, track in self._tracks.items():
            near = track.near(time, self._slop)
            if leader is None and near and near[0].time == time:
                leader = near[0].frame
            for kept in near:
                kept.broken = kept.frame.error is not None
                if not kept.broken:
                    kept.used = True
                    chosen[robot] = kept.frame
                    break
            else:
                error = near[0].frame.error if near else None
                chosen[robot] = error if error is not None else track.absence(time, self._slop)
        return self._moment(time, round(time * 10**9) if leader is None else leader.nanoseconds, chosen)

    def _moment(
        self, time: float, nanoseconds: int, chosen: Mapping[str, Frame | InputError | str]
    ) -> Moment:
        """Join what was chosen of each robot with the stills."""
        views, times, missing = dict[str, Picture](), dict[str, float](), dict[str, str]()
        for robot, source in self._sources.items():
            found = self._stills[robot] if source.still else chosen[robot]
            cut = self._cut(robot, found) if isinstance(found, Frame) else found
            if isinstance(cut, np.ndarray):
                views[robot] = cut
                times[robot] = time if source.still or not isinstance(found, Frame) else found.time
                continue
            missing[robot] = str(cut)
            if self._strict:
                raise _strictly(robot, time, cut)
        self.empty += not views
        return Moment(time, nanoseconds, views, times, missing)

    def _cut(self, robot: str, frame: Frame) -> Picture | InputError:
        """The region of the robot's picture, or what is wrong.

        A region that does not fit the robot's first picture is a mistake of the caller; if a later picture
        has another size, that one is left out.
        """
        picture, region = frame.picture, self._regions.get(robot)
        if picture is None:
            assert frame.error is not None
            return frame.error
        if region is None:
            return picture
        try:
            part = cut_out(picture, region)
        except ImageError as error:
            if robot not in self._fitting:
                raise _unfit(robot, error) from None
            return error
        self._fitting.add(robot)
        return part

    def _of_the_living(self) -> Iterator[Moment]:
        for frames, time in arrivals(self._live, self._slop, self._every):
            yield self._moment(time, round(time * 10**9), frames)


def _unfit(robot: str, error: ImageError) -> ImageError:
    what = f"robot {robot!r}, its first {error.what}"
    return ImageError(what, value=error.value, must=error.must, remedy=error.remedy)


def _strictly(robot: str, time: float, cause: InputError | str) -> InputError:
    if isinstance(cause, InputError):
        return type(cause)(
            f"robot {robot!r} at {time:.6f} s: {cause.what}",
            value=cause.value, must=cause.must, remedy=cause.remedy,
        )  # fmt: skip
    must, remedy = "must have a picture at every moment", "Do without strict, or with a wider slop."
    return SourceError(f"robot {robot!r} at {time:.6f} s", value=cause, must=must, remedy=remedy)


def moments(
    sources: Mapping[str, Source],
    *,
    slop: float,
    every: float | None = None,
    strict: bool = False,
    regions: Regions | None = None,
) -> Moments:
    """Join the pictures of several robots into moments, by their times.

    The robots lead in the order given: each frame of the first is a moment, and a frame of a later one is a
    moment of its own if no moment that a robot before it leads is at most `slop` away. So every frame lies
    within the slop of a moment. With `every`, the moments are at ``start + k * every`` instead, from the
    earliest to the latest frame of all; of a run of such times without any frame near, the first is given.

    At a moment, each robot gives its frame that is nearest in time, of equally near ones the earlier, among
    those that are at most `slop` away and can be read; a still gives its picture. A frame may be part of
    several moments, in each once. Which frames are in none is counted.

    Of live sources, the newest frame counts. A moment begins with the first frame that is newer than the
    last moment, waits at most `slop` for the frames of the others, and its time is that of the newest of
    them. With `every` it begins at least so much after the last one began.

    Parameters
    ----------
    sources : mapping of str to Source
        Each robot's source. Recordings and live sources do not go together; stills go with both. They are
        closed at the end.
    slop : float
        Seconds, >= 0.
    every : float, optional
        Seconds, at least `SHORTEST` (1 us).
    strict : bool
        Raise where otherwise a robot is left out of a moment, a source breaks off, or a frame is out of
        order.
    regions : mapping of str to Region or bool (h, w), optional
        The part of the robot's pictures to use: a region is cut out, see `cropped`; of a mask, see `masked`.

    Returns
    -------
    Moments
        Read once. The frames near the present moment are held, about twice the slop for each robot before it
        in the order; pictures are decoded when they are wanted.

    Raises
    ------
    InputError
        `slop` or `every` is out of range, or there is no source.
    SourceError
        Live sources and recordings together. While iterating: no source could be read at all; `strict`.
    ImageError
        While iterating: a region or a mask does not fit the first picture of its robot.
    RobotNameError
        A region of a robot that is not among the sources.
    """
    check_type(regions, (Mapping, type(None)), "regions")
    check_type(strict, bool, "strict")
    _check(sources, slop, every, regions or {})
    every = None if every is None else float(every)
    return Moments(sources, slop=float(slop), every=every, strict=strict, regions=regions or {})


def _check(sources: Mapping[str, Source], slop: Any, every: Any, regions: Regions) -> None:
    check_type(sources, Mapping, "sources", SourceError)
    for robot, source in sources.items():
        check_type(robot, str, "a robot's name", RobotNameError)
        check_type(source, Source, f"the source of robot {robot!r}", SourceError)
    if not sources:
        raise SourceError("sources", value="none", must="must be at least one robot's")
    must = "must be a finite number of seconds >= 0"
    if real(slop, "slop", must) < 0:
        raise InputError("slop", value=slop, must=must)
    must = f"must be a finite number of seconds >= {SHORTEST:g}"
    if every is not None and real(every, "every", must) < SHORTEST:
        raise InputError("every", value=every, must=must)
    unknown = [robot for robot in regions if robot not in sources]
    if unknown:
        raise RobotNameError("regions", value=unknown[0], must=f"must be of the robots {', '.join(sources)}")
    live = [robot for robot, source in sources.items() if source.live]
    recorded = [robot for robot, source in sources.items() if not source.live and not source.still]
    if live and recorded:
        must = "must be all live or all recorded, apart from single pictures: their clocks differ"
        raise SourceError("sources", value=f"live {live}, recorded {recorded}", must=must)
