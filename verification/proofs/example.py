"""That (c) needs strictness: X = o = lambda1 = lambda3 = 1, lambda2 = 2, from the paper's start w = u = 1.

The hypotheses of (b) are met, F -> F* = 1, and w(k) lies between 1/(2k+1) and 1/(2k-4).
"""

from verification.ledger.evidence import Step
from verification.proofs.checkers.polynomials import exact, identity
from verification.proofs.checkers.reals import real
from verification.proofs.unchecked import joints

GIVEN = "X = o = lambda1 = lambda3 = 1, lambda2 = 2"
ROW_W, ROW_U = "y*(2*w + 1) == w*(1 + u)", "x*(2*u + 1) == 2*u*z"
ITERATES = {"w": "w(k)", "u": "u(k)", "y": "w(k+1)"}
RECIPROCALS = {"s": "1/w(k)", "u": "u(k)", "S": "1/w(k+1)"}
NEXT = {"V": "u(k+1), Gauss-Seidel"}


def example() -> tuple[Step, ...]:
    """No q < 1 is a rate, in either order; for Gauss-Seidel w(k) is known from both sides."""
    return (*recursion(), *optimum(), *no_rate(), *from_above())


def recursion() -> tuple[Step, ...]:
    """The corrected update in closed form; it makes no exact zero."""
    return (
        identity(
            "example-update-w",
            "the system for w has this solution; lambda2 D^w is 1/w",
            "(1 + 1 + 2*(1/(2*w)))*(w*(1 + u)/(2*w + 1))",
            "1 + u",
            w="w(k)",
            u="u(k)",
        ),
        identity(
            "example-update-u",
            "the system for u has this solution; lambda3 D^u is 1/(2u)",
            "(1 + 1/(2*u))*(2*u*z/(2*u + 1))",
            "z",
            u="u(k)",
            z="w(k+1), or w(k) for Jacobi",
        ),
        real(
            "example-positive",
            "the iterates stay positive, in both orders: none is exactly zero",
            ["w > 0", "u > 0", "z == y or z == w", ROW_W, ROW_U],
            "y > 0 and x > 0",
            **ITERATES,
            x="u(k+1)",
            z="what u sees",
        ),
        *joints("induction"),
    )


def optimum() -> tuple[Step, ...]:
    """F* = 1 at w = u = 0, where the zero of w is not strict."""
    return (
        real(
            "example-optimum",
            "the optimum lies at 0; F exceeds it by the square of w at least",
            [],
            "(w - 1)**2 + (u - w)**2 + 2*abs(w) + abs(u) - 1 >= w**2"
            " and ((w - 1)**2 + (u - w)**2 + 2*abs(w) + abs(u) == 1) == (w == 0 and u == 0)",
            w="w, one view",
            u="u, one feature",
        ),
        exact(
            "example-not-strict",
            "at the optimum |v| equals lambda2, while the zero of u is strict",
            "abs(2*1*(1*0 - 1) - 2*1*(1*0 - 0)) == 2 and abs(2*1*1*(1*0 - 0)) < 1",
            GIVEN,
        ),
    )


def no_rate() -> tuple[Step, ...]:
    """A bound of w from below, which no geometric sequence stays above."""
    return (
        real(
            "example-below",
            "w(k) is at least 1/(2k+1), in both orders; the step from k to the next",
            ["w > 0", "u > 0", "(2*k + 1)*w >= 1", ROW_W],
            "(2*k + 3)*y >= 1",
            **ITERATES,
            k="the iteration",
        ),
        real(
            "example-powers",
            "a power of 1 + g exceeds a square of its exponent; the step from m to the next",
            ["g > 0", "m*(m - 1) >= 0", "P >= 1 + m*g + m*(m - 1)*g**2/2"],
            "P*(1 + g) >= 1 + (m + 1)*g + (m + 1)*m*g**2/2",
            P="(1 + g)^m",
            g="1/sqrt(q) - 1",
            m="iterations after N",
        ),
        real(
            "example-not-linear",
            "so the bound from below and a geometric bound from above contradict each other in the end",
            [
                *("C >= 0", "N >= 0", "(m - 1)*g**2 >= 2*C*(2*N + 3)", "g > 0"),
                *("P >= 1 + m*g + m*(m - 1)*g**2/2", "(2*(N + m) + 1)*w >= 1"),
            ],
            "w*P > C",
            C="sqrt(F(N) - F*)",
            P="(1 + g)^m",
            g="1/sqrt(q) - 1",
            N="where the rate is said to begin",
            m="iterations after N",
            w="w(N+m)",
        ),
        *joints("no-rate"),
    )


def from_above() -> tuple[Step, ...]:
    """Gauss-Seidel: 1/w(k) - 9 u(k) - u(k)/w(k) grows by at least 2 from k = 3 on."""
    return (
        real(
            "example-decreasing",
            "u stays at or below w, and w falls",
            ["u > 0", "u <= w", ROW_W, ROW_U, "z == y"],
            "y < w and x <= y",
            **ITERATES,
            x="u(k+1)",
            z="what u sees",
        ),
        exact(
            "example-third",
            "three updates from the start, system by system, after which w is small enough for what follows",
            "(2 + 1/1)*(2/3) == 1 + 1 and (1 + 1/2)*(4/9) == 2/3"
            " and (2 + 3/2)*(26/63) == 1 + 4/9 and (1 + 9/8)*(208/1071) == 26/63"
            " and (2 + 63/26)*(33254/123165) == 1 + 208/1071"
            " and (1 + 1071/416)*(13833664/183146355) == 33254/123165"
            " and 33254/123165 < 3/11 and (1 - 13833664/183146355)*(123165/33254) - 9*13833664/183146355 > 2",
            f"{GIVEN}, w(0) = u(0) = 1, w(1) = 2/3, u(1) = 4/9, w(2) = 26/63, u(2) = 208/1071,"
            " w(3) = 33254/123165,"
            " u(3) = 13833664/183146355",
        ),
        real(
            "example-loss",
            "the reciprocal of w grows by 2, less what u takes",
            ["u > 0", "s > 0", "S*(1 + u) == 2 + s"],
            "S >= 2 + s - 2*u - u*s",
            **RECIPROCALS,
        ),
        real(
            "example-shrink",
            "u shrinks, and so does its quotient by w",
            ["u > 0", "S >= 11/3", "V*(2*u + 1)*S == 2*u"],
            "V*S <= 2*u and 11*V <= 6*u",
            **NEXT,
            u="u(k)",
            S="1/w(k+1)",
        ),
        real(
            "example-potential",
            "1/w - 9u - u/w grows by 2 in each iteration once w is below 3/11",
            ["S >= 2 + s - 2*u - p", "q <= 2*u", "11*V <= 6*u", "u > 0"],
            "S - 9*V - q >= s - 9*u - p + 2",
            **RECIPROCALS,
            **NEXT,
            p="u(k)/w(k)",
            q="u(k+1)/w(k+1)",
        ),
        real(
            "example-above",
            "so w(k) is at most 1/(2k-4) for k from 3 on",
            ["u > 0", "w > 0", "w*s == 1", "s - 9*u - u*s >= 2 + 2*(k - 3)"],
            "(2*k - 4)*w <= 1",
            w="w(k)",
            u="u(k)",
            s="1/w(k)",
            k="the iteration",
        ),
    )
