"""How much a run tries: quick by default, ci, or full."""

from dataclasses import dataclass

from verification.checks.interface import EXPENSIVE, Check
from verification.ledger.claims import PARTS, Role

FEW = 12
"""Problems of an expensive family, besides the least number, that a check with the exact referee gets."""


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

    def budget(self, check: Check, family: str) -> int:
        """Problems of one family for one check; no more than a few where each takes seconds."""
        budget = max(self.least, round(self.problems * check.share))
        return min(budget, self.least + FEW) if family in EXPENSIVE and check.refereed else budget

    def hunted(self, part: str) -> bool:
        """Whether a failure of this part is shrunk."""
        return self.hunts or PARTS[part].role is Role.STATED


PROFILES = {
    each.name: each
    for each in (
        Profile("quick", problems=8, shard=64, hunts=False, per_scale=4),
        Profile("ci", problems=40, shard=64, hunts=True, per_scale=12, least=12),
        Profile("full", problems=800, shard=200, hunts=True, per_scale=100, least=36),
    )
}
