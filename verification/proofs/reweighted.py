"""Reweighted loops in general, docs/reweighted-theorem.md: what T1c applies, and what belongs to no claim.

F(z) = q(z) + sum_k lambda_k psi_k(s_k) with s_k = ||A_k z - b_k||^2. The update minimises Q(z) = q(z) + sum_k
lambda_k omega_k s_k with the weights omega_k of the iterate; up to a constant Q(w) = w'Pw - 2c'w, and in two
blocks Q(w, u) = w'Pw + 2w'Su + u'Ru - 2c'w - 2a'u.
"""

from verification.ledger.evidence import Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import exact
from verification.proofs.checkers.reals import real
from verification.proofs.norms import bracket_modality
from verification.proofs.unchecked import cited, joints

MATRIX = {"P": "the matrix of Q, or of Q in one block", "c": "the right side that belongs to it"}
BLOCKS = {
    "P": "the matrix of Q in the first block, w",
    "R": "its matrix in the second block, u",
    "S": "its matrix between the blocks",
    "c": "the right side of the first block",
    "a": "the right side of the second block",
}
ROCKAFELLAR = "R. T. Rockafellar, Convex Analysis, Princeton University Press 1970, theorems 23.8 and 23.9"
VARDI_ZHANG = (
    "Y. Vardi and C.-H. Zhang, The multivariate L1-median and associated data depth, Proc. Natl. Acad. Sci."
    " USA 97 (2000) 1423-1426"
)
POINTS = "the geometric median of 0, 1, 1, 1, -15 on the line"


def steps() -> tuple[Step, ...]:
    """All steps, each checked now; T1c applies `falls`, `distance`, `growth` and the joint `scaled`."""
    return (
        *(*tangent(), *falls(), *damping(), *three_blocks()),
        *(*necessary(), *distance()),
        *(*bounded_weights(), *growth(), *locked()),
    )


# --- (a): which objective falls, and by how much ------------------------------------------------------------


def tangent() -> tuple[Step, ...]:
    """The integral of a weight that does not rise lies below its tangents."""
    return (
        real(
            "tangent-mean",
            "the integral of omega lies below its tangent at s",
            ["t <= s or m <= a", "t >= s or m >= a", "P == m*(t - s)"],
            "P <= a*(t - s)",
            s="the squared norm of a residual at the iterate",
            t="another value of it",
            m="the mean of omega between s and t",
            a="omega(s)",
            P="the integral of omega from s to t",
        ),
        *joints("mean-value"),
    )


def falls() -> tuple[Step, ...]:
    """The fall of an objective below Q, block by block or in two blocks at once."""
    return (
        matrix_identity(
            "block-expand",
            "Q around any point: its derivative and its form; w is the minimum over a block, h the step back",
            f"{_quadratic('w + h')} - {_quadratic('w')}",
            "2*h.T*(P*w - c) + h.T*P*h",
            **MATRIX,
        ),
        matrix_identity(
            "block-jacobi",
            "two blocks at once: the rows that vanish, and the form of Q in the step with one sign changed",
            f"{_two_blocks('w + dw', 'u + du')} - {_two_blocks('w', 'u')}",
            "2*dw.T*(P*(w + dw) + S*u - c) + 2*du.T*(S.T*w + R*(u + du) - a)"
            " - (dw.T*P*dw - 2*dw.T*S*du + du.T*R*du)",
            **BLOCKS,
        ),
        *joints("block-minimum", "block-induction"),
        real(
            "form-sign",
            "the form of Q, term by term",
            ["l >= 0", "a >= 0", "S >= 0"],
            "S + l*a*n**2 >= 0",
            l="lambda_k",
            a="omega_k",
            n="the norm of A_k times the step",
            S="the form of q in the step",
        ),
        real(
            "fall-chain",
            "the objective falls by what Q falls by, or more",
            ["F1 <= Q1 + c", "F0 == Q0 + c", "Q1 == Q0 - s", "s >= 0"],
            "F0 - F1 >= s and F1 <= F0",
            F0="the objective at the iterate",
            F1="the objective at the next one",
            Q0="Q at the iterate",
            Q1="Q at the next one",
            c="the constant between them, by which they touch at the iterate",
            s="the form of Q in the step",
        ),
    )


def _quadratic(w: str) -> str:
    return f"(({w}).T*P*({w}) - 2*c.T*({w}))"


