"""docs/rounding.md and the code speak of the same functions and the same constants."""

import ast
import copy
import re
from collections.abc import Iterator
from importlib import import_module

import pytest
from lemmas import DOCUMENT, constants, documented, functions, makes_a_bound, written

FUNCTIONS, DOCUMENTED = functions(), documented()


def test_each_function_that_makes_a_bound_has_one_lemma() -> None:
    """And a lemma speaks of functions that there are."""
    bounding = {name for name, function in FUNCTIONS.items() if makes_a_bound(function)}
    assert bounding - set(DOCUMENTED) == set()
    assert set(DOCUMENTED) - set(FUNCTIONS) == set()
    assert len(bounding) > 50


def test_the_lemmas_are_numbered_one_after_the_other() -> None:
    numbers = re.findall(r"^### Lemma R(\d+) ", DOCUMENT.read_text(encoding="utf-8"), re.MULTILINE)
    assert numbers == [str(k) for k in range(1, len(numbers) + 1)]


@pytest.mark.parametrize("name", DOCUMENTED)
def test_the_function_names_its_lemma_and_has_its_constants(name: str) -> None:
    lemma, listed = DOCUMENTED[name]
    function = FUNCTIONS[name]
    assert re.search(rf"\bLemma {lemma}\b", ast.get_docstring(function) or ""), (
        f"{name} must name Lemma {lemma}"
    )
    assert constants(function) == listed, f"**Constants.** {written(constants(function))}."


def test_a_reference_within_the_document_is_to_a_lemma() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    lemmas = {lemma for lemma, _ in DOCUMENTED.values()}
    assert set(re.findall(r"\bR\d+\b", text)) <= lemmas


def test_the_named_constants_have_the_values_of_the_table() -> None:
    rows = re.findall(
        r"^\| `([\w.]+)` \| `([\d.*-]+)` \|", DOCUMENT.read_text(encoding="utf-8"), re.MULTILINE
    )
    assert len(rows) == 7
    for name, value in rows:
        module, _, constant = name.rpartition(".")
        package = "convexperc." if "." in module else "convexperc.certificate."
        base, _, power = value.partition("**")
        expected = float(base) ** int(power) if power else int(base)
        assert getattr(import_module(package + module), constant) == expected, name


def halved(function: ast.FunctionDef) -> Iterator[tuple[str, ast.FunctionDef]]:
    """The function with one constant of rounding halved, for each that it has; or not rounded outwards."""
    slices = [each.slice for each in ast.walk(function) if isinstance(each, ast.Subscript)]
    indices = {id(part) for each in slices for part in ast.walk(each)}
    for place, node in enumerate(ast.walk(function)):
        if id(node) in indices:
            continue
        changed = copy.deepcopy(function)
        twin = list(ast.walk(changed))[place]
        match node, twin:
            case ast.Constant(value=int() | float() as value), ast.Constant() if value not in (0, 1):
                twin.value = value / 2
            case ast.Name(id="U" | "UNDERFLOW" | "UNDERFLOW_SUM" | "g"), ast.Name(ctx=ast.Load()):
                twin.id = f"half_{twin.id}"
            case ast.Call(func=ast.Name(id="up" | "down" | "gamma")), ast.Call():
                twin.func = ast.Name(id="plain", ctx=ast.Load())
            case _:
                continue
        yield ast.unparse(node), changed


@pytest.mark.parametrize("name", [name for name in DOCUMENTED if makes_a_bound(FUNCTIONS[name])])
def test_a_constant_that_is_halved_is_noticed(name: str) -> None:
    """Each one by itself, whether or not the adversary can show that it is too small."""
    _, listed = DOCUMENTED[name]
    for what, changed in halved(FUNCTIONS[name]):
        assert constants(changed) != listed, f"{what} halved in {name}"
