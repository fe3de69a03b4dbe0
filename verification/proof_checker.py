"""An independent check of a proof file: integers and fractions alone, and the standard library alone.

Proved is lower <= F* <= upper for the problem that the file holds:

    F(w,u) = ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||_2
    F* <= F(w,u) at any point; F* >= D(a,b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1) at any (a,b) with
    |X a - b|_j <= lambda2 and ||X_i' b|| <= lambda3, and with b = 0 where lambda1 = 0.

No float takes part in the mathematics, nothing is accepted within a tolerance, and no code is shared with the
writer.
"""

import hashlib
import json
import re
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from pathlib import Path
from typing import Any

SCHEMA = "convexperc/proof/1"
ROOT_BITS = 256
"""Square roots are rounded up at this many bits; the writer rounds up at fewer."""
MOST_DIGITS, MOST_EXPONENT = 2**18, 2**18
"""Hexadecimal digits and binary exponent of a number: beyond these a file only costs memory."""
MOST_BITS, MOST_WORK = 2**31, 2**45
"""Bits of a vector in units of its smallest part (256 MB), and products of bits (a minute or less)."""
LAMBDAS = ("lambda1", "lambda2", "lambda3")
HEX = re.compile(r"(-?)0x([0-9a-f]+)(?:\.([0-9a-f]+))?p([+-][0-9]{1,7})", re.ASCII)


class Rejected(Exception):  # noqa: N818 - a verdict, not an error
    """The file proves nothing; the message says why."""


@dataclass(frozen=True)
class Verdict:
    """Whether a file is a proof; of what, or why not; and the digest of its data, empty where rejected."""

    proved: bool
    reason: str
    sha256: str = ""


@dataclass(frozen=True)
class _Vector:
    """Integers times one power of two."""

    whole: tuple[int, ...]
    exponent: int

    def minus(self, other: "_Vector") -> "_Vector":
        low = min(self.exponent, other.exponent)
        x, y = ([entry << (v.exponent - low) for entry in v.whole] for v in (self, other))
        return _Vector(tuple(a - b for a, b in zip(x, y, strict=True)), low)

    def dot(self, other: "_Vector") -> Fraction:
        total = sum(x * y for x, y in zip(self.whole, other.whole, strict=True))
        return total * _power(self.exponent + other.exponent)

    def part(self, columns: Sequence[int]) -> "_Vector":
        return _Vector(tuple(self.whole[j] for j in columns), self.exponent)

    @property
    def bits(self) -> int:
        return max(abs(entry).bit_length() for entry in self.whole)


@dataclass(frozen=True)
class _Problem:
    """The data: X as integers in units of 2^exponent, modalities as lists of columns."""

    X: tuple[tuple[int, ...], ...]
    exponent: int
    o: _Vector
    modalities: tuple[tuple[int, ...], ...]
    lambdas: tuple[Fraction, Fraction, Fraction]
    sha256: str

    def rows(self, x: _Vector) -> _Vector:
        """X x."""
        whole = (sum(a * b for a, b in zip(row, x.whole, strict=True)) for row in self.X)
        return _Vector(tuple(whole), self.exponent + x.exponent)

    def columns(self, x: _Vector) -> _Vector:
        """X' x."""
        total = [0] * len(self.o.whole)
        for row, factor in zip(self.X, x.whole, strict=True):
            if factor:
                total = [t + a * factor for t, a in zip(total, row, strict=True)]
        return _Vector(tuple(total), self.exponent + x.exponent)


def check(source: Path | str) -> Verdict:
    """Check a proof.

    Parameters
    ----------
    source : Path or str
        A file, or the JSON text itself.

    Raises
    ------
    OSError
        There is no such file, or it cannot be read.
    """
    data = source.encode("utf-8", "surrogatepass") if isinstance(source, str) else source.read_bytes()
    try:
        record = _keyed(_parsed(data), "the file", ("schema", "problem", "sha256", "claim", "primal", "dual"))
        _require(record["schema"] == SCHEMA, f"schema: must be {SCHEMA!r}")
        problem = _read_problem(record["problem"])
        _require(record["sha256"] == problem.sha256, f"sha256: the data have {problem.sha256}")
        claim = _keyed(record["claim"], "claim", ("lower", "upper"))
        lower, upper = (_number(claim[end], f"claim.{end}") for end in ("lower", "upper"))
        n, d = len(problem.X), len(problem.o.whole)
        primal, dual = (_keyed(record[k], k, names) for k, names in (("primal", "wu"), ("dual", "ab")))
        w, u = _vector(primal["w"], "primal.w", n), _vector(primal["u"], "primal.u", d)
        a, b = _vector(dual["a"], "dual.a", d), _vector(dual["b"], "dual.b", n)
        _check_work(problem, max(x.bits for x in (w, u, a, b)))
        _check_feasible(problem, a, b)
        _require(_dual_value(problem, a, b) >= lower, "claim.lower: exceeds D(a, b)")
        _require(_objective(problem, w, u) <= upper, "claim.upper: is below F(w, u)")
    except Rejected as rejection:
        return Verdict(False, str(rejection))
    except MemoryError:
        return Verdict(False, "not checked: it takes more memory than there is")
    return Verdict(True, f"{claim['lower']} <= F* <= {claim['upper']}", problem.sha256)


