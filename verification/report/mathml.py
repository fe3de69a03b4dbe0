"""Formulas of the plain notation as MathML: "lambda1 ||Xu - w||^2 >= 0" within a sentence of words.

A sentence is cut into tokens; a recursive descent finds the longest formulas among them. What does not parse
stays text, and a sentence in which a sign of mathematics would stay text is not converted at all: then it is
shown as it is written. The text of a formula, without the marks ^ and _, is that of the plain notation.
"""

import re
from dataclasses import dataclass

from markupsafe import Markup, escape

MINUS, TRANSPOSE, PRIME = "\N{MINUS SIGN}", "\N{DOWN TACK}", "\N{PRIME}"
GREEK = {"lambda": "λ", "lambda1": "λ1", "lambda2": "λ2", "lambda3": "λ3", "eps": "ε", "phi": "φ"}
LETTERS = frozenset("ABDFGHKLMNQRSXZbcdeghijkmnopqrtuvwxyz")
"""Single letters that are symbols wherever they stand."""
AMBIGUOUS = frozenset({"a", "A", "I", "s", "O"})
"""Letters that are words unless a sign beside them makes them symbols."""
TOGETHER = {name: tuple(name) for name in ("Xu", "Xo", "XX", "dw", "du", "dF")}
"""Symbols that the notation writes without a blank."""
NAMES = frozenset({"acc", "argmin", "blockdiag", "diag", "inf", "log10", "max", "min", "sqrt", "sum"})
SIGNS = {sign: sign for sign in ("<", ">", "=", "+", "/", "..")} | {
    "<=": "≤",
    ">=": "≥",
    "!=": "≠",
    "->": "→",
    "-": MINUS,
}
RELATIONS = ("<", "<=", ">", ">=")
CLOSED_BY = {"(": ")", "[": "]"}
KEY = re.compile(r"[A-Z]\d[a-z]?(?:/\w+)+")
"""The key of a part."""
TOKEN = re.compile(
    "|".join(
        (
            r"\s+",
            r"`[^`]*`",  # code
            KEY.pattern,
            r"(?<=\s)-[a-z](?=\s+[a-z]{3})",  # an option of a command
            r"\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![A-Za-z])",
            r"\d+",
            r"'s(?![A-Za-z])",  # of a genitive
            r"lambda[123]?(?![A-Za-z0-9])",
            r"[A-Za-z]{3,}(?:_[a-z]{2,})+",  # a name of a program
            r"[A-Za-z][A-Za-z0-9]*(?:-[A-Za-z0-9]+)*",
            r"<=|>=|!=|->|\.\.|\|\|",
            r".",
        )
    )
)
CLINGING = frozenset(",.;:)")
"""Marks that stay on the line of the formula before them."""
LONG, BREAK = 36, "\0"
"""Letters of a formula that may be broken before its signs, and what marks these places until then."""
WIDEST = 40
"""Letters that a phone shows in one line; a wider matrix is left as it is written, which breaks anywhere."""
TAG = re.compile("<[^>]*>")
LEFT_OVER = re.compile(r"[\^|<>=]|->|(?<![A-Za-z]{3})_|\blambda(?!s\b)|\b(sqrt|diag|blockdiag)\b")
"""Signs of mathematics: a sentence with one of them in its text was not understood."""


@dataclass(frozen=True)
class _Found:
    """A formula that ends before token `end`; `bare` if it is a number, or a letter that may be a word."""

    xml: str
    end: int
    bare: bool = False


def set_formulas(text: object) -> Markup:
    """Set the formulas of a sentence.

    Returns
    -------
    Markup
        The sentence with `<math>` for its formulas and `<code>` for what stands between backticks, or in a
        span of class math if it was not understood.
    """
    tokens = list(_tokens(str(text)))
    made, words, at = "", "", 0
    while at < len(tokens):
        found = _Parser(tokens).formula(at, BREAK)
        if tokens[at][0] == "`" and len(tokens[at]) > 1:
            made += f"<code>{escape(tokens[at][1:-1])}</code>"
            at += 1
        elif found is None or found.bare:
            end = found.end if found is not None else at + 1
            words += " " if KEY.fullmatch(tokens[at]) else "".join(tokens[at:end])
            made += str(escape("".join(tokens[at:end])))
            at = end
        else:
            plain = "".join(tokens[at : found.end])
            words, at = f"{words} ", found.end
            mark = tokens[at] if at < len(tokens) and tokens[at] in CLINGING else ""
            made += _set(found.xml, plain, mark)
            at += bool(mark)
    return Markup(f'<span class="math">{escape(text)}</span>' if LEFT_OVER.search(words) else made)


