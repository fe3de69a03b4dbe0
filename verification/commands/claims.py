"""Commands about claims: list, run, report, report diff; no mathematics."""

import json
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table
from rich.text import Text

from convexperc.files import check_apart, check_place, json_bytes, write_json
from verification.commands.console import console, say
from verification.commands.misuse import FAILED, OPEN, misuse
from verification.commands.progress import progress
from verification.commands.stored import attach, figures, read_stored

if TYPE_CHECKING:
    from verification.experiments.record.reading import Experiments
    from verification.ledger.baseline import Judged
    from verification.run.stages import Options, Run


Profiles = Annotated[str, typer.Option("--profile", help="How much is tried: quick, ci or full.")]
Seed = Annotated[int, typer.Option(min=0, help="Two runs of one seed find the same.")]
Jobs = Annotated[int, typer.Option(min=1, help="Worker processes; the outcome does not depend on it.")]
Chosen = Annotated[
    list[str] | None, typer.Option("--claim", help="Only this claim; may be given several times.")
]
Stored = Annotated[
    Path | None,
    typer.Option(
        "--experiments",
        help="Record that X1 to X8 are judged by, instead of the one that comes with the verifier.",
        dir_okay=False,
    ),
]
WRITTEN = (
    "report.html",
    "report.md",
    "report.json",
    "junit.xml",
    "SHA256SUMS",
    "experiments/experiments.html",
)
"""Files of a report, besides the folder of its counterexamples."""
Out = Annotated[Path, typer.Option(file_okay=False, help="Folder for everything that is written.")]


LISTED_HELP = """List the claims, their places and their parts."""


def listed() -> None:
    """Run the command ``list``."""
    from verification.ledger.claims import CLAIMS  # noqa: PLC0415 - keeps --help quick

    table = Table("id", "place", "claim", "parts", title="Claims; 'run --claim ID' judges one")
    for claim in CLAIMS.values():
        names = ", ".join(part.key.split("/", 1)[1] for part in claim.parts[:4])
        more = f" and {len(claim.parts) - 4} more" if len(claim.parts) > 4 else ""
        table.add_row(claim.id, claim.place, claim.statement, names + more)
    console().print(table)


RUN_HELP = (
    "Judge the claims and print the verdicts; the evidence is kept, no report is written.\n\n"
    "Exit code 0: every verdict is the baseline's; 1: a verdict changed, a promise of the library "
    "failed, or a record is stale; 2: misuse; 3: something required was left open."
)


def run(
    claim: Chosen = None,
    profile: Profiles = "quick",
    seed: Seed = 0,
    jobs: Jobs = 2,
    out: Out = Path("reports"),
    experiments: Stored = None,
) -> None:
    """Run the command ``run``."""
    options = _options(claim, profile, seed, jobs)
    check_apart(_kept(options, out), inputs={"--experiments": experiments})
    with misuse("--experiments"):
        stored = read_stored(experiments)
    found = _gather(options, out)
    attach(found.evidence, stored, experiments)
    judged = _judged(found)
    for table in figures(found.evidence):
        console().print(table)
    raise typer.Exit(judged.assessment.code)


REPORT_HELP = (
    "Judge the claims and write the report: report.html, .md, .json, junit.xml, counterexamples, "
    "SHA256SUMS.\n\n"
    "The same seed and versions give the same bytes, but for one block of times and names of this "
    "machine. With --claim the report is about these claims alone. The claims about the experiments, X1 "
    "to X8, are judged by a record that `experiments` has written, and not by this run. Exit codes as "
    "for `run`. A run that is broken off goes on where it was when it is started again."
)


def report(
    context: typer.Context,
    claim: Chosen = None,
    profile: Profiles = "quick",
    seed: Seed = 0,
    jobs: Jobs = 2,
    out: Out = Path("reports"),
    experiments: Stored = None,
    evidence: Annotated[
        Path | None,
        typer.Option(
            help="Render what a run has kept, OUT/.journal/*.evidence.json, instead of a new run;"
            " its options apply.",
            dir_okay=False,
        ),
    ] = None,
) -> None:
    """Run the command ``report``."""
    if context.invoked_subcommand is not None:
        return
    if evidence is not None and claim:
        raise typer.BadParameter("cannot be combined with --evidence", param_hint="--claim")

    kept = {} if evidence else _kept(_options(claim, profile, seed, jobs), out)
    files = kept | {f"{name} of --out": out / name for name in WRITTEN}
    read = {"--experiments": experiments, "--evidence": evidence}
    check_apart(files, folders={"counterexamples of --out": out / "counterexamples"}, inputs=read)
    with misuse("--experiments"):
        stored = read_stored(experiments)
    found = _read(evidence) if evidence else _gather(_options(claim, profile, seed, jobs), out)
    attach(found.evidence, stored, experiments)
    judged = _judged(found)
    with misuse("--evidence") if evidence is not None else nullcontext():
        content = _content(found, judged, stored)
    with misuse("--out"):
        _store(content, out)
    raise typer.Exit(judged.assessment.code)


DIFF_HELP = """Compare two reports; exit code 0 if all verdicts are equal, 1 if not."""


