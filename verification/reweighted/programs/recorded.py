"""Recorded answers: the inputs for a program that runs elsewhere, and the judgement of what it answered.

Each line of the inputs is ``{"id": ..., "input": ...}``; the id is a digest of the input. Beside its id an
answer has what `doors` reads: ``answer``, or ``refused``, and ``warned``. It may repeat the ``input``.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

from convexperc.errors import InputError, SolverError, escaped
from convexperc.files import NoFloat, given_path, write_atomic
from verification.conformance.answers import shown, told
from verification.conformance.doors import Results
from verification.reweighted.answers import Answer, Word
from verification.reweighted.programs.doors import answered
from verification.reweighted.programs.inputs import arrays, digest, line, listed
from verification.reweighted.programs.judging import Build, ProgramAnswers, judge_program
from verification.reweighted.programs.questions import Data, Question, checked
from verification.reweighted.programs.replies import NotAskedError
from verification.reweighted.programs.verdicts import Rule

ASKED = {"id", "input"}
"""Keys of a line that nobody has answered yet."""

NEEDS_THE_PROGRAM = "Not asked, since its answers are recorded:"
BASIS = "the files of the folder; an id is the digest of its input"


def export_inputs(
    file: str | PathLike[str], inputs: Sequence[Data], questions: Sequence[Question] | None = None
) -> int:
    """Write every input that is asked of a program elsewhere, one a line, for `judge_recorded`.

    Parameters
    ----------
    file : path
        Such as ``folder/inputs.jsonl``; it may lie in the folder of the answers.
    inputs : sequence of mappings of str to Any
    questions : sequence of Question
        As for `judge_program`; nothing is asked twice.

    Returns
    -------
    int
        How many there are: equal ones are asked once.

    Raises
    ------
    InputError
        There is no input, one cannot be written as JSON, a question names data that there are not, or the
        file cannot be written.
    """
    inputs = list(inputs)
    lines = [line({"id": key, "input": listed(data)}) for key, data in _asked(inputs, checked(questions))]
    write_atomic(file, "".join(f"{each}\n" for each in lines).encode())
    return len(lines)


def judge_recorded(
    folder: str | PathLike[str],
    build: Build,
    inputs: Sequence[Data],
    *,
    questions: Sequence[Question] | None = None,
    rule: Rule | None = None,
    name: str = "",
) -> ProgramAnswers:
    """Judge the answers that a program gave elsewhere, as `judge_program` does.

    Parameters
    ----------
    folder : path
        With the answers as ``*.json``, one a file, or ``*.jsonl``, one a line.
    build, rule
        As for `judge_program`.
    inputs, questions
        Those of `export_inputs`.
    name : str
        Of the program; default: the folder's.

    Returns
    -------
    ProgramAnswers
        An input without an answer keeps its questions undecided, and is neither refused nor a fault. An
        answer that cannot be read, or repeats another input, is a fault, as are several to one input.
        ``record`` tells what is missing in the folder or belongs to no input, ``draws`` and the questions
        that call a program twice what was not asked.

    Raises
    ------
    InputError
        As for `judge_program`; or the folder has no such file.
    """
    chosen, inputs = checked(questions), list(inputs)
    place = given_path(folder, "folder", InputError)
    record = _Record(Results(place, frozenset()), dict(_asked(inputs, chosen)))
    once = [question for question in chosen if not question.twice]
    found = judge_program(record, build, inputs=inputs, questions=once, rule=rule, name=name or place.name)
    rest = {question.name: "the same input once more." for question in chosen if question.twice}
    rest["draws"] = "inputs that are drawn, and smaller ones in place of those that fail."
    not_asked = [
        Answer(each, Word.UNDECIDED, f"{NEEDS_THE_PROGRAM} {what}", BASIS) for each, what in rest.items()
    ]
    return replace(found, answers=(*found.answers, *not_asked, record.answer()))


def _asked(inputs: Sequence[Data], questions: Sequence[Question]) -> Iterator[tuple[str, Data]]:
    """The different inputs by id: those given, and what each question makes of them."""
    if not inputs:
        raise InputError("inputs", value=inputs, must="must have at least one")
    ways = [(each.derive, k) for each in questions if not each.twice for k in each.variants]
    met = set[str]()
    for given in map(arrays, inputs):
        for data in (given, *(derive(given, k) for derive, k in ways)):
            if data is not None and (key := digest("", data)) not in met:
                met.add(key)
                yield key, data


class _Record:
    """Answers by the digest of the input; call it with the data by name."""

    def __init__(self, results: Results, asked: Mapping[str, Data]) -> None:
        self.asked = asked
        self.strays = [*results.strays, *(f"has no id: {shown(each)}" for each in results.nameless)]
        self.answers: dict[str, list[dict[str, Any]]] = {}
        for key, lines in results.found.items():
            try:
                given = [_numbers(each) for each in lines if each.keys() - ASKED]
            except RecursionError:
                self.strays.append(f"{shown(key)} is nested too deeply")
                continue
            if given:
                self.answers[key] = given

    def __call__(self, **data: Any) -> Any:
        """Look the answer up.

        Raises
        ------
        NotAskedError
            There is none.
        SolverError
            It cannot be read, repeats another input, or is not the only one.
        NotImplementedError
            The program refused the input.
        """
        key = digest("", data)
        found, what = self.answers.get(key, []), f"the recorded answer to the input {key}"
        if not found:
            raise NotAskedError(f"There is no answer to the input {key}.")
        if len(found) > 1:
            raise SolverError(what, value=f"{len(found)} answers", must="must be the only one")
        if found[0].get("input") not in (None, listed(data)):
            must = "must be to that input, and not to another one that it repeats"
            raise SolverError(what, value=found[0]["input"], must=must)
        return answered(found[0], what, str(found[0]))

    def answer(self) -> Answer:
        """What is missing in the folder, or belongs to no input."""
        missing = [key for key in self.asked if key not in self.answers]
        surplus = [key for key in self.answers if key not in self.asked]
        lists = {
            f"{len(missing)} of {len(self.asked)} inputs have no answer": missing,
            f"{len(surplus)} answers are to no input that is asked": surplus,
            f"{len(self.strays)} lines are no answer": self.strays,
        }
        short = {what: told([shown(one) for one in each]) for what, each in lists.items() if each}
        if parts := [f"{what}: {which}." for what, which in short.items()]:
            return Answer("record", Word.NO, escaped(" ".join(parts)), BASIS)
        every = f"Each of the {len(self.asked)} inputs has an answer, and each answer is to one of them."
        return Answer("record", Word.YES, every, BASIS)


def _numbers(value: Any) -> Any:
    """The same with NaN and infinity, which the strict reader leaves as text, as numbers."""
    if isinstance(value, dict):
        return {name: _numbers(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_numbers(part) for part in value]
    return float(value) if isinstance(value, NoFloat) else value
