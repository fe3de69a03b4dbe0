"""Tables and facts for the terminal, with bounds rounded outwards and names escaped."""

import os
from collections.abc import Iterable, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Any, Literal

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from convexperc.errors import escaped
from convexperc.report.records import judgement_record

if TYPE_CHECKING:
    from convexperc.certificate.certificate import Certificate
    from convexperc.problem.arrays import Vector
    from convexperc.problem.optimality import OptimalityResidual
    from convexperc.problem.problem import Problem
    from convexperc.recognition.calibration import Calibration, Counts, Judgement
    from convexperc.recognition.each_view import EachView
    from convexperc.recognition.recognition import Ranked, Recognition, Template
    from convexperc.solution.solution import Solution

MOST_ROWS = 30
"""Rows of a table on the terminal, about a screenful; the JSON record has all."""
_WORDS = {"certified": "yes", "enclosed": "F* only", "not certified": "NO"}


def console() -> Console:
    """Return the console: names are printed verbatim; output that is no terminal has 160 columns."""
    out = Console(markup=False, highlight=False, emoji=False, soft_wrap=False)
    if not out.is_terminal and "COLUMNS" not in os.environ:
        out.width = 160
    return out


def show_recognition(
    out: Console,
    recognition: "Recognition",
    judgement: "Judgement | None" = None,
    each_view: "EachView | None" = None,
) -> None:
    """Print every object, the rankings for the best one, and the certificate of its answer."""
    best = recognition.template()
    solution = best.solution
    out.print(problem_line(solution.problem, None))
    _show_objects(out, recognition)
    _show_ranking(out, best.name, "robot", ">w", recognition.ranked_views())
    _show_ranking(out, best.name, "modality", ">||u^i||", recognition.ranked_modalities())
    facts = [
        ("label", labelled(recognition)),
        ("acceptance", accepted(None if judgement is None else judgement_record(judgement))),
        ("verdict", stated(recognition)),
        *(_margin(recognition) if recognition.label is not None else []),
        ("explained", f"{percents(recognition.explained)} of ||o||^2 by the views"),
        *_rules(recognition),
        *_each_view(each_view),
        *certificate_facts(solution.certificate),
        ("objects", _counted(recognition)),
        ("solver", solver_status(solution)),
        *(("warning", warning) for warning in recognition.warnings),
        (
            "scope",
            "the optima are bounded for these features and lambdas; whether the label is right is not proved",
        ),
    ]
    show_facts(out, f"Certificate for {best.name}", facts)


def labelled(found: "Recognition") -> str:
    """Return the label with the reference that it is by, or the candidates."""
    if found.label is None:
        return f"none; candidates: {', '.join(found.candidates)}"
    best = found.template().name
    return (
        found.label
        if best == found.label
        else f"{found.label}, by its reference {reference(best, found.label)}"
    )


def stated(found: "Recognition") -> str:
    """Return the verdict: what is proved, or why nothing is."""
    if found.label is not None:
        return f"{found.statement} of {len(found.objects)} objects"
    return f"{found.statement}: {found.reason}"


def accepted(judged: Mapping[str, Any] | None) -> str:
    """Return what a calibration says, from `judgement_record`, or that there is none."""
    if judged is None:
        return "not judged, for want of a calibration"
    names = f" ({', '.join(judged['accepted'])})" if judged["accepted"] else ""
    return f"{judged['verdict']}{names}: {judged['reason']}"


def margin_words(margin: tuple[float, float], decision: str, runner_up: str | None) -> str:
    """Return how far the next object lies behind, in what the objects are compared by."""
    what = "F*" if decision == "objective" else "F* / ||o||^2"
    return f"{percents(margin)} below the {what} of {runner_up}, the runner-up"


def reference(name: str, shown: str) -> str:
    """Return a reference's own name, without that of its object."""
    return name.removeprefix(f"{shown}/")


def show_calibration(out: Console, made: "Calibration", counts: "Counts | None") -> None:
    """Print the thresholds, and how labelled scenes fare."""
    facts = [
        (
            "coverage",
            f"{100 * made.coverage:g} % of scenes of known objects, drawn as these {made.scenes} "
            f"{made.origin.value} were",
        ),
        (
            "excess",
            _threshold(made.excess, "above the lowest cost is the most that an accepted one costs"),
        ),
        ("share", _threshold(made.share, "of ||o||^2 is the most that it leaves unexplained")),
    ]
    if counts is not None and counts.known:
        by = ", each judged by the others" if made.origin.value == "labelled scenes" else ""
        said = (
            f"of {counts.known} scenes{by}: in {counts.accepted} the true object is accepted; in "
            f"{counts.recognised} one object alone is, and in {counts.wrong} of these a wrong one"
        )
        facts.append(("known", said))
    if counts is not None and counts.unknown:
        claimed = f"in {counts.claimed} one object is accepted"
        of = f"of {counts.unknown} scenes of objects that are not known ({', '.join(counts.strangers)})"
        facts.append(("unknown", f"{of} {counts.refused} are refused; {claimed}"))
    show_facts(out, "Calibration", facts)


