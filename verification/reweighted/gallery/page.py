"""The gallery as a page: each loop with its place, its formulas, what is said of it, and what repairs it."""

from typing import Any

from verification.reweighted.gallery import CASES, Case

HEAD = """\
# Reweighted loops of the literature, judged

Made by `convexperc-verification loops --page` from what `loops --store` found. Each loop is stated in our
words, and judged against its own objective on small data: what is proved of it follows from the
[theorem](../docs/reweighted-theorem.md), and what speaks against it is shown by an instance with an id,
which `convexperc-verification loops ID` replays in exact numbers. A rest at a residual of exactly 0 is true
of every weight that is not smoothed; how likely it is met is not said. What each question asks: [reweighted
loops](../docs/reweighted.md).

| loop | F never rises | against it |
|---|---|---|"""


def markdown(stored: dict[str, Any]) -> str:
    """The page of what is stored of the gallery."""
    lines, parts = [HEAD], []
    for case in CASES.values():
        found = stored["cases"][case.id]
        answers = {answer["question"]: answer for answer in found["answers"]}
        against = ", ".join(name for name, answer in answers.items() if answer["fault"]) or "nothing found"
        lines.append(f"| [{case.title}](#{case.id}) | {answers['descends']['answer']} | {against} |")
        parts += _part(case, answers, found["records"])
    return "\n".join([*lines, "", *parts]).rstrip() + "\n"


def _part(case: Case, answers: dict[str, Any], records: list[dict[str, Any]]) -> list[str]:
    lines = [f"## {case.id}", "", f"{case.title}. {case.source}.", ""]
    lines += [f"    objective: {case.objective}", f"    update: {case.update}", ""]
    ids = {record["question"]: record["id"] for record in records}
    for question, answer in answers.items():
        replay = f" Instance `{ids[question]}`." if question in ids else ""
        lines.append(f"- {question}: {answer['answer']}. {_plain(answer['statement'])}{replay}")
    repair = f"Repaired by: {case.repair}." if case.repair else "No repair is needed."
    return [*lines, "", repair, ""]


def _plain(statement: str) -> str:
    """No character of a formula is markup."""
    return statement.replace("*", "\\*").replace("_", "\\_").replace("<", "\\<").replace("|", "\\|")
