"""Which pictures belong to one moment, against a definition by brute force."""

import itertools
import math
from random import Random

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from made_sources import Listed, Lone, number_of, picture

from convexperc.errors import ImageError, InputError, RobotNameError, SourceError
from convexperc.features import Region
from convexperc.inputs import moments
from convexperc.inputs.frames import Silence
from convexperc.inputs.live import Live
from convexperc.inputs.synchronisation import SHORTEST

coarse = st.integers(0, 24).map(lambda k: k / 4)
fine = st.floats(0, 6, allow_nan=False)
track = (
    st.lists(st.one_of(coarse, fine), max_size=8)
    .map(sorted)
    .flatmap(lambda times: st.tuples(st.just(times), st.sets(st.integers(0, 7), max_size=3)))
)
tracks = st.lists(track, min_size=1, max_size=4)
slops = st.one_of(st.just(0.0), st.integers(0, 4).map(lambda k: k / 4), st.floats(0, 1))


def nearest(times, broken, moment, slop):
    """The number of the frame that a robot gives, or None; and whether any was near."""
    near = [n for n, time in enumerate(times) if abs(time - moment) <= slop]
    near.sort(key=lambda n: (abs(times[n] - moment), times[n], n))
    return next((n for n in near if n not in broken), None), bool(near)


def leading(all_times, slop):
    """Times of the moments, by definition: robot by robot."""
    found = []
    for times in all_times:
        before = list(found)
        found += [
            time for time in dict.fromkeys(times) if not any(abs(time - lead) <= slop for lead in before)
        ]
    return sorted(found)


def read(sources, **options):
    """What was chosen at each moment, and the object that tells the counts."""
    found = moments(sources, **options)
    return [(m.time, {robot: number_of(view) for robot, view in m.views.items()}) for m in found], found


CHAIN = [[10.0, 11.25], [10.75, 12.0], [9.75, 12.0], [8.75, 12.0]]
"""With a slop of 1, whether 8.75 leads depends on 9.75, that on 10.75, and that on what follows 11.25."""


@given(tracks, slops)
@example([(times, set()) for times in CHAIN], 1.0)
def test_moments_are_those_of_the_definition(made, slop):
    sources = {f"r{k}": Listed(times, broken) for k, (times, broken) in enumerate(made)}
    got, found = read(sources, slop=slop)
    times = leading([times for times, _ in made], slop)
    assert [time for time, _ in got] == times
    used = {robot: set() for robot in sources}
    for (time, chosen), k in itertools.product(got, range(len(made))):
        expected, _ = nearest(*made[k], time, slop)
        assert chosen.get(f"r{k}") == expected, (time, k)
        used[f"r{k}"] |= {expected} - {None}
    for robot, counts in found.counts.items():
        own, broken = made[int(robot[1:])]
        assert counts.frames == len(own)
        assert counts.used == len(used[robot])
        assert counts.used + counts.unused + counts.unreadable == counts.frames
        assert counts.unreadable <= sum(n in broken for n in range(len(own)))
    assert found.empty == sum(not chosen for _, chosen in got)


@given(tracks, slops)
def test_every_frame_is_within_the_slop_of_a_moment(made, slop):
    got, _ = read({f"r{k}": Listed(times) for k, (times, _) in enumerate(made)}, slop=slop)
    for times, _ in made:
        assert all(any(abs(time - moment) <= slop for moment, _ in got) for time in times)


@given(tracks, slops, st.one_of(st.integers(1, 8).map(lambda k: k / 4), st.floats(0.05, 3)))
def test_moments_on_a_grid_are_those_of_the_definition(made, slop, every):
    got, found = read({f"r{k}": Listed(*each) for k, each in enumerate(made)}, slop=slop, every=every)
    everything = [time for times, _ in made for time in times]
    expected, empty, within_run = [], 0, False
    for k in itertools.count():
        if not everything or min(everything) + k * every > max(everything):
            break
        time = min(everything) + k * every
        chosen = [nearest(*each, time, slop) for each in made]
        empty += all(number is None for number, _ in chosen)
        run = not any(near for _, near in chosen)
        if not (run and within_run):
            expected.append((time, {f"r{j}": n for j, (n, _) in enumerate(chosen) if n is not None}))
        within_run = run
    assert got == expected
    assert found.empty == empty


