"""The estimator: rows of several views in, labels out, with the recognition behind each of them."""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.classifier.training import check_kind, trained_library
from convexperc.enclosure.budget import SECONDS, Budget
from convexperc.errors import InputError, is_integer, require
from convexperc.problem.penalties import Penalties
from convexperc.recognition.decision import Decision
from convexperc.recognition.label import recognize
from convexperc.recognition.recognition import Recognition, Verdict

require("sklearn", "sklearn", "MultiViewClassifier")

from sklearn.base import BaseEstimator, ClassifierMixin  # noqa: E402 - `require` says how to install it
from sklearn.utils.multiclass import check_classification_targets  # noqa: E402
from sklearn.utils.validation import check_is_fitted, validate_data  # noqa: E402


class UnprovedLabelWarning(UserWarning):
    """`MultiViewClassifier.predict` returned labels of which it is not proved that they are the best."""


class MultiViewClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # no types there
    """Name the class whose reference has the lowest optimum, given the views of several robots.

    A sample is a row of n * d numbers: the d features of the first robot's view, then those of the second,
    and so on. `fit` keeps references o of each class; `predict` minimises, for the views X (n, d) of a sample
    and every reference,

        F(w, u) = ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||_2

    and returns the class of the reference with the lowest optimum F*.

    Parameters
    ----------
    robots : int
        n, the number of views in a sample.
    lambda1, lambda2, lambda3 : real number
        The penalties. They depend on the scale of the features: the defaults suit views of length about 1.
    modalities : see `Modalities.of`
        The partition of the d features of a view; one modality of all without.
    references : {"view", "sample", "class"}
        What becomes a reference: each view of each training sample, the mean of each sample's views, or the
        mean of all views of a class.
    decision : {"objective", "explained fraction"} or Decision
        What the references are compared by: F*, as in the paper (the default), or F* / ||o||^2.
    seconds : float
        For the ball arithmetic of one sample; see `convexperc.enclosure.budget.Budget`.

    Attributes
    ----------
    classes_ : (k,)
        The labels, sorted.
    library_ : TemplateLibrary
        The references in the order of `classes_`, named by the class and the row of X that they come from:
        ``cat/row 17/robot 2``, ``cat/row 17`` or ``cat``.
    n_features_in_ : int
        n * d.
    feature_names_in_ : (n * d,) of str
        The names of the columns, where X had any.

    Notes
    -----
    Each sample is one call of `convexperc.recognize`. `fit` reads `robots`, `modalities` and `references`;
    the other parameters are read where a sample is recognised, and may be changed without another fit. Errors
    about X and y are scikit-learn's; they, and those of this package, are a ValueError.
    """

    def __init__(
        self,
        robots: Any = 1,
        *,
        lambda1: Any = 0.1,
        lambda2: Any = 0.1,
        lambda3: Any = 0.1,
        modalities: Any = None,
        references: Any = "view",
        decision: Any = "objective",
        seconds: Any = SECONDS,
    ) -> None:
        self.robots = robots
        self.lambda1 = lambda1
        self.lambda2 = lambda2
        self.lambda3 = lambda3
        self.modalities = modalities
        self.references = references
        self.decision = decision
        self.seconds = seconds

    def fit(self, X: Any, y: Any) -> "MultiViewClassifier":
        """Keep the references of each class.

        Parameters
        ----------
        X : array_like (samples, n * d)
        y : array_like (samples,)
            The class of each sample.

        Returns
        -------
        MultiViewClassifier
            Itself.

        Raises
        ------
        InputError, ProblemError, DecisionError, BudgetError
            A parameter that is out of range; columns that cannot be shared equally by the robots.
        ModalityError
            The modalities are not a partition of the d features.
        TemplateNameError
            A class is an empty string.
        ValueError
            What scikit-learn says of X and y.
        """
        self._check_parameters()
        X, y = validate_data(self, X, y)
        check_classification_targets(y)
        if X.shape[1] % self.robots:
            must = f"must be a multiple of robots = {self.robots}: a sample holds as many features of each"
            raise InputError("the number of columns of X", value=X.shape[1], must=must)
        classes, owners = np.unique(y, return_inverse=True)
        samples, names = X.reshape(X.shape[0], self.robots, -1), [str(label) for label in classes]
        self.library_ = trained_library(samples, owners, names, self.references, self.modalities)
        self.classes_ = classes
        return self

    def predict(self, X: Any) -> NDArray[Any]:
        """Name the class of each sample.

        Where it is not proved that one class is the best, the label is that of the largest value of
        `decision_function`, the first in `classes_` of equal ones; a warning says how many these are.
        `recognize` says which, and why.

        Parameters
        ----------
        X : array_like (samples, n * d)

        Returns
        -------
        array (samples,)
            Entries of `classes_`.

        Warns
        -----
        UnprovedLabelWarning
            Some samples are undecided or tied.

        Raises
        ------
        ValueError, InputError
            See `recognize`.
        """
        places, unproved = list[int](), 0
        for views in self._samples(X):
            found = self._recognized(views)
            if found.verdict is not Verdict.PROVED:
                found = self._recognized(views, prune=False)
                unproved += found.verdict is not Verdict.PROVED
            places.append(int(_values(found).argmax()))
        if unproved:
            warnings.warn(
                f"the best class of {unproved} of {len(places)} samples is undecided or tied; "
                "recognize(X) gives the verdict of each",
                UnprovedLabelWarning,
                stacklevel=2,
            )
        return np.asarray(self.classes_[places])

    def decision_function(self, X: Any) -> Float[np.ndarray, "..."]:
        """Minus the lowest optimum of each class.

        The optimum is represented by its proved upper bound, which is as near to it as `Tolerances` asks by
        default, unless the `seconds` did not suffice. Every reference is solved to the end, which `predict`
        avoids.

        Parameters
        ----------
        X : array_like (samples, n * d)

        Returns
        -------
        float64 (samples, k)
            -F*, or -F* / ||o||^2, of the best reference of each class in the order of `classes_`; for two
            classes their difference (samples,), which is positive where the second is the better one.

        Raises
        ------
        ValueError, InputError
            See `recognize`.
        """
        values = np.array([_values(self._recognized(views, prune=False)) for views in self._samples(X)])
        return values[:, 1] - values[:, 0] if values.shape[1] == 2 else values

    def recognize(self, X: Any, *, prune: bool = True) -> tuple[Recognition, ...]:
        """Give the recognition behind each label.

        Parameters
        ----------
        X : array_like (samples, n * d)
        prune : bool
            As for `convexperc.recognize`: False solves every reference to the end.

        Returns
        -------
        tuple of Recognition
            Their labels and candidates are the classes as strings. A label is None unless it is proved.

        Raises
        ------
        sklearn.exceptions.NotFittedError
            `fit` has not been called.
        ValueError
            What scikit-learn says of X, another number of columns among them.
        InputError
            A parameter that was changed since `fit`.
        """
        return tuple(self._recognized(views, prune=prune) for views in self._samples(X))

    def __sklearn_tags__(self) -> Any:
        """Tell scikit-learn that little is to be expected on its centred blobs; see docs/scikit-learn.md."""
        tags = super().__sklearn_tags__()
        tags.classifier_tags.poor_score = True
        return tags

    def _check_parameters(self) -> None:
        if not is_integer(self.robots) or self.robots < 1:
            raise InputError("robots", value=self.robots, must="must be an integer >= 1")
        check_kind(self.references)
        Penalties(self.lambda1, self.lambda2, self.lambda3)
        Decision.of(self.decision)
        Budget(self.seconds)

    def _samples(self, X: Any) -> Iterator[NDArray[Any]]:
        """The views (n, d) of each sample, with d as in the references."""
        check_is_fitted(self)
        rows = validate_data(self, X, reset=False)
        return iter(rows.reshape(rows.shape[0], -1, self.library_.d))

    def _recognized(self, views: Any, *, prune: bool = True) -> Recognition:
        return recognize(
            views,
            self.library_,
            lambda1=self.lambda1,
            lambda2=self.lambda2,
            lambda3=self.lambda3,
            decision=self.decision,
            seconds=self.seconds,
            prune=prune,
        )


def _values(found: Recognition) -> Float[np.ndarray, " k"]:
    """Minus the proved upper bound of what the best reference of each class costs."""
    return -np.array([best.cost[1] for best in found.best_templates])
