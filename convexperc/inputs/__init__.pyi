from .frames import Frame, Source
from .regions import Mask, Region, cropped, masked, read_mask

__all__ = ["Frame", "Mask", "Region", "Source", "cropped", "masked", "read_mask"]
