"""Pairs of a loss and a weight that are programs: what is measured of them in float64, without derivatives.

If weight(r) square'(r) = loss'(r), then by the mean value theorem, for 0 < s < t,

    (loss(t) - loss(s)) / (square(t) - square(s)) = weight(x) for some x between s and t;

where the weight jumps it lies between its least and largest value. So a secant outside the range of the
weight shows that the pair is not tangent. The range is that of samples; it is widened by itself, by
`TOLERANCE`, and by the rounding of loss and weight (see `sampling`), and a pair is accused only where three
secants of one window are on the same side, so that a jump of the loss at one point is not taken for a wrong
slope. A YES is a measurement, no proof.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from convexperc.errors import InputError
from verification.reweighted.answers import Answer, Answers, Word
from verification.reweighted.terms.dimensions import POWERS
from verification.reweighted.terms.expressions import exactly, half, signed_variable
from verification.reweighted.terms.judging import judge_term
from verification.reweighted.terms.sampling import (
    GRID,
    POINTS,
    ROUNDING,
    Function,
    Samples,
    callable_on_arrays,
    quiet,
    sampled,
    value_at,
)
from verification.reweighted.terms.term import SQUARES
from verification.reweighted.terms.units import unit_said

TOLERANCE = 1e-3
"""Two numbers are called different if they differ by more than this part of them, beyond rounding."""

FAR = 1e-9
"""Part of the weights within three octaves that is taken for 0 at the end of a weight."""

FEWEST = 20
"""Windows, or points, without which nothing is said."""

FAR_WINDOWS, OCTAVES = 40, 5
"""Windows beyond the last difference, and octaves below it, that tell a smoothing from another weight."""

PAIRS = slice(3, None, 8)
"""One window of each octave: these are compared with one another."""

NUMBERS = tuple(0.37 * 2.3**k for k in range(-9, 11))
"""Residuals at which a formula is compared with the function."""

SHIFTS = (10, -20)
"""Changes of unit that are tried, in octaves: by these powers of 2."""

WELL = 1e4
"""A loss is compared in two units where it is so many times its noise."""

EPSILON = float(np.finfo(float).eps)

ROOTED = "measured in float64"
Pair = tuple[Function, Function]
Make = Callable[[float], Pair]


@dataclass(frozen=True)
class MeasuredSide:
    """Loss and weight, sampled for residuals of one sign.

    Attributes
    ----------
    sign : {1, -1}
    loss, weight : Samples
    factor : float
        Of r**2 in the square.
    offset : float
        loss(0) if that is a finite number, else 0.
    """

    sign: float
    loss: Samples
    weight: Samples
    factor: float
    offset: float

    @cached_property
    def secants(self) -> tuple[np.ndarray, np.ndarray]:
        """Change of the loss by that of the square, for halves and whole of each window, and their noise."""
        last = POINTS - 1
        first, second = np.array([0, last // 2, 0]), np.array([last // 2, last, last])
        s, t = GRID[..., first], GRID[..., second]
        squares = self.factor * (t - s) * (t + s)
        values = self.loss.values
        with np.errstate(all="ignore"):
            found = (values[..., second] - values[..., first]) / squares
            return found, 2 * self.loss.noise[..., None] / squares

    @cached_property
    def ranges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Least and largest weight of each window, and the size of the weights about it."""
        least, largest = self.weight.values.min(axis=2), self.weight.values.max(axis=2)
        octaves = np.nan_to_num(np.maximum(np.abs(least), np.abs(largest))).max(axis=1)
        near = np.lib.stride_tricks.sliding_window_view(np.pad(octaves, 3), 7).max(axis=1)
        return least, largest, near[:, None]

    @cached_property
    def allowance(self) -> np.ndarray:
        """What two weights of a window may differ by without being called different."""
        least, largest, near = self.ranges
        size = np.maximum(np.abs(least), np.abs(largest))
        return np.asarray(TOLERANCE * size + FAR * near + self.weight.noise)

    def shown(self, index: Any) -> str:
        """A residual of this side."""
        return f"{self.sign * GRID[index]:.9g}"


