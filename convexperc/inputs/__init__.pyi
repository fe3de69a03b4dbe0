from .frames import Frame, Source
from .grammar import GRAMMAR
from .messages import compressed_picture, image_picture
from .opening import open_source, open_sources, read_places
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
    "ResultBag",
    "Source",
    "compressed_picture",
    "image_picture",
    "moments",
    "open_source",
    "open_sources",
    "read_places",
]
