from .method import Batch, Newton

__all__ = [
    "Batch",
    "Newton",
]