def judge_functions(
    loss: Function,
    weight: Function,
    square: str = "r**2/2",
    *,
    signed: bool = False,
    make: Make | None = None,
    formula: bool = True,
    name: str = "",
) -> Answers:
    """Judge a loss and a weight that are programs.

    Parameters
    ----------
    loss, weight : callable
        Of one residual, or of an array of them; float64.
    square : {"r**2", "r**2/2"}
        What the weight multiplies in the loop.
    signed : bool
        Whether r may be negative; else it is a norm, and the functions are not asked about negative numbers.
    make : callable, optional
        ``make(width)`` returns loss and weight of another width, for the question ``units``.
    formula : bool
        Whether to call the functions with a symbol. Where they give a formula that agrees with them,
        `judge_term` decides, except that it accuses nothing that is not measured as well: numbers such as
        c**2 are rounded in the formula. It can take minutes.
    name : str

    Returns
    -------
    Answers
        ``tangent``, ``majorises``, ``sign``, ``at zero`` and ``units`` as of `judge_term`. The basis says
        whether an answer was measured; a YES that was measured is no proof.

    Raises
    ------
    InputError
        The square is another, or a function returns no numbers.

    Examples
    --------
    >>> import numpy as np
    >>> found = judge_functions(lambda r: np.log1p(r * r), lambda r: 1 / (1 + r * r), "r**2/2", formula=False)
    >>> found["tangent"].statement
    'The weight is 0.5 times the tangent one: the loop solves the problem with 0.5 times this term.'
    """
    if square not in SQUARES:
        raise InputError("square", value=square, must=f"must be one of {', '.join(SQUARES)}")
    with quiet():
        sides = _sides(loss, weight, float(SQUARES[square]), signed)
        tangent = _tangent(sides)
        answers = [
            tangent,
            _majorises(sides, tangent),
            _sign(sides),
            _at_zero(loss, weight),
            _units(sides[0], make),
        ]
    if formula:
        answers = _with_formula(answers, loss, weight, square=square, signed=signed)
    return Answers(name or f"{_called(loss)} and {_called(weight)} of {square}", tuple(answers))


def _called(function: Function) -> str:
    return getattr(function, "__name__", type(function).__name__)


def _sides(loss: Function, weight: Function, factor: float, signed: bool) -> tuple[MeasuredSide, ...]:
    found = []
    for sign in (1.0, -1.0) if signed else (1.0,):
        of_loss, of_weight = (callable_on_arrays(each, sign) for each in (loss, weight))
        zero = value_at(loss, 0.0)
        offset = zero if not isinstance(zero, str) and np.isfinite(zero) else 0.0
        samples = sampled(of_loss, sign, "change"), sampled(of_weight, sign, "value")
        found.append(MeasuredSide(sign, *samples, factor, offset))
    return tuple(found)


def _tangent(sides: tuple[MeasuredSide, ...]) -> Answer:
    hidden, worst, smoothing = list[float](), None, True
    for side in sides:
        secants, noise = side.secants
        least, largest, _ = side.ranges
        widened = (largest - least + side.allowance)[..., None]
        above = (secants - noise - largest[..., None] - widened).min(axis=2)
        below = (least[..., None] - widened - secants - noise).min(axis=2)
        outside = np.maximum(above, below)
        with np.errstate(all="ignore"):
            size = np.maximum(np.maximum(np.abs(least), np.abs(largest)), np.abs(secants[..., 2]))
            usable = np.isfinite(outside) & (noise[..., 0] <= 0.1 * np.where(size > 0, size, 1.0))
            share = np.where(usable & (outside > 0), outside / size, 0.0)
            hidden += (noise[..., 0] / size)[usable & (size > 0)].tolist()
        smoothing = smoothing and _is_smoothing(side, share > 0, usable)
        if share.max() > 0 and (worst is None or share.max() > worst[0]):
            worst = share.max(), side, np.unravel_index(_plain(share, GRID[..., 0]), share.shape)
    if worst is not None:
        return replace(_not_tangent(sides, worst[1], worst[2]), fault=not smoothing)
    if len(hidden) < FEWEST:
        said = "Too few residuals have a finite loss and weight that rounding does not hide."
        return Answer("tangent", Word.UNDECIDED, said, f"{ROOTED}: {len(hidden)} windows")
    limit = max(TOLERANCE, sorted(hidden)[FEWEST - 1])
    judged = sum(share <= limit for share in hidden)
    said = f"No difference between the slopes of loss and weighted square at {judged} residuals."
    if limit > TOLERANCE:
        said = f"{said[:-1]}; rounding may hide {limit:.2g} of the slope there."
    return Answer("tangent", Word.YES, said, _measured("secants against weights"))


