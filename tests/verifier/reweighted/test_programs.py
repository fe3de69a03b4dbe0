"""Programs judged by the optimum of each input: right ones acquitted, faulty ones accused."""

import json
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import cvxpy as cp
import numpy as np
import programs_to_judge as programs
import pytest
from hypothesis import strategies as st
from scipy.optimize import linprog
from sklearn.linear_model import Lasso

from convexperc.errors import FileFormatError, InputError, SolverError, ToleranceError
from convexperc.lasso import certify_lasso
from verification.reweighted import Rule, Word, all_questions, judge_program, loss, replay, variable
from verification.reweighted.programs import doors
from verification.reweighted.programs.doors import Command, module, serve
from verification.reweighted.programs.packages import cases, judge_packages
from verification.reweighted.programs.questions import as_given, other_units
from verification.reweighted.programs.verdicts import verdict

WHOLE = st.integers(-9, 9).map(float)
NUMBERS = {"y": st.lists(WHOLE, min_size=1, max_size=6)}
ABOUT_NUMBERS = all_questions(rows=("y",), powers={"y": 1})
PLANE = {"points": st.lists(st.tuples(WHOLE, WHOLE), min_size=1, max_size=5)}
ABOUT_POINTS = all_questions(rows=("points",), powers={"points": 1}, start=("start", "points"))
DRAWS = 12


def judged(program, only=None, draws=DRAWS, **options):
    """Ask all questions, or the first and one more."""
    asked = [each for each in ABOUT_NUMBERS if only is None or each.name in {"as given", only}]
    return judge_program(program, programs.median_objective, NUMBERS, questions=asked, draws=draws, **options)


def accused(answers):
    return {answer.question for answer in answers.faults}


def regression(seed=5, n=9, p=3):
    rng = np.random.default_rng(seed)
    return {"X": rng.integers(-5, 6, (n, p)).astype(float), "y": rng.integers(-9, 10, n).astype(float)}


def ask_all(program, build, data, **options):
    powers = {"y": 1} | ({"penalty": 1} if "penalty" in data else {})
    asked = all_questions(rows=("X", "y"), columns=("X",), powers=powers)
    return judge_program(program, build, inputs=[data], questions=asked, **options)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("unit", [5e-324, 1e-200, 1e160, 1e308])
def test_data_near_the_ends_of_float64_are_judged_as_others(unit):
    data = [{"y": [unit, 0.0, -unit, 0.0, unit]}]
    for program, word in ((programs.right_median, Word.YES), (lambda y: float(y[0]), Word.NO)):
        found = judge_program(program, programs.median_objective, inputs=data, questions=[as_given()])
        assert found["as given"].word is word, str(found)


@pytest.mark.parametrize("program", [programs.right_median, programs.reweighted_median])
def test_right_medians_are_acquitted(program):
    found = judged(program)
    assert not found.findings, str(found)
    assert {answer.word for answer in found} == {Word.YES}, str(found)


def test_vardi_and_zhang_s_repair_is_acquitted_and_weiszfeld_s_step_is_not():
    options = {"questions": ABOUT_POINTS, "draws": 6}
    found = judge_program(programs.vardi_zhang, programs.geometric_objective, PLANE, **options)
    assert not found.findings, str(found)
    found = judge_program(programs.plain_weiszfeld, programs.geometric_objective, PLANE, **options)
    assert "start at a data point" in accused(found), str(found)
    assert "as given" not in accused(found), str(found)


def by_linprog(X, y):
    n, p = X.shape
    unit = np.max(np.abs(y))
    bounds = [(None, None)] * p + [(0, None)] * (2 * n)
    costs = np.concatenate([np.zeros(p), np.ones(2 * n)])
    return (
        linprog(costs, A_eq=np.hstack([X, np.eye(n), -np.eye(n)]), b_eq=y / unit, bounds=bounds).x[:p] * unit
    )


def by_cvxpy(X, y):
    unit, b = np.max(np.abs(y)), cp.Variable(X.shape[1])
    whole = cp.Problem(cp.Minimize(cp.norm1(X @ b - y / unit)))
    whole.solve(solver=cp.CLARABEL, tol_gap_abs=1e-12, tol_gap_rel=1e-12, tol_feas=1e-12)
    return b.value * unit


@pytest.mark.parametrize("program", [by_linprog, by_cvxpy])
def test_other_people_s_solvers_of_least_absolute_deviations_are_acquitted(program):
    found = ask_all(program, programs.absolute_objective, regression())
    assert {answer.word for answer in found} == {Word.YES}, str(found)


