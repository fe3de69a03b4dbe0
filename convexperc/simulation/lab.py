"""The lab: a furnished room, seen by small robots on its floor."""

from collections.abc import Iterator

from convexperc.simulation.obstacles import cardboard_box
from convexperc.simulation.parts import Part, box, disc
from convexperc.simulation.pose import placed

ROOM_SIDE = 6.0
"""Side of the square room around the object, in metres."""

WALL_HEIGHT = 2.5
"""Height of the walls in metres; there is no ceiling, so that the overhead camera sees the room."""


def lab() -> Iterator[Part]:
    """Yield a room whose walls differ in colour and furniture.

    Each wall is built at x = ROOM_SIDE / 2 and rotated into place.
    """
    yield box("vinyl", (ROOM_SIDE, ROOM_SIDE, 0.08), (0.0, 0.0, -0.04))
    sides = (
        (0.0, "wall-sand", _entrance()),
        (90.0, "wall-sage", _library()),
        (180.0, "wall-blue", _desk()),
        (270.0, "wall-clay", _store()),
    )
    for turn, paint, furniture in sides:
        yield from placed(_wall(paint), rotation=(0.0, 0.0, turn))
        yield from placed(furniture, rotation=(0.0, 0.0, turn))


def _wall(paint: str) -> Iterator[Part]:
    """Yield a wall with its skirting board."""
    yield box(paint, (0.1, ROOM_SIDE + 0.1, WALL_HEIGHT), (ROOM_SIDE / 2 + 0.05, -0.05, WALL_HEIGHT / 2))
    yield box("skirting", (0.02, ROOM_SIDE, 0.1), (ROOM_SIDE / 2 - 0.01, 0.0, 0.05))


def _entrance() -> Iterator[Part]:
    """Yield a door in its frame, a cabinet of drawers and a chair."""
    wall = ROOM_SIDE / 2
    yield box("skirting", (0.06, 1.06, 2.13), (wall - 0.01, 0.6, 1.065))
    yield box("door", (0.06, 0.9, 2.05), (wall - 0.03, 0.6, 1.03))
    yield box("steel", (0.06, 0.12, 0.025), (wall - 0.08, 0.26, 1.02))
    yield box("steel", (0.01, 0.8, 0.2), (wall - 0.062, 0.6, 0.14))
    yield box("cabinet", (0.45, 0.5, 1.1), (wall - 0.25, -0.65, 0.55))
    for z in (0.2, 0.55, 0.9):
        yield box("steel", (0.02, 0.44, 0.3), (wall - 0.48, -0.65, z))
        yield box("ink", (0.03, 0.16, 0.02), (wall - 0.49, -0.65, z + 0.08))
    yield from placed(_chair(), (wall - 0.5, -1.75, 0.0), (0.0, 0.0, 160.0))


def _library() -> Iterator[Part]:
    """Yield two shelves with rows of books, and a plain post between them."""
    for y, books in ((-0.85, 0), (1.15, 2)):
        yield from placed(_shelves(books), (ROOM_SIDE / 2 - 0.17, y, 0.0))
    yield box("carton", (0.3, 0.4, 0.28), (ROOM_SIDE / 2 - 0.22, 2.5, 0.14))


def _shelves(first: int) -> Iterator[Part]:
    """Yield a case of four shelves, 1.5 m wide, its books to -x."""
    width, height = 1.5, 1.9
    colours = ("book-red", "book-blue", "book-ochre", "book-green", "paper")
    yield box("furniture", (0.02, width, height), (0.14, 0.0, height / 2))
    for y in (-width / 2, width / 2):
        yield box("furniture", (0.3, 0.03, height), (0.0, y, height / 2))
    for row, z in enumerate((0.08, 0.5, 0.92, 1.34, 1.88)):
        yield box("furniture", (0.3, width, 0.03), (0.0, 0.0, z))
        if row == 4:
            return
        start = -width / 2 + 0.03
        for k in range(3 + (row + first) % 2):
            length, tall = 0.22 + 0.07 * ((3 * k + row + first) % 4), 0.24 + 0.03 * ((k + 2 * row) % 4)
            colour = colours[(2 * k + row + first) % 5]
            yield box(colour, (0.2, length, tall), (0.02, start + length / 2, z + 0.015 + tall / 2))
            start += length + 0.02 + 0.08 * (k % 2)


def _desk() -> Iterator[Part]:
    """Yield a table with a screen, a whiteboard above and a chair."""
    wall = ROOM_SIDE / 2
    yield box("steel", (0.03, 2.04, 1.14), (wall - 0.015, 0.3, 1.6))
    yield box("board", (0.04, 1.96, 1.06), (wall - 0.02, 0.3, 1.6))
    yield box("furniture", (0.7, 1.6, 0.04), (wall - 0.4, 0.35, 0.72))
    for x in (wall - 0.71, wall - 0.09):
        for y in (-0.4, 1.1):
            yield box("cabinet", (0.05, 0.05, 0.7), (x, y, 0.35))
    yield box("cabinet", (0.5, 0.4, 0.55), (wall - 0.32, 0.8, 0.275))
    yield box("ink", (0.03, 0.6, 0.36), (wall - 0.3, 0.1, 1.0))
    yield box("ink", (0.14, 0.2, 0.1), (wall - 0.3, 0.1, 0.78))
    yield from placed(_chair(), (wall - 0.75, -1.2, 0.0), (0.0, 0.0, -140.0))
    yield disc("book-red", 0.14, 0.34, (wall - 0.3, -2.2, 0.17), axis="z")


def _store() -> Iterator[Part]:
    """Yield a window over a radiator, and a heap of cartons."""
    wall = ROOM_SIDE / 2
    yield box("skirting", (0.04, 1.5, 1.2), (wall - 0.01, -0.6, 1.6))
    yield box("pane", (0.05, 1.36, 1.06), (wall - 0.012, -0.6, 1.6))
    yield box("skirting", (0.06, 0.05, 1.1), (wall - 0.012, -0.6, 1.6))
    for k in range(6):
        yield box("paper", (0.1, 0.16, 0.6), (wall - 0.1, -1.1 + 0.2 * k, 0.45))
    yield box("paper", (0.06, 1.2, 0.05), (wall - 0.1, -0.6, 0.2))
    heap = ((0.5, 0.45, 0.9, 0.0, 8.0), (0.4, 0.35, 1.5, 0.0, -14.0), (0.36, 0.3, 0.95, 0.45, 25.0))
    for width, height, y, z, turn in heap:
        yield from placed(cardboard_box(width, height), (wall - 0.4, y, z), (0.0, 0.0, 180.0 + turn))


def _chair() -> Iterator[Part]:
    """Yield an office chair without arms that faces +x."""
    for x in (-0.19, 0.19):
        for y in (-0.19, 0.19):
            yield disc("steel", 0.013, 0.44, (x, y, 0.22), axis="z")
    yield box("fabric", (0.44, 0.44, 0.06), (0.0, 0.0, 0.46))
    yield box("fabric", (0.05, 0.42, 0.34), (-0.2, 0.0, 0.76))
    yield box("steel", (0.02, 0.06, 0.2), (-0.22, 0.0, 0.54))
