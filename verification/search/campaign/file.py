"""A campaign on file: what was asked, and what its first chunks found. A broken run goes on from here.

Schema: ``command`` (word by word), ``settings`` (the fields of `Settings`), ``chunks`` and ``done``, and the
fields of `verification.search.campaign.tallies`.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.method import Newton
from verification.search.campaign.cases import Plan
from verification.search.campaign.run import CHUNK, Rules, State


@dataclass(frozen=True)
class Settings:
    """Everything that the outcome depends on.

    Attributes
    ----------
    random, degenerate, extreme, seed : int
        See `Plan`.
    solver : str
        "newton" or "conic".
    escalate : bool
    referee, raw : int
        See `Rules`.
    chunk : int
        Cases that a worker takes at a time.
    """

    random: int
    degenerate: int
    extreme: int
    seed: int
    solver: str
    escalate: bool
    referee: int
    raw: int
    chunk: int = CHUNK

    @property
    def plan(self) -> Plan:
        """The cases."""
        return Plan(self.random, self.degenerate, self.extreme, self.seed)

    @property
    def rules(self) -> Rules:
        """How each is treated."""
        return Rules(_solver(self.solver), self.escalate, self.referee, self.raw)

    def fresh(self) -> State:
        """The state before the first chunk."""
        return State(-(-len(self.plan) // self.chunk))


def _solver(name: str) -> Solver:
    if name == "newton":
        return Newton()
    from convexperc.solvers.conic import Conic  # noqa: PLC0415 - CVXPY takes a second

    return Conic()


def save(file: Path, command: list[str], settings: Settings, state: State) -> None:
    """Write everything, by replacing the file at once: a run that is killed leaves a whole one."""
    data = {"command": command, "settings": asdict(settings), **state.as_json()}
    part = file.with_name(file.name + ".part")
    part.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    part.replace(file)


def load(file: Path) -> tuple[list[str], Settings, State]:
    """Read what `save` wrote.

    Raises
    ------
    OSError
        The file cannot be read.
    ValueError
        It is no campaign's.
    """
    try:
        data: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        return list(data["command"]), Settings(**data["settings"]), State.from_json(data)
    except (KeyError, TypeError) as problem:
        raise ValueError(f"no campaign's file: {problem}") from None
