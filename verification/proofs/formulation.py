"""Claims F1 and F2: F is convex, bounded below and attains its minimum; its group-lasso form is the same."""

from verification.ledger.evidence import Argument
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import cited, identity
from verification.proofs.checkers.reals import real
from verification.proofs.norms import cauchy_schwarz

SUM = "Every term of F has this form, with a weight >= 0; the inequalities add up in every dimension."


def arguments() -> tuple[Argument, ...]:
    """F1/convex, F1/bounded, F1/attained, F2/group_lasso."""
    return convex(), bounded(), attained(), group_lasso()


def convex() -> Argument:
    """F1/convex."""
    steps = (
        identity(
            "convex-square",
            "a residual is affine in (w,u): ((1-t)r + ts)^2 = (1-t)r^2 + ts^2 - t(1-t)(r-s)^2",
            "((1-t)*r + t*s)**2",
            "(1-t)*r**2 + t*s**2 - t*(1-t)*(r-s)**2",
        ),
        real(
            "convex-square-sign",
            "so the square at the chord is at most the chord of the squares for 0 <= t <= 1",
            ["t >= 0", "t <= 1"],
            "((1-t)*r + t*s)**2 <= (1-t)*r**2 + t*s**2",
        ),
        real(
            "convex-view",
            "|(1-t)a + tb| <= (1-t)|a| + t|b|, for each entry of w",
            ["t >= 0", "t <= 1"],
            "abs((1-t)*a + t*b) <= (1-t)*abs(a) + t*abs(b)",
        ),
        *cauchy_schwarz(),
        real(
            "convex-modality",
            "n = ||(1-t)x + ty||, r = ||x||, s = ||y||, c = x'y <= rs: n <= (1-t)r + ts, for each block of u",
            [
                *("t >= 0", "t <= 1", "r >= 0", "s >= 0", "c <= r*s", "n >= 0"),
                "n**2 == (1-t)**2*r**2 + 2*t*(1-t)*c + t**2*s**2",
            ],
            "n <= (1-t)*r + t*s",
        ),
        real(
            "convex-sum",
            "weighted by 1, lambda1, lambda2, lambda3 >= 0 the four inequalities add up, entry by entry",
            ["l1 >= 0", "l2 >= 0", "l3 >= 0", "a <= A", "b <= B", "c <= C", "e <= E"],
            "a + l1*b + l2*c + l3*e <= A + l1*B + l2*C + l3*E",
        ),
    )
    return Argument("F1/convex", f"F is jointly convex in (w, u). {SUM}", "", steps)


def bounded() -> Argument:
    """F1/bounded."""
    step = real(
        "bounded",
        "each square, |w_j| and ||u^i|| is >= 0, and so is each weight",
        ["l1 >= 0", "l2 >= 0", "l3 >= 0", "n >= 0"],
        "p**2 + l1*q**2 + l2*abs(w) + l3*n >= 0",
    )
    return Argument("F1/bounded", f"F >= 0. {SUM}", "", (step,))


def attained() -> Argument:
    """F1/attained, whatever lambdas are 0."""
    steps = (
        real(
            "attained-subspace",
            "F(z) = ||Mz - t||^2 + g(z), g(z) = lambda2 ||w||_1 + lambda3 ||u||_M. L = {d: Md = 0, g(d) = 0}"
            " is a subspace: g(d) = g(e) = 0 gives g(cd + e) = 0, term by term (n <= |c| r + s by the"
            " triangle inequality)",
            ["l >= 0", "r >= 0", "s >= 0", "n >= 0", "n <= abs(c)*r + s", "l*r == 0", "l*s == 0"],
            "l*n == 0",
        ),
        real(
            "attained-constant",
            "g(z + d) = g(z) for d in L, term by term; M(z + d) = Mz: F(z + d) = F(z), so z may be taken"
            " orthogonal to L",
            ["l >= 0", "r >= 0", "s >= 0", "n >= 0", "n <= r + s", "r <= n + s", "l*s == 0"],
            "l*n == l*r",
        ),
        cited(
            "attained-sphere",
            "max(||Mz||, g(z)) is continuous and > 0 on the unit sphere of the complement of L: it has a"
            " minimum mu > 0 there, and is >= mu ||z|| on the complement by homogeneity",
            "Weierstrass: a continuous function on a non-empty compact set attains its minimum",
        ),
        real(
            "attained-coercive",
            "F(z) >= T for mu ||z|| >= ||t|| + T, T >= 1 (a = ||Mz||, f = ||Mz - t|| >= a - ||t||, R = mu"
            " ||z||)",
            ["T >= 1", "k >= 0", "R >= k + T", "f >= 0", "f >= a - k", "g >= 0", "a >= R or g >= R"],
            "f**2 + g >= T",
        ),
        cited(
            "attained-ball",
            "F is continuous and exceeds F(0) outside a ball of the complement: its minimum over the ball is"
            " that over all z",
            "Weierstrass: a continuous function on a non-empty compact set attains its minimum",
        ),
    )
    return Argument("F1/attained", "F attains its infimum, for all lambdas >= 0.", "", steps)


def group_lasso() -> Argument:
    """F2/group_lasso, and the two identities behind the reduced problem."""
    steps = (
        matrix_identity(
            "lasso-rows",
            "the lower rows of A z - t are -sw + sXu = s(Xu - w); the upper ones X'w - o",
            "s0*X*u - s0*In*w",
            "s0*(X*u - w)",
        ),
        matrix_identity(
            "lasso-squares",
            "||A z - t||^2 = ||X'w-o||^2 + s^2 ||Xu-w||^2, s^2 = lambda1",
            "(X.T*w - o).T*(X.T*w - o) + (s0*X*u - s0*w).T*(s0*X*u - s0*w)",
            "(X.T*w - o).T*(X.T*w - o) + s0**2*(X*u - w).T*(X*u - w)",
        ),
        real(
            "lasso-singles",
            "a group of one: its 2-norm is |w_j|, so the n single groups sum to ||w||_1",
            ["n >= 0", "n**2 == w**2"],
            "n == abs(w)",
        ),
        matrix_identity(
            "reduced-loss",
            "the reduced problem has the same loss: ||X'w-o||^2 = w'Gw - 2c'w + ||o||^2, G = XX', c = Xo",
            "(X.T*w - o).T*(X.T*w - o)",
            "w.T*(X*X.T)*w - 2*(X*o).T*w + o.T*o",
        ),
        matrix_identity(
            "reduced-rows",
            "u = X'y + z with Xz = 0: ||u||^2 = ||X'y||^2 + ||z||^2 + 2 y'(Xz), for each block",
            "(X.T*y + z).T*(X.T*y + z)",
            "(X.T*y).T*(X.T*y) + z.T*z + 2*y.T*(X*z)",
        ),
        real(
            "reduced-shorter",
            "so leaving z out keeps Xu and makes no ||u^i|| longer: some optimum has u^i in the rows of X_i",
            ["n >= 0", "r >= 0", "n**2 == r**2 + k", "k >= 0"],
            "r <= n",
        ),
    )
    conclusion = "The group-lasso form equals F at every (w, u); the reduced problem has the same minimum."
    return Argument("F2/group_lasso", conclusion, "", steps)
