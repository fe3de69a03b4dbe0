"""Written proofs of each part of a claim that can be proved, whose algebraic steps are checked by machine.

A step is made by a function that checks what it is given: `polynomials.identity`, `polynomials.exact`,
`matrices.matrix_identity` or `reals.real`. What no machine checks is named beside them (`unchecked`): the
theorems that are cited, and the joints. A step's statement starts with its name; docs/theorem.md and
docs/reweighted-theorem.md are the proofs, and use these names.
"""

from collections.abc import Iterable

from verification.ledger.evidence import Argument, Step
from verification.proofs import (
    audit,
    derivation,
    descent,
    formulation,
    limit,
    one_view,
    rate,
    reweighted,
    smooth,
    systems,
    zeros,
)

TOPICS = (formulation, zeros, derivation, descent, limit, rate, smooth, systems, one_view)


def all_arguments() -> tuple[Argument, ...]:
    """Check every argument now.

    Returns
    -------
    tuple of Argument
        One a part. An argument with a step that did not pass is returned too; `Argument.passed` says so.
    """
    return tuple(argument for topic in TOPICS for argument in topic.arguments())


def all_steps(arguments: Iterable[Argument]) -> tuple[Step, ...]:
    """The steps of arguments and those that belong to no part of a claim, checked now; each name once."""
    found = [step for argument in arguments for step in argument.steps]
    return tuple({step_name(step): step for step in (*found, *other_steps())}.values())


def other_steps() -> tuple[Step, ...]:
    """The steps of the audit of the appendix and of the general theorem, checked now."""
    return (*audit.steps(), *reweighted.steps())


def step_name(step: Step) -> str:
    """The name that a step's statement starts with."""
    return step.statement.split(":", 1)[0]
