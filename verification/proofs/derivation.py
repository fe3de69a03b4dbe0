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
from verification.proofs.unchecked import joints

ENTRIES = {"S": "||v||_1", "a": "the size of one more entry"}


def arguments() -> tuple[Argument, ...]:
    """D1/corrected, D2/corrected, L1/inequality, L2/elementwise, A1/lambda1_one, A2/elementwise."""
    return derivative_w(), derivative_u(), lemma(), lemma_elementwise(), objective_one(), substitution()


def derivative_w() -> Argument:
    """D1/corrected."""
    steps = (
        matrix_identity(
            "derivative-w",
            "the two squares of F in w: the linear part is the printed derivative without D",
            f"{squares('w + h', 'u')} - {squares('w', 'u')}",
            "h.T*(2*X*X.T*w - 2*X*o - 2*l1*X*u + 2*l1*w) + h.T*(X*X.T + l1*In)*h",
        ),
        slope_view(),
        *joints("derivative"),
    )
    return Argument("D1/corrected", "dF/dw has D = diag(1/|w_i|), without a factor 1/2.", "", steps)


def derivative_u() -> Argument:
    """D2/corrected."""
    steps = (
        matrix_identity(
            "derivative-u",
            "the two squares of F in u: the linear part is the printed derivative without D",
            f"{squares('w', 'u + k')} - {squares('w', 'u')}",
            "k.T*(2*l1*X.T*X*u - 2*l1*X.T*w) + l1*(X*k).T*(X*k)",
        ),
        *cauchy_schwarz(),
        slope_modality(),
        *joints("norms", "derivative"),
    )
    return Argument("D2/corrected", "dF/du has D = blockdiag(I/||u^i||), without a factor 1/2.", "", steps)


def lemma() -> Argument:
    """L1/inequality, where its terms are defined."""
    steps = (
        *majorise_modality(),
        identity(
            "lemma-right",
            "the right side of the lemma is half the norm",
            "b - b**2/(2*b)",
            "b/2",
            b="||v||",
        ),
        *joints("norms"),
    )
    conclusion = "||t|| - ||t||^2/(2||v||) <= ||v|| - ||v||^2/(2||v||) for all t and all v != 0."
    return Argument("L1/inequality", conclusion, "v != 0", steps)


def lemma_elementwise() -> Argument:
    """L2/elementwise."""
    conclusion = (
        "sum_j (|t_j| - t_j^2/(2|v_j|)) <= ||v||_1/2 where no v_j is 0: the inequality of each entry, summed"
        " over j."
    )
    return Argument("L2/elementwise", conclusion, "", (*majorise_view(), *joints("sums")))


def objective_one() -> Argument:
    """A1/lambda1_one, and that no other lambda1 will do."""
    steps = (
        matrix_identity(
            "objective-one",
            "F less the appendix's objective, whose penalties are the same once they are renumbered",
            f"{squares('w', 'u')} - ((X.T*w - o).T*(X.T*w - o) + (X*u - w).T*(X*u - w))",
            "(l1 - 1)*(X*u - w).T*(X*u - w)",
        ),
        real(
            "objective-only-one",
            "so where Xu and w differ the two agree if and only if lambda1 is 1",
            ["q > 0"],
            "((l1 - 1)*q == 0) == (l1 == 1)",
            q="||Xu - w||^2",
        ),
    )
    return Argument("A1/lambda1_one", "The appendix's objective is F with lambda1 = 1.", "", steps)


def substitution() -> Argument:
    """A2/elementwise."""
    steps = (
        real(
            "substitution-left",
            "an entry of the left side at w equal to v (times 2|v_j|): half the absolute value",
            [],
            "v**2 == abs(v)*abs(v)",
            v="v_j",
        ),
        identity(
            "substitution-sides",
            "the two sides at w equal to v differ by this",
            "S/2 - T/(2*S)",
            "(S**2 - T)/(2*S)",
            S="||v||_1",
            T="||v||_2^2",
        ),
        identity(
            "substitution-cross",
            "what one more entry adds to the numerator, which is 0 for one entry",
            "(S + a)**2 - (T + a**2)",
            "(S**2 - T) + 2*a*S",
            **ENTRIES,
            T="||v||_2^2",
        ),
        real(
            "substitution-zero",
            "the numerator stays at or above 0, and is 0 as long as no second entry differs from 0",
            ["S >= 0", "a >= 0", "c >= 0"],
            "c + 2*a*S >= 0 and (c + 2*a*S == 0) == (c == 0 and (a == 0 or S == 0))",
            **ENTRIES,
            c="||v||_1^2 - ||v||_2^2 before it",
        ),
        *joints("sums", "induction"),
    )
    conclusion = "At w = v the two sides agree if and only if at most one entry is not 0."
    return Argument("A2/elementwise", conclusion, "v != 0, and 0/0 on the left is read as 0", steps)
