"""The audit of the appendix, and what each hypothesis is for: the numbers that docs/theorem.md quotes.

These steps belong to no part of a claim: the refutations are counterexamples with records of their own.
"""

from verification.ledger.evidence import Step
from verification.proofs.checkers.polynomials import exact
from verification.proofs.checkers.reals import real
from verification.proofs.unchecked import joints


def steps() -> tuple[Step, ...]:
    """All steps, each checked now."""
    return (*appendix(), *update(), *locking(), *joints("zero-lambdas", "locked"))


def appendix() -> tuple[Step, ...]:
    """Line by line."""
    return (
        exact(
            "audit-objective",
            "F and the appendix's objective at one point: 2 and 1",
            "(1*0 - 0)**2 + 2*(1*1 - 0)**2 == 2 and (1*0 - 0)**2 + (1*1 - 0)**2 == 1",
            "X = 1, o = 0, w = 0, u = 1, lambda1 = 2, lambda2 = lambda3 = 0",
        ),
        exact(
            "audit-l1-lemma",
            "the left side is 1, the right side 1/2",
            "(1 + 1) - (1 + 1)/(2*1) == 1 and 1 - 1/(2*1) == 1/2 and 1 > 1/2",
            "v = (1, 0), t = (1, 1)",
        ),
        exact(
            "audit-majorant",
            "loss and weighted square together grow from 1/2 to 13/25 in the step from 1/2 to 3/5",
            "(1 + 1 + (1/2)/(2*(1/2)))*(3/5) == 1 + 1/2 and (1/2 - 1)**2 + (1/2)**2/(2*(1/2)) == 1/2"
            " and (3/5 - 1)**2 + (3/5)**2/(2*(1/2)) == 13/25 and 13/25 > 1/2",
            "the printed factor 1/2 with |w|, X = o = lambda1 = lambda2 = 1, lambda3 = 0, w = u = 1/2",
        ),
        exact(
            "audit-substitution",
            "the sum over the entries is 1, the quotient of the norms 1/2",
            "1/2 + 1/2 == 1 and (1 + 1)/(2*(1 + 1)) == 1/2",
            "v = w = (1, 1)",
        ),
        exact(
            "audit-index",
            "with the new iterate in the right denominator the left side is 1, the right side 3/4",
            "(1 + 1) - (1 + 1)/(2*1) == 1 and 1 - 1/(2*(1 + 1)) == 3/4 and 1 > 3/4",
            "w(i) = (1, 0), w(i+1) = (1, 1)",
        ),
    )


def update() -> tuple[Step, ...]:
    """What the printed sign does."""
    return (
        exact(
            "audit-sign",
            "the update leads from -1 to -2, and F from 4 to 9",
            "(1 + 1 + (4/2)*(1/(2*(-1))))*(-2) == 1*(-1 + 1*(-1)) and (-1 + 1)**2 + 4*abs(-1) == 4"
            " and (-2 + 1)**2 + 4*abs(-2) == 9",
            "X = 1, o = -1, lambda1 = 1, lambda2 = 4, lambda3 = 0, start w = u = -1",
        ),
        exact(
            "audit-singular",
            "the 1 x 1 system is 0",
            "1 + 1 + (16/2)*(1/(2*(-2))) == 0",
            "X = 1, o = -2, lambda1 = 1, lambda2 = 16, lambda3 = 0, start w = u = -2",
        ),
    )


VIEWS = "(w + x - 1)**2 + x**2 + (u - w)**2 + (u + y - x)**2 + abs(w) + abs(x) + abs(u) + abs(y)"
MODALITIES = "(w - 1)**2 + (2*w - 2)**2 + (u + 2*y - w)**2 + abs(w) + abs(u) + abs(y)"
GIVEN_VIEWS = "X = [[1, 0], [1, 1]], o = (1, 0), all lambdas 1, modalities of one column"
GIVEN_MODALITIES = "X = (1, 2), o = (1, 2), all lambdas 1, modalities of one column"


def locking() -> tuple[Step, ...]:
    """What an exact zero does where all lambdas are positive."""
    return (
        exact(
            "lock-view-start",
            "the start solves X'w - o and Xu - w for 0: w_2 is 0 from the start on",
            "1*1 + 1*0 == 1 and 0*1 + 1*0 == 0 and 1*1 + 0*(-1) == 1 and 1*1 + 1*(-1) == 0",
            f"{GIVEN_VIEWS}; w = (1, 0), u = (1, -1)",
        ),
        real(
            "lock-view",
            "with w_2 held at 0, F does not fall below 7/8",
            ["x == 0"],
            f"{VIEWS} >= 7/8",
            w="w_1",
            x="w_2",
            u="u_1",
            y="u_2",
        ),
        exact(
            "lock-view-better",
            "F has the value 17/20",
            "(1/5 + 1/10 - 1)**2 + (1/10)**2 + (1/5)**2 + (1/10)**2 + 1/5 + 1/10 == 17/20 and 17/20 < 7/8",
            f"{GIVEN_VIEWS}; w = (1/5, 1/10), u = (0, 0)",
        ),
        exact(
            "lock-view-optimum",
            "which is the optimum, by a feasible dual point of that value: Xa - b is at most lambda2 and X'b"
            " at most lambda3",
            "abs(1*(-7/5) + 0*(1/5) + 2/5) <= 1 and abs(1*(-7/5) + 1*(1/5) + 1/5) <= 1"
            " and abs(1*(-2/5) + 1*(-1/5)) <= 1 and abs(0*(-2/5) + 1*(-1/5)) <= 1"
            " and -(1*(-7/5) + 0*(1/5)) - ((7/5)**2 + (1/5)**2)/4 - ((2/5)**2 + (1/5)**2)/4 == 17/20",
            f"{GIVEN_VIEWS}; a = (-7/5, 1/5), b = (-2/5, -1/5)",
        ),
        exact(
            "lock-modality-start",
            "the start solves X'w - o and Xu - w for 0: u_2 is 0 from the start on",
            "1*1 == 1 and 2*1 == 2 and 1*1 + 2*0 == 1",
            f"{GIVEN_MODALITIES}; w = 1, u = (1, 0)",
        ),
        real(
            "lock-modality",
            "with u_2 held at 0, F does not fall below 31/20",
            ["y == 0"],
            f"{MODALITIES} >= 31/20",
            w="the weight of the view",
            u="u_1",
            y="u_2",
        ),
        exact(
            "lock-modality-better",
            "F has the value 53/40",
            "(17/20 - 1)**2 + (2*(17/20) - 2)**2 + (0 + 2*(3/10) - 17/20)**2 + 17/20 + 0 + 3/10 == 53/40"
            " and 53/40 < 31/20",
            f"{GIVEN_MODALITIES}; w = 17/20, u = (0, 3/10)",
        ),
        exact(
            "lock-modality-optimum",
            "which is the optimum, by a feasible dual point of that value: Xa - b is at most lambda2 and X'b"
            " at most lambda3",
            "abs(1*(-3/10) + 2*(-3/5) + 1/2) <= 1 and abs(1*(-1/2)) <= 1 and abs(2*(-1/2)) <= 1"
            " and -(1*(-3/10) + 2*(-3/5)) - ((3/10)**2 + (3/5)**2)/4 - (1/2)**2/4 == 53/40",
            f"{GIVEN_MODALITIES}; a = (-3/10, -3/5), b = -1/2",
        ),
    )
