"""Formulas as MathML: no letter is lost, signs keep their meaning, words and hostile text stay text."""

import html
import re
from xml.etree import ElementTree

import pytest
from test_report import EVIL, spelled

from verification.counterexamples.files import catalogue
from verification.counterexamples.given import given
from verification.ledger.claims import CAUSES, CLAIMS
from verification.report import symbols
from verification.report.mathml import set_formulas

TEXTS = [
    *(
        text
        for claim in CLAIMS.values()
        for text in (claim.statement, *(part.statement for part in claim.parts))
    ),
    *(text for cause in CAUSES.values() for text in (cause.statement, cause.printed, cause.corrected)),
    *(text for pair in (*symbols.SYMBOLS, *symbols.VARIANTS) for text in pair),
    *(given(record) for record in catalogue()),
]


def text_of(markup: str) -> str:
    return html.unescape(re.sub(r"<[^>]*>", "", markup))


@pytest.mark.parametrize("text", TEXTS)
def test_the_text_of_a_sentence_is_that_of_the_plain_notation(text: str) -> None:
    found = str(set_formulas(text))
    assert spelled(text_of(found)) == spelled(text)
    ElementTree.fromstring(f"<p>{found.replace('&nbsp;', ' ')}</p>")


def test_a_letter_more_or_less_is_noticed() -> None:
    found = str(set_formulas("F(w, u) >= 0"))
    assert spelled(text_of(found)) != spelled("F(w, u) > 0")
    assert spelled(text_of(found.replace("<mi>u</mi>", ""))) != spelled("F(w, u) >= 0")


def test_nearly_all_of_the_ledger_is_set() -> None:
    left = [text for text in TEXTS if 'class="math"' in str(set_formulas(text))]
    assert len(left) <= 6, left
    assert sum("<math>" in str(set_formulas(text)) for text in TEXTS) > 100


W, SPACE = "<mi>w</mi>", "<mspace width='0.17em'/>"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("w*_j", f"<msub><mrow><msup><mrow>{W}</mrow><mo>*</mo></msup></mrow><mrow><mi>j</mi></mrow></msub>"),
        ("w^2.5", f"<msup><mrow>{W}</mrow><mrow><mn>2.5</mn></mrow></msup>"),
        ("w^-27", f"<msup><mrow>{W}</mrow><mrow><mo>\N{MINUS SIGN}</mo><mn>27</mn></mrow></msup>"),
        ("w'", f"<msup><mrow>{W}</mrow><mo>\N{PRIME}</mo></msup>"),
        ("X'", "<msup><mrow><mi>X</mi></mrow><mo>\N{DOWN TACK}</mo></msup>"),
        ("w'o", f"<msup><mrow>{W}</mrow><mo>\N{DOWN TACK}</mo></msup><mi>o</mi>"),
        ("w < 1", f"{W} <mo form='infix'>&lt;</mo> <mn>1</mn>"),
        ("2 w", f"<mn>2</mn> {SPACE}{W}"),
    ],
)
def test_marks_become_scripts(text: str, expected: str) -> None:
    assert str(set_formulas(text)) == f"<math>{expected}</math>"


def test_entries_of_a_matrix_are_no_differences() -> None:
    apart = "<mspace width='0.4em'/>"
    assert str(set_formulas("X = [1 -3; -1 2]")).count(apart) == 2
    assert str(set_formulas("X = [1 - 3]")).count(apart) == 0
    assert str(set_formulas("||Xu-w||^2")).count("<mo form='infix'>\N{MINUS SIGN}</mo>") == 1


@pytest.mark.parametrize(
    "text",
    [
        "A run is a step",
        "the trace's stop reason",
        "Gauss-Seidel, z3 and X1 to X8",
        "(none)",
        "7 of 250 cases",
        "family one_view",
        "python -m verification run",
    ],
)
def test_words_stay_words(text: str) -> None:
    assert text_of(str(set_formulas(text))) == text
    assert "<" not in str(set_formulas(text))


def test_what_is_not_understood_is_shown_as_it_is_written() -> None:
    assert str(set_formulas("lower <= F* <= upper")) == '<span class="math">lower &lt;= F* &lt;= upper</span>'
    assert "F's" in text_of(str(set_formulas("F's minimum F*")))


def test_a_matrix_that_no_phone_can_show_stays_as_it_is_written() -> None:
    wide = f"X = [{' '.join(['3.0000000000000004e-08'] * 8)}], o = [1]"
    found = str(set_formulas(wide))
    assert found.startswith('<span class="math">X = [3.0000000000000004e-08')
    assert found.endswith(
        "<math><mi>o</mi> <mo form='infix'>=</mo> <mrow><mo stretchy='false'>[</mo>"
        "<mn>1</mn><mo stretchy='false'>]</mo></mrow></math>"
    )
    assert spelled(text_of(found)) == spelled(wide)
    pieces = str(set_formulas("F(i) - F(i+1) >= ||X'dw||^2 + lambda1 ||dw||^2 + lambda1 ||X du||^2")).split(
        "<math>"
    )
    assert len(pieces) == 6, "a long formula may be broken before each of its signs"


def test_hostile_text_stays_text() -> None:
    assert str(set_formulas("&lt;bold&gt; & 'cut'")) == "&amp;lt;bold&amp;gt; &amp; &#39;cut&#39;"
    for text in (EVIL, f"`{EVIL}`", "w <script>", "<math>w</math>", "||<b>||", "w_<i>"):
        found = str(set_formulas(text))
        assert not re.search(r"<(script|b|i)\b", found), found
        assert "<math>w</math>" not in text or found.count("<math>") <= 1
