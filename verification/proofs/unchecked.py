"""What no machine checks: theorems of the literature, and the joints that are argued in words."""

from verification.ledger.evidence import Checker, Step

THEOREM = "docs/theorem.md"
GENERAL = "docs/reweighted-theorem.md"

THEOREM_JOINTS: dict[str, tuple[str, str]] = {
    # section 0: used everywhere
    "sums": (
        "0",
        "what is shown of one entry of w, one block of u or one residual holds of each of them, and adds"
        " up with weights >= 0",
    ),
    "norms": (
        "0",
        "the numbers of a scalar step stand for norms and inner products of vectors of any length; for a"
        " vector that is 0 the inequality of Cauchy and Schwarz is an equality",
    ),
    "induction": ("0", "a bound that holds at the start and passes on from k to k + 1 holds for every k"),
    "loop": (
        "0",
        "the two systems are those that the loop of the code solves, up to rounding; tests compare them (B3)",
    ),
    # section 1
    "derivative": (
        "1",
        "an expansion with a remainder of second order has the derivative as its linear part; w_j/|w_j| ="
        " (D w)_j and u^i/||u^i|| = (D u)^i by the definition of D",
    ),
    # section 2.1
    "held": (
        "2.1",
        "an entry or a block that is exactly 0, with a positive lambda, stays 0: its step is 0 whatever"
        " its row says, and it adds nothing to F or Q",
    ),
    "substitution": (
        "2.1",
        "the rows of Q in w and u are the two systems; its form at (dw, 0) and (0, du) adds up to the squares"
        " for Gauss-Seidel, and at (dw, -du) it is those for Jacobi",
    ),
    # section 2.2
    "vanishing": (
        "2.2",
        "falls with a finite sum tend to 0, and so do the steps, whose weights are bounded below",
    ),
    "passing": (
        "2.2",
        "the steps vanish, so an iterate near a limit point has its successor near it, and the rows pass"
        " to the limit where w_j or u^i is not 0",
    ),
    "supports": (
        "2.2",
        "there are finitely many supports, so the residuals have finitely many limit points; a bounded"
        " sequence is near one of them from some i on",
    ),
    "determined": (
        "2.2",
        "a linear map whose kernel is 0 has a continuous inverse: as the residuals converge, so do w and Xu",
    ),
    "unbounded": (
        "2.2",
        "|v_j|/lambda2 tends to a limit above 1, so |w_j| grows by a factor 1 + h from some i on, and 1 + kh"
        " exceeds every bound; blocks likewise",
    ),
    "values": (
        "2.2",
        "F is continuous: F(i) tends to F(z) along the subsequence, and the whole sequence, which falls,"
        " follows",
    ),
    "zero-lambdas": ("2.2", "the remark on lambdas that are 0; no verdict rests on it"),
    "locked": ("2.2", "the remark on entries and blocks that are locked at 0; no verdict rests on it"),
    # section 2.3
    "optima": (
        "2.3",
        "limit-unique over the whole space: all optima have the same residuals, v and g; F, expanded around"
        " one, is the same at another, so that every bracket of the other is 0",
    ),
    "polyhedron": (
        "2.3",
        "Z* is the polyhedron of the points whose entries and blocks lie on their rays and whose residuals"
        " are the optimal ones",
    ),
    "constants": (
        "2.3",
        "the iterates stay in a bounded set, on which the constants of all entries and blocks are"
        " collected into one",
    ),
    "subgradient": (
        "2.3",
        "xi is a subgradient of F at the new iterate, so E(i+1) <= xi'(z+ - z*); the inequality of Cauchy and"
        " Schwarz bounds the part that is no strict zero",
    ),
    "strict-limit": (
        "2.3",
        "at a strict zero |v_j|/lambda2 or ||g^i||/lambda3 tends to a limit below 1, so b <= t a with a t"
        " < 1 from some i on",
    ),
    "blocks-alike": (
        "2.3",
        "a block takes the steps of an entry: its norm for the absolute value, its direction for the sign",
    ),
    # section 3
    "no-rate": (
        "3",
        "a rate q < 1 from some N on would bound w(N+m) by C/(1+g)^m for every m, with g > 0 and a fixed C",
    ),
    # section 4
    "smooth-level": (
        "4",
        "the level set of the start is convex and compact, phi <= R on it; so F_eps is strongly convex"
        " there and has one minimum",
    ),
    "smooth-weights": (
        "4",
        "phi has the slope v/phi(v), so F_eps and Q have one gradient at the iterate; A and B lie between"
        " positive bounds as eps <= phi <= R",
    ),
    "smooth-limit": (
        "4",
        "E(i) <= r^i E(0) with an r < 1 tends to 0, and by strong convexity the iterates tend to the minimum",
    ),
    # section 5
    "complement": (
        "5",
        "every z is a sum of a part in L and a part orthogonal to it; a norm of a sum is at most the sum"
        " of the norms",
    ),
    "stacking": ("5", "the rows of A z - t are the residuals X'w - o and s(Xu - w)"),
    "split": ("5", "each u^i is a combination of the rows of X_i and a part z with X_i z = 0"),
    "along": (
        "5",
        "along one coordinate, one block or one direction, F changes by a function of the step alone, by"
        " quadratic-part",
    ),
    "gap": (
        "5",
        "at an optimum and a feasible dual point the brackets of gap-identity are >= 0, so its two squares"
        " add up to at most F* - D(a, b) <= gap",
    ),
    "definite": ("5", "a matrix M with h'Mh > 0 for every h that is not 0 is not singular"),
    "count": ("5", "the multiplications of each product and of the elimination are counted in the text"),
    "label": (
        "5",
        "the label is the template with the lowest F*: it is defined if and only if no other has the same",
    ),
    "determinant": (
        "5",
        "of all products in det(S + T), T diagonal, only that of the diagonal holds every t_j, once: its"
        " coefficient is 1 for every size; and w_j to t_j = lambda2/(4 w_j) keeps sets of measure 0",
    ),
    "one-view": (
        "5",
        "with one view F = ||o||^2 - 2 w x'o + R(w, u), R without o; so F* = ||o||^2 - h(x'o), h(c) the"
        " supremum of 2 w c - R, which is finite as F* >= 0, and 0 at c = 0 as R(0, 0) = 0",
    ),
    "one-view-scale": (
        "5",
        "h is even and convex, and |c| = s |e| puts |c| between 0 and |e|: h(c) <= s h(e) + (1-s) h(0)",
    ),
    "zero-value": ("5", "F* = F(0, 0) = ||o||^2 where w = u = 0 is optimal, and no view enters"),
}
"""By name: the section of docs/theorem.md that argues the joint, and what it says."""

