"""Claims F3 and F4: where the optimum is zero, why zeros are exact, and what shape u has."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.norms import (
    bracket_modality,
    bracket_view,
    cauchy_schwarz,
    quadratic_part,
    squares,
)
from verification.proofs.unchecked import joints


def arguments() -> tuple[Argument, ...]:
    """F3/critical_lambda2, F3/exact_zeros, F4/parallel."""
    return critical(), exact_zeros(), parallel()


def zero_is_optimal() -> tuple[Step, ...]:
    """lambda2 >= 2 max |x_j'o| makes w = u = 0 optimal."""
    return (
        matrix_identity(
            "zero-difference",
            "the change of the two squares of F from w and u both 0",
            f"{squares('w', 'u')} - o.T*o",
            "(X.T*w).T*(X.T*w) + l1*(X*u - w).T*(X*u - w) - 2*w.T*X*o",
        ),
        bracket_view(),
        *joints("sums"),
    )


def critical() -> Argument:
    """F3/critical_lambda2, both directions."""
    steps = (
        *zero_is_optimal(),
        real(
            "zero-fall",
            "below the critical lambda2 one coordinate of the sign of (Xo)_j lowers F from its value at 0",
            ["D > 0", "N > 0", "2*N*t == D"],
            "N*t**2 - t*D < 0",
            D="2|(Xo)_j| - lambda2",
            N="||x_j||^2 + lambda1",
            t="the size of that coordinate",
        ),
        *joints("along"),
    )
    conclusion = (
        "w = u = 0 is optimal if and only if lambda2 >= 2 max_j |x_j'o|, for all lambda1, lambda3 >= 0."
    )
    return Argument("F3/critical_lambda2", conclusion, "", steps)


def exact_zeros() -> Argument:
    """F3/exact_zeros: at an optimum, and near one."""
    steps = (quadratic_part(), *cauchy_schwarz(), *strict_zero(), *joints("along"), *gap(), *radius())
    conclusion = (
        "At an optimum |v_j| < lambda2 makes w*_j exactly 0, and ||g^i|| < lambda3 makes u*^i exactly 0. A"
        " feasible dual point (a, b) with F* - D(a, b) <= gap proves the first where |(Xa-b)_j| + 2 sqrt(gap"
        " (||x_j||^2 + lambda1)) < lambda2, and the second where ||X_i'b|| + 2 ||X_i|| sqrt(gap lambda1) <"
        " lambda3."
    )
    return Argument("F3/exact_zeros", conclusion, "", steps)


def strict_zero() -> tuple[Step, ...]:
    """Shrinking what is not 0 would lower F."""
    return (
        real(
            "strict-zero",
            "an entry that is not 0 although v_j is small: shrinking it by the factor 1 - t lowers F",
            ["abs(v) < l", "w != 0", "N >= 0", "t*(v*w + l*abs(w) + N*w**2) == v*w + l*abs(w)"],
            "-t*v*w + N*t**2*w**2 + l*(abs(w - t*w) - abs(w)) < 0",
            v="v_j",
            w="w_j",
            l="lambda2",
            N="||x_j||^2 + lambda1",
            t="a number that the third hypothesis chooses, between 0 and 1",
        ),
        real(
            "strict-zero-modality",
            "a block likewise",
            ["G < l", "r > 0", "c >= -G*r", "N >= 0", "t*(c + l*r + N) == c + l*r"],
            "t <= 1 and -t*c + N*t**2 - t*l*r < 0",
            G="||g^i||",
            l="lambda3",
            r="||u^i||",
            c="g^i'u^i",
            N="lambda1 ||X_i u^i||^2",
            t="a number that the last hypothesis chooses, above 0",
        ),
    )


def gap() -> tuple[Step, ...]:
    """The gap of any point and any dual point, as squares and brackets."""
    return (
        matrix_identity(
            "gap-identity",
            "the two squares of F less the dual value, expanded around a dual point (a, b)",
            f"{squares('w', 'u')} + a.T*o + a.T*a/4 + l1*e.T*e",
            "(X.T*w - o - a/2).T*(X.T*w - o - a/2) + l1*(X*u - w - e).T*(X*u - w - e)"
            " + w.T*(X*a - 2*l1*e) + 2*l1*u.T*X.T*e",
            a="the first part of the dual point",
            e="b/(2 lambda1), b the second part",
        ),
        bracket_view(),
        bracket_modality(),
        *joints("gap", "sums"),
    )


