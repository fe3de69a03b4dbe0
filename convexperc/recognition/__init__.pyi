from .calibration import (
    Acceptance,
    Calibration,
    Counts,
    Judgement,
    Origin,
    calibrated,
    counted,
    fewest_scenes,
    read_calibration,
)
from .decision import Decision
from .each_view import EachView
from .frames import Frames, Regions
from .held_out import held_out_scenes
from .label import Options, decide, decided_by, recognize, recognize_path
from .narrowing import narrowed_answers
from .recognition import Ranked, Recognition, Template, Verdict
from .references import (
    NamedPictures,
    ReferencePictures,
    References,
    left_out,
    perceive,
    read_pictures,
    read_references,
    read_scenes,
)
from .rules import Rules
from .sample import SampleScene, sample_names, sample_scene
from .warming import warm

__all__ = [
    "Acceptance",
    "Calibration",
    "Counts",
    "Decision",
    "EachView",
    "Frames",
    "Judgement",
    "NamedPictures",
    "Options",
    "Origin",
    "Ranked",
    "Recognition",
    "ReferencePictures",
    "References",
    "Regions",
    "Rules",
    "SampleScene",
    "Template",
    "Verdict",
    "calibrated",
    "counted",
    "decide",
    "decided_by",
    "fewest_scenes",
    "held_out_scenes",
    "left_out",
    "narrowed_answers",
    "perceive",
    "read_calibration",
    "read_pictures",
    "read_references",
    "read_scenes",
    "recognize",
    "recognize_path",
    "sample_names",
    "sample_scene",
    "warm",
]