GENERAL_JOINTS: dict[str, tuple[str, str]] = {
    "mean-value": (
        "2",
        "an integral is the length of its interval times a mean of omega there, which is at most omega(s) to"
        " the right of s and at least omega(s) to the left, as omega does not rise",
    ),
    "block-minimum": (
        "2",
        "at a minimum of Q over a block, with the residuals of infinite weight held at 0, the derivative"
        " along the block's step is 0; so Q falls by the form of the step",
    ),
    "block-induction": ("2", "one block after the other: the falls of Q add up, as the weights stay fixed"),
    "same-objective": ("3", "where omega = psi', the integral of omega is psi up to a constant"),
    "short-step": (
        "3",
        "as g grows, or t falls, the step tends to 0 while the slope of F tends to a number that is not 0;"
        " what losses with a derivative add beyond first order is of smaller order than the step",
    ),
    "scaled": (
        "3",
        "the weights kappa_k psi_k' are those of the losses kappa_k psi_k: lambda_k becomes kappa_k lambda_k",
    ),
    "sweep-gradient": (
        "4",
        "the derivative with respect to a block is 0 after its step, and the steps until then change it by"
        " twice their images at most; so the gradient at the iterate is at most 2m times the sum of the norms"
        " of these images, and for Jacobi at most 2L times the steps",
    ),
    "bounded-limit": (
        "4",
        "F_omega and Q have one gradient at the iterate; its limit is 0, F_omega is continuously"
        " differentiable, and a convex function is least where its gradient is 0",
    ),
    "lock-limit": (
        "4",
        "the rows pass to the limit where residuals are not 0 there; the others' dual vectors are determined"
        " by the rest and converge; one longer than lambda_k in the limit makes its residual unbounded",
    ),
}
"""The same of docs/reweighted-theorem.md."""

JOINTS: dict[str, tuple[str, str]] = {
    name: (f"{document} {section}", statement)
    for document, argued in ((THEOREM, THEOREM_JOINTS), (GENERAL, GENERAL_JOINTS))
    for name, (section, statement) in argued.items()
}
"""By name: the document and the section that argue the joint, and what it says."""


def joints(*names: str) -> tuple[Step, ...]:
    """Inferences that are made in words alone; they are named in the verdict and counted apart."""
    return tuple(
        Step(f"{name}: {statement}", Checker.PROSE, True, place)
        for name, (place, statement) in ((name, JOINTS[name]) for name in names)
    )


def cited(name: str, statement: str, source: str) -> Step:
    """Take a theorem from the literature."""
    return Step(f"{name}: {statement}", Checker.CITED, True, source)
