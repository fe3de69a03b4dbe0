from .method import Batch, Newton, Start

__all__ = [
    "Batch",
    "Newton",
    "Start",
]
