"""Reweighted loops: an objective, the order in which its blocks are updated, and the exact update.

The update of a block minimises the objective with each loss replaced by weight(r_i) square(r), r_i being
the residual at the iterate; a block of Gauss-Seidel sees the new values of those before it, one of Jacobi
does not.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, fmpq
from numpy.typing import NDArray

from convexperc.errors import InputError, SolverError
from verification.exact.balls import Numbers, UnresolvedError, exact, inner, precision, root
from verification.exact.reweighting import Square, System, UndefinedUpdateError, WeightedSquares
from verification.reweighted.objectives.objective import (
    Objective,
    Part,
    fractions,
    function_at,
    grows_without_bound,
    weight_in_floats,
)
from verification.reweighted.terms.dimensions import unit_of_widths
from verification.reweighted.terms.expressions import R, exactly
from verification.reweighted.terms.term import Side

Floats = NDArray[np.float64]
ORDERS = ("gauss_seidel", "jacobi")
AT_ZERO = ("hold", "undefined", "leave")

Point = Mapping[str, Numbers]
Step = Callable[[Point], Point]


@dataclass(frozen=True, eq=False)
class Loop:
    """A reweighted loop.

    Parameters
    ----------
    objective : Objective
    blocks : sequence of sequences of str
        Names of variables that are updated together, in order; default: all at once.
    order : {"gauss_seidel", "jacobi"}
    at_zero : {"hold", "undefined", "leave"}
        At a residual of 0 where the weight grows without bound: it is held at 0, which is the limit of the
        update; the update does not exist; or, by Vardi and Zhang's rule, it is left if that lowers F (where
        every residual with the block is a number times the whole block less a point).
    start : mapping of str to sequence of numbers, or None
        None: any start.
    stop : function of two float64 points, or None
        Says of an iterate and the next one, each a mapping of names to arrays, whether the loop ends there.
    update : function of a point, or None
        Another update than the one above, on mappings of names to lists of exact numbers.

    Raises
    ------
    InputError
        Blocks are not a partition of the variables, or see above.
    """

    objective: Objective
    blocks: Sequence[Sequence[str]] = ()
    order: str = "gauss_seidel"
    at_zero: str = "hold"
    start: Mapping[str, Any] | None = None
    stop: Callable[[Any, Any], bool] | None = None
    update: Step | None = None

    def __post_init__(self) -> None:
        for name, value, known in (("order", self.order, ORDERS), ("at_zero", self.at_zero, AT_ZERO)):
            if value not in known:
                raise InputError(name, value=value, must=f"must be one of {', '.join(known)}")
        named = [name for block in self.blocks for name in block]
        if self.blocks and sorted(named) != sorted(self.objective.sizes):
            must = f"must name each of {', '.join(self.objective.sizes)} once"
            raise InputError("blocks", value=self.blocks, must=must)

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """The blocks, in order."""
        return tuple(map(tuple, self.blocks)) or (tuple(self.objective.sizes),)

    @property
    def is_reweighted(self) -> bool:
        """Whether the update is the reweighted one and no other."""
        return self.update is None and self.at_zero != "leave"

    def step(self, point: Point) -> dict[str, Numbers]:
        """The next iterate in exact numbers.

        Raises
        ------
        UndefinedUpdateError
            There is none.
        UnresolvedError
            Balls do not tell.
        """
        if self.update is not None:
            return dict(self.update(point))
        parts = enumerate(self.objective.parts)
        weights = {k: self._weight(part, point) for k, part in parts if part.term is not None}
        found = dict(point)
        for names in self.groups:
            seen = found if self.order == "gauss_seidel" else point
            block = [k for name in names for k in self.columns[name]]
            whole = [x for name in self.columns for x in seen[name]]
            system = self._squares.system(block, whole, list(weights.values()))
            if system.held and self.at_zero == "leave":
                moved = self._left(system, block, {k for k, weight in weights.items() if weight is None})
            else:
                moved = system.solved(", ".join(names))
            values = iter(moved)
            found |= {name: [next(values) for _ in self.columns[name]] for name in names}
        return found

    @cached_property
    def columns(self) -> dict[str, range]:
        """The place of each variable in a vector of all, in the order of the objective."""
        found, at = {}, 0
        for name, size in self.objective.sizes.items():
            found[name], at = range(at, at + size), at + size
        return found

    @cached_property
    def _residuals(self) -> list[Square]:
        """The square of each part's residual."""
        return [self._square(part) for part in self.objective.parts]

    @cached_property
    def _squares(self) -> WeightedSquares:
        squares = list(zip(self.objective.parts, self._residuals, strict=True))
        fixed = [(exact(part.coefficient), square) for part, square in squares if part.term is None]
        weighted = [square for part, square in squares if part.term is not None]
        return WeightedSquares(sum(self.objective.sizes.values()), fixed, weighted)

    @cached_property
    def stacked(self) -> tuple[Floats, Floats, list[int]]:
        """In float64, matrix and constant of the residuals of all parts, and how many each has."""
        columns = sum(self.objective.sizes.values())
        A, b = [], []
        for matrices, constant in self.objective.in_arrays:
            A.append(np.zeros((len(constant), columns)))
            b.append(constant)
            for name, matrix in matrices.items():
                A[-1][:, self.columns[name]] = matrix
        return np.vstack(A), np.concatenate(b), [len(constant) for constant in b]

    def _square(self, part: Part) -> Square:
        rows: list[dict[int, Any]] = [{} for _ in range(part.affine.size)]
        for name, matrix in part.affine.parts.items():
            for row, entries in zip(rows, matrix, strict=True):
                row |= {k: exact(a) for k, a in zip(self.columns[name], entries, strict=True) if a}
        return list(zip(rows, map(exact, part.affine.constant), strict=True))

    def _weight(self, part: Part, point: Point) -> Any:
        """Coefficient, factor of the square and weight together; None where it grows without bound."""
        assert part.term is not None
        if not part.coefficient:
            return fmpq(0)
        try:
            weight = function_at(part.term, part.affine.at(point), "weight")
        except ZeroDivisionError:
            weight = None
        if weight is not None:
            return exact(part.coefficient) * fmpq(int(part.term.factor.p), int(part.term.factor.q)) * weight
        if self.at_zero == "undefined":
            raise UndefinedUpdateError(
                "the update", value="a residual of 0", must="must divide by a number other than 0"
            )
        return None

    def _left(self, system: System, block: Sequence[int], met: Collection[int]) -> Numbers:
        """Vardi and Zhang: the step of the rest, shortened by what the norms that are 0 pull back."""
        pull = fmpq(0)
        for k, part in enumerate(self.objective.parts):
            factor = _factor(self._residuals[k], block)
            if factor and k in met:
                if part.term is None or not all(_is_norm(side) for side in part.term.sides):
                    raise _not_theirs("another loss")
                pull += exact(part.coefficient) * abs(factor)
        gradient, size = system.gradient(system.point), system.matrix[0][0]
        force = 2 * root(inner(gradient, gradient))
        if bool(force <= pull):
            return system.point
        if not bool(force > pull):
            raise UnresolvedError("a force", value=str(force), must=f"must differ from {pull}")
        return [x - g / size * (1 - pull / force) for x, g in zip(system.point, gradient, strict=True)]


