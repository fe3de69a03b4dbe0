"""Commands about reweighted loops; no mathematics."""

import importlib.util
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table as Grid

from convexperc.errors import InputError
from convexperc.files import write_atomic, write_json
from verification.commands.console import console, say
from verification.commands.misuse import FAILED, check_places, misuse

if TYPE_CHECKING:
    from verification.reweighted.answers import Answers
    from verification.reweighted.gallery.records import Record

LOOPS_HELP = (
    "Judge a reweighted loop against its own objective: a case of the gallery, or one in a Python file.\n\n"
    "The file has `build`, a function that returns a Loop, and `data`, the Hypothesis strategies of its"
    " arguments; docs/reweighted.md begins with one. Without an argument, list the gallery.\n\n"
    "Exit code 0: nothing speaks against the loop; 1: something does; 2: misuse."
)


def loops(
    name: Annotated[
        str, typer.Argument(metavar="[ID|FILE]", help="A case, a stored instance, or a file.")
    ] = "",
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the answers to this file.", dir_okay=False)
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Of a stored instance: draw F by iteration.", dir_okay=False)
    ] = None,
    store: Annotated[
        Path | None, typer.Option(help="Judge the whole gallery, and write it to this file.", dir_okay=False)
    ] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write what is stored of the gallery as a page.", dir_okay=False)
    ] = None,
) -> None:
    """Run the command ``loops``."""
    from verification.reweighted.gallery.records import stored_records  # noqa: PLC0415 - keeps --help quick

    check_places(
        {"ID": Path(name) if name.endswith(".py") else None},
        json=json_file,
        plot=plot,
        store=store,
        page=page,
    )
    records = stored_records()
    if store is not None:
        _store(store)
    elif page is not None:
        _write_page(page)
    elif not name:
        _list()
    elif name in records:
        _replay(records[name], plot)
    else:
        _judge(name, json_file)


def _judge(name: str, place: Path | None) -> None:
    from verification.reweighted.gallery.records import judged  # noqa: PLC0415
    from verification.reweighted.loops.judging import judge_loop  # noqa: PLC0415

    with misuse("ID|FILE"):
        if name.endswith(".py"):
            build, data = _stated(Path(name))
            answers = judge_loop(build, name=Path(name).stem, **data)
        else:
            answers = judged(name)[0]
    _show(answers)
    if place is not None:
        with misuse("--json"):
            write_json(place, answers.as_json())
    raise typer.Exit(FAILED if answers.faults else 0)


def _show(answers: "Answers") -> None:
    say(answers.subject)
    grid = Grid("question", "answer", "what was found", "rests on", show_lines=True)
    for answer in answers:
        given = "\n".join(f"{key}: {value}" for key, value in answer.instance.items())
        grid.add_row(answer.question, answer.word.value, f"{answer.statement}\n{given}".strip(), answer.basis)
    console().print(grid)


def _stated(file: Path) -> tuple[Callable[..., Any], Mapping[str, Any]]:
    """`build` and `data` of a Python file, which is run."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    if spec is None or spec.loader is None or not file.is_file():
        raise InputError("FILE", value=str(file), must="must be a Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as fault:
        must = "must be a Python file that can be run"
        raise InputError(str(file), value=f"{type(fault).__name__}: {fault}", must=must) from fault
    build, data = getattr(module, "build", None), getattr(module, "data", None)
    if not callable(build) or not isinstance(data, Mapping) or not all(map(_is_strategy, data.values())):
        must = "must have a function `build`, and a mapping `data` of Hypothesis strategies"
        raise InputError("FILE", value=str(file), must=must)
    return build, data


def _is_strategy(value: object) -> bool:
    from hypothesis.strategies import SearchStrategy  # noqa: PLC0415

    return isinstance(value, SearchStrategy)


def _list() -> None:
    from verification.reweighted.gallery import CASES  # noqa: PLC0415
    from verification.reweighted.gallery.records import stored_records  # noqa: PLC0415

    found = stored_records()
    grid = Grid("case", "what it is", "source", "stored instances")
    for case in CASES.values():
        ids = [record.id for record in found.values() if record.case == case.id]
        grid.add_row(case.id, case.title, case.source, "\n".join(ids))
    console().print(grid)


def _replay(record: "Record", plot: Path | None) -> None:
    from convexperc.report import picture_kind  # noqa: PLC0415

    say(record.statement)
    grid = Grid("iteration", "point", "F")
    for row in record.table():
        grid.add_row(*row)
    console().print(grid)
    if plot is not None:
        with misuse("--plot"):
            write_atomic(plot, record.plot(picture_kind(plot)))
    confirmed = record.is_confirmed
    say("confirmed again" if confirmed else "no longer confirmed: the record is stale")
    raise typer.Exit(0 if confirmed else FAILED)


def _write_page(place: Path) -> None:
    from verification.reweighted.gallery.page import markdown  # noqa: PLC0415
    from verification.reweighted.gallery.records import stored  # noqa: PLC0415

    with misuse("--page"):
        write_atomic(place, markdown(stored()).encode())


def _store(place: Path) -> None:
    from verification.reweighted.gallery import CASES  # noqa: PLC0415
    from verification.reweighted.gallery.records import gallery_record, judged  # noqa: PLC0415

    found = {}
    for case in CASES:
        found[case] = judged(case)
        faults = ", ".join(answer.question for answer in found[case][0].faults) or "none"
        say(f"{case}: against it: {faults}")
    with misuse("--store"):
        write_json(place, gallery_record(found))


PACKAGES_HELP = (
    "Judge reweighted programs of installed packages against their objectives.\n\n"
    "A package that is not installed is left out. Exit code 0, whatever is found: it is not this project's."
)


def packages(
    out: Annotated[
        Path | None,
        typer.Option(help="Write reweighted.md and reweighted.json to this folder.", file_okay=False),
    ] = None,
) -> None:
    """Run the command ``packages``."""
    from verification.reweighted.programs.page import markdown, packages_record  # noqa: PLC0415

    places = {} if out is None else {"page": out / "reweighted.md", "record": out / "reweighted.json"}
    for place in places.values():
        with misuse("--out"):
            place.parent.mkdir(parents=True, exist_ok=True)
    check_places(out=places.get("page"))
    record = packages_record(say)
    page = markdown(record)
    if out is None:
        say(page)
        return
    with misuse("--out"):
        write_json(places["record"], record)
        write_atomic(places["page"], page.encode())
