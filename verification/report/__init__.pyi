from .diff import read_report
from .write import files, store

__all__ = [
    "files",
    "read_report",
    "store",
]
