"""L1, L2, A1 and A2 by cases: the lemmas and the objective of the proof, at small rational vectors."""

from collections.abc import Iterator, Sequence
from fractions import Fraction

from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation
from verification.checks.measures import drawn_point, number, share
from verification.exact.formulation import norms, objective, residuals
from verification.exact.numbers import Enclosure, Rationals, rationals, square_root, squares, total
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

Exact = Sequence[Fraction] | Rationals

ENDS = ("lower", "upper")

LARGEST = 4
"""Entries of the vectors are integers up to this, over one denominator up to this."""


def length(x: Exact) -> Enclosure:
    """||x||_2."""
    return square_root(squares(x))


def l1(x: Exact) -> Fraction:
    """||x||_1."""
    return total(abs(value) for value in x)


def lemma_one(t: Exact, v: Exact) -> Fraction:
    """Left side minus right side of Lemma 1, times 2 ||v|| > 0: 2 ||t|| ||v|| - ||t||^2 - ||v||^2.

    An upper bound, by the root of the one number ||t||^2 ||v||^2, and exact where that is a square.
    """
    return 2 * square_root(squares(t) * squares(v)).upper - squares(t) - squares(v)


def l1_analogue(t: Exact, v: Exact) -> Fraction:
    """Left side minus right side of the l1-form: (||t||_1 - ||v||_1) - (||t||^2 - ||v||^2) / (2 ||v||_1)."""
    return l1(t) - l1(v) - (squares(t) - squares(v)) / (2 * l1(v))


def elementwise(t: Exact, v: Exact) -> Fraction:
    """Left side minus right side of sum_j (|t_j| - t_j^2 / (2 |v_j|)) <= ||v||_1 / 2."""
    left = total(abs(x) - x * x / (2 * abs(y)) for x, y in zip(t, v, strict=True))
    return left - l1(v) / 2


def substituted(w: Exact, v: Exact) -> Fraction:
    """w'D^w w as the appendix has it: ||w||_2^2 / (2 ||v||_1)."""
    return squares(w) / (2 * l1(v))


def defined(w: Exact, v: Exact) -> Fraction:
    """w'D^w w with D^w = diag(1 / (2 |v_j|)), over the entries where v_j is not 0."""
    return total(x * x / (2 * abs(y)) for x, y in zip(w, v, strict=True) if y)


def observe_vectors(problem: Problem, source: Source) -> Iterator[Observation]:
    """Draw t and v; the problem gives nothing but n."""
    t, v = _vector(problem.n, source), _vector(problem.n, source)
    if not any(v):
        for part in ("L1/inequality", "L2/inequality", "L2/elementwise", "A2/substitution", "A2/elementwise"):
            yield Observation(part, Outcome.SKIPPED, detail="v = 0")
        return
    yield _lemma(t, v)
    yield _not_above("L2/inequality", l1_analogue(t, v), t, v)
    full = [x or Fraction(1) for x in v]
    yield _not_above("L2/elementwise", elementwise(t, full), t, full)
    left, right = defined(t, full), substituted(t, full)
    detail = f"w = {_text(t)}, w(i) = {_text(full)}: {left} and {right}"
    yield Observation.of("A2/substitution", left == right, share(abs(left - right), left), detail)
    yield _at_rest(v)


def _vector(n: int, source: Source) -> list[Fraction]:
    unit = Fraction(1, source.integer(1, LARGEST))
    return [source.integer(-LARGEST, LARGEST) * unit for _ in range(n)]


def _text(x: Exact) -> str:
    return f"({', '.join(map(str, x))})"


def _lemma(t: Exact, v: Exact) -> Observation:
    """Lemma 1; decided by squares where the root is open."""
    excess = lemma_one(t, v)
    shorter = 4 * squares(t) * squares(v) <= (squares(t) + squares(v)) ** 2
    held = excess <= 0 or (shorter and excess <= (squares(t) + squares(v)) / 2**100)
    detail = f"v = {_text(v)}, t = {_text(t)}: left - right = {number(excess)!r} / (2 ||v||)"
    return Observation.of("L1/inequality", held, 0.0 if held else number(excess), detail)


def _not_above(part: str, excess: Fraction, t: Exact, v: Exact) -> Observation:
    detail = f"v = {_text(v)}, t = {_text(t)}: left - right = {excess}"
    return Observation.of(part, excess <= 0, max(0.0, number(excess)), detail)


def _at_rest(v: Exact) -> Observation:
    """At w = w(i) = v: ||v||_1 / 2 by definition; the appendix agrees if at most one entry is not 0."""
    left, right = defined(v, v), substituted(v, v)
    single = sum(1 for x in v if x) <= 1
    held = left == l1(v) / 2 and (left == right) == single
    return Observation.of("A2/elementwise", held, share(abs(left - l1(v) / 2), left), f"v = {_text(v)}")


def appendix(problem: Problem, w: Exact, u: Exact) -> Enclosure:
    """||X'w - o||^2 + ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||."""
    p, q = residuals(problem, w, u)
    value, lengths = squares(p) + squares(q) + Fraction(problem.lambda2) * l1(w), norms(problem, u)
    low, high = (Fraction(problem.lambda3) * total(getattr(x, end) for x in lengths) for end in ENDS)
    return Enclosure(value + low, value + high)


def observe_objectives(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare the appendix's objective with F, with lambda1 as it is and with lambda1 = 1."""
    w, u = drawn_point(problem, source)
    one = Problem(
        problem.X, problem.o, modalities=problem.modalities,
        lambda1=1.0, lambda2=problem.lambda2, lambda3=problem.lambda3,
    )  # fmt: skip
    for part, each in (("A1/objective", problem), ("A1/lambda1_one", one)):
        stated, true = appendix(each, rationals(w), rationals(u)), objective(each, w, u)
        apart = max(stated.lower - true.upper, true.lower - stated.upper)
        detail = f"lambda1 = {each.lambda1!r}: {number(stated.lower)!r} for F = {number(true.lower)!r}"
        yield Observation.of(part, apart <= 0, share(apart, true.upper), detail)


VECTORS = ("L1/inequality", "L2/inequality", "L2/elementwise", "A2/substitution", "A2/elementwise")
CHECKS = (
    Check("vectors", VECTORS, observe_vectors, families=("random",), share=30.0, product=False),
    Check("objectives", ("A1/objective", "A1/lambda1_one"), observe_objectives, share=1.0, product=False),
)
