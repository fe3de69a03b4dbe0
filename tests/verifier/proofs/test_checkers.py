"""The checkers of single steps: what they refuse, what they do not accept, a second opinion in numbers."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from checked_arguments import checked_once

from convexperc.errors import InputError
from verification.ledger.evidence import Argument, Checker, Step
from verification.proofs.arguments import all_steps
from verification.proofs.checkers import reals
from verification.proofs.checkers.formulas import evaluate, names
from verification.proofs.checkers.matrices import SHAPES, matrix_identity
from verification.proofs.checkers.polynomials import exact, identity
from verification.proofs.checkers.reals import real
from verification.proofs.unchecked import cited, joints

INVERSE = {"E": "a matrix", "Ei": "its inverse"}


def asked(hypotheses: list[str], conclusion: str) -> Step:
    return real("x", "a gloss", hypotheses, conclusion, **dict.fromkeys(names(*hypotheses, conclusion), "x"))


def test_nothing_is_proved_of_nothing() -> None:
    assert not asked(["a > 0", "a < 0"], "a == 5").passed
    assert not asked(["a > 0"], "a > 1").passed
    assert asked(["a > 1"], "a > 0").passed


def test_unknown_is_not_a_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    hard = (["a >= 0", "b >= 0", "c >= 0"], "a**3 + b**3 + c**3 >= 3*a*b*c")
    assert asked(*hard).passed
    monkeypatch.setattr(reals, "EFFORT", 100)
    assert not asked(*hard).passed


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("says", ["sat", "unsat", "unknown"])
def test_a_step_needs_both_solvers(which: int, says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that says the same of both queries has missed one of them."""
    both = [reals.by_z3, reals.by_cvc5]
    both[which] = lambda script: says
    monkeypatch.setattr(reals, "SOLVERS", tuple(both))
    assert not asked(["a > 1"], "a > 0").passed


@pytest.mark.parametrize("solver", reals.SOLVERS)
def test_each_solver_reads_the_whole_language(solver) -> None:
    """Of every operation one formula that is true and one that is false, of each solver by itself."""
    for text, true in (
        ("abs(-a) == abs(a) and (a != 0 or not a > 0)", True),
        ("a/2 + a/2 == a and a**3 == a*a*a and -(-a) == a", True),
        ("(a < 1) != (a >= 1)", True),
        ("0 <= a <= 1 or a < 0 or 1 < a", True),
        ("abs(a) == a", False),
        ("a/2 == a", False),
        ("(a < 1) == (a >= 1)", False),
    ):
        script = reals._script(("a",), [reals._Smt().negation(evaluate(text, reals._Smt()))])
        assert solver(script) == ("unsat" if true else "sat"), text


def test_an_argument_needs_a_machine() -> None:
    words = (cited("x", "anything", "somebody"), *joints("sums"))
    assert not Argument("F1/bounded", "", "", words).passed
    assert not Argument("F1/bounded", "", "", (*words, exact("y", "", "1 == 2", ""))).passed
    assert Argument("F1/bounded", "", "", (*words, exact("y", "", "1 == 1", ""))).passed


@pytest.mark.parametrize(
    ("check", "words"),
    [
        (lambda: identity("x", "", "a +", "b", a="a"), "must be a formula"),
        (lambda: identity("x", "", "abs(a)", "a", a="a"), "must not stand in an identity"),
        (lambda: identity("x", "", "1/(a - a)", "a", a="a"), "not 0"),
        (lambda: identity("x", "", "a**b", "a", a="a", b="b"), "powers by positive integers"),
        (lambda: identity("x", "", "f(a)", "a", a="a", f="f"), "must not hold"),
        (lambda: exact("x", "", "a == 1", ""), "numbers only"),
        (lambda: exact("x", "", "1/0 == 1", ""), "must not divide by 0"),
        (lambda: real("x", "", [], "1/a > 0", a="a"), "multiply it out"),
        (lambda: real("x", "", [], "a in b", a="a", b="b"), "must compare"),
        (lambda: matrix_identity("x", "", "X*w", "w"), "fit"),
        (lambda: matrix_identity("x", "", "X + w", "w"), "one shape"),
        (lambda: matrix_identity("x", "", "X*u", "u"), "one shape on both sides"),
        (lambda: matrix_identity("x", "", "w/l", "w", l="l"), "multiply it out"),
    ],
)
def test_what_is_no_formula_is_refused(check, words: str) -> None:
    with pytest.raises(InputError, match=words):
        check()


def test_letters_do_not_commute() -> None:
    assert not matrix_identity("x", "", "A*X*B", "X*B").passed
    assert not matrix_identity("x", "", "X*X.T*A", "A*X*X.T").passed
    assert not matrix_identity("x", "", "E*B*Ei", "B", **INVERSE).passed
    assert matrix_identity("x", "", "E*Ei*B", "B", **INVERSE).passed
    assert matrix_identity("x", "", "(A*X).T", "X.T*A").passed
    assert matrix_identity("x", "", "w.T*X*u", "u.T*X.T*w").passed


class Sizes:
    """Random integer matrices for the letters; a second opinion on what the words say."""

    def __init__(self, seed: int, n: int, d: int) -> None:
        rng, sizes = np.random.default_rng(seed), {"n": n, "d": d, "1": 1}
        draw = {name: rng.integers(-4, 5, (sizes[r], sizes[c])) for name, (r, c) in SHAPES.items()}
        draw |= {name: draw[name] + draw[name].T for name in ("P", "R")}
        diagonals = {name: np.diag(rng.integers(1, 5, draw[name].shape[0])) for name in ("A", "B", "E")}
        units = {"In": np.eye(n, dtype=int), "Id": np.eye(d, dtype=int)}
        inverse = {"Ei": np.diag([Fraction(1, int(x)) for x in np.diag(diagonals["E"])])}
        self.values = {k: v.astype(object) for k, v in {**draw, **diagonals, **units, **inverse}.items()}
        self.rng = rng

    def name(self, name: str):
        return self.values.setdefault(name, Fraction(int(self.rng.integers(1, 6)), 3))

    def number(self, value: int) -> Fraction:
        return Fraction(value)

    def divide(self, left, right):
        return left * (1 / right)


class Matmul:
    """`*` as the product of matrices, or by a scalar."""

    def __init__(self, value) -> None:
        self.value = value

    @property
    def T(self) -> "Matmul":  # noqa: N802
        return Matmul(self.value.T)

    def __add__(self, other: "Matmul") -> "Matmul":
        return Matmul(self.value + other.value)

    def __mul__(self, other: "Matmul") -> "Matmul":
        both = isinstance(self.value, np.ndarray) and isinstance(other.value, np.ndarray)
        return Matmul(self.value @ other.value if both else self.value * other.value)


class MatmulDomain(Sizes):
    def name(self, name: str):
        return Matmul(super().name(name))

    def number(self, value: int):
        return Matmul(Fraction(value))

    def divide(self, left, right):
        return Matmul(left.value * (1 / right.value))


def test_matrix_identities_hold_for_numbers() -> None:
    steps = [step for step in all_steps(checked_once()) if step.checker is Checker.IDENTITY]
    sources = [step.source for step in steps if ".T" in step.source]
    assert len(sources) > 10, sources
    for source, (n, d) in product(sources, [(1, 1), (2, 3), (3, 2)]):
        domain = MatmulDomain(7, n, d)
        first, second = (evaluate(side, domain).value for side in source.split(" = "))
        assert first.shape == second.shape, (source, first, second)
        assert (first == second).all(), (source, first - second)
