"""SHA256SUMS: the hashes of a report's files, in the form that `sha256sum -c` reads."""

import hashlib
import re
from collections.abc import Mapping

LINE = re.compile(r"^[0-9a-f]{64}  (\S+)$", re.MULTILINE)


def sums(files: Mapping[str, bytes]) -> bytes:
    """One line a file, by name."""
    lines = (f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items()))
    return "".join(lines).encode()


def listed(content: bytes) -> list[str]:
    """The names in such a file."""
    return LINE.findall(content.decode(errors="replace"))
