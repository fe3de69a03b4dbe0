"""Is the lowest optimum low enough? Objects are accepted by thresholds that labelled scenes have set.

What is proved of the optima says nothing of whether the features tell the objects apart, or whether the
object is known at all. A calibration answers that with a stated coverage. For a scene of object y it takes

    excess   c_y / min_j c_j - 1           how much more y costs than the best object
    share    F*_y / ||o_y||^2              how much of y's template the views leave unexplained

and keeps, of each, the ceil((m + 1)(1 - alpha / 2))-th smallest of m scenes. An object is accepted where both
of its scores are at most that. If new scenes of known objects are drawn as the labelled ones were, the true
object is among those accepted with probability >= 1 - alpha, over the draw of all of them together. Nothing
is promised for objects that are not in the library: what share of them is refused has to be measured.

Source: Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World (2005), chapter 2; two conformal
predictors at alpha / 2 each are joined by the union bound.
"""

import bisect
import functools
import hashlib
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from convexperc.errors import CalibrationError, InputError, check_type, entries, is_one_of
from convexperc.files import placed, read_json
from convexperc.problem.arrays import BLOCK, nonnegative_number
from convexperc.problem.library import TemplateLibrary
from convexperc.recognition.decision import Decision
from convexperc.recognition.recognition import Recognition

SCHEMA = "convexperc/calibration/1"
LARGEST = 1.7976931348623157e308
"""The largest number of float64."""


class Origin(Enum):
    """What set the thresholds."""

    LABELLED = "labelled scenes"
    """Scenes whose object somebody has named."""
    HELD_OUT = "held-out references"
    """Scenes made of the references; see `convexperc.recognition.held_out_scenes`."""


class Acceptance(Enum):
    """What a calibration says of a recognition."""

    RECOGNISED = "recognised"
    """One object is accepted."""
    AMBIGUOUS = "ambiguous"
    """Several are."""
    UNKNOWN = "unknown"
    """None is."""


@dataclass(frozen=True)
class Judgement:
    """A recognition by a calibration.

    Attributes
    ----------
    acceptance : Acceptance
    accepted : tuple of str
        The objects that are accepted, in the order of their costs.
    reason : str
    """

    acceptance: Acceptance
    accepted: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Scores:
    """Proved bounds of the scores of one object in one scene: (lower, upper) each."""

    excess: tuple[float, float]
    share: tuple[float, float]


