"""The exceptions: each states what is wrong, its value, the condition violated, and a remedy."""

import functools
import importlib.util
import operator
import re
import warnings
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

T = TypeVar("T")

_UNSAFE = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""What breaks, moves or reorders printed text, or cannot be encoded: control characters, ends of lines,
directional embeddings, overrides and isolates, and the surrogates that stand for bytes that are no UTF-8."""


def escaped(text: str) -> str:
    r"""Return one line that is safe to print: a name in it cannot forge another line, or reorder its own.

    What cannot be printed safely stands as in a Python string, ``\n`` or ``\u202e``; everything else, such as
    the spaces of other scripts or emoji of several code points, stands as it is.
    """
    return _UNSAFE.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


class ConvexpercError(Exception):
    """Base class of the exceptions of this package.

    Parameters
    ----------
    what : str
        The name of what is wrong, for example ``"lambda2"`` or a file's name.
    value : object
        The offending value, kept as an attribute and shown (shortened) in the message.
    must : str
        The condition that is violated, for example ``"must be a finite number >= 0"``.
    remedy : str
        What the user can do, as a sentence; may be empty.
    """

    def __init__(self, what: str, *, value: Any, must: str, remedy: str = "") -> None:
        self.what = what
        self.value = value
        self.must = must
        self.remedy = remedy
        message = f"{what} {must}; got {_shown(value)}."
        super().__init__(escaped(f"{message} {remedy}" if remedy else message))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the named parts, so that an error can be raised across processes."""
        import pickle  # noqa: PLC0415 - rarely needed, and not at once

        value = self.value
        try:
            pickle.dumps(value)
        except Exception:  # objects that cannot be pickled raise anything: keep their repr
            value = _shown(value)
        return _rebuild, (type(self), self.what, value, self.must, self.remedy)


def _shown(value: Any) -> str:
    """Return a value's repr in at most 120 characters, even if the repr raises."""
    try:
        shown = repr(value)
    except Exception:  # an integer of over 4,300 digits raises, and so may any foreign object
        shown = f"a value of type {type(value).__name__} that has no short form"
    return f"{shown[:80]} ... {shown[-30:]}" if len(shown) > 120 else shown


def _rebuild(kind: type[ConvexpercError], what: str, value: Any, must: str, remedy: str) -> ConvexpercError:
    return kind(what, value=value, must=must, remedy=remedy)


class InputError(ConvexpercError, ValueError):
    """An argument from the caller cannot be used."""


class ProblemError(InputError):
    """X, o or a lambda does not describe a valid problem."""


class ModalityError(InputError):
    """The modalities are not a partition of the columns of X."""


class PointError(InputError):
    """A pair (w, u) does not fit the problem that it is evaluated on."""


class ToleranceError(InputError):
    """A tolerance is not a finite number >= 0."""


class PrecisionError(InputError):
    """A number of bits cannot be used."""


class BudgetError(InputError):
    """A budget is not a number of seconds > 0."""


class CalibrationError(InputError):
    """A calibration cannot be made of these scenes, does not fit the recognition, or is not one."""


class DecisionError(InputError):
    """There is no decision rule of that name."""


class TemplateNameError(InputError):
    """The names of the templates do not fit, or there is no template of that name."""


class RobotNameError(InputError):
    """The names of the robots do not fit the rows of X."""


class StartError(InputError):
    """Earlier answers do not fit the views and templates for which they are the start."""


class ImageError(InputError):
    """A picture cannot be read, or its size is out of range."""


class SourceError(InputError):
    """A source of pictures cannot be opened, breaks off, or does not go with the others."""


class FeatureError(InputError):
    """A feature configuration, or a feature vector, cannot be used."""


class FileFormatError(InputError):
    """A problem, answer or configuration file does not follow its schema."""


class SolverError(ConvexpercError, RuntimeError):
    """A solver raised, or does not support this kind of problem."""


class MissingExtraError(ConvexpercError, ImportError):
    """An optional package is needed; the remedy names the extra to install."""


class SlowWarning(UserWarning):
    """Something keeps this from being much faster; the message says what to do."""


class PictureWarning(UserWarning):
    """A picture, or a part of its file, is read otherwise than it may have been meant."""


@functools.cache
def warn_once(text: str) -> None:
    """Say once in a process what makes it slow."""
    warnings.warn(text, SlowWarning, stacklevel=2)


def installed(module: str) -> bool:
    """Whether a top-level package can be found; it is not imported."""
    return importlib.util.find_spec(module) is not None


def check_type(
    value: object, kind: type | tuple[type, ...], what: str, error: type[InputError] = InputError
) -> None:
    """Check an argument's type, where another one would end in an error of Python's own, or in none.

    Raises
    ------
    InputError
        Of the class given: it is no instance of the type, or of any of them.
    """
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        names = " or ".join("None" if each is type(None) else each.__name__ for each in kinds)
        raise error(what, value=value, must=f"must be of the type {names}")


def is_integer(value: object) -> bool:
    """Whether a value is an integer of Python or of NumPy, and no boolean."""
    if isinstance(value, (bool, type)) or hasattr(value, "__len__"):  # an array of one integer has an index
        return False
    try:
        operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return False
    return True


def is_one_of(value: object, names: Iterable[str]) -> bool:
    """Whether a value is one of these strings; an array, which compares by its entries, is none."""
    return isinstance(value, str) and value in names


def entries(values: Iterable[T], what: str, error: type[InputError] = InputError) -> Iterator[T]:
    """Iterate over an argument.

    Raises
    ------
    InputError
        Of the class given: it cannot be iterated over.
    """
    try:
        return iter(values)
    except TypeError:
        raise error(what, value=values, must="must be iterable, for example a list") from None


def require(module: str, extra: str, what: str) -> None:
    """Raise if an optional package is not installed; call it before any work is done.

    The package is located but not imported, so that a broken installation raises its own error later.

    Parameters
    ----------
    module : str
        Top-level name under which the package is imported.
    extra : str
        The extra that contains it, or several, separated by commas.
    what : str
        What needs it, for example ``"the picture"``.

    Raises
    ------
    MissingExtraError
        The package is not installed.
    """
    if not installed(module):
        missing = ModuleNotFoundError(f"No module named {module!r}", name=module)
        remedy = f"Install it: pip install 'convexperc[{extra}]'."
        raise MissingExtraError(what, value=missing, must=f"needs {module}", remedy=remedy)
