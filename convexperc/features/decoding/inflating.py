"""Inflating of Deflate streams a piece at a time, so that a small file cannot take all memory."""

import zlib

_PIECE_BYTES = 2**16
"""Compressed bytes inflated at once: they give at most 64.5 MiB, because Deflate's ratio is at most 1032."""


def inflated(stream: bytes | memoryview, enough: int) -> tuple[int, bool]:
    """Return the inflated size of a stream, or one above `enough`, and whether it ended with its checksum.

    Raises
    ------
    zlib.error
        The stream is damaged.
    """
    inflate, size = zlib.decompressobj(), 0
    for start in range(0, len(stream), _PIECE_BYTES):
        if inflate.eof or size > enough:
            break
        size += len(inflate.decompress(stream[start : start + _PIECE_BYTES]))
    return size, inflate.eof
