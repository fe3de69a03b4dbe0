"""Text, code and tables in Markdown, whatever signs they hold."""

import re
from collections.abc import Iterable, Iterator


def prose(text: object) -> str:
    """Text in one line whose signs mean nothing to Markdown or HTML."""
    return _escaped(" ".join(str(text).split()))


def _escaped(line: str) -> str:
    line = line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]|#~])", r"\\\1", line)


def code(text: object) -> str:
    """Text in one line as code, whatever backticks it holds."""
    line = " ".join(str(text).split())
    fence = "`" * (1 + max([len(run) for run in re.findall("`+", line)], default=0))
    blank = " " if "`" in line else ""
    return f"{fence}{blank}{line}{blank}{fence}" if line else ""


def marked(text: object) -> str:
    """Prose in which what stands between single backticks is code."""
    pieces = re.split(r"`([^`]*)`", " ".join(str(text).split()))
    return "".join(code(piece) if at % 2 else _escaped(piece) for at, piece in enumerate(pieces))


def table(head: Iterable[object], rows: Iterable[Iterable[object]]) -> Iterator[str]:
    """A table; cells must be marked up already."""
    titles = [str(title) for title in head]
    yield f"| {' | '.join(titles)} |"
    yield f"|{'---|' * len(titles)}"
    for row in rows:
        yield f"| {' | '.join(str(cell) for cell in row)} |"
