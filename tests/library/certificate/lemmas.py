"""The lemmas of docs/rounding.md, and what the code has of the same: functions, and the constants in them."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[3]
DOCUMENT = ROOT / "docs" / "rounding.md"
PROBES = "arithmetic"
"""The module that bounds nothing: it looks at the machine."""
MODULES = {
    path.stem if path.parent.name == "certificate" else f"{path.parent.name}.{path.stem}": path
    for path in (
        *(
            path
            for path in sorted((ROOT / "convexperc" / "certificate").glob("[a-z]*.py"))
            if path.stem != PROBES
        ),
        *(ROOT / "convexperc" / name for name in ("problem/scaling.py", "problem/reduction.py")),
        ROOT / "convexperc" / "recognition" / "decision.py",
    )
}
"""Where bounds in float64 are made."""
ROUNDED = {"up", "down", "nextafter", "spacing"}
MARKS = {"gamma", "U", "UNDERFLOW", "UNDERFLOW_SUM", *ROUNDED}
"""Names that only a function that makes a bound has a use for."""
TIMES = "\N{MULTIPLICATION SIGN}"
HEADING = re.compile(r"^### Lemma (R\d+) \(((?:`[\w.]+`(?:, )?)+)\)$", re.MULTILINE)

Function = ast.FunctionDef


def functions() -> dict[str, Function]:
    """Every function of `MODULES` by its module, class and name."""
    found = {}
    for module, path in MODULES.items():
        for scope, node in _defined(ast.parse(path.read_text(encoding="utf-8")), module):
            found[f"{scope}.{node.name}"] = node
    return found


def _defined(tree: ast.AST, scope: str) -> Iterator[tuple[str, Function]]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield scope, node
        if isinstance(node, ast.ClassDef):
            yield from _defined(node, f"{scope}.{node.name}")


def makes_a_bound(function: Function) -> bool:
    """Whether a constant of rounding, or rounding outwards, occurs in it."""
    return any(_mark(node) for node in ast.walk(function))


def _mark(node: ast.AST) -> bool:
    if isinstance(node, ast.Name):
        return node.id in MARKS
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        return isinstance(node.left, ast.Constant) and node.left.value == 2.0 and _plain(node.right)
    return isinstance(node, ast.Attribute) and node.attr in {"gamma", *ROUNDED}


def constants(function: Function) -> Counter[str]:
    """The constants of a function: whole products with U, powers, names in capitals, and other numbers.

    0 and 1 are left out, and so are indices. ``g`` stands for each use of the gamma that is handed on.
    """
    found: Counter[str] = Counter()
    for statement in function.body:
        _count(statement, found)
    return found


def _count(node: ast.AST, found: Counter[str]) -> None:
    name = _constant(node)
    if name is not None:
        found[name] += 1
    if name is None or name in ROUNDED:
        for child in ast.iter_child_nodes(node):
            if not (isinstance(node, ast.Subscript) and child is node.slice) and not isinstance(
                child, ast.keyword
            ):
                _count(child, found)


def _constant(node: ast.AST) -> str | None:
    """How a node is called among the constants; None for what is none by itself."""
    match node:
        case ast.BinOp(op=ast.Mult() | ast.Pow()) if _plain(node) and (_has_u(node) or _is_power(node)):
            found = ast.unparse(node)
        case ast.Call(func=ast.Name(id="gamma")):
            found = ast.unparse(node)
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)) if name in ROUNDED:
            found = name
        case ast.Name(id="g", ctx=ast.Load()) | ast.Attribute(attr="gamma", ctx=ast.Load()):
            found = "g"
        case ast.Name(id=name) if re.fullmatch(r"U|[A-Z][A-Z0-9_]{2,}", name):
            found = name
        case ast.Constant(value=int() | float() as value) if value not in (0, 1):
            found = repr(value)
        case _:
            found = None
    return found


def _plain(node: ast.AST) -> bool:
    """Whether it is made of numbers, sizes and U alone."""
    match node:
        case ast.BinOp(left=left, right=right):
            return _plain(left) and _plain(right)
        case ast.UnaryOp(operand=operand):
            return _plain(operand)
        case ast.Attribute(attr="size") | ast.Constant():
            return True
        case ast.Name(id=name):
            return name in {"U", "k", "n", "d"}
    return False


def _has_u(node: ast.AST) -> bool:
    return any(isinstance(each, ast.Name) and each.id == "U" for each in ast.walk(node))


def _is_power(node: ast.BinOp) -> bool:
    return isinstance(node.op, ast.Pow)


def documented() -> dict[str, tuple[str, Counter[str]]]:
    """By function: its lemma, and the constants that the lemma derives."""
    text, found = DOCUMENT.read_text(encoding="utf-8"), {}
    headings = list(HEADING.finditer(text))
    for heading, following in zip(headings, [*headings[1:], None], strict=True):
        body = text[heading.end() : following.start() if following else len(text)]
        (paragraph,) = re.findall(r"^\*\*Constants\.\*\*(.*?)\n\n", body, re.MULTILINE | re.DOTALL)
        shared, *own = re.split(r"`([\w.]+)`:", paragraph.replace("\n", " "))
        each = dict(zip(own[::2], own[1::2], strict=True))
        for name in re.findall(r"`([\w.]+)`", heading[2]):
            assert name not in found, (name, "has two lemmas")
            found[name] = heading[1], _listed(each.get(name, shared))
    return found


def _listed(text: str) -> Counter[str]:
    return Counter(
        {name: int(count or 1) for count, name in re.findall(rf"(?:(\d+) {TIMES} )?`([^`]+)`", text)}
    )


def written(found: Counter[str]) -> str:
    """As a lemma has them."""
    return ", ".join(
        f"{count} {TIMES} `{name}`" if count > 1 else f"`{name}`" for name, count in found.items()
    )
