"""Claim T1a for the corrected update and T1c: what one iteration does to F, in both orders.

Q(w, u) is F with |w_j| replaced by w_j^2/(2|w_j(i)|) and ||u^i|| by ||u^i||^2/(2||u^i(i)||): up to a
constant, above F and equal to it at the iterate. A = lambda2 D^w and B = lambda3 D^u are its diagonals.
"""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import exact
from verification.proofs.checkers.reals import real
from verification.proofs.norms import majorise_modality, majorise_view, squares
from verification.proofs.unchecked import joints

ROW_W = "(X*X.T + l1*In + A)*(w + dw) - X*(o + l1*u)"
ROW_U = "(l1*X.T*X + B)*(u + du) - l1*X.T*"
PENALTY = "dw'A dw + du'B du"
FALL = {
    "gauss_seidel": f"||X'dw||^2 + lambda1 ||dw||^2 + lambda1 ||X du||^2 + {PENALTY}",
    "jacobi": f"||X'dw||^2 + lambda1 ||dw + X du||^2 + {PENALTY}",
}


def arguments() -> tuple[Argument, ...]:
    """T1a/corrected, T1c/descent and T1c/absolute."""
    found = [absolute()]
    for order, fall in (("gauss_seidel", fall_gauss_seidel()), ("jacobi", fall_jacobi())):
        steps = (*majorants(), *update(), fall, *chain())
        conclusion = "F(i) - F(i+1) >= " + FALL[order]
        found += [
            Argument(f"T1c/descent/{order}", conclusion + " >= 0.", "", steps),
            Argument(f"T1a/corrected/{order}", f"F never rises: {conclusion} >= 0.", "", steps),
        ]
    return tuple(found)


def both_falls() -> tuple[Step, ...]:
    """Section 2.1 in both orders."""
    return (*majorants(), *update(), fall_gauss_seidel(), fall_jacobi(), *chain())


def majorants() -> tuple[Step, ...]:
    """F lies below Q and touches it at the iterate."""
    return (*majorise_view(), *majorise_modality(), *joints("sums", "norms", "held", "loop"))


def quadratic(w: str, u: str) -> str:
    """The text of Q, without its constant."""
    return f"({squares(w, u)} + ({w}).T*A*({w}) + ({u}).T*B*({u}))"


def update() -> tuple[Step, ...]:
    """The update minimises Q in one block at a time."""
    return (
        matrix_identity(
            "update-w",
            "Q in w, expanded: a solution of the system for w, unique or not, minimises it",
            f"{quadratic('w + h', 'u')} - {quadratic('w', 'u')}",
            "2*h.T*((X*X.T + l1*In + A)*w - X*(o + l1*u)) + h.T*(X*X.T + l1*In + A)*h",
        ),
        matrix_identity(
            "update-u",
            "Q in u, expanded: likewise for the system for u",
            f"{quadratic('w', 'u + k')} - {quadratic('w', 'u')}",
            "2*k.T*((l1*X.T*X + B)*u - l1*X.T*w) + k.T*(l1*X.T*X + B)*k",
        ),
    )


def fall_gauss_seidel() -> Step:
    """The fall of Q where u sees the new w."""
    return matrix_identity(
        "fall-gauss-seidel",
        "the fall of Q where u sees the new w: residuals of the two systems, and the squares of (a)",
        f"{quadratic('w + dw', 'u + du')} - {quadratic('w', 'u')}",
        f"2*dw.T*({ROW_W}) + 2*du.T*({ROW_U}(w + dw)) - ((X.T*dw).T*(X.T*dw) + l1*dw.T*dw"
        " + l1*(X*du).T*(X*du) + dw.T*A*dw + du.T*B*du)",
    )


def fall_jacobi() -> Step:
    """The fall of Q where u sees the old w."""
    return matrix_identity(
        "fall-jacobi",
        "the fall of Q where u sees the old w",
        f"{quadratic('w + dw', 'u + du')} - {quadratic('w', 'u')}",
        f"2*dw.T*({ROW_W}) + 2*du.T*({ROW_U}w) - ((X.T*dw).T*(X.T*dw)"
        " + l1*(dw + X*du).T*(dw + X*du) + dw.T*A*dw + du.T*B*du)",
    )


def chain() -> tuple[Step, ...]:
    """From Q to F."""
    return (
        real(
            "fall-sign",
            "the fall, term by term: squares with weights",
            ["l1 >= 0", "A >= 0", "B >= 0"],
            "s**2 + l1*q**2 + A*w**2 + B*u**2 >= 0",
            A="A_j",
            B="B_i",
            s="an entry of X'dw",
            q="an entry of dw, of X du, or of their sum",
            w="dw_j",
            u="an entry of du",
        ),
        real(
            "fall-chain",
            "F falls by what Q falls by, or more",
            ["F1 <= Q1 + c", "F0 == Q0 + c", "Q1 == Q0 - s", "s >= 0"],
            "F0 - F1 >= s and F1 <= F0",
            F0="F(i)",
            F1="F(i+1)",
            Q0="Q at the iterate",
            Q1="Q at the next one",
            c="the constant between F and Q",
            s="the sum of squares in (a)",
        ),
    )


def absolute() -> Argument:
    """T1c/absolute: factor 1/2 is the corrected update of other lambdas."""
    given = "X = o = lambda1 = lambda2 = 1, lambda3 = 0, so that u = w after an update"
    steps = (
        *joints("half"),
        *both_falls(),
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
