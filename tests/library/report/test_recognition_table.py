"""The table of the objects: what it says is explained is proved to be."""

import io
import re
from dataclasses import replace

import numpy as np
from rich.console import Console

from convexperc.recognition.decision import Decision
from convexperc.recognition.label import decide, recognize
from convexperc.report.tables import show_recognition


def test_the_share_that_is_explained_at_least_is_that_of_the_upper_bound():
    X = np.array([[1.0, 0.5, 0.0, 0.2], [0.1, 0.9, 0.4, 0.0]])
    found = recognize(X, {"a": X[0], "b": X[1]}, lambda1=0.5, lambda2=0.1, lambda3=0.1, prune=False)
    wide = replace(found.answers, lower=0.5 * found.answers.lower)
    found = decide(wide, found.names, found.views, Decision.EXPLAINED_FRACTION)
    stream = io.StringIO()
    show_recognition(Console(file=stream, width=200, color_system=None), found)
    for template in found.templates:
        row = re.search(rf"^ *{template.name} +(\S+)", stream.getvalue(), re.MULTILINE)
        assert row is not None, stream.getvalue()
        least, most = (1.0 - cost for cost in template.cost[::-1])
        assert least - 1e-5 < float(row[1]) <= least < most - 1e-3, (template.name, row[1], template.cost)
