"""The solvers that the benchmark compares, and the paper's loop.

None but NumPy, CVXPY and Clarabel is needed by the library; the others are the extra ``bench`` and are
imported where they are used.
"""

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from convexperc.problem.arrays import Vector
from verification.bench.cones import Clarabel, Qoco, Scs
from verification.bench.lassos import Celer, Skglm
from verification.bench.posed import Ours, OursAlone, Posed

IDLE = 10**9
"""A limit of iterations that is never met: the clock and the tolerance stop a solver, nothing else."""


class Direct(Posed):
    """Eq. (full) in CVXPY, compiled anew for every template."""

    def _pose(self) -> None:
        self.model: Any = None

    def _load(self, template: int) -> None:
        self.problem = self.instance.problem(template, self.lambdas)

    def _model(self) -> Any:
        from convexperc.solvers.conic import Model  # noqa: PLC0415 - slow to import

        model = self.model or Model.of(self.problem)
        model.assign(self.problem)
        return model

    def _solve(self, template: int) -> tuple[Vector, Vector]:
        from convexperc.solvers.conic import Conic  # noqa: PLC0415 - slow to import

        model, tolerance = self._model(), self.tolerance
        if tolerance < 1e-11:
            Conic(tolerance)._solve(model)
        else:
            names = ("tol_gap_abs", "tol_gap_rel", "tol_feas")
            model.problem.solve(solver="CLARABEL", max_threads=1, **dict.fromkeys(names, tolerance))
        return model.w.value, model.u.value

    def point(self, found: Any) -> tuple[Vector, Vector]:
        """(w, u), which is what the solver returned."""
        return found[0], found[1]


class DirectDpp(Direct):
    """Eq. (full) in CVXPY, compiled once, o and the lambdas as parameters."""

    def _pose(self) -> None:
        self.model = None
        self._load(0)
        self.model = self._model()
        self.model.problem.get_problem_data("CLARABEL")


class Paper(Posed):
    """Algorithm 1 until its own test holds; the update and the linear solver are named by the subclass."""

    reading, linear_solver = "printed", "direct"

    def _load(self, template: int) -> None:
        self.problem = self.instance.problem(template, self.lambdas)

    def _solve(self, template: int) -> tuple[Vector, Vector]:
        from convexperc.solvers.paper.loop import run  # noqa: PLC0415 - imported where it is used

        trace = run(
            self.problem,
            variant=self.reading,
            linear_solver=self.linear_solver,
            tolerance=self.tolerance,
            max_iterations=IDLE,
        )
        return trace.w, trace.u

    def point(self, found: Any) -> tuple[Vector, Vector]:
        """(w, u), which is what the solver returned."""
        return found[0], found[1]


class PaperWoodbury(Paper):
    """As printed, with the n x n system of Woodbury's identity."""

    linear_solver = "woodbury"


class CorrectedWoodbury(PaperWoodbury):
    """The update repaired, so that its limit is the optimum; by Woodbury."""

    reading = "corrected"


@dataclass(frozen=True)
class Peer:
    """A line of the table.

    Attributes
    ----------
    name : str
    kind : type of Posed
    ladder : tuple of float
        The solver's own tolerances, loose to tight; the first that satisfies the judge counts.
    needs : tuple of str
        Packages that must be there.
    most : float
        Largest n d, beyond which the peer is left out.
    """

    name: str
    kind: type[Posed]
    ladder: tuple[float, ...]
    needs: tuple[str, ...] = ()
    most: float = 5e7

    def left_out(self, instance_size: int) -> str:
        """Why this peer cannot be measured here; empty if it can."""
        missing = [package for package in self.needs if find_spec(package) is None]
        if missing:
            return f"{', '.join(missing)} not installed: extra bench"
        return f"left out: n d = {instance_size:.0e} is beyond it" if instance_size > self.most else ""


INTERIOR = (1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
OURS, ALONE = "ours", "ours, one at a time"
PEERS = {
    peer.name: peer
    for peer in (
        Peer(OURS, Ours, (9e-10, 1e-10, 1e-11), most=np.inf),
        Peer(ALONE, OursAlone, (9e-10, 1e-10, 1e-11), most=np.inf),
        Peer("qoco, reduced", Qoco, INTERIOR, ("qoco",)),
        Peer("clarabel, reduced", Clarabel, INTERIOR),
        Peer("scs, reduced", Scs, (1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), ("scs",)),
        Peer("skglm, reduced", Skglm, (1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13), ("skglm",)),
        Peer("celer, reduced", Celer, (1e-8, 1e-9, 1e-10, 1e-11, 1e-12), ("celer",)),
        Peer("cvxpy+clarabel, cold", Direct, INTERIOR, most=2e6),
        Peer("cvxpy+clarabel, dpp", DirectDpp, INTERIOR, most=2e6),
        Peer("paper, printed, direct", Paper, (1e-6, 1e-10), most=2e6),
        Peer("paper, printed, woodbury", PaperWoodbury, (1e-6, 1e-10), most=2e6),
        Peer("paper, corrected, woodbury", CorrectedWoodbury, (1e-6, 1e-8, 1e-10, 1e-12), most=2e6),
    )
}
ABSENT = {"adelie": "left out: its releases pin a NumPy that clashes with CVXPY's"}
"""Peers that no run measures, and why."""
