"""What a planted fault is, and how it is planted and taken out again."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

PACKAGE = "convexperc"


class Setter(Protocol):
    """What plants a fault: `Patcher`, or `pytest.MonkeyPatch`."""

    def setattr(self, target: Any, name: str, value: Any) -> None:
        """Replace an attribute."""


@dataclass
class Patcher:
    """Replaces attributes of modules and classes, and puts every one back.

    Attributes
    ----------
    before : list of (object, str, object)
        What was replaced: where, its name, and what was there.
    """

    before: list[tuple[Any, str, Any]] = field(default_factory=list)

    def setattr(self, target: Any, name: str, value: Any) -> None:
        """Replace an attribute that `target` itself has: a method's wrapper is kept as it is."""
        self.before.append((target, name, vars(target)[name]))
        setattr(target, name, value)

    def undo(self) -> None:
        """Put everything back, the last change first."""
        while self.before:
            target, name, value = self.before.pop()
            setattr(target, name, value)


Plant = Callable[[Setter], None]


@dataclass(frozen=True)
class Fault:
    """A fault.

    Attributes
    ----------
    name : str
    part : str
        The part of a claim that must name it, a key of `verification.ledger.claims.PARTS`.
    plant : callable
        Takes a `Setter`.
    also : tuple of str
        Parts of the same check that must name it as well.
    may : tuple of str
        Parts of the same check that it makes false too, but not under every draw of problems.
    """

    name: str
    part: str
    plant: Plant
    also: tuple[str, ...] = ()
    may: tuple[str, ...] = ()

    @contextmanager
    def planted(self) -> Iterator[Patcher]:
        """Plant it for a while; it is taken out again, whatever happens."""
        patcher = Patcher()
        try:
            self.plant(patcher)
            yield patcher
        finally:
            patcher.undo()


def replaced(target: Any, name: str, value: Any) -> Plant:
    """Put something else in one place."""
    return lambda setter: setter.setattr(target, name, value)


def wrapped(target: Any, name: str, change: Callable[..., Any]) -> Plant:
    """Change what one function returns: `change` takes that and the function's arguments."""
    original = getattr(target, name)
    return replaced(target, name, lambda *a, **k: change(original(*a, **k), *a))


def everywhere(original: Callable[..., Any], replacement: Callable[..., Any]) -> Plant:
    """Replace a function in every loaded module of the library that holds it."""

    def plant(setter: Setter) -> None:
        modules = [m for key, m in sys.modules.items() if key.split(".")[0] == PACKAGE]
        for module in modules:
            for name in [key for key, value in vars(module).items() if value is original]:
                setter.setattr(module, name, replacement)

    return plant


def together(*plants: Plant) -> Plant:
    """Several changes that make one fault."""

    def plant(setter: Setter) -> None:
        for each in plants:
            each(setter)

    return plant
