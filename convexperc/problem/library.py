"""The known objects: a library of templates, checked and measured once, and used for many sets of views."""

import itertools
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.caching import cached_property
from convexperc.errors import ModalityError, TemplateNameError, check_type
from convexperc.problem.arrays import BLOCK, FeatureVector, real_array
from convexperc.problem.column_files import Stored, open_columns, write_columns
from convexperc.problem.columns import Columns, strings
from convexperc.problem.modalities import CHUNK, Modalities

SAFE_SQUARE = 2.0**200
"""Squared lengths beyond this, or below its inverse, are left to `solve`: products may underflow."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class TemplateLibrary:
    """p templates: reference features of known objects, with their names and modalities.

    Parameters
    ----------
    templates : mapping of str to array_like, or array_like (d, p)
        Each object's name and its references: features (d,), several rows of them (k, d), or a mapping of
        their own names to features (d,). Or the columns of O.
    names : sequence of p str, optional
        Names of the columns of an array, all different; ``object 1`` ... without.
    objects : sequence of p str, optional
        The object that each column of an array shows; columns of one object are its references. Without, each
        column is an object of its own.
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
    given_objects : tuple of p str, or None
        The object that each template shows; None where each shows another one, and has its name.

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
    given_objects: tuple[str, ...] | None

    def __init__(
        self,
        templates: Any,
        *,
        names: Sequence[str] | None = None,
        objects: Sequence[str] | None = None,
        modalities: Any = None,
    ) -> None:
        columns = Columns.of(templates, names, objects)
        O = columns.O  # noqa: E741 - the paper's symbol
        if O.flags.writeable and not isinstance(O, np.memmap):
            O = O.copy()  # noqa: E741
            O.flags.writeable = False
        self._fill(columns._replace(O=O), Modalities.of(modalities, O.shape[0]))

    def _fill(self, columns: Columns, modalities: Modalities) -> None:
        self.__dict__.update(
            O=columns.O, modalities=modalities, given_names=columns.names, given_objects=columns.objects
        )

    @classmethod
    def of(
        cls,
        templates: Any,
        *,
        names: Sequence[str] | None = None,
        objects: Sequence[str] | None = None,
        modalities: Any = None,
    ) -> "TemplateLibrary":
        """Make a library, or take one as it is.

        Parameters
        ----------
        templates : TemplateLibrary, or as for the class
        names, objects, modalities : as for the class
            For a library they may be left out, or must be its own.

        Raises
        ------
        ProblemError, ModalityError, TemplateNameError
            As the class; also other names, objects or modalities than those of the library given.
        """
        if isinstance(templates, TemplateLibrary):
            return templates._confirmed(names, objects, modalities)
        return cls(templates, names=names, objects=objects, modalities=modalities)

    @classmethod
    def for_views(
        cls,
        templates: Any,
        names: Sequence[str] | None,
        modalities: Modalities,
    ) -> "TemplateLibrary":
        """Take the templates of one call, without a copy; they must have as many features as its views.

        Raises
        ------
        ProblemError, TemplateNameError
            As the class; also another number of features.
        """
        check_type(modalities, Modalities, "modalities", ModalityError)
        library = object.__new__(cls)
        library._fill(Columns.of(templates, names, d=modalities.d), modalities)
        return library

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "TemplateLibrary":
        """Open a library that `save` wrote; its numbers are mapped into memory, and read when they are used.

        The file must stay as it is while the library is in use.

        Raises
        ------
        FileFormatError
            It is not readable, or holds something else.
        """
        return cls.stored(open_columns(path))

    @classmethod
    def stored(cls, stored: Stored) -> "TemplateLibrary":
        """Take what `convexperc.problem.column_files.open_columns` returned."""
        check_type(stored, Stored, "stored")
        library = object.__new__(cls)
        library._fill(stored.columns, stored.modalities)
        return library

    def save(self, path: str | os.PathLike[str], more: Mapping[str, Any] | None = None) -> None:
        """Write the library to a file, whole or not at all.

        Parameters
        ----------
        path : path-like
            The layout is that of safetensors: tensor ``templates``, one template a row, as the numbers are.
        more : mapping of str to JSON value, optional
            Kept beside it.

        Raises
        ------
        InputError
            The file cannot be written; `more` holds what JSON does not keep, such as NaN or a key that is no
            string.
        """
        columns = Columns(self.O, self.given_names, self.given_objects)
        write_columns(path, Stored(columns, self.modalities, {} if more is None else more))

    def extended(
        self, templates: Any, *, names: Sequence[str] | None = None, objects: Sequence[str] | None = None
    ) -> "TemplateLibrary":
        """A library with more templates behind those of this one; known objects may get more references.

        Parameters
        ----------
        templates, names, objects : as for the class
            A name that is known already gets a number behind it.

        Raises
        ------
        ProblemError, TemplateNameError
            As the class; also another number of features.
        """
        added = Columns.of(templates, names, objects, self.d)
        if self.given_names is None and added.names is None and self.given_objects is None:
            found = Columns(np.hstack([self.O, added.O]), None, None)
        else:
            found = _joined(self, added)
        found.O.flags.writeable = False
        library = object.__new__(type(self))
        library._fill(found, self.modalities)
        return library

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.O.flags.writeable = False

    def _confirmed(
        self, names: Sequence[str] | None, objects: Sequence[str] | None, modalities: Any
    ) -> "TemplateLibrary":
        """The same library, unless it is to have other names, objects or modalities."""
        if names is not None and strings(names) != self.names:
            raise TemplateNameError("names", value=names, must="must be left out: the library has names")
        if objects is not None and strings(objects) != self.shown:
            must = "must be left out: the library has objects"
            raise TemplateNameError("objects", value=objects, must=must)
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
    def shown(self) -> tuple[str, ...]:
        """The object that each template shows."""
        return self.names if self.given_objects is None else self.given_objects

    @property
    def several(self) -> bool:
        """Whether some object has several templates."""
        return len(self.objects) < len(self)

    @cached_property
    def objects(self) -> tuple[str, ...]:
        """The objects, in the order of their first templates."""
        return tuple(dict.fromkeys(self.shown))

    @cached_property
    def owners(self) -> Int[np.ndarray, " p"]:
        """The place in `objects` of the object that each template shows."""
        if self.given_objects is None:
            return np.arange(len(self))
        places = {name: place for place, name in enumerate(self.objects)}
        return np.array([places[name] for name in self.given_objects])

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


def _joined(library: TemplateLibrary, added: Columns) -> Columns:
    """The templates of both, with names that differ."""
    if added.names is None:
        must = "must name the templates that are added: the library has names"
        raise TemplateNameError("names", value=None, must=must)
    names, known = list(library.names), set(library.names)
    for name in added.names:
        numbered = (f"{name}/{number}" for number in itertools.count(2))
        fresh = name if name not in known else next(each for each in numbered if each not in known)
        names.append(fresh)
        known.add(fresh)
    shown = *library.shown, *(added.objects or added.names)
    objects = None if tuple(names) == shown else shown
    return Columns(np.hstack([library.O, added.O]), tuple(names), objects)


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
