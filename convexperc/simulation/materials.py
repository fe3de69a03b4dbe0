"""The paints of the parts of a scene.

A paint is given by its reflectances for red, green and blue, so that it also looks right in dim and in
coloured light. Nothing emits light, and all reflectances are within the range of real paints: a surface of
reflectance 0 for a colour would be black in light of that colour.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from convexperc.errors import InputError

Colour = tuple[float, float, float]
"""Diffuse reflectances for red, green and blue, in [0, 1]."""

LEAST_REFLECTANCE, GREATEST_REFLECTANCE = 0.04, 0.96
"""Reflectances of black and of white paint."""


@dataclass(frozen=True, slots=True)
class Material:
    """A plain paint.

    Attributes
    ----------
    colour : tuple of float
        Reflectances, each in [`LEAST_REFLECTANCE`, `GREATEST_REFLECTANCE`].
    specular : float
        Strength of its highlight, in [0, 1].
    shininess : float
        Sharpness of its highlight, in [0, 1].

    Raises
    ------
    InputError
        A value lies outside its range.
    """

    colour: Colour
    specular: float = 0.05
    shininess: float = 0.1

    def __post_init__(self) -> None:
        _check_colour("colour", self.colour)
        for name, value in (("specular", self.specular), ("shininess", self.shininess)):
            if not 0.0 <= value <= 1.0:
                raise InputError(name, value=value, must="must lie in [0, 1]")


@dataclass(frozen=True, slots=True)
class Pattern:
    """A matt surface of rectangles in two colours, like a chessboard with joints.

    Attributes
    ----------
    first, second : tuple of float
        Colours of the rectangles, within the same limits as those of a `Material`.
    joint : tuple of float
        Colour of the lines between them.
    repeat : tuple of float
        Number of squares of two by two rectangles in a metre, along x and along y.

    Raises
    ------
    InputError
        A value lies outside its range.
    """

    first: Colour
    second: Colour
    joint: Colour
    repeat: tuple[float, float]

    def __post_init__(self) -> None:
        for name in ("first", "second", "joint"):
            _check_colour(name, getattr(self, name))
        if not all(0.0 < times < float("inf") for times in self.repeat):
            raise InputError("repeat", value=self.repeat, must="must hold two positive numbers")


def _check_colour(name: str, colour: Colour) -> None:
    if not all(LEAST_REFLECTANCE <= share <= GREATEST_REFLECTANCE for share in colour):
        must = f"must hold three shares of light in [{LEAST_REFLECTANCE}, {GREATEST_REFLECTANCE}]"
        raise InputError(name, value=colour, must=must)


MATERIALS: Mapping[str, Material] = MappingProxyType(
    {
        "red": Material((0.62, 0.04, 0.05), 0.5, 0.8),
        "gray": Material((0.45, 0.47, 0.49), 0.6, 0.8),
        "glass": Material((0.05, 0.07, 0.09), 0.9, 0.9),
        "rubber": Material((0.06, 0.06, 0.065), 0.1, 0.2),
        "seam": Material((0.1, 0.1, 0.11), 0.2, 0.3),
        "chrome": Material((0.75, 0.76, 0.78), 0.9, 0.9),
        "rim": Material((0.68, 0.69, 0.71), 0.8, 0.7),
        "lamp": Material((0.95, 0.95, 0.86), 0.9, 0.9),
        "tail-lamp": Material((0.55, 0.04, 0.04), 0.7, 0.7),
        "plate": Material((0.92, 0.92, 0.88), 0.1, 0.1),
        "steel": Material((0.55, 0.57, 0.59), 0.4, 0.4),
        "navy": Material((0.05, 0.09, 0.3), 0.2, 0.3),
        "board": Material((0.94, 0.94, 0.92), 0.1, 0.2),
        "husky": Material((0.93, 0.7, 0.05), 0.4, 0.5),
        "wood": Material((0.62, 0.44, 0.24), 0.05, 0.1),
        "beam": Material((0.74, 0.56, 0.34), 0.05, 0.1),
        "drum": Material((0.05, 0.22, 0.52), 0.5, 0.5),
        "drum-rib": Material((0.04, 0.16, 0.4), 0.5, 0.5),
        "drum-band": Material((0.88, 0.88, 0.85), 0.4, 0.4),
        "concrete": Material((0.7, 0.69, 0.66), 0.05, 0.1),
        "brick": Material((0.6, 0.29, 0.21), 0.05, 0.1),
        "mortar": Material((0.74, 0.7, 0.65), 0.05, 0.1),
        "plaster": Material((0.8, 0.77, 0.7), 0.05, 0.1),
        "bark": Material((0.3, 0.21, 0.13), 0.0, 0.1),
        "leaf": Material((0.3, 0.45, 0.18), 0.0, 0.1),
        "leaf-dark": Material((0.23, 0.37, 0.15), 0.0, 0.1),
        "hill": Material((0.42, 0.54, 0.4), 0.0, 0.1),
        "skirting": Material((0.86, 0.85, 0.81), 0.1, 0.2),
        "wall-sand": Material((0.74, 0.68, 0.55)),
        "wall-sage": Material((0.52, 0.60, 0.50)),
        "wall-blue": Material((0.50, 0.58, 0.68)),
        "wall-clay": Material((0.68, 0.49, 0.42)),
        "door": Material((0.46, 0.30, 0.18), 0.1, 0.2),
        "furniture": Material((0.78, 0.70, 0.58), 0.1, 0.2),
        "cabinet": Material((0.36, 0.39, 0.42), 0.2, 0.3),
        "fabric": Material((0.24, 0.30, 0.38), 0.02, 0.1),
        "pane": Material((0.66, 0.78, 0.88), 0.5, 0.6),
        "carton": Material((0.63, 0.47, 0.30)),
        "tape": Material((0.77, 0.66, 0.47), 0.3, 0.4),
        "paper": Material((0.90, 0.89, 0.84)),
        "ink": Material((0.15, 0.15, 0.18)),
        "plywood": Material((0.80, 0.66, 0.46), 0.05, 0.1),
        "plywood-edge": Material((0.55, 0.41, 0.26)),
        "book-red": Material((0.55, 0.16, 0.14), 0.1, 0.2),
        "book-blue": Material((0.15, 0.26, 0.48), 0.1, 0.2),
        "book-green": Material((0.20, 0.40, 0.26), 0.1, 0.2),
        "book-ochre": Material((0.76, 0.58, 0.22), 0.1, 0.2),
        "circuit": Material((0.06, 0.36, 0.17), 0.4, 0.5),
        "chassis": Material((0.80, 0.82, 0.84), 0.5, 0.5),
        "motor": Material((0.86, 0.62, 0.10), 0.3, 0.4),
        "toy-red": Material((0.70, 0.06, 0.06), 0.4, 0.5),
        "toy-white": Material((0.90, 0.90, 0.88), 0.2, 0.3),
        "cone": Material((0.90, 0.30, 0.05), 0.2, 0.3),
        "cone-foot": Material((0.12, 0.12, 0.13), 0.1, 0.2),
        "duck": Material((0.93, 0.74, 0.07), 0.4, 0.5),
        "beak": Material((0.88, 0.33, 0.05), 0.3, 0.4),
        "chair": Material((0.36, 0.20, 0.11), 0.2, 0.3),
        "chair-seat": Material((0.62, 0.44, 0.26), 0.1, 0.2),
        "pot": Material((0.66, 0.32, 0.20)),
        "soil": Material((0.20, 0.14, 0.10)),
        "cactus": Material((0.16, 0.40, 0.18), 0.1, 0.2),
        "cactus-rib": Material((0.40, 0.60, 0.30), 0.1, 0.2),
        "flower": Material((0.85, 0.20, 0.45), 0.1, 0.2),
        "teapot": Material((0.10, 0.25, 0.60), 0.7, 0.7),
        "engine-green": Material((0.08, 0.36, 0.16), 0.4, 0.5),
        "engine-black": Material((0.07, 0.07, 0.08), 0.3, 0.4),
        "brass": Material((0.78, 0.60, 0.22), 0.7, 0.7),
        "lens": Material((0.04, 0.04, 0.06), 0.9, 0.9),
    }
)
"""Every plain paint by its name."""

TEXTURED: Mapping[str, Pattern] = MappingProxyType(
    {
        "paving": Pattern((0.6, 0.59, 0.57), (0.57, 0.56, 0.54), (0.44, 0.44, 0.43), (0.5, 0.5)),
        "grass": Pattern((0.36, 0.47, 0.24), (0.34, 0.45, 0.22), (0.35, 0.46, 0.23), (0.1, 0.1)),
        "vinyl": Pattern((0.60, 0.61, 0.60), (0.56, 0.57, 0.57), (0.46, 0.47, 0.47), (1.6, 1.6)),
        "screed": Pattern((0.42, 0.42, 0.41), (0.41, 0.41, 0.40), (0.41, 0.41, 0.40), (0.5, 0.5)),
    }
)
"""Every surface with a pattern by its name."""
