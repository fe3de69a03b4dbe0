"""The fixed words of the report: what a verdict means, what limits it, the terms, the outcomes."""

from verification.ledger.claims import Role, Voice
from verification.ledger.evidence import Checker, Outcome, Verdict
from verification.search.profiles import PROFILES

TITLE = "Convex multi-robot perception: verification report"
AUTHORS = "Brian Reily and Hao Zhang"
PAPER = "Simultaneous View and Feature Selection for Collaborative Multi-Robot Perception"
ARXIV = "2012.09328"
LINK = f"https://arxiv.org/abs/{ARXIV}"
THEOREM = "docs/theorem.md"

OUTCOMES = {
    0: "Exit code 0: every verdict is the one that the baseline expects, no promise of the library"
    " failed, every stored counterexample still fails, and nothing that was required is missing.",
    1: "Exit code 1: this run differs from the baseline.",
    3: "Exit code 3: nothing contradicts the baseline, but something that was required is missing or"
    " undecided.",
}
"""By the exit code of the run; a promise and the baseline are explained with the terms."""

VOICES = {
    Voice.PAPER: (
        "The paper's claims",
        "Statements of the paper, put in our words; the place is its equation, by the name of its label,"
        " its theorem, its algorithm or its appendix.",
    ),
    Voice.QUESTION: (
        "Our questions",
        "Statements that the paper makes informally or not at all, and that this project asks about, among"
        " them its corrected version of Theorem 1. Here refuted means that the answer is no; it is no fault"
        " of the paper.",
    ),
    Voice.PROMISE: (
        "Promises of this library",
        "Properties that the library convexperc claims for itself. If one of them fails, the exit code is 1.",
    ),
}
"""Title of each group of claims, and what its statements are."""

VERDICTS = {
    Verdict.HOLDS: f"There is a written proof ({THEOREM}). A machine checked its algebraic steps; the"
    " theorems of the literature that it cites, and the inferences that it makes in words"
    " alone, are listed and counted separately.",
    Verdict.HOLDS_UNDER: "The same, but only under the condition that is named.",
    Verdict.SUPPORTED: "Tested on the stated number of cases without a failure. This is not a proof.",
    Verdict.REFUTED: "False as stated: a stored counterexample was confirmed again in this run, in exact"
    " arithmetic or, for a statement about a program, by running it beside a proved"
    " interval.",
    Verdict.INCONCLUSIVE: "Neither: no case was decided, or cases failed and none could be confirmed"
    " exactly. For an experiment: found in at most 5 % of the configurations, and left"
    " open by the data in at least half of them.",
    Verdict.NOT_TESTABLE: "It could not be judged, for the reason that is given.",
    Verdict.REPRODUCED: "For an experiment, on data other than the paper's: found in at least 95 % of the"
    " configurations.",
    Verdict.WHERE_DECIDED: "For an experiment: found in more than 5 % of the configurations, while at most"
    " 5 % show no effect or the opposite; the data leave the others open.",
    Verdict.DEPENDS: "For an experiment: found in more than 5 % of the configurations, while more than 5 %"
    " show no effect or the opposite. The condition names the choice that matters most, if there is one.",
    Verdict.NOT_REPRODUCED: "For an experiment: found in at most 5 % of the configurations, while more than"
    " half show no effect or the opposite. It may still be true of the paper's data.",
    Verdict.OPPOSITE: "For an experiment: in at least 95 % of the configurations the opposite was found, of a"
    " claim with several comparisons in at least one of them. It may still be true of the paper's data.",
}