def _factor(square: Square, block: Sequence[int]) -> Any:
    """The k of a residual k (x - a) of the block x; 0 where it does not depend on the block."""
    rows = [{k: a for k, a in row.items() if k in block} for row, _ in square]
    if not any(rows):
        return fmpq(0)
    factor = rows[0].get(block[0], fmpq(0))
    if rows != [{k: factor} for k in block]:
        raise _not_theirs("another expression")
    return factor


def _is_norm(side: Side) -> bool:
    return [piece.expression for piece in side.loss] == [R]


def _not_theirs(value: str) -> InputError:
    must = "must be for objectives of k ||x - a|| and of squares of k (x - a) alone, x being the block"
    return InputError("at_zero='leave'", value=value, must=must)


FLOAT_BITS = 128
"""Of an exact update that is rounded to float64."""

HELD = 1e20
"""Weight in float64 that holds a residual at 0, as a multiple of the largest other one."""

LARGEST = 1e200
"""Weight in float64 above which a system is not formed from it."""


def unbounded_at_zero(objective: Objective, point: Point) -> bool:
    """Whether a residual whose weight grows without bound is 0 at a rational point."""
    return any(
        part.term is not None
        and part.coefficient
        and grows_without_bound(part.term)
        and all(value == 0 for value in part.affine.at(point))
        for part in objective.parts
    )


