"""Parts of an objective whose convex conjugate is known: squares, norms, check losses, Huber's loss.

A part f(A z + d) is at least v'(A z + d) - f*(v) for every v. Here f grows, on each side of 0, as a r**2 up
to a bend and from there on with the slope `radius`; f*(v) = ||v||^2/(4a), or 0 where there is no square,
for the v that are at most `radius` long. All this is met by v = 0, hence by every t v, 0 <= t <= 1, of a v
that is allowed: a v that meets the equality sum A'v = 0, but is too long, is shortened.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy as sp
from flint import fmpq

from convexperc.errors import InputError
from verification.exact.balls import exact
from verification.reweighted.objectives.objective import Objective, Part
from verification.reweighted.terms.expressions import Piece, Pieces, R, fraction


class NotCoveredError(InputError):
    """A loss of which no conjugate is known here."""


@dataclass(frozen=True)
class Growth:
    """How a loss grows on one side of 0.

    Attributes
    ----------
    radius : fmpq or None
        Its largest slope; None: there is none.
    curve : fmpq or None
        The a of a r**2, with which it begins; None: it begins with the slope `radius`.
    """

    radius: Any
    curve: Any

    @property
    def kinked(self) -> bool:
        """Whether it begins with a slope."""
        return self.curve is None

    @property
    def bend(self) -> Any:
        """Where a square becomes a line; None where it does not."""
        return None if self.radius is None or self.curve is None else self.radius / (2 * self.curve)

    def times(self, line: Any, square: Any) -> "Growth":
        """With other units: the slope times `line`, the a times `square`."""
        return Growth(
            None if self.radius is None else self.radius * line,
            None if self.curve is None else self.curve * square,
        )


@dataclass(frozen=True, eq=False)
class Block:
    """f(A z + d), one part of an objective.

    Attributes
    ----------
    rows : list of lists of fmpq (k, n)
        A.
    offset : list of fmpq (k,)
        d.
    growths : tuple of Growth
        One for a norm or an even loss; two for a number of either sign: of r > 0, and of r < 0.
    """

    rows: list[list[Any]]
    offset: list[Any]
    growths: tuple[Growth, ...]

    def growth(self, v: Sequence[Any]) -> Growth:
        """The side on which a residual or a dual vector is."""
        return self.growths[-1] if len(self.growths) == 2 and v[0] < 0 else self.growths[0]


def blocks(objective: Objective) -> list[Block]:
    """All parts with a coefficient.

    Raises
    ------
    NotCoveredError
        The conjugate of a loss is not known here.
    """
    return [_block(objective, part) for part in objective.parts if part.coefficient]


def _block(objective: Objective, part: Part) -> Block:
    rows = []
    for i in range(part.affine.size):
        row: list[Any] = []
        for name, size in objective.sizes.items():
            matrix = part.affine.parts.get(name)
            row += [fmpq(0)] * size if matrix is None else [exact(a) for a in matrix[i]]
        rows.append(row)
    offset, factor = [exact(b) for b in part.affine.constant], exact(part.coefficient)
    if part.term is None:
        return Block(rows, offset, (Growth(None, factor),))
    smooth = _smoothed(part.term.sides[0].loss)
    if smooth is not None:
        slope, end = smooth
        return Block([*rows, [fmpq(0)] * len(rows[0])], [*offset, end], (Growth(slope * factor, None),))
    found = [_growth(side.loss) for side in part.term.sides]
    if None in found:
        known = "k*r, a*r**2, a*r**2 that goes on as its tangent, k*sqrt(r**2 + e**2)"
        must = f"must be made of {known}, with rational numbers"
        raise NotCoveredError("a loss", value=part.term.title, must=must)
    return Block(rows, offset, tuple(growth.times(factor, factor) for growth in found if growth is not None))


@lru_cache(maxsize=256)
def _growth(loss: Pieces) -> Growth | None:
    """Read k r, a r**2, or a r**2 that goes on as its tangent; None if it is another."""
    first, *more = loss
    square, line = _coefficient(first, R**2), _coefficient(first, R)
    if not more and line is not None:
        return Growth(line, None)
    if not more and square:
        return Growth(None, square)
    if len(more) == 1 and square and first.upper.is_Rational:
        a, end = sp.Rational(int(square.p), int(square.q)), first.upper
        tangent = 2 * a * end * R - a * end**2
        if sp.expand(more[0].expression - tangent) == 0:
            return Growth(2 * square * exact(fraction(end)), square)
    return None


def _coefficient(piece: Piece, of: Any) -> Any:
    """The rational k >= 0 of an expression k `of`; None if it is another."""
    quotient = sp.simplify(piece.expression / of)
    if not quotient.is_Rational or quotient < 0:
        return None
    return fmpq(int(quotient.p), int(quotient.q))


@lru_cache(maxsize=256)
def _smoothed(loss: Pieces) -> tuple[Any, Any] | None:
    """k and e of k sqrt(r**2 + e**2), which is k times the norm of (r, e); None if it is another."""
    if len(loss) != 1 or loss[0].expression.is_polynomial(R):
        return None
    square = sp.expand(loss[0].expression ** 2)
    k2, rest = square.coeff(R, 2), square.coeff(R, 0)
    if sp.expand(square - k2 * R**2 - rest) != 0 or not (k2.is_positive and rest.is_positive):
        return None
    slope, end = sp.sqrt(k2), sp.sqrt(rest / k2)
    if not (slope.is_Rational and end.is_Rational):
        return None
    return fmpq(int(slope.p), int(slope.q)), fmpq(int(end.p), int(end.q))
