"""The fixed words of the report: what a verdict means, what limits it, the symbols, the captions."""

from dataclasses import dataclass

from verification.ledger.claims import Role
from verification.ledger.evidence import Checker, Outcome, Verdict
from verification.search.profiles import PROFILES

TITLE = "Convex multi-robot perception: the claims of the paper, judged"
PAPER = (
    "The paper: B. Reily and H. Zhang, Simultaneous View and Feature Selection for Collaborative Multi-Robot"
    " Perception. Claims are told in our words; places are its equations, by the names of their labels, its"
    " theorem, its algorithm and its appendix. Proofs are written out in docs/theorem.md of the project."
)

VERDICTS = {
    Verdict.HOLDS: "Proved in writing (docs/theorem.md). A machine checked the algebraic steps: as exact"
    " identities, by the solvers z3 and cvc5 over the real numbers, or by exact evaluation. The theorems"
    " of the literature that are cited, and the inferences that are made in words alone, are counted apart.",
    Verdict.HOLDS_UNDER: "Proved in the same way, but only under the condition that is named.",
    Verdict.SUPPORTED: "Tested on the stated number of cases without a failure. This is not a proof.",
    Verdict.REFUTED: "False as stated. A counterexample is stored, and it was confirmed during this run: in"
    " exact arithmetic or, where the claim is about a program, by running it again beside a proved interval."
    " This is a finding about the claim, not a failure of the run.",
    Verdict.INCONCLUSIVE: "None of these: nothing was decided, or cases failed that nobody could"
    " confirm exactly. Of the experiments: the data do not tell in at least 95 % of the configurations.",
    Verdict.NOT_TESTABLE: "Cannot be judged here, for the reason that is given.",
    Verdict.REPRODUCED: "Of the experiments, on other data than the paper's: found in at least 95 % of the"
    " configurations, which are choices of what the paper leaves open.",
    Verdict.DEPENDS: "Of the experiments: found in some configurations and not in others. The factor is named"
    " whose levels differ most, if one does.",
    Verdict.NOT_REPRODUCED: "Of the experiments: found in at most 5 % of the configurations. This does not"
    " say that it is false of the paper's data.",
    Verdict.OPPOSITE: "Of the experiments: the opposite was found in at least 95 % of the configurations."
    " This does not say that it is false of the paper's data.",
}

TONES = {
    Verdict.HOLDS: "holds",
    Verdict.HOLDS_UNDER: "under",
    Verdict.SUPPORTED: "supported",
    Verdict.REFUTED: "refuted",
    Verdict.INCONCLUSIVE: "open",
    Verdict.NOT_TESTABLE: "untested",
    Verdict.REPRODUCED: "supported",
    Verdict.DEPENDS: "open",
    Verdict.NOT_REPRODUCED: "untested",
    Verdict.OPPOSITE: "refuted",
}
"""Class names in the style sheet."""

ROLES = {
    Role.STATED: "as stated",
    Role.VARIANT: "variant",
    Role.REPAIR: "corrected statement",
}

CHECKERS = {
    Checker.IDENTITY: "two polynomials with rational coefficients were expanded and compared",
    Checker.SOLVERS: "z3 and cvc5 each found real numbers that satisfy the hypotheses, and none that satisfy"
    " them and violate the conclusion",
    Checker.EXACT: "a statement about given rational numbers was evaluated",
    Checker.CITED: "a theorem of the literature; no machine checked it here",
    Checker.PROSE: "an inference that joins the steps; no machine checked it here, docs/theorem.md argues it",
}

OUTCOMES = {
    Outcome.HELD: "the case agrees with the part",
    Outcome.FAILED: "it does not; the verdict rests on the counterexamples that were confirmed, not on this"
    " count",
    Outcome.UNDECIDED: "the case does not tell, for example a loop that met its limit of iterations",
    Outcome.SKIPPED: "the part says nothing about such a case",
}