def _set(xml: str, plain: str, mark: str) -> str:
    """A formula and the mark after it; in pieces if it is long, as it is written if one would be too wide."""
    *before, last = xml.split(BREAK) if len(plain) > LONG else [xml.replace(BREAK, " ")]
    if max(len(TAG.sub("", piece)) for piece in (*before, last)) > WIDEST:
        return f'<span class="math">{escape(plain)}</span>{mark}'
    made = "".join(f"<math>{piece}</math> " for piece in before)
    return made + (f'<span class="nb"><math>{last}</math>{mark}</span>' if mark else f"<math>{last}</math>")


def _tokens(text: str) -> list[str]:
    """Cut a sentence; symbols with hyphens between them, as in Xu-w, are several tokens."""
    tokens, at = [], 0
    while at < len(text):
        token = TOKEN.match(text, at)[0]  # type: ignore[index]  # the last alternative takes any sign
        first, _, rest = token.partition("-")
        if rest and token[0].isalpha() and all(_is_symbol(each) for each in token.split("-")):
            token = first
        tokens.append(token)
        at += len(token)
    return tokens


def _is_symbol(word: str) -> bool:
    return word in GREEK or word in TOGETHER or word in LETTERS or word in AMBIGUOUS


def _symbol(token: str) -> str:
    """A number or a letter as MathML; empty for a word."""
    if token[:1].isdigit():
        return f"<mn>{token}</mn>"
    if token in GREEK:
        letter, digit = f"<mi>{GREEK[token][0]}</mi>", GREEK[token][1:]
        return f"<msub>{letter}<mn>{digit}</mn></msub>" if digit else letter
    if token in TOGETHER:
        return "".join(f"<mi>{letter}</mi>" for letter in TOGETHER[token])
    return f"<mi>{token}</mi>" if token in LETTERS or token in AMBIGUOUS else ""


