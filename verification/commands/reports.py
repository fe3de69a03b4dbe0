"""The command that makes the generated files of `reports/` anew; no mathematics."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from verification.commands.claims import Out


@dataclass(frozen=True)
class Step:
    """What makes some of the files.

    Attributes
    ----------
    subject : str
        The code that they speak of, a key of `verification.provenance.SUBJECTS`; empty for pages that follow
        from a stored record alone.
    commands : dict of str to str
        By the file whose stamp is read, the arguments of this program; {out} and {jobs} are filled in.
    """

    subject: str
    commands: dict[str, str]


STEPS = {
    "quick": Step("report", {"report.json": "report --jobs {jobs} --out {out}"}),
    "ci": Step("report", {"ci/report.json": "report --profile ci --jobs {jobs} --out {out}/ci"}),
    "faults": Step(
        "faults",
        {"faults.json": "faults --jobs {jobs} --json {out}/faults.json --markdown {out}/faults.md"},
    ),
    "experiments": Step("", {"experiments/experiments.md": "experiments-pages --out {out}/experiments"}),
    "bench": Step(
        "benchmark",
        {
            "bench-S-M.json": "bench --instances S,M --growth --plot {out}/growth.svg --pictures"
            " --json {out}/bench-S-M.json",
            "bench-L.json": "bench --instances L --templates 2 --repeat 3 --json {out}/bench-L.json",
            "bench-XL-P.json": "bench --instances XL,P --peers ours --templates 2 --repeat 3 --limit 120"
            " --json {out}/bench-XL-P.json",
        },
    ),
    "campaign": Step(
        "campaign",
        {
            "campaign.json": "campaign --random 530000 --degenerate 450000 --extreme 20000 --referee 18"
            " --clarabel 50 --jobs {jobs} --json {out}/campaign.json"
        },
    ),
    "full": Step("report", {"full/report.json": "report --profile full --jobs {jobs} --out {out}/full"}),
}
"""In the order of what they take: a minute, minutes, an hour."""


REPORTS_HELP = (
    "Make the reports, the table of faults, the benchmark and the campaign anew, where the code has "
    "changed.\n\n"
    "A run that is broken off goes on where it was. Exit code: the highest of the commands."
)


def reports(
    only: Annotated[
        list[str] | None, typer.Option(help=f"Of {', '.join(STEPS)}; may be given several times.")
    ] = None,
    out: Out = Path("reports"),
    jobs: Annotated[int, typer.Option(min=1, help="Worker processes.")] = 2,
    again: Annotated[bool, typer.Option("--again", help="Also what the present code has made.")] = False,
) -> None:
    """Run the command ``reports``."""
    chosen = list(only or STEPS)
    if unknown := [name for name in chosen if name not in STEPS]:
        raise typer.BadParameter(f"{unknown[0]!r} is none of {', '.join(STEPS)}", param_hint="--only")
    worst = 0
    for name in chosen:
        step = STEPS[name]
        for file, command in step.commands.items():
            if not again and step.subject and _is_current(out / file, step.subject):
                typer.echo(f"{file}: made by the present code")
                continue
            words = [word.format(out=out, jobs=jobs) for word in command.split()]
            typer.echo(f"{name}: {' '.join(words)}")
            done = subprocess.run([sys.executable, "-m", "verification", *words], check=False)
            worst = max(worst, abs(done.returncode))
    raise typer.Exit(worst)


def _is_current(file: Path, subject: str) -> bool:
    """Whether a generated file says that the present code made it."""
    from verification.provenance import is_current  # noqa: PLC0415 - keeps --help quick

    try:
        return is_current(json.loads(file.read_text(encoding="utf-8")), subject)
    except (OSError, ValueError):
        return False
