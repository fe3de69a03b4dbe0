"""Claims C1, N1 and R1: the two linear systems, and when a label is defined."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import exact, identity
from verification.proofs.checkers.reals import real
from verification.proofs.unchecked import cited, joints
from verification.proofs.zeros import zero_is_optimal

INVERSE = {"E": "B, or any invertible diagonal matrix", "Ei": "its inverse"}


def arguments() -> tuple[Argument, ...]:
    """N1/positive, N1/unlikely, C1/woodbury, R1/separated, R1/all_zero."""
    return positive(), unlikely(), woodbury(), separated(), all_zero()


def positive() -> Argument:
    """N1/positive."""
    steps = (
        matrix_identity(
            "positive-w",
            "the quadratic form of the matrix for w",
            "h.T*(X*X.T + l1*In + A)*h",
            "(X.T*h).T*(X.T*h) + l1*h.T*h + h.T*A*h",
        ),
        matrix_identity(
            "positive-u",
            "the quadratic form of the matrix for u",
            "k.T*(l1*X.T*X + B)*k",
            "l1*(X*k).T*(X*k) + k.T*B*k",
        ),
        real(
            "positive-sign",
            "both are positive at a vector that is not 0",
            ["S >= 0", "l > 0", "s > 0"],
            "S + l*s**2 > 0",
            l="lambda1, or an entry of B",
            s="the norm of h, or of an entry of k that is not 0",
            S="the other squares",
        ),
        *joints("sums", "definite", "loop"),
    )
    conclusion = (
        "With |w_i| for w_i, no exact zero, lambda1 > 0 (w) and lambda3 > 0 (u), both matrices are positive"
        " definite, for both factors."
    )
    return Argument("N1/positive", conclusion, "", steps)


def unlikely() -> Argument:
    """N1/unlikely: what can be said for the printed matrix, whose sign is not that of |w_i|."""
    steps = (
        identity(
            "determinant-two",
            "with two views the determinant of a symmetric matrix plus a diagonal one is a polynomial in the"
            " diagonal, whose last coefficient is 1",
            "(a + s)*(b + t) - c**2",
            "s*t + a*t + b*s + (a*b - c**2)",
            a="the first entry of the diagonal of XX' + lambda1 I",
            b="the second",
            c="the entry beside them",
            s="the first entry of (lambda2/2) D^w",
            t="the second",
        ),
        cited(
            "zero-set",
            "a polynomial that is not the zero polynomial is 0 on a set of measure 0 alone",
            "B. S. Mityagin, The zero set of a real analytic function, Math. Notes 107 (2020) 529-530",
        ),
        *joints("determinant"),
    )
    conclusion = "The printed matrix for w is singular only where w lies in a set of measure 0."
    return Argument("N1/unlikely", conclusion, "", steps)


def woodbury() -> Argument:
    """C1/woodbury."""
    steps = (
        matrix_identity(
            "woodbury-push",
            "the identity that exchanges the two systems",
            "(l1*X.T*X + E)*Ei*X.T",
            "X.T*(In + l1*X*Ei*X.T)",
            **INVERSE,
        ),
        matrix_identity(
            "woodbury-solve",
            "so a solution y of the small system gives one of the large system",
            "(l1*X.T*X + E)*(l1*Ei*X.T*y) - l1*X.T*w",
            "l1*X.T*((In + l1*X*Ei*X.T)*y - w)",
            **INVERSE,
            y="the solution of the n x n system",
        ),
        matrix_identity(
            "woodbury-positive",
            "the quadratic form of the small matrix, positive as Ei is",
            "h.T*(In + l1*X*Ei*X.T)*h",
            "h.T*h + l1*(X.T*h).T*Ei*(X.T*h)",
            Ei=INVERSE["Ei"],
        ),
        real(
            "woodbury-count",
            "the multiplications, summed: Ei X', X(Ei X'), times lambda1, elimination, X'y, Ei and lambda1",
            ["n >= 1", "d >= 1"],
            "n*d + n**2*d + n**2 + n**3/3 + n**2 + n*d + 2*d <= 8*(n**2*d + n**3)",
            n="robots",
            d="features",
        ),
        real(
            "woodbury-order",
            "the order that the paper states, where there are many more features than views",
            ["n >= 1", "d >= n**2"],
            "8*(n**2*d + n**3) <= 16*d**2",
            n="robots",
            d="features",
        ),
        *joints("definite", "count", "loop"),
    )
    conclusion = "Step 7 costs O(n^2 d + n^3) by this identity, which is O(d^2) where n^2 <= d."
    return Argument("C1/woodbury", conclusion, "lambda3 > 0, and blocks of u that are 0 are left out", steps)


def separated() -> Argument:
    """R1/separated."""
    steps = (
        real(
            "separated-proof",
            "two intervals that do not meet order the optima in them",
            ["F <= b", "b < c", "c <= G"],
            "F < G",
            F="F* of the best template",
            b="its upper end",
            G="F* of another template",
            c="its lower end",
        ),
        *joints("label"),
    )
    conclusion = (
        "upper_best < lower_j for all other j proves the label; a label is defined exactly without a tie."
    )
    return Argument("R1/separated", conclusion, "", steps)


def all_zero() -> Argument:
    """R1/all_zero."""
    steps = (
        *zero_is_optimal(),
        *joints("zero-value"),
        exact(
            "all-zero-example",
            "both templates have their optimum at 0, with the values 1 and 4: the shorter wins",
            "4 >= 2*abs(1*1) and 4 >= 2*abs(1*2) and 4 >= 2*abs(-1*2) and 1**2 < 2**2",
            "n = d = 1, X = 1 or X = -1, o = 1 or o = 2, lambda2 = 4",
        ),
    )
    conclusion = "Then F*_j = ||o_j||^2 for every template: the shortest one wins, whatever the robots see."
    return Argument("R1/all_zero", conclusion, "", steps)
