"""scikit-learn's own checks of an estimator, all of them, for several settings."""

import pytest
from sklearn.utils.estimator_checks import parametrize_with_checks

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


@parametrize_with_checks(SETTINGS)
def test_scikit_learn_finds_an_estimator(estimator, check):
    check(estimator)
