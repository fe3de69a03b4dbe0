"""Rational numbers: sums, products and enclosed roots against plain Fractions."""

from fractions import Fraction

import numpy as np

from verification.exact.balls import enclosed, exact, root
from verification.exact.numbers import (
    Enclosure,
    inner,
    integers,
    objects,
    rationals,
    square_root,
    squares,
    times,
    total,
)

MIXED = [Fraction(1, 3), Fraction(-5, 6), Fraction(7), Fraction(0), Fraction(2**900, 3), Fraction(1, 2**1074)]
OTHER = [
    Fraction(2, 9),
    Fraction(11, 4),
    Fraction(-1, 5),
    Fraction(8),
    Fraction(3, 2**900),
    Fraction(2**1000),
]


def test_sums_and_products_are_those_of_fractions() -> None:
    products = [x * y for x, y in zip(MIXED, OTHER, strict=True)]
    assert total(MIXED) == sum(MIXED)
    assert inner(MIXED, OTHER) == sum(products)
    assert squares(MIXED) == sum(x * x for x in MIXED)
    matrix = objects([*MIXED, *OTHER], (2, 6))
    assert times(matrix, rationals(OTHER)).tolist() == [sum(products), sum(x * x for x in OTHER)]
    assert (total([]), inner([], [])) == (0, 0)


def test_integers_have_the_least_common_denominator() -> None:
    assert integers([Fraction(1, 6), Fraction(3, 4), Fraction(2)]) == ([2, 9, 24], 12)
    assert integers([0.75, -2.0, 5e-324]) == ([3 * 2**1072, -(2**1075), 1], 2**1074)
    assert integers([]) == ([], 1)


def test_floats_are_the_rationals_that_they_are() -> None:
    found = rationals(np.array([0.1, -5e-324]))
    assert found.tolist() == [Fraction(0.1), Fraction(-1, 2**1074)]
    assert found.dtype == object


def test_square_roots_are_enclosed_and_exact_where_they_are_dyadic() -> None:
    for value in (Fraction(0), Fraction(9, 4), Fraction(1, 2**1200), Fraction(10**400)):
        root = square_root(value)
        assert root.lower**2 <= value <= root.upper**2, (value, root)
        assert root.width == 0, (value, root)
    for value in (Fraction(2), Fraction(1.5e-323), Fraction(1, 3), Fraction(3 * 2**2001)):
        root = square_root(value)
        assert root.lower**2 < value < root.upper**2, (value, root)
        assert root.width <= root.upper / 2**200, (value, root)


def test_roots_are_rational_where_they_can_be() -> None:
    assert enclosed(root(exact(Fraction(16, 9)))) == Enclosure(Fraction(4, 3), Fraction(4, 3))
    assert square_root(Fraction(16, 9)) == Enclosure(Fraction(4, 3), Fraction(4, 3))
    two = enclosed(root(exact(2)))
    assert two.lower**2 < 2 < two.upper**2, two
