"""Problems whose data are rational numbers: of a `Problem` of floats, of small integers, and as JSON."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from convexperc.errors import FileFormatError, ProblemError
from convexperc.problem.problem import Problem

Rational = tuple[Fraction, ...]
NUMBER = re.compile(r"-?[0-9]+(/[1-9][0-9]*)?")
LAMBDAS = ("lambda1", "lambda2", "lambda3")


@dataclass(frozen=True)
class ExactProblem:
    """The data of Eq. (full) as rational numbers.

    Attributes
    ----------
    X : tuple of n tuples of d Fractions
    o : tuple of d Fractions
    groups : tuple of tuples of int
        The columns of each modality.
    lambda1, lambda2, lambda3 : Fraction
    """

    X: tuple[Rational, ...]
    o: Rational
    groups: tuple[tuple[int, ...], ...]
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: Problem) -> "ExactProblem":
        """Take the floats of `problem` as the rationals that they are."""
        X = tuple(tuple(Fraction(float(x)) for x in row) for row in problem.X)
        groups = tuple(tuple(int(c) for c in np.arange(problem.d)[cols]) for cols in problem.modalities)
        o = tuple(Fraction(float(x)) for x in problem.o)
        return cls(X, o, groups, *(Fraction(value) for value in problem.lambdas))

    @classmethod
    def small(
        cls, X: Sequence[Sequence[Any]], o: Sequence[Any], sizes: Sequence[int], *lambdas: Any
    ) -> "ExactProblem":
        """Build it from integers, Fractions or strings p/q; `sizes` is like ``[2, 1]``."""
        rows = tuple(tuple(Fraction(x) for x in row) for row in X)
        return cls(rows, tuple(Fraction(x) for x in o), _groups(sizes), *(Fraction(x) for x in lambdas))

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "ExactProblem":
        """Read what `as_json` wrote.

        Raises
        ------
        FileFormatError
            Numbers that are no strings p/q, shapes that do not fit, modalities that are no partition, or a
            negative lambda.
        """
        sizes = data["modalities"]
        if not isinstance(sizes, list) or not all(type(size) is int and size > 0 for size in sizes):
            must = "must be a list of sizes, whole numbers >= 1"
            raise FileFormatError("problem: modalities", value=sizes, must=must)
        X = [_written(row, "X") for row in data["X"]]
        lambdas = _written([data[name] for name in LAMBDAS], "lambda1 .. lambda3")
        found = cls.small(X, _written(data["o"], "o"), sizes, *lambdas)
        if not found.X or any(len(row) != found.d for row in found.X):
            must = f"must have rows of {found.d} entries, as o has"
            raise FileFormatError("problem: X", value=data["X"], must=must)
        if sum(len(group) for group in found.groups) != found.d:
            must = f"must be sizes that add up to {found.d}, the number of columns"
            raise FileFormatError("problem: modalities", value=data["modalities"], must=must)
        for name, value in zip(LAMBDAS, found.lambdas, strict=True):
            if value < 0:
                raise FileFormatError(f"problem: {name}", value=str(value), must="must be >= 0")
        return found

    def as_json(self) -> dict[str, Any]:
        """Plain data with numbers as strings p/q.

        Raises
        ------
        ProblemError
            The columns of a modality do not follow each other.
        """
        sizes = [len(group) for group in self.groups]
        if _groups(sizes) != self.groups:
            must = "must follow each other, modality by modality, in a record"
            raise ProblemError("the columns of the modalities", value=self.groups, must=must)
        data: dict[str, Any] = {"X": [texts(row) for row in self.X], "o": texts(self.o), "modalities": sizes}
        return data | dict(zip(LAMBDAS, texts(self.lambdas), strict=True))

    @property
    def n(self) -> int:
        """Number of robots."""
        return len(self.X)

    @property
    def d(self) -> int:
        """Number of features."""
        return len(self.o)

    @property
    def m(self) -> int:
        """Number of modalities."""
        return len(self.groups)

    @property
    def lambdas(self) -> Rational:
        """(lambda1, lambda2, lambda3)."""
        return self.lambda1, self.lambda2, self.lambda3

    @property
    def numbers(self) -> Iterator[Fraction]:
        """Every number of the data."""
        for row in self.X:
            yield from row
        yield from self.o
        yield from self.lambdas

    @cached_property
    def columns(self) -> tuple[Rational, ...]:
        """X by columns."""
        return tuple(zip(*self.X, strict=True))

    def for_template(self, o: Sequence[Fraction]) -> "ExactProblem":
        """The same problem for another template."""
        return replace(self, o=tuple(o))

    def in_floats(self) -> Problem | None:
        """The same problem in float64, or None where a number is not representable."""
        try:
            rounded = [float(value) for value in self.numbers]
        except OverflowError:
            return None
        if [Fraction(value) for value in rounded] != list(self.numbers):
            return None
        X = [[float(x) for x in row] for row in self.X]
        l1, l2, l3 = (float(value) for value in self.lambdas)
        named = {f"m{i}": list(group) for i, group in enumerate(self.groups, 1)}
        o = [float(x) for x in self.o]
        return Problem(X, o, modalities=named, lambda1=l1, lambda2=l2, lambda3=l3)


def _groups(sizes: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    starts = [sum(sizes[:i]) for i in range(len(sizes))]
    return tuple(tuple(range(at, at + size)) for at, size in zip(starts, sizes, strict=True))


def _written(values: Any, name: str) -> Rational:
    """Read strings p/q, and nothing else."""
    if not isinstance(values, list) or not all(isinstance(v, str) and NUMBER.fullmatch(v) for v in values):
        raise FileFormatError(f"problem: {name}", value=values, must="must be strings p/q")
    return tuple(Fraction(value) for value in values)


def texts(values: Sequence[Fraction]) -> list[str]:
    """Each number as p/q."""
    return [str(value) for value in values]
