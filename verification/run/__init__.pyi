from .stages import Options, Run, gather

__all__ = [
    "Options",
    "Run",
    "gather",
]
