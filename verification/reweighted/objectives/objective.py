"""Objectives in exact numbers: squares, norms and losses of what is affine in the variables.

    F(z) = sum_j c_j ||A_j z - b_j||^2 + sum_k c_k loss_k(||A_k z - b_k||)

Data are taken as the rationals that they are; F is evaluated in rationals and balls, or in float64.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from math import prod
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, fmpq
from numpy.typing import NDArray

from convexperc.errors import InputError
from verification.exact.balls import Numbers, UnresolvedError, exact, inner, root
from verification.reweighted.terms.expressions import Pieces, R, evaluate, fraction
from verification.reweighted.terms.term import Term

Array = NDArray[Any]
"""An object array of Fractions."""


def fractions(values: Any) -> Array:
    """An array of integers, floats or Fractions as Fractions, each float as the rational that it is.

    Raises
    ------
    InputError
        A value is no finite number.
    """
    given = np.asarray(values, dtype=object)
    try:
        flat = [value if isinstance(value, Fraction) else Fraction(value) for value in given.ravel().tolist()]
    except (TypeError, ValueError, OverflowError) as fault:
        raise InputError("data", value=str(fault), must="must be finite numbers") from None
    found = np.empty(given.shape, dtype=object)
    found.ravel()[:] = flat
    return found


@dataclass(frozen=True, eq=False)
class Affine:
    """An array whose entries are affine in the variables.

    Attributes
    ----------
    shape : tuple of int
    parts : mapping of str to Array (entries, size)
        The matrix of each variable.
    constant : Array (entries,)
    """

    shape: tuple[int, ...]
    parts: Mapping[str, Array]
    constant: Array

    __array_ufunc__ = None
    """NumPy leaves operations with it to this class."""

    @property
    def size(self) -> int:
        """Number of entries."""
        return prod(self.shape)

    @property
    def T(self) -> "Affine":  # noqa: N802 - the name that NumPy gave it
        """The transpose."""
        return self._taken(np.arange(self.size).reshape(self.shape).T)

    def __getitem__(self, key: Any) -> "Affine":
        """Entries, rows or columns, as NumPy takes them."""
        return self._taken(np.arange(self.size).reshape(self.shape)[key])

    def _taken(self, entries: Any) -> "Affine":
        which = np.asarray(entries)
        order = which.ravel()
        parts = {name: matrix[order] for name, matrix in self.parts.items()}
        return Affine(which.shape, parts, self.constant[order])

    def __neg__(self) -> "Affine":
        return self.__mul__(-1)

    def __add__(self, other: Any) -> "Affine":
        if not isinstance(other, Affine):
            given = fractions(other)
            other = constant(np.full(self.shape, given[()]) if given.shape == () else given)
        if other.shape != self.shape:
            raise InputError(
                "affine expressions", value=(self.shape, other.shape), must="must have one shape to add"
            )
        parts = dict(self.parts)
        for name, matrix in other.parts.items():
            parts[name] = parts[name] + matrix if name in parts else matrix
        return Affine(self.shape, parts, self.constant + other.constant)

    __radd__ = __add__

    def __sub__(self, other: Any) -> "Affine":
        return self + (other * -1 if isinstance(other, Affine) else -fractions(other))

    def __rsub__(self, other: Any) -> "Affine":
        return (-self).__add__(other)

    def __mul__(self, number: Any) -> "Affine":
        factor = fractions(number)[()]
        if isinstance(factor, np.ndarray):
            raise InputError("factor", value=factor.shape, must="must be a number; matrices multiply by @")
        parts = {name: matrix * factor for name, matrix in self.parts.items()}
        return Affine(self.shape, parts, self.constant * factor)

    __rmul__ = __mul__

    def __rmatmul__(self, matrix: Any) -> "Affine":
        """A matrix of data times this vector or matrix."""
        A = fractions(matrix)
        if A.ndim not in (1, 2) or not self.shape or A.shape[-1] != self.shape[0]:
            raise InputError(
                "matrix", value=A.shape, must=f"must fit what it multiplies, of shape {self.shape}"
            )
        rows, shape = self.shape[0], (*A.shape[:-1], *self.shape[1:])

        def times(values: Array) -> Array:
            width = values.size // rows
            return (A @ values.reshape(rows, width)).reshape(prod(shape), -1)

        parts = {name: times(part) for name, part in self.parts.items()}
        return Affine(shape, parts, times(self.constant).ravel())

    def __matmul__(self, matrix: Any) -> "Affine":
        """The product with a matrix of data on the right."""
        return self.T.__rmatmul__(fractions(matrix).T).T

    def at(self, point: Mapping[str, Numbers]) -> Numbers:
        """The entries at a point, in its numbers."""
        return [
            reduce(
                lambda total, part: total + part,
                (
                    exact(a) * x
                    for name, matrix in self.parts.items()
                    for a, x in zip(matrix[i], point[name], strict=True)
                    if a
                ),
                exact(self.constant[i]),
            )
            for i in range(self.size)
        ]


def constant(values: Any) -> Affine:
    """Data as an affine expression without variables."""
    given = fractions(values)
    return Affine(given.shape, {}, given.ravel())


def variable(name: str, *shape: int) -> Affine:
    """A variable; no shape is a number.

    Parameters
    ----------
    name : str
    *shape : int
        Up to two sizes, each at least 1.
    """
    if not name.isidentifier() or len(shape) > 2 or any(size < 1 for size in shape):
        raise InputError("variable", value=(name, *shape), must="must have a name and up to two sizes >= 1")
    size = prod(shape)
    return Affine(
        tuple(shape), {name: fractions(np.eye(size, dtype=int))}, fractions(np.zeros(size, dtype=int))
    )


@dataclass(frozen=True, eq=False)
class Part:
    """One part of an objective: coefficient times a square, or times a loss of a norm.

    Attributes
    ----------
    coefficient : Fraction
    affine : Affine
    term : Term or None
        The loss and the weight of the loop; None for ||affine||^2.
    """

    coefficient: Fraction
    affine: Affine
    term: Term | None = None


@dataclass(frozen=True, eq=False)
class Objective:
    """A sum of parts.

    Attributes
    ----------
    parts : tuple of Part
    """

    parts: tuple[Part, ...]

    def __add__(self, other: Any) -> "Objective":
        return (
            self if other == 0 and not isinstance(other, Objective) else Objective(self.parts + other.parts)
        )

    __radd__ = __add__

    def __mul__(self, number: Any) -> "Objective":
        factor = fractions(number)[()]
        if not isinstance(factor, Fraction) or factor < 0:
            raise InputError("coefficient", value=number, must="must be a number >= 0")
        return Objective(tuple(replace(part, coefficient=part.coefficient * factor) for part in self.parts))

    __rmul__ = __mul__

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Entries of each variable, in the order in which they occur.

        Raises
        ------
        InputError
            One name has two sizes.
        """
        found: dict[str, int] = {}
        for part in self.parts:
            for name, matrix in part.affine.parts.items():
                if found.setdefault(name, matrix.shape[1]) != matrix.shape[1]:
                    raise InputError(
                        f"variable {name}", value=matrix.shape[1], must="must have one size throughout"
                    )
        return found

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """The different losses with their weights."""
        found: list[Term] = []
        for part in self.parts:
            if part.term is not None and part.coefficient and part.term not in found:
                found.append(part.term)
        return tuple(found)

    def at(self, point: Mapping[str, Numbers]) -> Any:
        """F at a point: a rational, or a ball that contains it."""
        return reduce(lambda a, b: a + b, (value_of(part, point) for part in self.parts), fmpq(0))

    def in_floats(self, point: Mapping[str, NDArray[np.float64]]) -> float:
        """F at a float64 point, in float64."""
        total = 0.0
        for part, (matrices, b) in zip(self.parts, self.in_arrays, strict=True):
            values = sum((A @ point[name] for name, A in matrices.items()), b)
            square = float(values @ values)
            total += float(part.coefficient) * (
                square if part.term is None else loss_in_floats(part.term, values)
            )
        return total

    @cached_property
    def in_arrays(self) -> list[tuple[dict[str, NDArray[np.float64]], NDArray[np.float64]]]:
        """Matrices by variable, and the constant, of each part, in float64."""
        return [
            (
                {name: matrix.astype(float) for name, matrix in part.affine.parts.items()},
                part.affine.constant.astype(float),
            )
            for part in self.parts
        ]


