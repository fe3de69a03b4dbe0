from .decision import Decision
from .label import decide, decided_by, recognize, recognize_path
from .recognition import Ranked, Recognition, Template, Verdict
from .references import References, SampleScene, perceive, read_pictures, sample_names, sample_scene

__all__ = [
    "Decision",
    "Ranked",
    "Recognition",
    "References",
    "SampleScene",
    "Template",
    "Verdict",
    "decide",
    "decided_by",
    "perceive",
    "read_pictures",
    "recognize",
    "recognize_path",
    "sample_names",
    "sample_scene",
]
