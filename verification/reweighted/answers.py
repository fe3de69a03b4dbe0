"""What is said of a term, a loop or a program: one answer to each question, with what it rests on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class Word(StrEnum):
    """The answer to a question."""

    YES = "yes"
    NO = "no"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Answer:
    """The answer to one question.

    Attributes
    ----------
    question : str
    word : Word
    statement : str
        What was found, in one sentence.
    basis : str
        What it rests on: who checked which formula, or which exact numbers show it.
    instance : mapping
        For a NO, the numbers that show it, as text; empty if there are none.
    fault : bool
        Whether a NO speaks against the update; some questions only describe it.
    replay : mapping
        For a NO about a loop, ``data`` and ``start`` of its instance as JSON values.
    """

    question: str
    word: Word
    statement: str
    basis: str
    instance: Mapping[str, str] = field(default_factory=dict)
    fault: bool = False
    replay: Mapping[str, Any] = field(default_factory=dict)

    @property
    def accuses(self) -> bool:
        """Whether it is a NO that speaks against the update."""
        return self.fault and self.word is Word.NO

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "question": self.question,
            "answer": self.word.value,
            "statement": self.statement,
            "basis": self.basis,
            "instance": dict(self.instance),
            "fault": self.accuses,
        }


@dataclass(frozen=True)
class Answers:
    """All answers about one thing.

    Attributes
    ----------
    subject : str
        What was judged.
    answers : tuple of Answer
        In the order of the questions.
    """

    subject: str
    answers: tuple[Answer, ...]

    def __getitem__(self, question: str) -> Answer:
        """The answer to a question; KeyError if it was not asked."""
        for answer in self.answers:
            if answer.question == question:
                return answer
        raise KeyError(question)

    def __iter__(self) -> Iterator[Answer]:
        """The answers in order."""
        return iter(self.answers)

    @property
    def faults(self) -> tuple[Answer, ...]:
        """The answers that speak against the update."""
        return tuple(answer for answer in self.answers if answer.accuses)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"subject": self.subject, "answers": [answer.as_json() for answer in self.answers]}

    def __str__(self) -> str:
        """A table in plain text."""
        lines = [self.subject]
        for answer in self.answers:
            lines.append(f"  {answer.question:<12} {answer.word.value:<10} {answer.statement}")
            lines.append(f"  {'':<12} {'':<10} [{answer.basis}]")
        return "\n".join(lines)
