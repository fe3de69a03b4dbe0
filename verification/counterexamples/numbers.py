"""Counterexamples that are single comparisons: inequalities, derivatives, optima, ties, operation counts."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from convexperc.errors import FileFormatError
from verification.checks.operations import eliminate
from verification.counterexamples.confirmation import Confirmation, Side, minus, point, shown, text
from verification.counterexamples.loops import the_problem
from verification.counterexamples.record import Record, numbers_of
from verification.exact.formulation import norms, objective, residuals
from verification.exact.numbers import Enclosure, Rational, inner, squares
from verification.exact.optimality import is_optimal
from verification.exact.problem import ExactProblem

EXPONENT_SLACK = Fraction(1, 2)
"""Beyond the claimed exponent; it makes the growth from n to 2n a comparison of whole numbers."""


def confirm_inequality(record: Record) -> Confirmation:
    """The two sides of a claimed relation between vectors, or of two objectives at a point."""
    relation = record.fields["relation"]
    if relation == "l1-analogue":
        v, t = (numbers_of(record, record.fields[name], name) for name in "vt")
        left, right = _one(t) - squares(t) / (2 * _one(v)), _one(v) - squares(v) / (2 * _one(v))
        return _compared(("the left side", left), ("the right side", right), fails=left > right, sign=">")
    if relation == "substitution":
        v, w = (numbers_of(record, record.fields[name], name) for name in "vw")
        left = sum((x * x / (2 * abs(y)) for x, y in zip(w, v, strict=True)), Fraction(0))
        right = squares(w) / (2 * _one(v))
        return _compared(("w'D w", left), ("||w||^2/(2||v||_1)", right), fails=left != right, sign="!=")
    if relation == "appendix-objective":
        problem, (w, u) = the_problem(record), _point(record, record.fields)
        _, q = residuals(problem, w, u)
        ours = objective(problem, w, u)
        theirs = minus(ours, point((problem.lambda1 - 1) * squares(q)))
        apart = theirs.lower > ours.upper or theirs.upper < ours.lower
        return _sides(("the objective of the appendix", theirs), ("F of Eq. (full)", ours), apart, "!=")
    known = "l1-analogue, substitution, appendix-objective"
    raise FileFormatError(f"{record.id}: relation", value=relation, must=f"must be one of {known}")


def confirm_derivative(record: Record) -> Confirmation:
    """The printed derivative lies outside what the difference quotients of the convex F allow.

    Formula: (F(z) - F(z - h e))/h <= dF/de <= (F(z + h e) - F(z))/h for every h > 0, as F is convex.
    """
    problem, (w, u) = the_problem(record), _point(record, record.fields)
    (h,) = numbers_of(record, [record.fields["h"]], "h")
    name, index = record.fields["variable"]["name"], int(record.fields["variable"]["index"])
    shift = [h if k == index else Fraction(0) for k in range(len(w if name == "w" else u))]

    def moved(sign: int) -> Enclosure:
        change = [sign * x for x in shift]
        if name == "w":
            return objective(problem, tuple(x + c for x, c in zip(w, change, strict=True)), u)
        return objective(problem, w, tuple(x + c for x, c in zip(u, change, strict=True)))

    here = objective(problem, w, u)
    low, high = minus(here, moved(-1)).lower / h, minus(moved(1), here).upper / h
    printed = _printed_w(problem, w, u, index) if name == "w" else _printed_u(problem, w, u, index)
    true = Enclosure(low, high)
    outside = printed.upper < low or printed.lower > high
    symbol = f"dF/d{name}_{index + 1}"
    found = {"printed": text(printed), "derivative": text(true)}
    finding = (
        f"{symbol} lies in [{shown(point(low))}, {shown(point(high))}]; as printed it is {shown(printed)}"
    )
    return Confirmation(outside, finding, found, sides=(Side("as printed", printed), Side(symbol, true)))


def _printed_w(problem: ExactProblem, w: Rational, u: Rational, j: int) -> Enclosure:
    p, q = residuals(problem, w, u)
    smooth = 2 * inner(problem.X[j], p) - 2 * problem.lambda1 * q[j]
    return point(smooth + problem.lambda2 * w[j] / (2 * w[j]))


def _printed_u(problem: ExactProblem, w: Rational, u: Rational, k: int) -> Enclosure:
    _, q = residuals(problem, w, u)
    smooth = 2 * problem.lambda1 * inner(problem.columns[k], q)
    size = norms(problem, u)[next(i for i, group in enumerate(problem.groups) if k in group)]
    ends = sorted(smooth + problem.lambda3 * u[k] / (2 * end) for end in (size.lower, size.upper))
    return Enclosure(*ends)


def confirm_similarity(record: Record) -> Confirmation:
    """With one view, u^i at the optimum is a multiple of the data whatever lambda3 > 0 is: no more similar.

    Every optimum has the same u here: u^i = -(||u^i||/lambda3) X_i'b with a number b, as n = 1.
    """
    problem, weights, spreads, proved = the_problem(record), [], [], True
    for optimum in record.fields["optima"]:
        (lambda3,) = numbers_of(record, [optimum["lambda3"]], "lambda3")
        w, u = _point(record, optimum)
        posed = replace(problem, lambda3=lambda3)
        proved = proved and problem.n == 1 and all(u) and is_optimal(posed, w, u)
        weights.append(lambda3)
        spreads.append(max(map(abs, u)) / min(map(abs, u)) if all(u) else Fraction(0))
    never_falls = all(x < y for x, y in pairwise(weights)) and all(x <= y for x, y in pairwise(spreads))
    found = {"spread": [str(x) for x in spreads]}
    pairs = ", ".join(f"{s} at lambda3 = {x}" for s, x in zip(spreads, weights, strict=True))
    sides = tuple(
        Side(f"max |u_k| / min |u_k| at lambda3 = {x}", point(s))
        for x, s in zip(weights, spreads, strict=True)
    )
    finding = f"the spread within the modality does not fall: {pairs}"
    if not proved:
        finding = "a stated optimum is not optimal"
    return Confirmation(proved and never_falls and len(spreads) > 1, finding, found, sides=sides)


def confirm_tie(record: Record) -> Confirmation:
    """All templates have the same optimum, each proved by its subgradients: no label has the lowest."""
    problem, values, proved = the_problem(record), [], True
    for template in record.fields["templates"]:
        posed = problem.for_template(numbers_of(record, template["o"], "o"))
        w, u = _point(record, template)
        proved = proved and is_optimal(posed, w, u)
        values.append(objective(posed, w, u))
    tied = len(values) > 1 and all(each.width == 0 and each == values[0] for each in values)
    sides = tuple(
        Side(f"F* of o = ({', '.join(template['o'])})", each)
        for template, each in zip(record.fields["templates"], values, strict=True)
    )
    finding = f"{len(values)} templates, each with F* = {shown(values[0])} exactly"
    if not proved:
        finding = "a stated optimum is not optimal"
    return Confirmation(proved and tied, finding, {"F_star": [text(each) for each in values]}, sides=sides)


def confirm_exponent(record: Record) -> Confirmation:
    """From each size to its double the count grows by more than 2^(claimed + 1/2)."""
    sizes, claimed = [int(n) for n in record.fields["sizes"]], int(record.fields["claimed"])
    counts = [eliminate(n) for n in sizes]
    doubling = len(sizes) > 1 and all(large == 2 * small for small, large in pairwise(sizes))
    power = int(2 * (claimed + EXPONENT_SLACK))
    steep = all(large**2 > 2**power * small**2 for small, large in pairwise(counts))
    named = ", ".join(f"{count} at {n}" for n, count in zip(sizes, counts, strict=True))
    sides = tuple(Side(f"multiplications at size {n}", point(c)) for n, c in zip(sizes, counts, strict=True))
    finding = f"multiplications: {named}; each doubling takes more than 2^{claimed + 0.5} times as many"
    return Confirmation(doubling and steep, finding, {"counts": [str(c) for c in counts]}, sides=sides)


def _one(values: Rational) -> Fraction:
    return sum((abs(x) for x in values), Fraction(0))


def _point(record: Record, data: Any) -> tuple[Rational, Rational]:
    return numbers_of(record, data["w"], "w"), numbers_of(record, data["u"], "u")


def _compared(
    left: tuple[str, Fraction], right: tuple[str, Fraction], *, fails: bool, sign: str
) -> Confirmation:
    return _sides((left[0], point(left[1])), (right[0], point(right[1])), fails, sign)


def _sides(left: tuple[str, Enclosure], right: tuple[str, Enclosure], fails: bool, sign: str) -> Confirmation:
    found = {"left": text(left[1]), "right": text(right[1])}
    word = {">": "exceeds", "!=": "is not"}[sign] if fails else "agrees with"
    finding = f"{left[0]}, {shown(left[1])}, {word} {right[0]}, {shown(right[1])}"
    return Confirmation(fails, finding, found, sides=(Side(*left), Side(*right)))
