"""Faults in F and its terms, in its derivatives, and in the lemmas of the proof."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from convexperc.certificate import lambda_max as critical
from convexperc.problem import formulation as objective
from convexperc.problem.problem import Problem
from convexperc.solvers.paper import systems as paper_systems
from convexperc.solvers.paper.variants import ABSOLUTE, CORRECTED
from verification.checks import lemmas
from verification.exact import formulation as exact
from verification.exact.numbers import Enclosure, square_root, squares
from verification.faults.fault import Fault, Plant, everywhere, replaced, wrapped


def terms_with(change: Callable[..., dict[str, float]]) -> Plant:
    """Change some of the library's terms of F."""
    return wrapped(objective, "terms", lambda found, p, w, u: replace(found, **change(found, p, w, u)))


def views_by(size: Callable[[Any], Any]) -> Plant:
    """Another size of w than ||w||_1."""
    return terms_with(lambda f, p, w, u: {"view_norm": p.lambda2 * float(size(w))})


def modalities_by(size: Callable[[Problem, Any], Any]) -> Plant:
    """Another size of u than ||u||_M."""
    return terms_with(lambda f, p, w, u: {"modality_norm": p.lambda3 * float(size(p, u))})


def single(values: Any) -> Any:
    """Round to single precision."""
    return np.asarray(values, dtype=np.float32).astype(np.float64)


def _turned_coupling(problem: Problem, w: Any, u: Any) -> Any:
    """Xu + w where Xu - w is asked for."""
    return problem.X.T @ w - problem.o, problem.X @ u + w


def _half_of_corrected(name: str) -> Plant:
    """Give lambda / 2 where the corrected derivative is asked for."""
    original = getattr(paper_systems, name)

    def derivative(problem: Problem, reading: Any, w: Any, u: Any) -> Any:
        return original(problem, ABSOLUTE if reading == CORRECTED else reading, w, u)

    return replaced(paper_systems, name, derivative)


def _scaled(value: Enclosure, factor: int) -> Enclosure:
    return Enclosure(value.lower / factor, value.upper / factor)


OBJECTIVE = (
    Fault(
        "the root of |w_j| in the objective",
        "F1/convex",
        views_by(lambda w: np.sqrt(np.abs(w)).sum()),
    ),
    Fault(
        "||o||^2 left out of the objective",
        "F1/bounded",
        terms_with(lambda f, p, w, u: {"loss": f.loss - 2.0 * float(p.o @ p.o)}),
    ),
    Fault(
        "lambda3 halved in the objective",
        "B1/objective",
        terms_with(lambda f, p, w, u: {"modality_norm": 0.5 * f.modality_norm}),
    ),
    Fault("Xu + w for Xu - w", "B1/objective", everywhere(objective.residuals, _turned_coupling)),
    Fault(
        "lambda1 left out of the objective",
        "B1/objective",
        terms_with(lambda f, p, w, u: {"coupling": float(((p.X @ u - w) ** 2).sum())}),
    ),
    Fault("sum of w_j for that of |w_j|", "B1/objective", views_by(np.sum)),
    Fault("l2-norm of w for its l1-norm", "B1/objective", views_by(np.linalg.norm)),
    Fault(
        "norms of the modalities squared",
        "B1/objective",
        modalities_by(lambda p, u: (p.modalities.norms(u) ** 2).sum()),
    ),
    Fault(
        "columns of the modalities shifted by one",
        "B1/objective",
        modalities_by(lambda p, u: p.modalities.norms(np.roll(u, 1)).sum()),
    ),
    Fault(
        "one norm of all u",
        "B1/objective",
        modalities_by(lambda p, u: np.linalg.norm(u)),
    ),
    Fault(
        "norms in single precision",
        "B1/objective",
        terms_with(lambda f, p, w, u: {"modality_norm": float(np.float32(f.modality_norm))}),
    ),
    Fault(
        "the l1-norm within a modality",
        "F4/parallel",
        modalities_by(lambda p, u: np.abs(u).sum()),
    ),
    Fault(
        "critical lambda2 without its factor 2",
        "F3/critical_lambda2",
        wrapped(critical, "lambda2_max", lambda found, *a: (0.5 * found[0], 0.5 * found[1])),
    ),
    Fault(
        "critical lambda3 without its factor 2",
        "F3/critical_lambda3",
        wrapped(critical, "lambda3_max", lambda found, *a: 0.5 * found),
    ),
    Fault(
        "critical lambda3 doubled",
        "F3/critical_lambda3",
        wrapped(critical, "lambda3_max", lambda found, *a: 2.0 * found),
    ),
)

DERIVATION = (
    Fault("half of lambda2 in the corrected derivative", "D1/corrected", _half_of_corrected("derivative_w")),
    Fault("half of lambda3 in the corrected derivative", "D2/corrected", _half_of_corrected("derivative_u")),
    Fault(
        "the derivative for w doubled",
        "D1/printed",
        wrapped(paper_systems, "derivative_w", lambda found, *a: 2.0 * found),
        also=("D1/corrected",),
    ),
    Fault(
        "the derivative for u doubled",
        "D2/printed",
        wrapped(paper_systems, "derivative_u", lambda found, *a: 2.0 * found),
        also=("D2/corrected",),
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
        wrapped(lemmas, "appendix", lambda value, p, w, u: _scaled(value, 2)),
    ),
    Fault(
        "the appendix's objective with lambda1 after all",
        "A1/objective",
        replaced(lemmas, "appendix", exact.objective),
    ),
    Fault(
        "the l1-form of Lemma 1 without its absolute values",
        "L2/inequality",
        wrapped(lemmas, "l1_analogue", lambda excess, t, v: -abs(excess)),
    ),
    Fault(
        "the appendix's substitution taken for the definition",
        "A2/substitution",
        replaced(lemmas, "substituted", lemmas.defined),
        also=("A2/elementwise",),
    ),
)
