"""Progress displays on stderr, if that is a terminal; only then is Rich's loaded."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from convexperc.errors import escaped

if TYPE_CHECKING:
    from rich.progress import Progress


@contextmanager
def progress(first: str, done: str) -> Iterator[tuple[Callable[[int], None], Callable[[str], None]]]:
    """Show a progress bar; yield a function to set the number of steps, and one to call after each step.

    Parameters
    ----------
    first : str
        Text before the first step is finished.
    done : str
        Prefix of the name of each finished step.
    """
    if not _is_terminal():
        yield lambda steps: None, lambda name: None
        return
    with _display() as bar:
        task = bar.add_task(first, total=None)

        def expect(steps: int) -> None:
            bar.update(task, total=steps)

        def step(name: str) -> None:
            bar.update(task, description=escaped(f"{done} {name}"), advance=1)

        yield expect, step


@contextmanager
def working(what: str) -> Iterator[None]:
    """Show a text and the elapsed time, for work of unknown length."""
    if not _is_terminal():
        yield
        return
    with _display(spinner=True) as line:
        line.add_task(what, total=None)
        yield


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _display(spinner: bool = False) -> "Progress":
    """Return a line with a bar or a spinner, the text, and the elapsed time, which is gone at the end."""
    from rich.console import Console  # noqa: PLC0415 - takes as long to load as --help
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    text = TextColumn("{task.description}", markup=False)
    columns: tuple[Any, ...] = (SpinnerColumn(), text) if spinner else (text, BarColumn())
    return Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True), transient=True)
