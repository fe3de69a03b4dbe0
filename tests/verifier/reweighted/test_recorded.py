"""Answers recorded elsewhere are judged as the program itself is, and what the folder lacks is told."""

import json
import subprocess
import sys

import numpy as np
import programs_to_judge as programs
import pytest

from convexperc.errors import InputError
from verification.reweighted import Rule, Word, all_questions, export_inputs, judge_program, judge_recorded
from verification.reweighted.programs.questions import as_given

INPUTS = [{"y": [0.0, 0.0, 1.0]}, {"y": [0.1, 1.0 / 3.0, -2.5, 7.0]}]
QUESTIONS = all_questions(rows=("y",), powers={"y": 1})
ONCE = [question for question in QUESTIONS if not question.twice]
OBJECTIVE = programs.median_objective


def exported(folder, inputs=INPUTS, questions=QUESTIONS):
    """The inputs, as a program elsewhere reads them."""
    file = folder / "inputs.jsonl"
    count = export_inputs(file, inputs, questions)
    found = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    assert len(found) == count
    return found


def answer_of(program, asked):
    found = program(**{name: np.array(value) for name, value in asked["input"].items()})
    return {"id": asked["id"], "answer": np.asarray(found).tolist()}


def recorded(folder, program=programs.right_median, inputs=INPUTS, questions=QUESTIONS):
    return [answer_of(program, each) for each in exported(folder, inputs, questions)]


def judged(folder, answers=(), inputs=INPUTS, questions=QUESTIONS, rule=None, text=""):
    lines = "".join(f"{json.dumps(each)}\n" for each in answers) + text
    (folder / "answers.jsonl").write_text(lines, encoding="utf-8")
    return judge_recorded(folder, OBJECTIVE, inputs, questions=questions, rule=rule, name="made up")


def no_acquittal(found):
    return all(each.word is not Word.YES for each in found if each.question not in {"warnings", "record"})


@pytest.mark.parametrize(
    "program",
    [
        programs.right_median,
        programs.mean_for_median,
        programs.absolute_floor,
        programs.only_the_first_is_doubled,
        programs.depends_on_order,
        programs.skips_zeros,
    ],
)
def test_a_folder_is_judged_as_the_program_itself(program, tmp_path):
    found = judged(tmp_path, recorded(tmp_path, program))
    asked = judge_program(program, OBJECTIVE, inputs=INPUTS, questions=ONCE, name="made up")
    told = {each.question: each for each in asked}
    assert {each.question: each for each in found if each.question in told} == told
    assert [each.as_json() for each in found.findings] == [each.as_json() for each in asked.findings]
    assert found["record"].word is Word.YES, str(found)


def test_the_inputs_are_those_that_the_program_is_asked_bit_by_bit(tmp_path):
    inputs = [{"y": [0.1, -0.0, 5e-324, 1.7e100], "start": np.float32(0.1), "text": "as it is"}]
    met = []

    def spy(**data):
        met.append((data["y"].astype(float).tobytes(), float(data["start"]), data["text"]))
        return np.median(data["y"])

    judge_program(spy, OBJECTIVE, inputs=inputs, questions=[as_given(), *ONCE[2:]])
    told = exported(tmp_path, inputs, [as_given(), *ONCE[2:]])
    sent = [
        (np.array(each["input"]["y"]).tobytes(), each["input"]["start"], each["input"]["text"])
        for each in told
    ]
    assert set(sent) == set(met)
    assert len(sent) == len(set(sent)), "equal inputs are written once"


def test_a_program_of_its_own_answers_the_lines(tmp_path):
    """It repeats the input, which costs nothing in most languages, and has no NumPy."""
    count = export_inputs(tmp_path / "inputs.jsonl", INPUTS, QUESTIONS)
    script = (
        "import json, sys\n"
        "for line in sys.stdin:\n"
        "    asked = json.loads(line)\n"
        "    y = sorted(asked['input']['y'])\n"
        "    print(json.dumps({**asked, 'answer': y[len(y) // 2], 'warned': []}))\n"
    )
    with (tmp_path / "inputs.jsonl").open() as given, (tmp_path / "answers.jsonl").open("w") as taken:
        subprocess.run([sys.executable, "-S", "-c", script], stdin=given, stdout=taken, check=True)
    found = judge_recorded(tmp_path, OBJECTIVE, INPUTS, questions=QUESTIONS, rule=Rule(1e-12))
    assert not found.faults, str(found)
    assert found.subject.startswith(tmp_path.name)
    assert all(found[question.name].word is Word.YES for question in ONCE), str(found)
    assert f"Each of the {count} inputs" in found["record"].statement