def _is_smoothing(side: MeasuredSide, wrong: np.ndarray, usable: np.ndarray) -> bool:
    """Whether the weight differs near 0 alone, where it is bounded and the tangent one of a kink is not."""
    if not wrong.any():
        return True
    r, secants = GRID[..., 0], side.secants[0][..., 2]
    beyond = usable & (r > r[wrong].max())
    near = np.flatnonzero((wrong & usable & (secants > 0)).any(axis=1))
    if beyond.sum() < FAR_WINDOWS or near.size < OCTAVES:
        return False
    first, later = near[0], near[OCTAVES - 1]
    grows = (
        secants[first][usable[first]].max() > 2.0 ** (later - first - 1) * secants[later][usable[later]].max()
    )
    bounded = side.ranges[1][first].max() <= (1 + 1e-2) * side.ranges[1][later].max()
    return bool(grows and bounded)


def _plain(shares: np.ndarray, r: np.ndarray) -> int:
    """Of the places that show at least half of the greatest difference, the one with r nearest to 1."""
    far = np.broadcast_to(np.abs(np.log(r)), shares.shape)
    return int(np.argmin(np.where(shares >= shares.max() / 2, far, np.inf)))


def _measured(what: str) -> str:
    allowed = f"rounding and {TOLERANCE:g} of the weight are allowed"
    return f"{ROOTED}, not proved: {what}, from 1e-12 to 1e12; {allowed}"


def _not_tangent(sides: tuple[MeasuredSide, ...], side: MeasuredSide, where: Any) -> Answer:
    factor = _factor(sides)
    said = (
        "The weighted square has another slope than the loss at r_i."
        if factor is None
        else f"The weight is {factor:.4g} times the tangent one: the loop solves the problem with"
        f" {factor:.4g} times this term."
    )
    least, largest, _ = side.ranges
    shown = {
        "r from": side.shown((*where, 0)),
        "r to": side.shown((*where, POINTS - 1)),
        "weights": f"{least[where]:.9g} to {largest[where]:.9g}",
        "secant of the loss by the square": f"{side.secants[0][where][2]:.9g}",
    }
    return Answer("tangent", Word.NO, said, _measured("a secant outside the weights"), shown, fault=True)


def _factor(sides: tuple[MeasuredSide, ...]) -> float | None:
    """weight / secant, if it is one number wherever both are known well."""
    ratios = []
    for side in sides:
        secants, noise = side.secants
        least, largest, _ = side.ranges
        whole, unsure = secants[..., 2], noise[..., 2]
        known = unsure < 1e-2 * TOLERANCE * np.maximum(np.abs(whole), np.abs(largest))
        known &= (side.weight.noise < 1e-2 * TOLERANCE * np.abs(largest)) | (whole != 0)
        known &= (largest - least) <= 0.01 * np.abs(largest)
        ratios.append((least + largest)[known] / 2 / whole[known])
    found = np.concatenate(ratios)
    if found.size < FEWEST:
        return None
    middle = float(np.median(found))
    if not np.isfinite(middle) or middle == 0 or abs(middle - 1) <= TOLERANCE:
        return None
    return middle if np.all(np.abs(found - middle) <= TOLERANCE * abs(middle)) else None


