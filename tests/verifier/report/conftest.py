"""Figures are drawn once for the same numbers: drawing takes most of the time of a report."""

import pickle
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from verification.report.experiments import catalogue
from verification.report.plots import plot


def remembered(draw: Callable[..., str], plain: Callable[..., Any]) -> Callable[..., str]:
    """`draw`, which is called once for the same arguments; `plain` makes data of them that can be pickled."""
    known: dict[bytes, str] = {}

    def once(*given: Any) -> str:
        key = pickle.dumps(plain(*given))
        if key not in known:
            known[key] = draw(*given)
        return known[key]

    return once


def parts(draw: partial[None], *given: Any) -> tuple[Any, ...]:
    """All that a figure of the experiments depends on: its function, its numbers, and how it is named."""
    plan, pictures, design = draw.args
    return plan.name, plan.draw, pictures, design, given


PLOT = remembered(plot, lambda *given: given)
DRAWN = remembered(catalogue.drawn, parts)


@pytest.fixture(autouse=True)
def _figures_drawn_once(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not where a test asks for `drawn_anew`, as it is about the drawing."""
    if "drawn_anew" not in request.fixturenames:
        monkeypatch.setattr("verification.report.page.plot", PLOT)
        monkeypatch.setattr("verification.report.experiments.catalogue.drawn", DRAWN)


@pytest.fixture
def drawn_anew() -> None:
    """Every figure is drawn, also where the same numbers were drawn before."""
