"""Claim T1a for the corrected update and T1c: what one iteration does to F, in both orders.

Q(w, u) is F with |w_j| replaced by w_j^2/(2|w_j(i)|) and ||u^i|| by ||u^i||^2/(2||u^i(i)||): up to a
constant, above F and equal to it at the iterate. A = lambda2 D^w and B = lambda3 D^u are its diagonals. That
the update lowers F is the general theorem (`reweighted.falls`) with this Q.
"""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import exact
from verification.proofs.norms import majorise_modality, majorise_view, squares
from verification.proofs.reweighted import falls
from verification.proofs.unchecked import joints

PENALTY = "dw'A dw + du'B du"
FALL = {
    "gauss_seidel": f"||X'dw||^2 + lambda1 ||dw||^2 + lambda1 ||X du||^2 + {PENALTY}",
    "jacobi": f"||X'dw||^2 + lambda1 ||dw + X du||^2 + {PENALTY}",
}


def arguments() -> tuple[Argument, ...]:
    """T1a/corrected, T1c/descent and T1c/absolute."""
    found, steps = [absolute()], descent()
    for order, fall in FALL.items():
        conclusion = f"F(i) - F(i+1) >= {fall}"
        found += [
            Argument(f"T1c/descent/{order}", conclusion + " >= 0.", "", steps),
            Argument(f"T1a/corrected/{order}", f"F never rises: {conclusion} >= 0.", "", steps),
        ]
    return tuple(found)


def descent() -> tuple[Step, ...]:
    """Section 2.1 in both orders: F lies below Q and touches it at the iterate, and Q falls by its form."""
    return (
        *majorise_view(),
        *majorise_modality(),
        *joints("sums", "norms", "held", "loop", "substitution"),
        form(),
        *falls(),
    )


def form() -> Step:
    """The systems and the form of Q."""
    terms = "({0}).T*A*({0}) + ({1}).T*B*({1})"
    changed, given = (f"({squares(*at)} + {terms.format(*at)})" for at in (("w + h", "u + k"), ("w", "u")))
    return matrix_identity(
        "update-form",
        "Q expanded: twice the residuals of the two systems, and its form",
        f"{changed} - {given}",
        "2*h.T*((X*X.T + l1*In + A)*w - X*(o + l1*u)) + 2*k.T*((l1*X.T*X + B)*u - l1*X.T*w)"
        " + (X.T*h).T*(X.T*h) + l1*(h - X*k).T*(h - X*k) + h.T*A*h + k.T*B*k",
    )


def absolute() -> Argument:
    """T1c/absolute: factor 1/2 is the corrected update of other lambdas."""
    given = "X = o = lambda1 = lambda2 = 1, lambda3 = 0, so that u = w after an update"
    steps = (
        *joints("scaled"),
        *descent(),
        exact(
            "absolute-fixed",
            "the update rests at 3/4",
            "(1 + 1 + (1/2)/(2*(3/4)))*(3/4) == 1*(1 + 3/4)",
            given,
        ),
        exact(
            "absolute-limit",
            "there F has the value 13/16, and a smaller one at 1/2",
            "(3/4 - 1)**2 + (3/4 - 3/4)**2 + 3/4 == 13/16 and (1/2 - 1)**2 + 1/2 == 3/4 and 3/4 < 13/16",
            given,
        ),
        exact(
            "absolute-rise",
            "the update leads from 1/2 to 3/5, where F is larger",
            "(1 + 1 + (1/2)/(2*(1/2)))*(3/5) == 1 + 1/2 and (3/5 - 1)**2 + 3/5 == 19/25 and 19/25 > 3/4",
            given,
        ),
    )
    conclusion = (
        "The update with factor 1/2 is the corrected one for lambda2/2, lambda3/2: it never raises that F,"
        " but it raises F itself, and stops away from its optimum."
    )
    return Argument("T1c/absolute", conclusion, "", steps)
