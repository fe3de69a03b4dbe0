"""The structure of both packages: faces, names, how many arguments; the import contracts check the rest."""

import ast
import importlib
import inspect
import re
from pathlib import Path

import pytest

import convexperc
import verification

TOP = Path(__file__).parents[1]
ROOTS = [Path(package.__file__).parent for package in (convexperc, verification)]
PACKAGES = ("convexperc", "verification")
FACES = sorted(stub.parent for root in ROOTS for stub in root.rglob("__init__.pyi"))
WITHOUT_A_FACE = {
    "convexperc.kernels",
    "convexperc.cli",
    "convexperc.features.decoding",
    "convexperc.features.network",
    "convexperc.simulation.objects",
    "verification",
    "verification.accuracy",
    "verification.bench",
    "verification.commands",
    "verification.experiments.measure",
    "verification.experiments.record",
    "verification.experiments.scenes",
    "verification.lassos",
    "verification.proofs.checkers",
    "verification.report.experiments",
    "verification.reweighted.loops",
    "verification.reweighted.objectives",
    "verification.reweighted.programs",
    "verification.reweighted.terms",
}
"""Packages of which outsiders take nothing."""
ROOMS, LAYERS = 21, 8
"""Packages and single modules of the verifier, its entry point among them; layers of its contract."""
MOST_ARGUMENTS = 10


def dotted(folder: Path) -> str:
    return ".".join(folder.relative_to(TOP).parts)


@pytest.fixture(params=FACES, ids=dotted)
def face(request):
    return importlib.import_module(dotted(request.param))


def test_every_package_with_public_names_has_a_face():
    packages = {file.parent for root in ROOTS for file in root.rglob("__init__.py")}
    assert {dotted(folder) for folder in packages - set(FACES)} == WITHOUT_A_FACE


def test_every_name_of_a_face_is_there_and_documented(face):
    for name in face.__all__:
        value = getattr(face, name)
        if inspect.isfunction(value) or inspect.isclass(value):
            assert value.__doc__, (face.__name__, name)


def test_no_module_is_named_like_a_function_of_its_face(face):
    modules = {file.stem for file in Path(face.__file__).parent.glob("*.py")}
    functions = {name for name in face.__all__ if inspect.isfunction(getattr(face, name))}
    assert not modules & functions, modules & functions


def test_no_public_function_takes_more_than_ten_arguments(face):
    for name in face.__all__:
        value = getattr(face, name)
        if inspect.isfunction(value):
            count = len(inspect.signature(value).parameters)
            assert count <= MOST_ARGUMENTS, (face.__name__, name, count)


ALLOWED = {
    "convexperc/features/network/model.py": {"convexperc.features.network"},  # onnx comes with an extra
    "convexperc/kernels/kernel.py": {"convexperc.kernels"},  # Numba comes with an extra
    "convexperc/report/picture.py": {"convexperc.report"},  # Matplotlib comes with an extra
    "verification/counterexamples/replay.py": {"convexperc.report.canvas"},  # Matplotlib
    "verification/bench/peers.py": {"convexperc.solvers.conic", "convexperc.solvers.paper.loop"},  # CVXPY
}
"""Imports of our own inside functions, the command lines apart, which keep --help quick."""


def own_imports_inside_functions(root: Path) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for file in sorted(root.rglob("*.py")):
        for function in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(function, (ast.FunctionDef, ast.AsyncFunctionDef)):
                for node in ast.walk(function):
                    if isinstance(node, (ast.Import, ast.ImportFrom)):
                        name = node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
                        found.setdefault(file.relative_to(TOP).as_posix(), set()).add(str(name))
    own = {
        file: {n for n in names if n.startswith(("convexperc", "verification"))}
        for file, names in found.items()
    }
    return {file: names for file, names in own.items() if names}


@pytest.mark.parametrize("root", ROOTS, ids=["convexperc", "verification"])
def test_no_import_inside_a_function_escapes_a_circle(root: Path):
    """Only what an extra or an equality case needs is imported where it is used."""
    found = own_imports_inside_functions(root)
    odd = {
        file: names
        for file, names in found.items()
        if "/commands/" not in file and names != ALLOWED.get(file)
    }
    assert not odd, odd


def contract(package: str) -> list[list[str]]:
    """The layers of the contract on a package's parts, each as the names in it."""
    text = (TOP / "pyproject.toml").read_text(encoding="utf-8")
    part = text.split(f'containers = ["{package}"]')[1].split("[[tool.importlinter")[0]
    layers = part.split("layers = [")[1].split("]")[0]
    return [re.split(r"\s*[|:]\s*", line) for line in layers.split('"')[1::2]]


@pytest.mark.parametrize("root", ROOTS, ids=["convexperc", "verification"])
def test_the_layers_are_the_packages(root: Path):
    """A file more changes nothing in pyproject.toml: the contract names packages and single modules."""
    names = {part.stem for part in root.iterdir() if part.suffix == ".py" or (part / "__init__.py").exists()}
    listed = [name for layer in contract(root.name) for name in layer]
    assert sorted(listed) == sorted(names - {"__init__"}), set(listed) ^ names


def test_the_verifier_keeps_its_few_rooms():
    layers = contract("verification")
    assert sum(map(len, layers)) <= ROOMS, layers
    assert len(layers) <= LAYERS, layers
