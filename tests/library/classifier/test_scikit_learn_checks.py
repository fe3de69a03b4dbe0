"""scikit-learn's own checks of an estimator, for several settings."""

from collections.abc import Iterator
from typing import Any

import pytest
from sklearn.utils.estimator_checks import estimator_checks_generator

from convexperc.classifier import MultiViewClassifier

pytestmark = [
    # labels that are not proved are warned about: the checks make ties, such as samples that are all the same
    pytest.mark.filterwarnings("ignore::convexperc.classifier.UnprovedLabelWarning"),
    # what a check ignores by itself when pytest does not make errors of warnings
    pytest.mark.filterwarnings("default::sklearn.exceptions.SkipTestWarning"),
]


class HeldToAnAccuracy(MultiViewClassifier):
    """Held to more than 83 % on scikit-learn's blobs, of which the tag `poor_score` relieves the others."""

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.classifier_tags.poor_score = False
        return tags


SETTINGS = [
    MultiViewClassifier(),
    MultiViewClassifier(references="class", decision="explained fraction"),
    HeldToAnAccuracy(lambda1=0.0, lambda2=0.0, lambda3=0.0),
]


INPUTS = ("check_estimators_dtypes", "readonly_memmap", "X_dtype")
"""In the names of checks of how X is stored, which is seen to before any setting is looked at: for the first
setting alone. All others are for every setting."""


def checks() -> Iterator[Any]:
    for k, estimator in enumerate(SETTINGS):
        for given, check in estimator_checks_generator(estimator):
            words = getattr(check, "keywords", {})
            name = f"{check.func.__name__}({', '.join(f'{key}={value}' for key, value in words.items())})"
            if not (k and any(each in name for each in INPUTS)):
                yield pytest.param(given, check, id=f"{type(estimator).__name__}-{k}-{name}")


@pytest.mark.parametrize(("estimator", "check"), list(checks()))
def test_scikit_learn_finds_an_estimator(estimator, check):
    check(estimator)
