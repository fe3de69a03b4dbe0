"""What the weights of the views are worth at other lambdas than the paper's, by default features."""

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Pair
from verification.experiments.measure.configurations import Configuration
from verification.experiments.measure.evaluation import Part
from verification.experiments.measure.numbers import rounded
from verification.experiments.measure.weights import chance_that_best_are_good, followed, weigh
from verification.experiments.record.entries import Ranking
from verification.experiments.scenes.pictures import Layout

Floats = NDArray[np.float64]

CHOICES: tuple[Pair, ...] = ((0.0, 0.0), (0.1, 0.1), (1.0, 0.1))
"""(lambda2, lambda3): least squares, the paper's, and the library's."""


def rankings(physical: Part, study: Part, configuration: Configuration) -> list[Ranking]:
    """Weigh every scene for its own object by each of `CHOICES`.

    Returns
    -------
    list of Ranking
        "lambdas"; "visible": mean Kendall's tau-b of |w| and the visible share; "full" and "proved zero":
        views that are hidden, and those of them that no optimum uses, by proof; "negative": share of the
        weights that are below 0; "three": mean over the case study of the chance that the three good views
        are ranked first.
    """
    X, known = physical.described(configuration)
    views, references = study.described(configuration)
    found: list[Ranking] = []
    for pair in CHOICES:
        w = weigh(physical.layout, X, known, pair=pair).w
        ranked = weigh(study.layout, views, references, pair=pair).w
        full = _hidden(physical.layout)
        found.append(
            {
                "lambdas": list(pair),
                "visible": followed(physical.layout, w),
                "full": int(full.sum()),
                "proved zero": int((w[full] == 0.0).sum()),
                "negative": rounded((w < 0.0).mean()),
                "three": _three(study.layout, ranked),
            }
        )
    return found


def _hidden(layout: Layout) -> NDArray[np.bool_]:
    return np.array([[view.obstruction == "full" for view in scene.views] for scene in layout.scenes])


def _three(layout: Layout, w: Floats) -> float:
    good = (np.array([view.good for view in scene.views]) for scene in layout.scenes)
    chances = [chance_that_best_are_good(each, those) for each, those in zip(w, good, strict=True)]
    return float(rounded(np.mean(chances)))
