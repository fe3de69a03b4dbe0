"""The journal: what was put is read back, and nothing else is believed."""

import json
from pathlib import Path

import pytest

from convexperc.errors import FileFormatError
from verification.journal import Journal, read_head

HEAD = {"seed": 3, "versions": {"numpy": "2"}}
ENTRIES = {f"shard {k}": {"failed": k, "worst": 0.1 * k, "cases": [[k, "0x1p+0"]]} for k in range(4)}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A journal of four entries."""
    journal = Journal(tmp_path / "made" / "run.jsonl", HEAD)
    for name, entry in ENTRIES.items():
        journal.put(name, entry)
    return tmp_path / "made" / "run.jsonl"


def test_what_was_put_is_read_back_in_order(file: Path) -> None:
    again = Journal(file, HEAD)
    assert list(again.entries.items()) == list(ENTRIES.items())
    again.put("another", {"failed": 9})
    assert Journal(file, HEAD).entries == ENTRIES | {"another": {"failed": 9}}
    assert read_head(file) == HEAD


@pytest.mark.parametrize("cut", [1, 20])
def test_a_line_that_was_cut_off_is_dropped_and_can_be_written_again(file: Path, cut: int) -> None:
    file.write_bytes(file.read_bytes()[: -1 - cut])
    journal = Journal(file, HEAD)
    assert list(journal.entries) == list(ENTRIES)[:-1], journal.entries
    journal.put("shard 3", ENTRIES["shard 3"])
    assert Journal(file, HEAD).entries == ENTRIES


def test_a_changed_line_is_not_believed(file: Path) -> None:
    lines = file.read_text().splitlines(keepends=True)
    changed = lines[2].replace('"failed":1', '"failed":0')
    assert changed != lines[2], lines[2]
    file.write_text("".join([*lines[:2], changed, *lines[3:]]))
    assert list(Journal(file, HEAD).entries) == ["shard 0", "shard 2", "shard 3"]


def test_a_journal_of_another_head_is_set_aside(file: Path) -> None:
    text = file.read_bytes()
    assert not Journal(file, HEAD | {"seed": 4}).entries
    assert file.with_name("run.jsonl.old").read_bytes() == text
    assert read_head(file)["seed"] == 4


def test_a_finished_journal_is_continued_only_if_it_is_reopened(file: Path) -> None:
    Journal(file, HEAD).finish()
    text = file.read_bytes()
    assert Journal(file, HEAD, reopen=True).entries == ENTRIES
    assert Journal(file, HEAD).entries == ENTRIES, (
        "a reopened journal is finished again by whoever reopened it"
    )
    file.write_bytes(text)
    assert not Journal(file, HEAD).entries
    assert file.with_name("run.jsonl.old").read_bytes() == text


def test_what_json_cannot_hold_is_refused(file: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        Journal(file, HEAD).put("infinite", float("inf"))
    assert Journal(file, HEAD).entries == ENTRIES


@pytest.mark.parametrize("text", ["", "{}\n", json.dumps({"head": HEAD})])
def test_a_file_that_is_no_journal_has_no_head(tmp_path: Path, text: str) -> None:
    (tmp_path / "other.json").write_text(text)
    with pytest.raises(FileFormatError, match="must be the journal of a run"):
        read_head(tmp_path / "other.json")
