from .loop import run
from .systems import LinearSolver, OnSingular, SingularSystemError
from .trace import PaperTrace, Stop
from .variants import (
    ABSOLUTE,
    APPENDIX_FULL,
    APPENDIX_HALF,
    CORRECTED,
    PRINTED,
    SMOOTHED,
    VARIANTS,
    Order,
    UpdateVariant,
    smoothed,
)

__all__ = [
    "ABSOLUTE",
    "APPENDIX_FULL",
    "APPENDIX_HALF",
    "CORRECTED",
    "PRINTED",
    "SMOOTHED",
    "VARIANTS",
    "LinearSolver",
    "OnSingular",
    "Order",
    "PaperTrace",
    "SingularSystemError",
    "Stop",
    "UpdateVariant",
    "run",
    "smoothed",
]
