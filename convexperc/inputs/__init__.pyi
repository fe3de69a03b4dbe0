from .frames import Frame, Source
from .grammar import GRAMMAR
from .opening import open_source, open_sources
from .regions import Region, cropped, masked, read_mask
from .results import Hypothesis, ResultBag
from .synchronisation import Moment, Moments, moments
from .tracks import Counts

__all__ = [
    "GRAMMAR",
    "Counts",
    "Frame",
    "Hypothesis",
    "Moment",
    "Moments",
    "Region",
    "ResultBag",
    "Source",
    "cropped",
    "masked",
    "moments",
    "open_source",
    "open_sources",
    "read_mask",
]
