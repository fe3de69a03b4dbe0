"""Exit codes, and errors of the caller as misuse: code 2, with the option that is to blame."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import typer

from convexperc.errors import InputError
from convexperc.files import check_apart, check_place

FAILED, OPEN = 1, 3
"""Exit codes: something was found; a run was broken off or left something open. 2, of misuse, is typer's."""


@contextmanager
def misuse(hint: str) -> Iterator[None]:
    """Files that cannot be read or written, and what is not what it should be, as misuse of this option.

    Where no option is to blame, as for a missing extra, the error passes: the program says it in one line.
    """
    try:
        yield
    except (OSError, InputError) as problem:
        raise typer.BadParameter(str(problem), param_hint=hint) from None


def check_places(inputs: Mapping[str, Path | None] | None = None, **places: Path | None) -> None:
    """Refuse files that cannot be written, or are an input or one another: before the work, not after it.

    `places` has them by the name of their option, `inputs` what is read.
    """
    check_apart({f"--{option}": place for option, place in places.items()}, inputs=inputs)
    for option, place in places.items():
        if place is not None:
            with misuse(f"--{option}"):
                check_place(place)
