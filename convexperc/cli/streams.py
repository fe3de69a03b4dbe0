"""Recognition from named sources: one recognition of pictures, or one at each moment of a stream."""

import re
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from convexperc import features, inputs, recognition, report
from convexperc.cli.stream_outputs import opened
from convexperc.errors import InputError, escaped
from convexperc.files import Places, check_apart, check_place

if TYPE_CHECKING:
    from convexperc.features.pictures import Picture
    from convexperc.inputs import Moments
    from convexperc.recognition import Calibration, Judgement, Recognition, References


@dataclass(frozen=True)
class Asked:
    """The options of recognition from named sources, as given."""

    view: Sequence[str]
    region: Sequence[str]
    mask: Sequence[str]
    slop: float
    every: float | None
    rate: float
    strict: bool
    jsonl: Path | None
    results: Path | None
    watch: bool

    @property
    def texts(self) -> dict[str, str]:
        """Where each robot's pictures come from."""
        return _named("--view", self.view)

    def check(self, outputs: Mapping[str, Path | None], read: Mapping[str, Places]) -> None:
        """Refuse options without a view, and outputs that would replace an input, before any work.

        `outputs` are those of one recognition, and `read` the other inputs, by their options.
        """
        if not self.view:
            given = {
                "--region": self.region, "--mask": self.mask, "--strict": self.strict, "--every": self.every,
                "--jsonl": self.jsonl, "--results": self.results, "--watch": self.watch,
            }  # fmt: skip
            for option, value in given.items():
                if value:
                    raise typer.BadParameter(f"{option} goes with --view")
            return
        places = {f"--view {name}": inputs.read_places(text) for name, text in self.texts.items()}
        masks = {f"--mask {name}": Path(file) for name, file in _named("--mask", self.mask).items()}
        files, folders = {**outputs, "--jsonl": self.jsonl}, dict[str, Path | None]()
        single = self.results is not None and self.results.suffix.lower() in (".mcap", ".db3")
        (files if single else folders)["--results"] = self.results
        check_apart(files, folders=folders, inputs={**places, **masks, **read})
        if self.jsonl is not None:
            check_place(self.jsonl)

    def take(self, folder: Path | None) -> "tuple[dict[str, Picture | None] | Stream, list[str]]":
        """Open the sources, in the order given; the pictures of the folder come first.

        Returns
        -------
        dict or Stream
            The pictures, None for one that cannot be read, if every source is a picture.
        list of str
            What has to be told of these.
        """
        texts = dict[str, str]()
        pictures = [] if folder is None else features.list_images(folder)
        for name, text in (*((path.stem, str(path)) for path in pictures), *self.texts.items()):
            if name in texts:
                raise typer.BadParameter(f"--view {name}: {texts[name]} of --views has that name")
            texts[name] = text
        for option, given in (("--region", self.region), ("--mask", self.mask)):
            for name in _named(option, given):
                if name not in texts:
                    raise typer.BadParameter(f"{option} {name}: no --view has that name")
        parts = self._parts()
        sources = inputs.open_sources(texts, rate=self.rate)
        moments = inputs.moments(sources, slop=self.slop, every=self.every, strict=self.strict, regions=parts)
        if all(source.still for source in sources.values()):
            return self._pictures(moments)
        return Stream(moments, tuple(sources), self), []

    def _pictures(self, moments: "Moments") -> "tuple[dict[str, Picture | None], list[str]]":
        """The pictures of the only moment."""
        for option, value in (
            ("--jsonl", self.jsonl), ("--results", self.results), ("--watch", self.watch)
        ):  # fmt: skip
            if value:
                raise typer.BadParameter(f"{option} is for streams, and every view is a picture")
        with moments:
            moment = next(moments)
        told = [f"{name}: left out; {reason}" for name, reason in moment.missing.items()]
        if not moment.views:
            raise _no_moment(told)
        return {**moment.views, **dict.fromkeys(moment.missing)}, told

    def _parts(self) -> dict[str, Any]:
        """The region or the mask of each robot that has one."""
        regions, masks = _named("--region", self.region), _named("--mask", self.mask)
        for name in regions:
            if name in masks:
                raise typer.BadParameter(f"--region {name}: there is a --mask for it, which has a region")
        found: dict[str, Any] = {name: features.Region.parse(text) for name, text in regions.items()}
        return found | {name: features.read_mask(file) for name, file in masks.items()}


def _named(option: str, given: Sequence[str]) -> dict[str, str]:
    """Split ``NAME=VALUE``, each name once."""
    found: dict[str, str] = {}
    for text in given:
        name, sign, value = text.partition("=")
        if not (name and sign and value):
            raise typer.BadParameter(f"{option} {text}: give it as NAME=..., with the name of a robot")
        if name in found:
            raise typer.BadParameter(f"{option} {name}: give it once")
        found[name] = value
    return found


@dataclass(frozen=True, eq=False)
class Recogniser:
    """What the pictures of a moment are recognised by.

    Attributes
    ----------
    known : References
    options : mapping
        Of `perceive`: the lambdas, and what decides.
    calibration : Calibration or None
    """

    known: "References"
    options: Mapping[str, Any]
    calibration: "Calibration | None"

    def perceive(
        self, views: "recognition.Frames", start: "Recognition | None"
    ) -> "tuple[Recognition, Judgement | None]":
        """Recognise, and judge that by the calibration."""
        found = recognition.perceive(views, self.known, start=start, prune=False, **self.options)
        return found, None if self.calibration is None else self.calibration.judge(found)


