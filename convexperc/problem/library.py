"""The known objects: a library of templates, checked and measured once, and used for many sets of views."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.caching import cached_property
from convexperc.errors import InputError, ModalityError, ProblemError, TemplateNameError
from convexperc.problem.arrays import BLOCK, FeatureVector, real_array
from convexperc.problem.conversion import held_exactly
from convexperc.problem.modalities import CHUNK, Modalities

SAFE_SQUARE = 2.0**200
"""Squared lengths beyond this, or below its inverse, are left to `solve`: products may underflow."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class TemplateLibrary:
    """p templates: reference features of known objects, with their names and modalities.

    Parameters
    ----------
    templates : mapping of str to array_like (d,), or array_like (d, p)
        Each object's name and reference features; or the columns of O.
    names : sequence of p str, optional
        Names of the columns of an array; ``object 1`` ... without.
    modalities : see `Modalities.of`

    Attributes
    ----------
    O : array of real numbers (d, p), read-only
        Column j is template j. An array that can be written is copied; a read-only or memory-mapped one is
        not, and must stay as it is while the library, or an answer to it, is in use.
    modalities : Modalities
        The partition of the d features.
    given_names : tuple of p str, or None
        One name a template, all different, if they were given.

    Raises
    ------
    ProblemError
        No template at all, a wrong shape, or entries that are not real numbers; those that are not finite are
        found by the first pass over the data.
    ModalityError
        The modalities are not a partition of the d features.
    TemplateNameError
        Names that do not fit, or others than the keys of a mapping.

    Notes
    -----
    The squared lengths, and the check that every number is finite, cost one pass over O. It is made once,
    with the first set of views or when they are asked for.
    """

    O: Any  # noqa: E741 - the paper's symbol
    modalities: Modalities
    given_names: tuple[str, ...] | None

    def __init__(self, templates: Any, *, names: Sequence[str] | None = None, modalities: Any = None) -> None:
        columns, found = read_columns(templates, names)
        if columns.flags.writeable and not isinstance(columns, np.memmap):
            columns = columns.copy()
            columns.flags.writeable = False
        parts = Modalities.of(modalities, columns.shape[0])
        self.__dict__.update(O=columns, modalities=parts, given_names=found)

    @classmethod
    def of(
        cls, templates: Any, *, names: Sequence[str] | None = None, modalities: Any = None
    ) -> "TemplateLibrary":
        """Make a library, or take one as it is.

        Parameters
        ----------
        templates : TemplateLibrary, or as for the class
        names, modalities : as for the class
            For a library they may be left out, or must be its own.

        Raises
        ------
        ProblemError, ModalityError, TemplateNameError
            As the class; also other names or modalities than those of the library given.
        """
        if isinstance(templates, TemplateLibrary):
            return templates._confirmed(names, modalities)
        return cls(templates, names=names, modalities=modalities)

    @classmethod
    def for_views(
        cls, templates: Any, names: Sequence[str] | None, modalities: Modalities
    ) -> "TemplateLibrary":
        """Take the templates of one call, without a copy; they must have as many features as its views.

        Raises
        ------
        ProblemError, TemplateNameError
            As the class; also another number of features.
        """
        columns, found = read_columns(templates, names, modalities.d)
        library = object.__new__(cls)
        library.__dict__.update(O=columns, modalities=modalities, given_names=found)
        return library

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.O.flags.writeable = False

    def _confirmed(self, names: Sequence[str] | None, modalities: Any) -> "TemplateLibrary":
        """The same library, unless it is to have other names or modalities."""
        if names is not None and tuple(names) != self.names:
            raise TemplateNameError("names", value=names, must="must be left out: the library has names")
        if modalities is None or modalities is self.modalities:
            return self
        wanted = Modalities.of(modalities, self.d)
        named = isinstance(modalities, (Modalities, Mapping)) and wanted.names != self.modalities.names
        if named or not wanted.same(self.modalities):
            remedy = "Leave them out, or make the library with them."
            must = f"must be those of the library, {', '.join(self.modalities.names)}"
            raise ModalityError("modalities", value=modalities, must=must, remedy=remedy)
        return self

    def __len__(self) -> int:
        return int(self.O.shape[1])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """One name a template, all different; ``object 1`` ... where none were given."""
        if self.given_names is not None:
            return self.given_names
        return tuple(f"object {i}" for i in range(1, len(self) + 1))

    @property
    def d(self) -> int:
        """Number of features."""
        return int(self.O.shape[0])

    def template(self, j: int) -> FeatureVector:
        """o_j as given."""
        return np.asarray(self.O[:, j], dtype=np.float64)

    def blocks(self) -> Iterator[tuple[slice, Float[np.ndarray, "d k"]]]:
        """The templates, a few at a time, as float64."""
        width = max(1, BLOCK // self.d)
        for start in range(0, len(self), width):
            chosen = slice(start, start + width)
            yield chosen, np.asarray(self.O[:, chosen], dtype=np.float64)

    @property
    def measured(self) -> bool:
        """Whether the pass over O has been made."""
        return "lengths" in self.__dict__

    @cached_property
    def lengths(self) -> "Lengths":
        """Squared lengths and exponents of all templates; every number is finite.

        Raises
        ------
        ProblemError
            A number is NaN or infinite.
        """
        squares = np.empty(len(self))
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            for chosen, block in self.blocks():
                squares[chosen] = squared_lengths(block, chosen.start)
        return Lengths.of(squares)

    def keep(self, squares: Float[np.ndarray, " p"]) -> None:
        """Take over the squared lengths of all templates, from `squared_lengths` block by block."""
        self.__dict__["lengths"] = Lengths.of(squares)

    def __repr__(self) -> str:
        sizes = dict(zip(self.modalities.names, self.modalities.sizes, strict=True))
        return f"TemplateLibrary(p={len(self)}, d={self.d}, modalities={sizes})"


@dataclass(frozen=True, eq=False)
class Lengths:
    """How long p templates are: ||o_j||^2 = 2^(2 k_j) ||o_j_||^2, with ||o_j_|| in [1/2, 1).

    Attributes
    ----------
    sound : bool (p,)
        Where the length is neither 0 nor out of the safe range.
    exponents : int (p,)
        k_j; 0 where the length is not sound.
    inverses, fourfold : float64 (p,)
        2^-k_j and 4^k_j.
    targets : float64 (p,)
        ||o_j_||^2, to rounding.
    squares : float64 (p,)
        ||o_j||^2, to rounding.
    largest : int
        The largest k_j.
    spread : float
        The largest of the squares over the smallest, to rounding; infinity if a length is not sound.
    units : float64 (p,)
        2^(2 (k_j - largest)), so that units times the optima of normalised problems compare as F* do.
    """

    sound: Bool[np.ndarray, " p"]
    exponents: Int[np.ndarray, " p"]
    inverses: Float[np.ndarray, " p"]
    fourfold: Float[np.ndarray, " p"]
    targets: Float[np.ndarray, " p"]
    squares: Float[np.ndarray, " p"]
    largest: int
    spread: float
    units: Float[np.ndarray, " p"]

    @classmethod
    def of(cls, squares: Float[np.ndarray, " p"]) -> "Lengths":
        """Normalise the squared lengths ||o_j||^2."""
        sound = (squares > 1.0 / SAFE_SQUARE) & (squares < SAFE_SQUARE)
        exponents = length_exponents(np.where(sound, squares, 0.5))
        targets, largest = np.ldexp(squares, -2 * exponents), int(exponents.max())
        units = np.ldexp(1.0, 2 * (exponents - largest))
        spread = float(squares.max() / squares.min()) if sound.all() else math.inf
        inverses, fourfold = np.ldexp(1.0, -exponents), np.ldexp(1.0, 2 * exponents)
        return cls(sound, exponents, inverses, fourfold, targets, targets * fourfold, largest, spread, units)


def length_exponents(squares: Any) -> Any:
    """The exponents k of squared lengths s: the length divided by 2^k lies in [1/2, 1)."""
    return (np.frexp(squares)[1] + 1) // 2


def squared_lengths(block: Float[np.ndarray, "d k"], first: int) -> Float[np.ndarray, " k"]:
    """||o_j||^2 of some columns of O, the first of which is column `first`.

    Raises
    ------
    ProblemError
        A number is NaN or infinite.
    """
    found = np.einsum("dp,dp->p", block[:CHUNK], block[:CHUNK])
    for start in range(CHUNK, block.shape[0], CHUNK):
        part = block[start : start + CHUNK]
        found += np.einsum("dp,dp->p", part, part)
    if not np.isfinite(found).all():
        for j in np.flatnonzero(~np.isfinite(found)):  # an overflow of the squares alone is no fault
            real_array(block[:, j], f"O[:, {first + j}]", 1)
    return np.asarray(found)


def read_columns(
    templates: Any, names: Sequence[str] | None, d: int | None = None
) -> tuple[Any, tuple[str, ...] | None]:
    """O, with d rows if that is known, and the names of its columns; see `TemplateLibrary`."""
    if isinstance(templates, Mapping):
        given = checked_names(tuple(templates), len(templates), TemplateNameError, "references", "templates")
        if names is not None and tuple(names) != given:
            must = "must be left out where the templates are a mapping, or be its keys"
            raise TemplateNameError("names", value=names, must=must)
        return _columns(templates, d), given
    columns = _as_columns(templates)
    if d is not None and columns.shape[0] != d:
        must = f"must have {d} rows, as X has columns"
        raise ProblemError("O", value=columns.shape, must=must, remedy="Each column of O is one template.")
    if names is None:
        return columns, None
    return columns, checked_names(names, columns.shape[1], TemplateNameError, "names", "templates")


def checked_names(
    names: Any, count: int, error: type[InputError], argument: str, named: str
) -> tuple[str, ...]:
    """As many names as there are things to be named: strings, not empty, all different.

    Raises
    ------
    InputError
        Of the class given.
    """
    given = () if isinstance(names, str) or not isinstance(names, Iterable) else tuple(names)
    strings = all(isinstance(name, str) and name for name in given)
    if not strings or len(given) != count or len(set(given)) != count:
        must = f"must name each of the {count} {named} once, by strings that are not empty"
        raise error(argument, value=names, must=must)
    return given


def _as_columns(templates: Any) -> Any:
    """O as an array of real numbers with a column for each template, copied only if it is no such array."""
    found = templates
    plain = isinstance(found, np.ndarray) and not isinstance(found, np.ma.MaskedArray)
    if not (plain and held_exactly(found.dtype) and found.ndim == 2):
        found = real_array(templates, "O", 2)
    if 0 in found.shape:
        must = "must have at least one row and at least one column"
        raise ProblemError("O", value=found.shape, must=must, remedy="Each column of O is one template.")
    return found


def _columns(templates: Mapping[str, Any], d: int | None) -> Float[np.ndarray, "d p"]:
    """Each template of a mapping as a column, read-only."""
    if not templates:
        raise ProblemError("references", value=templates, must="must name at least one object")
    rows = {name: real_array(o, f"reference {name!r}", 1) for name, o in templates.items()}
    first = next(iter(rows))
    must = f"must have the {rows[first].size} entries that reference {first!r} has"
    if d is not None:
        must = f"must have one entry for each of the {d} columns of X"
    for name, row in rows.items():
        if row.size != (rows[first].size if d is None else d):
            raise ProblemError(f"reference {name!r}", value=row.shape, must=must)
    columns = np.stack(list(rows.values())).T
    columns.flags.writeable = False
    return columns