def _majorises(sides: tuple[MeasuredSide, ...], tangent: Answer) -> Answer:
    for side in sides:
        found = _rises(side)
        if found is not None:
            return found
    if len(sides) > 1:
        found = _unlike_sides(*sides)
        if found is not None:
            return found
    points = sum(int(np.isfinite(side.weight.values).sum()) for side in sides)
    if points < FEWEST * POINTS:
        return Answer(
            "majorises", Word.UNDECIDED, "Too few weights are finite.", f"{ROOTED}: {points} points"
        )
    if tangent.word is Word.YES:
        found = _below(sides)
        if found is not None:
            return found
    said = f"The weight was not seen to rise with |r| at {points} points."
    return Answer("majorises", Word.YES, said, _measured("weights in order of |r|"))


def _rises(side: MeasuredSide) -> Answer | None:
    """A window whose weights all lie above all of a window nearer to 0."""
    least, largest = (each.ravel() for each in side.ranges[:2])
    allowed = side.allowance.ravel()
    before = np.where(np.isfinite(largest), largest + allowed, np.inf)
    nearest = np.minimum.accumulate(before)
    excess = np.where(np.isfinite(least), least - allowed, -np.inf)[1:] - nearest[:-1]
    if not (excess > 0).any():
        return None
    share = np.where(excess > 0, excess / np.where(least[1:] == 0, np.inf, np.abs(least[1:])), 0.0)
    high = _plain(share + (excess > 0) * 1e-300, GRID[..., 0].ravel()[1:]) + 1
    low = int(np.argmin(before[:high]))
    places: list[Any] = [(*np.unravel_index(each, side.allowance.shape), 0) for each in (low, high)]
    shown = {
        "r": side.shown(places[0]),
        "weight": f"{side.weight.values[places[0]]:.9g}",
        "larger r": side.shown(places[1]),
        "weight there": f"{side.weight.values[places[1]]:.9g}",
    }
    said = (
        "The weight rises with |r|: its square, made at the smaller one, lies below what it descends beyond."
    )
    return Answer("majorises", Word.NO, said, _measured("two windows of weights"), shown, fault=True)


def _unlike_sides(right: MeasuredSide, left: MeasuredSide) -> Answer | None:
    """The weights at r and -r: where they differ, the square from one of them lies below at the other."""
    allowed = right.allowance + left.allowance
    apart = np.maximum(right.ranges[0] - left.ranges[1], left.ranges[0] - right.ranges[1]) - allowed
    apart = np.where(np.isfinite(apart), apart, -np.inf)
    if apart.max() <= 0:
        return None
    size = np.maximum.reduce([np.abs(each) for side in (right, left) for each in side.ranges[:2]])
    share = np.where(apart > 0, apart / np.where(size == 0, np.inf, size), 0.0)
    where: Any = (*np.unravel_index(_plain(share, GRID[..., 0]), share.shape), 0)
    shown = {
        "r": right.shown(where),
        "weight": f"{right.weight.values[where]:.9g}",
        "-r": left.shown(where),
        "weight there": f"{left.weight.values[where]:.9g}",
    }
    said = "The weight differs at r and -r: the square from one lies below what it descends at the other."
    return Answer("majorises", Word.NO, said, _measured("weights at r and -r"), shown, fault=True)


def _below(sides: tuple[MeasuredSide, ...]) -> Answer | None:
    """A pair (s, t) with loss(t) > loss(s) + weight(s) (square(t) - square(s)) beyond rounding."""
    for here in sides:
        for there in sides:
            r, t = GRID[..., 0].ravel()[PAIRS][:, None], GRID[..., 0].ravel()[PAIRS][None, :]
            before, after = (each.loss.values[..., 0].ravel()[PAIRS] for each in (here, there))
            unsure = [each.noise.ravel()[PAIRS] for each in (here.loss, there.loss, here.weight)]
            weight = here.weight.values[..., 0].ravel()[PAIRS]
            squares = here.factor * (t - r) * (t + r)
            with np.errstate(all="ignore"):
                rise, told = after[None, :] - before[:, None], weight[:, None] * squares
                allowed = unsure[0][:, None] + unsure[1][None, :] + unsure[2][:, None] * np.abs(squares)
                excess = rise - told - allowed - TOLERANCE * (np.abs(rise) + np.abs(told))
                excess = np.where(np.isfinite(excess), excess, -np.inf)
                share = np.where(excess > 0, excess / (np.abs(rise) + np.abs(told)), 0.0)
            if share.max() <= 0:
                continue
            i, k = np.unravel_index(_plain(share, r), share.shape)
            shown = {
                "r_i": f"{here.sign * r[i, 0]:.9g}",
                "r": f"{there.sign * t[0, k]:.9g}",
                "square": f"{before[i] + told[i, k]:.9g}",
                "loss": f"{after[k]:.9g}",
            }
            said = "The weighted square made at r_i lies below the loss at r."
            return Answer("majorises", Word.NO, said, _measured("pairs of residuals"), shown, fault=True)
    return None


