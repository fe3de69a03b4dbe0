"""Replays: every record as a table of at most 100 columns and a plot; stale ones say so."""

import io
import xml.etree.ElementTree as ET
from dataclasses import replace

import matplotlib.image
import pytest
from rich.console import Console

from convexperc.errors import InputError
from verification.checks.catalogue import CHECKS
from verification.counterexamples.files import catalogue
from verification.counterexamples.replay import WIDTH, Replay, replay

CHECKED = {check.name: check for check in CHECKS}
RECORDS = {record.id: record for record in catalogue()}


def shown(of: Replay) -> str:
    stream = io.StringIO()
    console = Console(file=stream, width=WIDTH, color_system=None)
    for line in of.text():
        console.print(line, markup=False)
    console.print(of.table())
    return stream.getvalue()


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_is_shown_within_the_width(name: str) -> None:
    of = replay(RECORDS[name], CHECKED)
    assert not of.stale, of.verdict
    text = shown(of)
    assert max(map(len, text.splitlines())) <= WIDTH, text
    assert "confirmed: " in text, text
    assert RECORDS[name].part in text, text
    assert "..." not in text.split(name, 1)[1], text
    wanted = len(of.result.lines) or len(of.result.sides)
    assert wanted > 0 or RECORDS[name].kind == "case", of.result
    assert len(of.rows) == len(of.result.lines), of.rows


def test_a_rise_is_told_iteration_by_iteration() -> None:
    of = replay(RECORDS["rise-printed-gauss-seidel"], {})
    assert [(row.iteration, row.w, row.u, row.F, row.remark) for row in of.rows] == [
        (0, "(-1)", "(-1)", "1", ""),
        (1, "(-8/7)", "(-8/7)", "57/49", "rises"),
    ]
    assert of.rows[1].excess == pytest.approx(57 / 49 - 0.75, rel=1e-12), of.rows
    text = shown(of)
    for part in ("57/49", "1.163265306", "4.133e-01", "rises", "F* = 0.75", "X = [1], o = [-1]"):
        assert part in text, (part, text)


@pytest.mark.parametrize(
    ("name", "remark"),
    [("locked-w-jacobi", "locked"), ("singular-w-printed", "singular next"), ("limit-printed-sign", "stays")],
)
def test_the_table_says_what_happens(name: str, remark: str) -> None:
    assert remark in shown(replay(RECORDS[name], {}))


def test_two_sides_come_with_their_difference() -> None:
    text = shown(replay(RECORDS["l1-analogue"], {}))
    lines = [line.split() for line in text.splitlines()]
    assert ["difference", "1/2", "0.5"] in lines, text


def test_a_stale_record_says_so() -> None:
    record = RECORDS["rise-absolute-jacobi"]
    mended = replay(replace(record, fields=dict(record.fields) | {"reading": "corrected"}), {})
    assert mended.stale, mended.verdict
    assert mended.verdict.startswith("stale: "), mended.verdict
    assert "stale: " in shown(mended)
    assert mended.plot("svg").startswith(b"<?xml")
    other = replay(record.expecting(dict(record.expect) | {"rise": "1"}), {})
    assert other.stale, other.verdict
    assert "not what the record expects of rise" in other.verdict, other.verdict


@pytest.mark.parametrize("name", ["rise-absolute-visible", "derivative-w-sign", "limit-smoothed-default-eps"])
def test_the_plot_is_the_same_bytes_again(name: str) -> None:
    of = replay(RECORDS[name], {})
    svg, png = of.plot("svg"), of.plot("png")
    assert (svg, png) == (of.plot("svg"), of.plot("png"))
    root = ET.fromstring(svg)
    assert root.tag.endswith("svg"), root.tag
    assert len(svg) < 60_000, len(svg)
    for word in (b"<dc:date>", b"<script", b"matplotlib.org"):
        assert word not in svg, word
    picture = matplotlib.image.imread(io.BytesIO(png))
    assert picture.shape[0] > 300, picture.shape
    assert picture.std() > 0.01, "the picture is empty"


def test_a_rise_is_marked_in_the_plot() -> None:
    marked, plain = (
        replay(RECORDS[name], {}).plot("svg") for name in ("rise-absolute-visible", "locked-w-jacobi")
    )
    assert b"#b3261e" in marked
    assert b"#b3261e" not in plain


def test_another_kind_of_plot_is_refused() -> None:
    with pytest.raises(InputError, match="must be one of svg, png"):
        replay(RECORDS["l1-analogue"], {}).plot("gif")
