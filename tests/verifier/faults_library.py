"""Faults to plant, one at a time: where each is, and the part of a claim that must then fail."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from convexperc import certificate, critical, frame, objective, recognition, solving
from convexperc.answers import Answers
from convexperc.features import color, extraction, hog, lbp
from convexperc.problem import Problem
from convexperc.recognition import Verdict
from convexperc.reduction import Reduction
from convexperc.scaling import Scaling
from convexperc.solvers import paper_systems
from convexperc.solvers.conic import Model
from convexperc.solvers.newton import Newton
from convexperc.solvers.qp import Quadratic
from convexperc.solvers.readings import ABSOLUTE, CORRECTED
from verification import cost, oracles, raw
from verification.checks import lemmas
from verification.checks.rational import squares
from verification.oracles import Enclosure, square_root


class Patcher(Protocol):
    """What plants a fault; `pytest.MonkeyPatch` is one."""

    def setattr(self, target: Any, name: str, value: Any) -> None:
        """Replace an attribute."""


Plant = Callable[[Patcher], None]
ORDINARY = ("random", "recognition")


@dataclass(frozen=True)
class Fault:
    """A fault.

    Attributes
    ----------
    name : str
    part : str
        The part of a claim that must fail.
    plant : callable
        Takes a `Patcher`.
    also : tuple of str
        Parts of the same check that the fault makes false as well.
    families : tuple of str
        Where it shows.
    """

    name: str
    part: str
    plant: Plant
    also: tuple[str, ...] = ()
    families: tuple[str, ...] = ORDINARY


def replaced(target: Any, name: str, value: Any) -> Plant:
    """Put another function in one place."""
    return lambda patcher: patcher.setattr(target, name, value)


def wrapped(target: Any, name: str, change: Callable[..., Any]) -> Plant:
    """Change what one function returns: `change` takes that and the function's arguments."""
    original = getattr(target, name)
    return replaced(target, name, lambda *a, **k: change(original(*a, **k), *a))


def together(*plants: Plant) -> Plant:
    """Several changes that make one fault."""

    def apply(patcher: Patcher) -> None:
        for plant in plants:
            plant(patcher)

    return apply


def terms_with(change: Callable[..., dict[str, float]]) -> Plant:
    """Change some of the library's terms of F."""
    return wrapped(objective, "terms", lambda found, p, w, u: replace(found, **change(found, p, w, u)))


def with_lambdas(problem: Problem, one: float, two: float, three: float) -> Problem:
    """The same data with other lambdas."""
    return Problem(
        problem.X, problem.o, modalities=problem.modalities, lambda1=one, lambda2=two, lambda3=three
    )


def candidate_of(solver: type, change: Callable[[Problem], Problem]) -> Plant:
    """Let a solver answer another problem than the one it is given."""
    original = solver.candidate
    return replaced(solver, "candidate", lambda self, problem: original(self, change(problem)))


def halved_penalties(problem: Problem) -> Problem:
    return with_lambdas(problem, problem.lambda1, problem.lambda2 / 2, problem.lambda3 / 2)


def conic_halved(patcher: Patcher) -> None:
    original = Model.assign

    def assign(self: Model, problem: Problem) -> None:
        original(self, halved_penalties(problem))

    patcher.setattr(Model, "assign", assign)


def reduction_with(change: Callable[[Reduction], Reduction]) -> Plant:
    """Change the Gram matrices that the reduced problem is made of."""
    original = Reduction.of
    return replaced(Reduction, "of", lambda X, modalities: change(original(X, modalities)))


def single_precision(true: Reduction) -> Reduction:
    K = true.K.astype(np.float32).astype(np.float64)
    return replace(true, K=K, G=K.sum(axis=0))


def frame_with(**factors: float) -> Plant:
    """Multiply the normalised lambdas that the judge sees."""
    original = frame.Frame.of

    def of(problem: Problem, scaling: Scaling) -> frame.Frame:
        true = original(problem, scaling)
        changed = {k: tuple(f * x for x in getattr(true, k)) for k, f in factors.items()}
        return replace(true, **changed)

    return replaced(frame.Frame, "of", of)


def decided(change: Callable[[Any], Any]) -> Plant:
    """Change the verdict of a recognition."""
    return wrapped(recognition, "decide", lambda found, *a: change(found))


