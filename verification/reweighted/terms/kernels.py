"""Robust losses of installed libraries, each with the weight that the library uses for it, judged one by one.

A library that is not installed is left out, with the reason; so is a loss that there is no known way to make.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from verification.reweighted.answers import Answers
from verification.reweighted.terms.judging import judge_term
from verification.reweighted.terms.losses import LOSSES
from verification.reweighted.terms.measured import Make, judge_functions
from verification.reweighted.terms.term import Term

HALF = "r**2/2"


@dataclass(frozen=True)
class Kernel:
    """A loss of a library.

    Attributes
    ----------
    library, name : str
    judge : callable
        Returns the answers; or a text, why they are not given.
    """

    library: str
    name: str
    judge: Callable[[], Answers | str]


@dataclass(frozen=True)
class Judged:
    """What is said of a kernel.

    Attributes
    ----------
    library, name : str
        The name is empty where the whole library is left out.
    answers : Answers or None
    reason : str
        Why there are no answers.
    """

    library: str
    name: str
    answers: Answers | None
    reason: str = ""

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        told = {"library": self.library, "kernel": self.name, "reason": self.reason}
        return told | {"answers": None if self.answers is None else self.answers.as_json()["answers"]}


def formulas() -> Iterator[Kernel]:
    """The losses of the literature."""
    for loss in LOSSES:
        yield Kernel("formulas", loss.name, lambda term=loss.term: judge_term(term))  # type: ignore[misc]


ROBUST_NORMS: dict[str, Callable[[Any, float], Any]] = {
    "HuberT": lambda norms, width: norms.HuberT(width),
    "RamsayE": lambda norms, width: norms.RamsayE(width),
    "AndrewWave": lambda norms, width: norms.AndrewWave(width),
    "TrimmedMean": lambda norms, width: norms.TrimmedMean(width),
    "Hampel": lambda norms, width: norms.Hampel(2 * width, 4 * width, 8 * width),
    "TukeyBiweight": lambda norms, width: norms.TukeyBiweight(width),
    "TukeyQuartic": lambda norms, width: norms.TukeyQuartic(width),
    "StudentT": lambda norms, width: norms.StudentT(width),
    "MQuantileNorm": lambda norms, width: norms.MQuantileNorm(0.3, norms.HuberT(width)),
}
"""How statsmodels' norms are made with a width."""


def statsmodels() -> Iterator[Kernel]:
    """The classes of statsmodels.robust.norms: rho, and weights, which are psi(z)/z."""
    norms = import_module("statsmodels.robust.norms")
    for name, kind in vars(norms).items():
        if isinstance(kind, type) and issubclass(kind, norms.RobustNorm) and kind is not norms.RobustNorm:
            yield Kernel("statsmodels", name, lambda name=name: _norm(norms, name))  # type: ignore[misc]


def _norm(norms: Any, name: str) -> Answers | str:
    def make(width: float) -> Any:
        norm = ROBUST_NORMS[name](norms, width)
        return norm.rho, norm.weights

    try:
        norm = getattr(norms, name)() if name not in ("MQuantileNorm",) else ROBUST_NORMS[name](norms, 1.345)
    except TypeError:
        return "no known way to make it"
    known = make if name in ROBUST_NORMS else None
    return _judged(norm.rho, norm.weights, known, name)


def _judged(loss: Any, weight: Any, make: Make | None, name: str) -> Answers:
    return judge_functions(loss, weight, HALF, signed=True, make=make, name=name)


WITHOUT_WIDTH = ("Null",)
GIVEN_FUNCTIONS = ("Base", "Custom")
"""Names of gtsam.noiseModel.mEstimator that are no losses of its own."""


def gtsam() -> Iterator[Kernel]:
    """The estimators of gtsam.noiseModel.mEstimator: loss, and weight."""
    found = import_module("gtsam").noiseModel.mEstimator
    for name in sorted(vars(found)):
        kind = getattr(found, name)
        if isinstance(kind, type) and hasattr(kind, "Create") and name not in GIVEN_FUNCTIONS:
            yield Kernel("gtsam", name, lambda kind=kind, name=name: _estimator(kind, name))  # type: ignore[misc]