@given(tracks, slops, st.integers(0, 2**32), st.booleans())
def test_news_of_silence_change_nothing(made, slop, seed, grid):
    random = Random(seed)

    def told(times):
        events, floor = [], -1.0
        for time in [*times, 8.0]:
            while random.random() < 0.4:
                floor = random.uniform(floor, time)
                events.append(Silence(floor))
            if time < 8.0:
                events.append(time)
                floor = time
        return events

    options = {"slop": slop, "every": 0.5 if grid else None}
    plain, _ = read({f"r{k}": Listed(*each) for k, each in enumerate(made)}, **options)
    silent, _ = read({f"r{k}": Listed(told(times), b) for k, (times, b) in enumerate(made)}, **options)
    assert silent == plain


def test_a_clock_that_is_off_leaves_each_robot_out_by_name_and_says_how_far():
    sources = {"a": Listed([0.0, 1.0]), "b": Listed([100.0, 101.0])}
    found = list(moments(sources, slop=0.5))
    assert [set(m.views) for m in found] == [{"a"}, {"a"}, {"b"}, {"b"}]
    assert found[0].missing == {"b": "no picture within 0.5 s: the nearest is 100 s later"}
    assert found[3].missing == {"a": "no picture within 0.5 s: the nearest is 100 s earlier, its last one"}


def test_a_grid_over_a_long_gap_is_short_work():
    got, found = read({"a": Listed([0.0]), "b": Listed([1.7e9])}, slop=0.05, every=0.1)
    assert [chosen for _, chosen in got] == [{"a": 0}, {}, {"b": 0}]
    assert found.empty == pytest.approx(1.7e10, rel=1e-6)


def test_a_robot_that_drops_out_is_left_out_and_the_rest_go_on():
    times = [k / 10 for k in range(30)]
    sources = {"lead": Listed([t for t in times if not 1 <= t < 2]), "other": Listed(times)}
    found = list(moments(sources, slop=0.04))
    assert [m.time for m in found] == times
    assert [set(m.missing) for m in found] == [{"lead"} if 1 <= t < 2 else set() for t in times]


def test_a_broken_picture_gives_way_to_a_sound_one_or_leaves_its_robot_out():
    sources = {"a": Listed([0.0, 1.0]), "b": Listed([0.0, 0.1, 1.0], broken=[0, 2])}
    found = moments(sources, slop=0.2)
    first, second = found
    assert number_of(first.views["b"]) == 1
    assert first.times == {"a": 0.0, "b": 0.1}
    assert second.missing == {"b": "frame 2 must be a picture; got 'nothing'."}
    assert found.counts["b"].unreadable == 2
    assert "b: 2 of 3 frames without a readable picture" in found.remarks


def test_a_moment_without_any_robot_is_given():
    found = moments({"a": Listed([0.0, 1.0], broken=[0])}, slop=0.1)
    first, second = found
    assert not first.views
    assert set(first.missing) == {"a"}
    assert second.views
    assert found.empty == 1
    assert not [said for said in found.remarks if "without any robot" in said], "the caller counts them"


def test_a_frame_out_of_order_is_left_out_and_counted():
    """The one whose time is too far ahead, or the one before all others where a clock was set back."""
    got, found = read({"a": Listed([0.0, 9.0, 1.0, 1.5, 3.0])}, slop=0.1)
    assert got == [(0.0, {"a": 0}), (1.0, {"a": 2}), (1.5, {"a": 3}), (3.0, {"a": 4})]
    assert found.counts["a"].disordered == 1
    assert found.counts["a"].frames == 5
    got, found = read({"a": Listed([5.0, 6.0, 1.0, 2.0, 7.0])}, slop=0.1)
    assert got == [(5.0, {"a": 0}), (6.0, {"a": 1}), (7.0, {"a": 4})]
    assert "a: 2 of 5 frames left out: their times are out of order, or they came too late" in found.remarks


