"""Faults in Algorithm 1: in its updates, in their order, and in what its trace says."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from convexperc.solvers.paper import loop as paper
from convexperc.solvers.paper import systems as paper_systems
from convexperc.solvers.paper.trace import Log, PaperTrace
from convexperc.solvers.paper.variants import ABSOLUTE, CORRECTED, Diagonal, Size, UpdateVariant
from verification.faults.fault import Fault, Plant, Setter, replaced, together, wrapped
from verification.faults.formulation import single

LINES: tuple[Any, Any] = paper_systems.solve_w, paper_systems.solve_u
"""What lines 6 and 7 of the loop call."""


@dataclass
class Iteration:
    """One iteration of the loop while it runs: (w, u) before it, and its w."""

    w: Any = None
    u: Any = None
    next_w: Any = None


def iterating(
    new_w: Callable[[Iteration, Any], Any] = lambda at, found: found,
    seen: Callable[[Iteration, Any], Any] = lambda at, w: w,
    new_u: Callable[[Iteration, Any], Any] = lambda at, found: found,
) -> Plant:
    """Change what lines 6 and 7 return, or which w line 7 sees."""

    def plant(setter: Setter) -> None:
        at = Iteration()
        diagonal, (solve_w, solve_u) = UpdateVariant.view_diagonal, LINES

        def noted(self: UpdateVariant, w: Any) -> Diagonal:
            at.w = w
            return diagonal(self, w)

        def line_6(problem: Any, reading: Any, Dw: Any, u: Any, on_singular: Any) -> Any:
            at.u, before = u, at.w
            at.next_w = solve_w(problem, reading, Dw, u, on_singular)
            at.w = before
            return new_w(at, at.next_w)

        def line_7(problem: Any, reading: Any, Du: Any, w: Any, solver: Any, on_singular: Any) -> Any:
            return new_u(at, solve_u(problem, reading, Du, seen(at, w), solver, on_singular))

        setter.setattr(UpdateVariant, "view_diagonal", noted)
        setter.setattr(paper, "solve_w", line_6)
        setter.setattr(paper, "solve_u", line_7)

    return plant


def sizes_of_w(size: Size, change: Callable[[UpdateVariant, Any], Any]) -> Plant:
    """What stands for |w_i| where the reading has `size`."""
    original = UpdateVariant._view_sizes

    def sizes(self: UpdateVariant, w: Any) -> Any:
        return np.asarray(change(self, w)) if self.size is size else original(self, w)

    return replaced(UpdateVariant, "_view_sizes", sizes)


def sizes_of_u(change: Callable[[UpdateVariant, Any, Any], Any]) -> Plant:
    """What stands for ||u^i||: `change` takes the reading, the norms and the true sizes."""
    original = UpdateVariant._modality_sizes

    def sizes(self: UpdateVariant, u: Any, modalities: Any) -> Any:
        return np.asarray(change(self, modalities.norms(u), original(self, u, modalities)))

    return replaced(UpdateVariant, "_modality_sizes", sizes)


def halved(*names: str) -> Plant:
    """Give lambda / 2 where the corrected update is asked for."""

    def one(name: str) -> Plant:
        original = getattr(paper, name)

        def solve(problem: Any, reading: Any, *rest: Any) -> Any:
            return original(problem, ABSOLUTE if reading == CORRECTED else reading, *rest)

        return replaced(paper, name, solve)

    return together(*(one(name) for name in names))


def _without_lambda1(problem: Any, reading: Any, Dw: Any, u: Any, on_singular: Any) -> Any:
    """XX' for XX' + lambda1 I."""
    X, ridge = problem.X, Dw.times(reading.factor * problem.lambda2)
    rhs = X @ (problem.o + problem.lambda1 * u)
    return paper_systems._solve_free(X @ X.T, ridge, rhs, on_singular)


def _stale_u_in_w(solve_w: Any) -> Any:
    """Line 6 without lambda1 u."""
    return lambda problem, reading, Dw, u, stop: solve_w(problem, reading, Dw, np.zeros_like(u), stop)


def _released(solve_free: Any) -> Any:
    """No ridge where it should be infinite."""
    return lambda gram, ridge, rhs, stop: solve_free(
        gram, np.where(np.isfinite(ridge), ridge, 0.0), rhs, stop
    )


def _settled_at_once(settled: Any) -> Any:
    """Converged after the first step, whatever it was."""
    return lambda self, w, u: (settled(self, w, u), True)[1]


def _one_more(prepare: Any) -> Any:
    def post_init(self: Log) -> None:
        prepare(self)
        self.max_iterations += 1

    return post_init


def _late(trace: PaperTrace) -> PaperTrace:
    """F of every iterate one iteration late."""
    return replace(trace, F=np.concatenate([trace.F[:1], trace.F[:-1]]))


def _early_point(trace: PaperTrace) -> PaperTrace:
    """The last iterate but one as the answer."""
    return replace(trace, w=trace.path_w[-2:][0].copy(), u=trace.path_u[-2:][0].copy())


SIGNED = sizes_of_w(Size.ABSOLUTE, lambda reading, w: w)
SQUARED = sizes_of_u(lambda reading, norms, true: true**2)

UPDATES = (
    Fault("u is not updated", "B3/step", iterating(new_u=lambda at, found: at.u)),
    Fault("w is not updated", "B3/step", iterating(new_w=lambda at, found: at.w)),
    Fault("Jacobi where Gauss-Seidel is asked for", "B3/step", iterating(seen=lambda at, w: at.w)),
    Fault("Gauss-Seidel where Jacobi is asked for", "B3/step", iterating(seen=lambda at, w: at.next_w)),
    Fault("w's system without lambda1 u", "B3/step", replaced(paper, "solve_w", _stale_u_in_w(LINES[0]))),
    Fault("w's system without lambda1 I", "B3/step", replaced(paper, "solve_w", _without_lambda1)),
    Fault("D^w without absolute value", "B3/step", SIGNED),
    Fault("half of lambda2 in the corrected update", "B3/step", halved("solve_w")),
    Fault("half of lambda3 in the corrected update", "B3/step", halved("solve_u")),
    Fault("D^u with ||u^i||^2", "B3/step", SQUARED),
    Fault("blocks of D^u in the reverse order", "B3/step", sizes_of_u(lambda r, norms, true: true[::-1])),
    Fault(
        "eps ignored by D^w in the smoothed update",
        "B3/step",
        sizes_of_w(Size.SMOOTHED, lambda reading, w: np.abs(w)),
    ),
    Fault(
        "the appendix's ||w||_1 as ||w||_2",
        "B3/step",
        sizes_of_w(Size.L1_NORM, lambda reading, w: np.full_like(w, np.linalg.norm(w))),
    ),
    Fault(
        "updates in single precision",
        "B3/step",
        iterating(lambda at, found: single(found), lambda at, w: w, lambda at, found: single(found)),
    ),
    Fault(
        "Woodbury's inverse of D^u without its factor 2",
        "B3/step",
        replaced(Diagonal, "inverse", lambda self, weight: self.sizes / weight),
    ),
    Fault(
        "an entry at 0 is not held there",
        "B3/step",
        replaced(paper_systems, "_solve_free", _released(paper_systems._solve_free)),
    ),
)

TRACE = (
    Fault(
        "converged after the first step",
        "B3/trace",
        replaced(Log, "_settled", _settled_at_once(Log._settled)),
    ),
    Fault("F of the trace one iteration late", "B3/trace", wrapped(Log, "trace", lambda t, *a: _late(t))),
    Fault(
        "the answer is the last iterate but one",
        "B3/trace",
        wrapped(Log, "trace", lambda t, *a: _early_point(t)),
    ),
    Fault(
        "one iteration more than asked for",
        "B3/trace",
        replaced(Log, "__post_init__", _one_more(Log.__post_init__)),
    ),
)
