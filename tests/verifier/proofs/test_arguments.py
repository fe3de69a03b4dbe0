"""The checkers of arguments: every step passes, no planted fault does, and the written proof is the code."""

import re
from pathlib import Path

import pytest

from verification.ledger.claims import PARTS
from verification.ledger.evidence import Checker, Step
from verification.proofs.arguments import all_arguments, all_steps, step_name
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import exact, identity
from verification.proofs.checkers.reals import real

DOCUMENT = Path(__file__).parents[3] / "docs" / "theorem.md"
ALL = all_arguments()
ARGUMENTS = {argument.part: argument for argument in ALL}
STEPS = {step_name(step): step for step in all_steps(ALL)}
TAGS = {Checker.IDENTITY: "identity", Checker.Z3: "z3", Checker.EXACT: "exact", Checker.CITED: "cited"}


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
        *("T1c/rate", "C1/woodbury", "N1/positive", "R1/separated", "R1/one_view", "R1/all_zero"),
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
    tags = set(
        re.findall(r"\[(identity|z3|exact|cited)\s+([a-z0-9-]+)\]", DOCUMENT.read_text(encoding="utf-8"))
    )
    steps = {(TAGS[step.checker], name) for name, step in STEPS.items()}
    assert tags == steps, {"only in the text": tags - steps, "only in the code": steps - tags}


# --- planted faults: a step that is true, mutated -----------------------------------------------------------


def mutated(name: str, old: str, new: str) -> Step:
    """The step again, `old` replaced in what the machine was given; a hypothesis left empty is dropped."""
    step = STEPS[name]
    assert old in step.source, (old, step.source)
    source = step.source.replace(old, new, 1)
    if step.checker is Checker.Z3:
        *given, conclusion = source.split(" => ")
        hypotheses = [each for each in (given[0].split(", ") if given else []) if each]
        return real(name, "mutated", hypotheses, conclusion)
    if step.checker is Checker.EXACT:
        return exact(name, "mutated", source)
    left, right = source.split(" = ")
    letters = re.search(r"\bX\b|\.T", source)
    return (matrix_identity if letters else identity)(name, "mutated", left, right)


@pytest.mark.parametrize("name", STEPS)
def test_the_mutation_tool_repeats_a_step(name: str) -> None:
    """Without a mutation it passes, so what fails below fails for its mutation."""
    if STEPS[name].checker is not Checker.CITED:
        assert mutated(name, "", "").passed, STEPS[name]


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        # formulation
        ("convex-square", "- t*(1-t)", "+ t*(1-t)"),
        ("convex-square-sign", "t <= 1", ""),
        ("convex-view", "t >= 0", ""),
        ("convex-modality", "c <= r*s", ""),
        ("cauchy-schwarz", "r > 0", ""),
        ("bounded", "l2 >= 0", ""),
        ("attained-coercive", "f >= a - k", ""),
        ("attained-constant", "l*s == 0", ""),
        ("lasso-squares", "s0**2", "s0"),
        ("reduced-loss", "2*(X*o)", "(X*o)"),
        # zeros and shape
        ("zero-difference", "- 2*w.T", "- w.T"),
        ("zero-below", "2*abs(c)", "abs(c)"),
        ("zero-fall", "(4*N)", "(2*N)"),
        ("strict-zero", "abs(v) < l", "abs(v) <= 2*l"),
        ("gap-identity", "2*l1*u.T", "l1*u.T"),
        ("gap-bracket", "abs(v) <= l", "abs(v) <= 2*l"),
        ("block-slope", "k != 0", ""),
        ("block-bound", "G > l", ""),
        ("block-parallel", "c == -l*r", "c == l*r"),
        ("block-equal", "g == h", ""),
        # derivation
        ("derivative-w", "2*l1*X*u", "l1*X*u"),
        ("derivative-u", "2*l1*X.T*X*u", "l1*X.T*X*u"),
        ("derivative-w-diagonal", "(1/s)", "(1/(2*s))"),
        ("slope-view", "abs(h) < abs(w)", ""),
        ("slope-modality", "c**2 <= r**2*k", ""),
        ("majorise-modality", "2*b*a <=", "3*b*a <="),
        ("majorise-view", "2*abs(v)*abs(t) <=", "3*abs(v)*abs(t) <="),
        ("lemma-right", "b/2", "b"),
        ("objective-only-one", "q > 0", ""),
        ("substitution-zero", "or S == 0", ""),
        # descent
        ("update-w", "l1*In + A)*w", "l1*In + A/2)*w"),
        ("update-u", "- l1*X.T*w)", "- X.T*w)"),
        ("fall-gauss-seidel", "l1*dw.T*dw", "2*l1*dw.T*dw"),
        ("fall-gauss-seidel", "l1*X.T*(w + dw)", "l1*X.T*w"),
        ("fall-jacobi", "(dw + X*du).T*(dw + X*du)", "(dw - X*du).T*(dw - X*du)"),
        ("fall-jacobi", "l1*X.T*w)", "l1*X.T*(w + dw))"),
        ("fall-chain", "F1 <= Q1 + c", ""),
        ("fall-sign", "A >= 0", ""),
        ("absolute-half", "(l/2)/(2*s)", "l/(2*s)"),
        ("absolute-fixed", "1/2", "1"),
        ("absolute-rise", "19/25 >", "19/25 <"),
        # limit
        ("limit-weights", "A*2*w == l", "A*4*w == l"),
        ("limit-row-w", "2*A*w", "A*w"),
        ("limit-ratio", "l*abs(y) ==", "2*l*abs(y) =="),
        ("limit-sign", "abs(w) >= m", ""),
        ("limit-subspace", "P >= x*h", ""),
        ("limit-midpoint", "/4", "/2"),
        ("limit-unique", "M >= m", ""),
        ("limit-separate", "P > 3*r", "P > 2*r"),
        ("limit-difference", "+ (X.T*dw)", "- (X.T*dw)"),
        ("limit-growth", "s > 0", "s >= 0 - 1"),
        ("limit-kkt-zero", "abs(v) <= l", ""),
        ("limit-optimal", "Fk <= FN", ""),
        # rate
        ("growth-view", "v != l or", ""),
        ("growth-angle", "+ (r - t)", "- (r - t)"),
        ("growth-block", "r <= R", ""),
        ("growth-sum", "2*K**2", "K**2"),
        ("rate-lag", "2*l1*X*du", "l1*X*du"),
        ("rate-strict", "b <= t*a", ""),
        ("rate-combine", "p**2 + 2*q", "p**2/2 + q"),
        ("rate-linear", "(1 + C)*E1", "(2 + C)*E1"),
        ("example-update", "w/(w + 1)", "w/(w + 2)"),
        ("example-error", "(k + 1)**2", "(k + 2)**2"),
        ("example-not-linear", "k*(1 - q) >= 4", "k*(1 - q) >= 1"),
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
        ("positive-sign", "s > 0", ""),
        ("woodbury-push", "X.T*(In", "2*X.T*(In"),
        ("woodbury-count", "n >= 1", "n >= 0"),
        ("separated-proof", "b < c", "b <= c"),
        # audit
        ("audit-sign", "== 9", "== 4"),
        ("lock-view", "x == 0", ""),
        ("lock-view-optimum", "3/8", "2/5"),
        ("lock-modality-optimum", "135/476", "136/476"),
        ("lock-modality-better", "59/238", "60/238"),
    ],
)
def test_a_planted_fault_is_rejected(name: str, old: str, new: str) -> None:
    step = mutated(name, old, new)
    assert not step.passed, step
