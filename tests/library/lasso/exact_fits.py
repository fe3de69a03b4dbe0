"""Penalised least squares in exact numbers, and an independent solver, for tests of `convexperc.lasso`."""

import warnings
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt

import cvxpy as cp
import numpy as np

DIGITS = 10**40


@dataclass(frozen=True)
class Fit:
    """(K/2) ||y - X b - b0||^2 + l ||b||_1 + sum_g c_g ||b_g|| + (r/2) ||b||^2, in exact numbers."""

    X: np.ndarray
    y: np.ndarray
    K: Fraction
    l1: Fraction
    group: dict[int, Fraction]
    ridge: Fraction
    labels: np.ndarray | None = None
    positive: bool = False

    def value(self, b, b0: float) -> tuple[Fraction, Fraction]:
        """Bounds of the objective, 1e-40 apart for each group."""
        b = [Fraction(float(x)) for x in b]
        total = Fraction(0)
        for row, target in zip(self.X.tolist(), self.y.tolist(), strict=True):
            fitted = sum((Fraction(x) * c for x, c in zip(row, b, strict=True) if c), Fraction(float(b0)))
            total += (Fraction(target) - fitted) ** 2
        total = total * self.K / 2 + self.l1 * sum(map(abs, b), Fraction(0))
        total += self.ridge / 2 * sum((x * x for x in b), Fraction(0))
        low = high = total
        for label, weight in self.group.items():
            square = sum((b[j] ** 2 for j in np.flatnonzero(self.labels == label)), Fraction(0))
            root = isqrt(square.numerator * DIGITS**2 // square.denominator)
            low += weight * Fraction(root, DIGITS)
            high += weight * Fraction(root + 1, DIGITS) if square else Fraction(0)
        return low, high

    def solved(self, intercept: bool) -> tuple[np.ndarray, float]:
        """By CVXPY and Clarabel."""
        p = self.X.shape[1]
        b, b0 = cp.Variable(p), cp.Variable() if intercept else 0.0
        parts = float(self.K) / 2 * cp.sum_squares(self.y - self.X @ b - b0) + float(self.l1) * cp.norm1(b)
        parts += float(self.ridge) / 2 * cp.sum_squares(b)
        for label, weight in self.group.items():
            parts += float(weight) * cp.norm2(b[np.flatnonzero(self.labels == label)])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it may be inaccurate: it is judged
            cp.Problem(cp.Minimize(parts), [b >= 0] if self.positive else []).solve(
                solver=cp.CLARABEL, tol_gap_abs=1e-12, tol_gap_rel=1e-12, tol_feas=1e-12
            )
        found = np.asarray(b.value, dtype=float)
        return np.maximum(found, 0.0) if self.positive else found, float(b0.value) if intercept else 0.0
