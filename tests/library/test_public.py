"""The public names, what an import costs, and where each equation of the paper is."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import convexperc

ROOT = Path(__file__).parents[2]
SLOW = {"cvxpy", "clarabel", "osqp", "cv2", "skimage", "scipy", "matplotlib", "flint", "hypothesis"}


def loaded_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(' '.join({{name.split('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


FORMER_NAMES = {"critical_lambda2": "lambda2_max", "critical_lambda3": "lambda3_max"}
"""Public names of before, and what they are called now."""


@pytest.mark.parametrize("name", convexperc.__all__)
def test_every_public_name_is_there_and_documented(name):
    found = getattr(convexperc, name)
    assert found.__doc__, name
    assert found.__name__ == FORMER_NAMES.get(name, name), (found.__name__, name)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = convexperc.no_such_name


def test_certify_imports_numpy_alone():
    found = loaded_after("from convexperc import certify")
    assert not found & SLOW, found & SLOW
    assert "numpy" in found, found


def test_the_package_itself_imports_nothing_slow():
    found = loaded_after("import convexperc")
    assert not found & (SLOW | {"numpy"}), found & (SLOW | {"numpy"})


def test_every_equation_of_the_paper_has_one_home():
    homes: dict[str, list[str]] = {}
    for file in sorted((ROOT / "convexperc").rglob("*.py")):
        for place in re.findall(r"Paper: (Eq\. \([a-z_0-9]+\))", file.read_text(encoding="utf-8")):
            homes.setdefault(place, []).append(file.name)
    assert {"Eq. (full)", "Eq. (solve_w)", "Eq. (solve_u)", "Eq. (loss)"} <= homes.keys(), homes
    assert all(len(files) == 1 for files in homes.values()), homes
