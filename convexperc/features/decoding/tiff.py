"""TIFF files: which of the many forms are read, and what Pillow and libtiff would accept or misread.

Source: Adobe, TIFF Revision 6.0, and its Technical Notes 1 and 2 of 1995 and 2002.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import TiffImagePlugin
from PIL.TiffImagePlugin import TiffImageFile

from convexperc.features.decoding.inflating import inflated
from convexperc.features.decoding.jpeg import JpegFile
from convexperc.features.decoding.sizes import MAX_BYTES, MAX_PIXELS

# Photometric interpretation.
_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _YCBCR = 0, 1, 2, 3, 6
_COLORS = {_WHITE_IS_ZERO: 1, _BLACK_IS_ZERO: 1, _RGB: 3, _PALETTE: 1, _YCBCR: 3}
"""The samples of each interpretation that is read; CIELab, which the decoders convert differently, is not."""
# Compression. Of Deflate, Adobe's number is 8. CCITT's codes for facsimile (2, 3, 4) are not read: a damaged
# or truncated file cannot be told from a sound one. LZMA is not: libtiff goes on after its errors. So it does
# with luma and chroma, which are read where the size of a strip can be verified before.
_RAW, _LZW, _JPEG, _ADOBE_DEFLATE, _PACKBITS, _DEFLATE, _ZSTD = 1, 5, 7, 8, 32773, 32946, 50000
_READ = (_RAW, _LZW, _JPEG, _ADOBE_DEFLATE, _PACKBITS, _DEFLATE, _ZSTD)
_PREDICTED = (_LZW, _ADOBE_DEFLATE, _DEFLATE, _ZSTD)
"""The compressions for which libtiff looks at the predictor."""
_CHUNKY, _PLANAR = 1, 2
_UNASSOCIATED, _UNSIGNED, _REVERSED = 2, 1, 2  # extra sample; sample format; fill order
_BYTE_MAX, _BYTE_BITS = 255, 8
_PACKED_BITS = 12  # the only depth between 8 and 16 bits that Pillow opens

_HEADER_BYTES, _SPARE_BYTES = 8, 16
"""What programs may add to a strip to align it; more speaks for another width or depth than is stated."""
_YCBCR_SUBSAMPLING, _MAX_VALUE, _S_MAX_VALUE = 530, 281, 341


class _Piece(NamedTuple):
    """A strip or tile, its size in pixels, and its least and largest bytes without compression."""

    data: memoryview
    height: int
    width: int
    needed: int
    most: int


class Layout(NamedTuple):
    """What the tags of a TIFF say.

    Attributes
    ----------
    photometric, compression, planar, samples, bits : int
        `bits` is the largest number of bits of a sample.
    extra : tuple of int
        The meaning of each sample beyond the colors.
    """

    photometric: int
    compression: int
    planar: int
    samples: int
    bits: int
    extra: tuple[int, ...]

    @classmethod
    def of(cls, image: TiffImageFile) -> "Layout":
        """Read the tags."""
        tags, tag = image.tag_v2, TiffImagePlugin
        photometric = tags.get(tag.PHOTOMETRIC_INTERPRETATION, -1)
        return cls(
            photometric,
            tags.get(tag.COMPRESSION, _RAW),
            tags.get(tag.PLANAR_CONFIGURATION, _CHUNKY),
            tags.get(tag.SAMPLESPERPIXEL, _COLORS.get(photometric, 0)),
            max(tags.get(tag.BITSPERSAMPLE, (1,))),
            tuple(tags.get(tag.EXTRASAMPLES, ())),
        )

    @property
    def apart(self) -> bool:
        """Whether each sample has strips of its own."""
        return self.planar == _PLANAR

    @property
    def by_opencv(self) -> bool:
        """Whether Pillow would misread it, or reduce its samples to 8 bits, and OpenCV does not."""
        raw = self.photometric == _YCBCR or (self.apart and self.samples == 1)
        return (raw and self.compression == _RAW) or (self.bits == 16 and self.samples > 1)


def check(image: TiffImageFile, layout: Layout, data: bytes) -> None:
    """Refuse what neither library decodes correctly, or would accept though it is cut.

    Raises
    ------
    ValueError
        As said.
    """
    tags, tag = image.tag_v2, TiffImagePlugin
    _check_colors(layout)
    if {*tags.get(tag.SAMPLEFORMAT, ()), _UNSIGNED} != {_UNSIGNED}:
        raise ValueError("a TIFF of signed or floating-point numbers")
    _check_compression(image, layout)
    planes = layout.apart and layout.samples > 1
    if layout.bits > _BYTE_BITS and (layout.photometric == _WHITE_IS_ZERO or planes):
        raise ValueError(f"a TIFF of {layout.bits} bits with 0 for white or with its colors apart")
    if layout.bits == _PACKED_BITS and layout.compression == _JPEG:
        raise ValueError("a TIFF with a JPEG of 12 bits")
    if planes and tags.get(tag.FILLORDER, 1) == _REVERSED:
        raise ValueError("a TIFF with its colors apart and its bits reversed")
    left = MAX_BYTES
    for piece in _pieces(image, layout, data):
        if layout.compression in (_DEFLATE, _ADOBE_DEFLATE):
            left -= _whole_size(piece, left)
        elif layout.compression == _JPEG:
            _check_jpeg(piece, tags.get(tag.JPEGTABLES, b""), 1 if layout.apart else layout.samples)


def _check_compression(image: TiffImageFile, layout: Layout) -> None:
    """Refuse a compression that is not read, or not with what else is stated."""
    tags, tag = image.tag_v2, TiffImagePlugin
    sized = layout.compression in (_RAW, _JPEG, _DEFLATE, _ADOBE_DEFLATE)
    if layout.compression not in _READ or (layout.photometric == _YCBCR and not sized):
        said = f"compression {layout.compression} and photometric {layout.photometric}"
        raise ValueError(f"a TIFF with {said}, which is not read")
    if tag.BITSPERSAMPLE not in tags and layout.compression not in (_RAW, _DEFLATE, _ADOBE_DEFLATE):
        raise ValueError("a TIFF that does not state its bits, and of which the size cannot be verified")
    if tags.get(tag.PREDICTOR, 1) != 1 and layout.compression not in _PREDICTED:
        raise ValueError(f"a TIFF with a predictor for compression {layout.compression}, which has none")


def _check_colors(layout: Layout) -> None:
    """Refuse samples without a meaning that is read."""
    colors, extra = _COLORS.get(layout.photometric, 0), layout.extra
    meant = colors and extra in ((), (_UNASSOCIATED,)) and layout.samples == colors + len(extra)
    gray = layout.photometric in (_BLACK_IS_ZERO, _WHITE_IS_ZERO) and layout.bits >= _BYTE_BITS
    planes = colors == 3 or (layout.samples == 1 and (gray or layout.compression != _RAW))
    if not meant or layout.planar not in (_CHUNKY, _PLANAR) or (layout.apart and not planes):
        said = f"photometric {layout.photometric}, extra samples {extra}, planar {layout.planar}"
        raise ValueError(f"a TIFF of {layout.samples} samples a pixel, {said}")


def _pieces(image: TiffImageFile, layout: Layout, data: bytes) -> Iterator[_Piece]:
    """Yield each strip or tile; all must be in the file."""
    tags, tag = image.tag_v2, TiffImagePlugin
    width, height = tags[tag.IMAGEWIDTH], tags[tag.IMAGELENGTH]
    if tag.TILEOFFSETS in tags:
        offsets, counts = tags[tag.TILEOFFSETS], tags.get(tag.TILEBYTECOUNTS, ())
        across, down = tags[tag.TILEWIDTH], tags[tag.TILELENGTH]
        heights = [down] * (-(-width // across) * -(-height // down))
    else:
        offsets, counts = tags[tag.STRIPOFFSETS], tags.get(tag.STRIPBYTECOUNTS, ())
        across, down = width, min(tags.get(tag.ROWSPERSTRIP, height), height)
        heights = [min(down, height - top) for top in range(0, height, down)]
    if across * down > MAX_PIXELS:
        raise ValueError(f"a TIFF with a tile of more than {MAX_PIXELS} pixels")
    heights *= layout.samples if layout.apart else 1
    raw = layout.compression == _RAW
    if len(offsets) != len(heights) or len(counts) != len(heights):
        if counts or not raw or len(offsets) != len(heights):
            raise ValueError("a TIFF whose strips do not fill the picture")
        counts = [_raw_bytes(image, layout, across, rows) for rows in heights]
    _check_places(offsets, counts)
    most = _raw_bytes(image, layout, across, down) + _SPARE_BYTES
    for offset, count, rows in zip(offsets, counts, heights, strict=True):
        needed = _raw_bytes(image, layout, across, rows)
        if (raw and not needed <= count <= most) or offset + count > len(data):
            raise ValueError("a TIFF whose strips do not fill the picture")
        yield _Piece(memoryview(data)[offset : offset + count], rows, across, needed, most)


def _check_places(offsets: Sequence[int], counts: Sequence[int]) -> None:
    """Refuse strips that overlap each other or the header; equal ones may be stored once."""
    end = _HEADER_BYTES
    for offset, count in sorted(set(zip(offsets, counts, strict=True))):
        if offset < end:
            raise ValueError("a TIFF whose strips overlap")
        end = offset + count


def _raw_bytes(image: TiffImageFile, layout: Layout, width: int, rows: int) -> int:
    """Return the bytes of so many rows that are not compressed."""
    if layout.photometric == _YCBCR and not layout.apart:
        across, down = image.tag_v2.get(_YCBCR_SUBSAMPLING, (2, 2))
        return int(-(-width // across) * -(-rows // down) * (across * down + 2))
    samples = 1 if layout.apart else layout.samples
    return int(-(-width * samples * layout.bits // 8) * rows)


def _whole_size(piece: _Piece, left: int) -> int:
    """Inflate a strip up to its checksum, which the TIFF decoder does not verify; return its size."""
    size, ended = inflated(piece.data, left)
    if not ended or not piece.needed <= size <= min(piece.most, left):
        raise ValueError("a TIFF with a strip that does not end where it should")
    return size


def _check_jpeg(piece: _Piece, tables: bytes, components: int) -> None:
    """Decode a strip by itself: the TIFF decoder hides libjpeg's warnings, and fills in what is missing."""
    file = JpegFile.of(tables.removesuffix(b"\xff\xd9") + bytes(piece.data[2 if tables else 0 :]))
    same = file.width == piece.width and len(file.factors) == components
    if not same or not piece.height <= file.height <= MAX_PIXELS // file.width:
        raise ValueError("a TIFF with a JPEG of another size than its strip")
    file.decoded()


def named_colors(image: TiffImageFile, layout: Layout) -> NDArray[np.uint8] | None:
    """Return the colors of a palette, (2^bits, 3); None without one.

    Its numbers have 16 bits; but where none is above 255 they are of 8 bits, as some programs write them.
    """
    if layout.photometric != _PALETTE:
        return None
    stored = np.array(image.tag_v2[TiffImagePlugin.COLORMAP]).reshape(3, -1).T
    if len(stored) != 1 << layout.bits:
        raise ValueError(f"a TIFF with a palette of {len(stored)} colors for {layout.bits} bits")
    return (stored if stored.max() <= _BYTE_MAX else stored >> _BYTE_BITS).astype(np.uint8)


def stated_bits(image: TiffImageFile, layout: Layout) -> int:
    """Return how many bits of a sample are used, by the largest value that the tags state."""
    tags = image.tag_v2
    stated: Any = tags.get(_S_MAX_VALUE) or tags.get(_MAX_VALUE)
    largest = max(stated) if isinstance(stated, tuple) else stated
    return layout.bits if largest is None else int(largest).bit_length()
