"""Instances of a loop: built from data that Hypothesis draws and shrinks, with a start, and run exactly."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, fmpq
from hypothesis import HealthCheck, Phase, find, settings
from hypothesis import strategies as st
from hypothesis.errors import NoSuchExample

from convexperc.errors import InputError
from verification.exact.balls import Numbers, UnresolvedError, precision
from verification.exact.reweighting import UndefinedUpdateError
from verification.reweighted.loops.better import better_point, is_less
from verification.reweighted.loops.loop import Loop, Point, unbounded_at_zero
from verification.reweighted.objectives.objective import rational_point

BITS = 256
LONGEST = 512
"""Bits of a rational beyond which it becomes a ball."""

STEPS = 6
"""Exact iterations of one instance."""

LARGEST = 9
"""Size of the integers of a start."""

MISSES = Fraction(1, 10**4)
"""Share of F by which it must be larger than elsewhere for a point to count as away from the optimum."""

FLOOR = Fraction(1, 10**9)
"""Of F at the start, and of F at 0, which is the size of the data: what counts as 0."""

Build = Callable[..., Loop]
Data = st.SearchStrategy[Mapping[str, Any]]


@dataclass(frozen=True)
class Run:
    """Exact iterates of a loop.

    Attributes
    ----------
    points : tuple of mapping of str to Numbers
        Rationals while they last, then balls.
    values : tuple of fmpq or arb
        F at each.
    ended : str
        Why there is no further iterate; empty if there is one.
    """

    points: tuple[Point, ...]
    values: tuple[Any, ...]
    ended: str = ""

    @cached_property
    def rise(self) -> int | None:
        """The first iterate at which F is larger than before, beyond doubt."""
        for k in range(1, len(self.values)):
            if bool(arb(self.values[k]) > arb(self.values[k - 1])):
                return k
        return None

    @cached_property
    def rests(self) -> int | None:
        """The first iterate that is its own successor, exactly."""
        for k in range(1, len(self.points)):
            if same(self.points[k], self.points[k - 1]):
                return k - 1
        return None


def same(first: Point, second: Point) -> bool:
    """Whether two points are rational and equal."""
    return all(
        isinstance(a, fmpq) and isinstance(b, fmpq) and a == b
        for name, values in first.items()
        for a, b in zip(values, second[name], strict=True)
    )


def exact_run(loop: Loop, start: Mapping[str, Any], steps: int) -> Run:
    """Make exact steps from a rational start, as long as there are any and balls tell."""
    ended = ""
    with precision(BITS):
        points = [rational_point(start)]
        values = [loop.objective.at(points[0])]
        for _ in range(steps):
            try:
                found = _shortened(loop.step(points[-1]))
                values.append(loop.objective.at(found))
                points.append(found)
            except UndefinedUpdateError as fault:
                ended = str(fault)
                break
            except (UnresolvedError, ZeroDivisionError):
                break
    return Run(tuple(points), tuple(values), ended)


def _shortened(point: Point) -> dict[str, Numbers]:
    """Balls for rationals that are long, as their digits double every few steps; zeros stay exact."""
    return {
        name: [arb(x) if isinstance(x, fmpq) and x.height_bits() > LONGEST else x for x in values]
        for name, values in point.items()
    }


@dataclass(frozen=True)
class Instance:
    """A loop for given data, and a start.

    Attributes
    ----------
    data : mapping
        Arguments of the function that builds the loop.
    loop : Loop
    start : mapping of str to tuple of Fractions
    """

    data: Mapping[str, Any]
    loop: Loop
    start: Mapping[str, tuple[Fraction, ...]]

    @cached_property
    def run(self) -> Run:
        """The first exact iterates."""
        return exact_run(self.loop, self.start, STEPS)

    @cached_property
    def starts_at_zero(self) -> bool:
        """Whether a residual whose weight grows without bound is 0 at the start."""
        return unbounded_at_zero(self.loop.objective, rational_point(self.start))

    def better(self, point: Point) -> tuple[Point, Any] | None:
        """A rational point with an F smaller by a share, beyond doubt, and F there; None: none was found."""
        with precision(BITS):
            objective = self.loop.objective
            here, origin = objective.at(point), {name: [fmpq(0)] * len(point[name]) for name in point}
            sizes = [objective.at(origin), objective.at(rational_point(self.start))]
            floor = fmpq(FLOOR.numerator, FLOOR.denominator)
            if not all(bool(arb(here) > arb(size) * floor) for size in sizes):
                return None
            found = better_point(objective, point)
            there = objective.at(found)
            return (found, there) if is_less(there, here, MISSES) else None

    def rests_away(self, point: Point) -> bool:
        """Whether a point is its own successor, exactly, and F is smaller elsewhere."""
        try:
            with precision(BITS):
                rests = same(self.loop.step(point), point)
        except (UndefinedUpdateError, UnresolvedError, ZeroDivisionError):
            return False
        return rests and self.better(point) is not None

    def compared(self, point: Point) -> dict[str, str]:
        """F at a point and at a better one, as text."""
        better = self.better(point)
        assert better is not None
        with precision(BITS):
            shown = {"point": shown_point(point), "F there": shown_number(self.loop.objective.at(point))}
        return shown | {"better point": shown_point(better[0]), "F elsewhere": shown_number(better[1])}

    def as_json(self) -> dict[str, Any]:
        """Data and start as JSON values; numbers of the start as text p/q."""
        start = {name: [str(x) for x in values] for name, values in self.start.items()}
        return {"data": dict(self.data), "start": start}

    def shown(self) -> dict[str, str]:
        """Data and start as text."""
        start = ", ".join(f"{name} = ({', '.join(map(str, values))})" for name, values in self.start.items())
        return {**{name: str(value) for name, value in self.data.items()}, "start": start}


@dataclass(frozen=True)
class Search:
    """Instances that are drawn until one shows something, and the smallest that does.

    Attributes
    ----------
    build : function
        Returns a `Loop` for the data.
    data : Hypothesis strategy
        Of the keyword arguments of `build`.
    examples : int
    """

    build: Build
    data: Data
    examples: int

    def loops(self, count: int) -> list[Loop]:
        """Loops of some instances."""
        found: list[Loop] = []

        def keep(instance: Instance) -> bool:
            found.append(instance.loop)
            return False

        self.smallest(keep, count)
        return found

    def smallest(self, shows: Callable[[Instance], bool], count: int | None = None) -> Instance | None:
        """The smallest instance found for which `shows` is true; `count` instances are drawn."""
        options = settings(
            max_examples=self.examples if count is None else count,
            database=None,
            derandomize=True,
            deadline=None,
            phases=(Phase.generate, Phase.shrink),
            suppress_health_check=list(HealthCheck),
        )
        try:
            return find(_instances(self.build, self.data), shows, settings=options)
        except NoSuchExample:
            return None


def instance(build: Build, data: Mapping[str, Any], start: Mapping[str, Any]) -> Instance:
    """An instance from what `Instance.as_json` gave.

    Raises
    ------
    InputError
        The loop has other variables than the start.
    """
    loop = build(**data)
    if set(start) != set(loop.objective.sizes):
        raise InputError("start", value=sorted(start), must=f"must name {', '.join(loop.objective.sizes)}")
    return Instance(data, loop, {name: tuple(Fraction(x) for x in values) for name, values in start.items()})


def _built(build: Build, data: Mapping[str, Any]) -> Loop:
    """What `build` returns.

    Raises
    ------
    InputError
        It raises, or returns something else.
    """
    try:
        loop = build(**data)
    except InputError:
        raise
    except (Exception, SystemExit) as fault:
        must = "must take the data that are drawn, and return a Loop"
        raise InputError("build", value=f"{type(fault).__name__}: {fault}", must=must) from fault
    if not isinstance(loop, Loop):
        raise InputError("build", value=type(loop).__name__, must="must return a Loop")
    return loop


@st.composite
def _instances(draw: st.DrawFn, build: Build, data: Data) -> Instance:
    given = draw(data)
    loop = _built(build, given)
    start = dict(loop.start or {})
    for name, size in loop.objective.sizes.items():
        if name not in start:
            start[name] = draw(st.lists(st.integers(-LARGEST, LARGEST), min_size=size, max_size=size))
    flat = {name: np.ravel(np.asarray(values, dtype=object)) for name, values in start.items()}
    return Instance(given, loop, {name: tuple(Fraction(x) for x in values) for name, values in flat.items()})


def shown_number(value: Any) -> str:
    """A rational that is short as it is, else some digits."""
    if isinstance(value, fmpq) and len(str(value)) <= 20:
        return str(value)
    return str(arb(value).str(12, radius=False))


def shown_point(point: Mapping[str, Numbers]) -> str:
    """The coordinates by variable."""
    return ", ".join(f"{name} = ({', '.join(map(shown_number, values))})" for name, values in point.items())