@dataclass(frozen=True)
class Calibration:
    """Thresholds, and for what they hold.

    Attributes
    ----------
    coverage : float
        1 - alpha, in (0, 1).
    scenes : int
        Scenes that set them.
    excess, share : float
        The largest accepted scores; infinite where there were too few scenes to set one.
    lambdas : (float, float, float)
    decision : Decision
    library : str
        `library_digest` of the known objects. `judge` takes no other lambdas, decision or library.
    views : (int, int)
        Least and greatest number of views of a scene.
    origin : Origin
    """

    coverage: float
    scenes: int
    excess: float
    share: float
    lambdas: tuple[float, float, float]
    decision: Decision
    library: str
    views: tuple[int, int]
    origin: Origin = Origin.LABELLED

    @classmethod
    def of(
        cls,
        labelled: Iterable[tuple[Recognition, str]],
        coverage: Any = 0.9,
        held_out_of: TemplateLibrary | None = None,
    ) -> "Calibration":
        """Set the thresholds.

        Parameters
        ----------
        labelled : iterable of (Recognition, str)
            A recognition with ``prune=False`` of each scene, and the object that it really shows.
        coverage : float
            In (0, 1).
        held_out_of : TemplateLibrary, optional
            The library of which `held_out_scenes` made the scenes. Without it they are labelled scenes, and
            all of one library.

        Raises
        ------
        CalibrationError
            No scene, a coverage out of range, an object that is not known, or different lambdas, decisions or
            libraries.
        """
        wanted = _coverage(coverage)
        check_type(held_out_of, (TemplateLibrary, type(None)), "held_out_of", CalibrationError)
        settings, excess, share, views = None, list[float](), list[float](), list[int]()
        for found, truth in _scenes(labelled):
            given = _settings(found, held_out_of)
            settings = given if settings is None else settings
            if given != settings:
                here, there = _differences(given, settings)
                must = f"must be recognised with {there}, as the first one"
                raise CalibrationError("a scene", value=here, must=must)
            views.append(len(found.views))
            every = scores(found)
            if truth not in every:
                must = f"must be one of the known objects, {', '.join(every)}"
                raise CalibrationError("the object of a scene", value=truth, must=must)
            excess.append(every[truth].excess[1])
            share.append(every[truth].share[1])
        if settings is None:
            raise CalibrationError("scenes", value=0, must="must be at least one")
        level = 1.0 - (1.0 - wanted) / 2.0
        lambdas, decision, library = settings
        origin = Origin.LABELLED if held_out_of is None else Origin.HELD_OUT
        return cls(
            wanted, len(excess), _quantile(excess, level), _quantile(share, level), lambdas, decision,
            library, (min(views), max(views)), origin,
        )  # fmt: skip

    def judge(self, found: Recognition) -> Judgement:
        """Which objects are accepted; one whose bounds leave it open is.

        Raises
        ------
        CalibrationError
            Other lambdas, another decision, or another library.
        """
        check_type(found, Recognition, "found", CalibrationError)
        own, given = (self.lambdas, self.decision, self.library), _settings(found, None)
        if given != own:
            here, there = _differences(given, own)
            must = f"must be made with {there}, as the calibration was"
            remedy = "Calibrate again for these."
            raise CalibrationError("the recognition", value=here, must=must, remedy=remedy)
        every = scores(found)
        near = [name for name, each in every.items() if each.excess[0] <= self.excess]
        accepted = tuple(name for name in near if every[name].share[0] <= self.share)
        least, most = self.views
        more = f"calibrated with {least}" + (f" to {most}" if most > least else "")
        more = "" if least <= len(found.views) <= most else f"; {more} views, these are {len(found.views)}"
        if len(accepted) == 1:
            return Judgement(Acceptance.RECOGNISED, accepted, f"it alone is accepted{more}")
        if math.isinf(self.share):
            more = f"; the calibration had too few scenes to refuse any{more}"
        if accepted:
            return Judgement(Acceptance.AMBIGUOUS, accepted, f"{len(accepted)} objects are accepted{more}")
        left = 100.0 * min(every[name].share[0] for name in near)
        said = f"the views leave {left:.2f} % of the best template unexplained"
        reason = f"{said}, more than the {100.0 * self.share:.2f} % that are accepted{more}"
        return Judgement(Acceptance.UNKNOWN, (), reason)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values; an infinite threshold is null."""
        return {
            "schema": SCHEMA,
            "coverage": self.coverage,
            "scenes": self.scenes,
            "excess": None if math.isinf(self.excess) else self.excess,
            "share": None if math.isinf(self.share) else self.share,
            "lambdas": list(self.lambdas),
            "decision": self.decision.value,
            "library": self.library,
            "views": list(self.views),
            "origin": self.origin.value,
        }

    @classmethod
    def from_dict(cls, record: object) -> "Calibration":
        """Return the calibration that `to_dict` wrote.

        Raises
        ------
        CalibrationError
            A key is unknown or missing, or a value is invalid.
        """
        keys = {
            "schema", "coverage", "scenes", "excess", "share", "lambdas", "decision", "library", "views",
            "origin",
        }  # fmt: skip
        if (
            not isinstance(record, Mapping)
            or set(record) != keys
            or not is_one_of(record["schema"], (SCHEMA,))
        ):
            must = f"must be a mapping with schema {SCHEMA!r} and exactly the keys {', '.join(sorted(keys))}"
            raise CalibrationError("calibration", value=record, must=must)
        limits = {name: math.inf if record[name] is None else record[name] for name in ("excess", "share")}
        numbers = {**limits, "coverage": record["coverage"]}
        lambdas = record["lambdas"]
        numbers |= {
            f"lambda{i}": each for i, each in enumerate(lambdas if isinstance(lambdas, list) else [], 1)
        }
        for name, value in numbers.items():
            if name in limits and record[name] is None:
                continue
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= LARGEST:
                raise CalibrationError(name, value=value, must="must be a number >= 0 that float64 holds")
        count = record["scenes"]
        if len(numbers) != 6 or type(count) is not int or count < 1 or not 0.0 < numbers["coverage"] < 1.0:
            must = "must have three lambdas, at least one scene, and a coverage between 0 and 1"
            raise CalibrationError("calibration", value=record, must=must)
        one, two, three = map(float, lambdas)
        thresholds = float(limits["excess"]), float(limits["share"])
        decision, origins = Decision.of(record["decision"]), [origin.value for origin in Origin]
        if not is_one_of(record["origin"], origins):
            raise CalibrationError("origin", value=record["origin"], must=f"must be one of {origins}")
        origin, views, library = Origin(record["origin"]), record["views"], record["library"]
        if not isinstance(views, list) or [type(each) for each in views] != [int, int] or views[0] < 1:
            raise CalibrationError("views", value=views, must="must be two integers >= 1")
        if not isinstance(library, str):
            raise CalibrationError("library", value=library, must="must be the digest of a library")
        return cls(
            float(numbers["coverage"]),
            count,
            *thresholds,
            (one, two, three),
            decision,
            library,
            (views[0], views[1]),
            origin,
        )


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Read a calibration from a JSON file in the format of `Calibration.to_dict`.

    Raises
    ------
    FileFormatError
        The file is not readable or not JSON, or `Calibration.from_dict` refuses it.
    """
    file, record = read_json(path)
    try:
        return Calibration.from_dict(record)
    except InputError as error:
        raise placed(file, error) from None


