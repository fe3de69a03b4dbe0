"""The size of a picture."""

from dataclasses import dataclass

from convexperc.errors import InputError


@dataclass(frozen=True, slots=True)
class ImageSize:
    """Pixels of a picture, and samples of each pixel.

    Attributes
    ----------
    width, height : int
        In pixels.
    supersampling : int
        Each pixel is the mean of a square of this many samples a side.

    Raises
    ------
    InputError
        A number is not in 1..4096, or a side has more than 8192 samples.
    """

    width: int
    height: int
    supersampling: int = 2

    def __post_init__(self) -> None:
        for name in ("width", "height", "supersampling"):
            value = getattr(self, name)
            if not 1 <= value <= 4096:
                raise InputError(name, value=value, must="must be a whole number in 1..4096")
        if max(self.columns, self.rows) > 8192:
            must = "must give at most 8192 samples a side"
            raise InputError("supersampling", value=self.supersampling, must=must)

    @property
    def columns(self) -> int:
        """Samples in a row."""
        return self.width * self.supersampling

    @property
    def rows(self) -> int:
        """Samples in a column."""
        return self.height * self.supersampling
