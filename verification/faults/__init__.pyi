from .fault import Fault
from .hunt import Caught
from .own import COST, FAULTS
from .table import planted

__all__ = [
    "COST",
    "FAULTS",
    "Caught",
    "Fault",
    "planted",
]
