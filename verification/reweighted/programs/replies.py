"""One call of a program under judgement: its answer as float64 numbers, or why there is none."""

import inspect
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import escaped
from verification.reweighted.objectives.objective import Objective
from verification.reweighted.programs.questions import Data

REFUSALS: tuple[type[Exception], ...] = (ValueError, NotImplementedError)
"""Exceptions by which a program says that an input is not for it; numpy.linalg.LinAlgError is one."""

KEPT = 5
"""Warnings of one call that are kept."""


class Kind(StrEnum):
    """What came of a call."""

    ANSWER = "an answer"
    REFUSED = "no answer: the program refused"
    RAISED = "no answer: an exception"
    NOT_FINITE = "an answer that is not finite"
    NO_POINT = "an answer that is no point"
    NOT_ASKED = "no answer on record: the program was not asked"


class NotAskedError(Exception):
    """A program elsewhere has not answered this input: nothing is known of what it would say."""


@dataclass(frozen=True)
class Reply:
    """What came of a call.

    Attributes
    ----------
    kind : Kind
    values : mapping of str to float64 arrays
        Entries of each variable, row by row; empty where there are none of the right number.
    text : str
        Of the exception, or what was wrong.
    warned : tuple of str
        Warnings, each with its class.
    told : bool
        Whether a warning is one that a program gives on purpose: a UserWarning, as the ConvergenceWarning of
        most packages is, and no RuntimeWarning, which NumPy gives.
    """

    kind: Kind
    values: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    text: str = ""
    warned: tuple[str, ...] = ()
    told: bool = False


def ask(
    program: Callable[..., Any],
    data: Data,
    objective: Objective,
    *,
    twice: bool = False,
    refusals: tuple[type[Exception], ...] = REFUSALS,
) -> Reply:
    """Call a program with copies of the data, and read what it returns.

    Parameters
    ----------
    program : function
        Of the data by name; returns a number or an array, if the objective has one variable, or a mapping of
        the names of the variables.
    data : mapping of str to Any
    objective : Objective
        Says how many entries each variable has.
    twice : bool
        Call it once more with the same copies, and read that answer.
    refusals : tuple of exception classes
    """
    own = {name: np.array(value) if isinstance(value, np.ndarray) else value for name, value in data.items()}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = program(**own)
            if twice:
                found = program(**own)
            values = _values(found, objective)
        except NotAskedError as fault:
            kind, values, text = Kind.NOT_ASKED, {}, str(fault)
        except refusals as fault:
            kind, values, text = Kind.REFUSED, {}, _shown(fault)
        except (Exception, SystemExit, GeneratorExit) as fault:  # whatever it raises is what came of it
            kind, values, text = Kind.RAISED, {}, _shown(fault)
        else:
            kind, text = Kind.ANSWER, ""
    if kind is Kind.ANSWER and not values:
        kind, text = Kind.NO_POINT, _described(found, objective)
    elif kind is Kind.ANSWER and not all(np.isfinite(entries).all() for entries in values.values()):
        kind = Kind.NOT_FINITE
    told = any(issubclass(each.category, UserWarning) for each in caught)
    shown = dict.fromkeys(f"{each.category.__name__}: {escaped(str(each.message))[:200]}" for each in caught)
    return Reply(kind, values, text, tuple(shown)[:KEPT], told)


def _shown(fault: BaseException) -> str:
    return f"{type(fault).__name__}: {escaped(_text(fault, str))[:200]}"


def _text(value: Any, how: Callable[[Any], str]) -> str:
    """What an object says of itself; a fault of its own is told in place of it."""
    try:
        return how(value)
    except Exception as fault:
        return f"({type(fault).__name__} in {how.__name__})"


def _values(found: Any, objective: Objective) -> dict[str, NDArray[np.float64]]:
    """The answer by variable; empty where names or sizes are others, or entries are missing."""
    if not isinstance(found, Mapping):
        if len(objective.sizes) != 1:
            return {}
        found = dict.fromkeys(objective.sizes, found)
    values = {}
    for name, size in objective.sizes.items():
        try:
            entries = _entries(found[name])
        except (KeyError, TypeError, ValueError, OverflowError):
            return {}
        if entries.size != size:
            return {}
        values[name] = entries
    return values


def _entries(found: Any) -> NDArray[np.float64]:
    """Numbers row by row; none where an entry is masked or None, which NumPy takes for a number or NaN."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy's about a masked entry of a list is not the program's
        masked = np.ma.asarray(found)
    given = np.asarray(masked)
    missing = np.ma.is_masked(masked) or (given.dtype.kind == "O" and None in given.ravel().tolist())
    return np.empty(0) if missing or given.dtype.kind not in "fiuO" else given.astype(np.float64).ravel()


def _described(found: Any, objective: Objective) -> str:
    wanted = ", ".join(f"{name} with {size} numbers" for name, size in objective.sizes.items())
    return f"The answer must hold {wanted}; it is {escaped(_text(found, repr))[:120]}."


def accepted(build: Callable[..., Objective], data: Data) -> Data:
    """The data that a function takes by name: an objective does not depend on a start."""
    parameters = inspect.signature(build).parameters.values()
    if any(each.kind is inspect.Parameter.VAR_KEYWORD for each in parameters):
        return data
    names = {each.name for each in parameters}
    return {name: value for name, value in data.items() if name in names}
