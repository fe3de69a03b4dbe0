"""Claim R1/one_view: with one view and references of one length, no lambda changes the label."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.reals import real
from verification.proofs.unchecked import joints

SUPREMUM = "h at"
"""Of what the values of h are called."""


def arguments() -> tuple[Argument, ...]:
    """R1/one_view."""
    return (one_view(),)


def one_view() -> Argument:
    """F*_j = ||o_j||^2 - h(|x'o_j|) with one function h for all references, which never falls."""
    steps = (
        matrix_identity(
            "one-view-loss",
            "the reference enters the loss by Xo and its length alone",
            "(X.T*w - o).T*(X.T*w - o)",
            "(X.T*w).T*(X.T*w) - 2*w.T*X*o + o.T*o",
        ),
        real(
            "one-view-even",
            "without the norms of the modalities, R has one value at (w, u) and at (-w, -u)",
            [],
            "k*(-w)**2 + l1*(-s - (-w))**2 + l2*abs(-w) == k*w**2 + l1*(s - w)**2 + l2*abs(w)",
            k="the square of ||x||",
            s="x'u",
            w="the weight of the view",
        ),
        real(
            "one-view-convex",
            "a supremum of functions that are linear in the product is convex in it",
            ["t >= 0", "t <= 1", "2*w*c - R <= H", "2*w*e - R <= K"],
            "2*w*(t*c + (1 - t)*e) - R <= t*H + (1 - t)*K",
            c="a value of x'o",
            e="another value of x'o",
            t="the share of the first",
            w="the weight of the view",
            R="R at any (w, u)",
            H=f"{SUPREMUM} the first value",
            K=f"{SUPREMUM} the second value",
        ),
        real(
            "one-view-zero",
            "R takes no negative value",
            ["k >= 0", "l1 >= 0", "l2 >= 0", "l3 >= 0", "N >= 0"],
            "k*w**2 + l1*(s - w)**2 + l2*abs(w) + l3*N >= 0",
            k="the square of ||x||",
            s="x'u",
            w="the weight of the view",
            N="the sum of the norms of the modalities",
        ),
        real(
            "one-view-order",
            "h grows with the size of the product, strictly unless it is 0",
            ["s < 1", "H >= 0", "h <= s*H"],
            "h <= H and (H == 0 or h < H)",
            s="the quotient of the absolute values of the two products",
            h=f"{SUPREMUM} the smaller one",
            H=f"{SUPREMUM} the larger one",
        ),
        real(
            "one-view-label",
            "with one length the order of the optima is the opposite order of h",
            ["F == L**2 - h", "G == L**2 - H"],
            "(F > G) == (h < H)",
            L="the length of the references",
            F="the optimum of one reference",
            G="the optimum of another",
            h=f"{SUPREMUM} the product of the first",
            H=f"{SUPREMUM} the product of the second",
        ),
        *joints("one-view", "one-view-scale", "norms"),
    )
    conclusion = (
        "F*_j = ||o_j||^2 - h(|x'o_j|), h the same for all references: with one length the lowest optimum is"
        " that of the largest |x'o_j|, whatever the lambdas, unless w = u = 0 is optimal for each: then all"
        " tie."
    )
    return Argument("R1/one_view", conclusion, "", steps)
