"""The plain data of a record of the experiments: what is measured on one set of pictures.

The JSON Schema of a record is made from these types and from `verification.experiments.record.contents`.
"""

from typing import Annotated, NotRequired, TypedDict

from verification.experiments.design import GRID, SETTINGS, STUDY_VIEWS, VIEWS
from verification.experiments.measure.configurations import FACTORS
from verification.experiments.scenes.pictures import OBSTRUCTIONS
from verification.ledger.claims import PARTS
from verification.ledger.surveys import SurveyOutcome, Tally
from verification.ledger.verdicts import WEAKEST_SURVEY_FIRST

Number = Annotated[float, {"type": "number"}]
Share = Annotated[float, {"type": "number", "minimum": 0, "maximum": 1}]
Size = Annotated[float, {"type": "number", "minimum": 0}]
Count = Annotated[int, {"minimum": 0}]
Positive = Annotated[int, {"minimum": 1}]
Maybe = Annotated[float | None, {"type": ["number", "null"]}]
Level = Annotated[str | float, {"type": ["string", "number"]}]
Outcomes = Annotated[list[Count], {"minItems": len(Tally._fields), "maxItems": len(Tally._fields)}]
"""Configurations by their outcome, as `Tally` has them."""

OF_SETTINGS = {"minItems": len(SETTINGS), "maxItems": len(SETTINGS)}
OF_VIEWS = {"minItems": VIEWS, "maxItems": VIEWS}
OF_GRID = {"minItems": len(GRID), "maxItems": len(GRID)}
OF_STUDY = {"minItems": STUDY_VIEWS, "maxItems": STUDY_VIEWS}
OF_FACTORS = {"propertyNames": {"enum": list(FACTORS)}, "required": sorted(FACTORS)}
SURVEYED = sorted(key for key, part in PARTS.items() if part.rule is not None)
VERDICTS = [verdict.value for verdict in reversed(WEAKEST_SURVEY_FIRST)]
OF_CLAIMS = {"propertyNames": {"enum": SURVEYED}, "required": SURVEYED}

BySetting = Annotated[list[Share], OF_SETTINGS]
ByViews = Annotated[list[Share], OF_VIEWS]
Accuracy = Annotated[list[ByViews], OF_SETTINGS]
"""By setting, then number of views."""
Grid = Annotated[list[Annotated[list[Share], OF_GRID]], OF_GRID]
"""By lambda2, then lambda3."""
ByLevel = dict[str, Share]
ByFactor = Annotated[dict[str, ByLevel], OF_FACTORS]


class Decided(TypedDict):
    """What one configuration says of a part of a claim, with the comparison that decides."""

    outcome: SurveyOutcome
    statistic: Maybe
    lower: Maybe
    upper: Maybe
    comparison: str
    comparisons: Positive
    above: Count
    units: Count
    left_out: Count


class Entry(TypedDict):
    """One configuration."""

    id: Annotated[str, {"pattern": "^r[0-9]{3}$"}]
    levels: Annotated[dict[str, Level], OF_FACTORS]
    claims: Annotated[dict[str, Decided], OF_CLAIMS]
    accuracy: Accuracy
    open: Accuracy
    baselines: dict[str, ByViews]
    grid: Grid
    chance: Share


class Counts(TypedDict):
    """All configurations for a part of a claim."""

    verdict: Annotated[str, {"enum": VERDICTS}]
    counts: Outcomes
    undefined: Count
    agreeing: Count
    factors: Annotated[dict[str, dict[str, Outcomes]], OF_FACTORS]


class Scored(TypedDict):
    """A mean score with its interval."""

    score: Share
    lower: Share
    upper: Share


class Cell(TypedDict):
    """Labels counted, and their mean score."""

    right: Count
    wrong: Count
    tie: Count
    undecided: Count
    score: Share


class CountedCell(Cell):
    """The same with an interval."""

    lower: Share
    upper: Share


class Rank(TypedDict):
    """Mean mutual information of the views of one rank, in bits, with its interval."""

    rank: Positive
    mean: Number
    lower: Number
    upper: Number


class Case(TypedDict):
    """One scene with all its weights."""

    scene: str
    object: str
    views: list[str]
    obstruction: list[Annotated[str, {"enum": list(OBSTRUCTIONS)}]]
    visible_share: list[Share]
    w: list[Number]
    u: NotRequired[list[Number]]
    modality_sizes: dict[str, Count]
    modality_norms: list[Size]


class StudyScene(TypedDict):
    """A scene of the case study."""

    scene: str
    object: str
    views: Annotated[list[str], OF_STUDY]
    w: Annotated[list[Number], OF_STUDY]
    good: Annotated[list[bool], OF_STUDY]
    visible_share: Annotated[list[Share], OF_STUDY]


class Detail(TypedDict):
    """The default configuration in full."""

    accuracy: Annotated[list[Annotated[list[CountedCell], OF_VIEWS]], OF_SETTINGS]
    explained: Annotated[list[Annotated[list[CountedCell], OF_VIEWS]], OF_SETTINGS]
    baselines: dict[str, Annotated[list[Scored], OF_VIEWS]]
    grid: Annotated[list[Annotated[list[Cell], OF_GRID]], OF_GRID]
    by_level: dict[str, BySetting]
    by_object: dict[str, BySetting]
    information: list[Rank]
    shares: ByLevel
    modalities: ByLevel
    case: Case
    case_study: list[StudyScene]


class Confusion(TypedDict):
    """Rows: the object; columns: the label; what is open is counted apart."""

    objects: list[str]
    counts: list[list[Count]]
    open: list[Count]


class Shortest(TypedDict):
    """Wrong labels, and those of them that are the reference of the smallest length."""

    wrong: Count
    shortest: Count


class Limits(TypedDict):
    """What all configurations together say of where the method goes wrong."""

    shortest: dict[str, Shortest]
    objective: ByLevel
    explained: ByLevel
    visible: dict[str, Maybe]
    accuracy: ByFactor
    open: ByFactor
    settings: BySetting
    settings_open: BySetting
    grid: Grid
    grid_open: Grid
    confusion: Confusion


Ranking = TypedDict(
    "Ranking",
    {
        "lambdas": Annotated[list[Number], {"minItems": 2, "maxItems": 2}],
        "visible": Maybe,
        "full": Count,
        "proved zero": Count,
        "negative": Share,
        "three": Share,
    },
)
"""The ranking of the views at one (lambda2, lambda3); see `verification.experiments.record.rankings`."""
