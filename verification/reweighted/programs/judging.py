"""Programs as black boxes: their answers against the certified optimum of the objective that they state.

Each question (`questions`) makes other inputs of those that are given or drawn; the answer to each is
judged by the objective of that very input (`verdicts`). A question is answered by NO where the program is
right as long as the input is as given, and no longer once it is asked: what is wrong already is said by the
question "as given". What fails is shrunk by Hypothesis, and kept as a finding that can be judged again,
with the program or without it. An acquittal speaks of the inputs that were asked, and of no others.
"""

import json
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np

from convexperc.errors import FileFormatError, InputError, check_type
from convexperc.files import read_json, write_json
from verification.reweighted.answers import Answer, Answers, Word
from verification.reweighted.objectives.objective import Objective
from verification.reweighted.objectives.optimum import Optimum
from verification.reweighted.programs.inputs import arrays, digest, plain
from verification.reweighted.programs.questions import Data, Question, checked
from verification.reweighted.programs.replies import REFUSALS, Kind, Reply, accepted, ask
from verification.reweighted.programs.verdicts import Rule, Verdict, rounded, verdict

DRAWS = 40
"""Inputs that Hypothesis draws for each question."""

FIRST = 6
"""Variants of a question that are tried on each of them; on the smallest that fails, all are."""

SEED = 20
"""Of the draws, so that a run can be repeated."""

BASIS = (
    "F in rationals and balls at the answer and at another point, of the data exactly as they are in float64"
)
CALLED = "what the call returned or raised"
NO_ANSWERS = (Kind.REFUSED, Kind.RAISED)

Program = Callable[..., Any]
Build = Callable[..., Objective]


@dataclass(frozen=True)
class Finding:
    """An input on which a program fails.

    Attributes
    ----------
    id : str
        Digest of question and input.
    program : str
    question : str
    data : mapping of str to Any
        The input.
    kind : Kind
        What came of the call.
    answer : mapping of str to lists of float
        Empty where there is none.
    warned : tuple of str
    other : mapping of str to lists of numbers
        Another point, where F is smaller.
    values : pair of float
        F at the answer and at the other point, rounded.
    rule : Rule
    statement : str
    fault : bool
        False for what the program itself warned of, and for an input that it refused.
    """

    id: str
    program: str
    question: str
    data: Data
    kind: Kind
    answer: Mapping[str, list[float]]
    warned: tuple[str, ...]
    other: Mapping[str, list[Any]]
    values: tuple[float, float] | None
    rule: Rule
    statement: str
    fault: bool

    def as_json(self) -> dict[str, Any]:
        """Plain data, from which `replay` judges it again."""
        return {
            "id": self.id,
            "program": self.program,
            "question": self.question,
            "input": plain(self.data),
            "kind": self.kind.value,
            "answer": plain(self.answer),
            "warned": list(self.warned),
            "other point": plain(self.other),
            "F": None if self.values is None else plain(list(self.values)),
            "tolerance": self.rule.tolerance,
            "absolute": self.rule.absolute,
            "statement": self.statement,
            "fault": self.fault,
        }

    def store(self, folder: Path) -> Path:
        """Write it to a file named by its id."""
        place = folder / f"{self.id}.json"
        write_json(place, self.as_json())
        return place


@dataclass(frozen=True)
class ProgramAnswers(Answers):
    """What is said of a program, and the inputs that show it.

    Attributes
    ----------
    findings : tuple of Finding
        One for each question that was answered by NO.
    """

    findings: tuple[Finding, ...] = ()


