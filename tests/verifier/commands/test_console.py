"""What the verifier prints: brackets are no markup, and no name forges a line."""

import pytest
from rich.table import Table

from verification.commands.console import console, say


def test_what_stands_in_brackets_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("statistic [lower, upper]")
    table.add_row("[red]0.5[/red] :warning:")
    console().print(table)
    told = capsys.readouterr().out
    assert "statistic [lower, upper]" in told, told
    assert "[red]0.5[/red] :warning:" in told, told


def test_a_line_stays_one_line_and_is_not_broken(capsys: pytest.CaptureFixture[str]) -> None:
    say("wrote " + "x" * 300 + "\nproved\x1b[2J")
    assert capsys.readouterr().out == "wrote " + "x" * 300 + r"\nproved\x1b[2J" + "\n"
