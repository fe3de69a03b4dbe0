"""Claim T1c/limit: the corrected update reaches the optimum unless an entry or a block is exactly 0."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import cited, identity
from verification.proofs.checkers.reals import real
from verification.proofs.descent import chain, fall_gauss_seidel, fall_jacobi, update
from verification.proofs.norms import (
    cauchy_schwarz,
    majorise_modality,
    majorise_view,
    quadratic_part,
    slope_modality,
    tangent_view,
)

BOLZANO_WEIERSTRASS = (
    "Bolzano and Weierstrass; W. Rudin, Principles of Mathematical Analysis, 3rd ed., theorem 3.6 (b)"
)


def arguments() -> tuple[Argument, ...]:
    """T1c/limit."""
    return (limit(),)


def limit() -> Argument:
    """T1c/limit; the Jacobi rows are checked along."""
    falls = (*majorise_view(), *majorise_modality(), *update(), fall_gauss_seidel(), fall_jacobi(), *chain())
    steps = (*falls, *vanishing(), *rows(), *stationary(), *settling(), *optimal())
    conclusion = (
        "F(i) -> F*, and w(i) and Xu(i) converge, in both orders, from every start whose iterates have no"
        " entry of w and no block of u that is exactly 0."
    )
    return Argument("T1c/limit", conclusion, "", steps)


def vanishing() -> tuple[Step, ...]:
    """The iterates are bounded and the steps tend to 0."""
    return (
        real(
            "limit-bounded",
            "lambda2 ||w||_1 <= F(0) and lambda3 ||u||_M <= F(0): the iterates are bounded",
            ["R >= 0", "l2 > 0", "l3 > 0", "W >= 0", "U >= 0", "F <= F0", "F == R + l2*W + l3*U"],
            "l2*W <= F0 and l3*U <= F0",
        ),
        real(
            "limit-weights",
            "A_j = lambda2/(2|w_j|) >= lambda2^2/(2 F(0)); likewise B_i >= lambda3^2/(2 F(0))",
            ["w > 0", "l > 0", "l*w <= F0", "A*2*w == l"],
            "2*A*F0 >= l**2",
        ),
        real(
            "limit-telescope",
            "the falls s(0), s(1), ... add up to at most F(0), by induction: S <= F(0) - F(k) passes on to k"
            " + 1",
            ["S <= F0 - Fk", "s >= 0", "Fk - Fn >= s", "Fn >= 0"],
            "S + s <= F0 - Fn and S + s <= F0",
        ),
        cited("limit-points", "a bounded sequence of points has a limit point", BOLZANO_WEIERSTRASS),
    )


def rows() -> tuple[Step, ...]:
    """What the systems say, row by row."""
    return (
        matrix_identity(
            "limit-row-w",
            "twice the system for w: v + 2A w(i+1) = 0, v = 2X(X'w(i+1) - o) - 2 lambda1 (Xu(i) - w(i+1));"
            " and 2A_j w_j(i+1) = lambda2 w_j(i+1)/|w_j(i)|",
            "2*((X*X.T + l1*In + A)*w - X*(o + l1*u))",
            "2*X*(X.T*w - o) - 2*l1*(X*u - w) + 2*A*w",
        ),
        matrix_identity(
            "limit-row-u",
            "twice the system for u: g + 2B u(i+1) = 0, g = 2 lambda1 X'(Xu(i+1) - w), w = w(i+1) or,"
            " Jacobi, w(i)",
            "2*((l1*X.T*X + B)*u - l1*X.T*w)",
            "2*l1*X.T*(X*u - w) + 2*B*u",
        ),
        real(
            "limit-ratio",
            "so |w_j(i+1)|/|w_j(i)| = |v_j|/lambda2 (s = |w_j(i)|, y = w_j(i+1)); it is 0 only if v_j = 0",
            ["s > 0", "l > 0", "s*v + l*y == 0"],
            "l*abs(y) == s*abs(v) and (y == 0) == (v == 0)",
        ),
        real(
            "limit-ratio-modality",
            "and ||u^i(i+1)||/||u^i(i)|| = ||g^i||/lambda3 (squares of r g = -lambda3 u(i+1); n ="
            " ||u^i(i+1)||)",
            ["r > 0", "l > 0", "n >= 0", "G >= 0", "l**2*n**2 == r**2*G**2"],
            "l*n == r*G",
        ),
    )


def stationary() -> tuple[Step, ...]:
    """A limit point minimises F among the points with no more non-zeros."""
    return (
        real(
            "limit-sign",
            "where |w_j(i)| >= m > 0, w_j(i+1)/|w_j(i)| differs from the sign of w_j(i) by at most |dw_j|/m"
            " -> 0",
            ["m > 0", "abs(w) >= m", "b == abs(w)", "abs(y - w) <= s"],
            "m*abs(y - w) <= s*b",
        ),
        real(
            "limit-sign-modality",
            "likewise ||u^i(i+1) - u^i(i)||/||u^i(i)|| <= ||du^i||/m for a block",
            ["m > 0", "r >= m", "s >= 0"],
            "m*s <= s*r",
        ),
        quadratic_part(),
        tangent_view(),
        *cauchy_schwarz(),
        slope_modality(),
        real(
            "limit-subspace",
            "at a limit point v_j = -lambda2 sign(w_j), g^i = -lambda3 u^i/||u^i|| on its support: a change"
            " within the support has v'h + g'k + penalties >= 0 (x, y: slopes of the penalties), so F does"
            " not fall",
            ["v == -x", "g == -y", "P >= x*h", "R >= y*k", "S >= 0"],
            "v*h + g*k + P + R + S >= 0",
        ),
    )


def settling() -> tuple[Step, ...]:
    """The residuals converge, although (w, u) need not be unique."""
    return (
        identity(
            "limit-midpoint",
            "a residual at the midpoint of two points: ((r+s)/2)^2 = r^2/2 + s^2/2 - (r-s)^2/4",
            "((r + s)/2)**2",
            "r**2/2 + s**2/2 - (r - s)**2/4",
        ),
        real(
            "limit-unique",
            "two minimisers with one support have the same residuals p = X'w - o, sqrt(lambda1)(Xu - w):"
            " else F at the midpoint were below the minimum (D: sum of weighted squares of the differences)",
            ["F1 == m", "F2 == m", "M <= (F1 + F2)/2 - D/4", "M >= m", "D >= 0"],
            "D == 0",
        ),
        real(
            "limit-separate",
            "finitely many supports: the residuals have finitely many limit points, 3r or more apart. From"
            " some i on each is within r of one of them and moves by r or less: never to another (P <= a + s"
            " + b)",
            ["r > 0", "P > 3*r", "a >= 0", "a <= r", "b >= 0", "b <= r", "s >= 0", "P <= a + s + b"],
            "s > r",
        ),
        matrix_identity(
            "limit-difference",
            "dw'dw = dw'(dw - X du) + (X'dw)'du: equal residuals (X'dw = 0, dw = X du) have equal w and Xu",
            "dw.T*dw",
            "dw.T*(dw - X*du) + (X.T*dw).T*du",
        ),
    )


def optimal() -> tuple[Step, ...]:
    """The limit satisfies the optimality conditions everywhere."""
    return (
        real(
            "limit-growth",
            "v converges with the residuals. If |v_j| > lambda2 in the limit, |w_j(i+1)| >= (1+h)|w_j(i)|, h"
            " > 0, from some i on (s = |w_j(i)| > 0, y = |w_j(i+1)|); likewise for a block",
            ["s > 0", "l > 0", "h > 0", "l*y == V*s", "V >= (1 + h)*l"],
            "y >= (1 + h)*s",
        ),
        real(
            "limit-unbounded",
            "and (1+h)^k >= 1 + kh, by induction: against boundedness. So |v_j| <= lambda2, ||g^i|| <="
            " lambda3",
            ["h > 0", "k >= 0", "P >= 1 + k*h"],
            "P*(1 + h) >= 1 + (k + 1)*h",
        ),
        real(
            "limit-kkt-zero",
            "an entry that is 0 in the limit: v_j h + lambda2 |h| >= 0 for every h",
            ["abs(v) <= l"],
            "v*h + l*abs(h) >= 0",
        ),
        real(
            "limit-kkt-zero-modality",
            "a block that is 0 in the limit: g'k + lambda3 ||k|| >= 0 for every k (c = g'k >= -G s)",
            ["G >= 0", "G <= l", "s >= 0", "c >= -G*s"],
            "c + l*s >= 0",
        ),
        real(
            "limit-optimal",
            "with the entries on the support (limit-subspace) F(z') - F(z) >= 0 for every z': z is an"
            " optimum; F(i) falls, and to F(z) on a subsequence (e, N): F(k) <= F(N) <= F* + e for k >= N",
            ["Fs <= Fk", "Fk <= FN", "FN <= Fs + e", "e > 0"],
            "abs(Fk - Fs) <= e",
        ),
    )
