"""Families of problems by name, random and degenerate, each defined once for every source of numbers.

A family draws what it needs from a `Source`: a seeded generator (fast, for campaigns) or Hypothesis
(`verification.problems.strategies`, which shrinks).
"""

import zlib
from collections.abc import Callable

import numpy as np

from convexperc.problem.arrays import Matrix
from convexperc.problem.problem import Problem
from verification.problems.sources import Draft, Seeded, Source, draft

SMALLEST_SUBNORMAL = 5e-324
NEAREST, FARTHEST = 20, 53
"""A near-duplicate row differs by 2^-20 .. 2^-53 of each entry: up to the last bit of float64."""


def random(source: Source) -> Draft:
    """Nothing special; n > d may occur."""
    return draft(source)


def recognition(source: Source) -> Draft:
    """As the paper's data: non-negative, each modality of a row of unit length, o a noisy mix of rows."""
    p = draft(source)
    p.X = np.abs(p.X)
    stops = np.cumsum(p.sizes)
    for start, stop in zip(stops - p.sizes, stops, strict=True):
        norms = np.linalg.norm(p.X[:, start:stop], axis=1, keepdims=True)
        p.X[:, start:stop] /= np.where(norms > 0, norms, 1.0)
    p.o = p.X.mean(axis=0) + 0.125 * p.o
    return p


def zero_row(source: Source) -> Draft:
    """One of several robots saw nothing."""
    p = draft(source, least_n=2)
    p.X[source.integer(0, p.X.shape[0] - 1)] = 0.0
    return p