def _sign(sides: tuple[MeasuredSide, ...]) -> Answer:
    points = 0
    for side in sides:
        _, largest, _ = side.ranges
        below = np.where(np.isfinite(largest), -largest - side.allowance, -np.inf)
        points += int(np.isfinite(side.weight.values).sum())
        if below.max() > 0:
            where: Any = (*np.unravel_index(_plain((below > 0) * 1.0, GRID[..., 0]), below.shape), 0)
            shown = {"r": side.shown(where), "weight": f"{side.weight.values[where]:.9g}"}
            said = "The weight is negative: a square with it has no minimum of its own."
            return Answer("sign", Word.NO, said, _measured("a window of weights"), shown, fault=True)
    if points < FEWEST * POINTS:
        return Answer("sign", Word.UNDECIDED, "Too few weights are finite.", f"{ROOTED}: {points} points")
    said = f"The weight was not seen to be negative at {points} points."
    return Answer("sign", Word.YES, said, _measured("weights"))


def _at_zero(loss: Function, weight: Function) -> Answer:
    """What the functions return at exactly 0, and next to it."""
    found = {
        f"{what}({at:g})": value_at(each, at) for what, each in (("weight", weight),) for at in (0.0, 1e-300)
    }
    found["loss(0)"] = value_at(loss, 0.0)
    told = [
        f"{place} raises {value}" if isinstance(value, str) else f"{place} is {value:.9g}"
        for place, value in found.items()
    ]
    bad = [value for value in found.values() if isinstance(value, str) or not np.isfinite(value)]
    word = Word.NO if bad else Word.YES
    shown = {place: value if isinstance(value, str) else repr(value) for place, value in found.items()}
    return Answer("at zero", word, "; ".join(told) + ".", "called at 0 and at 1e-300", shown if bad else {})


def _units(side: MeasuredSide, make: Make | None) -> Answer:
    """By which power of the unit a width must follow so that the loss is the same up to a factor."""
    stated, shown = None, dict[str, str]()
    start = side if make is None else _sides(*make(1.0), side.factor, signed=False)[0]
    for power in POWERS if make is not None else (None,):
        fits = []
        for shift in SHIFTS:
            moved = (
                start
                if make is None
                else _sides(*make(2.0 ** float(shift * (power or 0))), side.factor, False)[0]
            )
            fits.append(_follows(start, moved, shift))
        if not all(fit.loss for fit in fits):
            continue
        wrong = [fit.weight for fit in fits if fit.weight]
        if not wrong:
            said = unit_said(power, "" if power is None else "the width")
            return Answer("units", Word.YES, said, _measured("losses and weights in other units"))
        if stated is None:
            stated, shown = power, dict(wrong[0])
    if shown:
        said = "In another unit of r the loss is the same up to a factor, and the weight is not."
        return Answer(
            "units", Word.NO, said, _measured("losses and weights in other units"), shown, fault=True
        )
    said = "No other width was given, and another unit changes the loss: the question does not arise."
    if make is not None:
        said = "The loss has numbers of its own unit, so that the question does not arise."
    return Answer("units", Word.UNDECIDED, said, f"{ROOTED}: losses in other units")


