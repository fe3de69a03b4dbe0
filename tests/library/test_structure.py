"""The structure of the library: faces, names, how many arguments; the import contracts check the rest."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest

import convexperc

ROOT = Path(convexperc.__file__).parent
FACES = sorted(stub.parent for stub in ROOT.rglob("__init__.pyi"))
MOST_ARGUMENTS = 10


def dotted(folder: Path) -> str:
    return ".".join(folder.relative_to(ROOT.parent).parts)


@pytest.fixture(params=FACES, ids=dotted)
def face(request):
    return importlib.import_module(dotted(request.param))


def test_every_package_with_public_names_has_a_face():
    packages = {file.parent for file in ROOT.rglob("__init__.py")}
    assert {dotted(folder) for folder in packages - set(FACES)} == {
        "convexperc.cli",
        "convexperc.simulation.objects",
    }


def test_every_name_of_a_face_is_there_and_documented(face):
    for name in face.__all__:
        value = getattr(face, name)
        if inspect.isfunction(value) or inspect.isclass(value):
            assert value.__doc__, (face.__name__, name)


def test_no_module_is_named_like_a_function_of_its_face(face):
    modules = {file.stem for file in Path(face.__file__).parent.iterdir()}
    functions = {name for name in face.__all__ if inspect.isfunction(getattr(face, name))}
    assert not modules & functions, modules & functions


def test_no_public_function_takes_more_than_ten_arguments(face):
    for name in face.__all__:
        value = getattr(face, name)
        if inspect.isfunction(value):
            count = len(inspect.signature(value).parameters)
            assert count <= MOST_ARGUMENTS, (face.__name__, name, count)


def test_no_import_inside_a_function_escapes_a_circle():
    """Only what an extra or an equality case needs is imported where it is used."""
    found = {}
    for file in sorted(ROOT.rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for function in ast.walk(tree):
            if isinstance(function, (ast.FunctionDef, ast.AsyncFunctionDef)):
                inner = [
                    node for node in ast.walk(function) if isinstance(node, (ast.Import, ast.ImportFrom))
                ]
                for node in inner:
                    name = node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
                    found.setdefault(file.relative_to(ROOT).as_posix(), set()).add(name)
    own = {file: {n for n in names if str(n).startswith("convexperc")} for file, names in found.items()}
    own = {file: names for file, names in own.items() if names}
    assert own == {"report/picture.py": {"convexperc.report"}}, own  # Matplotlib comes with an extra


def test_the_layers_are_the_packages():
    """A file more changes nothing in pyproject.toml: the contract names packages and single modules."""
    text = (ROOT.parent / "pyproject.toml").read_text(encoding="utf-8")
    names = {part.stem for part in ROOT.iterdir() if part.suffix == ".py" or (part / "__init__.py").exists()}
    contract = text.split('containers = ["convexperc"]')[1].split("[[tool.importlinter")[0]
    listed = {word.strip() for line in contract.split('"')[1::2] for word in line.split("|")}
    assert listed == names - {"__init__"}, listed ^ names
