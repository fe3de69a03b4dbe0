"""The symbols of the report, in the plain notation, and the variants of the update that it compares."""

SYMBOLS = (
    ("n, d, m, p", "numbers of robots (views), features, modalities and templates"),
    ("X", "n by d; row j holds the features that robot j saw"),
    ("o", "the d features of one template: a reference view of one object"),
    ("w, u", "weights of the n views and of the d features; u^i is the block of modality i"),
    (
        "lambda1, lambda2, lambda3",
        "weights >= 0 of the coupling, of the l1-norm of w, and of the modality norm",
    ),
    ("||w||_1, ||u||_M", "sum of |w_j|; sum over the modalities of ||u^i||_2"),
    ("F(w, u)", "||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 ||u||_M, Eq. (full)"),
    ("F*", "the minimum of F; [lower, upper] is an interval that is proved to contain it"),
    ("x_j, X_i", "row j of X, what robot j saw; the columns of X that belong to modality i"),
    ("b", "2 lambda1 (Xu - w), the derivative of the coupling by Xu"),
    ("v_j, in F3 and T1c", "entry j of 2X(X'w - o) - b, the derivative by w of the first two terms of F"),
    ("g^i", "2 lambda1 X_i'(Xu - w), the derivative by u^i of the coupling"),
    (
        "F_eps, eps",
        "F with sqrt(w_j^2 + eps^2) for |w_j| and sqrt(||u^i||^2 + eps^2) for ||u^i||; eps > 0 is chosen",
    ),
    ("strict", "an entry w_j = 0 with |v_j| < lambda2, or a block u^i = 0 with ||g^i|| < lambda3"),
    (
        "locked",
        "a weight that is exactly 0 and stays 0 in every later iteration, although the optimum needs it",
    ),
    ("referee", "a slow computation of F* in fractions and balls that shares no formula with the library"),
    ("gap", "an upper bound of F(w, u) - F*"),
    ("D^w, D^u", "the diagonal matrices of Algorithm 1 that stand for the derivatives of the norms"),
    (
        "Algorithm 1",
        "start: w = argmin ||X'w - o||, then u = argmin ||Xu - w||, each of least norm. Step 6: (XX' +"
        " lambda1 I + (lambda2/2) D^w) w = X(o + lambda1 u). Step 7: (lambda1 X'X + (lambda3/2) D^u) u ="
        " lambda1 X'w. D^w = diag(1/(2 w_i)) and D^u = blockdiag(I/(2||u^i||)) come from the iterate before;"
        " repeated until convergence. The update variants differ in D^w, D^u and the factor 1/2",
    ),
    ("A, B, Q", "in proofs: lambda2 D^w and lambda3 D^u; the quadratic above F that an update minimises"),
    (
        "w(i), u(i)",
        "the iterates of Algorithm 1; X' is the transpose of X, and w' without a factor another point",
    ),
)

VARIANTS = (
    ("printed", "D^w = diag(1/(2 w_i)), and lambda2/2 and lambda3/2, as in the paper's box"),
    ("absolute", "|w_i| in place of w_i; lambda2/2 and lambda3/2 stay"),
    (
        "corrected",
        "|w_i| in place of w_i, and the whole of lambda2 and lambda3, as the derivative of F asks for",
    ),
    ("appendix_half", "||w||_1 in place of w_i, as the proof in the appendix substitutes, with the halves"),
    ("appendix_full", "the same with the whole of lambda2 and lambda3"),
    ("smoothed", "sqrt(w_i^2 + eps^2) in place of w_i, and likewise for u; it descends F_eps"),
    ("Gauss-Seidel", "the update of u sees the new w(i+1)"),
    ("Jacobi", "the update of u sees the old w(i)"),
)

UPDATES = (
    (
        "w:",
        "(XX' + lambda1 I + (lambda2/2) D^w) w = X(o + lambda1 u), D^w = diag(1/(2 w_i))",
        "(XX' + lambda1 I + lambda2 D^w) w = X(o + lambda1 u), D^w = diag(1/(2 |w_i|))",
    ),
    (
        "u:",
        "(lambda1 X'X + (lambda3/2) D^u) u = lambda1 X'w, D^u = blockdiag(I/(2||u^i||))",
        "(lambda1 X'X + lambda3 D^u) u = lambda1 X'w, D^u = blockdiag(I/(2||u^i||))",
    ),
)
"""The two systems of an iteration: which weights they solve for, as printed, corrected."""
OBJECTIVE = "F(w, u) = ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||"
"""Eq. (full)."""