def _threshold(value: float, what: str) -> str:
    if value == float("inf"):
        return "none: too few scenes for this coverage, so that nothing is refused by it"
    return f"{100.0 * value:.4g} % {what}"


def _margin(recognition: "Recognition") -> list[tuple[str, str]]:
    """How far the next object lies behind."""
    if recognition.margin is None:
        return []
    return [("margin", margin_words(recognition.margin, recognition.decision.value, recognition.runner_up))]


def percents(ends: tuple[float, float]) -> str:
    """Return an interval of shares in per cent, rounded outwards."""
    lower, upper = below(100.0 * ends[0] * (1.0 - 2.0**-52), 4), above(100.0 * ends[1] * (1.0 + 2.0**-52), 4)
    return f"{lower} to {upper} %" if lower != upper else f"{lower} %"


def _rules(found: "Recognition") -> list[tuple[str, str]]:
    """What other rules say of the same views."""
    rules = found.rules
    votes = ", ".join(f"{name} {count}" for name, count in rules.votes.items())
    said = f"mean of the views: {rules.mean}; best view: {rules.best_view}; votes of the views: {votes}"
    facts = [("other rules", said)]
    if rules.disagreeing and found.label is not None:
        facts.append(
            ("disagreeing", f"nearest to another object than {rules.lowest}: {', '.join(rules.disagreeing)}")
        )
    return facts


def _each_view(found: "EachView | None") -> list[tuple[str, str]]:
    """What the optima of single views add up to."""
    if found is None:
        return []
    if found.label is None:
        return [("each view", f"undecided between {', '.join(found.candidates)}")]
    behind = "" if found.margin is None else f", {percents(found.margin)} below the next object"
    return [("each view", f"{found.label}; proved: lowest sum of the optima of single views{behind}")]


def _counted(recognition: "Recognition") -> str:
    """How many objects, and references of them, have a certified answer."""
    certified, templates = recognition.answers.certified, recognition.best_templates
    count = sum(bool(certified[template.index]) for template in templates)
    said = f"{count} of {len(templates)} have a certified answer"
    if len(recognition.names) > len(templates):
        said += f"; so have {int(certified.sum())} of their {len(recognition.names)} references"
    return said


def _show_objects(out: Console, recognition: "Recognition") -> None:
    left = recognition.unexplained[1]

    def row(template: "Template") -> tuple[str, ...]:
        verdict = "excluded"
        if template.object in recognition.candidates:
            verdict = "candidate" if recognition.label is None else "label"
        share = below(max(0.0, 1.0 - float(left[template.index]) - 2.0**-53), 6)
        lower, upper = template.interval
        return (
            template.name, share, below(lower), above(upper), _WORDS[template.status.value], verdict
        )  # fmt: skip

    rows = [row(template) for template in sorted(recognition.best_templates, key=lambda entry: entry.cost[1])]
    several = recognition.answers.data.library.several
    objects, title = ("reference", "Objects by their best references") if several else ("object", "Objects")
    columns = objects, ">explained", ">F* at least", ">F* at most", "certified", "verdict"
    order = "lowest optimum" if recognition.decision.value == "objective" else "largest explained fraction"
    _show_table(out, f"{title}, {order} first", columns, rows)


def show_blocks(
    out: Console,
    problem: "Problem",
    w: "Vector",
    u: "Vector",
    found: "Certificate",
    residual: "OptimalityResidual | None" = None,
) -> None:
    """Print every view and modality: its weight, its KKT residual if given, and whether it is proved zero."""
    views = [f"row {i}" for i in range(problem.n)], w, found.zero_views
    norms = problem.modalities.norms(u)
    modalities = problem.modalities.names, norms, found.zero_modalities
    errors = (None, None) if residual is None else (residual.views, residual.modalities)
    for title, weight, block, error in (
        ("view", ">w", views, errors[0]),
        ("modality", ">||u^i||", modalities, errors[1]),
    ):
        columns = [title, weight, *([] if error is None else [">KKT residual"]), "proved zero"]
        rows = []
        for i, (name, value, zero) in enumerate(zip(*block, strict=True)):
            measure = [] if error is None else [f"{error[i]:.3g}"]
            rows.append((name, _weight(value), *measure, "yes" if zero else ""))
        _show_table(out, "Views" if title == "view" else "Modalities", columns, rows)