def squares(affine: Affine) -> Objective:
    """||affine||^2, the sum of the squares of all entries."""
    return Objective((Part(Fraction(1), affine),))


def norm(affine: Affine, weight: Any = "1/(2*r)", **options: Any) -> Objective:
    """||affine||, the root of the sum of squares of all entries; weight(r_i) r**2 in the loop.

    Parameters
    ----------
    affine : Affine
    weight : str, sympy expression or Python function
        Of r = ||affine|| at the last iterate.
    **options
        Of `terms.Term`: ``square``, ``widths``, ``name``.
    """
    return loss(affine, "r", weight, **options)


def norm1(affine: Affine, weight: Any = "1/(2*abs(r))", **options: Any) -> Objective:
    """The sum of the absolute values of the entries; r is an entry with its sign."""
    return each_loss(affine, "abs(r)", weight, **options)


def loss(affine: Affine, formula: Any, weight: Any, **options: Any) -> Objective:
    """A loss of r = ||affine||; the loop has weight(r_i) square(r) in its place."""
    return Objective((Part(Fraction(1), affine, Term(formula, weight, **options)),))


def each_loss(affine: Affine, formula: Any, weight: Any, **options: Any) -> Objective:
    """The sum of a loss of each entry r, which has a sign."""
    term = Term(formula, weight, signed=True, **options)
    return Objective(tuple(Part(Fraction(1), entry, term) for entry in _entries(affine)))


