"""Every number that the features depend on, in one frozen record."""

import math
import operator
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from convexperc.errors import FeatureError, InputError
from convexperc.files import placed, read_json

UNIT_LENGTH = "unit length by modality"
UNIT_SUM = "sum one by modality"
UNIT_VIEW = "unit length"
NORMALISATIONS = (UNIT_LENGTH, UNIT_SUM, UNIT_VIEW, "none")
BY_CHANNEL, JOINT = "by channel", "joint"
MOST_JOINT = 32
"""Bins a channel of a joint histogram; its columns are their cube."""
HOG_BLOCK_NORMS = ("L1", "L1-sqrt", "L2", "L2-Hys")
LBP_METHODS = ("default", "ror", "uniform", "nri_uniform")

_WHOLE = (("color_bins", 2, 256), ("hog_orientations", 1, 180), ("lbp_points", 4, 24), ("lbp_bins", 1, 2**16))
_PAIRS = (("working_size", 8, 4096), ("hog_pixels_per_cell", 1, 4096), ("hog_cells_per_block", 1, 4096))
_CHOICES = (
    ("color_histogram", (BY_CHANNEL, JOINT)),
    ("hog_block_norm", HOG_BLOCK_NORMS),
    ("lbp_method", LBP_METHODS),
    ("normalisation", NORMALISATIONS),
)


