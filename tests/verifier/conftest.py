"""What is the same for every test of a worker is found once."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from verification import provenance


@pytest.fixture(scope="session", autouse=True)
def _code_parsed_once() -> Iterator[None]:
    """The digest of a file depends on its content alone; to parse all of them takes half a second."""
    code, known = provenance._code, {}

    def once(file: Path) -> str:
        key = file.suffix, file.read_bytes()
        if key not in known:
            known[key] = code(file)
        return known[key]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(provenance, "_code", once)
        yield
