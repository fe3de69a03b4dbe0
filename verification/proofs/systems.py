"""Claims C1, N1 and R1: the two linear systems, and when a label is defined."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import exact
from verification.proofs.checkers.reals import real
from verification.proofs.zeros import zero_is_optimal


def arguments() -> tuple[Argument, ...]:
    """N1/positive, C1/woodbury, R1/separated, R1/all_zero."""
    return positive(), woodbury(), separated(), all_zero()


def positive() -> Argument:
    """N1/positive."""
    steps = (
        matrix_identity(
            "positive-w",
            "h'(XX' + lambda1 I + A)h = ||X'h||^2 + lambda1 ||h||^2 + h'A h",
            "h.T*(X*X.T + l1*In + A)*h",
            "(X.T*h).T*(X.T*h) + l1*h.T*h + h.T*A*h",
        ),
        matrix_identity(
            "positive-u",
            "k'(lambda1 X'X + B)k = lambda1 ||Xk||^2 + k'B k",
            "k.T*(l1*X.T*X + B)*k",
            "l1*(X*k).T*(X*k) + k.T*B*k",
        ),
        real(
            "positive-sign",
            "both are > 0 for a vector that is not 0: lambda1 > 0 in w; B_i = factor lambda3/(2||u^i||) > 0"
            " in u (s: the norm of h or of the entry of k; S the other squares)",
            ["S >= 0", "l > 0", "s > 0"],
            "S + l*s**2 > 0",
        ),
    )
    conclusion = "With |w_i| for w_i and no exact zero both matrices are positive definite, for both factors."
    return Argument("N1/positive", conclusion, "", steps)


def woodbury() -> Argument:
    """C1/woodbury."""
    steps = (
        matrix_identity(
            "woodbury-push",
            "(lambda1 X'X + E) Ei X' = X'(I + lambda1 X Ei X') for every invertible E, Ei = E^-1",
            "(l1*X.T*X + E)*Ei*X.T",
            "X.T*(In + l1*X*Ei*X.T)",
        ),
        matrix_identity(
            "woodbury-solve",
            "so u = lambda1 Ei X'y with (I + lambda1 X Ei X')y = w solves (lambda1 X'X + E)u = lambda1 X'w",
            "(l1*X.T*X + E)*(l1*Ei*X.T*y) - l1*X.T*w",
            "l1*X.T*((In + l1*X*Ei*X.T)*y - w)",
        ),
        matrix_identity(
            "woodbury-positive",
            "h'(I + lambda1 X Ei X')h = ||h||^2 + lambda1 (X'h)'Ei(X'h) > 0: the n x n system has one"
            " solution",
            "h.T*(In + l1*X*Ei*X.T)*h",
            "h.T*h + l1*(X.T*h).T*Ei*(X.T*h)",
        ),
        real(
            "woodbury-count",
            "its multiplications: Ei X' nd, X(Ei X') n^2 d, times lambda1 n^2, elimination n^3/3 + n^2, X'y"
            " nd, Ei and lambda1 2d: at most 8(n^2 d + n^3)",
            ["n >= 1", "d >= 1"],
            "n*d + n**2*d + n**2 + n**3/3 + n**2 + n*d + 2*d <= 8*(n**2*d + n**3)",
        ),
        real(
            "woodbury-order",
            "which is at most 16 d^2 where n^2 <= d: the order that the paper states",
            ["n >= 1", "d >= n**2"],
            "8*(n**2*d + n**3) <= 16*d**2",
        ),
    )
    conclusion = "Step 7 costs O(n^2 d + n^3) by this identity, which is O(d^2) where n^2 <= d."
    return Argument("C1/woodbury", conclusion, "lambda3 > 0, and blocks of u that are 0 are left out", steps)


def separated() -> Argument:
    """R1/separated."""
    steps = (
        real(
            "separated-proof",
            "lower <= F* <= upper for both, upper_b < lower_j: F*_b < F*_j",
            ["a <= Fb", "Fb <= b", "c <= Fj", "Fj <= e", "b < c"],
            "Fb < Fj",
        ),
        real(
            "separated-unique",
            "two templates that both have the lowest optimum have the same one: the label is unique if and"
            " only if the lowest optimum is below all others",
            [],
            "(Fa <= Fb and Fb <= Fa) == (Fa == Fb)",
        ),
    )
    conclusion = (
        "upper_best < lower_j for all other j proves the label; a label is defined exactly without a tie."
    )
    return Argument("R1/separated", conclusion, "", steps)


def all_zero() -> Argument:
    """R1/all_zero."""
    steps = (
        *zero_is_optimal(),
        matrix_identity(
            "all-zero-value",
            "F(0, 0) = ||0 - o||^2 = ||o||^2, which no view enters",
            "(X.T*(w - w) - o).T*(X.T*(w - w) - o)",
            "o.T*o",
        ),
        exact(
            "all-zero-example",
            "n = d = 1, X = 1 or X = -1, o = 1 or 2, lambda2 = 4: F* is 1 and 4, the template 1 wins",
            "4 >= 2*abs(1*1) and 4 >= 2*abs(1*2) and 4 >= 2*abs(-1*2) and 1**2 < 2**2",
        ),
    )
    conclusion = "Then F*_j = ||o_j||^2 for every template: the shortest one wins, whatever the robots see."
    return Argument("R1/all_zero", conclusion, "", steps)
