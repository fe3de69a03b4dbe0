from .confirmation import Confirmation
from .files import catalogue, load, load_all, save, schema
from .found import case_record, rise_record
from .kinds import confirm
from .record import Record, parse

__all__ = [
    "Confirmation",
    "Record",
    "case_record",
    "catalogue",
    "confirm",
    "load",
    "load_all",
    "parse",
    "rise_record",
    "save",
    "schema",
]
