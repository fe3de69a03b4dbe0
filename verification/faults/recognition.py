"""Faults in the verdict on a label."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from convexperc.enclosure.enclosure import enclose
from convexperc.recognition import label as recognizing
from convexperc.recognition import pruning
from convexperc.recognition.recognition import Recognition, Verdict
from verification.faults.fault import Fault, Plant, replaced, together, wrapped
from verification.faults.solvers import called_again


def decided(change: Callable[[Recognition], Recognition]) -> Plant:
    """Change the verdict of a recognition."""
    return wrapped(recognizing, "decide", lambda found, *a: change(found))


def called(kind: Verdict) -> Callable[[Any], Any]:
    """Verdicts of this kind called proved, for the first candidate."""

    def change(found: Any) -> Any:
        if found.verdict is not kind:
            return found
        return replace(found, verdict=Verdict.PROVED, label=found.candidates[0])

    return change


def _swapped_label(found: Any) -> Any:
    """Another name for a proved label."""
    others = [name for name in found.names if name != found.label]
    return replace(found, label=others[0]) if found.verdict is Verdict.PROVED and others else found


def _highest(found: Any) -> Any:
    """The template with the highest optimum for that with the lowest."""
    if found.verdict is not Verdict.PROVED:
        return found
    return replace(found, label=found.names[int(found.answers.upper.argmax())])


def _called_tie(found: Any) -> Any:
    """A tie where one template is proved to be the lowest."""
    return replace(found, verdict=Verdict.TIE, label=None) if found.verdict is Verdict.PROVED else found


def _halved(found: Any) -> Any:
    """A tie without its last candidate."""
    return replace(found, candidates=found.candidates[:-1]) if found.verdict is Verdict.TIE else found


def _of_the_start(found: Any, X: Any, references: Any, **given: Any) -> Any:
    """The label of the recognition that it was started from."""
    start = given.get("start")
    if start is None or start.label is None:
        return found
    return replace(found, verdict=start.verdict, label=start.label, candidates=start.candidates)


def _equal_excluded(bounds: Any, *arguments: Any) -> Any:
    """Lower bounds that equal the lowest upper one are raised above it, but for one template."""
    lower, upper = (np.array(part) for part in bounds)
    equal = np.flatnonzero(lower == upper.min())
    spared = [int(upper.argmin())]
    lower[np.setdiff1d(equal, spared)] = np.nextafter(upper.min(), np.inf)
    return lower, upper


def _nothing_doubtful(*arguments: Any) -> Any:
    """No template is left over."""
    return np.empty(0, dtype=np.int64)


def _narrowed_by_first_entry(found: Any, budget: Any) -> Any:
    """Rivals narrowed once for all that have the same first entry."""
    if found.verdict is not Verdict.UNDECIDED:
        return found
    lower, upper = found.answers.lower.copy(), found.answers.upper.copy()
    known: dict[float, tuple[float, float]] = {}
    for j in (~found.excluded).nonzero()[0].tolist():
        problem = found.answers.problem(j)
        if problem.o[0] not in known:
            tight = enclose(problem, relative_tolerance=1e-30, absolute_tolerance=1e-30)
            known[problem.o[0]] = tight.lower, tight.upper
        lower[j], upper[j] = known[problem.o[0]]
    answers = replace(found.answers, lower=lower, upper=upper)
    return recognizing.decide(answers, found.names, found.views, found.decision)


LABEL = (
    Fault(
        "the label of the frame before returned by a warm start",
        "B4/label",
        called_again(recognizing, "recognize", _of_the_start),
        may=("R1/separated", "B4/share", "B4/tie"),
    ),
    Fault(
        "a template excluded where its bound equals the best one",
        "B4/label",
        wrapped(recognizing, "cost_bounds", _equal_excluded),
        may=("R1/separated", "B4/share", "B4/tie"),
    ),
    Fault(
        "pruning gives up a template whose bound equals the best one",
        "R1/separated",
        together(replaced(pruning, "MARGIN", -0.5), replaced(pruning, "_doubtful", _nothing_doubtful)),
    ),
    Fault(
        "overlapping rivals with the interval of another with the same first entry",
        "B4/share",
        replaced(recognizing, "_narrowed", _narrowed_by_first_entry),
        may=("R1/separated", "B4/label", "B4/tie"),
    ),
    Fault("a proved label exchanged", "B4/label", decided(_swapped_label), also=("B4/tie", "B4/share")),
    Fault("the highest optimum for the lowest", "B4/label", decided(_highest), also=("B4/tie", "B4/share")),
    Fault(
        "identical templates told apart by their order",
        "B4/tie",
        decided(called(Verdict.TIE)),
        also=("R1/separated",),
        may=("B4/label", "B4/share"),
    ),
    Fault(
        "the objective decides where the explained share was asked for",
        "B4/share",
        replaced(recognizing, "cost_bounds", lambda answers, decision: (answers.lower, answers.upper)),
    ),
    Fault("a tie without one of its candidates", "B4/tie", decided(_halved), also=("B4/label",)),
    Fault("a lowest template called a tie", "R1/separated", decided(_called_tie)),
    Fault(
        "undecided called proved",
        "R1/separated",
        decided(called(Verdict.UNDECIDED)),
        also=("B4/tie",),
        may=("B4/label", "B4/share"),
    ),
)
