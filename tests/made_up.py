"""Made-up evidence for tests of the report: every part of the ledger, no number of it measured."""

import math

from made_up_experiments import surveys

from verification.ledger.baseline import Judged
from verification.ledger.claims import PARTS
from verification.ledger.evidence import Argument, Checker, Count, Evidence, Refutation, Step
from verification.ledger.verdicts import judge_all
from verification.problems.families import FAMILIES

PROVED = (
    "F1/convex",
    "F1/bounded",
    "F1/attained",
    "F3/critical_lambda2",
    "D1/corrected",
    "D2/corrected",
    "T1a/corrected/gauss_seidel",
    "T1a/corrected/jacobi",
    "T1c/descent/gauss_seidel",
    "T1c/limit",
    "N1/positive",
)
REFUTED = {
    "D1/printed": "X = o = w = lambda2 = 1, lambda1 = 0, u = 0: the equation gives 1/2, the derivative is 1",
    "L2/inequality": "v = (1, 0), t = (1, 1): 2 - 2/2 = 1 > 1/2 = 1 - 1/2",
    "T1a/printed/gauss_seidel": "X = lambda1 = 1, o = -1, lambda2 = 4, lambda3 = 0: F goes 4, 9, 9; F* = 1",
    "T1b/printed/gauss_seidel": "X = o = lambda1 = lambda2 = 1, lambda3 = 0: F -> 13/16, F* = 3/4",
    "S1/optimal": "X = 1, o = 1/100000000: the value is 1.26 F*",
}
SETTINGS = {
    "command": "python -m verification report --profile quick --seed 0",
    "profile": "quick",
    "seed": 0,
    "problems a family": 250,
    "versions": {"python": "3.11.0", "numpy": "2.0.0", "clarabel": "0.11.1"},
}
MACHINE = {
    "date": "2001-01-01T00:00:00+00:00",
    "commit": "0123abc",
    "processor": "an abacus",
    "blas kernel": "beads",
}


def argument(part, condition="", passed=True):
    steps = (
        Step(
            f"product: of two lengths, for {part}",
            Checker.SOLVERS,
            passed,
            "2*a*b <= a**2 + b**2",
            "a: ||x||",
        ),
        Step("square: expanded", Checker.IDENTITY, True, "(a - b)**2 = a**2 - 2*a*b + b**2"),
        Step("a bounded monotone sequence converges", Checker.CITED, True, "any textbook of analysis"),
        Step("sums: over the entries", Checker.PROSE, True, "docs/theorem.md 0"),
    )
    return Argument(part, PARTS[part].statement, condition, steps)


def refutation(part, confirmed=True, name=""):
    finding = REFUTED.get(part, "1 > 0")
    return Refutation(
        name or part.replace("/", "-").replace("_", "-").lower(),
        part,
        confirmed,
        finding,
        "n = d = 1",
        "catalogue",
    )


def counts(part):
    """Two hundred and fifty cases a family; parts in `REFUTED` fail in some families."""
    made = []
    for at, family in enumerate(FAMILIES):
        failed = at * 7 % 90 if part in REFUTED else 0
        undecided = at % 4 if part.startswith("T1b") else 0
        made.append(
            Count(part, family, 250 - failed - undecided, failed, undecided, at % 3, 10.0 ** (at % 12 - 16))
        )
    return made


def series():
    runs = {f"{name} gauss_seidel": [4.0 - f * k / (k + 1) for k in range(12)] for name, f in FALLS.items()}
    decades = [10.0**k for k in range(-16, 4)]
    names = [f"{name}/{order}" for name in FALLS for order in ("gauss_seidel", "jacobi")]
    ks = range(200)
    return {
        "coverage": dict.fromkeys(FAMILIES, 500),
        "counterexample": {"title": "sign", "F_star": [1.0, 1.0], "runs": runs},
        "distance": {
            "edges": decades,
            "counts": {name: [(at * k * k) % 97 for k in range(20)] for at, name in enumerate(names, 1)},
            "undecided": {name: at for at, name in enumerate(names)},
            "undefined": {name: 2 * at for at, name in enumerate(names)},
        },
        "rate": {
            "title": "rate",
            "curves": {
                "corrected, strict zeros": [0.5**k for k in range(60)],
                "corrected, critical": [(k + 1.0) ** -2 for k in ks],
                "smoothed": [1e-6 + 0.7**k for k in ks] + ["nan"],
            },
            "reference": "1/(2k+1)^2",
        },
        "cost": {
            name: {"x": [4, 8, 16, 32, 64], "y": [n**slope for n in (4, 8, 16, 32, 64)], "slope": slope}
            for name, slope in (("step6", 2.9), ("step7", 2.95), ("woodbury", 1.01), ("reduction", 0.0))
        },
        "clarabel": {
            "scales": [10.0**k for k in range(-8, 9)],
            "share_off_1e-6": [abs(k) / 8 for k in range(-8, 9)],
            "share_off_1e-3": [max(0, -k) / 10 for k in range(-8, 9)],
            "share_not_optimal": [max(0, k) / 8 for k in range(-8, 9)],
            "per_scale": [6] * 17,
        },
    }


SURVEYS = surveys()
FALLS = {
    "printed": -3.0,
    "absolute": 2.0,
    "corrected": 3.0,
    "appendix_half": 1.0,
    "appendix_full": 1.4,
    "smoothed": 2.9,
}


def evidence(**changes):
    """Evidence on every part; fields may be replaced."""
    testable = [key for key, part in PARTS.items() if part.rule is None]
    made = Evidence(
        settings=dict(SETTINGS),
        counts=[
            count for key in testable if key not in ("F1/attained", "N1/w_system") for count in counts(key)
        ],
        arguments=[argument(key) for key in PROVED] + [argument("L1/inequality", "v != 0")],
        refutations=[refutation(key) for key in REFUTED],
        surveys=SURVEYS,
        series=series(),
        volatile=dict(MACHINE),
    )
    made.counts += [Count("N1/w_system", "random", 3, worst=math.inf)]
    for name, value in changes.items():
        setattr(made, name, value)
    return made


def verdicts(found):
    """A baseline that expects just what this evidence says."""
    return {key: judgement.verdict for key, judgement in judge_all(found).items()}


def judged(made=None, baseline=None):
    """The made-up evidence, or other one, judged; by default it is just what the baseline expects."""
    made = made or evidence()
    return Judged.of(made, verdicts(made) if baseline is None else baseline)