def show_terms(out: Console, found: "Certificate") -> None:
    """Print the contribution of each term to the gap, if the certificate has it."""
    if found.terms is None:
        return
    names = "loss", "coupling", "view_norm", "modality_norm"
    rows = [(name.replace("_", " "), above(getattr(found.terms, name), 3)) for name in names]
    _show_table(out, "Gap by term, in units where ||o|| is about 1", ("term", ">at most"), rows)


def show_facts(out: Console, title: str, facts: Iterable[tuple[str, str]]) -> None:
    """Print named facts, one below the other; a long one is wrapped."""
    grid = Table.grid(padding=(0, 2))
    grid.add_column(no_wrap=True)
    grid.add_column(overflow="fold")
    for name, fact in facts:
        grid.add_row(f"  {name}", escaped(fact))
    out.print(Text(escaped(title), style="bold"))
    out.print(grid)


def problem_line(problem: "Problem", name: str | None) -> str:
    """Return a one-line summary of a problem: sizes and lambdas."""
    parts = zip(problem.modalities.names, problem.modalities.sizes, strict=True)
    sizes = ", ".join(f"{part} {size}" for part, size in parts)
    lambdas = ", ".join(f"lambda{i} = {value:g}" for i, value in enumerate(problem.lambdas, 1))
    head = "" if name is None else f"{name}: "
    return escaped(f"{head}n = {problem.n} views, d = {problem.d} features ({sizes}), {lambdas}")


def certificate_facts(found: "Certificate") -> list[tuple[str, str]]:
    """Return what a certificate proves, as named facts."""
    word = "certified" if found.certified else "NOT CERTIFIED"
    relative, absolute = found.relative_tolerance, found.absolute_tolerance
    return [
        ("optimum", f"{below(found.lower)} <= F* <= {above(found.upper)}"),
        ("answer", f"{below(found.objective[0])} <= F(w, u) <= {above(found.objective[1])}"),
        ("gap", f"F(w, u) - F* <= {above(found.gap, 3)}, that is {above(found.relative_gap, 3)} of F*"),
        ("method", found.method),
        ("status", f"{word} (at most {relative:g} of F*, or {absolute:g} of ||o||^2)"),
    ]


def solver_status(solution: "Solution") -> str:
    """Return the solver's name and status, which the certificate does not use, and why no more is proved."""
    said = f"{solution.solver}; solver status (not used): {solution.solver_status}"
    return f"{said}; {solution.reason}" if solution.reason else said


def claim(proof: Mapping[str, Any]) -> str:
    """Return what a proof file claims."""
    lower, upper = (float.fromhex(proof["claim"][end]) for end in ("lower", "upper"))
    return f"{below(lower)} <= F* <= {above(upper)}"


def below(value: float, digits: int = 12) -> str:
    """Format a lower bound, rounded down to `digits` significant digits."""
    return f"{Context(prec=digits, rounding=ROUND_FLOOR).create_decimal_from_float(value):g}"


def above(value: float, digits: int = 12) -> str:
    """Format an upper bound, rounded up to `digits` significant digits."""
    return f"{Context(prec=digits, rounding=ROUND_CEILING).create_decimal_from_float(value):g}"


def _show_ranking(out: Console, best: str, what: str, weight: str, ranking: "Iterable[Ranked]") -> None:
    rows = []
    for i, entry in enumerate(ranking, 1):
        zero = "yes" if entry.proved_zero else ""
        rows.append((str(i), entry.name, _weight(entry.weight), f"{100 * entry.share:.1f} %", zero))
    _show_table(out, f"Ranking by {what} for {best}", (">rank", what, weight, ">share", "proved zero"), rows)


def _show_table(out: Console, title: str, columns: Sequence[str], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a table. Columns that start with ``>`` hold numbers; the first other one, of names, may wrap."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    names = next(column for column in columns if not column.startswith(">"))
    for column in columns:
        side: Literal["left", "right"] = "right" if column.startswith(">") else "left"
        table.add_column(column.removeprefix(">"), justify=side, no_wrap=column != names, overflow="fold")
    for row in rows[:MOST_ROWS]:
        table.add_row(*map(escaped, row))
    out.print(Text(escaped(title), style="bold"))
    out.print(table)
    if len(rows) > MOST_ROWS:
        out.print(f"... and {len(rows) - MOST_ROWS} more; --json has them all")
    out.print()


def _weight(value: float) -> str:
    return f"{value:.6f}" if value == 0.0 or 1e-6 <= abs(value) < 1e6 else f"{value:.3g}"