def in_unit(loop: Loop, unit: Fraction) -> Loop | None:
    """The same loop for data in another unit: every residual is multiplied by `unit`, and F stays as it is.

    Weights, start and stopping rule are kept as they are stated. Widths have the unit with which loss and
    weight are the same up to a factor, see `unit_of_widths`: most often that of a residual.

    Returns
    -------
    Loop or None
        None where a loss has a unit of its own, or is multiplied by a root of the unit.
    """
    parts = []
    for part in loop.objective.parts:
        term, power = part.term, sp.Integer(2)
        if term is not None:
            found = unit_of_widths(term.loss_expression, term.weight_expression, term.widths)
            if found is None:
                return None
            scale, power = exactly(unit) ** found[0], found[1]
            if not (power.is_Integer and scale.is_Rational):
                return None
            term = replace(term, widths={name: exactly(value) * scale for name, value in term.widths.items()})
        affine = replace(part.affine, constant=part.affine.constant * unit)
        parts.append(Part(part.coefficient / unit ** int(power), affine, term))
    start = (
        None
        if loop.start is None
        else {name: fractions(values) * unit for name, values in loop.start.items()}
    )
    return replace(loop, objective=Objective(tuple(parts)), start=start)


@dataclass(frozen=True)
class FloatRun:
    """Iterates in float64.

    Attributes
    ----------
    points : list of dict of str to float64 array
    ended : bool
        Whether the stopping rule was met.
    """

    points: list[dict[str, Floats]]
    ended: bool


def float_run(loop: Loop, start: Mapping[str, Floats], iterations: int, small: float) -> FloatRun:
    """Run in float64, until the loop's own rule says stop or, without one, a step is small by its share."""
    points = [dict(start)]
    for _ in range(iterations):
        found = _float_step(loop, points[-1])
        if found is None:
            return FloatRun(points, False)
        points.append(found)
        if _stops(loop, points[-2], found, small):
            return FloatRun(points, True)
    return FloatRun(points, False)


def _stops(loop: Loop, before: Mapping[str, Floats], after: Mapping[str, Floats], small: float) -> bool:
    if loop.stop is not None:
        return bool(loop.stop(before, after))
    step = max(float(np.abs(after[name] - before[name]).max()) for name in after)
    return step <= small * max(float(np.abs(values).max()) for values in after.values())


def _float_step(loop: Loop, point: Mapping[str, Floats]) -> dict[str, Floats] | None:
    """The next iterate; None where it is not finite. A residual of 0 is held by a large weight."""
    if loop.update is not None:
        return _rounded_step(loop, point)
    objective, found = loop.objective, dict(point)
    with np.errstate(all="ignore"):
        weights = [_float_weight(part, k, objective, point) for k, part in enumerate(objective.parts)]
    leaves = loop.at_zero == "leave" and np.isinf(weights).any()
    if leaves or any(np.isnan(weight) or weight < 0 for weight in weights):
        return _rounded_step(loop, point)
    held = min(HELD * max((weight for weight in weights if np.isfinite(weight)), default=1.0), LARGEST)
    A, b, rows = loop.stacked
    roots = np.repeat(np.sqrt(np.minimum(weights, held)), rows)
    for names in loop.groups:
        seen = found if loop.order == "gauss_seidel" else point
        block = [k for name in names for k in loop.columns[name]]
        with np.errstate(all="ignore"):
            system = roots[:, None] * A[:, block]
            right = -roots * (A @ np.concatenate([seen[name] for name in loop.columns]) + b)
        if not (np.isfinite(system).all() and np.isfinite(right).all()):
            return None
        move = iter(np.linalg.lstsq(system, right, rcond=None)[0])
        found |= {name: seen[name] + [next(move) for _ in loop.columns[name]] for name in names}
    return found if all(np.isfinite(values).all() for values in found.values()) else None


def _rounded_step(loop: Loop, point: Mapping[str, Floats]) -> dict[str, Floats] | None:
    """The exact update of a float64 point, rounded; None if there is none."""
    try:
        with precision(FLOAT_BITS):
            moved = loop.step({name: [exact(float(x)) for x in values] for name, values in point.items()})
    except (SolverError, ZeroDivisionError):
        return None
    return {name: np.array([float(arb(x).mid()) for x in values]) for name, values in moved.items()}


def _float_weight(part: Part, k: int, objective: Objective, point: Mapping[str, Floats]) -> float:
    if part.term is None or not part.coefficient:
        return float(part.coefficient)
    matrices, b = objective.in_arrays[k]
    values = sum((A @ point[name] for name, A in matrices.items()), b)
    return float(part.coefficient) * float(part.term.factor) * weight_in_floats(part.term, values)
