from .design import Design
from .record.reading import Experiments, packaged, read_experiments

__all__ = [
    "Design",
    "Experiments",
    "packaged",
    "read_experiments",
]
