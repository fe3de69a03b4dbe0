"""scikit-learn's own checks of an estimator, all of them, for several settings."""

import numpy as np
import pytest
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.utils.estimator_checks import parametrize_with_checks
from sklearn.utils.validation import check_is_fitted, validate_data

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


class Twice(TransformerMixin, BaseEstimator):
    """Two robots that see the same: the checks' samples have odd numbers of columns too."""

    def fit(self, X, y=None):
        validate_data(self, X)
        return self

    def transform(self, X):
        check_is_fitted(self)
        rows = validate_data(self, X, reset=False)
        return np.hstack([rows, rows])


SETTINGS = [
    MultiViewClassifier(),
    MultiViewClassifier(references="class", decision="explained fraction"),
    HeldToAnAccuracy(lambda1=0.0, lambda2=0.0, lambda3=0.0),
    make_pipeline(Twice(), MultiViewClassifier(robots=2, references="sample", lambda1=0.0)),
]


def failing(estimator):
    """What fails for every pipeline, for that of scikit-learn's own classifiers as well."""
    if not isinstance(estimator, Pipeline):
        return {}
    in_place = "a Pipeline fits the steps that it was given"
    return {"check_estimators_overwrite_params": in_place, "check_dont_overwrite_parameters": in_place}


@parametrize_with_checks(SETTINGS, expected_failed_checks=failing)
def test_scikit_learn_finds_an_estimator(estimator, check):
    check(estimator)
