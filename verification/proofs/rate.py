"""Claim T1c/rate: linear where every zero is strict, and an example that is not."""

from verification.ledger.evidence import Argument, Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real
from verification.proofs.descent import descent
from verification.proofs.example import example
from verification.proofs.limit import optimal, rows, settling, stationary, vanishing
from verification.proofs.norms import cauchy_schwarz, quadratic_part
from verification.proofs.unchecked import cited, joints

HOFFMAN = (
    "A. J. Hoffman, On approximate solutions of systems of linear inequalities, J. Res. Nat. Bur. Standards"
    " 49 (1952) 263-265"
)
CONDITION = (
    "for the linear rate: lambda1, lambda2, lambda3 > 0; no iterate has an exact zero; each w_j(i) stays away"
    " from 0 or has lim |v_j| < lambda2, each u^i(i) stays away from 0 or has lim ||g^i|| < lambda3"
)


def arguments() -> tuple[Argument, ...]:
    """T1c/rate."""
    steps = (
        *(*descent(), *vanishing(), *rows(), *stationary(), *settling(), *optimal()),
        *(*growth(), *subgradient(), *contraction(), *example()),
    )
    conclusion = (
        "There is q < 1 with F(i+1) - F* <= q (F(i) - F*) from some i on, in both orders. Without strictness"
        " there need not be: X = o = lambda1 = lambda3 = 1, lambda2 = 2 from w = u = 1 has F* = 1 and"
        " F(k) - F* >= 1/(2k+1)^2, in both orders."
    )
    steps = tuple({step.statement: step for step in steps}.values())
    return (Argument("T1c/rate", conclusion, CONDITION, steps),)


def growth() -> tuple[Step, ...]:
    """F - F* >= const dist(z, Z*)^2 on bounded sets, Z* the set of optima."""
    return (
        quadratic_part(),
        real(
            "growth-bracket",
            "from an optimum, where its own bracket is 0, an entry's change is its bracket; a block's"
            " likewise",
            ["v*s + l*abs(s) == 0"],
            "v*(w - s) + l*abs(w) - l*abs(s) == l*abs(w) + v*w",
            w="w_j",
            s="w*_j",
            v="v_j at the optimum",
            l="lambda2",
        ),
        *growth_of_an_entry(),
        *growth_of_a_block(),
        *joints("optima", "polyhedron"),
        cited(
            "growth-hoffman",
            "the distance of z' on the rays from Z*, which is a polyhedron, is at most H times the norm of"
            " (X'(w'-w*), sqrt(lambda1)(X(u'-u*) - (w'-w*)))",
            HOFFMAN,
        ),
        real(
            "growth-sum",
            "the squared distance from Z*, by the two terms that bound the distance",
            ["D >= 0", "D <= K*x + H*y"],
            "D**2 <= 2*K**2*x**2 + 2*H**2*y**2",
            D="dist(z, Z*)",
            x="the distance of z from its projection z' on the rays",
            y="the norm of z's two residuals less the optimal ones",
            H="Hoffman's constant",
            K="1 + H N, N the norm of the map from z to its residuals",
        ),
    )


def growth_of_an_entry() -> tuple[Step, ...]:
    """The bracket of one entry of w."""
    return (
        real(
            "growth-view",
            "at a strict zero the bracket grows like |w_j|, hence at least like its square",
            ["t <= 1", "l > 0", "abs(v) <= t*l", "abs(w) <= R"],
            "l*abs(w) + v*w >= (1 - t)*l*abs(w) and R*(l*abs(w) + v*w) >= (1 - t)*l*w**2",
            w="w_j",
            v="v_j at the optimum",
            l="lambda2",
            t="a bound of |v_j|/lambda2",
            R="a bound of |w_j|",
        ),
        real(
            "growth-view-side",
            "where |v_j| equals lambda2, the bracket grows like |w_j| on the wrong side of 0, and likewise"
            " its square",
            ["l > 0", "v*w > 0", "abs(w) <= R"],
            "l*abs(w) + v*w >= l*abs(w) and R*(l*abs(w) + v*w) >= l*w**2",
            w="w_j",
            v="v_j at the optimum",
            l="lambda2",
            R="a bound of |w_j|",
        ),
    )


