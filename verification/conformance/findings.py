"""What the kit finds about solvers that people use: one run of each, and a page that can be made again."""

import re
import shlex
import shutil
import statistics
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import convexperc
from verification.conformance import lasso_fits
from verification.conformance.doors import LAST_WORDS, Command, Door, Module
from verification.conformance.generated import LARGEST
from verification.conformance.judge import Finding, Level
from verification.conformance.profiles import FLOAT64
from verification.conformance.suite import Report, Selection, run
from verification.conformance.vectors import VERSION
from verification.provenance import installed

PLACE = "verification.conformance.adapters"
GENERATED = "verification.conformance.generated"
SECONDS = 60.0
"""For an answer; Numba compiles some solvers when the first request that they take comes."""
COMPILING = 300.0
"""Seconds for an answer of generated code: the first one of a shape waits for the compiler."""
SCHEMA = "convexperc/conformance-findings/1"
LONGEST = 600
"""Characters of a request that the page shows; a longer one is named by its id."""


HEAD = """\
# What the conformance kit finds about solvers that people use

Vectors {vectors}, profile {profile}; made by `convexperc-verification conform findings`. A level is reached if
nothing failed up to there. What a solver declines, because it is not made for it, is counted and is no failure. A
solver at its default tolerance may fail L1 or L2 and still keep its own promise: the column says what that is, and a
second row has a tighter one where there is one. CVXPYgen writes C code for a problem with parameters; it is asked what
has n d ≤ {largest}, as each shape is compiled: once as the first call of a program, and once as the second, after
another problem of the same shape. What fails in the second alone is left over from the first, as a warm start may be.
Malformed data are refused by the adapters, not by the solvers. That all vectors pass proves nothing of other inputs.
What the levels ask, and two faults of generated code: [verify your own solver](../docs/conformance.md).

| solver | tolerance | versions | reaches | L0 failed | L1 failed | L2 failed | L3 failed | L4 failed | declined | digits |
|---|---|---|---|---|---|---|---|---|---|---|"""  # noqa: E501
"""Text and head of the table; digits: to which F(w, u) agrees with F*, least and median."""


@dataclass(frozen=True)
class Peer:
    """A solver of the page.

    Attributes
    ----------
    adapter : str
        A function of `verification.conformance.adapters`; of generated code the options of
        `verification.conformance.generated`.
    name : str
    tolerance : str
        At which it runs: its own default, or one that the adapter sets.
    packages : tuple of str
        Whose versions are told.
    module : str
        What must be there.
    """

    adapter: str
    name: str
    tolerance: str
    packages: tuple[str, ...]
    module: str = "numpy"

    @property
    def generated(self) -> bool:
        """Whether it is C code that is generated and compiled."""
        return self.adapter.startswith("--")

    @property
    def words(self) -> list[str]:
        """The program that answers for generated code, without the Python that runs it."""
        return ["-m", GENERATED, *shlex.split(self.adapter)]

    @property
    def command(self) -> str:
        """What asks it again."""
        if not self.generated:
            return f"convexperc-verification conform --module {PLACE}:{self.adapter}"
        program = shlex.join(["python", *self.words])
        return f"convexperc-verification conform --command '{program}' --timeout {COMPILING:g}"

    @property
    def absent(self) -> str:
        """Why it cannot be run here; empty where it can."""
        if find_spec(self.module) is None:
            return f"{self.module} is not installed"
        tools = [name for name in ("cmake", "cc") if self.generated and shutil.which(name) is None]
        return f"there is no {' and no '.join(tools)}" if tools else ""

    def door(self, folder: str) -> Door:
        """How it is asked; generated code is kept in the folder."""
        if not self.generated:
            return Module(f"{PLACE}:{self.adapter}", seconds=SECONDS)
        return Command([sys.executable, *self.words, "--folder", folder], seconds=COMPILING)


