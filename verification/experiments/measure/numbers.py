"""Numbers as the record has them: six significant digits, no negative zero, nothing that is no number."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

DIGITS = 6


def rounded(data: Any, digits: int = DIGITS) -> Any:
    """Plain JSON values of the same shape, each float rounded.

    Parameters
    ----------
    data : mapping, sequence, array or scalar
    digits : int
        Significant digits.

    Raises
    ------
    ValueError
        A number is infinite or NaN.
    """
    if isinstance(data, Mapping):
        return {name: rounded(value, digits) for name, value in data.items()}
    if isinstance(data, (np.ndarray, np.generic)):
        return rounded(data.tolist(), digits)
    if isinstance(data, (list, tuple)):
        return [rounded(value, digits) for value in data]
    if isinstance(data, float):
        if not math.isfinite(data):
            raise ValueError(f"{data} cannot be recorded")
        return float(f"{data:.{digits}g}") + 0.0
    return data