def guessed(found: Any) -> Any:
    """A tie called by its first candidate."""
    if found.verdict is not Verdict.TIE:
        return found
    return replace(found, verdict=Verdict.PROVED, label=found.candidates[0])


def swapped_label(found: Any) -> Any:
    """Another name for a proved label."""
    others = [name for name in found.names if name != found.label]
    return replace(found, label=others[0]) if found.verdict is Verdict.PROVED and others else found


def called_tie(found: Any) -> Any:
    """A tie where one template is proved to be the lowest."""
    return replace(found, verdict=Verdict.TIE, label=None) if found.verdict is Verdict.PROVED else found


def half_of_corrected(name: str) -> Plant:
    """Give lambda / 2 where the corrected derivative is asked for."""
    original = getattr(paper_systems, name)

    def derivative(problem: Problem, reading: Any, w: Any, u: Any) -> Any:
        return original(problem, ABSOLUTE if reading is CORRECTED else reading, w, u)

    return replaced(paper_systems, name, derivative)


def l1_by_modality(found: Any, problem: Problem, w: Any, u: Any) -> dict[str, float]:
    return {"modality_norm": problem.lambda3 * float(np.abs(u).sum())}


def halved_oracle(value: Enclosure, problem: Problem, w: Any, u: Any) -> Enclosure:
    """F without a half of its modality norm."""
    other = with_lambdas(problem, problem.lambda1, problem.lambda2, problem.lambda3 / 2)
    return oracles_objective(other, w, u)


def lbp_of_levels(gray: Any, configuration: Any) -> Any:
    """A neighbour must be brighter by about one level of 16 to count."""
    codes = lbp.local_binary_pattern(
        gray // 16,
        P=configuration.lbp_points,
        R=configuration.lbp_radius,
        method=configuration.lbp_method,
    )
    rim = configuration.lbp_margin
    inner = codes[rim:-rim, rim:-rim].astype(np.int64)
    return np.bincount(inner.ravel(), minlength=configuration.lbp_bins).astype(np.float64)


def exchanged(X: Any, configuration: Any) -> Any:
    """The last block first."""
    ends = np.cumsum(list(configuration.modality_sizes.values()))
    first, middle, last = np.split(X, ends[:-1], axis=1)
    return np.concatenate([last, middle, first], axis=1)


oracles_objective = oracles.objective

FORMULATION = (
    Fault(
        "the root of |w_j| in the objective",
        "F1/convex",
        terms_with(lambda f, p, w, u: {"view_norm": p.lambda2 * float(np.sqrt(np.abs(w)).sum())}),
    ),
    Fault(
        "||o||^2 left out of the objective",
        "F1/bounded",
        terms_with(lambda f, p, w, u: {"loss": f.loss - 2.0 * float(p.o @ p.o)}),
    ),
    Fault("lambda2 and lambda3 halved in the conic model", "F2/conic", conic_halved),
    Fault(
        "lambda2 and lambda3 halved for Newton's method",
        "F2/reduced",
        candidate_of(Newton, halved_penalties),
    ),
    Fault(
        "OSQP's answer is another problem's",
        "F2/quadratic",
        candidate_of(Quadratic, halved_penalties),
        families=("one_column_modalities",),
    ),
    Fault(
        "lambda3 halved in the oracle",
        "F2/group_lasso",
        wrapped(oracles, "objective", halved_oracle),
    ),
    Fault(
        "critical lambda2 without its factor 2",
        "F3/critical_lambda2",
        wrapped(critical, "critical_lambda2", lambda found, *a: (0.5 * found[0], 0.5 * found[1])),
    ),
    Fault(
        "critical lambda3 without its factor 2",
        "F3/critical_lambda3",
        wrapped(critical, "critical_lambda3", lambda found, *a: 0.5 * found),
    ),
    Fault(
        "critical lambda3 doubled",
        "F3/critical_lambda3",
        wrapped(critical, "critical_lambda3", lambda found, *a: 2.0 * found),
    ),
    Fault(
        "modalities proved zero for nothing",
        "F3/exact_zeros",
        wrapped(certificate, "proved_zeros", lambda zeros, *a: (zeros[0], np.ones_like(zeros[1]))),
        also=("B2/true", "B2/answered"),
    ),
    Fault("the l1-norm within a modality", "F4/parallel", terms_with(l1_by_modality)),
)