def by_sklearn(X, y, penalty):
    model = Lasso(alpha=penalty / len(y), fit_intercept=False, tol=1e-12, max_iter=100_000)
    return model.fit(X, y).coef_


def test_scikit_learn_s_lasso_is_acquitted_as_its_certificate_says():
    data = regression() | {"penalty": 7.0}
    found = ask_all(by_sklearn, programs.lasso_objective, data)
    assert {answer.word for answer in found} == {Word.YES}, str(found)
    proof = certify_lasso(data["X"], data["y"], by_sklearn(**data), 7.0 / 9)
    assert proof.upper - proof.lower <= 1e-6 * proof.upper


def test_half_the_penalty_is_accused_and_the_point_shown_is_better():
    data = regression() | {"penalty": 7.0}
    assert not ask_all(programs.lasso, programs.lasso_objective, data).findings
    found = ask_all(programs.descends_half_the_penalty, programs.lasso_objective, data)
    assert accused(found) == {"as given"}, str(found)
    (finding,) = found.findings

    def value(b):
        return 0.5 * np.sum((data["X"] @ b - data["y"]) ** 2) + 7 * np.sum(np.abs(b))

    (answer,), (other,) = finding.answer.values(), finding.other.values()
    assert value(np.array(answer)) == pytest.approx(finding.values[0], rel=1e-12)
    assert value(np.array(other)) == pytest.approx(finding.values[1], rel=1e-12)
    assert finding.values[0] > 1.0001 * finding.values[1]


@pytest.mark.parametrize(
    ("program", "question"),
    [
        (programs.mean_for_median, "as given"),
        (programs.wrong_power, "as given"),
        (programs.one_iteration, "as given"),
        (programs.absolute_floor, "other units"),
        (programs.absolute_stop, "other units"),
        (programs.only_the_first_is_doubled, "duplicate a row"),
        (programs.depends_on_order, "permute rows"),
        (programs.skips_zeros, "add a zero row"),
        (programs.sorts_its_argument, "ask twice"),
        (programs.divides_by_zero, "duplicate a row"),
        (programs.raises_at_zero, "add a zero row"),
    ],
)
def test_faulty_programs_are_accused_by_the_right_question(program, question):
    found = judged(program, question, draws=40)
    assert question in accused(found), str(found)


def test_the_smallest_input_is_found():
    found = judged(programs.mean_for_median, "as given")
    (finding,) = (each for each in found.findings if each.question == "as given")
    assert finding.data["y"].tolist() == [0, 0, 1]
    assert finding.answer == {"m": [1 / 3]}
    assert finding.values == (pytest.approx(4 / 3), 1.0)
    assert "33.3 %" in finding.statement
    again = judged(programs.mean_for_median, "as given")
    assert [each.id for each in again.findings] == [each.id for each in found.findings]


def test_units_are_told_with_the_worst_of_them():
    found = judged(programs.absolute_floor, "other units", draws=40)
    assert accused(found) == {"other units"}, str(found)
    (finding,) = found.findings
    assert max(abs(finding.data["y"])) <= 1e-5
    assert finding.values[0] > 1.1 * finding.values[1]


def test_an_absolute_promise_is_another_promise():
    data = {"inputs": [{"y": [0.0, 0.0, 1.0]}], "questions": (as_given(), other_units({"y": 1}))}
    relative = judge_program(programs.absolute_floor, programs.median_objective, **data)
    absolute = judge_program(programs.absolute_floor, programs.median_objective, rule=Rule(0.0, 3e-6), **data)
    strict = judge_program(programs.absolute_floor, programs.median_objective, rule=Rule(0.0, 1e-9), **data)
    assert accused(relative) == {"other units"}
    assert not absolute.findings, str(absolute)
    assert accused(strict) == {"as given"}
    assert "3e-06 absolute" in absolute.subject
    with pytest.raises(ToleranceError):
        Rule(-1.0)


def test_what_a_program_says_itself_is_no_fault():
    told = judged(programs.warns_that_it_did_not_converge, "as given")
    assert told["as given"].word is Word.NO
    assert not told.faults
    assert "It warned: UserWarning: did not converge" in told["as given"].statement
    assert "did not converge" in told["warnings"].statement
    refused = judged(programs.refuses_zeros, "add a zero row")
    assert not refused.findings
    assert refused["add a zero row"].word is Word.UNDECIDED
    assert "zeros are not supported" in refused["add a zero row"].statement
    strict = judged(programs.refuses_zeros, "as given", refusals=())
    assert "as given" in accused(strict)


