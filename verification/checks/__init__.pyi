from .catalogue import CHECKS
from .interface import Check, Observation, Player, Recorder

__all__ = [
    "CHECKS",
    "Check",
    "Observation",
    "Player",
    "Recorder",
]