DERIVATION = (
    Fault("half of lambda2 in the corrected derivative", "D1/corrected", half_of_corrected("derivative_w")),
    Fault("half of lambda3 in the corrected derivative", "D2/corrected", half_of_corrected("derivative_u")),
    Fault(
        "the derivative for w doubled",
        "D1/printed",
        wrapped(paper_systems, "derivative_w", lambda found, *a: 2.0 * found),
        also=("D1/corrected",),
        families=("lambda2_zero",),
    ),
    Fault(
        "the derivative for u doubled",
        "D2/printed",
        wrapped(paper_systems, "derivative_u", lambda found, *a: 2.0 * found),
        also=("D2/corrected",),
        families=("lambda3_zero",),
    ),
    Fault(
        "Lemma 1 with ||v|| for 2 ||v||",
        "L1/inequality",
        replaced(lemmas, "lemma_one", lambda t, v: square_root(squares(t) * squares(v)).upper - squares(t)),
    ),
    Fault(
        "the elementwise form against a quarter of ||v||_1",
        "L2/elementwise",
        wrapped(lemmas, "elementwise", lambda excess, t, v: excess + lemmas.l1(v) / 4),
    ),
    Fault(
        "D^w without its factor 1/2",
        "A2/elementwise",
        wrapped(lemmas, "defined", lambda value, *a: 2 * value),
    ),
    Fault(
        "half of the appendix's objective",
        "A1/lambda1_one",
        wrapped(lemmas, "appendix", lambda value, p, w, u: Enclosure(value.lower / 2, value.upper / 2)),
    ),
)

LIBRARY = (
    Fault(
        "lambda3 halved in the objective",
        "B1/objective",
        terms_with(lambda f, p, w, u: {"modality_norm": 0.5 * f.modality_norm}),
    ),
    Fault(
        "terms of the gap left out",
        "B1/dual",
        wrapped(certificate, "gap_terms", lambda t, *a: replace(t, loss=0.25 * t.loss, view_norm=0.0)),
    ),
    Fault(
        "F* scaled back by half of the exponent",
        "B1/scaling",
        replaced(
            Scaling, "value_back", lambda self, bounds: tuple(float(np.ldexp(x, self.o)) for x in bounds)
        ),
    ),
    Fault("lambda2 doubled for the judge", "B2/true", frame_with(lambda2=2.0), also=("B2/answered",)),
    Fault(
        "Newton stops at once and nothing follows",
        "B2/answered",
        together(
            candidate_of(Newton, halved_penalties),
            replaced(solving, "_escalate", lambda problem, answer: answer),
        ),
    ),
    Fault("Gram matrices in single precision", "B2/batch", reduction_with(single_precision)),
    Fault("u of a batch is half as large", "B2/batch", wrapped(Answers, "u", lambda u, *a: 0.5 * u)),
    Fault("a proved label exchanged", "B4/label", decided(swapped_label), also=("B4/tie",)),
    Fault("identical templates told apart", "B4/tie", decided(guessed), also=("R1/separated", "B4/label")),
    Fault("a lowest template called a tie", "R1/separated", decided(called_tie)),
    Fault(
        "red and blue exchanged",
        "B5/histogram",
        wrapped(color, "color_histogram", lambda h, *a: h.reshape(3, -1)[::-1].ravel()),
    ),
    Fault("HOG in single precision", "B5/hog", wrapped(hog, "hog_descriptor", lambda h, *a: np.float32(h))),
    Fault(
        "LBP of gray values in 16 levels",
        "B5/lbp",
        replaced(lbp, "lbp_histogram", lbp_of_levels),
    ),
    Fault(
        "blocks of colour and texture exchanged",
        "B5/partition",
        wrapped(extraction, "extract", lambda X, images, c: exchanged(X, c)),
    ),
)


SOLVERS = (
    Fault(
        "Clarabel's value off by 1e-4",
        "S1/optimal",
        wrapped(raw, "raw", lambda found, *a: replace(found, value=found.value and found.value * 1.0001)),
    ),
)

COST = (
    Fault("Woodbury's identity not used", "C1/woodbury", replaced(cost, "woodbury", cost.step7)),
    Fault("nothing is reduced", "C1/reduction", replaced(cost.Iterate, "reduced", lambda self: self)),
)

FAULTS = FORMULATION + DERIVATION + LIBRARY + SOLVERS
"""Faults that a check on problems must see; those of `COST` show in `verification.cost`."""
