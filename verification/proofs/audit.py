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


VIEWS = "(w + 3*x - 1)**2 + x**2 + abs(w) + abs(x)"
MODALITIES = "(w - 1)**2 + (3*w + x - 3)**2 + (u + 3*y - w)**2 + (y - x)**2 + abs(u) + abs(y)"
GIVEN_VIEWS = "X = [[1, 0], [3, 1]], o = (1, 0), lambda1 = lambda2 = 1, lambda3 = 0"
GIVEN_MODALITIES = (
    "X = [[1, 3], [0, 1]], o = (1, 3), lambda1 = lambda3 = 1, lambda2 = 0, modalities of one column"
)


def locking() -> tuple[Step, ...]:
    """What an exact zero does."""
    return (
        exact(
            "lock-view-start",
            "the start solves X'w - o and Xu - w for 0: w_2 is 0 from the start on",
            "1*1 + 3*0 == 1 and 0*1 + 1*0 == 0 and 1*1 + 0*(-3) == 1 and 3*1 + 1*(-3) == 0",
            f"{GIVEN_VIEWS}; w = (1, 0), u = (1, -3)",
        ),
        real(
            "lock-view",
            "with w_2 held at 0, F does not fall below the value where it ends",
            ["x == 0"],
            f"{VIEWS} >= 3/4",
            w="w_1",
            x="w_2; Xu - w is 0",
        ),
        exact(
            "lock-view-better",
            "Xu - w is 0, and F has the value 3/8",
            "(0 + 3*(1/4) - 1)**2 + (1/4)**2 + 1/4 == 3/8 and 1*0 + 0*(1/4) == 0 and 3*0 + 1*(1/4) == 1/4",
            f"{GIVEN_VIEWS}; w = u = (0, 1/4)",
        ),
        real(
            "lock-view-optimum",
            "which is the optimum",
            [],
            f"{VIEWS} >= 3/8",
            w="w_1",
            x="w_2; Xu - w is 0 or adds more",
        ),
        exact(
            "lock-modality-start",
            "the start solves X'w - o and Xu - w for 0: u_2 is 0 from the start on",
            "1*1 + 0*0 == 1 and 3*1 + 1*0 == 3 and 1*1 + 3*0 == 1 and 0*1 + 1*0 == 0",
            f"{GIVEN_MODALITIES}; w = (1, 0), u = (1, 0)",
        ),
        real(
            "lock-modality",
            "with u_2 held at 0, F does not fall below the value where it ends",
            ["y == 0"],
            f"{MODALITIES} >= 31/44",
            w="w_1",
            x="w_2",
            u="u_1",
            y="u_2",
        ),
        exact(
            "lock-modality-better",
            "F has the value 135/476",
            "(215/238 - 1)**2 + (3*(215/238) + 32/119 - 3)**2 + (0 + 3*(59/238) - 215/238)**2"
            " + (59/238 - 32/119)**2 + 0 + 59/238 == 135/476 and 135/476 < 31/44",
            f"{GIVEN_MODALITIES}; w = (215/238, 32/119), u = (0, 59/238)",
        ),
        exact(
            "lock-modality-optimum",
            "which is the optimum, by a feasible dual point of that value: Xa - b is 0, X'b at most lambda3",
            "1*(-23/119) + 3*(-5/119) == -38/119 and 0*(-23/119) + 1*(-5/119) == -5/119"
            " and abs(1*(-38/119) + 0*(-5/119)) <= 1 and abs(3*(-38/119) + 1*(-5/119)) <= 1"
            " and -(1*(-23/119) + 3*(-5/119)) - ((23/119)**2 + (5/119)**2)/4 - ((38/119)**2 + (5/119)**2)/4"
            " == 135/476",
            f"{GIVEN_MODALITIES}; a = (-23/119, -5/119), b = (-38/119, -5/119)",
        ),
    )
