from .color import color_histogram
from .configuration import FeatureConfiguration, read_configuration
from .extraction import extract, normalise, raw_blocks, unit_length
from .hog import hog_descriptor
from .lbp import lbp_histogram
from .network.model import network_features
from .pictures import as_rgb, list_images, read_image, resize, to_gray
from .recent import RecentFeatures
from .regions import Region, cropped, cut_out, masked, read_mask

__all__ = [
    "FeatureConfiguration",
    "RecentFeatures",
    "Region",
    "as_rgb",
    "color_histogram",
    "cropped",
    "cut_out",
    "extract",
    "hog_descriptor",
    "lbp_histogram",
    "list_images",
    "masked",
    "network_features",
    "normalise",
    "raw_blocks",
    "read_configuration",
    "read_image",
    "read_mask",
    "resize",
    "to_gray",
    "unit_length",
]
