"""Draw both simulated sets where no folders of them are given."""

from collections.abc import Callable
from pathlib import Path

from convexperc.simulation import OBJECTS_OF, ImageSize, Request, SetName, write_data_set

SIZES: dict[SetName, int] = {"physical": 6, "case-study": 8}
"""Scenes of each object, and in the physical set of each level."""
FRAME = ImageSize(160, 120)


def draw(
    folder: Path, seed: int, workers: int, progress: Callable[[str, int, int], None]
) -> tuple[Path, Path]:
    """Draw both sets, or what an earlier run of the same seed has left to be drawn.

    Parameters
    ----------
    folder : Path
        Gets a folder for each set and seed.
    seed : int
    workers : int
        Processes; the pictures do not depend on it.
    progress : callable
        Called with the stage, how much is done, and of how much.

    Returns
    -------
    (Path, Path)
        Folders of the set in which objects are recognised, and of the case study.

    Raises
    ------
    InputError, MissingExtraError, RenderingError
        See `convexperc.simulation.write_data_set`.
    """
    places = []
    for kind, scenes in SIZES.items():
        place = folder / f"{kind}-{seed}"
        request = Request(kind, seed, scenes, OBJECTS_OF[kind], FRAME)
        done: list[str] = []

        def told(name: str, total: int, kind: str = kind, done: list[str] = done) -> None:
            done.append(name)
            progress(f"pictures of {kind}", len(done), total)

        write_data_set(place, request, workers=workers, progress=told)
        places.append(place)
    return places[0], places[1]
