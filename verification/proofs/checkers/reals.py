"""Inequalities over the reals, decided by z3."""

from dataclasses import dataclass
from typing import Any

import z3

from verification.ledger.evidence import Checker, Step
from verification.proofs.checkers.formulas import evaluate, names, refused

EFFORT = 20_000_000
"""z3's resource limit of one query: a count of its own steps, so that two machines agree, unlike a time."""


def real(name: str, statement: str, hypotheses: list[str], conclusion: str) -> Step:
    """Ask z3 whether the conclusion follows from the hypotheses, for all reals.

    It follows if `hypotheses and not conclusion` is unsatisfiable. The hypotheses alone must be satisfiable,
    so that nothing is proved of nothing. Each query has a context, a seed and an effort of its own; an answer
    "unknown" does not pass.

    Parameters
    ----------
    name : str
        How the written proof refers to the step.
    statement : str
        What it says in the notation of the paper.
    hypotheses : list of str
        Formulas; every name is a real variable.
    conclusion : str

    Returns
    -------
    Step

    Raises
    ------
    InputError
        A text is not a formula, or divides by anything but a number.
    """
    given = f"{', '.join(hypotheses)} => {conclusion}" if hypotheses else conclusion
    context = z3.Context()
    domain = _Reals(context, {each: z3.Real(each, context) for each in names(*hypotheses, conclusion)})
    assumed = [evaluate(text, domain) for text in hypotheses]
    claim = evaluate(conclusion, domain)
    passed = _answer(context, assumed) == z3.sat and _answer(context, [*assumed, z3.Not(claim)]) == z3.unsat
    return Step(f"{name}: {statement}", Checker.Z3, passed, given)


def _answer(context: Any, formulas: list[Any]) -> Any:
    solver = z3.SolverFor("QF_NRA", ctx=context)
    solver.set("rlimit", EFFORT)
    solver.set("random_seed", 0)
    solver.add(*formulas)
    return solver.check()


@dataclass(frozen=True)
class _Reals:
    """z3's real terms."""

    context: Any
    variables: dict[str, Any]

    def name(self, name: str) -> Any:
        return self.variables[name]

    def number(self, value: int) -> Any:
        return z3.RealVal(value, self.context)

    def divide(self, left: Any, right: Any) -> Any:
        divisor = z3.simplify(right)
        if not z3.is_rational_value(divisor) or divisor.as_fraction() == 0:
            raise refused(str(right), "must be a number other than 0 where it divides: multiply it out")
        return left / divisor

    def absolute(self, value: Any) -> Any:
        return z3.If(value >= 0, value, -value)

    def every(self, values: list[Any]) -> Any:
        return z3.And(*values)

    def some(self, values: list[Any]) -> Any:
        return z3.Or(*values)

    def negation(self, value: Any) -> Any:
        return z3.Not(value)
