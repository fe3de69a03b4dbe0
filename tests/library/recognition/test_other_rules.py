"""Other rules than the paper's, against distances computed one by one; and the margin."""

from collections import Counter

import numpy as np
import pytest

from convexperc import TemplateLibrary, recognize

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}


def made(
    seed: int, scale: float = 1.0, objects: int = 4, references: int = 3
) -> tuple[np.ndarray, TemplateLibrary]:
    rng = np.random.default_rng(seed)
    n, d, p = int(rng.integers(1, 7)), 9, objects * references
    X, O = rng.random((n, d)) * scale, rng.random((d, p)) * scale
    shown = [f"object {j % objects}" for j in range(p)]
    return X, TemplateLibrary(O, objects=shown, modalities=[4, 5])


@pytest.mark.parametrize("exponent", [0, 300, -300, 540, -540, 1000, -1000])
def test_the_rules_do_not_depend_on_the_unit(exponent):
    X, unit = np.array([[1.0, 0.1], [0.9, 0.0]]), 2.0**exponent
    found = recognize(
        X * unit, {"b": [0.0, unit], "a": [unit, 0.0]}, lambda1=0.1, lambda2=0.0, lambda3=0.0, escalate=False
    )
    rules = found.rules
    assert (rules.mean, rules.vote, rules.best_view, rules.nearest) == ("a", "a", "a", ("a", "a"))
    assert not np.isnan(rules.distances).any()


@pytest.mark.parametrize("scale", [1.0, 2.0**40, 1e-90])
@pytest.mark.parametrize("seed", range(12))
def test_every_rule_is_what_its_definition_says(seed, scale):
    X, library = made(seed, scale)
    lambdas = {"lambda1": 0.1 * scale**2, "lambda2": 0.1 * scale**2, "lambda3": 0.1 * scale**3}
    found = recognize(X, library, escalate=False, **lambdas)
    rules = found.rules
    O, objects = library.O, library.objects
    near = np.array(
        [
            [
                min(((x - O[:, j]) ** 2).sum() for j in range(12) if library.shown[j] == name)
                for name in objects
            ]
            for x in X
        ]
    )
    assert np.allclose(rules.distances, near, rtol=1e-9, atol=1e-12 * scale**2)
    assert rules.nearest == tuple(objects[k] for k in near.argmin(axis=1))
    assert rules.best_view == objects[int(near.min(axis=0).argmin())]
    mean = [((X.mean(axis=0) - O[:, j]) ** 2).sum() for j in range(12)]
    assert rules.mean == library.shown[int(np.argmin(mean))]
    votes = Counter(rules.nearest)
    assert rules.votes == dict(votes)
    assert votes[rules.vote] == max(votes.values())
    assert rules.lowest == found.candidates[0]
    robots = zip(found.views, rules.nearest, strict=True)
    assert rules.disagreeing == tuple(robot for robot, name in robots if name != found.candidates[0])


def test_of_equal_votes_the_smaller_sum_of_distances_decides():
    X = np.array([[1.0, 0.0], [0.0, 1.0]])
    O = {"far": [3.0, 0.0], "near": [0.0, 1.5]}
    assert recognize(X, O, **LAMBDAS).rules.vote == "near"
    assert recognize(X, dict(reversed(O.items())), **LAMBDAS).rules.vote == "near"


@pytest.mark.parametrize("decision", ["objective", "explained fraction"])
@pytest.mark.parametrize("seed", range(12))
def test_the_margin_lies_within_its_proved_bounds(seed, decision):
    X, library = made(seed)
    tight = recognize(X, library, prune=False, decision=decision, **LAMBDAS)
    pruned = recognize(X, library, decision=decision, **LAMBDAS)
    best = {each.object: sum(each.cost) / 2 for each in tight.best_templates}
    first, second = sorted(best.values())[:2]
    true = 1.0 - first / second
    for found in (tight, pruned):
        lower, upper = found.margin
        assert lower - 1e-9 <= true <= upper + 1e-9, (lower, true, upper)
    assert tight.margin[1] - tight.margin[0] < 1e-8
    assert tight.runner_up == sorted(best, key=best.get)[1]


def test_one_object_has_no_margin_and_equal_objects_have_none_that_is_proved():
    X = np.random.default_rng(0).random((3, 4))
    alone = recognize(X, {"a": X[:2]}, **LAMBDAS)
    assert (alone.margin, alone.runner_up, alone.label) == (None, None, "a")
    tied = recognize(X, {"a": X[0], "b": X[0]}, **LAMBDAS)
    assert tied.margin[0] == 0.0
    assert 0.0 <= tied.margin[1] < 1e-8