def _generated(backend: str, name: str, tolerance: str, solver: str) -> tuple[Peer, Peer]:
    """Rows of one solver of CVXPYgen: the first call of its code, and the call after another problem."""
    packages = ("cvxpygen", *([solver] if solver else []))
    first, second = (
        Peer(f"--backend {backend} --state {state}", f"{name}, {call} call", tolerance, packages, "cvxpygen")
        for state, call in (("fresh", "first"), ("primed", "second"))
    )
    return first, second


PEERS = (
    Peer("library", "convexperc", "gap 1e-9", ("convexperc",)),
    Peer("exact", "convexperc, ball arithmetic", "gap 1e-9", ("convexperc", "python-flint")),
    Peer("cvxpy_clarabel", "CVXPY with Clarabel", "1e-8", ("cvxpy", "clarabel"), "clarabel"),
    Peer("cvxpy_scs", "CVXPY with SCS", "1e-5", ("cvxpy", "scs"), "scs"),
    Peer("cvxpy_scs_tight", "CVXPY with SCS", "1e-10, set", ("cvxpy", "scs"), "scs"),
    Peer("cvxpy_qoco", "CVXPY with QOCO", "1e-7", ("cvxpy", "qoco"), "qoco"),
    Peer("cvxpy_osqp", "CVXPY with OSQP", "1e-5", ("cvxpy", "osqp"), "osqp"),
    Peer("cvxpy_osqp_tight", "CVXPY with OSQP", "1e-10, set", ("cvxpy", "osqp"), "osqp"),
    *_generated("qoco", "CVXPYgen with QOCO", "1e-7", ""),
    *_generated("qocogen", "CVXPYgen with QOCOGEN", "1e-7", "qocogen"),
    Peer(
        "--backend qocogen_example --state fresh --largest 2",
        "CVXPYgen with QOCOGEN, called as in its example",
        "not set",
        ("cvxpygen", "qocogen"),
        "cvxpygen",
    ),
    *_generated("ecos", "CVXPYgen with ECOS", "1e-8", ""),
    *_generated("scs", "CVXPYgen with SCS", "1e-4", ""),
    *_generated("scs_tight", "CVXPYgen with SCS", "1e-10, set", ""),
    *_generated("osqp", "CVXPYgen with OSQP", "1e-3", "osqp"),
    *_generated("osqp_tight", "CVXPYgen with OSQP", "1e-10, set", "osqp"),
    Peer("sklearn_lasso", "scikit-learn, Lasso", "1e-4", ("scikit-learn",), "sklearn"),
    Peer("sklearn_lasso_tight", "scikit-learn, Lasso", "1e-14, set", ("scikit-learn",), "sklearn"),
    Peer("celer_lasso", "celer, Lasso", "1e-4", ("celer",), "celer"),
    Peer("celer_lasso_tight", "celer, Lasso", "1e-14, set", ("celer",), "celer"),
    Peer("skglm_lasso", "skglm, Lasso", "1e-4", ("skglm",), "skglm"),
    Peer("skglm_lasso_tight", "skglm, Lasso", "1e-10, set", ("skglm",), "skglm"),
    Peer("paper_printed", "the paper's algorithm as printed", "500 iterations", ("convexperc",)),
    Peer("paper_corrected", "the paper's algorithm, corrected", "500 iterations", ("convexperc",)),
)


def findings(
    peers: Sequence[Peer] = PEERS,
    fitted: Sequence[lasso_fits.Fitted] = lasso_fits.FITTED,
    *,
    pythons: Mapping[str, str] | None = None,
    progress: Callable[[str, int, int], None] = lambda name, done, total: None,
) -> dict[str, Any]:
    """Run the vectors and the data sets against every peer that is installed; plain data.

    Parameters
    ----------
    pythons : mapping of str to str
        See `verification.conformance.lasso_fits.rows`.
    """
    solvers: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        for peer in peers:
            if peer.absent:
                solvers.append({"name": peer.name, "absent": peer.absent})
                continue
            report = run(
                peer.door(folder),
                Selection(FLOAT64),
                progress=lambda done, total, name=peer.name: progress(name, done, total),  # type: ignore[misc]
            )
            solvers.append(_row(peer, report))
    lassos = lasso_fits.rows(pythons or {}, fitted, progress=progress)
    told = {"schema": SCHEMA, "vectors": VERSION, "profile": FLOAT64.name}
    return told | {"solvers": solvers, "lassos": lassos}