def zero_modality(source: Source) -> Draft:
    """One of several modalities is 0 for every robot."""
    p = draft(source, d=source.integer(2, source.largest[1]))
    if len(p.sizes) == 1:
        p.sizes = [p.sizes[0] // 2, p.sizes[0] - p.sizes[0] // 2]
    p.X[:, : p.sizes[0]] = 0.0
    return p


def zero_data(source: Source) -> Draft:
    """X = 0."""
    p = draft(source)
    p.X[:] = 0.0
    return p


def duplicate_rows(source: Source) -> Draft:
    """Two robots saw the same."""
    p = draft(source, least_n=2)
    p.X[0] = p.X[1]
    return p


def near_duplicate_rows(source: Source) -> Draft:
    """Two robots saw the same up to 2^-20 .. 2^-53 of each entry."""
    p = draft(source, least_n=2)
    signs = np.sign(source.matrix(1, p.X.shape[1])[0])
    p.X[0] = p.X[1] * (1.0 + 2.0 ** -source.integer(NEAREST, FARTHEST) * signs)
    return p


def rank_deficient(source: Source) -> Draft:
    """Half of the rows are exact integer combinations of the others; entries are multiples of 2^-20."""
    p = draft(source, least_n=2)
    p.X = np.round(p.X * 2.0**20) / 2.0**20
    _mix_rows(source, p.X)
    return p


def nearly_rank_deficient(source: Source) -> Draft:
    """Half of the rows are integer combinations of the others, rounded: full rank by rounding alone."""
    p = draft(source, least_n=2)
    _mix_rows(source, p.X)
    return p


def _mix_rows(source: Source, X: Matrix) -> None:
    n = X.shape[0]
    k = max(1, n // 2)
    X[k:] = np.array([[float(source.integer(-2, 2)) for _ in range(k)] for _ in range(n - k)]) @ X[:k]


def zero_target(source: Source) -> Draft:
    """The target o is 0, so that F* = 0."""
    p = draft(source)
    p.o[:] = 0.0
    return p


def target_in_span(source: Source) -> Draft:
    """The target is a combination of the rows, so that the loss alone can reach 0 (up to rounding)."""
    p = draft(source)
    coefficients = np.array([float(source.integer(-2, 2)) for _ in range(p.X.shape[0])])
    p.o = p.X.T @ (coefficients if coefficients.any() else coefficients + 1.0)
    return p


def orthogonal_target(source: Source) -> Draft:
    """X o = 0, so that w = u = 0 is optimal."""
    p = draft(source, d=source.integer(2, source.largest[1]))
    half = p.X.shape[1] // 2
    p.X[:, half:] = 0.0
    p.o[:half] = 0.0
    return p


def lambda_above_critical(source: Source) -> Draft:
    """lambda2 at or above 2 max |X o|, where w = 0 begins to be optimal."""
    p = draft(source)
    p.lambdas[1] = 2.0 * float(np.abs(p.X @ p.o).max()) * source.choice((1.0, 1.0 + 1e-15, 1.5, 100.0))
    return p


def one_view(source: Source) -> Draft:
    """A single robot, n = 1."""
    return draft(source, n=1)


def more_views_than_features(source: Source) -> Draft:
    """More robots than features, n > d."""
    largest_n, largest_d = source.largest
    n = source.integer(2, largest_n)
    return draft(source, n=n, d=source.integer(1, min(n - 1, largest_d)))


def one_column_modalities(source: Source) -> Draft:
    """As many modalities as columns: the modality norm is the l1-norm."""
    return draft(source, sizes=[1] * source.integer(1, min(20, source.largest[1])))


def subnormal_entries(source: Source) -> Draft:
    """Some entries of X and o are the smallest subnormal number."""
    p = draft(source)
    p.X[source.matrix(*p.X.shape) < -0.5] = SMALLEST_SUBNORMAL
    p.o[source.matrix(1, p.o.size)[0] < 0.5] = SMALLEST_SUBNORMAL
    return p


def scaled_rows(source: Source) -> Draft:
    """Each row by its own power of ten, 1e-6 .. 1e6."""
    p = draft(source)
    p.X *= np.array([[10.0 ** source.integer(-6, 6)] for _ in range(p.X.shape[0])])
    return p


def mixed_scales(source: Source) -> Draft:
    """Entries of one X from 5e-324 to 1e150, and lambdas from 1e-150 to 1e150."""
    p = draft(source)
    decades = (0, 8, -8, 150, -150, -300, -323)
    p.X *= np.array([10.0 ** source.choice(decades) for _ in p.X.flat]).reshape(p.X.shape)
    p.o *= 10.0 ** source.integer(-150, 150)
    p.lambdas = [weight * 10.0 ** source.choice((0, 8, -8, 150, -150)) for weight in p.lambdas]
    return p


def nearly_zero_view(source: Source) -> Draft:
    """Up to two robots saw 1e-8 .. 1e-300 of what the others saw; n > d and lambda3 = 0."""
    p = more_views_than_features(source)
    for _ in range(source.integer(1, 2)):
        p.X[source.integer(0, p.X.shape[0] - 1)] *= 10.0 ** -source.choice((25, 8, 100, 300))
    p.lambdas[2] = 0.0
    return p


Family = Callable[[Source], Draft]


def _without(*indices: int) -> Family:
    """These lambdas are exactly 0."""

    def family(source: Source) -> Draft:
        p = draft(source) if source.integer(0, 1) else rank_deficient(source)
        for index in indices:
            p.lambdas[index] = 0.0
        return p

    return family


def near_duplicates_without_lambdas(source: Source) -> Draft:
    """Near-duplicate rows with at least one lambda 0: least squares is discontinuous here."""
    p = near_duplicate_rows(source)
    zeros = source.integer(1, 7)
    p.lambdas = [0.0 if zeros >> i & 1 else weight for i, weight in enumerate(p.lambdas)]
    return p


def _scaled_target(decades: int) -> Family:
    """Scale o, lambda2 and lambda3 together by t = 10^-decades .. 10^decades: F scales by t^2."""

    def family(source: Source) -> Draft:
        p = draft(source)
        t = 10.0 ** source.integer(-decades, decades)
        p.o *= t
        p.lambdas = [p.lambdas[0], p.lambdas[1] * t, p.lambdas[2] * t]
        return p

    return family


def _scaled_views(decades: int) -> Family:
    """X by s, lambda1 and lambda3 by s^2, lambda2 by s: F* stays."""

    def family(source: Source) -> Draft:
        p = draft(source)
        s = 10.0 ** source.integer(-decades, decades)
        p.X *= s
        p.lambdas = [p.lambdas[0] * s * s, p.lambdas[1] * s, p.lambdas[2] * s * s]
        return p

    return family


def _scaled_data(decades: int) -> Family:
    """Scale o and X each by their own scale, with the lambdas left alone."""

    def family(source: Source) -> Draft:
        p = draft(source)
        p.o *= 10.0 ** source.integer(-decades, decades)
        p.X *= 10.0 ** source.integer(-decades, decades)
        return p

    return family


RANDOM: dict[str, Family] = {"random": random, "recognition": recognition}

ORDINARY_DEGENERATE: dict[str, Family] = {
    "zero_row": zero_row,
    "zero_modality": zero_modality,
    "zero_data": zero_data,
    "duplicate_rows": duplicate_rows,
    "near_duplicate_rows": near_duplicate_rows,
    "rank_deficient": rank_deficient,
    "nearly_rank_deficient": nearly_rank_deficient,
    "zero_target": zero_target,
    "target_in_span": target_in_span,
    "orthogonal_target": orthogonal_target,
    "lambda1_zero": _without(0),
    "lambda2_zero": _without(1),
    "lambda3_zero": _without(2),
    "lambda1_lambda2_zero": _without(0, 1),
    "lambda1_lambda3_zero": _without(0, 2),
    "lambda2_lambda3_zero": _without(1, 2),
    "all_lambdas_zero": _without(0, 1, 2),
    "near_duplicates_without_lambdas": near_duplicates_without_lambdas,
    "lambda_above_critical": lambda_above_critical,
    "one_view": one_view,
    "more_views_than_features": more_views_than_features,
    "one_column_modalities": one_column_modalities,
    "subnormal_entries": subnormal_entries,
    "scaled_rows": scaled_rows,
    "scaled_target": _scaled_target(8),
    "scaled_views": _scaled_views(8),
    "scaled_data": _scaled_data(8),
}

EXTREME: dict[str, Family] = {
    "extreme_target": _scaled_target(150),
    "extreme_views": _scaled_views(150),
    "extreme_data": _scaled_data(150),
    "mixed_scales": mixed_scales,
    "nearly_zero_view": nearly_zero_view,
}

DEGENERATE: dict[str, Family] = ORDINARY_DEGENERATE | EXTREME
FAMILIES: dict[str, Family] = RANDOM | DEGENERATE


ZERO: dict[str, frozenset[str]] = {
    "zero_data": frozenset({"X"}),
    "zero_target": frozenset({"o"}),
    "lambda1_zero": frozenset({"lambda1"}),
    "lambda2_zero": frozenset({"lambda2"}),
    "lambda3_zero": frozenset({"lambda3"}),
    "lambda1_lambda2_zero": frozenset({"lambda1", "lambda2"}),
    "lambda1_lambda3_zero": frozenset({"lambda1", "lambda3"}),
    "lambda2_lambda3_zero": frozenset({"lambda2", "lambda3"}),
    "all_lambdas_zero": frozenset({"lambda1", "lambda2", "lambda3"}),
    "near_duplicates_without_lambdas": frozenset({"lambda1", "lambda2", "lambda3"}),
    "nearly_zero_view": frozenset({"lambda3"}),
}
"""What a family makes 0 by its definition; every other part of its problems may be 0 by chance alone."""


def zero_parts(problem: Problem) -> frozenset[str]:
    """Which of X, o and the lambdas are 0."""
    parts = {"X": bool(problem.X.any()), "o": bool(problem.o.any())}
    parts |= {f"lambda{k}": value != 0.0 for k, value in enumerate(problem.lambdas, 1)}
    return frozenset(name for name, value in parts.items() if not value)


def is_trivial(problem: Problem, family: str) -> bool:
    """Whether more is 0 than the family's definition asks for, so that the problem says little of it."""
    return not zero_parts(problem) <= ZERO.get(family, frozenset())


def seeded(family: str, seed: int, index: int, *, largest: tuple[int, int] = (8, 60)) -> Problem:
    """Return problem number `index` of a family's stream `seed`; the same at every call.

    Parameters
    ----------
    family : str
        A key of `FAMILIES`.
    seed, index : int
        Both >= 0.
    largest : (int, int)
        Largest n and largest d.

    Returns
    -------
    Problem
    """
    rng = np.random.default_rng([seed, index, zlib.crc32(family.encode())])
    return FAMILIES[family](Seeded(rng, largest)).problem()
