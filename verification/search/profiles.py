"""How much a run tries: quick by default, ci, or full."""

from dataclasses import dataclass

from verification.checks.interface import Check
from verification.ledger.claims import PARTS, Role


@dataclass(frozen=True)
class Profile:
    """A budget.

    Attributes
    ----------
    name : str
    problems : int
        Problems of each family that a check of share 1 is tried on.
    shard : int
        Most problems that a worker takes at a time; what a kill can lose.
    hunts : bool
        Whether failures of every part are shrunk, or those of stated parts alone.
    per_scale : int
        Problems a scale for the plot of Clarabel.
    least : int
        Problems of each family that every check is tried on, whatever its share: at least 4, since Hypothesis
        begins with the simplest problem, all zeros.
    """

    name: str
    problems: int
    shard: int
    hunts: bool
    per_scale: int
    least: int = 4

    def budget(self, check: Check) -> int:
        """Problems of each family for one check."""
        return max(self.least, round(self.problems * check.share))

    def hunted(self, part: str) -> bool:
        """Whether a failure of this part is shrunk."""
        return self.hunts or PARTS[part].role is Role.STATED


PROFILES = {
    each.name: each
    for each in (
        Profile("quick", problems=8, shard=64, hunts=False, per_scale=4),
        Profile("ci", problems=40, shard=64, hunts=True, per_scale=12, least=12),
        Profile("full", problems=715, shard=175, hunts=True, per_scale=100, least=36),
    )
}