def test_what_needs_the_program_is_told_as_not_asked(tmp_path):
    found = judged(tmp_path, recorded(tmp_path))
    for question in ("ask twice", "draws"):
        assert found[question].word is Word.UNDECIDED
        assert found[question].statement.startswith("Not asked")


def test_mixed_up_answers_are_wrong_and_told_where_they_repeat_their_input(tmp_path):
    asked = exported(tmp_path, questions=(as_given(),))
    answers = [answer_of(programs.right_median, each) for each in asked]
    first, second = ({**one, "id": other["id"]} for one, other in zip(answers, answers[::-1], strict=True))
    found = judged(tmp_path, [first, second], questions=(as_given(),))
    assert found["as given"].accuses
    assert "F(answer)" in found["as given"].statement
    first |= {"input": asked[0]["input"]}
    found = judged(tmp_path, [first, answers[0]], questions=(as_given(),))
    assert found["as given"].accuses
    assert f"the input {asked[1]['id']} must be to that input" in found["as given"].statement


def test_a_missing_answer_is_neither_a_refusal_nor_an_acquittal_nor_a_fault(tmp_path):
    answers = recorded(tmp_path)
    lost = answers.pop(0)["id"]
    found = judged(tmp_path, answers)
    assert not found.faults, str(found)
    assert found["as given"].word is Word.UNDECIDED
    assert (
        found["as given"].statement
        == "Within the tolerance on 1 of 1 inputs. Inputs without an answer on record: 1."
    )
    assert found["add a zero row"].word is Word.YES, "it is told of the others all the same"
    assert f"1 of {len(answers) + 1} inputs have no answer: {lost}." in found["record"].statement
    wrong = judged(tmp_path, recorded(tmp_path, programs.mean_for_median)[1:])
    assert wrong["as given"].accuses, "what is there is judged"


def test_without_any_answer_nothing_is_said_for_or_against_the_program(tmp_path):
    count = len(exported(tmp_path))
    for found in (judge_recorded(tmp_path, OBJECTIVE, INPUTS, questions=QUESTIONS), judged(tmp_path)):
        assert not found.faults
        assert {each.word for each in found if each.question != "record"} == {Word.UNDECIDED}, str(found)
        assert f"{count} of {count} inputs have no answer" in found["record"].statement


def test_the_folder_of_other_inputs_belongs_to_no_input(tmp_path):
    answers = recorded(tmp_path, inputs=[{"y": [3.0, 4.0, 8.0]}])
    found = judged(tmp_path, answers)
    assert not found.faults
    assert no_acquittal(found), str(found)
    assert f"{len(answers)} answers are to no input that is asked" in found["record"].statement


@pytest.mark.parametrize(
    "text",
    [
        "PK\x03\x04 garbage\n",
        '{"id": "0", "answer": 1, "answer": 2}\n',
        '{"answer": 3}\n',
        '{"error": "no"}\n',
        "[1]\n",
    ],
)
def test_garbage_is_told_with_its_place(text, tmp_path):
    found = judged(tmp_path, recorded(tmp_path), text=text)
    assert found["record"].word is Word.NO
    assert "1 lines are no answer" in found["record"].statement
    assert not found.faults, "it answers nothing, so that nothing is known of it"
    alone = judged(tmp_path, text=text + text)
    assert no_acquittal(alone), str(alone)
    assert not alone.faults


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"answer": float("nan")}, "not finite"),
        ({"answer": [float("-inf")]}, "not finite"),
        ({"answer": None}, "no point"),
        ({"answer": [1.0, 2.0]}, "no point"),
        ({"answer": "0.0"}, "no point"),
        ({"refused": "not today"}, '"answer" or "refused"'),
        ({"warned": "all is well"}, "as a list"),
    ],
)
def test_an_answer_that_cannot_be_read_is_a_fault(changed, said, tmp_path):
    answers = recorded(tmp_path)
    answers[0] |= changed
    found = judged(tmp_path, answers)
    assert [each.question for each in found.faults] == ["as given"], str(found)
    assert said in found["as given"].statement


def test_two_answers_to_one_input_are_a_fault_and_a_number_beyond_float64_is_not_finite(tmp_path):
    answers = recorded(tmp_path, questions=(as_given(),))
    found = judged(tmp_path, [*answers, answers[0]], questions=(as_given(),))
    assert "must be the only one; got '2 answers'" in found["as given"].statement
    beyond = f'{{"id": "{answers[0]["id"]}", "answer": 1e999}}\n'
    found = judged(tmp_path, answers[1:], questions=(as_given(),), text=beyond)
    assert "not finite" in found["as given"].statement
    assert found["as given"].accuses