def _check_work(problem: _Problem, bits: int) -> None:
    """Reject witnesses of so many bits that the products below would take too long."""
    n, d, m = len(problem.X), len(problem.o.whole), len(problem.modalities)
    own = max(abs(entry).bit_length() for row in problem.X for entry in row)
    work = n * d * own * bits + (n + d + m) * bits**2
    _require(work <= MOST_WORK, f"not checked: its numbers have {bits} bits, beyond the limit of work")


def _check_feasible(problem: _Problem, a: _Vector, b: _Vector) -> None:
    """Reject a dual point that violates a constraint by anything at all."""
    lambda1, lambda2, lambda3 = problem.lambdas
    _require(lambda1 > 0 or not any(b.whole), "dual.b: must be 0 where lambda1 is 0")
    slack = problem.rows(a).minus(b)
    unit = _power(slack.exponent)
    for j, entry in enumerate(slack.whole):
        _require(abs(entry) * unit <= lambda2, f"dual: |X a - b| exceeds lambda2 in row {j}")
    pull = problem.columns(b)
    for i, columns in enumerate(problem.modalities):
        part = pull.part(columns)
        _require(part.dot(part) <= lambda3**2, f"dual: ||X_i' b|| exceeds lambda3 in modality {i}")


def _dual_value(problem: _Problem, a: _Vector, b: _Vector) -> Fraction:
    coupling = b.dot(b) / (4 * problem.lambdas[0]) if any(b.whole) else Fraction(0)
    return -a.dot(problem.o) - a.dot(a) / 4 - coupling


def _objective(problem: _Problem, w: _Vector, u: _Vector) -> Fraction:
    """F(w, u), its square roots rounded up."""
    lambda1, lambda2, lambda3 = problem.lambdas
    p, q = problem.columns(w).minus(problem.o), problem.rows(u).minus(w)
    length = sum(map(abs, w.whole)) * _power(w.exponent)
    parts = (u.part(columns) for columns in problem.modalities)
    norms = sum((_root_up(part.dot(part)) for part in parts), Fraction(0))
    return p.dot(p) + lambda1 * q.dot(q) + lambda2 * length + lambda3 * norms


