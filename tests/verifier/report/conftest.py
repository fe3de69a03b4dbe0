"""Figures are drawn once for the same numbers: drawing takes most of the time of a report."""

import json
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from verification.report.experiments import catalogue
from verification.report.plots import plot

Draw = Callable[..., str]


def remembered(draw: Draw, plain: Callable[..., Any]) -> Draw:
    """`draw`, which is called once for the same arguments; `plain` tells them as plain data."""
    known: dict[str, str] = {}

    def once(*given: Any) -> str:
        key = json.dumps(plain(*given), default=np.ndarray.tolist)
        if key not in known:
            known[key] = draw(*given)
        return known[key]

    return once


def told(draw: partial[None], *given: Any) -> tuple[Any, ...]:
    """All that a figure of the experiments depends on: its function, its numbers, and how it is named."""
    plan, pictures, design = draw.args
    return plan.name, plan.draw.__qualname__, pictures, design, given


PLACES: dict[str, tuple[Draw, Draw]] = {
    "verification.report.page.plot": (plot, remembered(plot, lambda *given: given)),
    "verification.report.experiments.catalogue.drawn": (catalogue.drawn, remembered(catalogue.drawn, told)),
}
"""Where a figure is asked for: what draws it, and what draws it once."""


@pytest.fixture(scope="module", autouse=True)
def _figures_drawn_once() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patched:
        for place, (_, once) in PLACES.items():
            patched.setattr(place, once)
        yield


@pytest.fixture
def drawn_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every figure is drawn, also where the same numbers were drawn before: for tests of the drawing."""
    for place, (draw, _) in PLACES.items():
        monkeypatch.setattr(place, draw)