@dataclass(frozen=True)
class Counts:
    """How labelled scenes fare.

    Attributes
    ----------
    known, accepted, recognised, wrong : int
        Scenes of known objects; those whose object is accepted; those of which one object is, and those of
        these of which it is another one.
    unknown, refused, claimed : int
        Scenes of objects that are not known; those of which no object is accepted, and one.
    strangers : tuple of str
        Names of these objects.
    """

    known: int
    accepted: int
    recognised: int
    wrong: int
    unknown: int
    refused: int
    claimed: int
    strangers: tuple[str, ...] = ()


def calibrated(
    labelled: Sequence[tuple[Recognition, str]], coverage: Any = 0.9
) -> tuple[Calibration, Counts]:
    """Set the thresholds by the scenes of known objects, and count how all scenes fare.

    Each scene of a known object is judged by the thresholds of all others.

    Raises
    ------
    CalibrationError
        See `Calibration.of`.
    """
    labelled = list(_scenes(labelled))
    known = [(found, truth) for found, truth in labelled if truth in found.objects]
    made, judged = Calibration.of(known, coverage), []
    for found, truth in labelled:
        others = [pair for pair in known if pair[0] is not found]
        judge = Calibration.of(others, coverage) if others and len(others) < len(known) else made
        judged.append((judge.judge(found), truth, truth in found.objects))
    return made, _counts(judged)


def counted(made: Calibration, labelled: Iterable[tuple[Recognition, str]]) -> Counts:
    """Count how labelled scenes fare that have not set the thresholds."""
    check_type(made, Calibration, "calibration", CalibrationError)
    return _counts([(made.judge(found), truth, truth in found.objects) for found, truth in _scenes(labelled)])


def _scenes(labelled: Iterable[tuple[Recognition, str]]) -> Iterator[tuple[Recognition, str]]:
    """Each scene, checked."""
    for given in entries(labelled, "scenes", CalibrationError):
        scene: Any = given
        kinds = [type(part) for part in scene] if isinstance(scene, (tuple, list)) else []
        if len(kinds) != 2 or not issubclass(kinds[0], Recognition) or not issubclass(kinds[1], str):
            must = "must be a Recognition and the name of the object that it shows"
            raise CalibrationError("a scene", value=scene, must=must)
        yield given


def _counts(judged: Sequence[tuple[Judgement, str, bool]]) -> Counts:
    """Of judgements with the true object and whether it is known."""
    known = [(each.accepted, truth) for each, truth, is_known in judged if is_known]
    unknown = [each.acceptance for each, _, is_known in judged if not is_known]
    strangers = tuple(dict.fromkeys(truth for _, truth, is_known in judged if not is_known))
    alone = [(names, truth) for names, truth in known if len(names) == 1]
    return Counts(
        len(known), sum(truth in names for names, truth in known), len(alone),
        sum(truth not in names for names, truth in alone), len(unknown), unknown.count(Acceptance.UNKNOWN),
        unknown.count(Acceptance.RECOGNISED), strangers,
    )  # fmt: skip