@dataclass(frozen=True)
class FeatureConfiguration:
    """What the three modalities are made of; the defaults give 24 + 1764 + 26 = 1814 columns.

    Attributes
    ----------
    working_size : tuple of int
        (height, width) in pixels that each picture is brought to; sides 8..4096. The ratio of the
        sides is not kept.
    color_histogram : {"by channel", "joint"}
        One histogram each of R, G and B, or one of all three together.
    color_bins : int
        B, bins of equal width for each of R, G, B: a divisor of 256 that is at least 2, and at most 32 where
        a joint histogram has B^3 columns. Few on purpose: the shades of one object must share bins across
        views, or the histograms of flat colours hardly overlap.
    hog_orientations : int
        Bins of the gradient's direction over 180 degrees, 1..180.
    hog_pixels_per_cell, hog_cells_per_block : tuple of int
        (rows, columns) of a cell in pixels, and of a block in cells; blocks step by one cell.
    hog_block_norm : {"L1", "L1-sqrt", "L2", "L2-Hys"}
        How each block is normalised.
    hog_transform_sqrt : bool
        Take the square root of the gray values first.
    lbp_points : int
        P, the neighbours on the circle: 4..24, at most 16 for "default" and "ror".
    lbp_radius : float
        R in pixels, at least 1; the circle must fit into the working size.
    lbp_method : {"default", "ror", "uniform", "nri_uniform"}
        How a pattern becomes a code.
    lbp_bins : int
        The number of codes: P + 2 for "uniform", P (P - 1) + 3 for "nri_uniform", else 2^P.
    normalisation : {"unit length by modality", "sum one by modality", "unit length", "none"}
        Divide each modality of a view by its Euclidean length, or by the sum of its entries; divide the whole
        view by its Euclidean length; or leave counts and HOG values alone.

    Raises
    ------
    FeatureError
        A value is of the wrong type, out of its range, or does not fit to another one.

    Notes
    -----
    Paper: Section IV
    """

    working_size: tuple[int, int] = (128, 128)
    color_histogram: str = BY_CHANNEL
    color_bins: int = 8
    hog_orientations: int = 9
    hog_pixels_per_cell: tuple[int, int] = (16, 16)
    hog_cells_per_block: tuple[int, int] = (2, 2)
    hog_block_norm: str = "L2-Hys"
    hog_transform_sqrt: bool = False
    lbp_points: int = 24
    lbp_radius: float = 3.0
    lbp_method: str = "uniform"
    lbp_bins: int = 26
    normalisation: str = UNIT_LENGTH

    def __post_init__(self) -> None:
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in _checked(given).items():
            object.__setattr__(self, name, value)
        self._check_together()

    def _check_together(self) -> None:
        if 256 % self.color_bins:
            raise FeatureError("color_bins", value=self.color_bins, must="must divide 256")
        if self.color_histogram == JOINT and self.color_bins > MOST_JOINT:
            must = f"must be at most {MOST_JOINT} for a joint histogram"
            raise FeatureError("color_bins", value=self.color_bins, must=must)
        if min(self._hog_blocks) < 1:
            must = f"must let a block of cells fit into working_size {self.working_size}"
            raise FeatureError("hog_pixels_per_cell x hog_cells_per_block", value=self._hog_blocks, must=must)
        if 2 * self.lbp_margin >= min(self.working_size):
            must = f"must let the circle fit into working_size {self.working_size}"
            raise FeatureError("lbp_radius", value=self.lbp_radius, must=must)
        if self.lbp_method in ("default", "ror") and self.lbp_points > 16:
            must = f"must be at most 16 for lbp_method {self.lbp_method!r}"
            raise FeatureError("lbp_points", value=self.lbp_points, must=must)
        codes = {"uniform": self.lbp_points + 2, "nri_uniform": self.lbp_points * (self.lbp_points - 1) + 3}
        if self.lbp_bins != codes.get(self.lbp_method, 2**self.lbp_points):
            must = f"must be {codes.get(self.lbp_method, 2**self.lbp_points)}, the number of codes"
            remedy = f"lbp_points is {self.lbp_points}, lbp_method is {self.lbp_method!r}."
            raise FeatureError("lbp_bins", value=self.lbp_bins, must=must, remedy=remedy)

    @property
    def _hog_blocks(self) -> tuple[int, int]:
        """Blocks down and across; a rest of pixels that fills no cell is left out."""
        sides = zip(self.working_size, self.hog_pixels_per_cell, self.hog_cells_per_block, strict=True)
        down, across = (pixels // cell - block + 1 for pixels, cell, block in sides)
        return down, across

    @property
    def lbp_margin(self) -> int:
        """Width in pixels of the rim that has no full circle of neighbours: R rounded up."""
        return math.ceil(self.lbp_radius)

    @property
    def modality_sizes(self) -> dict[str, int]:
        """Columns of each modality, in their order: "color", "hog", "lbp"."""
        color = self.color_bins**3 if self.color_histogram == JOINT else 3 * self.color_bins
        hog = math.prod(self._hog_blocks) * math.prod(self.hog_cells_per_block) * self.hog_orientations
        return {"color": color, "hog": hog, "lbp": self.lbp_bins}

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values by name; `from_dict` gives back an equal configuration."""
        record = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in record.items()}

    @classmethod
    def from_dict(cls, record: object) -> "FeatureConfiguration":
        """Read what `to_dict` wrote; every key must be there, so that no default can change its meaning.

        Raises
        ------
        FeatureError
            A key is unknown or missing, or a value cannot be used.
        """
        names = {field.name for field in fields(cls)}
        if not isinstance(record, Mapping) or set(record) != names:
            keys = set(record) if isinstance(record, Mapping) else set()
            remedy = f"Unknown: {sorted(map(str, keys - names))}; missing: {sorted(names - keys)}."
            must = "must be a mapping with exactly the names of a FeatureConfiguration"
            raise FeatureError("feature configuration", value=record, must=must, remedy=remedy)
        return cls(**_checked(record))


def _checked(record: Mapping[str, Any]) -> dict[str, Any]:
    """Each value by itself: its type and range; lists become tuples, NumPy's integers plain ones."""
    checked = dict(record)
    for name, low, high in _WHOLE:
        checked[name] = _whole(record[name], name, low, high)
    for name, low, high in _PAIRS:
        checked[name] = _pair(record[name], name, low, high)
    for name, allowed in _CHOICES:
        if not isinstance(record[name], str) or record[name] not in allowed:
            raise FeatureError(
                name, value=record[name], must=f"must be one of {', '.join(map(repr, allowed))}"
            )
    if not isinstance(record["hog_transform_sqrt"], bool):
        raise FeatureError(
            "hog_transform_sqrt", value=record["hog_transform_sqrt"], must="must be True or False"
        )
    checked["lbp_radius"] = _radius(record["lbp_radius"])
    return checked


def _whole(value: Any, name: str, low: int, high: int) -> int:
    must = f"must be an integer from {low} to {high}"
    if isinstance(value, bool):
        raise FeatureError(name, value=value, must=must)
    try:
        number = operator.index(value)
    except TypeError:
        raise FeatureError(name, value=value, must=must) from None
    if not low <= number <= high:
        raise FeatureError(name, value=value, must=must)
    return number


def _pair(value: Any, name: str, low: int, high: int) -> tuple[int, int]:
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise FeatureError(name, value=value, must="must be two integers, rows (height) first")
    return _whole(value[0], name, low, high), _whole(value[1], name, low, high)


def _radius(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 1 <= value < math.inf:
        raise FeatureError("lbp_radius", value=value, must="must be a finite number >= 1")
    return float(value)


def read_configuration(path: str | os.PathLike[str]) -> FeatureConfiguration:
    """Read a feature configuration: what `FeatureConfiguration.to_dict` gives, as JSON.

    Raises
    ------
    FileFormatError
        Not readable, not JSON, or values that `FeatureConfiguration.from_dict` refuses.
    """
    file, record = read_json(path)
    try:
        return FeatureConfiguration.from_dict(record)
    except InputError as error:
        raise placed(file, error) from None
