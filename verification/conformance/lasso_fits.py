"""What packages of the lasso family answer, judged by `certify_lasso`: rows for the page of findings.

The data sets are drawn from a seed and their number. An answer is judged by the objective that the package
documents, and by a gap that is proved.
"""

import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.lasso import LassoCertificate, certify_lasso
from verification.conformance import lasso_runner

SETS = 36
SECONDS = 240.0
"""Time for all data sets of one peer."""

KINDS = ("random", "equal columns", "zero columns", "equal up to 1e-6", "large columns", "small target")
NEAR, NEARER = 1e-6, 1e-8
"""Relative gaps that are counted: the tolerances of L1 and L2."""


@dataclass(frozen=True, eq=False)
class DataSet:
    """A least-squares fit with groups of consecutive columns.

    Attributes
    ----------
    id : str
    kind : str
        One of `KINDS`.
    X : float64 (n, p)
    y : float64 (n,)
    sizes : list of int
        Columns of each group.
    alpha : float
    intercept : bool
    """

    id: str
    kind: str
    X: Any
    y: Any
    sizes: list[int]
    alpha: float
    intercept: bool

    @property
    def line(self) -> str:
        """The data set as JSON."""
        data = {"id": self.id, "X": self.X.tolist(), "y": self.y.tolist(), "sizes": self.sizes}
        return json.dumps(data | {"alpha": self.alpha, "intercept": self.intercept})

    @property
    def energy(self) -> float:
        """||y||^2 / n, of the centred y where there is an intercept."""
        y = self.y - self.y.mean() if self.intercept else self.y
        return float(y @ y) / len(y)


