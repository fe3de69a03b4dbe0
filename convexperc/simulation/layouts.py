"""Three scenes laid out by hand, one of each object of the case study, with five robots each."""

from convexperc.simulation.camera import Camera
from convexperc.simulation.scenes import Obstacle, Robot, Scene


def _huskies(*cameras: Camera) -> tuple[Robot, ...]:
    return tuple(Robot("husky", camera) for camera in cameras)


RED_CAR = Scene(
    name="red-car",
    object="red-car",
    target_height=0.72,
    reference=Camera(azimuth=0.0, distance=6.8, height=1.0),
    robots=_huskies(
        Camera(azimuth=5.0, distance=6.9, height=0.9, pan=1.0),
        Camera(azimuth=-24.0, distance=6.4, height=1.1, pan=-1.5),
        Camera(azimuth=33.0, distance=6.8, height=0.8),
        Camera(azimuth=140.0, distance=8.2, height=0.9),
        Camera(azimuth=205.0, distance=7.4, height=1.2),
    ),
    obstacles=(
        Obstacle("wall", azimuth=140.0, distance=2.9, width=4.2, height=1.75),
        Obstacle("crate", azimuth=211.0, distance=3.9, width=1.1, height=1.1, turn=12.0),
        Obstacle("crate", azimuth=228.0, distance=3.9, width=1.1, height=1.1, turn=-5.0),
        Obstacle("crate", azimuth=220.0, distance=3.9, width=0.9, height=0.9, elevation=1.1, turn=20.0),
        Obstacle("barrel", azimuth=112.0, distance=4.2, width=0.62, height=0.95),
    ),
)
"""A saloon; two of five robots see it from behind obstacles."""

GRAY_CAR = Scene(
    name="gray-car",
    object="gray-car",
    target_height=0.8,
    reference=Camera(azimuth=0.0, distance=6.8, height=1.0),
    robots=_huskies(
        Camera(azimuth=176.0, distance=6.8, height=1.0),
        Camera(azimuth=-7.0, distance=6.5, height=1.2, pan=1.5),
        Camera(azimuth=-122.0, distance=8.0, height=0.8),
        Camera(azimuth=19.0, distance=6.6, height=0.8, pan=-1.0),
        Camera(azimuth=37.0, distance=6.7, height=1.1),
    ),
    obstacles=(
        Obstacle("barrel", azimuth=165.0, distance=3.4, width=0.62, height=0.95),
        Obstacle("barrel", azimuth=176.0, distance=3.7, width=0.62, height=0.95),
        Obstacle("barrel", azimuth=187.0, distance=3.5, width=0.62, height=0.95),
        Obstacle("barrel", azimuth=177.0, distance=3.6, width=0.62, height=0.95, elevation=0.95),
        Obstacle("wall", azimuth=-122.0, distance=3.1, width=4.0, height=1.95),
        Obstacle("crate", azimuth=-68.0, distance=4.5, width=1.0, height=1.0, turn=25.0),
    ),
)
"""An estate; two of five robots see it from behind obstacles."""

ICA_SIGN = Scene(
    name="ica-sign",
    object="ica-sign",
    target_height=1.25,
    reference=Camera(azimuth=0.0, distance=6.0, height=1.2),
    robots=_huskies(
        Camera(azimuth=-31.0, distance=6.0, height=1.0),
        Camera(azimuth=33.0, distance=8.2, height=0.9),
        Camera(azimuth=4.0, distance=6.2, height=1.1, pan=1.0),
        Camera(azimuth=-19.0, distance=5.6, height=0.9, pan=-1.0),
        Camera(azimuth=158.0, distance=6.6, height=1.2),
    ),
    obstacles=(
        Obstacle("wall", azimuth=33.0, distance=4.0, width=3.0, height=2.0),
        Obstacle("crate", azimuth=150.0, distance=3.2, width=1.1, height=1.1, turn=15.0),
        Obstacle("crate", azimuth=152.0, distance=3.2, width=1.0, height=1.0, elevation=1.1, turn=-8.0),
        Obstacle("barrel", azimuth=172.0, distance=3.0, width=0.62, height=0.95),
        Obstacle("barrel", azimuth=-95.0, distance=3.4, width=0.62, height=0.95),
    ),
)
"""The sign; two of five robots see it from behind obstacles."""

SCENES = (RED_CAR, GRAY_CAR, ICA_SIGN)
"""All three."""
