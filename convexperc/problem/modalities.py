"""The partition of the columns of X into named modalities."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.caching import cached_property
from convexperc.errors import ModalityError, entries, is_integer
from convexperc.problem.arrays import euclidean_length
from convexperc.problem.conversion import refuse_mask

Columns = slice | NDArray[np.int64]
CHUNK = 4096
"""Columns that are multiplied at a time: a product's rounding grows with the length of its sums."""
REMEDY = "Give each modality at least one column, and each column exactly one modality."


@dataclass(frozen=True, eq=False)
class Modalities:
    """m named groups of columns: every column belongs to one of them.

    Attributes
    ----------
    names : tuple of str
        One name a modality, all different.
    columns : tuple of slice or int array
        The columns of each modality; a slice wherever they are contiguous and ascending.
    d : int
        Number of columns in all.

    Notes
    -----
    Paper: Section III-A, d = sum_i d_i.
    """

    names: tuple[str, ...]
    columns: tuple[Columns, ...]
    d: int

    @classmethod
    def of(cls, spec: Any, d: int) -> "Modalities":
        """Read a partition of `d` columns from any of its usual forms.

        Parameters
        ----------
        spec : Modalities, sequence of int, mapping, or None
            ``[20, 15, 5]`` sizes, named m1, m2, ...; ``{"color": 20, "hog": 15}`` sizes in order;
            ``{"color": [0, 2], "hog": [1, 3]}`` or slices: the columns themselves; ``None``: one
            modality of all columns.
        d : int
            Number of columns of X.

        Raises
        ------
        ModalityError
            A modality is empty, two overlap, a column is missing or out of range, or a size is not an
            integer >= 1.
        """
        if isinstance(spec, Modalities):
            if spec.d != d:
                raise ModalityError("modalities", value=spec.d, must=f"must cover the {d} columns of X")
            return spec
        if spec is None:
            spec = [d]
        if isinstance(spec, np.ma.MaskedArray):
            refuse_mask(spec, "modalities", ModalityError)
        if isinstance(spec, np.ndarray):
            spec = spec.tolist()
        if isinstance(spec, Mapping):
            names, parts = tuple(spec.keys()), tuple(spec.values())
        elif isinstance(spec, Sequence) and not isinstance(spec, str):
            names, parts = tuple(f"m{i}" for i in range(1, len(spec) + 1)), tuple(spec)
        else:
            must = "must be sizes, a mapping of names to sizes or columns, or None"
            raise ModalityError("modalities", value=spec, must=must)
        _check_names(names)
        return cls(names, _partition(names, parts, d), d)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for columns in self.columns:
            if isinstance(columns, np.ndarray):
                columns.flags.writeable = False

    def __len__(self) -> int:
        return len(self.columns)

    def __iter__(self) -> Iterator[Columns]:
        return iter(self.columns)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of columns d_i of each modality."""
        return tuple(len(range(*c.indices(self.d))) if isinstance(c, slice) else c.size for c in self.columns)

    @cached_property
    def chunks(self) -> tuple[tuple[Columns, ...], ...]:
        """The columns of each modality, at most `CHUNK` at a time."""
        return tuple(tuple(_chunks(columns, self.d)) for columns in self.columns)

    def norms(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """||u^i||_2 of each modality, shape (m,), safe against overflow and underflow."""
        return np.array([euclidean_length(u[c]) for c in self.columns])

    def same(self, other: "Modalities") -> bool:
        """Whether the other has the same groups of columns in the same order, whatever their names."""
        return len(self) == len(other) and all(
            np.array_equal(np.r_[a], np.r_[b]) for a, b in zip(self, other, strict=True)
        )

    def permuted(self, order: Sequence[int]) -> "Modalities":
        """The same groups of columns, listed in another order.

        Raises
        ------
        ModalityError
            The order does not name each group once, by its place.
        """
        places = list(entries(order, "order", ModalityError))
        if not all(map(is_integer, places)) or sorted(places) != list(range(len(self))):
            must = f"must name each of 0 .. {len(self) - 1} once"
            raise ModalityError("order", value=order, must=must)
        order = places
        return Modalities(tuple(self.names[i] for i in order), tuple(self.columns[i] for i in order), self.d)


def _chunks(columns: Columns, d: int) -> Iterator[Columns]:
    if not isinstance(columns, slice):
        yield from (columns[first : first + CHUNK] for first in range(0, columns.size, CHUNK))
        return
    start, stop, _ = columns.indices(d)
    for first in range(start, stop, CHUNK):
        yield slice(first, min(first + CHUNK, stop))


def _check_names(names: tuple[Any, ...]) -> None:
    if not names:
        raise ModalityError("modalities", value=names, must="must name at least one modality", remedy=REMEDY)
    for name in names:
        if not isinstance(name, str) or not name:
            raise ModalityError("a modality's name", value=name, must="must be a non-empty string")
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ModalityError("a modality's name", value=name, must="must be given once")
        seen.add(name)


def _partition(names: tuple[str, ...], parts: tuple[Any, ...], d: int) -> tuple[Columns, ...]:
    """Turn sizes or explicit columns into checked groups."""
    if all(_is_integer(part) for part in parts):
        return _from_sizes(names, tuple(int(part) for part in parts), d)
    groups = tuple(_explicit(name, part, d) for name, part in zip(names, parts, strict=True))
    owner: dict[int, str] = {}
    for name, group in zip(names, groups, strict=True):
        for column in group.tolist():
            if column in owner:
                must = f"must not overlap: column {column} already belongs to {owner[column]!r}"
                raise ModalityError(f"modality {name!r}", value=column, must=must, remedy=REMEDY)
            owner[column] = name
    if len(owner) != d:
        missing = next(column for column in range(d) if column not in owner)
        raise ModalityError("modalities", value=missing, must=f"must cover all {d} columns", remedy=REMEDY)
    return tuple(_as_slice(group) for group in groups)


def _is_integer(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.bool_))


def _from_sizes(names: tuple[str, ...], sizes: tuple[int, ...], d: int) -> tuple[Columns, ...]:
    for name, size in zip(names, sizes, strict=True):
        if size < 1:
            raise ModalityError(
                f"modality {name!r}", value=size, must="must have at least one column", remedy=REMEDY
            )
    if sum(sizes) != d:
        raise ModalityError(
            "modalities", value=sum(sizes), must=f"must sum to the {d} columns of X", remedy=REMEDY
        )
    stops = np.cumsum(sizes).tolist()
    return tuple(slice(stop - size, stop) for size, stop in zip(sizes, stops, strict=True))


def _explicit(name: str, part: Any, d: int) -> NDArray[np.int64]:
    """Columns given one by one or as a slice, checked to lie in 0 .. d-1 and to be different."""
    label = f"modality {name!r}"
    if isinstance(part, np.ma.MaskedArray):
        refuse_mask(part, label, ModalityError)
    try:
        group = np.asarray(range(*part.indices(d)) if isinstance(part, slice) else part)
    except (ValueError, TypeError) as problem:
        must = "must be a size, a slice, or a list of column numbers"
        raise ModalityError(label, value=part, must=must, remedy=f"{problem}.") from None
    if group.size == 0:
        raise ModalityError(label, value=part, must="must have at least one column", remedy=REMEDY)
    if group.ndim != 1 or group.dtype.kind not in "iu":
        raise ModalityError(label, value=part, must="must be a size, a slice, or a list of column numbers")
    for column in group.tolist():
        if not 0 <= column < d:
            raise ModalityError(label, value=column, must=f"must name columns in 0 .. {d - 1}", remedy=REMEDY)
    if np.unique(group).size != group.size:
        values, counts = np.unique(group, return_counts=True)
        twice = int(values[counts > 1][0])
        raise ModalityError(label, value=twice, must="must name each column once", remedy=REMEDY)
    frozen = group.astype(np.int64)
    frozen.flags.writeable = False
    return frozen


def _as_slice(group: NDArray[np.int64]) -> Columns:
    start, stop = int(group[0]), int(group[-1]) + 1
    return slice(start, stop) if np.array_equal(group, np.arange(start, stop)) else group
