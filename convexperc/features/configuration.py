"""All parameters of the features, in one frozen record."""

import math
import operator
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from convexperc.errors import FeatureError, InputError
from convexperc.features.network.provenance import COLUMNS, checked_name, name_in, record_of
from convexperc.files import placed, read_json

UNIT_LENGTH = "unit length by modality"
UNIT_SUM = "sum one by modality"
UNIT_VIEW = "unit length"
NORMALISATIONS = (UNIT_LENGTH, UNIT_SUM, UNIT_VIEW, "none")
BY_CHANNEL, JOINT = "by channel", "joint"
MAX_JOINT_BINS = 32
"""Largest number of bins for each channel of a joint histogram, whose columns are its cube, 32,768."""
HOG_BLOCK_NORMS = ("L1", "L1-sqrt", "L2", "L2-Hys")
"""Those of scikit-image's ``hog``."""
LBP_METHODS = ("default", "ror", "uniform", "nri_uniform")
"""Those of scikit-image's ``local_binary_pattern`` that give codes."""

# Names of the integers, each with its least and greatest value.
_INTEGERS = (
    ("color_bins", 2, 256),
    ("hog_orientations", 1, 180),
    ("lbp_points", 4, 24),
    ("lbp_bins", 1, 2**16),
)
# Likewise for pairs.
_PAIRS = (("working_size", 8, 4096), ("hog_pixels_per_cell", 1, 4096), ("hog_cells_per_block", 1, 4096))
_CHOICES = (
    ("color_histogram", (BY_CHANNEL, JOINT)),
    ("hog_block_norm", HOG_BLOCK_NORMS),
    ("lbp_method", LBP_METHODS),
    ("normalisation", NORMALISATIONS),
)


@dataclass(frozen=True)
class FeatureConfiguration:
    """The parameters of the modalities; the defaults give three, 24 + 1764 + 26 = 1814 columns.

    Attributes
    ----------
    working_size : tuple of int
        (height, width) in pixels to which each picture is resized; sides 8..4096. The aspect ratio is
        not preserved.
    color_histogram : {"by channel", "joint"}
        One histogram each of R, G and B, or one of all three together.
    color_bins : int
        B, bins of equal width for each of R, G, B: a divisor of 256 that is at least 2, and at most 32 for a
        joint histogram, which has B^3 columns. Wide bins are intended: the shades of one object should fall
        into the same bins in all views, otherwise the histograms of flat colours hardly overlap.
    hog_orientations : int
        Bins of the gradient's direction over 180 degrees, 1..180.
    hog_pixels_per_cell, hog_cells_per_block : tuple of int
        (rows, columns) of a cell in pixels, and of a block in cells; blocks step by one cell.
    hog_block_norm : {"L1", "L1-sqrt", "L2", "L2-Hys"}
        Normalisation of each block.
    hog_transform_sqrt : bool
        Whether to take the square root of the gray values first.
    lbp_points : int
        P, the number of neighbours on the circle: 4..24, at most 16 for "default" and "ror".
    lbp_radius : float
        R in pixels, at least 1; the circle must fit into the working size.
    lbp_method : {"default", "ror", "uniform", "nri_uniform"}
        How a pattern is mapped to a code.
    lbp_bins : int
        The number of codes: P + 2 for "uniform", P (P - 1) + 3 for "nri_uniform", else 2^P.
    normalisation : {"unit length by modality", "sum one by modality", "unit length", "none"}
        Divide each modality of a view by its Euclidean length, or by the sum of its entries; divide the whole
        view by its Euclidean length; or leave counts, HOG values and means unchanged.
    network : {None, "efficientnet-lite0"}
        The pretrained network whose features are a fourth modality, "cnn", of 1280 columns (see
        `network_features`); it needs the extra ``cnn``. None: there is no fourth.

    Raises
    ------
    FeatureError
        A value has the wrong type, is out of range, or contradicts another one.

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
    network: str | None = None

    def __post_init__(self) -> None:
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in _checked(given).items():
            object.__setattr__(self, name, value)
        self._check_together()

    def _check_together(self) -> None:
        if 256 % self.color_bins:
            raise FeatureError("color_bins", value=self.color_bins, must="must divide 256")
        if self.color_histogram == JOINT and self.color_bins > MAX_JOINT_BINS:
            must = f"must be at most {MAX_JOINT_BINS} for a joint histogram"
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
        """Numbers of blocks down and across; remaining pixels that do not fill a cell are ignored."""
        sides = zip(self.working_size, self.hog_pixels_per_cell, self.hog_cells_per_block, strict=True)
        down, across = (pixels // cell - block + 1 for pixels, cell, block in sides)
        return down, across

    @property
    def lbp_margin(self) -> int:
        """Width in pixels of the border whose pixels lack some neighbours: R rounded up."""
        return math.ceil(self.lbp_radius)

    @property
    def modality_sizes(self) -> dict[str, int]:
        """Number of columns of each modality, in the order "color", "hog", "lbp" and, if any, "cnn"."""
        color = self.color_bins**3 if self.color_histogram == JOINT else 3 * self.color_bins
        hog = math.prod(self._hog_blocks) * math.prod(self.hog_cells_per_block) * self.hog_orientations
        sizes = {"color": color, "hog": hog, "lbp": self.lbp_bins}
        return sizes if self.network is None else sizes | {"cnn": COLUMNS}

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values by name; `from_dict` restores an equal configuration.

        Without a network there is no key "network". With one, its value is a mapping: the network's name, the
        package that holds its weights, with version and licence, and the SHA-256 of the weights.
        """
        record = {field.name: getattr(self, field.name) for field in fields(self)}
        network = record.pop("network")
        plain = {name: list(value) if isinstance(value, tuple) else value for name, value in record.items()}
        return plain if network is None else plain | {"network": record_of(network)}

    @classmethod
    def from_dict(cls, record: object) -> "FeatureConfiguration":
        """Return the configuration that `to_dict` wrote; every key is required, but "network".

        Raises
        ------
        FeatureError
            A key is unknown or missing, or a value is invalid; the features are those of a network with other
            weights than this version of the library uses.
        """
        names = {field.name for field in fields(cls)}
        keys = set(record) if isinstance(record, Mapping) else set()
        if not isinstance(record, Mapping) or keys | {"network"} != names:
            missing = names - keys - {"network"}
            remedy = f"Unknown: {sorted(map(str, keys - names))}; missing: {sorted(missing)}."
            must = "must be a mapping with exactly the names of a FeatureConfiguration"
            raise FeatureError("feature configuration", value=record, must=must, remedy=remedy)
        network = name_in(record["network"]) if "network" in record else None
        return cls(**_checked({**record, "network": network}))


def _checked(record: Mapping[str, Any]) -> dict[str, Any]:
    """Validate the type and range of each value; lists become tuples, and NumPy integers become int."""
    checked = dict(record)
    for name, low, high in _INTEGERS:
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
    checked["network"] = checked_name(record["network"])
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
    known = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not known or not 1 <= value <= sys.float_info.max:  # which a long integer may exceed
        raise FeatureError("lbp_radius", value=value, must="must be a finite number >= 1")
    return float(value)


def read_configuration(path: str | os.PathLike[str]) -> FeatureConfiguration:
    """Read a feature configuration from a JSON file in the format of `FeatureConfiguration.to_dict`.

    Raises
    ------
    FileFormatError
        The file is not readable or not JSON, or `FeatureConfiguration.from_dict` refuses its values.
    """
    file, record = read_json(path)
    try:
        return FeatureConfiguration.from_dict(record)
    except InputError as error:
        raise placed(file, error) from None
