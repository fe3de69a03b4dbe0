"""Claim T1c/limit: the corrected update reaches the optimum unless an entry or a block is exactly 0."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.descent import descent
from verification.proofs.norms import (
    bracket_modality,
    bracket_view,
    cauchy_schwarz,
    quadratic_part,
    slope_modality,
    tangent_view,
)
from verification.proofs.reweighted import growth
from verification.proofs.unchecked import cited, joints

BOLZANO_WEIERSTRASS = (
    "Bolzano and Weierstrass; W. Rudin, Principles of Mathematical Analysis, 3rd ed., theorem 3.6 (b)"
)


def arguments() -> tuple[Argument, ...]:
    """T1c/limit."""
    return (limit(),)


def limit() -> Argument:
    """T1c/limit; the Jacobi rows are checked along."""
    steps = (*descent(), *vanishing(), *rows(), *stationary(), *settling(), *optimal())
    conclusion = (
        "For lambda1, lambda2, lambda3 > 0, F(i) -> F*, and w(i) and Xu(i) converge, in both orders, from"
        " every start whose iterates have no entry of w and no block of u that is exactly 0."
    )
    return Argument("T1c/limit", conclusion, "", steps)


def vanishing() -> tuple[Step, ...]:
    """The iterates are bounded and the steps tend to 0."""
    return (
        real(
            "limit-bounded",
            "both penalties stay below the first value of F, so the iterates are bounded",
            ["R >= 0", "l2 > 0", "l3 > 0", "W >= 0", "U >= 0", "F <= F0", "F == R + l2*W + l3*U"],
            "l2*W <= F0 and l3*U <= F0",
            R="the two squares of F",
            W="||w||_1",
            U="||u||_M",
            F="F(i)",
            F0="F(0)",
        ),
        real(
            "limit-weights",
            "so the weight A_j is bounded below; B_i likewise",
            ["w > 0", "l > 0", "l*w <= F0", "A*2*w == l"],
            "2*A*F0 >= l**2",
            w="|w_j|",
            l="lambda2",
            A="A_j",
            F0="F(0)",
        ),
        real(
            "limit-telescope",
            "the falls up to k add up to no more than F lost; the step from k to the next",
            ["S <= F0 - Fk", "Fk - Fn >= s", "Fn >= 0"],
            "S + s <= F0 - Fn and S + s <= F0",
            S="the sum of the falls before k",
            s="the fall at k",
            F0="F(0)",
            Fk="F(k)",
            Fn="F(k+1)",
        ),
        *joints("induction", "vanishing"),
        cited("limit-points", "a bounded sequence of points has a limit point", BOLZANO_WEIERSTRASS),
    )


def rows() -> tuple[Step, ...]:
    """What the systems say, row by row."""
    return (
        matrix_identity(
            "limit-row-w",
            "twice the system for w(i+1), here w, at u(i): v and the weighted entry",
            "2*((X*X.T + l1*In + A)*w - X*(o + l1*u))",
            "2*X*(X.T*w - o) - 2*l1*(X*u - w) + 2*A*w",
        ),
        matrix_identity(
            "limit-row-u",
            "twice the system for u(i+1), here u, at w(i+1) or w(i): g and the weighted entry",
            "2*((l1*X.T*X + B)*u - l1*X.T*w)",
            "2*l1*X.T*(X*u - w) + 2*B*u",
        ),
        real(
            "limit-ratio",
            "an entry's next size: it grows or shrinks by |v_j|/lambda2, and is 0 if and only if v_j is",
            ["s > 0", "l > 0", "s*v + l*y == 0"],
            "l*abs(y) == s*abs(v) and (y == 0) == (v == 0)",
            s="|w_j(i)|",
            l="lambda2",
            v="v_j",
            y="w_j(i+1)",
        ),
        real(
            "limit-ratio-modality",
            "a block's next size: it grows or shrinks by ||g^i||/lambda3",
            ["r > 0", "l > 0", "n >= 0", "G >= 0", "l**2*n**2 == r**2*G**2"],
            "l*n == r*G",
            r="||u^i(i)||",
            l="lambda3",
            n="||u^i(i+1)||",
            G="||g^i||",
        ),
    )


def stationary() -> tuple[Step, ...]:
    """A limit point minimises F among the points with no more non-zeros."""
    return (
        real(
            "limit-sign",
            "w_j(i+1)/|w_j(i)| differs from the sign of w_j(i) by |dw_j|/m at most, where m bounds |w_j(i)|"
            " from below",
            ["b >= m", "s >= 0"],
            "m*s <= s*b",
            b="|w_j(i)| or ||u^i(i)||",
            m="a lower bound of it",
            s="|dw_j| or ||du^i||",
        ),
        *joints("passing"),
        quadratic_part(),
        tangent_view(),
        *cauchy_schwarz(),
        slope_modality(),
        real(
            "limit-subspace",
            "a change within the support of a limit point does not lower F: the slopes of the penalties"
            " cancel v and g",
            ["v == -x", "g == -y", "P >= x*h", "R >= y*k", "S >= 0"],
            "v*h + g*k + P + R + S >= 0",
            v="v_j",
            g="g^i in the direction of the change",
            x="the slope lambda2 sign(w_j)",
            y="the slope lambda3 u^i/||u^i|| in that direction",
            h="the change of w_j",
            k="the size of the change of u^i",
            P="the change of lambda2 |w_j|",
            R="the change of lambda3 ||u^i||",
            S="the two squares of quadratic-part",
        ),
    )


def unique() -> tuple[Step, ...]:
    """Minimisers over one subspace have one pair of residuals."""
    return (
        identity(
            "limit-midpoint",
            "a residual at the midpoint of two points",
            "((r + s)/2)**2",
            "r**2/2 + s**2/2 - (r - s)**2/4",
            r="an entry of X'w - o or sqrt(lambda1) (Xu - w) at the first point",
            s="the same at the second point",
        ),
        real(
            "limit-unique",
            "two minimisers over one subspace have the same residuals, or F would be lower at the midpoint",
            ["F1 == m", "F2 == m", "M <= (F1 + F2)/2 - D/4", "M >= m", "D >= 0"],
            "D == 0",
            F1="F at the first",
            F2="F at the second",
            m="the minimum",
            M="F at the midpoint",
            D="the sum of the squared differences of the residuals",
        ),
    )


def settling() -> tuple[Step, ...]:
    """The residuals converge, although (w, u) need not be unique."""
    return (
        *unique(),
        real(
            "limit-separate",
            "to go from near one limit point of the residuals to near another takes a step longer than r",
            ["P > 3*r", "a <= r", "b <= r", "P <= a + s + b"],
            "s > r",
            P="the distance of the two limit points",
            a="the distance of the residuals from the first",
            b="the distance of the next residuals from the second",
            s="the step",
            r="a third of the least distance of two limit points, or less",
        ),
        *joints("supports", "determined"),
        matrix_identity(
            "limit-difference",
            "dw squared, from the differences of the residuals: if they are 0, so are dw and X du",
            "dw.T*dw",
            "dw.T*(dw - X*du) + (X.T*dw).T*du",
        ),
    )


def optimal() -> tuple[Step, ...]:
    """The limit satisfies the optimality conditions everywhere."""
    return (
        *growth(),
        *joints("unbounded"),
        bracket_view(),
        bracket_modality(),
        real(
            "limit-optimal",
            "F between its optimum and a value near it, from some iteration on",
            ["Fs <= Fk", "Fk <= FN", "FN <= Fs + e"],
            "abs(Fk - Fs) <= e",
            Fs="F(z), the optimum",
            FN="F(N)",
            Fk="F(k), k beyond N",
            e="any positive number",
        ),
        *joints("values"),
    )
