"""The models of which scenes are made: objects, robots, obstacles, surroundings."""

from collections import Counter

import numpy as np
import pytest

from convexperc.simulation.objects.cars import ESTATE, SALOON, car
from convexperc.simulation.obstacles import OBSTACLES
from convexperc.simulation.parts import Part, box, disc, mirrored
from convexperc.simulation.skins import hull


@pytest.mark.parametrize("style", [SALOON, ESTATE])
def test_the_skins_of_a_car_are_closed_and_face_outwards(style):
    skins = [part for part in car(style, "red") if part.faces]
    assert len(skins) == 2
    for skin in skins:
        edges = Counter((face[k], face[(k + 1) % 3]) for face in skin.faces for k in range(3))
        assert set(edges.values()) == {1}, "an edge is used twice in one direction"
        assert all((b, a) in edges for a, b in edges), "the skin has a hole"
        corners = np.array(skin.vertices)[np.array(skin.faces)]
        assert np.linalg.det(corners).sum() / 6 > 0, "the volume must be positive"


@pytest.mark.parametrize(
    "part",
    [
        box("steel", (0.1, 0.2, 0.3), (1.0, 2.0, 3.0), (10.0, 20.0, 30.0)),
        disc("rubber", 0.3, 0.2, (0.8, 1.0, 0.3)),
        hull("glass", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]),
    ],
)
def test_mirroring_twice_changes_nothing(part: Part):
    assert mirrored(part) != part
    assert mirrored(mirrored(part)) == part


@pytest.mark.parametrize("kind", ["crate", "barrel", "wall"])
@pytest.mark.parametrize("extent", [0.2, 0.32, 1.0, 20.0])
def test_an_obstacle_of_any_allowed_size_has_positive_extents(kind, extent):
    for part in OBSTACLES[kind](extent, extent):
        assert min(part.size) > 0, part