def test_a_source_that_breaks_off_is_named_and_the_rest_go_on():
    found = moments({"a": Listed([0.0], fails="a cut"), "b": Listed([0.0, 1.0])}, slop=0.1)
    made = list(found)
    assert set(made[0].views) == {"a", "b"}
    assert made[1].missing == {"a": "listed must go on; got 'a cut'."}
    assert "a: broke off: listed must go on; got 'a cut'." in found.remarks


def test_no_source_that_could_be_read_is_an_error():
    with pytest.raises(SourceError, match="a cut"):
        list(moments({"a": Listed([], fails="a cut"), "b": Listed([])}, slop=0.1))


def test_sources_without_a_frame_give_no_moment():
    assert not list(moments({"a": Listed([])}, slop=0.1))
    assert not list(moments({"a": Listed([])}, slop=0.1, every=1.0))


@pytest.mark.parametrize(
    ("source", "kind", "said"),
    [
        (Listed([0.0]), SourceError, "no picture within"),
        (Listed([0.0, 5.0], broken=[1]), ImageError, "frame 1"),
        (Listed([0.0, 5.0], fails="a cut"), SourceError, "a cut"),
        (Listed([0.0, 5.0, 4.0]), SourceError, "time of a frame"),
    ],
    ids=["drop-out", "broken", "cut", "disordered"],
)
def test_strict_raises_where_something_is_left_out_and_closes(source, kind, said):
    lead = Listed([0.0, 5.0])
    with pytest.raises(kind, match=said):
        list(moments({"lead": lead, "b": source}, slop=0.1, strict=True))
    assert lead.closed


def test_strict_changes_nothing_where_nothing_is_missing():
    sources = {"a": Listed([0.0, 1.0]), "b": Listed([0.05, 1.0])}
    assert len(list(moments(sources, slop=0.1, strict=True))) == 2


def test_a_still_is_in_every_moment_and_leads_none():
    found = list(moments({"still": Lone(), "a": Listed([1.0, 2.0])}, slop=0.1))
    assert [(m.time, list(m.views)) for m in found] == [(1.0, ["still", "a"]), (2.0, ["still", "a"])]
    assert found[1].times == {"still": 2.0, "a": 2.0}
    (only,) = moments({"x": Lone(1), "y": Lone(2)}, slop=0.1)
    assert only.time == 0.0
    assert [number_of(view) for view in only.views.values()] == [1, 2]


def test_regions_are_cut():
    mask = np.zeros((12, 16), dtype=np.bool_)
    mask[1:10, 2:13] = True
    regions = {"a": Region(2, 1, 9, 8), "c": mask}
    (only,) = moments({robot: Lone() for robot in "ac"}, slop=0.0, regions=regions)
    assert only.views["a"].shape == (8, 9, 3)
    assert only.views["c"].shape == (9, 11, 3)


@pytest.mark.parametrize(
    ("region", "said"),
    [
        (
            Region(10, 0, 9, 9),
            r"robot 'b', its first picture: region .* picture of 16 x 12 .* got '10,0,9,9'",
        ),
        (np.ones((9, 9), np.bool_), r"robot 'b', its first picture: mask .*, \(12, 16\)"),
    ],
)
@pytest.mark.parametrize("still", [True, False])
def test_a_region_that_does_not_fit_the_first_picture_is_refused(region, said, still):
    sources = {"a": Listed([0.0]), "b": Lone() if still else Listed([0.0])}
    with pytest.raises(ImageError, match=said):
        list(moments(sources, slop=0.0, regions={"b": region}))


def test_frames_that_are_in_no_moment_are_told_with_what_may_be_why():
    found = moments({"a": Listed([0.0]), "b": Listed([0.0, 0.01])}, slop=0.05)
    assert len(list(found)) == 1
    assert found.remarks == ("b: 1 of 2 frames not used: no moment was near, or another frame was nearer",)


