"""`cached_property` without the lock that Python 3.11 takes for it, which costs more than most values."""

import functools
import sys
from typing import TYPE_CHECKING, Any

__all__ = ["cached_property"]


class _CachedProperty(functools.cached_property[Any]):
    """A property that is computed once and then lies in the instance's dictionary.

    Two threads that ask at once may both compute it; that has to give the same value.
    """

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        if instance is None:
            return self
        assert self.attrname is not None  # known once the class is made
        found = instance.__dict__[self.attrname] = self.func(instance)
        return found


if TYPE_CHECKING or sys.version_info >= (3, 12):
    cached_property = functools.cached_property
else:
    cached_property = _CachedProperty
