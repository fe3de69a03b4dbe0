"""Plain data: what JSON, XML and HTML can hold."""

import math
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

UNPRINTABLE = re.compile(r"[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, and HTML should not."""


def plain(value: Any) -> Any:
    """JSON data; "inf", "-inf" and "nan" where JSON has no number, "?" for what no file can hold."""
    if is_dataclass(value):
        return {each.name: plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Mapping):
        return {plain(str(key)): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return printable(str(value)) if isinstance(value, str) else value


def printable(text: str) -> str:
    """The text with "?" for what no file can hold."""
    return UNPRINTABLE.sub("?", text)
