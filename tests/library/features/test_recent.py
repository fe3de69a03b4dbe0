"""Pictures that have not changed since the last call are not described again; all others are."""

import copy
import pickle
import threading

import numpy as np
import pytest

from convexperc.features import FeatureConfiguration, RecentFeatures, extract, extraction
from convexperc.recognition.references import References, perceive

CONFIGURATION = FeatureConfiguration(working_size=(32, 36), hog_pixels_per_cell=(8, 8))
OTHER = FeatureConfiguration(working_size=(32, 36), hog_pixels_per_cell=(8, 8), color_bins=16)
# The number of bytes of a picture, 9 x 13 x 3, is not a multiple of 8.
PICTURES = np.random.default_rng(8).integers(0, 256, (5, 9, 13, 3), dtype=np.uint8)
LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}


@pytest.fixture
def described(monkeypatch):
    """Grows by one for each picture that is described."""
    calls = []
    original = extraction.color_histogram

    def counting(picture, configuration):
        calls.append(configuration)
        return original(picture, configuration)

    monkeypatch.setattr(extraction, "color_histogram", counting)
    return calls


@pytest.mark.parametrize(
    "again",
    [
        PICTURES.copy(),
        PICTURES[[3, 1, 4, 0, 2]],
        PICTURES[::2],
        PICTURES.astype(np.uint16) * 257,
        PICTURES[[1, 1]],
    ],
)
def test_the_same_pixels_are_described_once(again, described):
    recent, expected = RecentFeatures(), extract(again, CONFIGURATION)
    extract(PICTURES, CONFIGURATION, recent=recent)
    del described[:]
    for _ in range(2):
        found = extract(again, CONFIGURATION, recent=recent)
        assert found.tobytes() == expected.tobytes()
    assert not described


def test_new_pictures_among_known_ones_have_their_places(described):
    recent, expected = RecentFeatures(), extract(PICTURES, CONFIGURATION)
    extract(PICTURES[[1, 3]], CONFIGURATION, recent=recent)
    del described[:]
    found = extract(PICTURES, CONFIGURATION, recent=recent)
    assert found.tobytes() == expected.tobytes()
    assert len(described) == 3


@pytest.mark.parametrize("place", [(0, 0, 0), (4, 6, 1), (8, 12, 0), (8, 12, 1), (8, 12, 2)])
def test_a_picture_changed_in_place_is_described_again(place, described):
    recent, picture = RecentFeatures(), PICTURES[0].copy()
    extract([picture], CONFIGURATION, recent=recent)
    picture[place] ^= 1
    found = extract([picture], CONFIGURATION, recent=recent)
    assert len(described) == 2
    assert found.tobytes() == extract([picture], CONFIGURATION).tobytes()


def test_pictures_of_the_same_words_in_another_order_are_told_apart():
    words = np.random.default_rng(2).integers(0, 2**63, (24, 3, 3), dtype=np.uint64)
    one, other = (part.view(np.uint8).reshape(24, 24, 3) for part in (words, words[::-1].copy()))
    recent, expected = RecentFeatures(), extract([one, other], CONFIGURATION)
    assert expected[0].tobytes() != expected[1].tobytes()
    for _ in range(2):
        assert extract([one], CONFIGURATION, recent=recent)[0].tobytes() == expected[0].tobytes()
        assert extract([other], CONFIGURATION, recent=recent)[0].tobytes() == expected[1].tobytes()
        assert extract([one, other], CONFIGURATION, recent=recent).tobytes() == expected.tobytes()


def test_another_shape_or_configuration_is_another_picture(described):
    recent = RecentFeatures()
    tall, wide = np.zeros((24, 12, 3), np.uint8), np.zeros((12, 24, 3), np.uint8)
    for picture, configuration in (
        (tall, CONFIGURATION),
        (wide, CONFIGURATION),
        (wide, OTHER),
        (tall, OTHER),
    ):
        extract([picture], configuration, recent=recent)
    assert described == [CONFIGURATION, CONFIGURATION, OTHER, OTHER]


def test_the_pictures_of_the_last_call_alone_are_kept(described):
    recent = RecentFeatures()
    extract(PICTURES[:3], CONFIGURATION, recent=recent)
    extract(PICTURES[2:], CONFIGURATION, recent=recent)
    assert len(described) == 5
    extract(PICTURES, CONFIGURATION, recent=recent)
    assert len(described) == 7


def test_pictures_that_are_too_many_at_once_are_described_again(described, monkeypatch):
    monkeypatch.setattr(extraction, "BATCH", 2 * PICTURES[0].nbytes)
    recent, expected = RecentFeatures(), extract(PICTURES, CONFIGURATION)
    for _ in range(2):
        assert extract(PICTURES, CONFIGURATION, recent=recent).tobytes() == expected.tobytes()
    assert len(described) == 15
    extract(PICTURES[4:], CONFIGURATION, recent=recent)
    assert len(described) == 15


def test_what_is_kept_cannot_be_changed():
    recent = RecentFeatures()
    found = extract(PICTURES, CONFIGURATION, recent=recent)
    again = recent.rows(list(PICTURES), CONFIGURATION, lambda pictures: [np.zeros(3) for _ in pictures])
    assert np.stack(again).tobytes() == found.tobytes()
    with pytest.raises(ValueError, match="read-only"):
        again[0][0] = 1.0


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda kept: pickle.loads(pickle.dumps(kept))])
def test_a_copy_begins_empty(copied, described):
    recent = RecentFeatures()
    extract(PICTURES, CONFIGURATION, recent=recent)
    extract(PICTURES, CONFIGURATION, recent=copied(recent))
    assert len(described) == 10


def test_threads_may_share_it():
    recent, expected = RecentFeatures(), extract(PICTURES, CONFIGURATION)
    wrong = []

    def work(seed):
        random = np.random.default_rng(seed)
        for _ in range(40):
            chosen = random.integers(0, 5, 3)
            found = extract(PICTURES[chosen], CONFIGURATION, recent=recent)
            if found.tobytes() != expected[chosen].tobytes():
                wrong.append(chosen)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_views_that_have_not_changed_are_described_once_for_their_references(described):
    known = {"a": PICTURES[0], "b": PICTURES[1], "c": PICTURES[2]}
    references, others = (References.of(known, CONFIGURATION) for _ in range(2))
    views = {"left": PICTURES[3].copy(), "right": PICTURES[4].copy()}
    del described[:]
    first = perceive(views, references, **LAMBDAS)
    assert len(described) == 2
    views["right"][5, 5] ^= 1
    second = perceive(views, references, **LAMBDAS)
    assert len(described) == 3
    alone = perceive(views, others, **LAMBDAS)
    assert len(described) == 5
    for one, other in zip(second.templates, alone.templates, strict=True):
        assert one.solution.w.tobytes() == other.solution.w.tobytes()
    assert first.views == second.views == ("left", "right")
    assert "recent" not in repr(references)