LIMITATIONS = (
    '"Supported" speaks of the cases that were tried and of no others. They come from families of'
    " problems that the authors of this report chose, and they are small: at most 4 views and 8 features.",
    "A profile tries a check on as many problems of each family as the settings say, an expensive check on"
    f" a part of that, and none on fewer than {PROFILES['quick'].least} (quick), {PROFILES['ci'].least} (ci)"
    f" or {PROFILES['full'].least} (full). The profile quick has {PROFILES['quick'].problems}: that"
    f" shows what fails often, not what fails rarely. The profiles ci ({PROFILES['ci'].problems}) and full"
    f" ({PROFILES['full'].problems}) say more.",
    "The cases are no random sample: each family begins with its simplest problem, and the search then drives"
    " the measure of a part up. A share of failures says how easily one is found, not how often one occurs.",
    "The counterexamples of the catalogue were made small on purpose; how small is said with each. Those that"
    " the search met are the smallest of their run; the profile quick shrinks them for stated parts alone.",
    "A claim that has no meaning somewhere, as a division by 0, is judged where it has one, and holds under"
    " that condition. One that has a meaning and is false somewhere is refuted, however small that place."
    " Several refutations share a cause: the absolute value and the factor 2 that the derivatives lack are"
    " behind D1, D2, T1a and T1b; the l1-norm in place of its entries behind L2, A2 and appendix variants.",
    "Each claim was put into formal parts by us. Where the paper's words admit several interpretations,"
    ' one is marked "as stated" and decides the verdict; the others are judged beside it.',
    "A proof is as sound as what checked its steps, and as the words between them. Of a step, the formula"
    " was checked; what its letters stand for, and the gloss beside it, were not. Cited theorems and"
    " joints, as how scalar steps add up in every dimension or pass to a limit, were checked by no machine.",
    "The limit of an iteration cannot be observed. A run that meets the limit of 150 iterations is"
    " undecided, and never counts as a failure. One that meets a singular system has no next iterate, and"
    " counts as a failure to converge.",
    "The loops run in float64. A rise of F counts once one exact update from the iterate before it rises as"
    " well; a wrong limit, where the run ends by itself above the proved interval of F*. The counterexamples"
    " of the catalogue are exact from the first iterate to the limit; those named found-... repeat a case.",
    "Rigorous intervals of F* assume IEEE 754 arithmetic that rounds to nearest, and matrix"
    " products that sum ordinary products, in any order.",
    "What is said of other solvers holds for the versions named here, at their default settings.",
    "The same seed and versions give the same files. On another processor, a case that lies exactly at a"
    " tolerance may be counted differently.",
    "The paper's pictures are not public. The claims about the experiments are judged on simulated scenes of"
    " the same design, and not on the paper's own: what is refuted here may hold there.",
    "The paper leaves open what a repetition needs: lambda1 in the experiments, the bins of the"
    " histograms, the settings of HOG and LBP, the size of the pictures and their normalisation. The"
    " configurations vary these, and nothing else; a fraction of all combinations shows the effect of each,"
    " not of all together.",
)

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
    ("locked", "a weight that is exactly 0 and stays 0 for ever, although the optimum needs it"),
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
    ("w(i), u(i)", "the iterates of Algorithm 1; t' is the transpose of t"),
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


@dataclass(frozen=True)
class Figure:
    """A figure of the report.

    Attributes
    ----------
    name : str
        Key of the series that it draws.
    claim : str
        The claim that it belongs to.
    title, caption : str
    """

    name: str
    claim: str
    title: str
    caption: str


FIGURES = (
    Figure(
        "counterexample",
        "T1a",
        "One counterexample, iteration by iteration",
        "F at each iteration for several variants of the update, from the same start. The band is"
        " an interval that is proved to contain the optimum F*. Equal curves lie one over the other:"
        " absolute and appendix half; corrected, appendix full and smoothed. A curve that is shorter than"
        " the others came to rest.",
    ),
    Figure(
        "distance",
        "T1b",
        "Where the iteration ends",
        "Each row is one update variant in one order (GS: Gauss-Seidel): the darker a cell, the larger the"
        " share of its runs that ended with that relative distance (F(last) - F*)/F*. The line is the"
        " tolerance; the first cell holds all that ended at 1e-16 or below, the last all beyond 100. On the"
        " right: runs whose distance is known + undecided runs + runs without an end, whose system was"
        " singular or that diverged.",
    ),
    Figure(
        "rate",
        "T1c",
        "How fast the repaired update gets there",
        "(F - F*) / F* by iteration, both axes logarithmic. A straight line is a power of the iteration, a"
        " curve that bends down is faster than every power. Values of 0 or below, where rounding"
        " ends the curve, are not drawn. The dotted line 1/(2k+1)^2 is proved to lie below the"
        " curve of the corrected update where one zero is not strict.",
    ),
    Figure(
        "cost",
        "C1",
        "Counted multiplications by size",
        "Multiplications of one step, counted by running it on numbers that count, both axes"
        " logarithmic; the slope is the measured exponent. The curves of steps 6 and 7 coincide.",
    ),
    Figure(
        "clarabel",
        "S1",
        'Answers with the status "optimal", by the scale of the data',
        "o, lambda2 and lambda3 are multiplied by the scale, which multiplies F* by its square and"
        " changes nothing else. Shares of the answers that lie outside the proved interval of F* by"
        " more than the stated part of F*, and of those that are not called optimal.",
    ),
)

TIMES = Figure(
    "times",
    "C1",
    "Measured times by size",
    "Seconds of the same steps on this machine, both axes logarithmic.",
)

NOT_RUN = "Not run in this profile."
