"""Claim R1/one_view: with one view and references of one length, no lambda changes the label."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.reals import real
from verification.proofs.unchecked import joints

REST = {"k": "||x||^2", "s": "x'u", "w": "the weight of the view"}
"""What the letters of R(w, u), the part of F without o, stand for."""
VALUES = {"h": "h at the reference in question", "H": "h at the other reference"}


def arguments() -> tuple[Argument, ...]:
    """R1/one_view."""
    return (one_view(),)


def one_view() -> Argument:
    """F*_j = ||o_j||^2 - h(|x'o_j|) with one function h for all references, which never falls."""
    steps = (
        matrix_identity(
            "one-view-loss",
            "the loss, expanded: o enters by X o and by its length",
            "(X.T*w - o).T*(X.T*w - o)",
            "(X.T*w).T*(X.T*w) - 2*w.T*X*o + o.T*o",
        ),
        real(
            "one-view-even",
            "R is the same at a point and at its negative, so h is even",
            [],
            "k*(-w)**2 + l1*(-s - (-w))**2 + l2*abs(-w) == k*w**2 + l1*(s - w)**2 + l2*abs(w)",
            **REST,
        ),
        real(
            "one-view-convex",
            "what h is the supremum of, at a point between two others",
            ["t >= 0", "t <= 1", "2*w*c - R <= H", "2*w*e - R <= K"],
            "2*w*(t*c + (1 - t)*e) - R <= t*H + (1 - t)*K",
            w="the weight of the view",
            R="R(w, u)",
            c="x'o of one reference",
            e="x'o of another one",
            t="the weight of the first",
            H="h(c)",
            K="h(e)",
        ),
        real(
            "one-view-zero",
            "R has no negative value",
            ["k >= 0", "l1 >= 0", "l2 >= 0", "l3 >= 0", "N >= 0"],
            "k*w**2 + l1*(s - w)**2 + l2*abs(w) + l3*N >= 0",
            N="the sum of the norms of the blocks of u",
            **REST,
        ),
        real(
            "one-view-order",
            "h at two references, by convexity and its value at 0",
            ["s < 1", "H >= 0", "h <= s*H"],
            "h <= H and (H == 0 or h < H)",
            s="the ratio of the two values of |x'o|",
            **VALUES,
        ),
        real(
            "one-view-label",
            "the lower optimum and the larger value of h",
            ["F == L**2 - h", "G == L**2 - H"],
            "(F > G) == (h < H) and (h != 0 or F == L**2)",
            F="F* of the reference in question",
            G="F* of the other reference",
            L="the length of both",
            **VALUES,
        ),
        *joints("one-view", "label"),
    )
    conclusion = (
        "F*_j = ||o_j||^2 - h(|x'o_j|), h the same for all references: with one length the lowest optimum is"
        " that of the largest |x'o_j|, whatever the lambdas, or every optimum is 0 and all tie."
    )
    return Argument("R1/one_view", conclusion, "", steps)