@dataclass(frozen=True)
class _Fit:
    """Whether the loss is the same up to a factor, and numbers that show that the weight is not."""

    loss: bool
    weight: Mapping[str, str]


def _follows(start: MeasuredSide, moved: MeasuredSide, shift: int) -> _Fit:
    """Compare a pair at r with one at 2**shift r."""
    here = slice(max(0, -shift), min(0, -shift) or None)
    there = slice(max(0, shift), min(0, shift) or None)
    raised, known = [], []
    for side, octaves in ((start, here), (moved, there)):
        values = side.loss.values[octaves, :, 0] - side.offset
        raised.append(values)
        known.append(
            np.abs(values) > WELL * (side.loss.noise[octaves] + ROUNDING * EPSILON * abs(side.offset))
        )
    with np.errstate(all="ignore"):
        ratio = raised[1] / raised[0]
        compared = known[0] & known[1] & np.isfinite(ratio) & (raised[0] != 0) & (raised[1] != 0)
        if compared.sum() < FEWEST:
            return _Fit(False, {})
        middle = np.median(ratio[compared])
        if not np.all(np.abs(ratio[compared] - middle) <= TOLERANCE * abs(middle)):
            return _Fit(False, {})
        before, after = start.weight.values[here, :, 0], moved.weight.values[there, :, 0]
        by = middle / 4.0**shift
        allowed = moved.allowance[there] + abs(by) * start.allowance[here]
        apart = np.where(
            compared & np.isfinite(after - by * before), np.abs(after - by * before) - allowed, -np.inf
        )
    if apart.max() <= 0:
        return _Fit(True, {})
    where = np.unravel_index(int(apart.argmax()), apart.shape)
    return _Fit(
        True,
        {
            "r": f"{GRID[here, :, 0][where]:.9g}",
            "weight": f"{before[where]:.9g}",
            "r in the other unit": f"{GRID[there, :, 0][where]:.9g}",
            "weight that follows": f"{by * before[where]:.9g}",
            "weight there": f"{after[where]:.9g}",
        },
    )


def _with_formula(
    answers: list[Answer], loss: Function, weight: Function, square: str, signed: bool
) -> list[Answer]:
    """Those of `judge_term` where the functions give formulas and no measurement contradicts."""
    formulas = [_formula(each, signed) for each in (loss, weight)]
    if None in formulas:
        return answers
    try:
        exact = judge_term(formulas[0], formulas[1], square=square, signed=signed)
    except (InputError, NotImplementedError):
        return answers
    return [_joined(each, exact) for each in answers]


def _formula(function: Function, signed: bool) -> Any:
    """The function as an expression of r with rational numbers; None if it gives none that agrees with it."""
    try:
        found = function(signed_variable())
    except Exception:  # a foreign function may raise anything for a symbol
        return None
    if not isinstance(found, sp.Expr) or found.free_symbols - {signed_variable()}:
        return None
    found = found.xreplace({each: exactly(float(each)) for each in found.atoms(sp.Float)})
    for sign in (1, -1) if signed else (1,):
        one_side = half(found, negative=sign < 0)
        for number in NUMBERS:
            value = value_at(function, sign * number)
            meant = one_side.subs({each: exactly(number) for each in one_side.free_symbols}).evalf(30)
            if isinstance(value, str) or not meant.is_real:
                return None
            if not abs(value - float(meant)) <= 1e-9 * max(abs(value), abs(float(meant))):
                return None
    return found


def _joined(measured: Answer, exact: Answers) -> Answer:
    """One answer of two: the exact one unless what was measured contradicts it."""
    if measured.question == "at zero":
        return measured
    proved = exact[measured.question]
    if proved.word is measured.word or (proved.word is Word.YES and measured.word is Word.UNDECIDED):
        return replace(
            proved, basis=f"{proved.basis}, of the formulas that the functions return for a symbol"
        )
    if measured.word is Word.YES and proved.word is Word.NO:
        return replace(
            measured, basis=f"{measured.basis}; the formula, with rounded numbers, differs by less"
        )
    return measured
