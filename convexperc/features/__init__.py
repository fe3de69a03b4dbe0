"""Three modalities of a picture: colour, shape and texture, as one row of numbers for each view.

`extract` imports scikit-image, so it is loaded when it is first asked for; the configuration is not.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from convexperc.features.configuration import FeatureConfiguration

if TYPE_CHECKING:
    from convexperc.features.extraction import extract, unit_length

__all__ = ["FeatureConfiguration", "extract", "unit_length"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("convexperc.features.extraction"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