def _root_up(square: Fraction) -> Fraction:
    """The square root, exact where it is a short dyadic number, else rounded up."""
    size = square.numerator.bit_length() - square.denominator.bit_length()
    shift = max(0, ROOT_BITS + 1 - size // 2)
    scaled = square * 4**shift
    root = isqrt(scaled.numerator // scaled.denominator)
    return Fraction(root if root * root == scaled else root + 1, 2**shift)


def _read_problem(record: Any) -> _Problem:
    """Read the data, check them, and take their digest."""
    found = _keyed(record, "problem", ("n", "d", "modalities", "X", "o", *LAMBDAS))
    n, d = _whole(found["n"], "problem.n"), _whole(found["d"], "problem.d")
    _require(n >= 1 and d >= 1, "problem: n and d must be at least 1")
    rows = _listed(found["X"], "problem.X", n)
    X = [_doubles(row, f"problem.X[{i}]", d) for i, row in enumerate(rows)]
    o = _doubles(found["o"], "problem.o", d)
    one, two, three = (_number(found[name], f"problem.{name}") for name in LAMBDAS)
    _require(min(one, two, three) >= 0, "problem: a lambda must not be negative")
    modalities = _read_modalities(found["modalities"], d)
    flat = _common([pair for row in X for pair in row])
    matrix = tuple(flat.whole[i * d : (i + 1) * d] for i in range(n))
    numbers = [text for row in rows for text in row] + found["o"] + [found[name] for name in LAMBDAS]
    digest = hashlib.sha256(SCHEMA.encode() + b"\0" + struct.pack("<3q", n, d, len(modalities)))
    digest.update(struct.pack(f"<{len(numbers)}d", *map(float.fromhex, numbers)))
    for columns in modalities:
        digest.update(struct.pack(f"<{len(columns) + 1}q", len(columns), *columns))
    return _Problem(matrix, flat.exponent, _common(o), modalities, (one, two, three), digest.hexdigest())


def _read_modalities(record: Any, d: int) -> tuple[tuple[int, ...], ...]:
    """Columns of each modality, given as sizes in order or one by one; a partition of 0 .. d-1."""
    _require(isinstance(record, dict) and bool(record), "problem.modalities: must be a non-empty object")
    explicit = any(isinstance(part, list) for part in record.values())
    groups: list[tuple[int, ...]] = []
    seen: set[int] = set()
    for name, part in record.items():
        place = f"problem.modalities[{name!r}]"
        if explicit:
            group = tuple(_whole(column, place) for column in _listed(part, place))
        else:
            size = _whole(part, place)
            _require(len(seen) + size <= d, f"{place}: there are only {d} columns")
            group = tuple(range(len(seen), len(seen) + size))
        _require(bool(group), f"{place}: is empty")
        for column in group:
            _require(column < d, f"{place}: there is no column {column}")
            _require(column not in seen, f"{place}: column {column} is given twice")
            seen.add(column)
        groups.append(group)
    _require(len(seen) == d, "problem.modalities: must cover every column")
    return tuple(groups)


def _parsed(data: bytes) -> Any:
    """JSON, strictly: no key twice, no NaN or infinity, no float that might have been rounded."""

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        record: dict[str, Any] = {}
        for key, entry in pairs:
            _require(key not in record, f"key {key!r} is given twice")
            record[key] = entry
        return record

    def refused(text: str) -> Any:
        raise Rejected(f"number {text[:40]}: numbers are hex floats in strings")

    try:
        text = data.decode("utf-8-sig")
        return json.loads(text, object_pairs_hook=once, parse_constant=refused, parse_float=refused)
    except (ValueError, RecursionError) as problem:
        raise Rejected(f"not JSON: {problem}") from None


def _require(condition: bool, reason: str) -> None:
    if not condition:
        raise Rejected(reason)


def _keyed(record: Any, place: str, keys: Iterable[str]) -> dict[str, Any]:
    _require(isinstance(record, dict), f"{place}: must be an object")
    expected = set(keys)
    for key in sorted(expected ^ set(record)):
        _require(key in record, f"{place}: key {key!r} is missing")
        _require(key in expected, f"{place}: key {key!r} is unknown")
    return dict(record)


def _listed(entries: Any, place: str, length: int | None = None) -> list[Any]:
    _require(isinstance(entries, list), f"{place}: must be a list")
    if length is not None:
        _require(len(entries) == length, f"{place}: must have {length} entries, has {len(entries)}")
    return list(entries)


def _whole(number: Any, place: str) -> int:
    _require(type(number) is int and 0 <= number < 2**62, f"{place}: must be an integer >= 0")
    return int(number)


Pair = tuple[int, int]
"""mantissa, exponent: mantissa * 2^exponent, the mantissa odd or 0."""


def exact_pair(text: Any, place: str) -> Pair:
    """Read a C99 hex float of any length; raises `Rejected`, with this place, where it is none."""
    found = HEX.fullmatch(text) if isinstance(text, str) and len(text) <= MOST_DIGITS else None
    if found is None:
        shown = repr(text[:40]) if isinstance(text, str) else type(text).__name__
        raise Rejected(f"{place}: must be a hex float in a string, not {shown}")
    sign, digits, places, shift = found[1], found[2], found[3] or "", int(found[4])
    _require(abs(shift) <= MOST_EXPONENT, f"{place}: the exponent is beyond {MOST_EXPONENT}")
    mantissa = int(digits + places, 16)
    zeros = max(0, (mantissa & -mantissa).bit_length() - 1)
    return (-1 if sign else 1) * (mantissa >> zeros), (shift - 4 * len(places) + zeros if mantissa else 0)


def _double(text: Any, place: str) -> Pair:
    """Read a hex float that is a finite float64 exactly."""
    mantissa, exponent = exact_pair(text, place)
    bits = mantissa.bit_length()
    fits = bits <= 53 and exponent >= -1074 and exponent + bits <= 1024
    _require(fits, f"{place}: {text[:40]} is no float64")
    return mantissa, exponent


def _number(text: Any, place: str) -> Fraction:
    mantissa, exponent = _double(text, place)
    return mantissa * _power(exponent)


def _doubles(entries: Any, place: str, length: int) -> list[Pair]:
    return [_double(text, f"{place}[{i}]") for i, text in enumerate(_listed(entries, place, length))]


def _vector(entries: Any, place: str, length: int) -> _Vector:
    pairs = [exact_pair(text, f"{place}[{i}]") for i, text in enumerate(_listed(entries, place, length))]
    ends = [(e, e + m.bit_length()) for m, e in pairs if m]
    span = max(high for _, high in ends) - min(low for low, _ in ends) if ends else 0
    _require(length * span <= MOST_BITS, f"{place}: not checked: beyond the limit of {MOST_BITS} bits")
    return _common(pairs)


def _common(pairs: Sequence[Pair]) -> _Vector:
    low = min((exponent for mantissa, exponent in pairs if mantissa), default=0)
    return _Vector(tuple(m << (e - low) if m else 0 for m, e in pairs), low)


def _power(exponent: int) -> Fraction:
    return Fraction(2) ** exponent
