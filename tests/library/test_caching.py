"""Values that are computed once."""

import inspect

from convexperc.caching import _CachedProperty, cached_property


class Counted:
    """Counts how often its square is computed."""

    def __init__(self, side: int) -> None:
        self.side, self.times = side, 0

    @cached_property
    def square(self) -> int:
        """Side times side."""
        self.times += 1
        return self.side * self.side

    again = _CachedProperty(lambda self: self.side * self.side)


def test_the_value_is_computed_once_and_can_be_forgotten():
    three = Counted(3)
    assert (three.square, three.square, three.times) == (9, 9, 1)
    three.side = 4
    assert three.square == 9
    del three.square
    assert (three.square, three.times) == (16, 2)
    assert (three.again, vars(three)["again"]) == (16, 16)


def test_two_objects_have_values_of_their_own():
    assert (Counted(2).square, Counted(5).square) == (4, 25)


def test_the_class_shows_the_property_and_its_docstring():
    assert inspect.getdoc(Counted.square) == "Side times side."
    assert isinstance(Counted.again, _CachedProperty)
