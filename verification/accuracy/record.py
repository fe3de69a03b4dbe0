"""What a record says of the pictures and of how it was measured."""

from collections.abc import Sequence
from dataclasses import asdict
from hashlib import sha256
from typing import Any

import numpy as np

from verification.accuracy.methods import LAMBDAS, METHODS, SECONDS, TOLERANCE
from verification.accuracy.scenes import CONDITIONS, Sizes, photograph
from verification.experiments.design import VIEWS, Design
from verification.experiments.scenes.album import Album
from verification.ledger.claims import PROTOCOL


def pictures_record(name: str, albums: Sequence[Album]) -> dict[str, Any]:
    """Count the photographs, and take a digest of their names, pixels and masks."""
    sha, count = sha256(), 0
    for album in albums:
        for photo in (album.reference, *album.others):
            count += 1
            sha.update(repr((photograph(album.object, photo), photo.picture.shape)).encode())
            sha.update(photo.picture.tobytes() + np.packbits(photo.mask).tobytes())
    return {"name": name, "objects": len(albums), "photographs": count, "digest": sha.hexdigest()}


def design_record(sizes: Sizes, design: Design) -> dict[str, Any]:
    """State what was drawn, and by what it was judged."""
    return {
        **asdict(sizes),
        "views": VIEWS,
        "conditions": CONDITIONS,
        "methods": list(METHODS),
        "lambdas": [list(each) for each in LAMBDAS],
        "relative tolerance": TOLERANCE,
        "seconds of ball arithmetic": SECONDS,
        "resamples": design.resamples,
        "confidence": PROTOCOL.confidence,
    }
