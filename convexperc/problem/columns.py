"""Templates as the caller gives them: read as the columns of O, with their names and what they show."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from convexperc.errors import InputError, ProblemError, TemplateNameError
from convexperc.problem.arrays import FeatureVector, real_array
from convexperc.problem.conversion import held_exactly


class Columns(NamedTuple):
    """The columns of O.

    Attributes
    ----------
    O : array of real numbers (d, p)
        Read-only where it was made here.
    names : tuple of p str, or None
        One a column, all different, if they were given.
    objects : tuple of p str, or None
        The object that each column shows; None where each shows another one, and has its name.
    """

    O: Any  # noqa: E741 - the paper's symbol
    names: tuple[str, ...] | None
    objects: tuple[str, ...] | None

    @classmethod
    def of(
        cls,
        templates: Any,
        names: Sequence[str] | None = None,
        objects: Sequence[str] | None = None,
        d: int | None = None,
    ) -> "Columns":
        """Read what `TemplateLibrary` takes, with d features if that is known.

        Raises
        ------
        ProblemError, TemplateNameError
            See `TemplateLibrary`.
        """
        if isinstance(templates, Mapping):
            if not templates:
                raise ProblemError("references", value=templates, must="must name at least one object")
            checked_names(tuple(templates), len(templates), TemplateNameError, "references", "objects")
            return _of_mapping(templates, names, objects, d)
        O = _as_columns(templates)  # noqa: E741
        if d is not None and O.shape[0] != d:
            must = f"must have {d} rows, as X has columns"
            raise ProblemError("O", value=O.shape, must=must, remedy="Each column of O is one template.")
        given = None
        if names is not None:
            given = checked_names(names, O.shape[1], TemplateNameError, "names", "templates")
        if objects is None:
            return cls(O, given, None)
        shown = _checked_objects(objects, O.shape[1])
        return cls(O, _reference_names(shown) if given is None else given, shown)


def checked_names(
    names: Any, count: int, error: type[InputError], argument: str, named: str
) -> tuple[str, ...]:
    """As many names as there are things to be named: strings, not empty, all different.

    Raises
    ------
    InputError
        Of the class given.
    """
    given = strings(names)
    if given is None or len(given) != count or len(set(given)) != count:
        must = f"must name each of the {count} {named} once, by strings that are not empty"
        raise error(argument, value=names, must=must)
    return given


def _checked_objects(objects: Any, count: int) -> tuple[str, ...]:
    given = strings(objects)
    if given is None or len(given) != count:
        must = f"must name the object that each of the {count} templates shows, by strings that are not empty"
        raise TemplateNameError("objects", value=objects, must=must)
    return given


def strings(names: Any) -> tuple[str, ...] | None:
    """The names, if all are strings that are not empty."""
    try:
        given = () if isinstance(names, str) else tuple(names)
    except TypeError:
        return None
    return given if all(isinstance(name, str) and name for name in given) else None


def _reference_names(shown: tuple[str, ...]) -> tuple[str, ...]:
    """The object's name where it has one reference; with the number of the reference where it has several."""
    many, seen, names = Counter(shown), Counter[str](), list[str]()
    for name in shown:
        seen[name] += 1
        names.append(name if many[name] == 1 else f"{name}/{seen[name]}")
    return _all_different(names)


def _all_different(names: list[str]) -> tuple[str, ...]:
    if len(set(names)) < len(names):
        twice = Counter(names).most_common(1)[0][0]
        must = "must differ from all others; a reference is named OBJECT/REFERENCE"
        raise TemplateNameError("a template's name", value=twice, must=must, remedy="Rename the object.")
    return tuple(names)


def _as_columns(templates: Any) -> Any:
    """O as an array of real numbers with a column for each template, copied only if it is no such array."""
    found = templates
    plain = isinstance(found, np.ndarray) and not isinstance(found, np.ma.MaskedArray)
    if not (plain and held_exactly(found.dtype) and found.ndim == 2):
        found = real_array(templates, "O", 2)
    if 0 in found.shape:
        must = "must have at least one row and at least one column"
        raise ProblemError("O", value=found.shape, must=must, remedy="Each column of O is one template.")
    return found


def _of_mapping(
    templates: Mapping[str, Any], names: Sequence[str] | None, objects: Sequence[str] | None, d: int | None
) -> Columns:
    """Each reference of a mapping as a column, read-only."""
    if names is not None and strings(names) != tuple(templates):
        must = "must be left out where the templates are a mapping, or be its keys"
        raise TemplateNameError("names", value=names, must=must)
    if objects is not None:
        must = "must be left out where the templates are a mapping: its keys are the objects"
        raise TemplateNameError("objects", value=objects, must=must)
    rows, found, shown = list[FeatureVector](), list[str](), list[str]()
    for name, value in templates.items():
        for reference, row in _references(name, value):
            rows.append(row)
            found.append(reference)
            shown.append(name)
    _check_sizes(found, rows, d)
    columns = np.stack(rows).T
    columns.flags.writeable = False
    return Columns(columns, _all_different(found), None if found == shown else tuple(shown))


def _references(name: str, value: Any) -> list[tuple[str, FeatureVector]]:
    """The references of one object, by name."""
    if isinstance(value, Mapping):
        if not value:
            raise ProblemError(f"reference {name!r}", value=value, must="must hold at least one reference")
        argument = f"references of {name!r}"
        own = checked_names(tuple(value), len(value), TemplateNameError, argument, "references")
        parts = ((f"{name}/{each}", value[each]) for each in own)
        return [(each, real_array(row, f"reference {each!r}", 1)) for each, row in parts]
    try:
        several = np.ndim(value) == 2
    except (ValueError, UserWarning):  # rows of different lengths; a masked entry, if warnings are errors
        several = True
    if not several:
        return [(name, real_array(value, f"reference {name!r}", 1))]
    rows = real_array(value, f"references of {name!r}", 2)
    if rows.shape[0] == 0:
        must = "must hold at least one reference, one a row"
        raise ProblemError(f"references of {name!r}", value=rows.shape, must=must)
    if rows.shape[0] == 1:
        return [(name, rows[0])]
    return [(f"{name}/{i}", row) for i, row in enumerate(rows, 1)]


def _check_sizes(names: list[str], rows: list[FeatureVector], d: int | None) -> None:
    """All rows have as many entries as X has columns, or as the first."""
    must = f"must have the {rows[0].size} entries that reference {names[0]!r} has"
    if d is not None:
        must = f"must have one entry for each of the {d} columns of X"
    for name, row in zip(names, rows, strict=True):
        if row.size != (rows[0].size if d is None else d):
            raise ProblemError(f"reference {name!r}", value=row.shape, must=must)
