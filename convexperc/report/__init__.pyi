from . import tables
from .lines import line_text, recognition_line
from .live import live_view
from .picture import picture_kind, recognition_picture
from .proof import data_digest, proof_record
from .records import certificate_record, recognition_record, solution_record

__all__ = [
    "certificate_record",
    "data_digest",
    "line_text",
    "live_view",
    "picture_kind",
    "proof_record",
    "recognition_line",
    "recognition_picture",
    "recognition_record",
    "solution_record",
    "tables",
]
