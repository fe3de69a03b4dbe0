"""Problems whose data are rational numbers: of a `Problem` of floats, of small integers, and as JSON."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import islice
from typing import Any

import numpy as np

from convexperc.errors import FileFormatError, ProblemError
from convexperc.problem.problem import Problem
from verification.exact.numbers import Rational, integers

Whole = tuple[int, ...]
NUMBER = re.compile(r"-?[0-9]+(/[1-9][0-9]*)?")
LAMBDAS = ("lambda1", "lambda2", "lambda3")


@dataclass(frozen=True)
class ExactProblem:
    """The data of Eq. (full) as rational numbers: integers over the least common denominator.

    Attributes
    ----------
    rows : tuple of n tuples of d int
        X times `unit`.
    unit : int
    target : tuple of d int
        o times `target_unit`.
    target_unit : int
    groups : tuple of tuples of int
        The columns of each modality.
    lambda1, lambda2, lambda3 : Fraction
    """

    rows: tuple[Whole, ...]
    unit: int
    target: Whole
    target_unit: int
    groups: tuple[Whole, ...]
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: "Problem | ExactProblem") -> "ExactProblem":
        """Take the floats of a `Problem` as the rationals that they are."""
        if isinstance(problem, ExactProblem):
            return problem
        columns = np.arange(problem.d)
        groups = tuple(tuple(columns[part].tolist()) for part in problem.modalities)
        return cls._from(problem.X.tolist(), problem.o.tolist(), groups, problem.lambdas)

    @classmethod
    def small(
        cls, X: Sequence[Sequence[Any]], o: Sequence[Any], sizes: Sequence[int], *lambdas: Any
    ) -> "ExactProblem":
        """Build it from integers, Fractions or strings p/q; `sizes` is like ``[2, 1]``."""
        rows = [[Fraction(x) for x in row] for row in X]
        return cls._from(rows, [Fraction(x) for x in o], _groups(sizes), lambdas)

    @classmethod
    def _from(
        cls, X: Sequence[Sequence[Any]], o: Sequence[Any], groups: tuple[Whole, ...], lambdas: Iterable[Any]
    ) -> "ExactProblem":
        whole, unit = integers(x for row in X for x in row)
        entries = iter(whole)
        rows = tuple(tuple(islice(entries, len(row))) for row in X)
        target, target_unit = integers(o)
        return cls(rows, unit, tuple(target), target_unit, groups, *(Fraction(x) for x in lambdas))

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
        if not found.rows or any(len(row) != found.d for row in found.rows):
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
        return len(self.rows)

    @property
    def d(self) -> int:
        """Number of features."""
        return len(self.target)

    @property
    def m(self) -> int:
        """Number of modalities."""
        return len(self.groups)

    @property
    def lambdas(self) -> Rational:
        """(lambda1, lambda2, lambda3)."""
        return self.lambda1, self.lambda2, self.lambda3

    @cached_property
    def X(self) -> tuple[Rational, ...]:  # noqa: N802 - the matrix of Eq. (full)
        """X by rows, n tuples of d Fractions."""
        return tuple(tuple(Fraction(x, self.unit) for x in row) for row in self.rows)

    @cached_property
    def columns(self) -> tuple[Rational, ...]:
        """X by columns, d tuples of n Fractions."""
        return tuple(zip(*self.X, strict=True))

    @cached_property
    def o(self) -> Rational:
        """The template, d Fractions."""
        return tuple(Fraction(x, self.target_unit) for x in self.target)

    @property
    def numbers(self) -> Iterator[Fraction]:
        """Every number of the data."""
        for row in self.X:
            yield from row
        yield from self.o
        yield from self.lambdas

    def for_template(self, o: Sequence[Fraction]) -> "ExactProblem":
        """Return the same problem for another template, d Fractions."""
        target, unit = integers(o)
        return replace(self, target=tuple(target), target_unit=unit)

    def scaled(self, s: Fraction, t: Fraction) -> "ExactProblem":
        """Return the problem whose X is s times this one's and whose F* is t^2 times as large, s, t > 0.

        Formula: X by s, o by t, lambda1 by s^2, lambda2 by s t, lambda3 by s^2 t.
        """
        X = [[s * x for x in row] for row in self.X]
        factors = s * s, s * t, s * s * t
        lambdas = [x * factor for x, factor in zip(self.lambdas, factors, strict=True)]
        return self._from(X, [t * x for x in self.o], self.groups, lambdas)

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


def _groups(sizes: Sequence[int]) -> tuple[Whole, ...]:
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
