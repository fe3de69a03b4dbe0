"""Claims F1 and F2: F is convex, bounded below and attains its minimum; its group-lasso form is the same."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.norms import cauchy_schwarz
from verification.proofs.unchecked import cited, joints

SUM = "Every term of F has this form, with a weight >= 0; the inequalities add up in every dimension."
CHORD = {"t": "where on the chord"}
WEIERSTRASS = "Weierstrass: a continuous function on a non-empty compact set attains its minimum"
TERMS = {
    "l": "lambda2 or lambda3",
    "r": "|w_j| or ||u^i|| at z or d",
    "n": "the same at the sum",
    "s": "the same at the other",
}


def arguments() -> tuple[Argument, ...]:
    """F1/convex, F1/bounded, F1/attained, F2/group_lasso."""
    return convex(), bounded(), attained(), group_lasso()


def convex() -> Argument:
    """F1/convex."""
    steps = (
        identity(
            "convex-square",
            "a residual is affine in (w, u); the chord of its square exceeds the square on it by a square",
            "((1-t)*r + t*s)**2",
            "(1-t)*r**2 + t*s**2 - t*(1-t)*(r-s)**2",
            **CHORD,
            r="the residual at one end",
            s="the residual at the other",
        ),
        real(
            "convex-square-sign",
            "which has a weight that is not negative between the ends",
            ["t >= 0", "t <= 1"],
            "((1-t)*r + t*s)**2 <= (1-t)*r**2 + t*s**2",
            **CHORD,
            r="the residual at one end",
            s="the residual at the other",
        ),
        real(
            "convex-view",
            "an absolute value lies below its chord",
            ["t >= 0", "t <= 1"],
            "abs((1-t)*a + t*b) <= (1-t)*abs(a) + t*abs(b)",
            **CHORD,
            a="w_j at one end",
            b="w_j at the other",
        ),
        *cauchy_schwarz(),
        real(
            "convex-modality",
            "a norm lies below its chord",
            [
                *("t >= 0", "t <= 1", "r >= 0", "s >= 0", "c <= r*s"),
                "n**2 == (1-t)**2*r**2 + 2*t*(1-t)*c + t**2*s**2",
            ],
            "n <= (1-t)*r + t*s",
            **CHORD,
            r="||x||, x the block at one end",
            s="||y||, y the block at the other",
            c="x'y",
            n="||(1-t)x + ty||",
        ),
        real(
            "convex-sum",
            "the four inequalities, with their weights, add up",
            ["l1 >= 0", "l2 >= 0", "l3 >= 0", "a <= A", "b <= B", "c <= C", "e <= E"],
            "a + l1*b + l2*c + l3*e <= A + l1*B + l2*C + l3*E",
            **{name: f"term {at} of F on the chord, without its weight" for at, name in enumerate("abce", 1)},
            **{name: f"the chord of term {at}" for at, name in enumerate("ABCE", 1)},
        ),
        *joints("sums", "norms"),
    )
    return Argument("F1/convex", f"F is jointly convex in (w, u). {SUM}", "", steps)


def bounded() -> Argument:
    """F1/bounded."""
    step = real(
        "bounded",
        "squares, absolute values and norms with weights",
        ["l1 >= 0", "l2 >= 0", "l3 >= 0", "n >= 0"],
        "p**2 + l1*q**2 + l2*abs(w) + l3*n >= 0",
        p="an entry of X'w - o",
        q="an entry of Xu - w",
        w="w_j",
        n="||u^i||",
    )
    return Argument("F1/bounded", f"F >= 0. {SUM}", "", (step, *joints("sums")))


def attained() -> Argument:
    """F1/attained, whatever lambdas are 0."""
    steps = (
        *joints("sums", "norms", "complement"),
        real(
            "attained-subspace",
            "the directions that change neither Mz nor the penalty are a subspace L: a combination of two"
            " has no penalty, term by term",
            ["n >= 0", "n <= abs(c)*r + s", "l*r == 0", "l*s == 0"],
            "l*n == 0",
            **TERMS,
            c="the factor of the first direction",
        ),
        real(
            "attained-constant",
            "a direction of L changes no penalty, term by term; so z may be taken orthogonal to L",
            ["n <= r + s", "r <= n + s", "l*s == 0"],
            "l*n == l*r",
            **TERMS,
        ),
        cited(
            "attained-sphere",
            "max(||Mz||, g(z)) is continuous and > 0 on the unit sphere of the complement of L, g the"
            " penalties: it has a minimum mu > 0 there, and is >= mu ||z|| on the complement by homogeneity",
            WEIERSTRASS,
        ),
        real(
            "attained-coercive",
            "so F exceeds every T far out in the complement",
            ["T >= 1", "k >= 0", "R >= k + T", "f >= a - k", "g >= 0", "a >= R or g >= R"],
            "f**2 + g >= T",
            T="any bound from 1 on",
            k="||t||",
            R="mu ||z||",
            a="||Mz||",
            f="||Mz - t||",
            g="the penalties",
        ),
        cited(
            "attained-ball",
            "F is continuous and exceeds F(0) outside a ball of the complement: its minimum over the ball is"
            " that over all z",
            WEIERSTRASS,
        ),
    )
    return Argument("F1/attained", "F attains its infimum, for all lambdas >= 0.", "", steps)


def group_lasso() -> Argument:
    """F2/group_lasso, and the two identities behind the reduced problem."""
    steps = (
        *joints("stacking", "split"),
        matrix_identity(
            "lasso-squares",
            "the squared rows of the group lasso are the two squares of F, lambda1 being s^2",
            "(X.T*w - o).T*(X.T*w - o) + (s*X*u - s*w).T*(s*X*u - s*w)",
            "(X.T*w - o).T*(X.T*w - o) + s**2*(X*u - w).T*(X*u - w)",
            s="sqrt(lambda1)",
        ),
        real(
            "lasso-singles",
            "the norm of a group of one is its absolute value",
            ["n >= 0", "n**2 == w**2"],
            "n == abs(w)",
            n="the norm of the group",
            w="w_j",
        ),
        matrix_identity(
            "reduced-loss",
            "the loss in the terms of the reduced problem, XX' and Xo",
            "(X.T*w - o).T*(X.T*w - o)",
            "w.T*(X*X.T)*w - 2*(X*o).T*w + o.T*o",
        ),
        matrix_identity(
            "reduced-rows",
            "the square of a block: a combination of the rows of X_i, and a part z",
            "(X.T*y + z).T*(X.T*y + z)",
            "(X.T*y).T*(X.T*y) + z.T*z + 2*y.T*(X*z)",
            y="the coefficients",
            z="a part with X_i z equal to 0",
        ),
        real(
            "reduced-shorter",
            "so leaving z out keeps Xu and lengthens no block",
            ["n >= 0", "n**2 == r**2 + k", "k >= 0"],
            "r <= n",
            n="||u^i||",
            r="||X_i'y||",
            k="||z||^2",
        ),
        *joints("sums"),
    )
    conclusion = "The group-lasso form equals F at every (w, u); the reduced problem has the same minimum."
    return Argument("F2/group_lasso", conclusion, "", steps)
