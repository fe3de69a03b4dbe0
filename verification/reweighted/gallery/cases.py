"""All cases, by id."""

from verification.reweighted.gallery import medians, recognition, regression, selection
from verification.reweighted.gallery.case import Case

CASES: dict[str, Case] = {
    case.id: case for topic in (recognition, medians, regression, selection) for case in topic.CASES
}
