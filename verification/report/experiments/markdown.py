"""The section on the experiments as Markdown."""

from collections.abc import Iterator, Sequence

from verification.report.experiments.blocks import Block, Heading, Listing, Paragraph, Picture, Sheet, Table
from verification.report.marks import marked, prose, table


def lines(blocks: Sequence[Block], level: int, folder: str = "", sheets: str = "sheets") -> Iterator[str]:
    """The lines of all blocks.

    Parameters
    ----------
    blocks : sequence of Block
    level : int
        Of the headings.
    folder : str
        Where figures/ lies, with a slash at its end; "-" names the drawings and shows none.
    sheets : str
        Where the contact sheets lie.
    """
    for block in blocks:
        match block:
            case Heading():
                yield f"{'#' * (level + block.level)} {prose(block.text)}"
            case Paragraph():
                yield prose(block.text)
            case Listing():
                yield from (f"- **{prose(name)}:** {marked(text)}" for name, text in block.items)
            case Table():
                yield from _table(block)
            case Picture(drawing):
                caption = f"{drawing.title}. {drawing.caption}"
                yield from _shown(caption, f"{folder}figures/{drawing.name}.svg", folder)
            case Sheet():
                yield from _shown(block.caption, f"{sheets}/{block.name}.jpg", folder)
        yield ""


def _table(block: Table) -> Iterator[str]:
    yield from (f"{prose(block.title)}:", "")
    yield from table(map(prose, block.head), (map(prose, row) for row in block.rows))


def _shown(caption: str, place: str, folder: str) -> Iterator[str]:
    if folder == "-":
        yield f"*Drawing in report.html:* {prose(caption)}"
    else:
        yield from (f"![{prose(caption.partition('.')[0])}]({place})", "", prose(caption))
