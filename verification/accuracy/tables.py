"""The tables of a record, in Markdown: percentages, with intervals at 95 % in brackets."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from verification.accuracy.methods import DISTANCES, METHODS, PAPER
from verification.accuracy.scenes import CONDITIONS

Result = Mapping[str, Any]
COMPARED = METHODS[1:]


def pages(record: Mapping[str, Any]) -> str:
    """Return all tables of a record as one page."""
    parts = ["# Accuracy beside simple rules\n\nWritten by `convexperc-verification accuracy`; never edited."]
    for result in record["results"]:
        pictures = result["pictures"]
        told = f"{pictures['objects']} objects, {pictures['photographs']} photographs"
        parts.append(f"## {pictures['name']}, features: {result['configuration name']}\n\n{told}.")
        parts += [f"### {title}\n\n{table(result)}" for title, table in TABLES.items()]
    return "\n\n".join(parts) + "\n"


def accuracy_table(result: Result) -> str:
    """Mean accuracy of each method."""
    rows = (
        [each["objects"], f"{each['scenes']}", *(percent(each["methods"][name][0]) for name in METHODS)]
        for each in result["accuracy"]
    )
    return _by_condition(result["accuracy"], ["objects", "scenes", *METHODS], rows)


def difference_table(result: Result) -> str:
    """The paper's accuracy, and that minus each other method's, in percentage points."""
    name = f"{PAPER[0]} minus"
    rows = (
        [each["objects"], interval(each["methods"][PAPER[0]]), *(signed(each[name][n]) for n in COMPARED)]
        for each in result["accuracy"]
    )
    return _by_condition(result["accuracy"], ["objects", PAPER[0], *(f"minus {n}" for n in COMPARED)], rows)


def margin_table(result: Result) -> str:
    """Area under the ROC curve of the margin for right against wrong labels, and accuracy by quarters."""
    kinds = PAPER[0], DISTANCES[0]
    rows = (
        [
            each["objects"],
            *(
                text
                for kind in kinds
                for text in (
                    area(each[kind]["auc"]),
                    ", ".join(percent(share) for share in each[kind]["quartiles"]),
                )
            ),
        ]
        for each in result["margin"]
    )
    heads = [f"{kind}: {what}" for kind in kinds for what in ("AUC", "accuracy by quarter")]
    return _by_condition(result["margin"], ["objects", *heads], rows)


def acceptance_table(result: Result) -> str:
    """What becomes of test scenes of known and of unknown objects, before and after calibration."""
    if result["not calibrated"]:
        return f"Not measured: {result['not calibrated']}."
    rows = []
    for each in result["acceptance"]:
        before, unknown = each["before"]["known"], each["before"]["unknown"]["proved"]
        right, wrong = before["proved and right"], before["proved and wrong"]
        first = [each["objects"], "proved", "", interval(right["share"]), counted(wrong), "", ""]
        rows.append([*first, "", "", counted(unknown)])
        for row in each["after"]:
            known, other = row["known"], row["unknown"]
            rows.append([
                each["objects"],
                f"coverage {percent(row['coverage'])} %",
                interval(known["covered"]["share"]),
                interval(known["recognised and right"]["share"]),
                counted(known["recognised and wrong"]),
                percent(known["ambiguous"]["share"][0]),
                percent(known["refused"]["share"][0]),
                interval(other["refused"]["share"]),
                percent(other["ambiguous"]["share"][0]),
                counted(other["recognised"]),
            ])  # fmt: skip
    heads = ("objects", "accepted if", "object among the accepted", "right", "wrong", "ambiguous", "refused",
             "unknown: refused", "unknown: ambiguous", "unknown: named")  # fmt: skip
    sizes = "; ".join(
        f"{each['objects']}: {each['known scenes']} scenes of known and {each['unknown scenes']} of unknown"
        f" objects, thresholds from {each['calibration scenes']} scenes or more, AUC of unknown against known"
        f" {area(each['auc of unknown against known']['share'])} by the least F\\*/‖o‖²,"
        f" {area(each['auc of unknown against known']['distance'])} by the nearest distance to the mean"
        for each in result["acceptance"]
    )
    return f"{_table(heads, rows)}\n\n{sizes}."


TABLES = {
    "Accuracy, %": accuracy_table,
    "The paper's rule minus each other one, percentage points": difference_table,
    "The margin: right against wrong labels": margin_table,
    "Acceptance, two views covered": acceptance_table,
}


def percent(share: float) -> str:
    """A share in percent, to one digit after the point where there is one."""
    return f"{100.0 * share:.1f}"


def interval(figure: Sequence[float | None]) -> str:
    """A share in percent with its interval, cut at what is possible."""
    mean, lower, upper = figure
    if mean is None or lower is None or upper is None:
        return "-" if mean is None else percent(mean)
    return f"{percent(mean)} [{percent(max(0.0, lower))}, {percent(min(1.0, upper))}]"


def signed(figure: Sequence[float | None]) -> str:
    """A difference in percentage points with its interval."""
    mean, *ends = (None if each is None else f"{100.0 * each:+.1f}" for each in figure)
    return f"{mean}" if None in ends else f"{mean} [{', '.join(map(str, ends))}]"


def area(figure: Sequence[float | None]) -> str:
    """An area under a ROC curve with its interval; a dash where only one kind occurs."""
    mean, *ends = (None if each is None else f"{each:.2f}" for each in figure)
    return "-" if mean is None else f"{mean} [{', '.join(map(str, ends))}]"


def counted(part: Mapping[str, Any]) -> str:
    """A number of scenes, and their share in percent."""
    return f"{part['scenes']} ({percent(part['share'][0])})"


def _by_condition(entries: Sequence[Mapping[str, Any]], heads: list[str], rows: Iterator[list[str]]) -> str:
    """One table, the conditions one after the other."""
    pairs = list(zip(entries, rows, strict=True))
    ordered = [[of, *row] for of in CONDITIONS for entry, row in pairs if entry["condition"] == of]
    return _table(["scenes of", *heads], ordered)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
