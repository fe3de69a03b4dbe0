"""Scenes made of references, against a library without them made by hand; and the share explained."""

import numpy as np
import pytest

from convexperc import TemplateLibrary, recognize
from convexperc.errors import CalibrationError, DecisionError
from convexperc.recognition import Calibration, Origin, held_out_scenes

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
RNG = np.random.default_rng(11)
COLUMNS = RNG.random((9, 8))
SHOWN = ["a", "b", "a", "c", "b", "a", "a", "b"]
LIBRARY = TemplateLibrary(
    COLUMNS, names=[f"{name}/{i}" for i, name in enumerate(SHOWN)], objects=SHOWN, modalities=[5, 4]
)


@pytest.mark.parametrize("robots", [1, 2, 3])
def test_every_scene_is_that_of_the_others_without_its_views(robots):
    places = {name: [j for j, each in enumerate(SHOWN) if each == name] for name in "abc"}
    expected = [
        (name, [own[(i + k) % len(own)] for k in range(robots)])
        for name, own in places.items()
        for i in range(len(own))
        if len(own) > robots
    ]
    made = list(held_out_scenes(LIBRARY, robots, **LAMBDAS))
    assert [name for _, name in made] == [name for name, _ in expected]
    for (found, _), (_, out) in zip(made, expected, strict=True):
        kept = [j for j in range(8) if j not in out]
        assert found.names == tuple(LIBRARY.names[j] for j in kept)
        assert set(found.objects) == {"a", "b", "c"}
        rest = TemplateLibrary(
            COLUMNS[:, kept], objects=[SHOWN[j] for j in kept], modalities=LIBRARY.modalities
        )
        truth = recognize(COLUMNS[:, sorted(out)].T, rest, prune=False, **LAMBDAS)
        assert np.array_equal(found.answers.upper, truth.answers.upper)
        assert found.answers.certified.all()


def test_their_origin_is_kept():
    made = Calibration.of(held_out_scenes(LIBRARY, **LAMBDAS), 0.5, LIBRARY)
    assert (made.scenes, made.origin, made.views) == (7, Origin.HELD_OUT, (1, 1))
    assert made.judge(recognize(COLUMNS[:, :1].T, LIBRARY, prune=False, **LAMBDAS)).accepted
    assert Calibration.from_dict(made.to_dict()) == made
    with pytest.raises(CalibrationError, match="origin"):
        Calibration.from_dict({**made.to_dict(), "origin": "somewhere"})


def test_what_does_not_fit_is_refused():
    with pytest.raises(CalibrationError, match="more than 4 references"):
        next(held_out_scenes(LIBRARY, 4, **LAMBDAS))
    with pytest.raises(CalibrationError, match="at least 1"):
        next(held_out_scenes(LIBRARY, 0, **LAMBDAS))
    with pytest.raises(DecisionError):
        next(held_out_scenes(LIBRARY, decision="vote", **LAMBDAS))


@pytest.mark.parametrize("decision", ["objective", "explained fraction"])
@pytest.mark.parametrize("scale", [1.0, 1e-170, 1e150])
def test_the_share_explained_is_one_minus_that_of_the_best_reference(decision, scale):
    lambdas = {"lambda1": 0.1 * scale**2, "lambda2": 0.1 * scale, "lambda3": 0.1 * scale}
    X = RNG.random((3, 9))
    found = recognize(X, LIBRARY, decision=decision, **LAMBDAS)
    best = found.template()
    true = 1.0 - best.interval[1] / (COLUMNS[:, best.index] ** 2).sum()
    lower, upper = found.explained
    assert 0.0 <= lower <= true + 1e-9
    assert true - 1e-9 <= upper <= 1.0
    assert upper - lower <= 1e-8
    scaled = recognize(
        X * scale, TemplateLibrary(COLUMNS * scale, objects=SHOWN), decision=decision, **lambdas
    )
    lower, upper = scaled.explained
    assert 0.0 <= lower <= upper <= 1.0