@pytest.mark.parametrize("answer", [float("nan"), [1.0, 2.0], None, {"other": 1.0}, "text"])
def test_what_is_no_point_is_accused(answer):
    found = judge_program(
        lambda y: answer, programs.median_objective, inputs=[{"y": [1.0, 2.0]}], name="made up"
    )
    assert accused(found) == {"as given"}, str(found)
    assert json.loads(json.dumps(found.as_json()))["subject"].startswith("made up")


def test_an_answer_near_the_tolerance_is_neither_accused_nor_acquitted_wrongly():
    """1e-6 of F* is within the tolerance; another 1e-6 of the data's size, here 1, leaves it open."""
    data = {"y": np.array([0.0, 0.0, 1.0])}
    objective = programs.median_objective(**data)
    words = [verdict(objective, {"m": [m]}, Rule(1e-6)).word for m in (0.9e-6, 0.999e-6, 1.9e-6, 2.1e-6)]
    assert words == [Word.YES, Word.YES, Word.UNDECIDED, Word.NO]


def test_an_objective_without_a_known_conjugate_is_undecided():
    def build(y):
        return sum(loss(variable("m") - v, "log(1 + r**2)", "1/(1 + r**2)") for v in y)

    found = judge_program(programs.right_median, build, inputs=[{"y": [0.0, 3.0]}])
    assert found["as given"].word is Word.UNDECIDED
    assert not found.findings


def test_findings_are_kept_and_judged_again(tmp_path):
    found = judged(programs.mean_for_median, "as given")
    finding = found.findings[0]
    place = finding.store(tmp_path)
    assert place.name == f"{finding.id}.json"
    build = programs.median_objective
    for given in (finding, finding.as_json(), place):
        assert replay(given, build).word is Word.NO
    assert replay(place, build).accuses
    assert replay(place, build, programs.mean_for_median).accuses
    assert replay(place, build, programs.right_median).word is Word.YES
    record = json.loads(place.read_text())
    record["answer"] = {"m": [0.0]}
    assert replay(record, build).word is Word.YES
    record["input"]["y"] = [0.0, 0.0, 2.0]
    with pytest.raises(FileFormatError, match="digest"):
        replay(record, build)
    with pytest.raises(FileFormatError, match="must have"):
        replay({"id": "0"}, build)


def test_findings_without_an_answer_are_judged_again():
    found = judged(programs.raises_at_zero, "as given")
    finding = next(each for each in found.findings if each.question == "as given")
    assert replay(finding, programs.median_objective).word is Word.UNDECIDED
    assert replay(finding, programs.median_objective, programs.raises_at_zero).accuses
    assert replay(finding, programs.median_objective, programs.right_median).word is Word.YES


def test_there_must_be_inputs_and_an_objective():
    with pytest.raises(InputError, match="inputs"):
        judge_program(programs.right_median, programs.median_objective)
    with pytest.raises(InputError, match="build"):
        judge_program(programs.right_median, lambda y: 3, inputs=[{"y": [1.0]}])


PROGRAM = """
import json, sys
y = json.loads(sys.stdin.readline())["y"]
print("a line of its own")
print(json.dumps({answer}))
"""


@pytest.mark.parametrize(
    ("answer", "word", "said"),
    [
        ('{"answer": sorted(y)[len(y) // 2]}', Word.YES, "Within"),
        ('{"answer": sum(y) / len(y)}', Word.NO, "33.3 %"),
        ('{"refused": "not today"}', Word.UNDECIDED, "not today"),
        ('{"result": 3}', Word.NO, "must write"),
        ("1/0", Word.NO, "ZeroDivisionError"),
    ],
)
def test_commands_are_asked_line_by_line(answer, word, said):
    door = Command([sys.executable, "-c", PROGRAM.replace("{answer}", answer)])
    found = judge_program(
        door, programs.median_objective, inputs=[{"y": [0.0, 0.0, 1.0]}], questions=(as_given(),)
    )
    assert found["as given"].word is word
    assert said in found["as given"].statement


def of_its_argument(a):
    return programs.median_objective(a)


def test_functions_are_imported_in_a_process_of_their_own():
    door, data = module("numpy:median"), {"a": [0.0, 4.0, 1.0]}
    found = judge_program(door, of_its_argument, inputs=[data], questions=(as_given(),))
    assert found["as given"].word is Word.YES
    slow = Command([sys.executable, "-c", "import time; time.sleep(60)"], seconds=0.5)
    found = judge_program(slow, programs.median_objective, inputs=[{"y": [1.0]}], questions=(as_given(),))
    assert "must answer and end within 0.5 s" in found["as given"].statement


STARTING = """
import subprocess, sys, time
p = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(99)'])
open(sys.argv[1], 'w').write(str(p.pid))
"""