def _two_blocks(w: str, u: str) -> str:
    return f"({_quadratic(w)} + 2*({w}).T*S*({u}) + ({u}).T*R*({u}) - 2*a.T*({u}))"


def damping() -> tuple[Step, ...]:
    """More than two blocks at once: the mean of the block minimisers."""
    mean = "((1 - t)*w + t*y)"
    return (
        matrix_identity(
            "block-mean",
            "Q between two points lies below its chord, by the form of their difference",
            f"(1 - t)*{_quadratic('w')} + t*{_quadratic('y')} - {_quadratic(mean)}",
            "t*(1 - t)*(w - y).T*P*(w - y)",
            t="the share of the second point",
            y="the second point",
            **MATRIX,
        ),
        real(
            "damped-mean",
            "so Q at the mean of some points is at most the mean of its values; from k points to one more",
            ["k >= 1", "(k + 1)*t == 1", "N <= (1 - t)*M + t*B", "k*M <= T"],
            "(k + 1)*N <= T + B",
            k="the number of points",
            t="the share of the new one",
            M="Q at the mean of the first k",
            N="Q at the mean of them and the new one",
            T="the sum of Q at the first k",
            B="Q at the new one",
        ),
    )


def three_blocks() -> tuple[Step, ...]:
    """What Jacobi does with more than two blocks, or with two that the form does not tell apart."""
    return (
        exact(
            "jacobi-three",
            "the step from 1 to -2 of each variable raises F from 19 to 31",
            "2*(-2 + 1 + 1 + 1) + 2*(1/2)*(-2) == 0 and (1 + 1 + 1 + 1)**2 + 3*abs(1) == 19"
            " and (-2 - 2 - 2 + 1)**2 + 3*abs(-2) == 31 and 31 > 19",
            "F = (x + y + z + 1)^2 + |x| + |y| + |z|, weights 1/(2|x|), start x = y = z = 1",
        ),
        exact(
            "jacobi-cycle",
            "two blocks whose form is 0 in the step: from (1, 0) to (0, -1) and back, while F stays 1",
            "0 + 0 == 0 and 1 + (-1) == 0 and 1 - 1 == 0 and (1 + 0)**2 == 1 and (0 - 1)**2 == 1"
            " and ((0 - 1) - (-1 - 0))**2 == 0",
            "F = (x + y)^2, no weights",
        ),
    )


# --- (b): which weights belong to F -------------------------------------------------------------------------


def necessary() -> tuple[Step, ...]:
    """A weight that is not the derivative makes F rise for some data."""
    return (
        real(
            "tangent-slopes",
            "a choice of q for which Q and F have opposite slopes",
            ["G == -(a + b)*x*l"],
            "G + 2*a*x*l == (a - b)*x*l and G + 2*b*x*l == -(a - b)*x*l",
            G="the slope of q at x",
            a="omega at x^2",
            b="the derivative of psi at x^2",
            x="the iterate, one number",
            l="lambda_k",
        ),
        real(
            "tangent-needed",
            "then a step that is short enough raises F",
            ["e != 0", "c > 0", "2*c*D == -e", "g >= 0", "2*abs(r) <= abs(e*D)"],
            "-e*D + g*D**2 + r > 0",
            e="the slope of Q at x, and that of F with its sign changed",
            c="half the second derivative of Q",
            D="the step",
            g="half the second derivative of q",
            r="what the losses change beyond first order",
        ),
        real(
            "ratio-needed",
            "two terms alone: slopes of Q and F with opposite signs, that of Q as small as t",
            ["x > 0", "b > 0", "a > b", "t > 0", "t*a < a - b", "b*y == -a*(1 - t)*x"],
            "x + y < 0 and a*x + b*y > 0",
            x="the slope of the first term of F",
            y="the slope of the second term of F",
            a="omega over the derivative of psi in the first",
            b="the same in the second",
            t="a small number",
        ),
        *joints("same-objective", "short-step", "scaled"),
    )


def distance() -> tuple[Step, ...]:
    """How far the minimum of another objective may lie from that of F, in values of F."""
    return (
        real(
            "distance-minimum",
            "F at a point where another objective is nearly lowest, by way of its value elsewhere",
            ["F <= E + M", "G + m <= H", "E <= G + d"],
            "F - H <= M - m + d",
            F="F at that point",
            E="the other objective there",
            H="F at any other point",
            G="the other objective at the other point",
            M="the largest difference of the two objectives",
            m="their least difference",
            d="the distance of E from the lowest value",
        ),
    )