def radius() -> tuple[Step, ...]:
    """How far the optimal v and g lie from those of a dual point with a small gap."""
    return (
        matrix_identity(
            "zero-view",
            "v at an optimum (w, u) less Xa - b, by the vectors whose squares the gap bounds",
            "2*X*(X.T*w - o) - 2*l1*(X*u - w) - (X*a - 2*l1*e)",
            "2*X*(X.T*w - o - a/2) - 2*l1*(X*u - w - e)",
            a="the first part of the dual point",
            e="b/(2 lambda1), b the second part",
        ),
        identity(
            "zero-radius-square",
            "the inequality of Cauchy and Schwarz for two pairs of numbers, with its remainder",
            "(n**2 + l)*(s**2 + l*t**2)",
            "(n*s + l*t)**2 + l*(n*t - s)**2",
            n="||x_j||",
            l="lambda1",
            s="||p* - a/2||",
            t="||q* - b/(2 lambda1)||",
        ),
        real(
            "zero-radius",
            "so v_j is within 2 sqrt(gap (||x_j||^2 + lambda1)) of (Xa - b)_j, both squared",
            [
                *("l1 >= 0", "abs(c) <= p", "abs(z) <= t", "N >= 0", "Q <= e"),
                *("N*Q == r**2 + l1*k**2", "r == p + l1*t"),
            ],
            "(2*c - 2*l1*z)**2 <= 4*N*e",
            c="x_j'(p* - a/2)",
            p="||x_j|| ||p* - a/2||",
            z="entry j of q* - b/(2 lambda1)",
            t="||q* - b/(2 lambda1)||",
            N="||x_j||^2 + lambda1",
            Q="||p* - a/2||^2 + lambda1 t^2",
            r="the root of the first square of zero-radius-square",
            k="that of the second",
            e="gap",
        ),
        real(
            "zero-radius-modality",
            "and g^i is within 2 ||X_i|| sqrt(gap lambda1) of X_i'b, both squared",
            ["l1 >= 0", "0 <= r", "r <= 2*l1*n*t", "l1*t**2 <= e"],
            "r**2 <= 4*l1*n**2*e",
            r="||2 lambda1 X_i'(q* - b/(2 lambda1))||",
            n="||X_i||, a norm that bounds ||X_i'y|| by ||X_i|| ||y||",
            t="||q* - b/(2 lambda1)||",
            e="gap",
        ),
        real(
            "zero-proof",
            "a number within R of one that is below lambda2 by more than R; norms of blocks likewise",
            ["abs(v - s) <= R", "abs(v) + R < l"],
            "abs(s) < l",
            v="(Xa - b)_j, or ||X_i'b||",
            s="v_j, or ||g^i||, at an optimum",
            R="the radius",
            l="lambda2, or lambda3",
        ),
        *joints("norms"),
    )


def parallel() -> Argument:
    """F4/parallel."""
    steps = (
        quadratic_part(),
        *cauchy_schwarz(),
        real(
            "block-slope",
            "a block scaled by 1 + t: the slope in t is 0 at an optimum, or some t would lower F",
            ["N >= 0", "k != 0", "t*2*(N + abs(k)) == -k"],
            "abs(t) < 1 and t*k + N*t**2 < 0",
            k="g^i'u^i + lambda3 ||u^i||, the slope",
            N="lambda1 ||X_i u^i||^2",
            t="the change of the factor",
        ),
        real(
            "block-bound",
            "t g^i taken from a block: ||g^i|| is at most lambda3 at an optimum, or some t would lower F",
            ["l >= 0", "G > l", "N >= 0", "t*2*(N + 1) == G*(G - l)"],
            "t > 0 and -t*G**2 + l*t*G + N*t**2 < 0",
            G="||g^i||",
            l="lambda3",
            N="lambda1 ||X_i g^i||^2",
            t="the size of the change",
        ),
        matrix_identity(
            "block-square",
            "the square of lambda3 u + r g, a block and its multiple of g",
            "(l3*u + r*g).T*(l3*u + r*g)",
            "l3**2*u.T*u + 2*l3*r*g.T*u + r**2*g.T*g",
            r="||u^i||",
            g="g^i",
        ),
        real(
            "block-parallel",
            "that square is 0 at an optimum, so u^i is a negative multiple of g^i",
            [
                *("G >= 0", "G <= l", "c == -l*r", "S >= 0"),
                "S == l**2*r**2 + 2*l*r*c + r**2*G**2",
            ],
            "S == 0",
            l="lambda3",
            r="||u^i||",
            G="||g^i||",
            c="g^i'u^i",
            S="||lambda3 u^i + r g^i||^2",
        ),
        real(
            "block-equal",
            "equal columns of X_i have equal entries of g^i, hence equal weights",
            ["l > 0", "l*u == -r*g", "l*y == -r*h", "g == h"],
            "u == y",
            l="lambda3",
            r="||u^i||",
            u="the weight of the first column",
            y="the weight of the second",
            g="the entry of g^i for the first",
            h="the entry for the second",
        ),
        *joints("along", "norms"),
    )
    conclusion = "u*^i = -(||u*^i||/lambda3) X_i'b: zero as a whole, or shaped by the data alone."
    return Argument("F4/parallel", conclusion, "lambda3 > 0", steps)
