"""What a folder of pictures holds, and what of it is left out."""

import os
import socket

import pytest

from convexperc.errors import ImageError
from convexperc.features.folders import Folder
from convexperc.features.pictures import read_image


def test_every_entry_is_a_picture_a_folder_or_left_out_with_its_reason(tmp_path):
    for name in ("b.PNG", "a.jfif", "c.gif", "d.HEIC", "notes.txt", "none", ".hidden.png"):
        (tmp_path / name).write_bytes(b"x")
    (tmp_path / "sub").mkdir()
    os.mkfifo(tmp_path / "pipe.png")
    (tmp_path / "to-nothing.txt").symlink_to(tmp_path / "missing")
    (tmp_path / "link.png").symlink_to(tmp_path / "b.PNG")
    found = Folder.of(tmp_path)
    assert [path.name for path in found.pictures] == ["a.jfif", "b.PNG", "link.png"]
    assert [path.name for path in found.folders] == ["sub"]
    assert dict(found.others) == {
        "c.gif": "GIF is not read; convert it to PNG",
        "d.HEIC": "HEIC is not read; convert it to PNG",
        "none": "no picture by its name",
        "notes.txt": "no picture by its name",
        "pipe.png": "not a file",
        "to-nothing.txt": "a link to nothing",
    }


@pytest.mark.parametrize("target", ["missing.png", "cup.png"])
def test_a_link_to_nothing_or_itself_named_like_a_picture_is_one_so_that_reading_it_fails(tmp_path, target):
    (tmp_path / "cup.png").symlink_to(tmp_path / target)
    assert [path.name for path in Folder.of(tmp_path).pictures] == ["cup.png"]
    with pytest.raises(ImageError, match=r"cup\.png must be a readable file"):
        read_image(tmp_path / "cup.png")


def test_a_socket_and_a_link_to_itself_are_left_out(tmp_path):
    with socket.socket(socket.AF_UNIX) as door:
        door.bind(os.fspath(tmp_path / "door.png"))
        (tmp_path / "loop").symlink_to(tmp_path / "loop")
        assert [name for name, _ in Folder.of(tmp_path).others] == ["door.png", "loop"]


@pytest.mark.parametrize("name", ["missing", "file"])
def test_what_is_no_folder_is_refused(tmp_path, name):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(ImageError, match="must be a readable folder"):
        Folder.of(tmp_path / name)
