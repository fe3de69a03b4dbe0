"""Claim T1c/rate: linear where every zero is strict, and an example that is not."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import cited, exact, identity
from verification.proofs.checkers.reals import real
from verification.proofs.descent import chain, fall_gauss_seidel, fall_jacobi, update
from verification.proofs.limit import rows
from verification.proofs.norms import cauchy_schwarz, majorise_modality, majorise_view, quadratic_part

HOFFMAN = (
    "A. J. Hoffman, On approximate solutions of systems of linear inequalities, J. Res. Nat. Bur. Standards"
    " 49 (1952) 263-265"
)
CONDITION = (
    "for the linear rate: lambda1, lambda2, lambda3 > 0; no iterate has an exact zero; each w_j(i) stays away"
    " from 0 or has lim |v_j| < lambda2, each u^i(i) stays away from 0 or has lim ||g^i|| < lambda3"
)


def arguments() -> tuple[Argument, ...]:
    """T1c/rate."""
    falls = (*majorise_view(), *majorise_modality(), *update(), fall_gauss_seidel(), fall_jacobi(), *chain())
    steps = (*falls, *rows(), *growth(), *subgradient(), *contraction(), *example())
    conclusion = (
        "There is q < 1 with F(i+1) - F* <= q (F(i) - F*) from some i on, in both orders; without strictness"
        " the example has F - F* = 1/(k+1)^2 exactly (its u is 0 from k = 1 on, or from the start)."
    )
    return (Argument("T1c/rate", conclusion, CONDITION, steps),)


def growth() -> tuple[Step, ...]:
    """F - F* >= const dist(z, Z*)^2 on bounded sets, Z* the set of optima."""
    return (
        quadratic_part(),
        real(
            "growth-bracket",
            "at an optimum v_j w*_j + lambda2 |w*_j| = 0, so v_j (w - w*) + lambda2 (|w| - |w*|) = lambda2"
            " |w| + v_j w; likewise for blocks: F - F* = ||X'(w-w*)||^2 + lambda1 ||X(u-u*) - (w-w*)||^2 +"
            " sum of brackets",
            ["v*s + l*abs(s) == 0"],
            "v*(w - s) + l*abs(w) - l*abs(s) == l*abs(w) + v*w",
        ),
        real(
            "growth-view",
            "the bracket of w_j is >= (1-t) lambda2 |w_j| if |v_j| <= t lambda2; it is >= lambda2 |w_j| if"
            " v_j = lambda2 and w_j > 0 (wrong side); and lambda2 |w_j| >= (lambda2/R) w_j^2 for |w_j| <= R",
            ["l > 0", "t >= 0", "t <= 1", "R > 0", "abs(w) <= R"],
            "(abs(v) > t*l or l*abs(w) + v*w >= (1-t)*l*abs(w)) and (v != l or w <= 0 or l*abs(w) + v*w >="
            " l*abs(w)) and R*l*abs(w) >= l*w**2",
        ),
        *cauchy_schwarz(),
        identity(
            "growth-angle",
            "a block with ||g|| = lambda3, u = -t g/||g|| + s, s orthogonal to g, r = ||u||, r^2 = t^2 +"
            " ||s||^2: its bracket is lambda3 (r - t), and 2r(r - t) = ||s||^2 + (r - t)^2",
            "2*r*(r - t)",
            "(r**2 - t**2) + (r - t)**2",
        ),
        real(
            "growth-block",
            "so the bracket is >= lambda3 dist^2/(2R) to the ray {-t g, t >= 0} for r <= R: dist is ||s||"
            " for t >= 0, else r; and >= (lambda3 - ||g||) r if ||g|| < lambda3",
            ["l > 0", "r > 0", "r <= R", "q >= 0", "r**2 == t**2 + q**2"],
            "2*R*l*(r - t) >= l*q**2 and (t >= 0 or 2*R*l*(r - t) >= l*r**2)",
        ),
        cited(
            "growth-hoffman",
            "Z* is a polyhedron: {entries on their rays, strict ones 0} and {the residuals are those of the"
            " optimum}; from z' on the rays its distance is at most H times ||(X'(w'-w*),"
            " sqrt(lambda1)(X(u'-u*) - (w'-w*)))||",
            HOFFMAN,
        ),
        real(
            "growth-sum",
            "z' the projection of z on the rays, x = ||z - z'||, y the residual of z: dist <= x + H(y + N"
            " x), so dist^2 <= 2(1+HN)^2 x^2 + 2H^2 y^2 <= const (F - F*)",
            ["x >= 0", "y >= 0", "H >= 0", "K >= 0", "D >= 0", "D <= K*x + H*y"],
            "D**2 <= 2*K**2*x**2 + 2*H**2*y**2",
        ),
    )


def subgradient() -> tuple[Step, ...]:
    """F(i+1) - F* <= <xi, z - z*> with xi a subgradient that the last step made small."""
    return (
        matrix_identity(
            "rate-lag",
            "the row of w has the old u: v(w, u) - v(w, u+du) = 2 lambda1 X du (v as in limit-row-w)",
            "(2*X*(X.T*w - o) - 2*l1*(X*u - w)) - (2*X*(X.T*w - o) - 2*l1*(X*(u + du) - w))",
            "2*l1*X*du",
        ),
        matrix_identity(
            "rate-lag-jacobi",
            "Jacobi: the row of u has the old w: g(w, u) - g(w+dw, u) = 2 lambda1 X'dw (Gauss-Seidel: none)",
            "2*l1*X.T*(X*u - w) - 2*l1*X.T*(X*u - (w + dw))",
            "2*l1*X.T*dw",
        ),
        identity(
            "rate-subgradient",
            "so xi_j = v_j(z) + lambda2 y/b = lambda2 y (a-b)/(a b) - lag, with v_j + lag = -lambda2 y/a, y"
            " = w_j(i+1), b = |y|, a = |w_j(i)|; likewise for a block",
            "-l*y/a - m + l*y/b",
            "l*y*(a - b)/(a*b) - m",
        ),
        real(
            "rate-support",
            "where a >= m > 0 that term is at most (lambda2/m)|dw_j| (|a - b| <= |dw_j| = s, |y| = b)",
            ["m > 0", "a >= m", "b > 0", "abs(a - b) <= s", "l > 0"],
            "m*l*abs(a - b) <= l*s*a",
        ),
        real(
            "rate-strict",
            "where b <= t a, t < 1 (strict): the term times w_j - w*_j = y is lambda2 b(a-b)/a, at most"
            " 2t/(1-t) times its share lambda2 (a-b)^2/(2a) <= lambda2 dw_j^2/(2a) of the fall",
            ["a > 0", "b >= 0", "t > 0", "t < 1", "b <= t*a"],
            "(1-t)*b*(a-b) <= t*(a-b)**2",
        ),
        real(
            "rate-steps",
            "dw_j^2 + ||du||^2 <= const fall: A_j, B_i >= m > 0 (limit-weights)",
            ["m > 0", "A >= m", "B >= m", "R >= 0", "s == R + A*x**2 + B*y**2"],
            "m*(x**2 + y**2) <= s",
        ),
    )


def contraction() -> tuple[Step, ...]:
    """The estimates together."""
    return (
        real(
            "rate-combine",
            "F(i+1) - F* <= a ||dz|| dist + b fall <= p x y + q y^2, x^2 = F(i+1) - F*, y^2 = fall: x^2 <="
            " (p^2+2q) y^2",
            ["x >= 0", "y >= 0", "p >= 0", "q >= 0", "x**2 <= p*x*y + q*y**2"],
            "x**2 <= (p**2 + 2*q)*y**2",
        ),
        real(
            "rate-linear",
            "E(i+1) <= C (E(i) - E(i+1)) gives E(i+1) <= C/(1+C) E(i), E = F - F*",
            ["C > 0", "E1 <= C*(E0 - E1)"],
            "(1 + C)*E1 <= C*E0",
        ),
    )


def example() -> tuple[Step, ...]:
    """X = o = 1, lambda1 = 0, lambda2 = 2, from w = 1."""
    return (
        identity(
            "example-update",
            "the system of w > 0: (1 + 2/(2w)) w' = 1 has w' = w/(w+1)",
            "(1 + 2*(1/(2*w)))*(w/(w + 1))",
            "1",
        ),
        identity(
            "example-iterates",
            "w(0) = 1 solves the least-squares problem; w(k) = 1/(k+1) makes w(k+1) = 1/(k+2)",
            "(1/(k + 1))/(1/(k + 1) + 1)",
            "1/(k + 2)",
        ),
        real(
            "example-optimum",
            "F = (w-1)^2 + 2|w| >= 1, equality at w = 0 only: F* = 1",
            [],
            "(w - 1)**2 + 2*abs(w) >= 1 and ((w - 1)**2 + 2*abs(w) == 1) == (w == 0)",
        ),
        identity(
            "example-error",
            "F - F* = w^2 = 1/(k+1)^2 for w = 1/(k+1)",
            "(1/(k + 1) - 1)**2 + 2*(1/(k + 1)) - 1",
            "1/(k + 1)**2",
        ),
        exact(
            "example-not-strict",
            "at w = 0 |v| = |2(0 - 1)| is lambda2 = 2: the zero is not strict",
            "abs(2*(0 - 1)) == 2",
        ),
        real(
            "example-not-linear",
            "1/(k+2)^2 > q/(k+1)^2 for every q < 1 once k(1-q) >= 4: no rate q",
            ["k >= 0", "q >= 0", "q < 1", "k*(1 - q) >= 4"],
            "(k + 1)**2 > q*(k + 2)**2",
        ),
        identity(
            "example-coupled",
            "with lambda1 > 0 and u = 0 the same: (1 + lambda1 + 2/(2w)) w' = 1 at w = 1/((1+lambda1)k + 1)"
            " gives w' = 1/((1+lambda1)(k+1) + 1)",
            "(1 + l1 + ((1 + l1)*k + 1))*(1/((1 + l1)*(k + 1) + 1))",
            "1",
        ),
    )
