"""Progress without a terminal: the first and the last line of a stage, and one now and then."""

import pytest

from verification.commands import progress
from verification.commands.progress import EVERY, Lines


def test_lines_are_few_and_tell_rate_and_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    show, now = Lines(), 1000.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    show("search", 500, 1100, "0 failed")  # 500 were done by an earlier run
    for _ in range(120):
        now += 1.0
        show("search", 500 + 5 * round(now - 1000.0), 1100, "2 failed")
    show("series", 0, 3)
    told = capsys.readouterr()
    assert not told.out
    first, *between, last, other = told.err.splitlines()
    assert first == "search: 500 of 1100, 0.0/s, time left unknown; 0 failed"
    assert between[0] == "search: 650 of 1100, 5.0/s, 1.5 min left; 2 failed"
    assert len(between) == 120 / EVERY - 1, between
    assert last == "search: 1100 of 1100, 5.0/s, 0.0 min left; 2 failed"
    assert other == "series: 0 of 3, 0.0/s, time left unknown"
