"""Inequalities over the reals, each decided by z3 and by cvc5 from one SMT-LIB text."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cvc5
import z3

from verification.ledger.evidence import Checker, Step
from verification.proofs.checkers.formulas import evaluate, legend, names, refused

EFFORT = 20_000_000
"""z3's resource limit of one query: a count of its own steps, so that two machines agree, unlike a time."""
EFFORT_CVC5 = 300_000
"""The same for cvc5. Its cylindrical coverings do not look at it: a query that is too hard for them does not
end, and has to be replaced by an exact witness."""
KNOWN = frozenset({"l1", "l2", "l3"})
"""lambda1, lambda2, lambda3."""


def real(name: str, gloss: str, hypotheses: list[str], conclusion: str, **where: str) -> Step:
    """Ask z3 and cvc5 whether the conclusion follows from the hypotheses, for all reals.

    It follows if `hypotheses and not conclusion` is unsatisfiable. The hypotheses alone must be satisfiable,
    so that nothing is proved of nothing. The step passes if both solvers say both; each query has an effort
    and a seed of its own, and an answer "unknown" does not pass.

    Parameters
    ----------
    name : str
        How the written proof refers to the step.
    gloss : str
        What the step is for, in words.
    hypotheses : list of str
        Formulas; every name is a real variable.
    conclusion : str
    **where : str
        What the names that are not in `KNOWN` stand for.

    Returns
    -------
    Step

    Raises
    ------
    InputError
        A text is not a formula, or divides by anything but an integer; or see `legend`.
    """
    given = f"{', '.join(hypotheses)} => {conclusion}" if hypotheses else conclusion
    used = names(*hypotheses, conclusion)
    meaning = legend(gloss, where, set(used) - KNOWN)
    assumed = [evaluate(text, _Smt()) for text in hypotheses]
    possible = _script(used, assumed)
    violated = _script(used, [*assumed, _Smt().negation(evaluate(conclusion, _Smt()))])
    passed = all(answer(possible) == "sat" and answer(violated) == "unsat" for answer in SOLVERS)
    return Step(f"{name}: {gloss}", Checker.SOLVERS, passed, given, meaning)


def by_z3(script: str) -> str:
    """What z3 says: "sat", "unsat" or "unknown"."""
    solver = z3.SolverFor("QF_NRA", ctx=z3.Context())
    solver.set("rlimit", EFFORT)
    solver.set("random_seed", 0)
    solver.from_string(script)
    return str(solver.check())


def by_cvc5(script: str) -> str:
    """What cvc5 says: "sat", "unsat" or "unknown"."""
    solver = cvc5.Solver(cvc5.TermManager())
    solver.setLogic("QF_NRA")
    solver.setOption("rlimit", str(EFFORT_CVC5))
    solver.setOption("seed", "0")
    parser = cvc5.InputParser(solver)
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, script, "query")
    while not (command := parser.nextCommand()).isNull():
        command.invoke(solver, parser.getSymbolManager())
    found = solver.checkSat()
    return "sat" if found.isSat() else "unsat" if found.isUnsat() else "unknown"


SOLVERS: tuple[Callable[[str], str], ...] = (by_z3, by_cvc5)
"""Both have to agree; cvc5 is asked where z3 accepted."""


def _script(variables: tuple[str, ...], formulas: list["_Term"]) -> str:
    declared = (f"(declare-const {name} Real)" for name in variables)
    return "\n".join([*declared, *(f"(assert {formula.text})" for formula in formulas)])


@dataclass(frozen=True, eq=False)
class _Term:
    """A term of SMT-LIB."""

    text: str

    def __add__(self, other: "_Term") -> "_Term":
        return _term("+", self, other)

    def __mul__(self, other: "_Term") -> "_Term":
        return _term("*", self, other)

    def __lt__(self, other: "_Term") -> "_Term":
        return _term("<", self, other)

    def __le__(self, other: "_Term") -> "_Term":
        return _term("<=", self, other)

    def __gt__(self, other: "_Term") -> "_Term":
        return _term(">", self, other)

    def __ge__(self, other: "_Term") -> "_Term":
        return _term(">=", self, other)

    __hash__ = object.__hash__

    def __eq__(self, other: Any) -> Any:
        return _term("=", self, other)

    def __ne__(self, other: Any) -> Any:
        return _term("distinct", self, other)


def _term(operation: str, *parts: _Term) -> _Term:
    return _Term(f"({operation} {' '.join(part.text for part in parts)})")


class _Smt:
    """Terms of SMT-LIB over the reals."""

    def name(self, name: str) -> _Term:
        return _Term(name)

    def number(self, value: int) -> _Term:
        return _Term(f"{value}.0") if value >= 0 else _Term(f"(- {-value}.0)")

    def divide(self, left: _Term, right: _Term) -> _Term:
        if not right.text.removesuffix(".0").isdigit() or right.text == "0.0":
            raise refused(right.text, "must be an integer other than 0 where it divides: multiply it out")
        return _term("/", left, right)

    def absolute(self, value: _Term) -> _Term:
        return _Term(f"(ite (>= {value.text} 0.0) {value.text} (- {value.text}))")

    def every(self, values: list[_Term]) -> _Term:
        return _term("and", *values) if len(values) > 1 else values[0]

    def some(self, values: list[_Term]) -> _Term:
        return _term("or", *values)

    def negation(self, value: _Term) -> _Term:
        return _term("not", value)