def growth_of_a_block() -> tuple[Step, ...]:
    """The bracket of one block of u."""
    return (
        *cauchy_schwarz(),
        identity(
            "growth-angle",
            "the bracket of a block with ||g|| equal to lambda3, over lambda3 and times 2||u||",
            "2*r*(r - t)",
            "(r**2 - t**2) + (r - t)**2",
            r="||u^i||",
            t="the length of the part of u^i along -g^i, with its sign",
        ),
        real(
            "growth-block",
            "such a bracket grows at least like the squared distance from the ray of -g: s on its side, r"
            " else",
            ["l > 0", "r > 0", "r <= R", "r**2 == t**2 + q**2"],
            "2*R*l*(r - t) >= l*q**2 and (t >= 0 or 2*R*l*(r - t) >= l*r**2)",
            l="lambda3",
            r="||u^i||",
            R="a bound of it",
            t="the length of the part of u^i along -g^i, with its sign",
            q="||s||, s the part of u^i orthogonal to g^i",
        ),
        real(
            "growth-block-strict",
            "at a strict zero the bracket grows like ||u^i||, hence at least like its square",
            ["G < l", "r >= 0", "r <= R", "c >= -G*r"],
            "l*r + c >= (l - G)*r and R*(l*r + c) >= (l - G)*r**2",
            l="lambda3",
            G="||g^i|| at the optimum",
            r="||u^i||",
            R="a bound of it",
            c="g^i'u^i",
        ),
    )


def subgradient() -> tuple[Step, ...]:
    """F(i+1) - F* <= <xi, z - z*> with xi a subgradient that the last step made small."""
    return (
        matrix_identity(
            "rate-lag",
            "the row of w has the old u, which shifts v by a lag",
            "(2*X*(X.T*w - o) - 2*l1*(X*u - w)) - (2*X*(X.T*w - o) - 2*l1*(X*(u + du) - w))",
            "2*l1*X*du",
        ),
        matrix_identity(
            "rate-lag-jacobi",
            "in Jacobi order the row of u has the old w, which shifts g by a lag",
            "2*l1*X.T*(X*u - w) - 2*l1*X.T*(X*u - (w + dw))",
            "2*l1*X.T*dw",
        ),
        identity(
            "rate-subgradient",
            "an entry of the subgradient at the new iterate, by the row of w",
            "-l*y/a - m + l*y/b",
            "l*y*(a - b)/(a*b) - m",
            l="lambda2",
            y="w_j(i+1)",
            a="|w_j(i)|",
            b="|w_j(i+1)|",
            m="the lag",
        ),
        real(
            "rate-support",
            "where |w_j(i)| stays away from 0, its size is at most a constant times |dw_j|",
            ["m > 0", "a >= m", "abs(a - b) <= s", "l > 0"],
            "m*l*abs(a - b) <= l*s*a",
            a="|w_j(i)|",
            b="|w_j(i+1)|",
            m="a lower bound of |w_j(i)|",
            s="|dw_j|",
            l="lambda2",
        ),
        real(
            "rate-strict",
            "at a strict zero its product with w_j(i+1) is at most a constant times its share of the fall"
            " (both times |w_j(i)|/lambda2)",
            ["b >= 0", "t > 0", "t < 1", "b <= t*a"],
            "(1-t)*b*(a-b) <= t*(a-b)**2",
            a="|w_j(i)|",
            b="|w_j(i+1)|",
            t="a bound of the factor by which it shrinks",
        ),
        real(
            "rate-steps",
            "the squared steps are at most a constant times the fall",
            ["A >= m", "B >= m", "R >= 0", "s == R + A*x**2 + B*y**2"],
            "m*(x**2 + y**2) <= s",
            A="A_j",
            B="B_i",
            m="a lower bound of both, by limit-weights",
            R="the other squares of the fall",
            s="the sum of squares in (a)",
            x="dw_j",
            y="||du^i||",
        ),
        *joints("blocks-alike", "strict-limit", "subgradient", "constants"),
    )


def contraction() -> tuple[Step, ...]:
    """The estimates together."""
    return (
        real(
            "rate-combine",
            "the error after a step is at most a constant times the fall",
            ["x**2 <= p*x*y + q*y**2"],
            "x**2 <= (p**2 + 2*q)*y**2",
            x="sqrt(E(i+1))",
            y="the root of the fall",
            p="c1 times the constants of growth-sum and rate-steps",
            q="c2",
        ),
        real(
            "rate-linear",
            "so the error shrinks by a factor below 1",
            ["E1 <= C*(E0 - E1)"],
            "(1 + C)*E1 <= C*E0",
            C="that constant",
            E0="E(i)",
            E1="E(i+1)",
        ),
    )
