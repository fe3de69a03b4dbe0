"""Claims D1, D2, L1, L2, A1 and A2: the derivatives and the inequalities of the appendix, made true."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.norms import (
    cauchy_schwarz,
    majorise_modality,
    majorise_view,
    slope_modality,
    slope_view,
    squares,
)


def arguments() -> tuple[Argument, ...]:
    """D1/corrected, D2/corrected, L1/inequality, L2/elementwise, A1/lambda1_one, A2/elementwise."""
    return derivative_w(), derivative_u(), lemma(), lemma_elementwise(), objective_one(), substitution()


def derivative_w() -> Argument:
    """D1/corrected."""
    steps = (
        matrix_identity(
            "derivative-w",
            "the squares of F change by h'(2XX'w - 2Xo - 2 lambda1 Xu + 2 lambda1 w) + h'(XX' + lambda1 I)h",
            f"{squares('w + h', 'u')} - {squares('w', 'u')}",
            "h.T*(2*X*X.T*w - 2*X*o - 2*l1*X*u + 2*l1*w) + h.T*(X*X.T + l1*In)*h",
        ),
        slope_view(),
        identity(
            "derivative-w-diagonal",
            "and w_j/|w_j| is (D w)_j with D = diag(1/|w_j|)",
            "w/s",
            "(1/s)*w",
        ),
    )
    return Argument("D1/corrected", "dF/dw has D = diag(1/|w_i|), without a factor 1/2.", "", steps)


def derivative_u() -> Argument:
    """D2/corrected."""
    steps = (
        matrix_identity(
            "derivative-u",
            "the squares of F change by k'(2 lambda1 X'Xu - 2 lambda1 X'w) + lambda1 ||Xk||^2",
            f"{squares('w', 'u + k')} - {squares('w', 'u')}",
            "k.T*(2*l1*X.T*X*u - 2*l1*X.T*w) + l1*(X*k).T*(X*k)",
        ),
        *cauchy_schwarz(),
        slope_modality(),
        identity(
            "derivative-u-diagonal",
            "and u^i/||u^i|| is (D u)^i with D = blockdiag(I/||u^i||), entry by entry",
            "u/r",
            "(1/r)*u",
        ),
    )
    return Argument("D2/corrected", "dF/du has D = blockdiag(I/||u^i||), without a factor 1/2.", "", steps)


def lemma() -> Argument:
    """L1/inequality, where its terms are defined."""
    steps = (
        *majorise_modality(),
        identity(
            "lemma-right",
            "||v|| - ||v||^2/(2||v||) = ||v||/2",
            "b - b**2/(2*b)",
            "b/2",
        ),
    )
    conclusion = "||t|| - ||t||^2/(2||v||) <= ||v|| - ||v||^2/(2||v||) for all t and all v != 0."
    return Argument("L1/inequality", conclusion, "v != 0", steps)


def lemma_elementwise() -> Argument:
    """L2/elementwise."""
    conclusion = "sum_j (|t_j| - t_j^2/(2|v_j|)) <= ||v||_1/2: the inequality of each entry, summed over j."
    return Argument("L2/elementwise", conclusion, "", majorise_view())


def objective_one() -> Argument:
    """A1/lambda1_one, and that no other lambda1 will do."""
    steps = (
        matrix_identity(
            "objective-one",
            "F without lambda1 is F with lambda1 = 1 (the penalties are the same, once renumbered)",
            "(X.T*w - o).T*(X.T*w - o) + (X*u - w).T*(X*u - w)",
            squares("w", "u").replace("l1", "1"),
        ),
        real(
            "objective-only-one",
            "where Xu != w the two agree for lambda1 = 1 only (q = ||Xu-w||^2 > 0, R the other terms)",
            ["q > 0", "R + q == R + l1*q"],
            "l1 == 1",
        ),
    )
    return Argument("A1/lambda1_one", "The appendix's objective is F with lambda1 = 1.", "", steps)


def substitution() -> Argument:
    """A2/elementwise."""
    steps = (
        real(
            "substitution-left",
            "v_j^2/(2|v_j|) = |v_j|/2: the left side at w = v is ||v||_1/2",
            ["v != 0"],
            "2*v**2 == abs(v)*(2*abs(v))",
        ),
        identity(
            "substitution-sides",
            "the two sides at w = v, S = ||v||_1, T = ||v||_2^2: S/2 - T/(2S) = (S^2 - T)/(2S)",
            "S/2 - T/(2*S)",
            "(S**2 - T)/(2*S)",
        ),
        identity(
            "substitution-cross",
            "one more entry a = |v_j| adds 2aS to S^2 - T, which is 0 for one entry",
            "(S + a)**2 - (T + a**2)",
            "(S**2 - T) + 2*a*S",
        ),
        real(
            "substitution-zero",
            "so S^2 - T >= 0 stays, and is 0 after the entry if and only if it was before and aS = 0; by"
            " induction if and only if at most one entry is not 0",
            ["S >= 0", "a >= 0", "c >= 0"],
            "c + 2*a*S >= 0 and (c + 2*a*S == 0) == (c == 0 and (a == 0 or S == 0))",
        ),
    )
    conclusion = "At w = v the two sides agree if and only if at most one entry is not 0."
    return Argument("A2/elementwise", conclusion, "v != 0, and 0/0 on the left is read as 0", steps)
