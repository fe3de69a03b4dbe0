"""junit.xml: one test case a part, passed where the verdict is the baseline's; for servers that read it."""

from xml.etree import ElementTree

from verification.ledger.evidence import Verdict
from verification.report.contents import JudgedPart, Report
from verification.report.plain import printable

FINDINGS = {
    "failed": "no promise of the library fails",
    "changed": "every verdict is the baseline's",
    "stale": "every stored counterexample still fails",
    "open": "nothing that is required is missing or open",
}
"""By the fields of `verification.ledger.baseline.Assessment`."""


def junit(report: Report) -> bytes:
    """Render junit.xml; it holds nothing volatile, every time is 0."""
    root = ElementTree.Element("testsuites", name="convexperc verification")
    for claim in report.claims:
        suite = ElementTree.SubElement(root, "testsuite", name=claim.id)
        for part in claim.parts:
            _part(_case(suite, part.key, claim.id), part)
    run = ElementTree.SubElement(root, "testsuite", name="run")
    for field, name in FINDINGS.items():
        case = _case(run, name, "run")
        if lines := getattr(report.outcome, field):
            _failure(case, f"{len(lines)} found", "\n".join(lines))
    for element in (*root, root):
        _count(element)
    ElementTree.indent(root)
    text = printable(ElementTree.tostring(root, encoding="unicode"))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _case(suite: ElementTree.Element, name: str, classname: str) -> ElementTree.Element:
    return ElementTree.SubElement(suite, "testcase", name=name, classname=classname, time="0")


def _part(case: ElementTree.Element, part: JudgedPart) -> None:
    if part.verdict != part.baseline:
        message = f"{part.verdict}; the baseline says {part.baseline or 'nothing'}"
        _failure(case, message, part.reason)
    elif part.verdict is Verdict.NOT_TESTABLE:
        ElementTree.SubElement(case, "skipped", message=part.reason)
    else:
        ElementTree.SubElement(case, "system-out").text = f"{part.verdict}: {part.reason}"


def _failure(case: ElementTree.Element, message: str, text: str) -> None:
    ElementTree.SubElement(case, "failure", message=message).text = text


def _count(element: ElementTree.Element) -> None:
    for name, tag in (("tests", "testcase"), ("failures", "failure"), ("skipped", "skipped")):
        element.set(name, str(sum(1 for _ in element.iter(tag))))
    element.set("errors", "0")
    element.set("time", "0")
