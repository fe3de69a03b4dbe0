"""A run of three robots, made of the package's sample: a ROS 2 bag, and a picture of its live view.

python tests/made_up_robots.py docs/live.svg
"""

import io
import json
import os
import re
import sys
import time
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table
from typer.testing import CliRunner

from convexperc.cli.main import app
from convexperc.recognition import sample_scene
from convexperc.report import live_view

START = 1_700_000_000 * 10**9 + 123_456_789
"""Nanoseconds of the first moment."""
STEP = 10**8
"""Nanoseconds from one moment to the next."""
OFFSETS = {"husky-1": 0, "husky-2": 12_000_000, "spot": -8_000_000}
"""Nanoseconds by which each robot's camera is late."""
VIEWS = {
    "ica-sign": {"husky-1": "robot-4", "husky-2": "robot-3", "spot": "robot-1"},
    "gray-car": {"husky-1": "robot-4", "husky-2": "robot-2", "spot": "robot-5"},
}
"""Which of the sample's robots each of these three is, by scene."""
MOMENTS = 12
SILENT = {"spot": (3, 4, 5)}
"""Moments at which a robot's camera gives nothing."""
DARK = {"husky-2": (8, 9)}
"""Moments at which a robot's frame cannot be read."""


def scene_at(moment: int) -> str:
    """The object that all of them look at."""
    return "ica-sign" if moment < 7 else "gray-car"


def frames() -> Iterator[tuple[str, int, bytes]]:
    """Robot, time and JPEG of each frame, with a little noise, in the order of the moments."""
    scenes = {name: sample_scene(name).views for name in VIEWS}
    for moment in range(MOMENTS):
        scene = scene_at(moment)
        for place, (robot, offset) in enumerate(OFFSETS.items()):
            if moment in SILENT.get(robot, ()):
                continue
            noise = np.random.default_rng(10 * moment + place).normal(0.0, 3.0, (144, 192, 3))
            picture = np.clip(scenes[scene][VIEWS[scene][robot]] + noise, 0, 255).astype(np.uint8)
            done, data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
            assert done
            stored = data.tobytes()
            if moment in DARK.get(robot, ()):
                stored = stored[: len(stored) // 3]
            yield robot, START + moment * STEP + offset, stored


def topic(robot: str) -> str:
    return f"/{robot}/camera/image/compressed"


def write_bag(folder: Path) -> Path:
    """Write the run as a ROS 2 bag, a new folder."""
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415 - an extra
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = "sensor_msgs/msg/CompressedImage"
    image, header, stamp = (
        store.types[name] for name in (kind, "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    with Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        topics = {robot: bag.add_connection(topic(robot), kind, typestore=store) for robot in OFFSETS}
        for robot, nanoseconds, data in frames():
            said = header(stamp(*divmod(nanoseconds, 10**9)), f"{robot}_camera")
            message = image(said, "jpeg", np.frombuffer(data, np.uint8))
            bag.write(topics[robot], nanoseconds + 3_000_000, store.serialize_cdr(message, kind))
    return folder


def write_references(folder: Path) -> Path:
    """Write the pictures of the sample's objects."""
    folder.mkdir()
    for name, picture in sample_scene("ica-sign").references.items():
        assert cv2.imwrite(str(folder / f"{name}.png"), picture[..., ::-1])
    return folder


def views(bag: Path) -> list[str]:
    """The options that name the robots."""
    return [part for robot in OFFSETS for part in ("--view", f"{robot}={bag}#{topic(robot)}")]


SHOWN = (2, 4, 7, 8)
"""Moments of the picture: all well, a robot without frames, another object, a frame that cannot be read."""


def draw(lines: list[dict[str, Any]]) -> str:
    """Draw the live view at `SHOWN`, side by side, as SVG without fonts from elsewhere."""
    console = Console(
        record=True, width=162, file=io.StringIO(), force_terminal=True, color_system="truecolor"
    )
    grid = Table.grid(padding=(0, 2))
    for first in range(0, len(SHOWN), 2):
        grid.add_row(*(live_view(lines[moment], OFFSETS) for moment in SHOWN[first : first + 2]))
    console.print(grid)
    svg = console.export_svg(title="convexperc recognize --watch", unique_id="live")
    return re.sub(r"@font-face \{.*?\}\s*", "", svg, flags=re.DOTALL)


def main(target: str) -> None:
    """Recognise the run, and draw what the live view shows, in UTC; times of this machine are left out."""
    os.environ["TZ"] = "UTC"
    time.tzset()
    with TemporaryDirectory() as name, chdir(name):
        write_references(Path("known"))
        arguments = ["recognize", "--references", "known", *views(write_bag(Path("run")))]
        done = CliRunner().invoke(app, [*arguments, "--jsonl", "lines.jsonl"])
        assert done.exit_code in (0, 1), done.output
        lines = [json.loads(line) for line in Path("lines.jsonl").read_text().splitlines()]
    drawn = draw([line | {"milliseconds": None} for line in lines])
    Path(target).write_text(drawn, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
