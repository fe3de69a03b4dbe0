"""Which views are looked at: random subsets of a scene's views, the same for everything that is compared."""

import numpy as np

from verification.experiments.design import GRID_COUNT, Design, key
from verification.experiments.scenes.pictures import Scene

Subset = tuple[int, ...]
"""Numbers of views, ascending."""


def drawn(design: Design, name: str, scene: Scene) -> tuple[tuple[Subset, ...], ...]:
    """Draw each repetition's subset for every number of views.

    Parameters
    ----------
    design : Design
    name : str
        Of the set.
    scene : Scene

    Returns
    -------
    tuple of tuple of Subset
        Entry [n - 1][r] has n views. A subset may come several times.
    """
    everyone = len(scene.views)
    found = []
    for n in design.counts:
        rng = np.random.default_rng([design.seed, key(name), key(scene.name), n])
        draws = (rng.choice(everyone, n, replace=False) for _ in range(design.repetitions))
        found.append(tuple(tuple(sorted(draw.tolist())) for draw in draws))
    return tuple(found)


def of_grid(subsets: tuple[tuple[Subset, ...], ...]) -> tuple[Subset, Subset]:
    """The two subsets on which the grid is tried: the first of three views, and all views."""
    return subsets[GRID_COUNT - 1][0], subsets[-1][0]
