"""What the kit finds about solvers that people use: one run of each, and a page that can be made again."""

import re
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from verification.conformance.doors import Module
from verification.conformance.judge import Finding, Level
from verification.conformance.profiles import FLOAT64
from verification.conformance.suite import Report, Selection, run
from verification.conformance.vectors import VERSION
from verification.provenance import installed

PLACE = "verification.conformance.adapters"
SECONDS = 20.0
SCHEMA = "convexperc/conformance-findings/1"
LONGEST = 600
"""Characters of a request that the page shows; a longer one is named by its id."""


@dataclass(frozen=True)
class Peer:
    """A solver of the page.

    Attributes
    ----------
    adapter : str
        A function of `verification.conformance.adapters`.
    name : str
    packages : tuple of str
        Whose versions are told.
    module : str
        What must be there.
    """

    adapter: str
    name: str
    packages: tuple[str, ...]
    module: str = "numpy"


PEERS = (
    Peer("library", "convexperc", ("convexperc",)),
    Peer("exact", "convexperc, ball arithmetic", ("convexperc", "python-flint")),
    Peer("cvxpy_clarabel", "CVXPY with Clarabel", ("cvxpy", "clarabel"), "clarabel"),
    Peer("cvxpy_scs", "CVXPY with SCS", ("cvxpy", "scs"), "scs"),
    Peer("cvxpy_scs_tight", "CVXPY with SCS, eps 1e-10", ("cvxpy", "scs"), "scs"),
    Peer("cvxpy_qoco", "CVXPY with QOCO", ("cvxpy", "qoco"), "qoco"),
    Peer("cvxpy_osqp", "CVXPY with OSQP", ("cvxpy", "osqp"), "osqp"),
    Peer("cvxpy_osqp_tight", "CVXPY with OSQP, eps 1e-10", ("cvxpy", "osqp"), "osqp"),
    Peer("sklearn_lasso", "scikit-learn, Lasso", ("scikit-learn",), "sklearn"),
    Peer("celer_lasso", "celer, Lasso", ("celer",), "celer"),
    Peer("skglm_lasso", "skglm, Lasso", ("skglm",), "skglm"),
    Peer("paper_printed", "the paper's algorithm as printed", ("convexperc",)),
    Peer("paper_corrected", "the paper's algorithm, corrected", ("convexperc",)),
)


def findings(
    peers: Sequence[Peer] = PEERS, progress: Callable[[str, int, int], None] = lambda name, done, total: None
) -> dict[str, Any]:
    """Run the vectors against every peer that is installed; plain data."""
    rows = []
    for peer in peers:
        if find_spec(peer.module) is None:
            rows.append({"name": peer.name, "absent": f"{peer.module} is not installed"})
            continue
        report = run(
            Module(f"{PLACE}:{peer.adapter}", seconds=SECONDS),
            Selection(FLOAT64),
            progress=lambda done, total, name=peer.name: progress(name, done, total),  # type: ignore[misc]
        )
        rows.append(_row(peer, report))
    return {"schema": SCHEMA, "vectors": VERSION, "profile": FLOAT64.name, "solvers": rows}


def _row(peer: Peer, report: Report) -> dict[str, Any]:
    versions = " ".join(f"{name} {installed(name)}" for name in peer.packages)
    smallest = next(iter(report.failed), None)
    problems = [each for each in report.findings if each.level is Level.L2]
    levels = {level: {word: report.counts(level)[word] for word in ("held", "failed")} for level in Level}
    return {
        "name": peer.name,
        "versions": versions,
        "command": f"convexperc-verification conform --module {PLACE}:{peer.adapter}",
        "reached": report.reached,
        "asked": len(problems),
        "declined": sum(
            each.level is Level.L0 and each.outcome.value == "skipped" for each in report.findings
        ),
        "levels": levels,
        "digits": [min(report.digits), statistics.median(report.digits)] if report.digits else None,
        "smallest": None if smallest is None else _told(smallest, report),
    }


def _told(finding: Finding, report: Report) -> dict[str, str]:
    return {
        "id": finding.id,
        "level": finding.level,
        "detail": finding.detail,
        "request": report.requests.get(finding.id, ""),
    }


def markdown(record: dict[str, Any]) -> str:
    """The page."""
    lines = [
        "# What the conformance kit finds about solvers that people use",
        "",
        f"Vectors {record['vectors']}, profile {record['profile']}; made by",
        "`convexperc-verification conform findings`. Solvers run at their default settings unless the name says",
        "otherwise. A level is reached if nothing failed up to there; what a solver declines, because it is not",
        "made for it, is counted and is no failure. L0 also counts malformed data, which many solvers leave to",
        "their callers. That all vectors pass proves nothing of other inputs. What the levels ask:",
        "[verify your own solver](../docs/conformance.md).",
        "",
        "| solver | versions | reaches | L0 failed | L1 failed | L2 failed | L3 failed | L4 failed | declined |"
        " digits: least, median |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    present = [row for row in record["solvers"] if "absent" not in row]
    for row in present:
        counts = " | ".join(_count(row["levels"][level]) for level in Level)
        digits = "" if row["digits"] is None else f"{row['digits'][0]:.1f}, {row['digits'][1]:.1f}"
        lines.append(
            f"| {row['name']} | {row['versions']} | {row['reached'] or 'none'} | {counts} |"
            f" {row['declined']} of {row['asked']} | {digits} |"
        )
    passed = [row["name"] for row in present if row["smallest"] is None and not row["declined"]]
    partly = [row["name"] for row in present if row["smallest"] is None and row["declined"]]
    lines += ["", f"Without a failure on all requests: {'; '.join(passed) or 'none'}."]
    lines += [f"Without a failure on the requests that they take: {'; '.join(partly) or 'none'}."]
    lines += ["", "## The smallest failing request of each", ""]
    for row in present:
        if row["smallest"] is not None:
            lines += _failure(row)
    absent = [f"{row['name']}: {row['absent']}" for row in record["solvers"] if "absent" in row]
    lines += [f"Not run: {each}." for each in absent]
    return "\n".join(lines).rstrip() + "\n"


def _count(counts: dict[str, int]) -> str:
    total = counts["failed"] + counts["held"]
    return f"{counts['failed']} of {total}" if total else "not asked"


def _failure(row: dict[str, Any]) -> list[str]:
    found = row["smallest"]
    detail = re.sub(r"([|<>`*_])", r"\\\1", found["detail"][:LONGEST])
    lines = [f"### {row['name']}", "", f"`{found['id']}`, {found['level']}: {detail}", ""]
    lines += [f"    {row['command']} --filter {found['id']}", ""]
    if 0 < len(found["request"]) <= LONGEST:
        lines += ["```json", *found["request"].splitlines(), "```", ""]
    return lines
