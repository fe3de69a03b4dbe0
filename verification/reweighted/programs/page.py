"""What was found of installed packages, as plain data and as a page."""

from collections.abc import Callable
from typing import Any

from verification.reweighted.answers import Word
from verification.reweighted.programs.packages import Judged, judge_packages

SCHEMA = "convexperc/reweighted-packages/1"

HEAD = """\
# Reweighted programs in packages that people install

Made by `convexperc-verification packages`, with the versions in the table. Each program is asked on small
inputs, as they are, and changed in a way that its objective follows: in other units, with rows doubled,
permuted or zero. Its answer is compared with another point, F at both in exact numbers and balls, by the
tolerance of its row; where its documentation can be read in two ways, both are rows. "within" is proved by
a lower bound of each optimum, and speaks of the inputs that were asked alone. How it is decided:
[reweighted loops](../docs/reweighted.md).

| package | program | tolerance | as given | other questions |
|---|---|---|---|---|"""


def packages_record(told: Callable[[str], None] = lambda name: None) -> dict[str, Any]:
    """Judge the packages that are installed; plain data."""
    rows = []
    for judged in judge_packages():
        rows.append(_row(judged))
        told(rows[-1]["package"] + ", " + rows[-1]["program"])
    return {"schema": SCHEMA, "programs": rows}


def _row(judged: Judged) -> dict[str, Any]:
    case, answers = judged.case, judged.answers
    return {
        "package": f"{case.distribution} {judged.version}",
        "program": case.program,
        "promise": case.promise,
        "tolerance": str(case.rule),
        "answers": answers.as_json()["answers"],
        "findings": [finding.as_json() for finding in answers.findings],
    }


def markdown(record: dict[str, Any]) -> str:
    """The page."""
    lines = [HEAD]
    for row in record["programs"]:
        asked = [answer for answer in row["answers"] if answer["question"] != "warnings"]
        first, *others = (f"{each['question']}: {_said(each)}" for each in asked)
        told = first.partition(": ")[2], "; ".join(others) or "not asked"
        lines.append(f"| {row['package']} | `{row['program']}` | {row['tolerance']} | {' | '.join(told)} |")
    right = [
        f"{row['package']}, `{row['program']}` ({row['tolerance']})"
        for row in record["programs"]
        if not any(answer["fault"] for answer in row["answers"])
    ]
    lines += [
        "",
        f"Against these nothing was found: {'; '.join(right) or 'none'}.",
        "",
        "## What was found",
        "",
    ]
    for row in record["programs"]:
        for finding in row["findings"]:
            if finding["fault"]:
                lines += _finding(row, finding)
    return "\n".join(lines).rstrip() + "\n"


def _said(answer: dict[str, Any]) -> str:
    if answer["fault"]:
        return "**beyond**"
    return {Word.YES.value: "within", Word.NO.value: "told by a warning"}.get(answer["answer"], "undecided")


def _finding(row: dict[str, Any], finding: dict[str, Any]) -> list[str]:
    lines = [f"### {row['package']}, `{row['program']}`, {finding['question']}", ""]
    lines += [f"Promise: {row['promise']}.", "", f"{finding['statement']}", ""]
    given = ", ".join(f"{name} = {value}" for name, value in finding["input"].items())
    answer = ", ".join(f"{name} = {value}" for name, value in finding["answer"].items())
    other = ", ".join(f"{name} = {value}" for name, value in finding["other point"].items())
    lines += [
        f"    {part}"
        for part in (f"id: {finding['id']}", given, f"answer: {answer}", f"a better point: {other}")
    ]
    warned = "; ".join(finding["warned"])
    return [*lines, "", f"It warned: {warned}." if warned else "It gave no warning.", ""]