TONES = {
    Verdict.HOLDS: "holds",
    Verdict.HOLDS_UNDER: "under",
    Verdict.SUPPORTED: "supported",
    Verdict.REFUTED: "refuted",
    Verdict.INCONCLUSIVE: "open",
    Verdict.NOT_TESTABLE: "untested",
    Verdict.REPRODUCED: "supported",
    Verdict.WHERE_DECIDED: "supported",
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

OUTCOME_OF_A_CASE = {
    Outcome.HELD: "the case agrees with the part",
    Outcome.FAILED: "it does not; a verdict rests on confirmed counterexamples and never on this count alone",
    Outcome.UNDECIDED: "the case does not tell, for example because a loop reached its limit of iterations",
    Outcome.SKIPPED: "the part says nothing about such a case",
}

TERMS = (
    ("claim", "a statement in the ledger, with an identifier such as T1a"),
    (
        "part",
        "one formal version of a claim. The part marked as stated decides the verdict on the claim; a"
        " variant is the same statement about another update; a corrected statement is what is true instead",
    ),
    ("case", "one problem, with given numbers, on which one part was tried"),
    (
        "family",
        "a kind of problem that cases are drawn from, for example problems whose X has a row of zeros",
    ),
    ("profile", "how many problems are drawn: quick, ci or full"),
    ("baseline", "the stored list of expected verdicts that a run is compared with"),
    ("promise", "a property that the library convexperc claims for itself"),
    (
        "configuration",
        "in the experiments, one choice of everything that the paper leaves open, for example lambda1 and"
        " the settings of the features",
    ),
    ("proved interval", "two numbers that are proved to enclose F*, with rounding errors included"),
    (
        "joint",
        "an inference of a written proof that leads from one step to the next; it is argued in words, and"
        " no machine checks it",
    ),
    ("referee", "a slow computation of F* in exact arithmetic that shares no formula with the library"),
)

LIMITATIONS = (
    '"Supported" refers to the cases that were tried and to no others. They come from families of problems'
    " that the authors of this report chose, and they are small: at most 4 views and 8 features.",
    "A profile tries a check on as many problems of each family as the settings say, an expensive check on"
    f" a part of that, and none on fewer than {PROFILES['quick'].least} (quick), {PROFILES['ci'].least} (ci)"
    f" or {PROFILES['full'].least} (full). The profile quick draws {PROFILES['quick'].problems} of each"
    f" family, which shows what fails often, not what fails rarely; ci draws {PROFILES['ci'].problems}, and"
    f" full {PROFILES['full'].problems}.",
    "The cases are not a random sample: each family begins with its simplest problem, and the search then"
    " tries to increase the measure of a part. A share of failures says how easily one is found, not how"
    " often one occurs.",
    "The counterexamples of the catalogue were made small on purpose; each says how small it is. Those that"
    " the search found are the smallest of their run; the profile quick shrinks those of stated parts only.",
    "Where a claim has no meaning, for example because it divides by 0, it is not judged: it is said to"
    " hold under the condition that it has one. A claim that has a meaning and is false somewhere is"
    " refuted, even if it is false in few places.",
    "We put each claim into formal parts. Where the paper's words allow several interpretations, one is"
    " marked as stated and decides the verdict; the others are judged beside it.",
    "A proof is as sound as what checked its steps, and as the words between them. Of a step, the formula"
    " was checked; what its letters stand for, and the words beside it, were not. Cited theorems and"
    " inferences in words, such as how scalar steps add up in every dimension or pass to a limit, were"
    " checked by no machine.",
    "The limit of an iteration cannot be observed. A run that reaches the limit of 150 iterations is"
    " undecided and never counts as a failure; one that meets a singular system has no next iterate and"
    " counts as a failure to converge.",
    "The loops run in float64. A rise of F counts only if one exact update from the iterate before it rises"
    " as well; a wrong limit counts only if the run ends by itself above the proved interval of F*. The"
    " counterexamples of the catalogue are exact from the first iterate to the limit; those named found-..."
    " repeat a case of the search.",
    "Proved intervals of F* assume IEEE 754 arithmetic that rounds to nearest, and matrix products that sum"
    " ordinary products, in any order.",
    "Statements about other solvers refer to the versions named here, at their default settings.",
    "The same seed and versions give the same files. On another processor, a case that lies exactly at a"
    " tolerance may be counted differently.",
    "The paper's pictures are not public. Its experiments were repeated on simulated scenes of the same"
    " design and on photographs; what is not found there may still be true of the paper's data.",
    "The paper does not state lambda1 in the experiments, the bins of the histograms, the settings of HOG"
    " and LBP, the size of the pictures or their normalisation. The configurations that count vary these"
    " and nothing else, and only a fraction of all combinations is tried.",
)

CHECKERS = {
    Checker.IDENTITY: "two polynomials with rational coefficients, or two matrix expressions of any size,"
    " were expanded and compared",
    Checker.SOLVERS: "z3 and cvc5 each found real numbers that satisfy the hypotheses, and none that"
    " satisfy them and violate the conclusion",
    Checker.EXACT: "a statement about given rational numbers was evaluated",
    Checker.CITED: "a theorem of the literature, which no machine checked here",
    Checker.PROSE: "an inference that joins steps; the section named beside it argues it, and no machine did",
}
