"""The ledger: every claim that the verifier judges, its place, its formal parts, and how each is judged.

A part is one formal reading. Its role says what it means for the claim: ``stated`` is the claim as the paper
has it, ``reading`` another way to read it, ``repair`` the nearest true form. The verdict of a claim is that
of its stated parts. Nothing here computes.
"""

from dataclasses import dataclass
from enum import StrEnum


class Role(StrEnum):
    """What a part means for its claim."""

    STATED = "stated"
    READING = "reading"
    REPAIR = "repair"


class Subject(StrEnum):
    """What a claim is about."""

    FORMULATION = "the formulation"
    ALGORITHM = "the algorithm and its theorem"
    EXPERIMENTS = "the experiments"
    SOLVERS = "other solvers"
    LIBRARY = "this library"


@dataclass(frozen=True)
class Part:
    """One formal reading of a claim.

    Attributes
    ----------
    key : str
        The claim's id, a slash, and a name.
    role : Role
    statement : str
        Formal, in the paper's symbols, plain text.
    tolerance : str
        What counts as equal and why; empty where the judgement is exact.
    measure : str
        What `Count.worst` measures; empty where nothing is counted.
    """

    key: str
    role: Role
    statement: str
    tolerance: str = ""
    measure: str = ""

    @property
    def claim(self) -> str:
        """The id of its claim."""
        return self.key.split("/")[0]


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes
    ----------
    id : str
    place : str
        Where in the paper; "ours" for claims of this project.
    subject : Subject
    statement : str
        In our words.
    method : str
        How it is judged.
    parts : tuple of Part
    testable : str
        Why it cannot be judged here; empty if it can.
    """

    id: str
    place: str
    subject: Subject
    statement: str
    method: str
    parts: tuple[Part, ...]
    testable: str = ""


ROUNDING = "1e-12 of max(F(start), ||o||^2): F sums n + d terms, each good to some 1e-16"
LIMIT = "F - F* <= 1e-6 F* + 1e-12 ||o||^2: far below every wrong limit, above what slow runs leave"
SAME = "certified intervals [lower, upper] of F* must meet: rounding is inside them"

READINGS = ("printed", "absolute", "corrected", "appendix_half", "appendix_full", "smoothed")
"""The readings of the update, as `convexperc.solvers.readings` names them."""
ORDERS = ("gauss_seidel", "jacobi")
DESCENDING = ("absolute", "corrected", "smoothed")
"""Readings with an objective of their own."""


def _by_reading(claim: str, statement: str, tolerance: str, measure: str) -> tuple[Part, ...]:
    stated = ("printed", "gauss_seidel")
    return tuple(
        Part(
            f"{claim}/{reading}/{order}",
            Role.STATED if (reading, order) == stated else Role.READING,
            statement.format(reading=reading, order=order.replace("_", "-")),
            tolerance,
            measure,
        )
        for reading in READINGS
        for order in ORDERS
    )


FORMULATION = (
    Claim(
        "F1",
        "Eq. (full)",
        Subject.FORMULATION,
        "F is jointly convex in (w, u), bounded below by 0, and attains its minimum.",
        "Scalar identities and inequalities that sum to the statement in every dimension; exact chords.",
        (
            Part(
                "F1/convex",
                Role.STATED,
                "F((1-t) z + t z') <= (1-t) F(z) + t F(z') for 0 <= t <= 1",
                "",
                "(F on the chord - the chord) / the chord, in exact arithmetic",
            ),
            Part("F1/bounded", Role.STATED, "F(w, u) >= 0", "", "-F(w, u), in exact arithmetic"),
            Part("F1/attained", Role.STATED, "F(w*, u*) = inf F for some (w*, u*), whatever lambdas are 0"),
        ),
    ),
    Claim(
        "F2",
        "Eq. (full)",
        Subject.FORMULATION,
        "The direct conic model, the reduced problem, the group-lasso form and, where it is one, the quadratic"
        " program have one optimum.",
        "Exact identities; certified intervals of every solver against the exact referee.",
        (
            Part(
                "F2/conic",
                Role.STATED,
                "the CVXPY model solved by Clarabel: its certified interval contains F*",
                SAME,
                "relative gap of its point",
            ),
            Part(
                "F2/reduced",
                Role.STATED,
                "the reduced problem: its certified interval contains F*",
                SAME,
                "relative gap of its point",
            ),
            Part(
                "F2/group_lasso",
                Role.STATED,
                "||A z - t||^2 + sum of group norms equals F at every z = (w, u), A = [[X', 0], [-s I, s X]], s^2 = lambda1",
                "",
                "difference, in exact arithmetic",
            ),
            Part(
                "F2/quadratic",
                Role.STATED,
                "OSQP, where lambda3 = 0 or every modality has one column: likewise",
                SAME,
                "relative gap of its point",
            ),
        ),
    ),
    Claim(
        "F3",
        "Eq. (full)",
        Subject.FORMULATION,
        "The l1-norm gives exact zeros in w, the group norm whole modalities that are exactly zero; both are"
        " all zero beyond critical lambdas.",
        "A scalar argument for the critical lambda2; exact evaluation at and just below it; proved zeros.",
        (
            Part(
                "F3/critical_lambda2",
                Role.STATED,
                "w = u = 0 is optimal if and only if lambda2 >= 2 max_j |x_j'o| (lambda1, lambda3 > 0)",
                "",
                "relative distance of F* from ||o||^2 on the wrong side",
            ),
            Part(
                "F3/critical_lambda3",
                Role.STATED,
                "u = 0 is optimal from the library's critical lambda3 on",
                SAME,
                "relative distance of F* from the optimum with u = 0",
            ),
            Part(
                "F3/exact_zeros",
                Role.STATED,
                "at an optimum with |v_j| < lambda2 the entry w*_j is 0, not merely small: proved zeros are true",
                "",
                "proved zeros that the referee contradicts",
            ),
        ),
    ),
    Claim(
        "F4",
        "after the modality norm",
        Subject.FORMULATION,
        "The l2-norm within a modality makes the weights of that modality become similar.",
        "Exact optima with one view, where u^i is a multiple of the data; columns that are equal.",
        (
            Part(
                "F4/similar",
                Role.STATED,
                "the spread max_k |u^i_k| / min_k |u^i_k| within a modality falls as lambda3 grows",
            ),
            Part(
                "F4/parallel",
                Role.REPAIR,
                "u*^i = -(rho_i / lambda3) X_i'b: zero as a whole, or shaped by the data alone;"
                " equal columns of one modality get equal weights",
                SAME,
                "difference of the two weights, relative",
            ),
        ),
    ),
)

DERIVATION = (
    Claim(
        "D1",
        "derivative for w",
        Subject.ALGORITHM,
        "The printed stationarity equation for w is the derivative of F set to 0.",
        "F is convex, so its difference quotients enclose its derivative: evaluated in exact arithmetic.",
        (
            Part(
                "D1/printed",
                Role.STATED,
                "dF/dw = 2XX'w - 2Xo - 2 lambda1 Xu + 2 lambda1 w + lambda2 D w, D = diag(1/(2 w_i))",
                "",
                "distance from the enclosure, relative",
            ),
            Part(
                "D1/corrected",
                Role.REPAIR,
                "the same with D = diag(1/|w_i|), where no w_i is 0",
                "",
                "distance from the enclosure, relative",
            ),
        ),
    ),
    Claim(
        "D2",
        "derivative for u",
        Subject.ALGORITHM,
        "The printed stationarity equation for u is the derivative of F set to 0.",
        "As D1.",
        (
            Part(
                "D2/printed",
                Role.STATED,
                "dF/du = 2 lambda1 X'Xu - 2 lambda1 X'w + lambda3 D u, D = blockdiag(I/(2||u^i||))",
                "",
                "distance from the enclosure, relative",
            ),
            Part(
                "D2/corrected",
                Role.REPAIR,
                "the same with D = blockdiag(I/||u^i||), where no u^i is 0",
                "",
                "distance from the enclosure, relative",
            ),
        ),
    ),
    Claim(
        "L1",
        "Lemma 1",
        Subject.ALGORITHM,
        "||t|| - ||t||^2/(2||v||) <= ||v|| - ||v||^2/(2||v||) for any two vectors.",
        "z3 over the reals, in the two norms.",
        (
            Part(
                "L1/inequality",
                Role.STATED,
                "as stated, for all v, t",
                "",
                "left - right, in exact arithmetic",
            ),
        ),
    ),
    Claim(
        "L2",
        "appendix, after Lemma 1",
        Subject.ALGORITHM,
        "The analogue of Lemma 1 with l1-norms and squared l2-norms.",
        "Exhaustive search over small integers; z3 for the repair.",
        (
            Part(
                "L2/inequality",
                Role.STATED,
                "||t||_1 - ||t||_2^2/(2||v||_1) <= ||v||_1 - ||v||_2^2/(2||v||_1) for all v != 0, t",
                "",
                "left - right, in exact arithmetic",
            ),
            Part(
                "L2/elementwise",
                Role.REPAIR,
                "sum_j (|t_j| - t_j^2/(2|v_j|)) <= ||v||_1/2 where no v_j is 0",
                "",
                "left - right, in exact arithmetic",
            ),
        ),
    ),
    Claim(
        "A1",
        "appendix, objective",
        Subject.ALGORITHM,
        "The objective that the proof starts from is Eq. (full).",
        "Both evaluated at rational points.",
        (
            Part(
                "A1/objective",
                Role.STATED,
                "||X'w-o||^2 + ||Xu-w||^2 + lambda2 ||w||_1 + lambda3 ||u||_M = F(w, u) for all lambdas",
                "",
                "relative difference",
            ),
            Part("A1/lambda1_one", Role.REPAIR, "the same for lambda1 = 1", "", "relative difference"),
        ),
    ),
    Claim(
        "A2",
        "appendix, substitution",
        Subject.ALGORITHM,
        "By the definition of D^w in Algorithm 1, w'D^w w is ||w||_2^2 / (2 ||w(i)||_1).",
        "Both evaluated at rational points; z3 for when they agree.",
        (
            Part(
                "A2/substitution",
                Role.STATED,
                "sum_j w_j^2/(2|v_j|) = ||w||_2^2/(2||v||_1), v = w(i), w = w(i+1)",
                "",
                "relative difference",
            ),
            Part(
                "A2/elementwise",
                Role.REPAIR,
                "at w = v both sides agree if and only if at most one entry is not 0;"
                " the left side at w = v is ||v||_1/2",
                "",
                "relative difference",
            ),
        ),
    ),
)

ALGORITHM = (
    Claim(
        "T1a",
        "Theorem 1",
        Subject.ALGORITHM,
        "The objective never increases from one iteration to the next.",
        "Every reading in both orders from the paper's start, on every family; a rise is confirmed in exact"
        " arithmetic before it counts.",
        _by_reading(
            "T1a",
            "{reading} update, {order}: F(w(i+1), u(i+1)) <= F(w(i), u(i))",
            ROUNDING,
            "largest rise of F / max(F(start), ||o||^2)",
        ),
    ),
    Claim(
        "T1b",
        "Theorem 1",
        Subject.ALGORITHM,
        "The iteration converges to the optimum of F.",
        "As T1a; F* from certified answers; a run that meets the limit of iterations is undecided.",
        _by_reading(
            "T1b",
            "{reading} update, {order}: F(w(i), u(i)) -> F* from the paper's start",
            LIMIT,
            "(F(last) - F*) / F* of runs that ended by themselves",
        ),
    ),
    Claim(
        "T1c",
        "ours",
        Subject.ALGORITHM,
        "The repaired theorem: the corrected update never raises F; it reaches the optimum unless an entry of w"
        " or a block of u is exactly 0 and ought not to be; the smoothed update cannot lock and ends within a"
        " stated distance.",
        "A written proof whose every step is an identity, a z3 query or a cited theorem; the loop beside it.",
        (
            Part(
                "T1c/descent/gauss_seidel",
                Role.STATED,
                "corrected: F(i) - F(i+1) >= sum of weighted squares of the steps >= 0 (Gauss-Seidel)",
                ROUNDING,
                "shortfall of the fall of F, relative",
            ),
            Part(
                "T1c/descent/jacobi",
                Role.STATED,
                "corrected: F(i) - F(i+1) >= sum of weighted squares of the steps >= 0 (Jacobi)",
                ROUNDING,
                "shortfall of the fall of F, relative",
            ),
            Part(
                "T1c/limit",
                Role.STATED,
                "corrected, Gauss-Seidel: F(i) -> F* if lambda1, lambda2, lambda3 > 0 and no entry of w and no block"
                " of u ever is exactly 0",
                LIMIT,
                "(F(last) - F*) / F* of runs that converged",
            ),
            Part(
                "T1c/smoothed_descent",
                Role.STATED,
                "smoothed: F_eps never rises, in either order",
                ROUNDING,
                "largest rise of F_eps, relative",
            ),
            Part(
                "T1c/smoothed_distance",
                Role.STATED,
                "F <= F_eps <= F + eps (n lambda2 + m lambda3): a minimum of F_eps is that close to F*",
                LIMIT,
                "share of the allowed distance that was used",
            ),
            Part(
                "T1c/absolute",
                Role.STATED,
                "absolute value alone: the same with F where lambda2 and lambda3 are halved, not with F",
                ROUNDING,
                "largest rise of that objective, relative",
            ),
            Part(
                "T1c/rate",
                Role.STATED,
                "corrected: linear where every zero is strict, |v_j| < lambda2; F - F* = 1/(k+1)^2 exactly at"
                " X = o = 1, lambda1 = 0, lambda2 = 2, where it is not",
            ),
        ),
    ),
    Claim(
        "C1",
        "complexity",
        Subject.ALGORITHM,
        "Steps 6 and 7, as systems of linear equations, cost O(n^2) and O(d^2).",
        "Multiplications counted by a number type, so that two runs agree; times beside them.",
        (
            Part(
                "C1/step6",
                Role.STATED,
                "step 6 by elimination: multiplications grow like n^2",
                "exponent within 0.1 of it",
                "measured exponent",
            ),
            Part(
                "C1/step7",
                Role.STATED,
                "step 7 by elimination: multiplications grow like d^2",
                "exponent within 0.1 of it",
                "measured exponent",
            ),
            Part(
                "C1/woodbury",
                Role.REPAIR,
                "step 7 by Woodbury's identity: O(n^2 d + n^3), linear in d",
                "exponent within 0.1 of it",
                "measured exponent",
            ),
            Part(
                "C1/reduction",
                Role.REPAIR,
                "on the reduced problem an iteration does not depend on d",
                "exponent within 0.1 of it",
                "measured exponent",
            ),
        ),
    ),
    Claim(
        "N1",
        "comment on invertibility",
        Subject.ALGORITHM,
        "The matrices of both updates are never singular on real observations.",
        "Exact determinants and ranks; z3 for the repair.",
        (
            Part("N1/w_system", Role.STATED, "XX' + lambda1 I + (lambda2/2) D^w is never singular", "", ""),
            Part("N1/u_system", Role.STATED, "lambda1 X'X + (lambda3/2) D^u is never singular", "", ""),
            Part(
                "N1/positive",
                Role.REPAIR,
                "with |w_i| for w_i and no exact zero: both are positive definite if lambda1 > 0 (w), lambda3 > 0 (u)",
                "",
                "",
            ),
        ),
    ),
    Claim(
        "R1",
        "Algorithm 1",
        Subject.ALGORITHM,
        "The label is the category with the lowest objective.",
        "Exact ties; the referee's optimum of every template against the library's verdict.",
        (
            Part(
                "R1/defined",
                Role.STATED,
                "exactly one template has the lowest optimum, and it depends on the views",
                "",
                "",
            ),
            Part(
                "R1/separated",
                Role.REPAIR,
                "the label is defined exactly where the lowest optimum lies below all others; proved as soon as"
                " upper_best < lower_j for all other j",
                SAME,
                "",
            ),
            Part(
                "R1/all_zero",
                Role.REPAIR,
                "where lambda2 >= 2 max_j |x_j'o| for all templates, F*_j = ||o_j||^2: the shortest template wins, whatever"
                " the robots see",
                "",
                "",
            ),
        ),
    ),
)

UNTIL_EXPERIMENTS = "needs pictures of robots and objects; the original ones are not public"


def _experiment(number: int, place: str, statement: str) -> Claim:
    part = Part(f"X{number}/stated", Role.STATED, statement)
    return Claim(f"X{number}", place, Subject.EXPERIMENTS, statement, "-", (part,), UNTIL_EXPERIMENTS)


EXPERIMENTS = (
    _experiment(
        1, "simulation", "5 robots, 3 objects: the three best-ranked views are good and unobstructed."
    ),
    _experiment(
        2,
        "physical, accuracy",
        "6 robots, 8 objects, n = 1..6 views: lambda2 = lambda3 = 0 is worst at every n.",
    ),
    _experiment(3, "physical, accuracy", "lambda2 = lambda3 = 0.1 is best at every n."),
    _experiment(4, "physical, accuracy", "With one norm only, that of w beats that of u."),
    _experiment(
        5, "physical, information", "Views ranked higher by w share more mutual information with the object."
    ),
    _experiment(
        6, "discussion, w", "Nearly 0 on two obstructed views; over 80 % of the weight on two views."
    ),
    _experiment(7, "discussion, u", "The total weight of LBP is nearly 0; HOG is primary."),
    _experiment(
        8,
        "discussion, lambdas",
        "Accuracy is low at 0 and at 10, highest at lambda2 in {0.1, 1}, lambda3 = 0.1.",
    ),
)

SOLVERS = (
    Claim(
        "S1",
        "ours",
        Subject.SOLVERS,
        'A status "optimal" of CVXPY with Clarabel at default settings means an optimum.',
        "The value against the proved interval of F*, by family and by scale.",
        (
            Part(
                "S1/optimal",
                Role.STATED,
                'the value of an "optimal" answer is within 1e-6 F* of [lower, upper]',
                "1e-6: a hundred times Clarabel's own tolerance of 1e-8",
                "distance from the interval / F*",
            ),
        ),
    ),
)

LIBRARY = (
    Claim(
        "B1",
        "ours",
        Subject.LIBRARY,
        "F, its terms, its derivative and the dual value are what the formulas say.",
        "Against exact rationals that share no formula with the library.",
        (
            Part(
                "B1/objective",
                Role.STATED,
                "each term of `terms` and F agree with exact arithmetic",
                "8 (n + d) units in the last place of the sum of magnitudes",
                "error / allowance",
            ),
            Part(
                "B1/dual",
                Role.STATED,
                "gap, lower and upper of `certify` bound the exact values at any point",
                "",
                "violations",
            ),
            Part("B1/scaling", Role.STATED, "F* of scaled data is the scaled F*", SAME, "violations"),
        ),
    ),
    Claim(
        "B2",
        "ours",
        Subject.LIBRARY,
        "No statement of a certificate is false, and every problem is answered.",
        "Every statement against the exact optimum.",
        (
            Part(
                "B2/true",
                Role.STATED,
                "lower <= F* <= upper, gap, tolerances and proved zeros, against the referee",
                "",
                "false statements",
            ),
            Part(
                "B2/answered",
                Role.STATED,
                "`solve` ends certified or enclosed",
                "1e-9 F* or 1e-14 ||o||^2",
                "relative gap",
            ),
            Part(
                "B2/batch",
                Role.STATED,
                "`solve_many`: every interval contains F*, every u gives its F",
                SAME,
                "violations",
            ),
        ),
    ),
    Claim(
        "B3",
        "ours",
        Subject.LIBRARY,
        "The paper's loop does what each reading says.",
        "One exact step (rationals, or balls of 256 bits) from every kind of iterate.",
        (
            Part(
                "B3/step",
                Role.STATED,
                "each float64 iterate is the exact update of the one before",
                "1e-9 of its norm, times the condition of the system",
                "error / allowance",
            ),
            Part(
                "B3/trace",
                Role.STATED,
                "the trace's F is F at its iterates, and its stop reason is true",
                ROUNDING,
                "violations",
            ),
        ),
    ),
    Claim(
        "B4",
        "ours",
        Subject.LIBRARY,
        "A proved label is the label; a tie is called a tie.",
        "The exact optimum of every template.",
        (
            Part("B4/label", Role.STATED, "a proved label has the lowest exact optimum", "", "violations"),
            Part(
                "B4/tie",
                Role.STATED,
                "identical or permuted templates are never told apart",
                "",
                "violations",
            ),
        ),
    ),
    Claim(
        "B5",
        "ours",
        Subject.LIBRARY,
        "Features are what they are called, in the modality that is named.",
        "Against direct computations on small pictures.",
        (
            Part(
                "B5/histogram",
                Role.STATED,
                "the colour block counts pixels by bin and channel",
                "1e-12",
                "largest difference",
            ),
            Part(
                "B5/hog",
                Role.STATED,
                "the HOG block is scikit-image's on the grey picture; it turns with the picture",
                "1e-9",
                "largest difference",
            ),
            Part(
                "B5/lbp",
                Role.STATED,
                "the LBP block is a histogram of scikit-image's codes",
                "1e-12",
                "largest difference",
            ),
            Part(
                "B5/partition",
                Role.STATED,
                "blocks have the stated order, sizes and unit length",
                "1e-12",
                "largest difference",
            ),
        ),
    ),
)

CLAIMS: dict[str, Claim] = {
    claim.id: claim for claim in FORMULATION + DERIVATION + ALGORITHM + EXPERIMENTS + SOLVERS + LIBRARY
}
PARTS: dict[str, Part] = {part.key: part for claim in CLAIMS.values() for part in claim.parts}
