"""One loop of the gallery, and the small data that instances of it are drawn from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hypothesis import strategies as st

from verification.reweighted.loops.instances import Build

SMALL = 3
"""Size of the integers in the data."""


@dataclass(frozen=True)
class Case:
    """A loop as it is printed somewhere, or repaired.

    Attributes
    ----------
    id : str
    title : str
    source : str
        Author, year, where.
    objective, update : str
        Formulas, in plain text.
    build : function
        Returns the `Loop` for the data.
    data : mapping of str to Hypothesis strategy
    repair : str
        What repairs it, or the id of the case that does; empty where nothing is wrong.
    """

    id: str
    title: str
    source: str
    objective: str
    update: str
    build: Build
    data: Mapping[str, st.SearchStrategy[Any]]
    repair: str = ""


def numbers(low: int = -SMALL, high: int = SMALL) -> st.SearchStrategy[int]:
    """Small integers."""
    return st.integers(low, high)


def vector(size: int) -> st.SearchStrategy[list[int]]:
    """A vector of small integers."""
    return st.lists(numbers(), min_size=size, max_size=size)


def matrix(rows: int, columns: int) -> st.SearchStrategy[list[list[int]]]:
    """A matrix of small integers."""
    return st.lists(vector(columns), min_size=rows, max_size=rows)


def points(most: int = 6, largest: int = 9) -> st.SearchStrategy[list[tuple[int, ...]]]:
    """Up to `most` points on a line or in a plane."""
    return st.integers(1, 2).flatmap(
        lambda size: st.lists(st.tuples(*[numbers(-largest, largest)] * size), min_size=2, max_size=most)
    )