def scores(found: Recognition) -> dict[str, Scores]:
    """Bound the scores of every object, in the order of their costs.

    Parameters
    ----------
    found : Recognition
        Best of ``prune=False``: what was given up early is bounded only as far as the label needed.
    """
    (lower, upper), left = found.costs, found.unexplained
    owners, objects = found.answers.data.library.owners, found.objects
    least = float(lower.min()), float(upper.min())
    every = []
    for place, name in enumerate(objects):
        own = owners == place
        low, high = float(lower[own].min()), float(upper[own].min())
        excess = _excess(low, least[1], -math.inf), _excess(high, least[0], math.inf)
        share = float(left[0][own].min()), float(left[1][own].min())
        every.append((high, name, Scores(excess, share)))
    return {name: each for _, name, each in sorted(every, key=lambda entry: entry[0])}


def _excess(cost: float, least: float, way: float) -> float:
    """cost / least - 1, rounded in a direction, >= 0; infinite where it is not known."""
    if cost <= least:
        return 0.0
    if least == 0.0:
        return math.inf
    share = math.nextafter(cost / least, way)
    return max(0.0, math.nextafter(share - 1.0, way))


@functools.lru_cache(maxsize=4)
def library_digest(library: TemplateLibrary) -> str:
    """SHA-256 of the names, objects, modalities and numbers of a library, in hexadecimal.

    The order of the references makes no difference.
    """
    order = sorted(range(len(library.names)), key=library.names.__getitem__)
    names = [[library.names[j], library.shown[j]] for j in order]
    places = np.arange(library.modalities.d)
    parts = [list(library.modalities.names), [places[columns].tolist() for columns in library.modalities]]
    found = hashlib.sha256(json.dumps([names, parts]).encode())
    O = library.O  # noqa: E741 - the paper's symbol
    step = max(1, BLOCK // (8 * O.shape[0]))
    for first in range(0, len(order), step):
        part = np.asarray(O[:, order[first : first + step]], dtype="<f8")
        found.update(np.ascontiguousarray(part.T + 0.0).tobytes())  # -0 is 0
    return found.hexdigest()


Settings = tuple[tuple[float, float, float], Decision, str]
"""Lambdas, decision, and digest of the library."""


def _settings(found: Recognition, library: TemplateLibrary | None) -> Settings:
    digest = library_digest(found.answers.data.library if library is None else library)
    return found.answers.lambdas, found.decision, digest


def _differences(given: Settings, own: Settings) -> tuple[str, str]:
    """What of two settings differs, as the one and as the other has it."""
    told = zip(_told(given), _told(own), strict=True)
    here, there = zip(*((mine, other) for mine, other in told if mine != other), strict=True)
    return ", ".join(here), ", ".join(there)


def _told(settings: Settings) -> tuple[str, ...]:
    lambdas, decision, library = settings
    said = (f"lambda{i} = {value!r}" for i, value in enumerate(lambdas, 1))
    return (*said, f"decided by {decision.value}", f"library {library}")


def fewest_scenes(coverage: float) -> int:
    """The least number of scenes that sets thresholds: 2 / (1 - coverage) - 1, rounded up.

    Raises
    ------
    CalibrationError
        The coverage is no number between 0 and 1.
    """
    wanted, enough = _coverage(coverage), 1
    level = 1.0 - (1.0 - wanted) / 2.0

    def suffices(count: int) -> bool:
        return math.ceil((count + 1) * level) <= count

    while not suffices(enough):
        enough *= 2
    return bisect.bisect_left(range(enough), True, lo=1, key=suffices)


def _coverage(value: Any) -> float:
    """The coverage as a float, if it is one."""
    wanted = nonnegative_number(value, "coverage", error=CalibrationError)
    if not 0.0 < wanted < 1.0:
        raise CalibrationError("coverage", value=value, must="must be a number between 0 and 1")
    return wanted


def _quantile(values: list[float], level: float) -> float:
    """The ceil((m + 1) level)-th smallest of m values; infinity beyond the last."""
    place = math.ceil((len(values) + 1) * level)
    return sorted(values)[place - 1] if place <= len(values) else math.inf