def judge_program(
    program: Program,
    build: Build,
    data: Mapping[str, Any] | None = None,
    *,
    inputs: Sequence[Data] = (),
    questions: Sequence[Question] | None = None,
    rule: Rule | None = None,
    draws: int = DRAWS,
    refusals: tuple[type[Exception], ...] = REFUSALS,
    name: str = "",
) -> ProgramAnswers:
    """Judge what a program returns against the optimum of its objective.

    Parameters
    ----------
    program : function
        Of the data by name; returns the variables' values (see `replies.ask`).
    build : function
        Of the data by name, as many as it takes; returns the `Objective`, or something that has one as its
        `objective`.
    data : mapping of str to Hypothesis strategies
        Lists are drawn into arrays.
    inputs : sequence of mappings of str to Any
        Inputs that are always asked, before any is drawn.
    questions : sequence of Question
        Default: each input as it is, and the same input twice; see `questions.all_questions`.
    rule : Rule
        What the program documents; default: 1e-6 relative to the optimum.
    draws : int
        Inputs that are drawn for each question.
    refusals : tuple of exception classes
        By which the program says that an input is not for it. Such an input is undecided; any other exception
        is a fault.
    name : str
        Of the program.

    Returns
    -------
    ProgramAnswers
        YES: within the tolerance on every input that was asked. NO: on one it is not; a fault, unless the
        program gave a warning of its own there. ``warnings`` lists what was warned of.

    Raises
    ------
    InputError
        There is no input at all, an argument is of another kind, or a question names data that there are not.
    """
    if not data and not inputs:
        raise InputError("data", value=data, must="must have strategies, or there must be inputs")
    check_type(rule, (Rule, type(None)), "rule")
    for what, function in (("program", program), ("build", build)):
        if not callable(function):
            raise InputError(what, value=type(function).__name__, must="must be a function of the data")
    trial = _Trial(program, build, rule or Rule(), refusals, name or getattr(program, "__name__", "program"))
    answers, findings = [], []
    for question in checked(questions):
        case = _smallest(trial, question, data or {}, inputs, draws)
        answers.append(trial.answered(question, case))
        if case is not None:
            findings.append(trial.finding(question, case))
    answers.append(trial.warnings())
    return ProgramAnswers(f"{trial.name}, tolerance {trial.rule}", tuple(answers), tuple(findings))


@dataclass(frozen=True)
class _Case:
    """One input, what came of it, and what is proved of that."""

    given: Data
    data: Data
    reply: Reply
    verdict: Verdict | None

    @property
    def basis(self) -> str:
        """What an answer by NO rests on."""
        return CALLED if self.verdict is None else BASIS

    @property
    def ratio(self) -> float:
        """F at the answer beside F at the other point; infinite where there is no answer."""
        if self.verdict is None or self.verdict.value is None or not self.verdict.other_value:
            return float("inf")
        return rounded(self.verdict.value.lower / self.verdict.other_value)

    @property
    def fails(self) -> bool:
        """Whether a finding is made of it."""
        if self.reply.kind is Kind.ANSWER:
            return self.verdict is not None and self.verdict.word is Word.NO
        return self.reply.kind not in {Kind.REFUSED, Kind.NOT_ASKED}

    @property
    def fault(self) -> bool:
        """Whether it speaks against the program."""
        return self.fails and not self.reply.told