def _row(peer: Peer, report: Report) -> dict[str, Any]:
    versions = " ".join(f"{name} {_version(name)}" for name in peer.packages)
    smallest = next(iter(report.failed), None)
    problems = [each for each in report.findings if each.level is Level.L2]
    levels = {level: {word: report.counts(level)[word] for word in ("held", "failed")} for level in Level}
    return {
        "name": peer.name,
        "tolerance": peer.tolerance,
        "versions": versions,
        "command": peer.command,
        "reached": report.reached,
        "asked": len(problems),
        "declined": sum(
            each.level is Level.L0 and each.outcome.value == "skipped" for each in report.findings
        ),
        "levels": levels,
        "digits": [min(report.digits), statistics.median(report.digits)] if report.digits else None,
        "smallest": None if smallest is None else _told(smallest, report),
    }


def _version(name: str) -> str:
    return convexperc.__version__ if name == "convexperc" else installed(name)


def _told(finding: Finding, report: Report) -> dict[str, str]:
    return {
        "id": finding.id,
        "level": finding.level,
        "detail": finding.detail.partition(LAST_WORDS)[0],
        "request": report.requests.get(finding.id, ""),
    }


def markdown(record: dict[str, Any]) -> str:
    """The page."""
    lines = [HEAD.format(**record, largest=LARGEST)]
    present = [row for row in record["solvers"] if "absent" not in row]
    for row in present:
        counts = " | ".join(_count(row["levels"][level]) for level in Level)
        digits = "" if row["digits"] is None else f"{row['digits'][0]:.1f}, {row['digits'][1]:.1f}"
        told = [row["name"], row["tolerance"], row["versions"], row["reached"] or "none", counts]
        lines.append(f"| {' | '.join(told)} | {row['declined']} of {row['asked']} | {digits} |")
    passed = [_called(row) for row in present if row["smallest"] is None and not row["declined"]]
    partly = [_called(row) for row in present if row["smallest"] is None and row["declined"]]
    lines += ["", f"Without a failure on all requests: {'; '.join(passed) or 'none'}."]
    lines += [f"Without a failure on the requests that they take: {'; '.join(partly) or 'none'}."]
    lines += ["", *lasso_fits.markdown(record["lassos"])]
    lines += ["## The smallest failing request of each", ""]
    for row in present:
        if row["smallest"] is not None:
            lines += _failure(row)
    absent = [f"{row['name']}: {row['absent']}" for row in record["solvers"] if "absent" in row]
    lines += [f"Not run: {each}." for each in absent]
    return "\n".join(lines).rstrip() + "\n"


def _called(row: dict[str, Any]) -> str:
    return f"{row['name']} ({row['tolerance']})"


def _count(counts: dict[str, int]) -> str:
    total = counts["failed"] + counts["held"]
    return f"{counts['failed']} of {total}" if total else "not asked"


def _failure(row: dict[str, Any]) -> list[str]:
    found = row["smallest"]
    detail = re.sub(r"([|<>`*_])", r"\\\1", found["detail"][:LONGEST])
    lines = [
        f"### {row['name']} ({row['tolerance']})",
        "",
        f"`{found['id']}`, {found['level']}: {detail}",
        "",
    ]
    lines += [f"    {row['command']} --filter {found['id']}", ""]
    if 0 < len(found["request"]) <= LONGEST:
        lines += ["```json", *found["request"].splitlines(), "```", ""]
    return lines
