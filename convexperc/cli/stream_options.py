"""Options of recognition from named sources, as Typer shows them."""

from pathlib import Path
from typing import Annotated

import typer

SLOP, RATE = 0.05, 30.0
"""Seconds, half the time between two frames at 10 Hz; frames a second of pictures without times."""
PANEL = "Named views and streams"
"""Heading of these options in the help."""
View = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=SOURCE",
        rich_help_panel=PANEL,
        help="A robot and where its pictures come from: a picture, a folder, a pattern, a video, camera:0, a"
        " stream's address, or BAG#/topic; repeat it for each robot.",
    ),
]
Part = Annotated[
    list[str] | None,
    typer.Option(
        "--region",
        metavar="NAME=X,Y,W,H",
        rich_help_panel=PANEL,
        help="The part of a robot's pictures with the object, in pixels from the upper left; repeatable.",
    ),
]
MaskFile = Annotated[
    list[str] | None,
    typer.Option(
        "--mask",
        metavar="NAME=FILE",
        rich_help_panel=PANEL,
        help="A picture that is 0 where a robot's pictures do not show the object; repeatable.",
    ),
]
Slop = Annotated[
    float,
    typer.Option(
        metavar="SECONDS",
        rich_help_panel=PANEL,
        help="How far the pictures of one moment may be apart from it.",
    ),
]
Every = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        rich_help_panel=PANEL,
        help="A moment each so many seconds, not at the pictures; the robots lead in the order given.",
    ),
]
Rate = Annotated[
    float,
    typer.Option(metavar="HZ", rich_help_panel=PANEL, help="Pictures a second of folders and patterns."),
]
Strict = Annotated[
    bool,
    typer.Option(
        "--strict",
        rich_help_panel=PANEL,
        help="End with exit code 2 where a picture is missing or broken, instead of leaving the robot out.",
    ),
]
Jsonl = Annotated[
    Path | None,
    typer.Option(
        "--jsonl",
        metavar="FILE",
        rich_help_panel=PANEL,
        help="Write a line of JSON for each moment to a file, not to the standard output.",
    ),
]
Results = Annotated[
    Path | None,
    typer.Option(
        "--results",
        metavar="BAG",
        rich_help_panel=PANEL,
        help="Write a ROS 2 bag with a vision_msgs/Classification of the accepted objects for each moment."
        " Needs the extra ros.",
    ),
]
Watching = Annotated[
    bool,
    typer.Option("--watch", rich_help_panel=PANEL, help="Show a stream's moments in the terminal."),
]
