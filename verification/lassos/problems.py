"""Random and degenerate problems of the lasso family, with an answer each, from a seed and a number alone.

The objective of each problem is written down here a second time, in exact numbers, from the formula that the
convention stands for: nothing of `convexperc.lasso` is used.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.lassos.descent import descend
from verification.lassos.objective import Exact

ROOT_DIGITS = 10**60
"""Square roots of group sizes are taken to this many digits; the exact objective is defined by these."""
DATA = ("random", "equal columns", "zero column", "opposite columns", "constant column", "integers", "y = 0",
        "y fitted", "one sample", "wide")  # fmt: skip
ANSWERS = ("solved", "stopped", "near", "rounded", "zero", "nonsense", "huge")
ALPHAS = ("usual", "small", "at the maximum", "beyond the maximum", "zero", "tiny")
SCALES = (0, 0, 0, 0, 1, -1, 9, -9, 40, -40)
"""Decimal exponents of X and of y."""


@dataclass(frozen=True)
class Shape:
    """How a convention's strengths become coefficients.

    Attributes
    ----------
    mean : bool
        Whether the loss is a mean; a sum otherwise.
    halved : bool
        Whether it is divided by 2.
    ratio, weights, groups, samples, second : bool
        Whether there is l1_ratio, weights, groups, sample_weight, l1_reg.
    rooted : bool
        Whether groups that are given no weights have the square roots of their sizes.
    """

    mean: bool = True
    halved: bool = True
    ratio: bool = True
    weights: bool = True
    groups: bool = True
    samples: bool = True
    second: bool = False
    rooted: bool = False


SHAPES = {
    "scikit-learn": Shape(weights=False, groups=False),
    "scikit-learn ridge": Shape(mean=False, halved=False, ratio=False, weights=False, groups=False),
    "glmnet": Shape(groups=False),
    "celer": Shape(samples=False),
    "skglm": Shape(),
    "adelie": Shape(rooted=True),
    "asgl": Shape(halved=False, weights=False, samples=False, rooted=True),
    "group-lasso": Shape(ratio=False, samples=False, second=True, rooted=True),
    "residual sum of squares": Shape(mean=False, halved=False),
}


@dataclass(frozen=True, eq=False)
class Drawn:
    """A problem with an answer, as `certify_lasso` takes it, and the same in exact numbers.

    Attributes
    ----------
    X : float64 (n, p)
    y : float64 (n,)
    coef : float64 (p,)
    alpha : float
    options : dict
        All that is given by name; of numbers, lists and arrays.
    sparse : bool
        Whether X is to be given as a sparse matrix.
    exact : Exact
    kind : str
        Convention, data, strength and answer.
    """

    X: NDArray[np.float64]
    y: NDArray[np.float64]
    coef: NDArray[np.float64]
    alpha: float
    options: dict[str, Any]
    sparse: bool
    exact: Exact
    kind: str


def draw(seed: int, index: int) -> Drawn:
    """Draw problem number `index` of the stream of a seed."""
    rng = np.random.default_rng([seed, index])
    name = str(rng.choice(list(SHAPES)))
    shape, data, answer = SHAPES[name], str(rng.choice(DATA)), str(rng.choice(ANSWERS))
    X, y = _data(rng, data)
    n, p = X.shape
    options: dict[str, Any] = {"convention": name, "positive": bool(rng.random() < 0.25)}
    if shape.groups and rng.random() < 0.6:
        options["groups"] = rng.integers(0, max(1, p // 2), p).tolist()
    if shape.weights and ("groups" in options or not shape.second) and rng.random() < 0.4:
        count = len(set(options["groups"])) if "groups" in options else p
        options["weights"] = _weights(rng, count)
    if shape.samples and rng.random() < 0.3:
        options["sample_weight"] = _weights(rng, n)
    if shape.ratio and not _plain_groups(name, options):
        options["l1_ratio"] = float(rng.choice([0.0, 0.25, 0.5, 0.9, 1.0, 1.0]))
    if shape.second:
        options["l1_reg"] = float(rng.choice([0.0, 0.05, 0.5]))
    strength, wanted = str(rng.choice(ALPHAS)), bool(rng.random() < 0.6)
    alpha = _alpha(strength, X, y, shape, wanted)
    exact = _exact(X, y, alpha, shape, options, wanted)
    coef, b0 = _answer(rng, answer, exact)
    if wanted:
        options["intercept"] = b0
    kind = f"{name}, {'groups' if 'groups' in options else 'columns'}, {data}, alpha {strength}, {answer}"
    return Drawn(X, y, coef, alpha, options, bool(rng.random() < 0.2), exact, kind)


def _plain_groups(name: str, options: dict[str, Any]) -> bool:
    """Whether a ratio means nothing: groups alone are penalised, by their norms; or, for asgl, no groups."""
    if name == "asgl":
        return "groups" not in options
    return "groups" in options and name != "adelie"


def _data(rng: np.random.Generator, data: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    n, p = int(rng.integers(2, 8)), int(rng.integers(1, 6))
    if data == "one sample":
        n = 1
    if data == "wide":
        n, p = int(rng.integers(2, 4)), int(rng.integers(5, 8))
    X, y = rng.standard_normal((n, p)), rng.standard_normal(n) + rng.choice([0.0, 2.0])
    one, other = rng.integers(0, p, 2)
    if data == "equal columns":
        X[:, one] = X[:, other]
    elif data == "opposite columns":
        X[:, one] = -2.0 * X[:, other]
    elif data == "zero column":
        X[:, one] = 0.0
    elif data == "constant column":
        X[:, one] = rng.choice([1.0, 0.7, -3.0])
    elif data == "integers":
        X, y = np.round(2.0 * X), np.round(3.0 * y)
    elif data == "y = 0":
        y = np.zeros(n)
    elif data == "y fitted":
        y = X @ rng.integers(-2, 3, p)
    return X * 10.0 ** rng.choice(SCALES), y * 10.0 ** rng.choice(SCALES)


def _weights(rng: np.random.Generator, count: int) -> list[float]:
    found = rng.choice([0.0, 0.5, 1.0, 1.0, 3.0, 0.1], count)
    return [float(each) for each in (found if found.any() else np.ones(count))]


def _alpha(
    strength: str, X: NDArray[np.float64], y: NDArray[np.float64], shape: Shape, centred: bool
) -> float:
    """A strength beside the least one at which a plain lasso of these data is 0."""
    target = y - y.mean() if centred else y
    most = float(np.abs(X.T @ target).max()) * (1.0 if shape.halved else 2.0)
    most = most / len(y) if shape.mean else most
    factor = {"usual": 0.2, "small": 1e-3, "at the maximum": 1.0, "beyond the maximum": 4.0, "zero": 0.0,
              "tiny": 1e-9}  # fmt: skip
    return (most or 1.0) * factor[strength]


def _root(size: int) -> Fraction:
    return Fraction(isqrt(size * ROOT_DIGITS**2), ROOT_DIGITS)


def _exact(
    X: NDArray[np.float64],
    y: NDArray[np.float64],
    alpha: float,
    shape: Shape,
    options: dict[str, Any],
    intercept: bool,
) -> Exact:
    """The objective of a convention, in exact numbers."""
    n, p = X.shape
    name, a, ratio = options["convention"], Fraction(alpha), Fraction(options.get("l1_ratio", 1.0))
    samples = [Fraction(w) for w in options.get("sample_weight", [1.0] * n)]
    factor = (Fraction(1) if shape.halved else Fraction(2)) / (sum(samples) if shape.mean else 1)
    labels = options.get("groups")
    members = [] if labels is None else [
        [j for j in range(p) if labels[j] == label] for label in sorted(set(labels))
    ]  # fmt: skip
    given = options.get("weights")
    if given is None:
        weights = [_root(len(group)) if shape.rooted else Fraction(1) for group in members] or [
            Fraction(1)
        ] * p
    else:
        weights = [Fraction(w) for w in given]
    if name == "glmnet":
        weights = [w * p / sum(weights) for w in weights]
    none = [Fraction(0)] * p
    l1, ridge, groups = list(none), list(none), list[tuple[list[int], Fraction]]()
    second = Fraction(options.get("l1_reg", 0.0))
    if name == "scikit-learn ridge":
        ridge = [2 * a] * p
    elif labels is None:
        l1 = [a * w * ratio + second for w in weights]
        ridge = [a * w * (1 - ratio) for w in weights] if name not in ("asgl", "group-lasso") else none
    elif name == "asgl":
        l1 = [a * ratio] * p
        groups = [(each, a * (1 - ratio) * w) for each, w in zip(members, weights, strict=True)]
    else:
        share = ratio if name == "adelie" else Fraction(1)
        l1 = [second] * p
        groups = [(each, a * share * w) for each, w in zip(members, weights, strict=True)]
        for each, w in zip(members, weights, strict=True):
            for j in each:
                ridge[j] = a * (1 - share) * w
    return Exact(
        [[Fraction(x) for x in row] for row in X.tolist()], [Fraction(v) for v in y.tolist()],
        [factor * w for w in samples], l1, ridge, groups, intercept, options["positive"],
    )  # fmt: skip


def _answer(rng: np.random.Generator, answer: str, exact: Exact) -> tuple[NDArray[np.float64], float]:
    """An answer of some quality; the descent is this module's own, and nothing depends on how good it is."""
    p = len(exact.l1)
    size = 1.0
    if answer not in ("zero", "nonsense", "huge"):
        b, b0 = descend(exact, sweeps=2 if answer == "stopped" else 60)
        if answer == "near":
            size = 10.0 ** float(rng.integers(-12, -1))
            b, b0 = b * (1.0 + size * rng.standard_normal(p)), b0 * (1.0 + size)
        elif answer == "rounded":
            mantissas, exponents = np.frexp(b)
            b = np.ldexp(mantissas.astype(np.float32).astype(np.float64), exponents)
    else:
        size = {"zero": 0.0, "nonsense": 1.0, "huge": 1e12}[answer]
        b, b0 = size * rng.standard_normal(p), size * float(rng.standard_normal())
    return np.abs(b) if exact.positive and rng.random() < 0.9 else b, b0