@dataclass(frozen=True, eq=False)
class Stream:
    """Views at one moment after the other.

    Attributes
    ----------
    moments : Moments
    robots : tuple of str
        In the order given.
    asked : Asked
    """

    moments: "Moments"
    robots: tuple[str, ...]
    asked: Asked

    def __len__(self) -> int:
        return len(self.robots)

    def check(self, options: Mapping[str, object]) -> None:
        """Refuse the options of one recognition."""
        for option, value in options.items():
            if value:
                raise typer.BadParameter(
                    f"{option} is for one recognition, and these views are a stream: leave it out"
                    " (--jsonl FILE writes the moments of a stream)"
                )

    def follow(self, recogniser: Recogniser, told: Sequence[str]) -> bool:
        """Recognise the views of each moment, write a line for each, and say at the end what was left out.

        An interruption ends it like the end of the stream does, and is raised again afterwards.

        Returns
        -------
        bool
            Whether the label of every moment is proved, certified and accepted.

        Raises
        ------
        InputError
            There was no moment at all.
        """
        tally = _Tally()
        try:
            with (
                self.moments as moments,
                opened(self.robots, self.asked.jsonl, self.asked.results, self.asked.watch) as outputs,
                _ended_by_interruption() as interrupted,
            ):
                for line, found in _lines(moments, recogniser):
                    tally.add(line)
                    outputs.write(line, found)
        finally:
            for said in (*told, *tally.lines(self.moments.empty), *self.moments.remarks):
                typer.echo(escaped(said), err=True)
        if interrupted:
            raise interrupted[0]
        if not tally.moments:
            raise _no_moment(self.moments.remarks or [f"{name}: it has no picture" for name in self.robots])
        return tally.accepted == tally.moments


def _lines(
    moments: "Moments", recogniser: Recogniser
) -> "Iterator[tuple[dict[str, Any], Recognition | None]]":
    """The record of each moment, and the recognition, which is the start of the next one."""
    start: Recognition | None = None
    for moment in moments:
        began, found, judged = time.perf_counter(), None, None
        if moment.views:
            found, judged = recogniser.perceive(moment.views, start)
            start = found
        times = moment.time, moment.nanoseconds, moment.times
        line = report.recognition_line(*times, moment.missing, found, judged)
        if found is not None:
            line["milliseconds"] = round(1e3 * (time.perf_counter() - began), 3)
        yield line, found


def _no_moment(told: Sequence[str]) -> InputError:
    must = "must give at least one moment with a picture"
    return InputError("--view", value="; ".join(told) or "no picture", must=must)


@contextmanager
def _ended_by_interruption() -> Iterator[list[KeyboardInterrupt]]:
    """Leave the block where it is interrupted, and say so in the list."""
    seen: list[KeyboardInterrupt] = []
    try:
        yield seen
    except KeyboardInterrupt as interruption:
        seen.append(interruption)


_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def _counted(moments: int) -> str:
    return f"{moments} moment{'' if moments == 1 else 's'}"


@dataclass
class _Tally:
    """What there was so far."""

    moments: int = 0
    proved: int = 0
    accepted: int = 0
    empty: int = 0
    missing: dict[str, Counter[str]] = field(default_factory=dict)
    """Reasons by robot, counted by their kinds: their texts without numbers."""
    last: dict[tuple[str, str], str] = field(default_factory=dict)
    """The last reason of each kind, by robot and kind."""

    def add(self, line: Mapping[str, Any]) -> None:
        self.moments += 1
        self.empty += line["verdict"] is None
        proved = line["label"] is not None and line["certified"]
        self.proved += proved
        judged = line["acceptance"]
        self.accepted += proved and (judged is None or judged["accepted"] == [line["label"]])
        for name, reason in line["missing"].items():
            kind = _NUMBER.sub("", reason)
            self.missing.setdefault(name, Counter())[kind] += 1
            self.last[name, kind] = reason

    def lines(self, empty: int) -> list[str]:
        """One line on all moments, if there was any, and one for each robot that was missing.

        `empty` counts the moments without any robot, those included that have no line of their own.
        """
        if not self.moments:
            return []
        said = [f"{_counted(self.moments)}: the lowest optimum is proved in {self.proved}"]
        if self.accepted < self.proved:
            said[0] += f", and accepted by the calibration in {self.accepted} of these"
        if self.empty:
            said[0] += f"; no robot has a view in {self.empty}"
        if empty > self.empty:
            said[0] += f", nor in {_counted(empty - self.empty)} without a line"
        for name, reasons in self.missing.items():
            (kind, count), total = reasons.most_common(1)[0], reasons.total()
            often = "" if len(reasons) == 1 else f"in {count} of these, "
            which = "" if count == 1 else "last: "
            shown = f"{often}{which}{self.last[name, kind]}"
            said.append(f"{name}: missing in {total} of {_counted(self.moments)}; {shown}")
        return said
