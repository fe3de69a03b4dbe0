"""The written proofs: every step passes, no planted fault does, and the document is the code."""

import ast
import re
from collections import Counter
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import pytest
from checked_arguments import checked_once

from convexperc.errors import InputError
from verification.ledger.claims import PARTS
from verification.ledger.evidence import Checker, Step
from verification.proofs import reweighted
from verification.proofs.arguments import all_arguments, all_steps, step_name
from verification.proofs.checkers import reals
from verification.proofs.checkers.formulas import evaluate, names
from verification.proofs.checkers.matrices import KNOWN, matrix_identity
from verification.proofs.checkers.polynomials import exact, identity
from verification.proofs.unchecked import JOINTS

DOCS = Path(__file__).parents[3] / "docs"
DOCUMENTS = {
    name: (DOCS / name).read_text(encoding="utf-8") for name in ("theorem.md", "reweighted-theorem.md")
}
TAG = r"\[(identity|smt|exact|cited|text)\s+([a-z0-9-]+)\]"
ALL = checked_once()
ARGUMENTS = {argument.part: argument for argument in ALL}
STEPS = {step_name(step): step for step in all_steps(ALL)}
TAGS = dict(zip(Checker, ("identity", "smt", "exact", "cited", "text"), strict=True))
CHECKED = {name: step for name, step in STEPS.items() if step.checker.is_machine}
TAGGED = {document: set(re.findall(TAG, text)) for document, text in DOCUMENTS.items()}


# --- all arguments -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", ARGUMENTS)
def test_every_argument_passes(part: str) -> None:
    argument = ARGUMENTS[part]
    assert part in PARTS, part
    assert argument.passed, [step for step in argument.steps if not step.passed]
    assert len({step_name(step) for step in argument.steps}) == len(argument.steps), part


def test_the_parts_that_are_proved() -> None:
    assert set(ARGUMENTS) == {
        *(
            "F1/convex",
            "F1/bounded",
            "F1/attained",
            "F2/group_lasso",
            "F3/critical_lambda2",
            "F3/exact_zeros",
        ),
        *("F4/parallel", "D1/corrected", "D2/corrected", "L1/inequality", "L2/elementwise", "A1/lambda1_one"),
        *("A2/elementwise", "T1a/corrected/gauss_seidel", "T1a/corrected/jacobi", "T1c/descent/gauss_seidel"),
        *("T1c/descent/jacobi", "T1c/limit", "T1c/smoothed_descent", "T1c/smoothed_distance", "T1c/absolute"),
        *(
            "T1c/rate",
            "C1/woodbury",
            "N1/positive",
            "N1/unlikely",
            "R1/separated",
            "R1/one_view",
            "R1/all_zero",
        ),
    }
    assert len(ALL) == len(ARGUMENTS)


def test_one_name_is_one_step() -> None:
    for argument in ARGUMENTS.values():
        for step in argument.steps:
            assert STEPS[step_name(step)] == step, (argument.part, step)
    failed = [step for step in STEPS.values() if not step.passed]
    assert not failed, failed


def test_two_runs_say_the_same() -> None:
    assert all_arguments() == ALL


def test_the_written_proof_names_every_step_and_its_checker() -> None:
    tags = set.union(*TAGGED.values())
    steps = {(TAGS[step.checker], name) for name, step in STEPS.items()}
    assert tags == steps, {"only in the text": tags - steps, "only in the code": steps - tags}


def test_the_general_theorem_names_all_its_steps() -> None:
    steps = {(TAGS[step.checker], step_name(step)) for step in reweighted.steps()}
    assert steps <= TAGGED["reweighted-theorem.md"], steps - TAGGED["reweighted-theorem.md"]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_the_head_counts_what_is_checked_cited_and_argued(document: str) -> None:
    count = Counter(STEPS[name].checker for _, name in TAGGED[document])
    head = " ".join(DOCUMENTS[document].split("\n## 1.")[0].split())
    for told in (
        f"{sum(count[each] for each in Checker if each.is_machine)} steps, of which",
        f"of which {count[Checker.IDENTITY]} are exact identities,",
        f"{count[Checker.SOLVERS]} are decided by z3 and cvc5, and {count[Checker.EXACT]} are exact eval",
        f"{count[Checker.CITED]} theorems are cited. The {count[Checker.PROSE]} joints,",
    ):
        assert told in head, told