# --- (c): the limit -----------------------------------------------------------------------------------------


def bounded_weights() -> tuple[Step, ...]:
    """The fall pays for the gradient, so the gradient tends to 0."""
    return (
        matrix_identity(
            "gradient-form",
            "the form of Q in L times the step less its image",
            "(L*dw - P*dw).T*P*(L*dw - P*dw)",
            "L**2*dw.T*P*dw - 2*L*(P*dw).T*(P*dw) + (P*dw).T*P*(P*dw)",
            P=MATRIX["P"],
            L="a bound of the eigenvalues of P",
        ),
        real(
            "gradient-fall",
            "that form is not negative, so the squared image of a step is at most L times its form",
            ["L > 0", "L**2*f - 2*L*n + m >= 0", "m <= L*n"],
            "n <= L*f",
            L="a bound of the eigenvalues of P",
            f="the form of Q in the step",
            n="the squared norm of its image, a quarter of the squared gradient",
            m="the form of Q in the image",
        ),
        *joints("sweep-gradient", "bounded-limit"),
    )


def growth() -> tuple[Step, ...]:
    """A residual whose dual vector is too long grows without bound, unless it is exactly 0."""
    return (
        real(
            "limit-growth",
            "a residual whose dual vector exceeds lambda by a factor grows by that factor",
            ["s > 0", "l > 0", "l*y == V*s", "V >= (1 + h)*l"],
            "y >= (1 + h)*s",
            s="the norm of a residual: |w_j(i)|, ||u^i(i)||",
            y="its next norm",
            V="the norm of its dual vector: |v_j|, ||g^i||",
            l="its lambda",
            h="the excess of the factor over 1",
        ),
        real(
            "limit-unbounded",
            "Bernoulli's inequality, from k to the next",
            ["h > 0", "k >= 0", "P >= 1 + k*h"],
            "P*(1 + h) >= 1 + (k + 1)*h",
            P="(1 + h)^k",
            h="the excess of the factor over 1",
            k="a number of iterations",
        ),
    )


def locked() -> tuple[Step, ...]:
    """The certificate of a point with residuals that are 0; the geometric median, and its repair."""
    return (
        *joints("lock-limit"),
        bracket_modality(),
        real(
            "lock-optimal",
            "a change away from a point with a certificate does not lower F",
            ["R >= g", "g + c == 0", "N >= c"],
            "R + N >= 0",
            R="the change of q and of the terms with a residual",
            g="their slope in the direction of the change",
            c="the sum of the products of the dual vectors with A_k times the change",
            N="the change of the norms whose residual is 0",
        ),
        cited(
            "lock-certificate",
            "the subdifferential of a sum of finite convex functions is the sum of theirs, and that of"
            " f(Az - b) is A' times that of f: a minimum has a certificate",
            ROCKAFELLAR,
        ),
        exact(
            "median-locks",
            "the next iterate is exactly 0, a data point: a weighted sum of the points that vanishes",
            "(1/5)*0 + 3*(1/4)*1 + (1/20)*(-15) == 0 and 5 - 0 == 5 and 5 - 1 == 4 and 5 - (-15) == 20",
            f"{POINTS}, start 5",
        ),
        exact(
            "median-not",
            "0 has no certificate, since the other points pull with a force of 2: F is 18 there, and 17 at 1",
            "abs(3*1 + (-1)) > 1 and 0 + 3*1 + 15 == 18 and 1 + 3*0 + 16 == 17 and 17 < 18",
            POINTS,
        ),
        cited(
            "vardi-zhang",
            "if the points do not lie on one line: with the step from a data point z of multiplicity e to"
            " (1 - e/||R||) T + (e/||R||) z where ||R|| > e, and none else, R the pull of the other points"
            " and T their weighted mean, F falls unless z is the median, and the iterates tend to the median"
            " from every start",
            VARDI_ZHANG,
        ),
        exact(
            "vardi-zhang-step",
            "its step from 0 leads to 15/46, where F is 813/46",
            "(3*1 + (-15)/15)/(3 + 1/15) == 15/23 and (1 - 1/2)*(15/23) + (1/2)*0 == 15/46"
            " and 15/46 + 3*(1 - 15/46) + (15/46 + 15) == 813/46 and 813/46 < 18",
            f"{POINTS}, start 0, e = 1, R = 2",
        ),
    )
