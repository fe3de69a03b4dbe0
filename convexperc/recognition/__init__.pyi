from .decision import Decision
from .label import Options, decide, decided_by, recognize, recognize_path
from .narrowing import narrowed_answers
from .recognition import Ranked, Recognition, Template, Verdict
from .references import NamedPictures, References, perceive, read_pictures
from .sample import SampleScene, sample_names, sample_scene
from .warming import warm

__all__ = [
    "Decision",
    "NamedPictures",
    "Options",
    "Ranked",
    "Recognition",
    "References",
    "SampleScene",
    "Template",
    "Verdict",
    "decide",
    "decided_by",
    "narrowed_answers",
    "perceive",
    "read_pictures",
    "recognize",
    "recognize_path",
    "sample_names",
    "sample_scene",
    "warm",
]