def test_a_joint_is_argued_in_the_section_that_it_names() -> None:
    for name, step in STEPS.items():
        if step.checker is Checker.PROSE:
            document, section = step.source.removeprefix("docs/").split()
            parts = re.split(r"^##+ ([\d.]+?)\.? .*$", DOCUMENTS[document], flags=re.MULTILINE)
            sections = dict(zip(parts[1::2], parts[2::2], strict=True))
            assert re.search(rf"\[text\s+{name}\]", sections[section]), step


def test_every_joint_is_used() -> None:
    assert {name for name, step in STEPS.items() if step.checker is Checker.PROSE} == set(JOINTS)


# --- no step says nothing: every hypothesis is needed, no conclusion is one, no identity is one as typed ----


def formulas(step: Step) -> tuple[list[str], str]:
    """The hypotheses and the conclusion of a step that the solvers checked."""
    *given, conclusion = step.source.split(" => ")
    return (given[0].split(", ") if given else []), conclusion


def asked(hypotheses: list[str], conclusion: str) -> Step:
    meaning = dict.fromkeys(set(names(*hypotheses, conclusion)) - reals.KNOWN, "a number")
    return reals.real("name", "again", hypotheses, conclusion, **meaning)


BREAKING = {("lock-view", "x == 0"): ["w == 3/10", "x == 1/10", "u == 0", "y == 0"]}
"""Points, by step and hypothesis, where that hypothesis and the conclusion alone are false. What cannot be
proved there cannot be proved in general; without the point z3 takes 20 s to give up."""


def superfluous(step: Step) -> list[str]:
    """The hypotheses without which z3 still proves the conclusion."""
    hypotheses, conclusion = formulas(step)
    name = step_name(step)
    others = (
        [*(each for each in hypotheses if each is not left), *BREAKING.get((name, left), [])]
        for left in hypotheses
    )
    return [left for left, rest in zip(hypotheses, others, strict=True) if asked(rest, conclusion).passed]


def conjuncts(text: str) -> set[str]:
    tree = ast.parse(text, mode="eval").body
    parts = tree.values if isinstance(tree, ast.BoolOp) and isinstance(tree.op, ast.And) else [tree]
    return {ast.unparse(part) for part in parts}


class Typed:
    """Formulas as typed, but for the order of factors and summands and for factors that cancel."""

    def __init__(self, commuting: bool) -> None:
        self.commuting = commuting

    def name(self, name: str) -> "Sum":
        return Sum(self.commuting, [(((name, 1),), Fraction(1))])

    def number(self, value: int) -> "Sum":
        return Sum(self.commuting, [((), Fraction(value))])

    def divide(self, left: "Sum", right: "Sum") -> "Sum":
        factors, number = right.product
        return left * Sum(self.commuting, [(tuple((name, -power) for name, power in factors), 1 / number)])


@dataclass
class Sum:
    """Products with a number each; of letters, and of sums that are not expanded."""

    commuting: bool
    terms: list[tuple[tuple[tuple[str, int], ...], Fraction]]

    @property
    def key(self) -> str:
        return str(sorted(self.terms))

    @property
    def product(self) -> tuple[tuple[tuple[str, int], ...], Fraction]:
        return self.terms[0] if len(self.terms) == 1 else (((self.key, 1),), Fraction(1))

    @property
    def T(self) -> "Sum":  # noqa: N802 - the name that NumPy gave it
        return Sum(self.commuting, [(((f"transpose of {self.key}", 1),), Fraction(1))])

    def __add__(self, other: "Sum") -> "Sum":
        return Sum(self.commuting, self.terms + other.terms)

    def __mul__(self, other: "Sum") -> "Sum":
        (left, a), (right, b) = self.product, other.product
        factors = left + right
        if self.commuting:
            powers: Counter[str] = Counter()
            for name, power in factors:
                powers[name] += power
            factors = tuple(sorted((name, power) for name, power in powers.items() if power))
        return Sum(self.commuting, [(factors, a * b)])