def test_refusals_and_warnings_are_those_of_the_program(tmp_path):
    answers = recorded(tmp_path, programs.mean_for_median, questions=(as_given(),))
    told = [each | {"warned": ["did not converge"]} for each in answers]
    found = judged(tmp_path, told, questions=(as_given(),))
    assert found["as given"].word is Word.NO
    assert not found.faults
    assert "did not converge" in found["warnings"].statement
    refused = [{"id": each["id"], "refused": "no licence"} for each in answers]
    found = judged(tmp_path, refused, questions=(as_given(),))
    assert "no licence" in found["as given"].statement
    assert found["as given"].word is Word.UNDECIDED


def test_one_answer_a_file_does_as_well(tmp_path):
    for number, each in enumerate(recorded(tmp_path)):
        (tmp_path / f"{number}.json").write_text(json.dumps(each, indent=2), encoding="utf-8")
    found = judge_recorded(tmp_path, OBJECTIVE, INPUTS, questions=QUESTIONS)
    assert found["record"].word is Word.YES, str(found)
    assert all(found[question.name].word is Word.YES for question in ONCE), str(found)


def test_misuse_is_told(tmp_path):
    file = tmp_path / "inputs.jsonl"
    for inputs, questions, what in (
        ([], None, "inputs"),
        ([{"y": len}], None, "JSON"),
        ([3], None, "an input"),
        (INPUTS, ["as given"], "question"),
        (INPUTS, all_questions(rows=("z",)), "among the data"),
    ):
        with pytest.raises(InputError, match=what):
            export_inputs(file, inputs, questions)
    assert not file.exists()
    with pytest.raises(InputError, match="folder"):
        judge_recorded(tmp_path, OBJECTIVE, INPUTS)
    with pytest.raises(InputError, match="Rule"):
        judged(tmp_path, rule=1e-3)


def test_a_line_that_is_nested_too_deeply_is_told(tmp_path):
    answers = recorded(tmp_path)
    deep = '{"id": "other", "answer": ' + "[" * 900 + "]" * 900 + "}\n"
    found = judged(tmp_path, answers, text=deep)
    assert found["as given"].word is Word.YES, str(found)
    assert "other is nested too deeply" in found["record"].statement


@pytest.mark.parametrize("refused", [False, True])
def test_without_an_answer_as_given_no_question_is_blamed(refused, tmp_path):
    """The mean is wrong whatever the unit or the order of the data."""
    answers = recorded(tmp_path, programs.mean_for_median)
    given = {each["id"] for each in exported(tmp_path, questions=[as_given()])}
    rest = [each for each in answers if each["id"] not in given]
    rest += [{"id": each, "refused": "not today"} for each in sorted(given) if refused]
    found = judged(tmp_path, rest)
    assert not found.faults, str(found)
    assert "as they are given it has no answer" in found["other units"].statement
    assert found["other units"].word is Word.UNDECIDED
    assert judged(tmp_path, answers).faults


def test_null_stands_for_nothing(tmp_path):
    nothing = {"refused": None, "warned": None, "input": None}
    found = judged(tmp_path, [each | nothing for each in recorded(tmp_path)])
    assert found["as given"].word is Word.YES, str(found)


def test_a_whole_number_beyond_float64_is_no_point(tmp_path):
    found = judged(tmp_path, [each | {"answer": 10**400} for each in recorded(tmp_path)])
    assert found["as given"].fault, str(found)
    assert "no point" in found["as given"].statement


@pytest.mark.parametrize("wrong", [[[1.0], [1.0, 2.0]], np.ma.array([1.0, 2.0], mask=[True, False])])
def test_rows_of_several_lengths_and_masked_entries_are_no_input(wrong, tmp_path):
    with pytest.raises(InputError, match="input y"):
        export_inputs(tmp_path / "inputs.jsonl", [{"y": wrong}], QUESTIONS)


def test_inputs_may_come_one_after_the_other(tmp_path):
    assert export_inputs(tmp_path / "inputs.jsonl", iter(INPUTS), QUESTIONS) == len(exported(tmp_path))
    answers = recorded(tmp_path)
    assert judged(tmp_path, answers, inputs=iter(INPUTS))["record"].word is Word.YES


def test_long_lines_are_told_in_short(tmp_path):
    found = judged(tmp_path, [{"id": "a" * 10**6, "answer": 0.0}, {"answer": "b" * 10**6}])
    assert len(found["record"].statement) < 2000
