"""Identities between matrix expressions, for every size at once: letters that do not commute, expanded.

An expression is a sum of words in the letters below, with polynomial coefficients in the scalars. Two sums
that are equal word by word are equal for all real matrices of the letters' shapes; a 1 x 1 word equals its
transpose. Nothing is assumed but the shapes, the symmetries and E Ei = Ei E = I.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from verification.ledger.evidence import Checker, Step
from verification.proofs.checkers.formulas import evaluate, legend, names, refused

Letter = tuple[str, bool]
"""A name, and whether it is transposed."""
Term = tuple[tuple[str, ...], tuple[Letter, ...]]
"""Scalars, sorted, and letters, in order."""
Shape = tuple[str, str]

SHAPES: dict[str, Shape] = {
    "X": ("n", "d"),
    "A": ("n", "n"),
    "B": ("d", "d"),
    "E": ("d", "d"),
    "Ei": ("d", "d"),
    "P": ("n", "n"),
    "R": ("d", "d"),
    "S": ("n", "d"),
    "In": ("n", "n"),
    "Id": ("d", "d"),
    **dict.fromkeys(("w", "dw", "h", "e", "y", "c"), ("n", "1")),
    **dict.fromkeys(("u", "du", "k", "g", "o", "a", "z"), ("d", "1")),
}
"""X; A and B diagonal, E invertible; P, S, R the blocks of a quadratic form; vectors of n and of d entries.
Every other name is a scalar."""

KNOWN = frozenset({"X", "A", "B", "In", "Id", "w", "u", "dw", "du", "h", "k", "o", "l1", "l2", "l3"})
"""Names that mean the same in every step: h and k are any changes of w and u, l1 is lambda1."""

SYMMETRIC = frozenset({"A", "B", "E", "Ei", "P", "R"})
UNITS = frozenset({"In", "Id"})
INVERSES = frozenset({("E", "Ei"), ("Ei", "E")})


def matrix_identity(name: str, gloss: str, left: str, right: str, **where: str) -> Step:
    """Check that two matrix expressions are equal for all matrices of the shapes in `SHAPES`.

    Parameters
    ----------
    name : str
        How the written proof refers to the step.
    gloss : str
        What the step is for, in words.
    left, right : str
        Formulas; ``X.T`` is the transpose. Names outside `SHAPES` are scalars.
    **where : str
        What the names that are not in `KNOWN` stand for.

    Returns
    -------
    Step

    Raises
    ------
    InputError
        A text is not a formula of this kind, its shapes do not fit, or see `legend`.
    """
    given = f"{left} = {right}"
    meaning = legend(gloss, where, set(names(left, right)) - KNOWN)
    first, second = (evaluate(text, _Matrices()) for text in (left, right))
    if first.shape != second.shape:
        raise refused(given, f"must have one shape on both sides, not {first.shape}, {second.shape}")
    return Step(f"{name}: {gloss}", Checker.IDENTITY, first.terms == second.terms, given, meaning)


@dataclass(frozen=True)
class Expression:
    """A sum of words of one shape; shape None is a scalar that multiplies anything."""

    shape: Shape | None
    terms: dict[Term, Fraction]

    @property
    def T(self) -> "Expression":  # noqa: N802 - the name that NumPy gave it
        """The transpose."""
        if self.shape is None:
            return self
        turned = {(scalars, _turned(word)): value for (scalars, word), value in self.terms.items()}
        return _sum((self.shape[1], self.shape[0]), turned.items())

    def __add__(self, other: "Expression") -> "Expression":
        if self.shape != other.shape:
            raise refused(f"{self.shape} + {other.shape}", "must add expressions of one shape")
        return _sum(self.shape, [*self.terms.items(), *other.terms.items()])

    def __mul__(self, other: "Expression") -> "Expression":
        shape = self.shape or other.shape
        if self.shape and other.shape:
            if self.shape[1] != other.shape[0]:
                raise refused(f"{self.shape} * {other.shape}", "must multiply shapes that fit")
            shape = (self.shape[0], other.shape[1])
        products = [
            ((tuple(sorted(s + t)), _reduced(x + y)), a * b)
            for (s, x), a in self.terms.items()
            for (t, y), b in other.terms.items()
        ]
        return _sum(shape, products)


def _sum(shape: Shape | None, parts: Any) -> Expression:
    terms: dict[Term, Fraction] = {}
    for (scalars, word), value in parts:
        same = min(word, _turned(word)) if shape == ("1", "1") else word
        terms[scalars, same] = terms.get((scalars, same), Fraction(0)) + value
    return Expression(shape, {term: value for term, value in terms.items() if value})


def _turned(word: tuple[Letter, ...]) -> tuple[Letter, ...]:
    return tuple((name, not turned and name not in SYMMETRIC) for name, turned in reversed(word))


def _reduced(word: tuple[Letter, ...]) -> tuple[Letter, ...]:
    """Cancel E Ei and Ei E."""
    kept: list[Letter] = []
    for letter in word:
        if kept and (kept[-1][0], letter[0]) in INVERSES:
            kept.pop()
        else:
            kept.append(letter)
    return tuple(kept)


class _Matrices:
    """Sums of words."""

    def name(self, name: str) -> Expression:
        one = Fraction(1)
        if name not in SHAPES:
            return Expression(None, {((name,), ()): one})
        return Expression(SHAPES[name], {((), () if name in UNITS else ((name, False),)): one})

    def number(self, value: int) -> Expression:
        return Expression(None, {((), ()): Fraction(value)} if value else {})

    def divide(self, left: Expression, right: Expression) -> Expression:
        number = right.terms.get(((), ()))
        if right.shape is not None or len(right.terms) != 1 or number is None:
            raise refused("/", "must divide by a number other than 0: multiply it out")
        return left * Expression(None, {((), ()): 1 / number})

    def absolute(self, value: Expression) -> Expression:
        raise refused("abs", "must not stand in a matrix identity")

    def every(self, values: list[Any]) -> Any:
        raise refused("and", "must not stand in a matrix identity")

    def some(self, values: list[Any]) -> Any:
        raise refused("or", "must not stand in a matrix identity")

    def negation(self, value: Any) -> Any:
        raise refused("not", "must not stand in a matrix identity")
