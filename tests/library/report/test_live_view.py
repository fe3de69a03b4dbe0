"""The line of a moment and the live view of it."""

import io
import json
import time

import numpy as np
import pytest
from rich.console import Console

from convexperc.problem import TemplateLibrary
from convexperc.recognition import Calibration, recognize
from convexperc.report import line_text, live_view, recognition_line
from convexperc.report.tables import percents

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
ROBOTS = ("spot", "husky", "mast")


def shown(line, robots=ROBOTS, rate=None, width=100):
    """The view as text, without styles."""
    console = Console(file=io.StringIO(), width=width, force_terminal=False, emoji=False)
    console.print(live_view(line, robots, rate))
    return console.file.getvalue()


@pytest.fixture(scope="module")
def found():
    """Two robots that see the cup, of three objects."""
    rng = np.random.default_rng(0)
    O = rng.random((40, 3))
    X = np.stack([O[:, 1] + 0.05 * rng.random(40), O[:, 1] + 0.5 * rng.random(40)])
    library = TemplateLibrary(O, names=("box", "cup", "[red]hat[/red]"), modalities={"a": 25, "b": 15})
    return recognize(X, library, views=("spot", "husky"), prune=False, **LAMBDAS)


def line_of(found, judgement=None, missing=None):
    times = {"spot": 12.0, "husky": 11.97}
    absent = {"mast": "no picture within 0.05 s"} if missing is None else missing
    return recognition_line(12.0, 12 * 10**9, times, absent, found, judgement)


def test_the_view_has_what_the_line_has(found):
    line = line_of(found) | {"milliseconds": 12.34}
    text = shown(line, rate=9.87)
    lower, upper = found.template("cup").interval
    assert "cup  proved: lowest optimum" in text
    stated = next(row for row in text.splitlines() if "<= F* <=" in row).split()
    below, above = float(stated[2]), float(stated[6])
    assert below <= lower <= upper <= above, "bounds are rounded outwards"
    assert below == pytest.approx(lower, rel=1e-7)
    assert f"% below the F* of {found.runner_up}, the runner-up" in text
    assert f"explained   {percents(found.explained)} of ||o||^2 by the views" in text
    assert "time        12.000 s " in text
    assert "speed       recognised in 12.3 ms, 9.9 moments a second" in text
    rows = [row.split()[1:] for row in text.splitlines() if row.split()[1:2] and row.split()[1] in ROBOTS]
    assert [row[0] for row in rows] == ["spot", "husky", "mast"], "the order of the rows changes"
    weights = {each.name: each for each in found.ranked_views()}
    for row in rows[:2]:
        assert row[1] == f"{weights[row[0]].weight:.4f}"
        assert row[2] == f"{100 * weights[row[0]].share:.1f}"
    assert rows[1][-3:-1] == ["-30", "ms"]
    assert rows[2][1] == "missing"
    assert "mast: no picture within 0.05 s" in text


def test_what_may_be_it_is_named_where_nothing_is_proved(found):
    line = line_of(found) | {
        "verdict": "undecided",
        "label": None,
        "candidates": ["a", "b", "c", "d", "e", "f"],
    }
    assert "a or b or c or d or 2 more  undecided" in shown(line)
    assert "not certified" in shown(line | {"certified": False})


def test_a_moment_without_a_view_says_so():
    line = recognition_line(1.5, 1_500_000_000, {}, dict.fromkeys(ROBOTS, "silent"), None)
    text = shown(line)
    assert "no robot has a view" in text
    assert text.count("missing") == 3
    assert "1.500 s" in text
    assert set(line) == set(line_of(None)), "keys depend on the moment"


@pytest.mark.parametrize(
    ("nanoseconds", "zone", "said"),
    [
        (1_700_000_000_123_999_999, "UTC0", "2023-11-14 22:13:20.123"),
        (1_700_000_000_123_999_999, "CET-1CEST,M3.5.0,M10.5.0/3", "2023-11-14 23:13:20.123"),
        (10**18, "UTC0", "2001-09-09 01:46:40.000"),
        (999_999_999 * 10**9, "UTC0", "999999999.000 s"),
        (12_345_678_901, "UTC0", "12.346 s"),
        (-(10**9), "UTC0", "-1.000 s"),
        (10**19, "UTC0", "10000000000.000 s"),
    ],
)
def test_a_time_since_the_epoch_is_shown_as_local_time(monkeypatch, nanoseconds, zone, said):
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    try:
        text = shown(recognition_line(nanoseconds / 10**9, nanoseconds, {}, {}, None))
    finally:
        monkeypatch.undo()
        time.tzset()
    assert f"time        {said} " in text


