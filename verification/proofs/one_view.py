"""Claim R1/one_view: with one view and references of one length, no lambda changes the label."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.reals import real


def arguments() -> tuple[Argument, ...]:
    """R1/one_view."""
    return (one_view(),)


def one_view() -> Argument:
    """F*_j = ||o_j||^2 - h(|x'o_j|) with one function h for all references, which never falls."""
    steps = (
        matrix_identity(
            "one-view-loss",
            "||X'w - o||^2 = ||X'w||^2 - 2 w'Xo + ||o||^2; with n = 1, c = x'o and R(w, u) = w^2 ||x||^2 +"
            " lambda1 (x'u - w)^2 + lambda2 |w| + lambda3 sum_i ||u^i||, F = ||o||^2 - 2 w c + R(w, u), so F*"
            " = ||o||^2 - h(c), h(c) = sup (2 w c - R(w, u)), in which o enters by c alone",
            "(X.T*w - o).T*(X.T*w - o)",
            "(X.T*w).T*(X.T*w) - 2*w.T*X*o + o.T*o",
        ),
        real(
            "one-view-even",
            "R(-w, -u) = R(w, u), so h(-c) = h(c) (s = x'u, k = ||x||^2)",
            [],
            "k*(-w)**2 + l1*(-s - (-w))**2 + l2*abs(-w) == k*w**2 + l1*(s - w)**2 + l2*abs(w)",
        ),
        real(
            "one-view-convex",
            "h is convex: 2 w (t c + (1-t) e) - R <= t h(c) + (1-t) h(e) for every (w, u)",
            ["t >= 0", "t <= 1", "2*w*c - R <= H", "2*w*e - R <= K"],
            "2*w*(t*c + (1 - t)*e) - R <= t*H + (1 - t)*K",
        ),
        real(
            "one-view-zero",
            "R >= 0, and R(0, 0) = 0: h(0) = 0 and h >= 0 (N = sum_i ||u^i||)",
            ["k >= 0", "l1 >= 0", "l2 >= 0", "l3 >= 0", "N >= 0"],
            "k*w**2 + l1*(s - w)**2 + l2*abs(w) + l3*N >= 0",
        ),
        real(
            "one-view-order",
            "|c| = s |e|, s < 1: h(c) <= s h(e) + (1-s) h(0), so h(c) <= h(e), and h(c) < h(e) unless h(e) ="
            " 0",
            ["s >= 0", "s < 1", "H >= 0", "h <= s*H"],
            "h <= H and (H == 0 or h < H)",
        ),
        real(
            "one-view-label",
            "references of one length L: the lowest L^2 - h is that of the largest h; where all h are 0,"
            " every F* is L^2",
            ["F == L**2 - h", "G == L**2 - H"],
            "(F > G) == (h < H) and (h != 0 or F == L**2)",
        ),
    )
    conclusion = (
        "F*_j = ||o_j||^2 - h(|x'o_j|), h the same for all references: with one length the lowest optimum is"
        " that of the largest |x'o_j|, whatever the lambdas, or every optimum is 0 and all tie."
    )
    return Argument("R1/one_view", conclusion, "", steps)
