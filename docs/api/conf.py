"""Configuration of Sphinx: the reference of the public names, made of the docstrings."""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

project = "convexperc"
copyright = "the convexperc developers"  # noqa: A001 - Sphinx's name
extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc"]
default_role = "py:obj"
autodoc_default_options = {"members": True, "no-value": True}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "none"
autosummary_generate = False
numpydoc_show_class_members = False
smartquotes = False  # X' is a transpose
toc_object_entries_show_parents = "hide"
html_theme_options = {"page_width": "1100px", "sidebar_width": "260px"}

PAGES = sorted(page.stem for page in Path(__file__).parent.glob("convexperc.*.rst"))
HOMES = {name: page for page in PAGES for name in getattr(import_module(page), "__all__", ())}


def formulas(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Keep a docstring's formulas: ``|``, ``*`` and ``x_`` are no markup, and lines keep their ends."""
    found: list[str] = []
    for paragraph in "\n".join(lines).split("\n\n"):
        if paragraph.startswith("    ") and found and not found[-1].split("\n")[-1].startswith(" "):
            found += ["::", paragraph]
        else:
            found.append(re.sub(r"(`+[^`]+`+)|([|*]|_(?!\w))", lambda m: m[1] or "\\" + m[2], paragraph))
    lines[:] = "\n\n".join(found).split("\n")


def link(app: Any, env: Any, node: Any, text: Any) -> Any:
    """Find a public name of another package, such as ``Modalities.of``."""
    target = node.get("reftarget", "")
    home = HOMES.get(target.split(".")[0])
    if home is None:
        return None
    place = node["refdoc"], app.builder, "obj", f"{home}.{target}"
    return env.domains["py"].resolve_xref(env, *place, node, text)


def setup(app: Any) -> None:
    """Connect the two, the first before numpydoc reads the sections."""
    app.connect("autodoc-process-docstring", formulas, priority=100)
    app.connect("missing-reference", link)
