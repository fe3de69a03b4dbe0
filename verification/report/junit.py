"""junit.xml: one test case a part, passed where the verdict is the baseline's; for servers that read it."""

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

from verification.ledger.evidence import Verdict

FINDINGS = {
    "failed": "no promise of the library fails",
    "stale": "every stored counterexample still fails",
    "open": "nothing that is required is missing or open",
}


def junit(record: Mapping[str, Any]) -> bytes:
    """Render junit.xml; it holds nothing volatile, every time is 0.

    Parameters
    ----------
    record : mapping
        See `verification.report.machine.report_record`.
    """
    root = ElementTree.Element("testsuites", name="convexperc verification")
    for claim in record["claims"]:
        suite = ElementTree.SubElement(root, "testsuite", name=claim["id"])
        for part in claim["parts"]:
            _part(
                ElementTree.SubElement(suite, "testcase", name=part["key"], classname=claim["id"], time="0"),
                part,
            )
    run = ElementTree.SubElement(root, "testsuite", name="run")
    for key, name in FINDINGS.items():
        case = ElementTree.SubElement(run, "testcase", name=name, classname="run", time="0")
        if lines := record["outcome"][key]:
            _failure(case, f"{len(lines)} found", "\n".join(lines))
    for element in (*root, root):
        _count(element)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _part(case: ElementTree.Element, part: Mapping[str, Any]) -> None:
    verdict, expected = part["verdict"], part["baseline"]
    if verdict != expected:
        _failure(case, f"{verdict}; the baseline says {expected or 'nothing'}", part["reason"])
    elif verdict == Verdict.NOT_TESTABLE:
        ElementTree.SubElement(case, "skipped", message=part["reason"])
    else:
        ElementTree.SubElement(case, "system-out").text = f"{verdict}: {part['reason']}"


def _failure(case: ElementTree.Element, message: str, text: str) -> None:
    ElementTree.SubElement(case, "failure", message=message).text = text


def _count(element: ElementTree.Element) -> None:
    for name, tag in (("tests", "testcase"), ("failures", "failure"), ("skipped", "skipped")):
        element.set(name, str(sum(1 for _ in element.iter(tag))))
    element.set("errors", "0")
    element.set("time", "0")