@dataclass
class _Trial:
    """A program under judgement, and what its inputs have shown so far."""

    program: Program
    build: Build
    rule: Rule
    refusals: tuple[type[Exception], ...]
    name: str
    asked: int = 0
    replies: int = 0
    not_asked: int = 0
    undecided: list[str] = field(default_factory=list)
    wrong_as_given: int = 0
    unknown_as_given: int = 0
    worst: float = 0.0
    optima: dict[str, Optimum] = field(default_factory=dict)
    warned: dict[str, int] = field(default_factory=dict)

    def begin(self) -> None:
        """Count anew."""
        self.asked, self.not_asked, self.undecided = 0, 0, []
        self.wrong_as_given, self.unknown_as_given, self.worst = 0, 0, 0.0

    def case(self, question: Question, data: Data, variant: int) -> _Case | None:
        """Ask; None where the question does not apply to the input, or is not why it is wrong."""
        given = question.derive(data, variant)
        if given is None:
            return None
        case = self._asked(data, given, twice=question.twice)
        if case.fails and question.beside:
            beside = self._asked(data, data)
            unknown = beside.reply.kind in (Kind.NOT_ASKED, Kind.REFUSED)
            self.wrong_as_given += beside.fails
            self.unknown_as_given += unknown
            if beside.fails or unknown:
                return None
        self._count(case)
        return case

    def _asked(self, given: Data, data: Data, *, twice: bool = False) -> _Case:
        objective = built(self.build, data)
        reply = ask(self.program, data, objective, twice=twice, refusals=self.refusals)
        if reply.kind is not Kind.ANSWER:
            return _Case(given, data, reply, None)
        key = digest("", data)
        judged = verdict(objective, reply.values, self.rule, self.optima.get(key))
        if judged.best is not None:
            self.optima[key] = judged.best
        return _Case(given, data, reply, judged)

    def _count(self, case: _Case) -> None:
        if case.reply.kind is Kind.NOT_ASKED:
            self.not_asked += 1
            return
        self.asked += 1
        self.replies += 1
        for text in case.reply.warned:
            self.warned[text] = self.warned.get(text, 0) + 1
        if case.reply.kind is Kind.REFUSED:
            self.undecided.append(case.reply.text)
        elif case.verdict is not None and case.verdict.word is Word.UNDECIDED:
            self.undecided.append(case.verdict.reason)
        elif case.verdict is not None and case.verdict.word is Word.YES and np.isfinite(case.verdict.excess):
            self.worst = max(self.worst, case.verdict.excess)

    def answered(self, question: Question, case: _Case | None) -> Answer:
        """The answer to a question, of all inputs that were asked."""
        if case is not None:
            said = self.statement(question, case)
            shown = {key: json.dumps(value) for key, value in self._shown(question, case).items()}
            return Answer(question.name, Word.NO, said, case.basis, shown, case.fault)
        wrong = f"On {self.wrong_as_given} more it is wrong as they are given." if self.wrong_as_given else ""
        if self.unknown_as_given:
            more = f"On {self.unknown_as_given} more it is wrong, and as they are given it has no answer."
            wrong = f"{wrong} {more}".strip()
        unknown = f"Inputs without an answer on record: {self.not_asked}." if self.not_asked else ""
        if self.asked and not self.undecided and not unknown and not self.unknown_as_given:
            far = f"farthest above F*: {self.worst:.1e} of it"
            said = f"Within the tolerance on all {self.asked} inputs; {far}. {wrong}"
            basis = "a proved lower bound of each optimum; for these inputs alone"
            return Answer(question.name, Word.YES, said.strip(), basis)
        acquitted = self.asked - len(self.undecided)
        within = f"Within the tolerance on {acquitted} of {self.asked} inputs."
        none = "" if self.asked or wrong else "The question applies to no input."
        if unknown and not self.asked:
            within = none = ""
        parts = [within, none, *self.undecided[:1], wrong, unknown]
        return Answer(question.name, Word.UNDECIDED, " ".join(filter(None, parts)), BASIS)

    def warnings(self) -> Answer:
        """What the program warned of."""
        if not self.replies:
            return Answer(
                "warnings", Word.UNDECIDED, "Nothing was asked.", "calls with all warnings recorded"
            )
        if not self.warned:
            return Answer("warnings", Word.YES, "It gave no warnings.", "calls with all warnings recorded")
        counted = "; ".join(f"{text} ({count} times)" for text, count in self.warned.items())
        return Answer("warnings", Word.NO, f"It warned: {counted}.", "calls with all warnings recorded")

    def statement(self, question: Question, case: _Case) -> str:
        """What an input shows, in one sentence."""
        how = "" if question.name == "as given" else f" ({question.name})"
        told = f" It warned: {case.reply.warned[0]}." if case.reply.told else ""
        if case.reply.kind is not Kind.ANSWER:
            text = f": {case.reply.text}" if case.reply.text else ""
            return f"{case.reply.kind.value.capitalize()}{how}{text}{'' if text.endswith('.') else '.'}{told}"
        value, other = self._values(case)
        more = f"{100 * (case.ratio - 1):.3g} % above it" if other else "above 0"
        said = f"F(answer) = {value:.6g}{how}; at another point F = {other:.6g}."
        return f"{said} The answer is {more}; allowed is {self.rule}.{told}"

    @staticmethod
    def _values(case: _Case) -> tuple[float, float]:
        assert case.verdict is not None
        assert case.verdict.value is not None
        assert case.verdict.other_value is not None
        return rounded(case.verdict.value.lower), rounded(case.verdict.other_value)

    def _shown(self, question: Question, case: _Case) -> dict[str, Any]:
        shown = {"id": digest(question.name, case.data), "input": plain(case.data)}
        if case.reply.values:
            shown["answer"] = plain(case.reply.values)
        if case.verdict is not None:
            shown["F(answer)"], shown["F(other point)"] = self._values(case)
            shown["other point"] = plain(case.verdict.other or {})
        return shown

    def finding(self, question: Question, case: _Case) -> Finding:
        """What is kept of a failure."""
        return Finding(
            id=digest(question.name, case.data),
            program=self.name,
            question=question.name,
            data=case.data,
            kind=case.reply.kind,
            answer={name: values.tolist() for name, values in case.reply.values.items()},
            warned=case.reply.warned,
            other={} if case.verdict is None else {k: list(v) for k, v in (case.verdict.other or {}).items()},
            values=None if case.verdict is None else self._values(case),
            rule=self.rule,
            statement=self.statement(question, case),
            fault=case.fault,
        )


def built(build: Build, data: Data) -> Objective:
    """The objective of an input.

    Raises
    ------
    InputError
        The function returns none.
    """
    found = build(**accepted(build, data))
    objective: Any = getattr(found, "objective", found)
    check_type(objective, Objective, "what build returns")
    return cast(Objective, objective)