class Resized(Listed):
    """The second picture is lower."""

    def _picture(self, number):
        return picture(number, (10, 16) if number == 1 else (12, 16))


def test_a_later_picture_of_another_size_leaves_the_robot_out():
    regions = {"a": Region(0, 0, 16, 12)}
    found = list(moments({"a": Resized([0.0, 1.0, 2.0])}, slop=0.1, regions=regions))
    assert [list(each.views) for each in found] == [["a"], [], ["a"]]
    assert "within the picture of 16 x 10 pixels" in found[1].missing["a"]


@pytest.mark.parametrize(
    "options",
    [
        {"slop": -1.0}, {"slop": math.inf}, {"slop": math.nan}, {"slop": 0.1, "every": 0.0},
        {"slop": 0.1, "every": 1e-9}, {"slop": 0.1, "every": 1e-300}, {"slop": 0.1, "every": math.nan},
    ],
)  # fmt: skip
def test_what_is_out_of_range_is_refused(options):
    with pytest.raises(InputError, match="seconds"):
        moments({"a": Listed([])}, **options)


def test_the_shortest_grid_has_different_times_since_the_epoch():
    found = moments({"a": Listed([1.7e9, 1.7e9 + 1.0])}, slop=0.1, every=SHORTEST)
    times = [next(found).time for _ in range(1000)]
    assert len(set(times)) == 1000


def test_what_is_read_ahead_is_not_called_unused_before_the_end():
    found = moments({"a": Listed([0.0, 1.0, 1.01, 2.0])}, slop=0.1, every=1.0)
    next(found)
    assert found.counts["a"].waiting > 0
    assert found.remarks == ()
    assert [moment.time for moment in found] == [1.0, 2.0]
    assert (found.counts["a"].waiting, found.counts["a"].unused) == (0, 1)
    assert "1 of 4 frames not used" in found.remarks[0]


def test_no_source_an_unknown_robot_and_a_mixture_are_refused():
    with pytest.raises(SourceError, match="at least one"):
        moments({}, slop=0.1)
    with pytest.raises(RobotNameError, match="of the robots a"):
        moments({"a": Listed([])}, slop=0.1, regions={"b": Region(0, 0, 8, 8)})

    class Closed:
        def read(self):
            return False, None

        def release(self):
            pass

    with Live("0", "camera 0", Closed(), 1.0) as camera, pytest.raises(SourceError, match="all recorded"):
        moments({"a": Listed([]), "b": camera}, slop=0.1)


def test_no_more_is_read_ahead_than_the_slop_needs():
    """A stream of any length: at most a few frames of each robot are held."""
    sources = {"a": Listed([k / 30 for k in range(3000)]), "b": Listed([k / 10 for k in range(1000)])}
    for count, moment in enumerate(moments(sources, slop=0.1)):
        assert moment.time == count / 30
        assert sources["a"].read - count < 12
        assert sources["b"].read - count / 3 < 6


def test_sources_are_closed_at_the_end_and_on_the_way():
    sources = {"a": Listed([0.0, 1.0]), "b": Listed([0.0])}
    with moments(sources, slop=0.1) as found:
        next(found)
    assert all(source.closed for source in sources.values())
    assert not list(found)


def test_a_moment_has_the_nanoseconds_of_the_frame_that_leads():
    class Exact(Listed):
        def events(self):
            for frame in super().events():
                frame.nanoseconds = 1_700_000_000_123_456_789
                yield frame

    time = 1_700_000_000_123_456_789 / 10**9
    (only,) = moments({"b": Lone(), "a": Exact([time])}, slop=0.1)
    assert only.nanoseconds == 1_700_000_000_123_456_789
    assert only.time == time


def test_pictures_are_decoded_only_where_they_are_wanted():
    decoded = []

    class Watched(Listed):
        def _picture(self, number):
            decoded.append(number)
            return picture(number)

    list(moments({"a": Watched([k / 10 for k in range(31)])}, slop=0.01, every=1.0))
    assert decoded == [0, 10, 20, 30]