def diff(
    a: Annotated[Path, typer.Argument(metavar="A", help="A report.json.", dir_okay=False)],
    b: Annotated[Path, typer.Argument(metavar="B", help="Another one.", dir_okay=False)],
) -> None:
    """Run the command ``report diff``."""
    from verification.report.diff import diff as compared  # noqa: PLC0415 - keeps --help quick
    from verification.report.diff import read_report  # noqa: PLC0415

    with misuse("A and B"):
        found = compared(read_report(a), read_report(b))
    for line in found.text.split("\n"):
        say(line)
    raise typer.Exit(found.code)


def _options(claim: list[str] | None, profile: str, seed: int, jobs: int) -> "Options":
    from verification.ledger.claims import CLAIMS  # noqa: PLC0415 - keeps --help quick
    from verification.run.stages import Options  # noqa: PLC0415
    from verification.search.profiles import PROFILES  # noqa: PLC0415

    if profile not in PROFILES:
        raise typer.BadParameter(f"must be one of {', '.join(PROFILES)}", param_hint="--profile")
    for each in claim or ():
        if each not in CLAIMS:
            raise typer.BadParameter(
                f"no claim {each!r}; the ledger has {', '.join(CLAIMS)}", param_hint="--claim"
            )
    return Options(PROFILES[profile], seed, jobs, tuple(each for each in CLAIMS if each in (claim or ())))


def _gather(options: "Options", out: Path) -> "Run":
    """Run and show the progress; keep the evidence, even of a run that was broken off."""
    from verification.run.stages import gather  # noqa: PLC0415

    kept, journal = _kept(options, out).values()
    with misuse("--out"):  # before the work, not after it
        kept.parent.mkdir(parents=True, exist_ok=True)
        for place in (kept, journal, out / "report.html"):
            check_place(place)
    with progress() as show:
        found = gather(options, journal, show)
        command = " ".join(["python -m verification", *_arguments(options)])
        found.evidence.settings = {"command": command} | found.evidence.settings
        write_json(kept, found.as_json())
    say(f"evidence: {kept}; 'report --evidence' renders it")
    return found


def _kept(options: "Options", out: Path) -> dict[str, Path]:
    """Where a run keeps its evidence and its journal, by what they are."""
    name = "-".join([options.profile.name, str(options.seed), *options.claims])
    folder = out / ".journal"
    return {"the evidence": folder / f"{name}.evidence.json", "the journal": folder / f"{name}.jsonl"}


def _arguments(options: "Options") -> Iterator[str]:
    """The arguments that repeat a run."""
    yield from ("report", "--profile", options.profile.name, "--seed", str(options.seed))
    for claim in options.claims:
        yield from ("--claim", claim)


def _read(file: Path) -> "Run":
    """Read back what `_gather` has kept."""
    from verification.ledger.claims import CLAIMS  # noqa: PLC0415 - keeps --help quick
    from verification.run.stages import Run  # noqa: PLC0415

    try:
        found = Run.from_json(json.loads(file.read_text(encoding="utf-8")))
        if unknown := set(found.evidence.settings["claims"]) - set(CLAIMS):
            raise ValueError(f"the ledger has no claim {', '.join(sorted(unknown))}")
        return found
    except OSError as problem:
        raise typer.BadParameter(str(problem), param_hint="--evidence") from None
    except (ValueError, TypeError, LookupError, AttributeError) as problem:
        message = f"{file.name} is no evidence of a run: {type(problem).__name__}: {problem}"
        raise typer.BadParameter(message, param_hint="--evidence") from None


def _content(found: "Run", judged: "Judged", stored: "Experiments | None") -> dict[str, bytes]:
    """The files of the report."""
    from verification.report.write import files  # noqa: PLC0415

    records = {f"{name}.json": json_bytes(record.as_json()) for name, record in found.records.items()}
    return files(judged, records, stored)


def _store(content: dict[str, bytes], out: Path) -> None:
    from verification.report.write import store  # noqa: PLC0415 - keeps --help quick

    store(content, out)
    say(f"wrote {out / 'report.html'} and its companions")


def _judged(found: "Run") -> "Judged":
    """Judge a run and print verdicts and findings; exit where nothing can be judged."""
    from verification.ledger.baseline import Judged  # noqa: PLC0415 - keeps --help quick
    from verification.ledger.verdicts import ContradictionError  # noqa: PLC0415

    if found.interrupted:
        told = "; ".join(found.evidence.missing)
        say(f"{told}: nothing is judged. The same command goes on from there.")
        raise typer.Exit(OPEN)
    try:
        judged = Judged.of(found.evidence)
    except ContradictionError as problem:
        say(str(problem))
        raise typer.Exit(FAILED) from None
    _print(judged)
    return judged


def _print(judged: "Judged") -> None:
    from verification.ledger.claims import CLAIMS  # noqa: PLC0415 - keeps --help quick
    from verification.ledger.verdicts import verdict_in_words  # noqa: PLC0415

    table = Table("claim", "verdict", "from")
    for key in CLAIMS:
        if key in judged.judgements:
            each = judged.judgements[key]
            table.add_row(*map(Text, (key, verdict_in_words(each), each.reason)))
    console().print(table)
    if table.row_count < len(CLAIMS):
        say(f"judged: {table.row_count} of {len(CLAIMS)} claims; nothing is said of the others")
    for message in judged.assessment.messages:
        say(message)
