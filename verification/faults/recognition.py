"""Faults in the verdict on a label."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from convexperc.recognition import label as recognizing
from convexperc.recognition.recognition import Recognition, Verdict
from verification.faults.fault import Fault, Plant, replaced, wrapped


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


LABEL = (
    Fault("a proved label exchanged", "B4/label", decided(_swapped_label), also=("B4/tie", "B4/share")),
    Fault("the highest optimum for the lowest", "B4/label", decided(_highest), also=("B4/tie", "B4/share")),
    Fault(
        "identical templates told apart by their order",
        "B4/tie",
        decided(called(Verdict.TIE)),
        also=("R1/separated", "B4/label", "B4/share"),
    ),
    Fault(
        "the objective decides where the explained share was asked for",
        "B4/share",
        replaced(recognizing, "cost_bounds", lambda answers, decision: (answers.lower, answers.upper)),
    ),
    Fault("a tie without one of its candidates", "B4/tie", decided(_halved)),
    Fault("a lowest template called a tie", "R1/separated", decided(_called_tie)),
    Fault(
        "undecided called proved",
        "R1/separated",
        decided(called(Verdict.UNDECIDED)),
        also=("B4/tie", "B4/label", "B4/share"),
    ),
)
