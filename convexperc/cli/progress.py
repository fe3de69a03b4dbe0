"""Progress displays on stderr, if that is a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from convexperc.errors import escaped


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
    console = Console(stderr=True)
    columns = TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(first, total=None)

        def expect(steps: int) -> None:
            bar.update(task, total=steps)

        def step(name: str) -> None:
            bar.update(task, description=escaped(f"{done} {name}"), advance=1)

        yield expect, step


@contextmanager
def working(what: str) -> Iterator[None]:
    """Show a text and the elapsed time, for work of unknown length."""
    console = Console(stderr=True)
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as line:
        line.add_task(what, total=None)
        yield
