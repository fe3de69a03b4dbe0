"""The label of one scene by each method, all from the same features and references.

paper            the lowest optimum, at three choices of lambda1, lambda2, lambda3; (0.1, 0, 0) is a least
                 squares fit of each reference by the views
each view        the lowest sum over the views of the optimum of each alone, at the first choice; see
                 `convexperc.recognition.EachView`
nearest to mean  the object of the reference nearest to the mean of the views
vote, best view  see `convexperc.recognition.rules`
SVM              scikit-learn's LinearSVC with its default C = 1, one against the rest, trained on the
                 references; the decision values of the views are added, or each view votes
"""

import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc import TemplateLibrary, recognize_path
from convexperc.errors import InputError
from convexperc.recognition import EachView, Recognition, Verdict
from verification.accuracy.object_sets import Fold
from verification.accuracy.scenes import Described, Split, Trial, photograph

Floats = NDArray[np.float64]
LAMBDAS = ((0.1, 1.0, 0.1), (0.1, 0.1, 0.1), (0.1, 0.0, 0.0))
"""The first are the defaults of the command line: margins and acceptance are of them."""
PAPER = tuple(f"paper ({one:g}, {two:g}, {three:g})" for one, two, three in LAMBDAS)
DISTANCES = "nearest to mean", "sum of distances", "vote", "best view"
METHODS = (*PAPER, "each view", *DISTANCES, "SVM, sum", "SVM, vote")
TOLERANCE = 1e-6
"""Relative gap to which all templates are certified; a label is proved by disjoint intervals."""
SECONDS = 5.0
"""For ball arithmetic, where intervals overlap."""


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """The references of a fold.

    Attributes
    ----------
    library : TemplateLibrary
        Its templates are named after their photographs, its objects are the labels.
    photographs : frozenset of str
    machine : LinearSVC or None
        None where it is not asked for.
    """

    library: TemplateLibrary
    photographs: frozenset[str]
    machine: Any

    @classmethod
    def of(
        cls, fold: Fold, count: int, splits: Mapping[str, Split], described: Described, *, machine: bool
    ) -> "Known":
        """Take the first `count` references of each known object."""
        shown = {
            photograph(name, photo): label
            for name, label in fold.known.items()
            for photo in splits[name].references[:count]
        }
        O = np.stack([described.rows[name] for name in shown], axis=1)  # noqa: E741 - the paper's symbol
        O.flags.writeable = False
        sizes = described.configuration.modality_sizes
        library = TemplateLibrary(O, names=list(shown), objects=list(shown.values()), modalities=sizes)
        return cls(library, frozenset(shown), trained(O.T, list(shown.values())) if machine else None)

    def recognise(self, trial: Trial, lambdas: tuple[tuple[float, float, float], ...]) -> list[Recognition]:
        """Recognise a scene at several choices of the lambdas, every template solved to the end.

        Raises
        ------
        InputError
            A photograph is both a reference and a view: the object would be recognised by the picture.
        """
        if both := sorted(self.photographs.intersection(str(v.photograph) for v in trial.scene.views)):
            must = "must not be a reference as well"
            raise InputError(f"view of {trial.scene.name}", value=both[0], must=must)
        return list(
            recognize_path(
                trial.X, self.library, lambdas, prune=False, relative_tolerance=TOLERANCE, seconds=SECONDS
            )
        )


def trained(samples: Floats, labels: list[str]) -> Any:
    """Train a linear support vector machine on the references."""
    from sklearn.svm import LinearSVC  # noqa: PLC0415 - an optional package

    with warnings.catch_warnings():  # one reference of each object is what is asked for
        warnings.filterwarnings("ignore", "The number of unique classes", UserWarning)
        return LinearSVC(random_state=0, max_iter=20000).fit(samples, labels)


@dataclass(frozen=True, slots=True)
class Named:
    """What the methods say of a scene.

    Attributes
    ----------
    scores : tuple of float
        Of each of `METHODS`, the chance that a fair draw among the objects it names is right.
    proved : bool
        Whether the paper's rule at the first lambdas proves a label.
    right : bool
        Whether its first candidate is right.
    margin : float
        Its margin's lower bound.
    nearest_margin : float
        1 - d1/d2 for the squared distances of the mean of the views from the nearest object and the next.
    """

    scores: tuple[float, ...]
    proved: bool
    right: bool
    margin: float
    nearest_margin: float


def name_by_all(known: Known, trial: Trial, truth: str) -> Named:
    """Apply every method to one scene."""
    found = known.recognise(trial, LAMBDAS)
    first, rules = found[0], found[0].rules
    named = [each.candidates for each in found] + [EachView.of(first).candidates]
    scores = [float(truth in candidates) / len(candidates) for candidates in named]
    closest = found[0].objects[int(rules.distances.sum(axis=0).argmin())]
    scores += [float(name == truth) for name in (rules.mean, closest, rules.vote, rules.best_view)]
    scores += [float(name == truth) for name in by_machine(known.machine, trial.X)]
    return Named(
        tuple(scores),
        first.verdict is Verdict.PROVED,
        first.candidates[0] == truth,
        0.0 if first.margin is None else first.margin[0],
        nearest_margin(known.library, trial.X),
    )


def by_machine(machine: Any, X: Floats) -> tuple[str, str]:
    """The label by the sum of the decision values over the views, and by their votes.

    Of equal votes the larger sum decides.
    """
    values, names = np.asarray(machine.decision_function(X)), [str(each) for each in machine.classes_]
    if values.ndim == 1:
        values = np.stack([-values, values], axis=1)
    sums = values.sum(axis=0)
    votes = Counter(values.argmax(axis=1).tolist())
    return names[int(sums.argmax())], names[max(votes, key=lambda k: (votes[k], sums[k]))]


def mean_distances(library: TemplateLibrary, X: Floats) -> Floats:
    """Squared distance of the mean of the views from the nearest reference of each object."""
    mean, columns = X.mean(axis=0), np.asarray(library.O)
    squares = library.lengths.squares - 2.0 * (mean @ columns) + mean @ mean
    found = np.full(len(library.objects), np.inf)
    np.minimum.at(found, library.owners, np.maximum(squares, 0.0))
    return found


def nearest_margin(library: TemplateLibrary, X: Floats) -> float:
    """1 - d1/d2 of the two nearest objects; 0 where both are at no distance."""
    first, second = np.sort(mean_distances(library, X))[:2]
    return float(1.0 - first / second) if second > 0.0 else 0.0
