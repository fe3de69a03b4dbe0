"""Claims F3 and F4: where the optimum is zero, why zeros are exact, and what shape u has."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.norms import cauchy_schwarz, quadratic_part, squares


def arguments() -> tuple[Argument, ...]:
    """F3/critical_lambda2, F3/exact_zeros, F4/parallel."""
    return critical(), exact_zeros(), parallel()


def zero_is_optimal() -> tuple[Step, ...]:
    """lambda2 >= 2 max |x_j'o| makes w = u = 0 optimal."""
    return (
        matrix_identity(
            "zero-difference",
            "f(w, u) - f(0, 0) = ||X'w||^2 + lambda1 ||Xu-w||^2 - 2 w'Xo, f the two squares of F",
            f"{squares('w', 'u')} - o.T*o",
            "(X.T*w).T*(X.T*w) + l1*(X*u - w).T*(X*u - w) - 2*w.T*X*o",
        ),
        real(
            "zero-below",
            "lambda2 |w_j| - 2 w_j (Xo)_j >= 0 where lambda2 >= 2 |(Xo)_j|; summed over j, F(w, u) >= F(0,"
            " 0)",
            ["l >= 2*abs(c)"],
            "l*abs(w) - 2*w*c >= 0",
        ),
    )


def critical() -> Argument:
    """F3/critical_lambda2, both directions."""
    steps = (
        *zero_is_optimal(),
        identity(
            "zero-fall",
            "else w = t e_j, u = 0, t of the sign of (Xo)_j, |t| = D/(2N), D = 2|(Xo)_j| - lambda2, N ="
            " ||x_j||^2 + lambda1: F(t e_j, 0) - F(0, 0) = N t^2 - |t| D = -D^2/(4N)",
            "N*(D/(2*N))**2 - (D/(2*N))*D",
            "-D**2/(4*N)",
        ),
        real(
            "zero-fall-sign",
            "which is < 0 for D > 0; N > 0 since x_j'o is not 0",
            ["D > 0", "N > 0"],
            "-D**2 < 0 and 4*N > 0",
        ),
    )
    conclusion = (
        "w = u = 0 is optimal if and only if lambda2 >= 2 max_j |x_j'o|, for all lambda1, lambda3 >= 0."
    )
    return Argument("F3/critical_lambda2", conclusion, "", steps)


def exact_zeros() -> Argument:
    """F3/exact_zeros: at an optimum, and by a proof from any point with a gap."""
    steps = (
        quadratic_part(),
        real(
            "strict-zero",
            "|v_j| < lambda2 and w_j != 0: shrinking w_j by the factor 1 - t lowers F, t = D/(D + N w_j^2),"
            " D = v_j w_j + lambda2 |w_j|, N = ||x_j||^2 + lambda1; so w_j = 0 at an optimum",
            ["abs(v) < l", "w != 0", "N >= 0", "t*(v*w + l*abs(w) + N*w**2) == v*w + l*abs(w)", "t > 0"],
            "-t*v*w + N*t**2*w**2 + l*(abs(w - t*w) - abs(w)) < 0",
        ),
        matrix_identity(
            "gap-identity",
            "for every (w, u) and dual (a, b), b = 2 lambda1 e: f(w, u) + a'o + ||a||^2/4 + lambda1 ||e||^2"
            " = ||p - a/2||^2 + lambda1 ||q - e||^2 + w'(Xa - b) + u'X'b, p = X'w - o, q = Xu - w",
            f"{squares('w', 'u')} + a.T*o + a.T*a/4 + l1*e.T*e",
            "(X.T*w - o - a/2).T*(X.T*w - o - a/2) + l1*(X*u - w - e).T*(X*u - w - e)"
            " + w.T*(X*a - 2*l1*e) + 2*l1*u.T*X.T*e",
        ),
        real(
            "gap-bracket",
            "at a dual feasible point lambda2 |w_j| + w_j (Xa-b)_j >= 0, and likewise lambda3 ||u^i|| +"
            " u^i'X_i'b: at an optimum (w*, u*) this leaves ||p* - a/2||^2 + lambda1 ||q* - e||^2 <= F* -"
            " D(a, b) <= gap",
            ["abs(v) <= l"],
            "l*abs(w) + w*v >= 0",
        ),
        real(
            "gap-bracket-modality",
            "the same for a block: c = u'X_i'b >= -||u|| ||X_i'b||",
            ["G >= 0", "G <= l", "r >= 0", "c >= -r*G"],
            "l*r + c >= 0",
        ),
        real(
            "zero-radius",
            "so v_j = (Xa-b)_j is within a radius R of v*_j, and |v_j| + R < lambda2 proves |v*_j| < lambda2",
            ["abs(v - s) <= R", "abs(v) + R < l"],
            "abs(s) < l",
        ),
    )
    conclusion = (
        "At an optimum |v_j| < lambda2 makes w*_j exactly 0, and a small gap proves |v*_j| < lambda2."
    )
    return Argument("F3/exact_zeros", conclusion, "", steps)


def parallel() -> Argument:
    """F4/parallel."""
    steps = (
        quadratic_part(),
        *cauchy_schwarz(),
        real(
            "block-slope",
            "u^i scaled by 1 + t at an optimum: F changes by t k + N t^2, k = g'u + lambda3 r, r = ||u^i||,"
            " g = X_i'b, N = lambda1 ||X_i u^i||^2; k != 0 would let it fall at t = -k/(2(N + |k|)); so g'u"
            " = -lambda3 r",
            ["N >= 0", "k != 0", "t*2*(N + abs(k)) == -k"],
            "abs(t) < 1 and t*k + N*t**2 < 0",
        ),
        real(
            "block-bound",
            "-t g added to u^i: F changes by at most -tG^2 + lambda3 tG + N t^2, G = ||g||; G > lambda3 would"
            " let it fall; so G <= lambda3",
            ["l >= 0", "G > l", "N >= 0", "t*2*(N + 1) == G*(G - l)"],
            "t > 0 and -t*G**2 + l*t*G + N*t**2 < 0",
        ),
        matrix_identity(
            "block-square",
            "||lambda3 u + r g||^2 = lambda3^2 ||u||^2 + 2 lambda3 r g'u + r^2 ||g||^2",
            "(l3*u + r0*g).T*(l3*u + r0*g)",
            "l3**2*u.T*u + 2*l3*r0*g.T*u + r0**2*g.T*g",
        ),
        real(
            "block-parallel",
            "with ||u|| = r, g'u = -lambda3 r and ||g|| <= lambda3 that square is 0: lambda3 u^i = -r g",
            [
                *("l >= 0", "r >= 0", "G >= 0", "G <= l", "c == -l*r", "S >= 0"),
                "S == l**2*r**2 + 2*l*r*c + r**2*G**2",
            ],
            "S == 0",
        ),
        real(
            "block-equal",
            "equal columns k, l of X_i have g_k = g_l, so u_k = u_l",
            ["l > 0", "l*u == -r*g", "l*y == -r*h", "g == h"],
            "u == y",
        ),
    )
    conclusion = "u*^i = -(||u*^i||/lambda3) X_i'b: zero as a whole, or shaped by the data alone."
    return Argument("F4/parallel", conclusion, "lambda3 > 0", steps)