def alike(left: str, right: str, commuting: bool) -> bool:
    """Whether two sides are the same but for what `Typed` overlooks."""
    return bool(evaluate(left, Typed(commuting)).key == evaluate(right, Typed(commuting)).key)


def sides(formula: str) -> list[tuple[str, str]]:
    """Pairs that a formula compares."""
    found = [node for node in ast.walk(ast.parse(formula, mode="eval")) if isinstance(node, ast.Compare)]
    return [(ast.unparse(node.left), ast.unparse(node.comparators[0])) for node in found]


@pytest.mark.parametrize("name", [name for name, step in STEPS.items() if step.checker is Checker.SOLVERS])
def test_every_hypothesis_is_needed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without it z3 no longer proves the step: no hypothesis is for show, no range narrower than needed."""
    monkeypatch.setattr(reals, "SOLVERS", (reals.by_z3,))
    assert not superfluous(STEPS[name]), STEPS[name]


@pytest.mark.parametrize("name", CHECKED)
def test_no_step_repeats_what_it_is_given(name: str) -> None:
    step = CHECKED[name]
    if step.checker is Checker.IDENTITY:
        left, right = step.source.split(" = ")
        assert not alike(left, right, commuting=".T" not in step.source), step
        return
    hypotheses, conclusion = formulas(step)
    assert not conjuncts(conclusion) & set().union(*map(conjuncts, hypotheses)), step
    assert all(left != right for left, right in sides(conclusion)), step


def test_planted_tautologies_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reals, "SOLVERS", (reals.by_z3,))
    assert superfluous(asked(["a > 0", "b > 0"], "a**2 >= 0")) == ["a > 0", "b > 0"]
    assert superfluous(asked(["a > 0"], "2*a > 0")) == []
    assert conjuncts("a > 0 and b > a") & conjuncts("b > a")
    for left, right in (("(l/2)*(1/(2*s))", "(l/2)/(2*s)"), ("2*v/(2*f)", "v/f"), ("a*(b + c)", "(c + b)*a")):
        assert alike(left, right, commuting=True), (left, right)
    assert not alike("a*(b + c)", "a*b + a*c", commuting=True)
    assert alike("X.T*w + o", "o + X.T*w", commuting=False)
    assert not alike("w.T*X*u", "u.T*X.T*w", commuting=False)


# --- no gloss says more than its formula --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("gloss", "hypotheses", "conclusion", "meaning", "why"),
    [
        ("|t| <= t^2 for every t", ["t > 1"], "t <= t**2", {"t": "a number"}, "must leave relations"),
        ("true for every t", ["t > 1"], "t <= t**2", {"t": "a number"}, "must leave relations"),
        (
            "a number and its square",
            ["t > 1"],
            "t <= t**2",
            {"t": "any real number >= 0"},
            "must leave relations",
        ),
        ("a number and its square", ["t > 1"], "t <= t**2", {}, "must be in the formula and have a meaning"),
        (
            "a number",
            ["t > 1"],
            "t <= t**2",
            {"t": "t", "s": "s"},
            "must be in the formula and have a meaning",
        ),
    ],
)
def test_a_gloss_that_says_more_than_its_formula_is_refused(
    gloss: str, hypotheses: list[str], conclusion: str, meaning: dict[str, str], why: str
) -> None:
    """Relations, ranges and quantifiers are the formula's, which the report prints with its hypotheses."""
    with pytest.raises(InputError, match=why):
        reals.real("planted", gloss, hypotheses, conclusion, **meaning)