@pytest.mark.parametrize("then", ["time.sleep(99)", "print('{\"answer\": 1.0}')"])
def test_what_a_program_has_started_ends_with_it(then, tmp_path):
    """With its output still open, whether the program answers or hangs."""
    place, begun = tmp_path / "pid", time.monotonic()
    door = Command([sys.executable, "-c", STARTING + then, str(place)], seconds=5.0)
    answered = "print" in then
    with nullcontext() if answered else pytest.raises(SolverError, match="within 5 s"):
        assert door(y=[1.0]) == 1.0
    while is_running(int(place.read_text())):
        assert time.monotonic() - begun < 30.0
        time.sleep(0.05)


def is_running(pid):
    """Not so once it is a zombie, which nobody may have waited for."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_a_flood_is_ended_and_a_program_may_read_to_the_end_or_nothing(monkeypatch):
    monkeypatch.setattr(doors, "LONGEST", 1 << 20)
    flood = Command([sys.executable, "-c", "while True: print('x' * 9999)"], seconds=60.0)
    with pytest.raises(SolverError, match="more than 1048576 bytes"):
        flood(y=[1.0])
    whole = Command(
        [sys.executable, "-c", "import json, sys; print(json.dumps({'answer': json.load(sys.stdin)['y']}))"]
    )
    large = np.arange(1e5) / 3
    assert np.array_equal(whole(y=large[:5000]), large[:5000])
    deaf = Command([sys.executable, "-c", "print('{\"answer\": 2}')"])
    assert deaf(y=large) == 2


def test_data_that_are_no_json_are_no_fault_of_the_program():
    with pytest.raises(InputError, match="JSON"):
        Command([sys.executable, "-c", ""])(y=len)


@pytest.mark.parametrize(
    "answer",
    [
        np.ma.masked_array([3.0], [True]),
        [np.ma.masked],
        np.ma.masked,
        {"m": np.ma.masked_array(3.0, True)},
        [None],
    ],
)
def test_a_masked_entry_is_no_point_whatever_number_it_hides(answer):
    found = judge_program(lambda y: answer, programs.median_objective, inputs=[{"y": [3.0, 3.0]}])
    assert accused(found) == {"as given"}, str(found)
    assert "no point" in found["as given"].statement
    bare = np.ma.masked_array([3.0], [False])
    found = judge_program(lambda y: bare, programs.median_objective, inputs=[{"y": [3.0, 3.0]}])
    assert not found.findings, str(found)


def test_a_module_keeps_the_mask():
    given = json.dumps({"data": [1.0, 2.0], "mask": [True, False]})
    assert json.loads(serve("numpy.ma:masked_array", given)) == {"answer": [None, 2.0]}


def test_programs_of_packages_that_are_installed_with_the_tests():
    chosen = [case for case in cases() if case.distribution in {"numpy", "scipy", "scikit-learn"}]
    found = list(judge_packages(chosen))
    assert len(found) == 3
    for each in found:
        assert not each.answers.findings, str(each.answers)
        assert each.version in each.answers.subject


@pytest.mark.parametrize(
    ("module_name", "program", "question"),
    [
        ("statsmodels", "QuantReg(y, ones).fit(q=0.5)", "other units"),
        ("geom_median", "compute_geometric_median(points)", "other units"),
    ],
)
def test_packages_that_are_not_installed_with_the_tests(module_name, program, question):
    pytest.importorskip(module_name)
    case = next(case for case in cases() if case.program == program)
    (found,) = judge_packages([case])
    assert accused(found.answers) == {question}


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ({"rule": 1e-3}, "rule"),
        ({"questions": all_questions(rows=("z",))}, "among the data"),
        ({"questions": all_questions(powers={"z": 1})}, "among the data"),
        ({"questions": all_questions(powers={"unit": 1})}, "must be numbers"),
        ({"questions": all_questions(rows=("unit",))}, "must have 1 dimensions"),
        ({"questions": all_questions(columns=("y",))}, "must have 2 dimensions"),
        ({"questions": as_given()}, "questions must be of the type Sequence"),
        ({"questions": ("as given",)}, "a question must be"),
        ({"inputs": [3]}, "an input must be"),
        ({"program": 3}, "function"),
        ({"build": None}, "function"),
    ],
)
def test_misuse_of_judge_program_is_told(arguments, what):
    inputs = [{"y": [1.0, 2.0], "unit": "m"}]
    given = {"program": of_numbers, "build": programs.median_objective, "inputs": inputs} | arguments
    with pytest.raises(InputError, match=what):
        judge_program(given.pop("program"), given.pop("build"), **given)


def of_numbers(y, unit):
    return np.median(y)