def _entries(affine: Affine) -> Iterable[Affine]:
    return (affine._taken([i]) for i in range(affine.size))


def value_of(part: Part, point: Mapping[str, Numbers]) -> Any:
    """One part of F at a point."""
    if not part.coefficient:
        return fmpq(0)
    values = part.affine.at(point)
    if part.term is None:
        return exact(part.coefficient) * inner(values, values)
    return exact(part.coefficient) * function_at(part.term, values, "loss")


def function_at(term: Term, values: Numbers, which: str) -> Any:
    """The loss or the weight of a term at the entries of its affine expression.

    Parameters
    ----------
    term : Term
    values : Numbers
    which : {"loss", "weight"}

    Returns
    -------
    fmpq, arb or None
        None for a weight that does not exist, because it grows without bound at a residual of 0.

    Raises
    ------
    UnresolvedError
        Balls do not tell the sign of a residual, or on which side of a change of the formula it is.
    """
    r, side = residual(term, values)
    function: Pieces = getattr(side, which)
    if r == 0:
        return _at_zero(function)
    piece = _piece(function, r)
    return evaluate(piece.expression, r)


def residual(term: Term, values: Numbers) -> tuple[Any, Any]:
    """|r| and the side of the term on which r is."""
    sides = term.sides
    if not term.signed:
        return root(inner(values, values)), sides[0]
    r = values[0]
    if isinstance(r, arb) and r.contains(0):
        raise UnresolvedError("a residual", value=str(r), must="must have a sign", remedy="Use more bits.")
    return abs(r), sides[-1] if bool(r < 0) else sides[0]


def _at_zero(function: Pieces) -> Any:
    limit = _limit(function[0].expression)
    return (
        None if limit is None else exact(fraction(limit)) if limit.is_Rational else (evaluate(limit, fmpq(0)))
    )


def grows_without_bound(term: Term) -> bool:
    """Whether a weight does not exist at a residual of 0."""
    return any(_limit(side.weight[0].expression) is None for side in term.sides)


def _limit(expression: Any) -> Any:
    if expression not in _LIMITS:
        found = sp.limit(expression, R, 0, "+")
        _LIMITS[expression] = found if found.is_number and found.is_finite else None
    return _LIMITS[expression]


_LIMITS: dict[Any, Any] = {}


def _piece(function: Pieces, r: Any) -> Any:
    if len(function) == 1:
        return function[0]
    for piece in function:
        upper = piece.upper
        if upper is sp.oo or _below(r, upper):
            return piece
    raise AssertionError("unreachable: the last piece has no end")


def _below(r: Any, end: Any) -> bool:
    """Whether r <= end, where a formula changes; balls that do not tell raise."""
    limit = evaluate(end, fmpq(0))
    if isinstance(r, fmpq) and isinstance(limit, fmpq):
        return bool(r <= limit)
    if bool(arb(r) <= arb(limit)):
        return True
    if bool(arb(r) > arb(limit)):
        return False
    raise UnresolvedError(
        "a residual", value=str(r), must=f"must be on one side of {end}", remedy="Use more bits."
    )


def loss_in_floats(term: Term, values: NDArray[np.float64]) -> float:
    """The loss in float64."""
    return _in_floats(term, values, "loss")


def weight_in_floats(term: Term, values: NDArray[np.float64]) -> float:
    """The weight in float64; inf or nan where it does not exist."""
    return _in_floats(term, values, "weight")


def _in_floats(term: Term, values: NDArray[np.float64], which: str) -> float:
    sides = term.sides
    r = float(values[0]) if term.signed else float(np.linalg.norm(values))
    side = sides[-1] if r < 0 else sides[0]
    size = abs(r)
    function: Pieces = getattr(side, which)
    if size == 0.0:
        limit = _limit(function[0].expression)
        return np.inf if limit is None else float(limit)
    for piece in function:
        if size <= float(piece.upper):
            with np.errstate(all="ignore"):
                return float(_compiled(piece.expression)(np.float64(size)))
    return np.nan


def _compiled(expression: Any) -> Any:
    if expression not in _COMPILED:
        _COMPILED[expression] = sp.lambdify(R, expression, "numpy")
    return _COMPILED[expression]


_COMPILED: dict[Any, Any] = {}


def rational_point(values: Mapping[str, Sequence[Any]]) -> dict[str, Numbers]:
    """A point of integers, floats or Fractions, in FLINT's rationals."""
    return {name: [exact(value) for value in fractions(entries).ravel()] for name, entries in values.items()}
