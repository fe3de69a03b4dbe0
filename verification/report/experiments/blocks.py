"""What the section on the experiments is made of: plain blocks that a page and Markdown render alike."""

from dataclasses import dataclass
from typing import ClassVar

from verification.report.experiments.catalogue import Drawing


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading within the section.

    Attributes
    ----------
    text : str
    level : int
        0 for a part of the section, 1 within a part.
    """

    text: str
    level: int = 0
    kind: ClassVar[str] = "heading"


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Sentences."""

    text: str
    kind: ClassVar[str] = "paragraph"


@dataclass(frozen=True, slots=True)
class Listing:
    """Points, each with a word in front or none."""

    items: tuple[tuple[str, str], ...]
    kind: ClassVar[str] = "listing"


@dataclass(frozen=True, slots=True)
class Table:
    """A table; the first column is a heading.

    Attributes
    ----------
    title : str
    head : tuple of str
    rows : tuple of tuple of str
    words : tuple of int
        Columns that hold words; the others hold numbers.
    folded : bool
        Whether a page shows it on demand.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: tuple[int, ...] = (0,)
    folded: bool = False
    kind: ClassVar[str] = "table"

    def __post_init__(self) -> None:
        if any(len(row) != len(self.head) for row in self.rows):
            raise ValueError(f"rows of {self.title!r} do not fit its head")


@dataclass(frozen=True, slots=True)
class Picture:
    """A drawing."""

    drawing: Drawing
    kind: ClassVar[str] = "picture"


@dataclass(frozen=True, slots=True)
class Sheet:
    """A contact sheet.

    Attributes
    ----------
    name : str
        Of its file, without an ending.
    caption : str
    data : bytes
        JPEG.
    """

    name: str
    caption: str
    data: bytes
    kind: ClassVar[str] = "sheet"


Block = Heading | Paragraph | Listing | Table | Picture | Sheet