def _estimator(kind: Any, name: str) -> Answers | str:
    def make(width: float) -> Any:
        made = kind.Create(width)
        return made.loss, made.weight

    try:
        one = kind.Create() if name in WITHOUT_WIDTH else kind.Create(1.0)
    except TypeError:
        return "no known way to make it"
    return _judged(one.loss, one.weight, None if name in WITHOUT_WIDTH else make, name)


LEAST_SQUARES = {
    "linear": ("r**2/2", "1"),
    "soft_l1": ("c**2*(sqrt(1 + (r/c)**2) - 1)", "1/sqrt(1 + (r/c)**2)"),
    "huber": ("r**2/2 if r <= c else c*r - c**2/2", "1 if r <= c else c/r"),
    "cauchy": ("c**2*log(1 + (r/c)**2)/2", "1/(1 + (r/c)**2)"),
    "arctan": ("c**2*atan((r/c)**2)/2", "1/(1 + (r/c)**4)"),
}
"""c**2/2 rho((r/c)**2) and rho'((r/c)**2) as SciPy documents rho, with c = f_scale."""

F_SCALE = "1.5"
COMPARED = (-40.0, -3.0, -1.25, -0.01, 0.02, 0.9, 2.0, 7.0, 1e4)
"""Residuals at which the cost and the gradient of least_squares are compared with these."""


def scipy() -> Iterator[Kernel]:
    """The losses of scipy.optimize.least_squares: documented formulas, compared with its cost."""
    solve = import_module("scipy.optimize").least_squares
    for name in LEAST_SQUARES:
        yield Kernel("scipy", name, lambda name=name: _least_squares(solve, name))  # type: ignore[misc]


def _least_squares(solve: Any, name: str) -> Answers | str:
    loss, weight = LEAST_SQUARES[name]
    widths = {"c": F_SCALE} if "c" in loss else {}
    term = Term(loss, weight, HALF, widths, name=name)
    for r in COMPARED:
        cost, slope = _returned(solve, name, r)
        values = {each.name: float(F_SCALE) for each in term.loss_expression.free_symbols if each.name != "r"}
        wanted = [
            float(each.subs({s: values.get(s.name, abs(r)) for s in each.free_symbols}).evalf())
            for each in (term.loss_expression, term.weight_expression)
        ]
        if not np.allclose([cost, slope / r], wanted, rtol=1e-9, atol=0.0):
            return f"at r = {r:g} cost and gradient / r are {cost!r} and {slope / r!r}, documented {wanted}"
    return judge_term(term)


def _returned(solve: Any, name: str, r: float) -> tuple[float, float]:
    """The cost of one residual r, and its derivative, where no step has been made."""
    found = solve(lambda x: x, [r], jac=lambda x: np.eye(1), loss=name, f_scale=float(F_SCALE), max_nfev=1)
    return float(found.cost), float(found.grad[0])


LIBRARIES: dict[str, Callable[[], Iterator[Kernel]]] = {
    "formulas": formulas,
    "scipy": scipy,
    "statsmodels": statsmodels,
    "gtsam": gtsam,
}


def judged(
    libraries: tuple[str, ...], progress: Callable[[str, int, int], None] = lambda library, done, total: None
) -> Iterator[Judged]:
    """Judge all kernels of these libraries; `progress` gets a library, how many are done, of how many."""
    for library in libraries:
        try:
            kernels = list(LIBRARIES[library]())
        except ModuleNotFoundError as missing:
            yield Judged(library, "", None, f"not installed: {missing.name}")
            continue
        for done, kernel in enumerate(kernels):
            progress(library, done, len(kernels))
            found = kernel.judge()
            if isinstance(found, str):
                yield Judged(library, kernel.name, None, found)
            else:
                yield Judged(library, kernel.name, found)
