"""What every figure is drawn with: Matplotlib's own settings and a style, whatever the caller has chosen."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from typing import Any

import matplotlib as mpl
from matplotlib.font_manager import FontProperties, findfont, get_font

from convexperc.errors import escaped

FAMILY = "DejaVu Sans"
"""The font, which comes with Matplotlib."""


@contextmanager
def settings(style: Mapping[str, Any]) -> Iterator[None]:
    """Draw by Matplotlib's defaults and `style`, so that equal input gives equal bytes.

    Settings of the caller and of its files have no effect, and are as before afterwards; its backend is never
    looked at.
    """
    chosen: dict[Any, Any] = {name: value for name, value in mpl.rcParamsDefault.items() if name != "backend"}
    with mpl.rc_context(chosen | {"font.family": FAMILY} | dict(style)):
        yield


def drawable(text: str) -> str:
    """Escape what cannot be printed safely, and each character that the font does not have."""
    known = _characters()
    return "".join(
        each if ord(each) in known else each.encode("unicode_escape").decode("ascii")
        for each in escaped(text)
    )


@cache
def _characters() -> frozenset[int]:
    """The code points that both weights of the font have."""
    files = (findfont(FontProperties(family=FAMILY, weight=weight)) for weight in ("normal", "bold"))
    normal, bold = (get_font(file).get_charmap().keys() for file in files)
    return frozenset(normal & bold)
