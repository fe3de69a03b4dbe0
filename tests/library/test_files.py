"""Outputs that are an input or one another, by every way to name a file."""

import os
from pathlib import Path

import pytest

from convexperc.errors import InputError
from convexperc.files import check_apart


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a file, links to it, and a folder of pictures; it is the working directory."""
    (tmp_path / "in.json").write_text("{}")
    (tmp_path / "soft.json").symlink_to("in.json")
    os.link(tmp_path / "in.json", tmp_path / "hard.json")
    (tmp_path / "seen" / "deep").mkdir(parents=True)
    (tmp_path / "link").symlink_to("seen")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("spelling", ["in.json", "./in.json", "seen/../in.json", "soft.json", "hard.json"])
def test_a_file_that_is_read_is_not_written(folder, spelling):
    for name in (Path(spelling), folder / spelling):
        with pytest.raises(InputError, match=r"--json must be another file than PROBLEM; got '.*json'"):
            check_apart({"--json": name}, inputs={"PROBLEM": Path("in.json")})


@pytest.mark.parametrize("name", ["in.json", "seen", "link"])
def test_an_existing_file_of_another_case_is_that_file_only_where_the_system_says_so(folder, name):
    other = Path(name.upper())
    same = other.exists()
    try:
        check_apart({"--json": other}, inputs={"PROBLEM": Path(name)})
    except InputError:
        assert same
    else:
        assert not same


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("new.json", "./new.json"),
        ("new.json", "seen/../new.json"),
        ("seen/new.json", "link/new.json"),
        ("new.json", "dangling.json"),
        ("new.json", "NEW.json"),
        ("caf\u00e9.json", "cafe\u0301.json"),
        ("new/deep.json", "New/deep.json"),
        ("soft.json", "hard.json"),
    ],
)
def test_two_outputs_are_not_one_file(folder, one, other):
    (folder / "dangling.json").symlink_to("new.json")
    with pytest.raises(InputError, match="--proof must be another file than --json"):
        check_apart({"--json": Path(one), "--proof": Path(other)})


@pytest.mark.parametrize("place", ["seen/a.png", "link/a.png", "seen/deep/../a.png"])
def test_a_file_is_not_written_among_those_that_are_read(folder, place):
    with pytest.raises(InputError, match="--picture must not lie in the folder of --views, which is read"):
        check_apart({"--picture": Path(place)}, inputs={"--views": Path("seen")})


def test_a_file_that_an_entry_of_a_folder_leads_to_is_not_written(folder):
    (folder / "seen" / "a.json").symlink_to(folder / "in.json")
    with pytest.raises(InputError, match="--json must not lie in the folder of --views"):
        check_apart({"--json": Path("in.json")}, inputs={"--views": Path("seen")})
    (folder / "seen" / "a.json").unlink()
    check_apart({"--json": Path("in.json")}, inputs={"--views": Path("seen")})


@pytest.mark.parametrize("place", ["in.json", "hard.json"])
def test_an_input_may_be_several_files(folder, place):
    with pytest.raises(InputError, match="--json must be another file than --view a"):
        check_apart({"--json": Path(place)}, inputs={"--view a": [Path("seen/x"), Path("in.json")]})


@pytest.mark.parametrize(
    ("filled", "read"),
    [("seen", "seen"), ("link/new", "seen"), (".", "in.json"), ("seen", "link/deep"), (".", "seen/deep")],
)
def test_a_folder_that_is_filled_and_what_is_read_lie_apart(folder, filled, read):
    with pytest.raises(InputError, match="DIR must neither contain --meshes nor lie in it"):
        check_apart({}, folders={"DIR": Path(filled)}, inputs={"--meshes": Path(read)})


def test_a_folder_that_is_filled_holds_no_other_output(folder):
    with pytest.raises(InputError, match="the figures must neither contain the page nor lie in it"):
        check_apart({"the page": Path("new/a.html")}, folders={"the figures": Path("new")})
    with pytest.raises(InputError, match="b must neither contain a nor lie in it"):
        check_apart({}, folders={"a": Path("new"), "b": Path("NEW/deep")})


def test_what_lies_apart_is_allowed_and_nothing_is_created(folder):
    before = sorted(folder.rglob("*"))
    check_apart(
        {"--json": Path("out.json"), "--proof": Path("new/out.json"), "--picture": None},
        folders={"DIR": Path("sets")},
        inputs={"PROBLEM": Path("in.json"), "--views": Path("seen"), "--references": None},
    )
    check_apart({"--json": Path("seen/deep/out.json")}, inputs={"--views": Path("link")})
    check_apart({"--json": Path("a\0b")}, inputs={"PROBLEM": Path("in.json")})  # refused when it is used
    assert sorted(folder.rglob("*")) == before
