"""The same drawing in fewer bytes: without ids that nothing refers to, empty groups and needless digits."""

import re
from xml.etree import ElementTree

FINE = re.compile(r"(-?\d+\.\d)\d+")
"""A number with more digits than a drawing can show."""
REFERENCE = re.compile(r"#([\w.-]+)")
STILL = re.compile(r"rotate\(-?0 ")
NUMBERS = ("d", "x", "y", "x1", "x2", "y1", "y2", "width", "height", "transform")
NEEDLESS = ("font-family: 'DejaVu Sans'", "stroke-linecap: square", "stroke-linejoin: miter")


def compact(svg: str) -> str:
    """Shorten an inline SVG as `verification.report.drawing.drawn` makes it; it looks the same."""
    root = ElementTree.fromstring(svg)
    used = set(REFERENCE.findall(svg))
    for element in root.iter():
        if element.get("id") not in used:
            element.attrib.pop("id", None)
        _shorten(element)
    _unwrap(root)
    return ElementTree.tostring(root, encoding="unicode")


def _shorten(element: ElementTree.Element) -> None:
    element.tail = None
    if not (element.text or "").strip():
        element.text = None
    if STILL.match(element.get("transform", "")):
        del element.attrib["transform"]
    for name in NUMBERS:
        if name in element.attrib:
            element.set(name, " ".join(FINE.sub(r"\1", element.attrib[name]).split()))
    if "style" in element.attrib:
        told = (each.strip() for each in element.attrib["style"].split(";"))
        kept = [each.replace(": ", ":").replace(", ", ",") for each in told if each and each not in NEEDLESS]
        element.set("style", ";".join(kept))


def _unwrap(element: ElementTree.Element) -> None:
    """Put the children of groups without attributes in the place of their group; drop empty definitions."""
    for child in element:
        _unwrap(child)
    children = [
        inner for child in element for inner in (child if child.tag == "g" and not child.attrib else [child])
    ]
    element[:] = [child for child in children if child.tag != "defs" or len(child)]