class _Parser:
    """Recursive descent over tokens; each method returns what it found from a token on, or None."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens

    def at(self, place: int) -> str:
        return self.tokens[place] if place < len(self.tokens) else ""

    def skip(self, place: int) -> int:
        """Over blanks."""
        while self.at(place).isspace():
            place += 1
        return place

    def formula(self, start: int, join: str = " ") -> _Found | None:
        """Products joined by signs; a sign in front as well."""
        sign, place = "", start
        if self.at(start) in RELATIONS:
            sign, place = f"<mo>{escape(SIGNS[self.at(start)])}</mo> ", self.skip(start + 1)
        elif self.at(start) in ("-", "+") and not self.at(start + 1).isspace():
            sign, place = f"<mo form='prefix' lspace='0' rspace='0'>{SIGNS[self.at(start)]}</mo>", start + 1
        first = self.product(place)
        if first is None:
            return None
        xml, end, bare = sign + first.xml, first.end, first.bare and not sign
        while (sign := self.at(self.skip(end))) in SIGNS and not self._is_prefix(end):
            after = self.formula(self.skip(self.skip(end) + 1), join)
            if after is None:
                break
            gap = " " if sign == "/" else join
            xml, end, bare = (
                f"{xml}{gap}<mo form='infix'>{escape(SIGNS[sign])}</mo> {after.xml}",
                after.end,
                False,
            )
        return _Found(xml, end, bare)

    def _is_prefix(self, end: int) -> bool:
        """Whether the sign after a blank belongs to the next entry, as in [1 -3]."""
        place = self.skip(end)
        return place > end and self.at(place) in ("-", "+") and not self.at(place + 1).isspace()

    def product(self, start: int) -> _Found | None:
        """Factors beside one another: 2 a b, lambda1 ||Xu - w||^2, F(w, u)."""
        first = self.factor(start)
        if first is None:
            return None
        xml, end, bare = first.xml, first.end, first.bare
        while True:
            place = self.skip(end)
            blank = place > end
            if self.at(place)[:1].isdigit() or (blank and self._is_word(place)):
                break
            after = self.factor(place)
            if after is None or (blank and bare and after.bare):
                break
            gap = " <mspace width='0.17em'/>" if blank else ""
            xml, end, bare = xml + gap + after.xml, after.end, False
        return _Found(xml, end, bare)

    def _is_word(self, place: int) -> bool:
        """Whether the letter after a blank is a word ("F rises by a step") and no factor (lambda1 I + B)."""
        after = self.at(self.skip(place + 1))
        return self.at(place) in AMBIGUOUS and not (
            after in SIGNS or after in ("^", "_", "'", ")", "]", "|", "||")
        )

    def factor(self, start: int) -> _Found | None:
        """An atom with its marks: ', *, ^ and _."""
        found = self.atom(start)
        if found is None:
            return None
        xml, end, bare = found.xml, found.end, found.bare
        symbol = (
            self.at(start).isalpha() or self.at(start) in GREEK or self.at(start) in ("(", "[", "|", "||")
        )
        while end < len(self.tokens):
            mark = self.at(end)
            if mark == "'" and symbol:
                raised = TRANSPOSE if self._is_transposed(start, end) else PRIME
                xml, end = f"<msup><mrow>{xml}</mrow><mo>{raised}</mo></msup>", end + 1
            elif mark == "*" and symbol and not self.at(end + 1)[:1].isdigit():
                xml, end = f"<msup><mrow>{xml}</mrow><mo>*</mo></msup>", end + 1
            elif mark in ("^", "_") and (script := self.script(end + 1)) is not None:
                kind = "msup" if mark == "^" else "msub"
                xml, end = f"<{kind}><mrow>{xml}</mrow><mrow>{script.xml}</mrow></{kind}>", script.end
            else:
                break
            bare = False
        return _Found(xml, end, bare)

    def _is_transposed(self, start: int, end: int) -> bool:
        """Whether ' means the transpose, of a matrix or of a factor; else it marks another point."""
        after = self.at(end + 1)
        return not self.at(start).islower() or after[:1].isalpha() or after in ("(", "|")

    def script(self, start: int) -> _Found | None:
        """What stands after ^ or _: a number with a sign, a name, a group."""
        if self.at(start) == "-" and self.at(start + 1)[:1].isdigit():
            return _Found(f"<mo>{MINUS}</mo><mn>{self.at(start + 1)}</mn>", start + 2)
        if self.at(start) in CLOSED_BY:
            return self.group(start)
        word = self.at(start)
        if word in GREEK or word[:1].isdigit():
            return self.atom(start)
        if word.isalpha() and len(word) == 1:
            return _Found(f"<mi>{word}</mi>", start + 1)
        if word.isalpha() and word.islower():
            return _Found(f"<mtext>{word}</mtext>", start + 1)
        return None

    def atom(self, start: int) -> _Found | None:
        """A number, a symbol, a group, an absolute value or a norm."""
        token = self.at(start)
        if token in CLOSED_BY:
            return self.group(start)
        if token in ("|", "||"):
            return self.fenced(start)
        if token in NAMES:
            return self.named(start)
        symbol = _symbol(token)
        return _Found(symbol, start + 1, token[:1].isdigit() or token in AMBIGUOUS) if symbol else None

    def named(self, start: int) -> _Found | None:
        """A name such as max, where something follows that it applies to."""
        name, after = self.at(start), self.at(start + 1)
        sign = {"sum": "<mo largeop='false'>∑</mo>", "sqrt": "<mo>√</mo>"}.get(name, f"<mi>{name}</mi>")
        applied = after in ("(", "_") or (name != "acc" and self.factor(self.skip(start + 1)) is not None)
        return _Found(sign, start + 1) if applied else None

    def fenced(self, start: int) -> _Found | None:
        """What stands between two bars or two double bars."""
        bar = self.at(start)
        inner = self.formula(self.skip(start + 1))
        if inner is None or self.at(self.skip(inner.end)) != bar:
            return None
        sign = f"<mo stretchy='false'>{'‖' if bar == '||' else '|'}</mo>"
        return _Found(f"<mrow>{sign}{inner.xml}{sign}</mrow>", self.skip(inner.end) + 1)

    def group(self, start: int) -> _Found | None:
        """Formulas in brackets, with commas, semicolons or blanks between them."""
        closing, xml, place, bare = CLOSED_BY[self.at(start)], "", start + 1, True
        while True:
            inner = self.formula(self.skip(place))
            if inner is None:
                return None
            xml, place, bare = xml + inner.xml, self.skip(inner.end), bare and inner.bare
            token = self.at(place)
            if token == closing:
                fence = f"<mo stretchy='false'>{self.at(start)}</mo>{xml}<mo stretchy='false'>{closing}</mo>"
                return _Found(f"<mrow>{fence}</mrow>", place + 1, bare)
            if token in (",", ";"):
                xml, place = f"{xml}<mo separator='true'>{token}</mo> ", place + 1
            elif place > inner.end:
                xml += "<mspace width='0.4em'/> "
            else:
                return None
