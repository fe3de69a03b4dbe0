"""Claim T1c for the smoothed update: F_eps falls; the distance of its minimum; the rate."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.descent import chain, fall_gauss_seidel, fall_jacobi, update
from verification.proofs.norms import cauchy_schwarz

ROOTS = ["e > 0", "f > 0", "g > 0", "f**2 == v**2 + e**2", "g**2 == t**2 + e**2"]


def arguments() -> tuple[Argument, ...]:
    """T1c/smoothed_descent and T1c/smoothed_distance."""
    return smoothed_descent(), smoothed_distance()


def smoothed_descent() -> Argument:
    """T1c/smoothed_descent."""
    steps = (*majorise(), *update(), fall_gauss_seidel(), fall_jacobi(), *chain())
    conclusion = (
        "F_eps(i) - F_eps(i+1) >= the same sums of squares, A = lambda2 D^w, B = lambda3 D^u smoothed."
    )
    return Argument("T1c/smoothed_descent", conclusion, "", steps)


def majorise() -> tuple[Step, ...]:
    """phi(t) = sqrt(t^2 + eps^2) lies below its weighted square."""
    return (
        real(
            "smooth-majorise",
            "phi(t) <= phi(v) + (t^2 - v^2)/(2 phi(v)), f = phi(v), g = phi(t); t, v entries or norms of"
            " blocks",
            ROOTS,
            "2*f*g <= 2*f**2 + t**2 - v**2",
        ),
        identity(
            "smooth-touch",
            "with equality at t = v, and there the slope of both sides is v/phi(v)",
            "2*v/(2*f)",
            "v/f",
        ),
    )


def smoothed_distance() -> Argument:
    """T1c/smoothed_distance, and that the minimum is reached, linearly."""
    steps = (
        real(
            "smooth-between",
            "|t| <= sqrt(t^2 + eps^2) <= |t| + eps: summed, F <= F_eps <= F + eps (n lambda2 + m lambda3)",
            ["e >= 0", "g >= 0", "g**2 == t**2 + e**2"],
            "abs(t) <= g and g <= abs(t) + e",
        ),
        real(
            "smooth-minimum",
            "z a minimum of F_eps, z* of F: F(z) <= F_eps(z) <= F_eps(z*) <= F* + eps (n lambda2 + m"
            " lambda3)",
            ["F <= E", "E <= Es", "Es <= Fs + s"],
            "F - Fs <= s",
        ),
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
        identity(
            "smooth-curvature",
            "(||v||^2 + eps^2)(||t||^2 + eps^2) - (c + eps^2)^2 = eps^2 (||v||^2 + ||t||^2 - 2c) + (||v||^2"
            " ||t||^2 - c^2), c = v't",
            "(v**2 + e**2)*(t**2 + e**2) - (c + e**2)**2",
            "e**2*(v**2 + t**2 - 2*c) + (v**2*t**2 - c**2)",
        ),
        real(
            "smooth-strong",
            "so phi(t) >= phi(v) + v'(t-v)/phi(v) + eps^2 ||t-v||^2/(2R^3) where phi <= R: strong convexity"
            " (left times phi(v); S = ||t-v||^2, P = (f g)^2 - (c + eps^2)^2 >= eps^2 S)",
            [
                "f > 0",
                "g > 0",
                "e > 0",
                "f <= R",
                "g <= R",
                "S >= 0",
                "x <= f*g",
                "(f*g)**2 - x**2 >= e**2*S",
            ],
            "2*R**2*(f*g - x) >= e**2*S",
        ),
        real(
            "smooth-error",
            "F_eps* >= F_eps(z) - G D + m D^2 >= F_eps(z) - G^2/(4m), G the norm of the gradient, m > 0",
            ["m > 0", "G >= 0", "D >= 0"],
            "4*m*(-G*D + m*D**2) >= -G**2",
        ),
        matrix_identity(
            "smooth-gradient-w",
            "the gradient in w at the iterate is 2[(XX' + lambda1 I + A)w - X(o + lambda1 u)], and equals"
            " -2(XX' + lambda1 I + A)dw by the system that w + dw solves",
            "2*((X*X.T + l1*In + A)*w - X*(o + l1*u))",
            "2*((X*X.T + l1*In + A)*(w + dw) - X*(o + l1*u)) - 2*(X*X.T + l1*In + A)*dw",
        ),
        matrix_identity(
            "smooth-gradient-u",
            "that in u equals -2(lambda1 X'X + B)du + 2 lambda1 X'dw (Gauss-Seidel), without the last term"
            " (Jacobi)",
            "2*((l1*X.T*X + B)*u - l1*X.T*w)",
            "2*((l1*X.T*X + B)*(u + du) - l1*X.T*(w + dw)) - 2*(l1*X.T*X + B)*du + 2*l1*X.T*dw",
        ),
        real(
            "smooth-fall",
            "so G <= L ||dz||, while the fall is >= a ||dz||^2, a the least of A and B: fall >= (a/L^2) G^2",
            ["L > 0", "a > 0", "G >= 0", "D >= 0", "G <= L*D", "s >= a*D**2"],
            "L**2*s >= a*G**2",
        ),
        real(
            "smooth-linear",
            "E(i) = F_eps(i) - F_eps*: E(i) <= G^2/(4m), E(i) - E(i+1) >= c G^2: E(i+1) <= (1 - 4mc) E(i)",
            ["m > 0", "c > 0", "4*m*E0 <= G2", "E0 - E1 >= c*G2"],
            "E1 <= (1 - 4*m*c)*E0",
        ),
    )