def data_set(index: int) -> DataSet:
    """Data set number `index`: kinds in turn, an intercept in every second, small and larger ones."""
    rng, kind = np.random.default_rng([7, index]), KINDS[index % len(KINDS)]
    sizes = [int(k) for k in rng.integers(1, 7, int(rng.integers(2, 9)))]
    n, p = int(rng.integers(6, 40)), sum(sizes)
    X = rng.standard_normal((n, p))
    y = X[:, : sizes[0]].sum(axis=1) + 0.5 * rng.standard_normal(n) + 1.0
    if kind == "equal columns":
        X[:, -1] = X[:, 0]
    elif kind == "zero columns":
        X[:, : sizes[0]] = 0.0
    elif kind == "equal up to 1e-6":
        X[:, -1] = X[:, 0] + 1e-6 * X[:, -1]
    elif kind == "large columns":
        X *= 10.0 ** rng.integers(-3, 4, p)
    elif kind == "small target":
        y *= 1e-4
    intercept = bool(index // len(KINDS) % 2)
    target = y - y.mean() if intercept else y
    pulls = [np.linalg.norm(part.T @ target) for part in np.split(X, np.cumsum(sizes)[:-1], axis=1)]
    alpha = float(max(pulls)) / n * float(rng.choice([0.3, 0.1, 0.01]))
    return DataSet(f"lasso-{index:02}", kind, X, y, sizes, alpha, intercept)


@dataclass(frozen=True)
class Fitted:
    """A package of the table.

    Attributes
    ----------
    runner : str
        A key of `verification.conformance.lasso_runner.PEERS`.
    name, tolerance, package, module : str
        As for `verification.conformance.findings.Peer`; the version of `package` is told.
    convention : str
        Whose objective its answers are judged by; a key of `convexperc.lasso.CONVENTIONS`.
    groups : bool
    gap : float or None
        The gap that its tolerance promises, as a share of ||y||^2 / n; None where it promises another thing.
    factor : float
        What alpha is multiplied by before the answer is judged.
    """

    runner: str
    name: str
    tolerance: str
    package: str
    module: str
    convention: str
    groups: bool = True
    gap: float | None = None
    factor: float = 1.0


_GAP = "gap {} of ‖y‖²/n"


def _both(
    runner: str, name: str, package: str, module: str, convention: str, promise: str,
    tolerances: tuple[str, str], *, groups: bool = True, gap: bool = False, factor: float = 1.0,
) -> tuple[Fitted, Fitted]:  # fmt: skip
    """Rows of a package at its default tolerance and at a tight one."""
    default, tight = (
        Fitted(
            each, name, promise.format(tolerance) + told, package, module, convention, groups,
            float(tolerance) if gap else None, factor,
        )
        for each, tolerance, told in zip(
            (runner, f"{runner}_tight"), tolerances, ("", ", set"), strict=True
        )
    )  # fmt: skip
    return default, tight


FITTED = (
    *_both("sklearn", "scikit-learn, Lasso", "scikit-learn", "sklearn", "scikit-learn", _GAP,
           ("1e-4", "1e-10"), groups=False, gap=True),
    *_both("celer", "celer, GroupLasso", "celer", "celer", "celer", _GAP, ("1e-4", "1e-10"), gap=True),
    *_both("skglm", "skglm, GroupLasso", "skglm", "skglm", "skglm", "violation {}", ("1e-4", "1e-8")),
    *_both("adelie", "adelie, grpnet", "adelie", "adelie", "adelie", "steps {}", ("1e-7", "1e-14")),
    *_both("asgl", "asgl, Regressor", "asgl", "asgl", "asgl", "0 below {}", ("1e-3", "1e-14")),
    *_both("group_lasso", "group-lasso, as documented", "group-lasso", "group_lasso", "group-lasso",
           "steps {}", ("1e-5", "1e-10")),
    *_both("group_lasso", "group-lasso, by twice its strength", "group-lasso", "group_lasso", "group-lasso",
           "steps {}", ("1e-5", "1e-10"), factor=2.0),
)  # fmt: skip


def rows(
    pythons: Mapping[str, str],
    fitted: Sequence[Fitted] = FITTED,
    sets: Sequence[DataSet] = (),
    progress: Callable[[str, int, int], None] = lambda name, done, total: None,
) -> list[dict[str, Any]]:
    """Run every package that is installed, here or in the environment of an interpreter; plain data.

    Parameters
    ----------
    pythons : mapping of str to str
        For a package, the Python that has it; the others are looked for in this environment.
    """
    asked = sets or [data_set(k) for k in range(SETS)]
    absent, found = dict[int, str](), dict[int, _Answers]()
    answers = dict[str, tuple[str, list[dict[str, Any]]]]()
    for k, each in enumerate(fitted):
        progress(each.name, k, len(fitted))
        if each.package not in pythons and find_spec(each.module) is None:
            absent[k] = f"{each.module} is not installed"
            continue
        if each.runner not in answers:
            python = pythons.get(each.package, sys.executable)
            answers[each.runner] = ask(python, each.runner, each.package, asked)
        found[k] = _Answers(each, asked, *answers[each.runner])
    lowest = _lowest(found.values())
    return [
        {"name": each.name, "absent": absent[k]} if k in absent else found[k].row(lowest)
        for k, each in enumerate(fitted)
    ]


def ask(python: str, runner: str, package: str, sets: Sequence[DataSet]) -> tuple[str, list[dict[str, Any]]]:
    """The version of the package, and its answers; what it does not answer in time is an error."""
    words = [python, str(Path(lasso_runner.__file__)), runner, package]
    lines = "".join(f"{each.line}\n" for each in sets)
    try:
        done = subprocess.run(
            words, input=lines, capture_output=True, text=True, timeout=SECONDS, check=False
        )
        text, why = done.stdout, f"ended with {done.returncode}: {done.stderr.strip()[-200:]}"
    except subprocess.TimeoutExpired as late:
        text, why = (late.stdout or b"").decode(), f"no answer within {SECONDS:g} s"
    version, *answers = [json.loads(line) for line in text.splitlines()] or [{"version": "unknown"}]
    missing = [{"error": why}] * (len(sets) - len(answers))
    return version["version"], answers + missing


def judged(each: Fitted, data: DataSet, answer: Mapping[str, Any]) -> LassoCertificate:
    """The certificate of an answer, by the objective that the package documents."""
    options: dict[str, Any] = {"intercept": answer["intercept"]} if data.intercept else {}
    if each.groups:
        options["groups"] = np.repeat(np.arange(len(data.sizes)), data.sizes)
    if each.convention == "asgl":
        options["l1_ratio"] = 0.0
    alpha = each.factor * data.alpha
    return certify_lasso(data.X, data.y, answer["coef"], alpha, convention=each.convention, **options)


Problem = tuple[str, float, str]
"""An objective, by convention and factor, of a data set."""


class _Answers:
    """What a package answered, with certificates."""

    def __init__(
        self, fitted: Fitted, sets: Sequence[DataSet], version: str, answers: Sequence[Mapping[str, Any]]
    ) -> None:
        self.fitted, self.version, self.sets = fitted, version, sets
        self.error = next((answer["error"] for answer in answers if "error" in answer), None)
        self.judged = [
            (data, judged(fitted, data, answer))
            for data, answer in zip(sets, answers, strict=True)
            if "error" not in answer and np.isfinite([*answer["coef"], answer["intercept"]]).all()
        ]

    def problem(self, data: DataSet) -> Problem:
        """What was solved."""
        return self.fitted.convention, self.fitted.factor, data.id

    def _fails(self, data: DataSet, found: LassoCertificate, lowest: Mapping[Problem, float]) -> bool:
        """Whether a promised gap is proved to be exceeded; without a promise, no gap of `NEAR` is proved."""
        if self.fitted.gap is None:
            return found.relative_gap > NEAR
        return found.objective[0] - lowest[self.problem(data)] > self.fitted.gap * data.energy

    def row(self, lowest: Mapping[Problem, float]) -> dict[str, Any]:
        """The row of the table; plain data."""
        each, gaps = self.fitted, [found.relative_gap for _, found in self.judged]
        kept = [found.gap <= (each.gap or 0.0) * data.energy for data, found in self.judged]
        failed = [(data, found) for data, found in self.judged if self._fails(data, found, lowest)]
        smallest = min(failed, key=lambda pair: pair[0].X.size, default=None)
        promise = None if each.gap is None else {"kept": sum(kept), "broken": len(failed)}
        return {
            "name": each.name, "tolerance": each.tolerance, "versions": f"{each.package} {self.version}",
            "sets": len(self.sets), "answered": len(self.judged), "promise": promise,
            "near": sum(gap <= NEAR for gap in gaps), "nearer": sum(gap <= NEARER for gap in gaps),
            "worst": max(gaps) if gaps and all(map(math.isfinite, gaps)) else None,
            "smallest": None if smallest is None else _told(*smallest), "error": self.error,
        }  # fmt: skip


def _lowest(found: Iterable[_Answers]) -> dict[Problem, float]:
    """The least upper bound of each optimum that any answer gives."""
    lowest = dict[Problem, float]()
    for each in found:
        for data, certificate in each.judged:
            name = each.problem(data)
            lowest[name] = min(certificate.upper, lowest.get(name, math.inf))
    return lowest


def _told(data: DataSet, certificate: LassoCertificate) -> dict[str, Any]:
    n, p = data.X.shape
    shares = f"{certificate.relative_gap:.2g} of the optimum, {certificate.gap / data.energy:.2g} of ‖y‖²/n"
    return {"id": data.id, "detail": f"{data.kind}, {n} by {p}: gap at most {shares}"}


def markdown(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """The section of the page."""
    lines = [HEAD.format(sets=SETS)]
    for row in found:
        if "absent" in row:
            continue
        promise = row["promise"]
        kept = "-" if promise is None else f"{promise['kept']}, {promise['broken']}"
        worst = "unknown" if row["worst"] is None else f"{row['worst']:.1g}"
        told = [row["name"], row["tolerance"], row["versions"], f"{row['answered']} of {row['sets']}", kept]
        told += [str(row["near"]), str(row["nearer"]), worst]
        smallest = row["smallest"]
        told.append("" if smallest is None else f"`{smallest['id']}`: {smallest['detail']}")
        lines.append(f"| {' | '.join(told)} |")
    absent = [f"Not run: {row['name']}: {row['absent']}." for row in found if "absent" in row]
    errors = [f"{row['name']} ({row['tolerance']}): {row['error']}." for row in found if row.get("error")]
    return [*lines, "", *(f"{each}\n" for each in (*errors, *absent))]


HEAD = """\
## Lasso family

Answers to {sets} data sets, each judged by the objective that the package documents, with [a proved
gap](../docs/lasso.md). The sets have groups of one to six columns; equal, nearly equal and zero columns;
columns and targets of other orders of size; half of them an intercept. `data_set(k)` of
`verification/conformance/lasso_fits.py` is the one named `lasso-k`. scikit-learn and celer promise a duality
gap: how often it is proved to be kept is told, and how often proved to be exceeded, by a better answer of
another row. The other tolerances are of steps, of the optimality conditions, or what is rounded to 0: a larger
gap breaks no promise. The smallest set is told on which a promise is proved to be broken, or without one the
gap is not proved to be 1e-6 of the optimum. A gap is an upper bound.

| package | tolerance | version | answered | promise kept, broken | gap ≤ 1e-6 | gap ≤ 1e-8 | worst gap | smallest |
|---|---|---|---|---|---|---|---|---|"""  # noqa: E501
