"""What a run of the kit found, as a table for the terminal, JSON, junit.xml and a page."""

import statistics
from typing import Any
from xml.etree import ElementTree

from rich.console import Group
from rich.table import Table
from rich.text import Text

from convexperc.errors import escaped
from verification.conformance.judge import WORDS, Finding, Level
from verification.conformance.searching import Searched
from verification.conformance.suite import COUNTED, SMALLEST, Report
from verification.ledger.evidence import Outcome
from verification.report.plain import printable

SCHEMA = "convexperc/conformance-report/1"
LONGEST_LINE = 4000
"""Characters of a request that a page shows; the JSON has it whole."""


def table(report: Report) -> Group:
    """Counts by level, the smallest failures, and the statement."""
    grid = Table("level", "what it asks", *COUNTED)
    for level in Level:
        counts = report.counts(level)
        grid.add_row(level, WORDS[level], *(str(counts[word]) for word in COUNTED))
    shown, lines = set(), []
    for each in smallest(report):
        told = told_lines(each, report)
        lines += [Text(escaped(line)) for line in (told[:1] if each.id in shown else told)]
        shown.add(each.id)
    if report.digits:
        least, middle = min(report.digits), statistics.median(report.digits)
        lines.append(Text(f"digits to which F(w, u) agrees with F*: least {least:.1f}, median {middle:.1f}"))
    lines += (
        [Text(f"keys of answers that nobody reads: {', '.join(report.ignored)}")] if report.ignored else []
    )
    lines += [Text(escaped(f"known failure that did not fail: {each}")) for each in report.stale]
    return Group(grid, *lines, Text(escaped(report.statement)))


def told_lines(finding: Finding, report: Report) -> list[str]:
    """A failure and, where there is one, what was answered and what is better."""
    explained = report.explained.get(finding.id)
    return [f"{finding.id} {finding.level}: {finding.detail}", *(explained.lines if explained else ())]


def smallest(report: Report) -> list[Finding]:
    """Of each level, the unexpected failures of the smallest requests."""
    return [
        each
        for level in Level
        for each in [found for found in report.unexpected if found.level is level][:SMALLEST]
    ]


def searched_lines(searched: Searched) -> list[str]:
    """What the search found, each failure with its request."""
    lines = [f"search: {searched.asked} requests beyond the vectors, {searched.undecided} verdicts undecided"]
    for each in searched.found:
        lines.append(
            f"{each.level} fails on {each.failures}, the smallest of family {each.family}: {each.detail}"
        )
        lines += [*(each.explained.lines if each.explained else ()), each.line]
    return lines + [f"the kit itself failed: {each}" for each in searched.broken]


def as_json(report: Report, searched: Searched | None) -> dict[str, Any]:
    """Plain data: counts, every finding that is no pass, and the requests of those that failed."""
    return {
        "schema": SCHEMA,
        "solver": printable(report.solver),
        "vectors": report.version,
        "profile": report.selection.profile.name,
        "filter": report.selection.only,
        "statement": printable(report.statement),
        "reached": report.reached,
        "levels": {level: {word: report.counts(level)[word] for word in COUNTED} for level in Level},
        "digits": sorted(round(each, 2) for each in report.digits),
        "seconds": {"total": sum(report.seconds), "median": statistics.median(report.seconds or (0.0,))},
        "findings": [_finding(each) for each in report.findings if each.outcome is not Outcome.HELD],
        "known": [f"{id} {level}" for id, level in report.known],  # noqa: A001
        "stale": list(report.stale),
        "ignored": list(report.ignored),
        "requests": {
            each.id: report.requests[each.id] for each in report.failed if each.id in report.requests
        },
        "explained": {
            each.id: report.explained[each.id].as_json()
            for each in smallest(report)
            if each.id in report.explained
        },
        "search": None if searched is None else _searched(searched),
    }


def _finding(each: Finding) -> dict[str, Any]:
    return {"id": each.id, "level": each.level, "outcome": each.outcome, "detail": printable(each.detail)}


def _searched(searched: Searched) -> dict[str, Any]:
    found = [
        {
            "level": each.level,
            "failures": each.failures,
            "family": each.family,
            "detail": printable(each.detail),
            "request": each.line,
            "explained": each.explained.as_json() if each.explained else None,
        }
        for each in searched.found
    ]
    return {
        "asked": searched.asked,
        "undecided": searched.undecided,
        "found": found,
        "broken": list(searched.broken),
    }


def junit(report: Report) -> bytes:
    """One test case for each level of each request; what is known to fail is skipped with its reason."""
    suite = ElementTree.Element("testsuite", name=printable(f"conformance of {report.solver}"))
    counts = {"failures": 0, "skipped": 0}
    for each in report.findings:
        case = ElementTree.SubElement(suite, "testcase", classname=each.id, name=each.level)
        known = report.known.get((each.id, each.level))
        detail = printable(each.detail)
        if each.outcome is Outcome.FAILED and known is None:
            counts["failures"] += 1
            ElementTree.SubElement(case, "failure", message=detail)
        elif each.outcome is not Outcome.HELD:
            counts["skipped"] += 1
            message = detail if known is None else f"known failure: {printable(known)}: {detail}"
            ElementTree.SubElement(case, "skipped", message=message)
    suite.set("tests", str(len(report.findings)))
    for name, count in counts.items():
        suite.set(name, str(count))
    ElementTree.indent(suite)
    text = ElementTree.tostring(suite, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def page(report: Report, searched: Searched | None) -> bytes:
    """One HTML file without scripts."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - comes with an extra

    loader = PackageLoader("verification.conformance", "templates")
    made = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    digits = (min(report.digits), statistics.median(report.digits)) if report.digits else None
    text = made.get_template("conformance.html.j2").render(
        report=report, searched=searched, levels=list(Level), words=WORDS, counted=COUNTED, digits=digits,
        smallest=smallest(report), longest=LONGEST_LINE,
    )  # fmt: skip
    return (printable(text.rstrip()) + "\n").encode()
