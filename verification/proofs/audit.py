"""The audit of the appendix, and what each hypothesis is for: the numbers that docs/theorem.md quotes.

These steps belong to no part of a claim: the refutations are counterexamples with records of their own.
"""

from verification.ledger.evidence import Step
from verification.proofs.checkers.polynomials import exact
from verification.proofs.checkers.reals import real


def steps() -> tuple[Step, ...]:
    """All steps, each checked now."""
    return (*appendix(), *update(), *locking())


def appendix() -> tuple[Step, ...]:
    """Line by line."""
    return (
        exact(
            "audit-objective",
            "X = 1, o = 0, w = 0, u = 1, lambda1 = 2, lambda2 = lambda3 = 0: F = 2, the appendix's objective"
            " is 1",
            "(1*0 - 0)**2 + 2*(1*1 - 0)**2 == 2 and (1*0 - 0)**2 + (1*1 - 0)**2 == 1",
        ),
        exact(
            "audit-l1-lemma",
            "v = (1, 0), t = (1, 1): the left side is 2 - 2/2 = 1, the right side 1 - 1/2 = 1/2",
            "(1 + 1) - (1 + 1)/(2*1) == 1 and 1 - 1/(2*1) == 1/2 and 1 > 1/2",
        ),
        exact(
            "audit-majorant",
            "the printed factor 1/2, with |w|: X = o = lambda1 = lambda2 = 1, lambda3 = 0, from w = u = 1/2"
            " to 3/5: loss + w^2/(2|w(i)|) grows from 1/2 to 13/25",
            "(1 + 1 + (1/2)/(2*(1/2)))*(3/5) == 1 + 1/2 and (1/2 - 1)**2 + (1/2)**2/(2*(1/2)) == 1/2"
            " and (3/5 - 1)**2 + (3/5)**2/(2*(1/2)) == 13/25 and 13/25 > 1/2",
        ),
        exact(
            "audit-substitution",
            "v = w = (1, 1): sum_j w_j^2/(2|v_j|) = 1, but ||w||_2^2/(2||v||_1) = 1/2",
            "1/2 + 1/2 == 1 and (1 + 1)/(2*(1 + 1)) == 1/2",
        ),
        exact(
            "audit-index",
            "the line with the new iterate in the right denominator, w(i) = (1, 0), w(i+1) = (1, 1): the"
            " left side is 1, the right side 1 - 1/4 = 3/4",
            "(1 + 1) - (1 + 1)/(2*1) == 1 and 1 - 1/(2*(1 + 1)) == 3/4 and 1 > 3/4",
        ),
    )


def update() -> tuple[Step, ...]:
    """What the printed sign does."""
    return (
        exact(
            "audit-sign",
            "X = 1, o = -1, lambda1 = 1, lambda2 = 4, lambda3 = 0, from the start w = u = -1: 1/(2w) = -1/2,"
            " the update gives -2, and F goes from 4 to 9",
            "(1 + 1 + (4/2)*(1/(2*(-1))))*(-2) == 1*(-1 + 1*(-1)) and (-1 + 1)**2 + 4*abs(-1) == 4"
            " and (-2 + 1)**2 + 4*abs(-2) == 9",
        ),
        exact(
            "audit-singular",
            "the same with o = -2, lambda2 = 16, from w = u = -2: the 1 x 1 system is 1 + 1 - 2 = 0",
            "1 + 1 + (16/2)*(1/(2*(-2))) == 0",
        ),
    )


VIEWS = "(w + 3*x - 1)**2 + x**2 + abs(w) + abs(x)"
MODALITIES = "(w - 1)**2 + (3*w + x - 3)**2 + (u + 3*y - w)**2 + (y - x)**2 + abs(u) + abs(y)"


def locking() -> tuple[Step, ...]:
    """What an exact zero does."""
    return (
        exact(
            "lock-view-start",
            "X = [[1, 0], [3, 1]], o = (1, 0), lambda1 = lambda2 = 1, lambda3 = 0: X'w = o at w = (1, 0), Xu"
            " = w at u = (1, -3); w_2 is 0 from the start on",
            "1*1 + 3*0 == 1 and 0*1 + 1*0 == 0 and 1*1 + 0*(-3) == 1 and 3*1 + 1*(-3) == 0",
        ),
        real("lock-view", "with w_2 = x = 0 F is at least 3/4, where it ends", ["x == 0"], f"{VIEWS} >= 3/4"),
        exact(
            "lock-view-better",
            "at w = u = (0, 1/4), Xu = w, F = 3/8",
            "(0 + 3*(1/4) - 1)**2 + (1/4)**2 + 1/4 == 3/8 and 1*0 + 0*(1/4) == 0 and 3*0 + 1*(1/4) == 1/4",
        ),
        real("lock-view-optimum", "which is F*: F >= 3/8 everywhere", [], f"{VIEWS} >= 3/8"),
        exact(
            "lock-modality-start",
            "X = [[1, 3], [0, 1]], o = (1, 3), lambda1 = lambda3 = 1, lambda2 = 0, modalities of one column:"
            " the start is w = (1, 0), u = (1, 0); u_2 is 0 from the start on",
            "1*1 + 0*0 == 1 and 3*1 + 1*0 == 3 and 1*1 + 3*0 == 1 and 0*1 + 1*0 == 0",
        ),
        real(
            "lock-modality",
            "with u_2 = y = 0 F is at least 31/44, where it ends",
            ["y == 0"],
            f"{MODALITIES} >= 31/44",
        ),
        exact(
            "lock-modality-better",
            "at w = (215/238, 32/119), u = (0, 59/238) F = 135/476",
            "(215/238 - 1)**2 + (3*(215/238) + 32/119 - 3)**2 + (0 + 3*(59/238) - 215/238)**2"
            " + (59/238 - 32/119)**2 + 0 + 59/238 == 135/476 and 135/476 < 31/44",
        ),
        real("lock-modality-optimum", "which is F*: F >= 135/476 everywhere", [], f"{MODALITIES} >= 135/476"),
    )