# --- planted faults: a step that is true, mutated -----------------------------------------------------------


def mutated(name: str, old: str, new: str) -> Step:
    """The step again, `old` replaced in what the machine was given."""
    step = STEPS[name]
    assert old in step.source, (old, step.source)
    source = step.source.replace(old, new, 1)
    if step.checker is Checker.SOLVERS:
        return asked(*formulas(replace(step, source=source)))
    if step.checker is Checker.EXACT:
        return exact(name, "mutated", source, "the same")
    left, right = source.split(" = ")
    check, known = (matrix_identity, KNOWN) if re.search(r"\bX\b|\.T", source) else (identity, frozenset())
    return check(name, "mutated", left, right, **dict.fromkeys(set(names(left, right)) - known, "a letter"))


@pytest.mark.parametrize("name", CHECKED)
def test_the_mutation_tool_repeats_a_step(name: str) -> None:
    """Without a mutation it passes, so what fails below fails for its mutation."""
    assert mutated(name, "", "").passed, STEPS[name]


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        # formulation
        ("convex-square", "- t*(1-t)", "+ t*(1-t)"),
        ("lasso-squares", "+ s**2", "+ s"),
        ("reduced-loss", "2*(X*o)", "(X*o)"),
        # zeros and shape
        ("zero-difference", "- 2*w.T", "- w.T"),
        ("strict-zero", "abs(v) < l", "abs(v) <= 2*l"),
        ("gap-identity", "2*l1*u.T", "l1*u.T"),
        ("block-parallel", "c == -l*r", "c == l*r"),
        # derivation
        ("derivative-w", "2*l1*X*u", "l1*X*u"),
        ("derivative-u", "2*l1*X.T*X*u", "l1*X.T*X*u"),
        ("majorise-modality", "2*b*a <=", "3*b*a <="),
        ("majorise-view", "2*abs(v)*abs(t) <=", "3*abs(v)*abs(t) <="),
        ("lemma-right", "b/2", "b"),
        ("substitution-zero", "or S == 0", ""),
        # descent
        ("update-form", "l1*In + A)*w", "l1*In + A/2)*w"),
        ("update-form", "- l1*X.T*w)", "- X.T*w)"),
        ("update-form", "(h - X*k).T*(h - X*k)", "(h + X*k).T*(h + X*k)"),
        ("absolute-fixed", "1/2", "1"),
        ("absolute-rise", "19/25 >", "19/25 <"),
        ("objective-one", "(l1 - 1)", "(l1 + 1)"),
        ("bracket-view", "abs(v) <= l", "abs(v) <= 2*l"),
        ("bracket-modality", "c >= -G*s", "c >= -2*G*s"),
        ("strict-zero-modality", "G < l", "G <= l"),
        ("zero-fall", "2*N*t == D", "N*t == D"),
        ("zero-view", "a/2", "a"),
        ("zero-radius-square", "(n*t - s)", "(n*t + s)"),
        ("zero-radius", "4*N*e", "3*N*e"),
        ("zero-radius-modality", "4*l1", "3*l1"),
        # limit
        ("limit-weights", "A*2*w == l", "A*4*w == l"),
        ("limit-row-w", "2*A*w", "A*w"),
        ("limit-ratio", "l*abs(y) ==", "2*l*abs(y) =="),
        ("limit-midpoint", "/4", "/2"),
        ("limit-separate", "P > 3*r", "P > 2*r"),
        ("limit-difference", "+ (X.T*dw)", "- (X.T*dw)"),
        ("limit-growth", "s > 0", "s < 0"),
        # rate
        ("growth-angle", "+ (r - t)", "- (r - t)"),
        ("growth-sum", "2*K**2", "K**2"),
        ("rate-lag", "2*l1*X*du", "l1*X*du"),
        ("rate-combine", "p**2 + 2*q", "p**2/2 + q"),
        ("rate-linear", "(1 + C)*E1", "(2 + C)*E1"),
        ("example-not-linear", "2*C*(2*N + 3)", "C"),
        ("growth-block-strict", "G < l", "G <= 2*l"),
        ("growth-view-side", "v*w > 0", "v*w < 0"),
        ("example-update-w", "(2*w + 1)", "(2*w + 2)"),
        ("example-update-u", "(2*u + 1)", "(2*u + 2)"),
        ("example-optimum", ">= w**2", ">= 2*w**2"),
        ("example-below", "(2*k + 3)", "(2*k + 2)"),
        ("example-powers", "(m + 1)*m*g**2/2", "(m + 1)*m*g**2"),
        ("example-third", "3/11", "3/12"),
        ("example-potential", "+ 2", "+ 3"),
        ("example-above", "(2*k - 4)*w", "(2*k - 2)*w"),
        # reweighted loops in general
        ("tangent-mean", "m <= a", "m >= a"),
        ("block-expand", "+ h.T*P*h", "- h.T*P*h"),
        ("block-jacobi", "- 2*dw.T*S*du", "+ 2*dw.T*S*du"),
        ("block-jacobi", "S.T*w + R", "S.T*(w + dw) + R"),
        ("block-mean", "t*(1 - t)*(w - y)", "t*(w - y)"),
        ("damped-mean", "(k + 1)*N", "(k + 2)*N"),
        ("form-sign", "a >= 0", "a <= 0"),
        ("fall-chain", "F1 <= Q1 + c", "F1 <= Q1 + 2*c"),
        ("jacobi-three", "(1/2)*(-2)", "(1/2)*(-1)"),
        ("jacobi-cycle", "0 - 1)**2 == 1", "0 - 1)**2 == 0"),
        ("tangent-slopes", "-(a + b)", "-(a - b)"),
        ("tangent-needed", "2*abs(r)", "abs(r)"),
        ("ratio-needed", "t*a < a - b", "t*a < 2*a"),
        ("distance-minimum", "G + m", "G - m"),
        ("gradient-form", "2*L*(P*dw)", "L*(P*dw)"),
        ("gradient-fall", "m <= L*n", "m <= 2*L*n"),
        ("lock-optimal", "g + c == 0", "g - c == 0"),
        ("median-locks", "-15", "-14"),
        ("median-not", "> 1", "< 1"),
        ("vardi-zhang-step", "813/46 < 18", "813/46 < 17"),
        # smooth
        ("smooth-majorise", "t**2 - v**2", "t**2/2 - v**2"),
        ("smooth-between", "abs(t) + e", "abs(t) + e/2"),
        ("smooth-curvature", "- 2*c", "- c"),
        ("smooth-strong", "2*R**2", "R**2"),
        ("smooth-error", "4*m*(-G*D", "5*m*(-G*D"),
        ("smooth-gradient-u", "+ 2*l1*X.T*dw", ""),
        ("smooth-linear", "1 - 4*m*c", "1 - 5*m*c"),
        # systems and labels
        ("positive-w", "l1*h.T*h", "2*l1*h.T*h"),
        ("woodbury-push", "X.T*(In", "2*X.T*(In"),
        ("woodbury-count", "n >= 1", "n >= 0"),
        ("separated-proof", "b < c", "b <= c"),
        # audit
        ("audit-sign", "== 9", "== 4"),
        ("lock-view-optimum", "== 17/20", "== 16/20"),
        ("lock-view", ">= 7/8", "> 7/8"),
        ("lock-modality-optimum", "== 53/40", "== 54/40"),
        ("lock-modality-better", "3/10", "4/10"),
    ],
)
def test_a_planted_fault_is_rejected(name: str, old: str, new: str) -> None:
    step = mutated(name, old, new)
    assert not step.passed, step
