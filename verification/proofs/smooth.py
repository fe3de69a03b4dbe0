"""Claim T1c for the smoothed update: F_eps falls; the distance of its minimum; the rate."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.descent import form
from verification.proofs.norms import cauchy_schwarz
from verification.proofs.reweighted import distance, falls
from verification.proofs.unchecked import joints

VALUES = {"f": "phi(v)", "g": "phi(t)"}


def arguments() -> tuple[Argument, ...]:
    """T1c/smoothed_descent and T1c/smoothed_distance."""
    return smoothed_descent(), smoothed_distance()


def smoothed_descent() -> Argument:
    """T1c/smoothed_descent."""
    steps = (majorise(), *joints("sums", "norms", "loop", "substitution"), form(), *falls())
    conclusion = (
        "F_eps(i) - F_eps(i+1) >= the same sums of squares, A = lambda2 D^w, B = lambda3 D^u smoothed."
    )
    return Argument("T1c/smoothed_descent", conclusion, "", steps)


def majorise() -> Step:
    """phi(t) = sqrt(t^2 + eps^2) lies below its weighted square."""
    return real(
        "smooth-majorise",
        "phi lies below its weighted square (times 2 phi(v)), and touches it at v",
        ["f > 0", "f**2 == v**2 + e**2", "g**2 == t**2 + e**2"],
        "2*f*g <= 2*f**2 + t**2 - v**2 and (t != v or 2*f*g == 2*f**2 + t**2 - v**2 or g < 0)",
        **VALUES,
        v="an entry of the iterate, or the norm of a block",
        t="any other value of it",
        e="eps",
    )


def smoothed_distance() -> Argument:
    """T1c/smoothed_distance, and that the minimum is reached, linearly."""
    steps = (
        real(
            "smooth-between",
            "phi exceeds the absolute value by eps at most",
            ["e >= 0", "g >= 0", "g**2 == t**2 + e**2"],
            "abs(t) <= g and g <= abs(t) + e",
            g="phi(t)",
            t="an entry, or the norm of a block",
            e="eps",
        ),
        *distance(),
        *convergence(),
    )
    conclusion = (
        "A minimum of F_eps is within eps (n lambda2 + m lambda3) of F*. For lambda2, lambda3 > 0 the"
        " smoothed update converges to it linearly in both orders, from every start."
    )
    return Argument("T1c/smoothed_distance", conclusion, "", steps)


def convergence() -> tuple[Step, ...]:
    """F_eps is strongly convex on its bounded level set, and each step pays for the gradient."""
    return (
        *cauchy_schwarz(),
        *joints("sums", "norms"),
        *strong(),
        *joints("smooth-level"),
        *gradient(),
        *joints("smooth-weights", "loop"),
        real(
            "smooth-fall",
            "so the fall is at least a constant times the squared gradient",
            ["a > 0", "G >= 0", "G <= L*D", "s >= a*D**2"],
            "L**2*s >= a*G**2",
            L="the norm of the map from a step to the gradient",
            a="the least entry of A and B",
            G="the norm of the gradient",
            D="||dz||",
            s="the fall",
        ),
        real(
            "smooth-linear",
            "and the error shrinks by a factor below 1",
            ["c > 0", "4*m*E0 <= G2", "E0 - E1 >= c*G2"],
            "E1 <= (1 - 4*m*c)*E0",
            m="the modulus of smooth-error",
            c="the constant a/L^2 of smooth-fall",
            G2="the squared gradient",
            E0="F_eps(i) less its minimum",
            E1="F_eps(i+1) less its minimum",
        ),
        *joints("smooth-limit"),
    )


def strong() -> tuple[Step, ...]:
    """Strong convexity of phi, and what it says of the error."""
    return (
        identity(
            "smooth-curvature",
            "the product of two phi, squared, less a square: eps^2 ||t - v||^2 and the square of Cauchy and"
            " Schwarz",
            "(v**2 + e**2)*(t**2 + e**2) - (c + e**2)**2",
            "e**2*(v**2 + t**2 - 2*c) + (v**2*t**2 - c**2)",
            v="||v||",
            t="||t||",
            c="v't",
            e="eps",
        ),
        real(
            "smooth-strong",
            "so phi is strongly convex where it is bounded (times phi(v))",
            [
                *("f > 0", "g > 0", "f <= R", "g <= R"),
                *("S >= 0", "(f*g)**2 - x**2 >= e**2*S"),
            ],
            "2*R**2*(f*g - x) >= e**2*S",
            **VALUES,
            R="a bound of phi",
            e="eps",
            S="||t - v||^2",
            x="v't + eps^2",
        ),
        real(
            "smooth-error",
            "so the error is at most the squared gradient over 4m",
            [],
            "4*m*(-G*D + m*D**2) >= -G**2",
            m="the modulus of strong convexity",
            G="the norm of the gradient",
            D="the distance of the minimum",
        ),
    )


def gradient() -> tuple[Step, ...]:
    """The gradient at the iterate, by the systems that the next one solves."""
    return (
        matrix_identity(
            "smooth-gradient-w",
            "the gradient in w at the iterate: twice the residual of the system for w, and a matrix times dw",
            "2*X*(X.T*w - o) - 2*l1*(X*u - w) + 2*A*w",
            "2*((X*X.T + l1*In + A)*(w + dw) - X*(o + l1*u)) - 2*(X*X.T + l1*In + A)*dw",
        ),
        matrix_identity(
            "smooth-gradient-u",
            "the gradient in u likewise (Gauss-Seidel; for Jacobi the last term and dw in the residual are"
            " absent)",
            "2*l1*X.T*(X*u - w) + 2*B*u",
            "2*((l1*X.T*X + B)*(u + du) - l1*X.T*(w + dw)) - 2*(l1*X.T*X + B)*du + 2*l1*X.T*dw",
        ),
    )
