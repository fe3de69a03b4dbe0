"""Exit codes, and errors of the caller as misuse: code 2, with the option that is to blame."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import typer

FAILED, OPEN = 1, 3
"""Exit codes: something was found; a run was broken off or left something open. 2, of misuse, is typer's."""


@contextmanager
def misuse(hint: str) -> Iterator[None]:
    """Files that cannot be read or written, and what is not what it should be, as misuse.

    A missing extra passes: no option is to blame for it, and the entry point says it in one line.
    """
    from convexperc.errors import ConvexpercError, MissingExtraError  # noqa: PLC0415 - keeps --help quick

    try:
        yield
    except MissingExtraError:
        raise
    except (OSError, ConvexpercError) as problem:
        raise typer.BadParameter(str(problem), param_hint=hint) from None


def check_places(inputs: Mapping[str, Path | None] | None = None, **places: Path | None) -> None:
    """Refuse files that cannot be written, or are an input or one another: before the work, not after it.

    `places` has them by the name of their option, `inputs` what is read.
    """
    from convexperc.files import check_place  # noqa: PLC0415 - keeps --help quick

    check_outputs({f"--{option}": place for option, place in places.items()}, inputs)
    for option, place in places.items():
        if place is not None:
            with misuse(f"--{option}"):
                check_place(place)


def check_outputs(
    files: Mapping[str, Path | None],
    inputs: Mapping[str, Path | None] | None = None,
    folders: Mapping[str, Path | None] | None = None,
) -> None:
    """Refuse outputs that are an input or one another, see `convexperc.files.check_apart`."""
    from convexperc.files import check_apart  # noqa: PLC0415 - keeps --help quick

    with misuse("outputs"):
        check_apart(files, folders=folders, inputs=inputs)