def test_what_is_not_bounded_is_shown_as_infinite(found):
    line = line_of(found) | {"optimum": {"lower": 1.0, "upper": None}, "margin": None}
    assert "1 <= F* <= inf" in shown(line)


def test_the_calibration_is_in_line_and_view(found):
    judgement = Calibration.of([(found, "cup")] * 30, 0.9).judge(found)
    line = line_of(found, judgement)
    reason = "it alone is accepted"
    assert line["acceptance"] == {"verdict": "recognised", "accepted": ["cup"], "reason": reason}
    assert f"recognised (cup): {reason}" in shown(line)
    assert "not judged" in shown(line_of(found))


@pytest.mark.parametrize(
    ("accepted", "said", "color"),
    [
        (None, "cup  proved: lowest optimum", None),
        (["cup"], "cup  proved: lowest optimum", "green"),
        ([], "unknown  lowest optimum: cup", "red"),
        (["cup", "box"], "ambiguous: cup or box  lowest optimum: cup", "yellow"),
        (["box"], "accepted: box  lowest optimum: cup", "yellow"),
    ],
)
def test_only_a_label_that_is_accepted_alone_is_green(found, accepted, said, color):
    judged = None if accepted is None else {"verdict": "x", "accepted": accepted, "reason": "a reason"}
    line = line_of(found) | {"acceptance": judged}
    text = shown(line)
    assert said in text
    assert ("a reason" in text) == (judged is not None)
    console = Console(
        file=io.StringIO(), width=100, force_terminal=True, color_system="standard", emoji=False
    )
    console.print(live_view(line, ROBOTS))
    row = next(row for row in console.file.getvalue().splitlines() if "object" in row)
    codes = {"green": "\x1b[1;32m", "red": "\x1b[1;31m", "yellow": "\x1b[1;33m"}
    assert [name for name, code in codes.items() if code in row] == ([] if color is None else [color])
    assert color is not None or "\x1b[1mcup" in row, "bold"


def test_names_cannot_write_to_the_terminal(found):
    robots = ("\x1b[31mspot", "[bold]husky[/bold]", "line\nbreak")
    missing = dict.fromkeys(robots, "\u202ereason\x1b[2J")
    line = recognition_line(0.0, 0, {}, missing, found)
    text = shown(line | {"label": "[red]hat[/red]\x1b", "warnings": ["\x1b[5m"]}, robots)
    assert "\x1b" not in text
    assert "\u202e" not in text
    for part in ("[bold]husky[/bold]", "line\\nbreak", "[red]hat[/red]\\x1b"):
        assert part in text, part
    written = line_text(line)
    assert written.isascii()
    assert len(written.splitlines()) == 1
    assert list(json.loads(written)["missing"]) == list(robots)


@pytest.mark.parametrize("width", [36, 40, 50, 60, 80, 200])
def test_names_shares_and_offsets_are_whole_in_a_narrow_terminal(found, width):
    text = shown(line_of(found), width=width)
    assert "\N{HORIZONTAL ELLIPSIS}" not in text
    rows = {row.split()[1]: row.split()[2:] for row in text.splitlines() if row.split()[1:2]}
    shares = {each.name: f"{100 * each.share:.1f}" for each in found.ranked_views()}
    assert shares["spot"] in rows["spot"]
    assert shares["husky"] in rows["husky"]
    assert "-30" in rows["husky"]
    assert "missing" in rows["mast"]
    assert ("\N{FULL BLOCK}" in text) == (width >= 50)


@pytest.mark.parametrize("width", [40, 80, 200])
def test_the_view_fits_the_terminal_and_keeps_its_width(found, width):
    widths = {
        len(row) for missing in ({}, None, {"mast": "long " * 200})
        for row in shown(line_of(found, missing=missing), width=width).splitlines()
    }  # fmt: skip
    assert widths == {min(width, 80)}