def _smallest(
    trial: _Trial, question: Question, strategies: Mapping[str, Any], inputs: Sequence[Data], draws: int
) -> _Case | None:
    """The smallest input found to fail; None if none did. A fault comes before what the program tells."""
    trial.begin()
    cases = [_worst(trial, question, arrays(data)) for data in inputs]
    failing = [case for case in cases if case is not None]
    fault = next((case for case in failing if case.fault), None)
    if fault is None and strategies:
        drawn = _drawn(trial, question, strategies, draws)
        failing += [] if drawn is None else [drawn]
        fault = next((case for case in failing if case.fault), None)
    return fault or next(iter(failing), None)


def _worst(trial: _Trial, question: Question, data: Data) -> _Case | None:
    """Of all ways to ask, the simplest with the worst answer, to one digit; None if none fails."""
    cases = [trial.case(question, data, variant) for variant in sorted(question.variants, key=abs)]
    failing = [case for case in cases if case is not None and case.fails]
    return max(failing, key=lambda case: (case.fault, float(f"{case.ratio - 1:.1g}")), default=None)


def _drawn(trial: _Trial, question: Question, strategies: Mapping[str, Any], draws: int) -> _Case | None:
    from hypothesis import HealthCheck, find, settings  # noqa: PLC0415
    from hypothesis import strategies as st  # noqa: PLC0415
    from hypothesis.errors import NoSuchExample  # noqa: PLC0415

    told: list[_Case] = []

    def fails(data: Data) -> bool:
        for variant in question.variants[:FIRST]:
            case = trial.case(question, arrays(data), variant)
            if case is not None and case.fault:
                return True
            if case is not None and case.fails:
                told.append(case)
        return False

    inputs = st.fixed_dictionaries(dict(strategies))
    how = settings(max_examples=draws, database=None, deadline=None, suppress_health_check=list(HealthCheck))
    try:
        smallest = find(inputs, fails, settings=how, random=random.Random(SEED))
    except NoSuchExample:
        return told[0] if told else None
    return _worst(trial, question, arrays(smallest))


def replay(
    finding: Finding | Path | Mapping[str, Any], build: Build, program: Program | None = None
) -> Answer:
    """Judge a finding again: the program's answer of today, or, without the program, the one on record.

    Parameters
    ----------
    finding : Finding, or its file, or its JSON
    build : function
        As for `judge_program`.
    program : function, optional

    Returns
    -------
    Answer
        NO: it is found again. YES: the answer is within the tolerance. UNDECIDED: neither is proved, or
        there is no answer to judge.

    Raises
    ------
    FileFormatError
        The file is no finding, or its input was changed.
    """
    record = _record(finding)
    data, rule = arrays(record["input"]), Rule(record["tolerance"], record["absolute"])
    objective = built(build, data)
    if program is None:
        values = {name: np.array(part, dtype=float) for name, part in record["answer"].items()}
        reply = Reply(Kind(record["kind"]), values)
        whose = "the recorded answer"
    else:
        reply = ask(program, data, objective, twice=record["question"] == "ask twice")
        whose = "a new answer"
    trial = _Trial(lambda: None, build, rule, REFUSALS, record["program"])
    question = Question(record["question"], (0,), lambda given, _: given)
    if reply.kind is not Kind.ANSWER:
        unknown = (program is None and reply.kind in NO_ANSWERS) or reply.kind is Kind.NOT_ASKED
        word = Word.UNDECIDED if unknown else Word.NO
        said = trial.statement(question, _Case(data, data, reply, None))
        return Answer("replay", word, said, whose, fault=record["fault"])
    judged = verdict(objective, reply.values, rule)
    if judged.word is Word.NO:
        said = trial.statement(question, _Case(data, data, reply, judged))
        return Answer("replay", Word.NO, said, f"{whose}; {BASIS}", fault=record["fault"])
    within = f"Within the tolerance, {rule}." if judged.word is Word.YES else judged.reason
    return Answer("replay", judged.word, within, whose)


def _record(finding: Finding | Path | Mapping[str, Any]) -> Mapping[str, Any]:
    if isinstance(finding, Finding):
        return finding.as_json()
    file, record = read_json(finding) if isinstance(finding, Path) else ("finding", finding)
    wanted = {"id", "program", "question", "input", "kind", "answer", "tolerance", "absolute", "fault"}
    if not isinstance(record, Mapping) or not wanted <= set(record):
        raise FileFormatError(
            file, value=type(record).__name__, must=f"must have {', '.join(sorted(wanted))}"
        )
    if record["id"] != digest(record["question"], record["input"]):
        raise FileFormatError(file, value=record["id"], must="must be the digest of its question and input")
    return record
