"""The campaign of lasso certificates: it repeats, resumes, and finds each fault that is planted."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from convexperc.lasso import certificate as bounds
from convexperc.lasso import certifying, conventions, dual_points
from convexperc.lasso.certificate import LassoCertificate
from convexperc.lasso.conventions import CONVENTIONS, Given
from convexperc.lasso.scaled import ScaledData
from verification.__main__ import app
from verification.journal import Journal
from verification.lassos import campaign
from verification.lassos.campaign import Outcome, Settings, contradictions, run, shard
from verification.lassos.problems import SHAPES, draw

FEW = Settings(problems=60, seed=3, referee=1)
MANY = Settings(problems=200, seed=1, referee=1)
"""Within these each planted fault is found; the rest is left out once it is."""
RUNNER = CliRunner()


def test_no_statement_is_false_and_every_convention_is_drawn():
    outcome = run(FEW)
    assert outcome.clean, outcome.found
    assert set(outcome.conventions) == set(SHAPES) == set(CONVENTIONS)
    total = outcome.total
    assert (total.total, total.refereed) == (60, 60)
    assert total.loose <= 6, "the referee itself is to be exact"
    assert total.certified >= 15, "the bounds are to be worth something"
    assert total.zeros > 0


def test_two_runs_find_the_same_and_a_journal_is_gone_on_from(tmp_path, monkeypatch):
    monkeypatch.setattr(campaign, "SHARD", 20)
    whole = run(FEW)
    journal = Journal(tmp_path / "journal.jsonl", {"head": 1})
    journal.put("0|20", shard(FEW, 0, 20))
    done = []
    monkeypatch.setattr(campaign, "shard", lambda *what: done.append(what[1:]) or shard(*what))
    assert run(FEW, journal=journal) == whole
    assert done == [(20, 20), (40, 20)]


def test_the_problems_are_those_of_their_number():
    one, same, other = draw(5, 7), draw(5, 7), draw(5, 8)
    assert one.kind == same.kind
    assert np.array_equal(one.X, same.X)
    assert not (one.X.shape == other.X.shape and np.array_equal(one.X, other.X))


def plant_high_bound(monkeypatch):
    """The lower bound 1e-9 too high."""
    lower = dual_points.DualPoint.lower.fget
    monkeypatch.setattr(dual_points.DualPoint, "lower", property(lambda self: lower(self) * (1.0 + 1e-9)))


def plant_forgotten_intercept(monkeypatch):
    """A dual point that is not made orthogonal to 1, nor to free columns."""
    monkeypatch.setattr(dual_points, "_orthogonal", lambda data, t, root, free: (t, 0.0, free))


def plant_left_out_weights(monkeypatch):
    """Weights of columns and groups that are not looked at."""
    monkeypatch.setattr(Given, "own", property(lambda self: np.ones(self.m or self.p)))


def plant_wrong_sign(monkeypatch):
    """Only positive correlations counted, as with b >= 0."""
    monkeypatch.setattr(dual_points, "_reach", lambda data, v: v.mid + v.rad)


def plant_left_out_samples(monkeypatch):
    """Sample weights that are not looked at."""
    monkeypatch.setattr(certifying, "_sample_weights", lambda value, n: None)


def plant_unrooted_groups(monkeypatch):
    """Groups without the square roots of their sizes."""
    monkeypatch.setattr(Given, "rooted", property(lambda self: self.own))


def plant_halved_reach(monkeypatch):
    """Zeros from a tenth of the distance that the gap allows."""
    zeros_at = dual_points.zeros_at
    monkeypatch.setattr(bounds, "zeros_at", lambda data, dual, gap: zeros_at(data, dual, gap * 0.01))


def plant_loss_of_the_sum(monkeypatch):
    """A loss divided by n where it is divided by 2 n."""
    loss = certifying._loss
    monkeypatch.setattr(
        certifying, "_loss", lambda *what: replace(loss(*what), factor=2 * loss(*what).factor)
    )


def plant_uncharged_excess(monkeypatch):
    """A dual point that is not feasible, at no cost."""
    monkeypatch.setattr(dual_points, "_charge", lambda excess, limits: 0.0)


def plant_small_gap(monkeypatch):
    """A gap 1e-6 too small."""
    gap_at = dual_points.gap_at
    monkeypatch.setattr(bounds, "gap_at", lambda *what: gap_at(*what) * (1.0 - 1e-6))


def plant_left_out_ridge(monkeypatch):
    """An elastic net without its second penalty."""
    made = ScaledData.of.__func__

    def of(cls, given):
        data = made(cls, given)
        zero = replace(data.ridge, lower=0.0 * data.ridge.lower, upper=0.0 * data.ridge.upper)
        return replace(data, ridge=zero)

    monkeypatch.setattr(ScaledData, "of", classmethod(of))


FAULTS = [each for name, each in sorted(globals().items()) if name.startswith("plant_")]


@pytest.mark.parametrize("plant", FAULTS, ids=lambda each: each.__name__[6:])
def test_a_planted_fault_is_found(plant, monkeypatch):
    plant(monkeypatch)
    outcome = Outcome()
    for first in range(0, MANY.problems, 10):
        outcome.add(shard(MANY, first, 10))
        if outcome.total.wrong:
            break
    assert not outcome.clean
    assert outcome.total.wrong > 0, "found by its statements, not by an exception"


def test_without_a_fault_the_same_problems_are_clean():
    assert run(MANY).clean


def test_an_exception_is_that_of_its_problem(monkeypatch):
    calls = []

    def broken(*what, **more):
        calls.append(1)
        if len(calls) == 3:
            raise TypeError("planted")
        return certifying.certify_lasso(*what, **more)

    monkeypatch.setattr(campaign, "certify_lasso", broken)
    outcome = run(replace(FEW, problems=10))
    assert [each["wrong"] for each in outcome.found] == [["TypeError: planted"]]
    assert (outcome.total.total, outcome.total.crashed) == (10, 1)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"lower": 3.0}, "lower > upper"),
        ({"gap": math.nan}, "a number is NaN or negative"),
        ({"objective": (2.0, 1.0)}, "objective, lower > upper"),
        ({"upper": 5.0}, "upper > objective"),
    ],
)
def test_a_certificate_against_itself_is_seen(changes, told):
    drawn = draw(3, 0)
    found = certifying.certify_lasso(drawn.X, drawn.y, drawn.coef, drawn.alpha, **drawn.options)
    assert contradictions(found) == []
    plain = {"lower": 1.0, "upper": 2.0, "objective": (2.0, 2.0), "gap": 1.0} | changes
    assert told in contradictions(replace(found, **plain)), LassoCertificate


def test_the_command_writes_what_it_found(tmp_path):
    file = tmp_path / "lassos.json"
    done = RUNNER.invoke(
        app, ["lassos", "--problems", "12", "--referee", "6", "--seed", "2", "--json", str(file)]
    )
    assert done.exit_code == 0, done.output
    assert "all: 12 problems" in done.output
    data = json.loads(file.read_text(encoding="utf-8"))
    assert data["schema"] == "convexperc/lassos/1"
    assert data["command"] == "python -m verification lassos --problems 12 --seed 2 --referee 6"
    assert sum(each["total"] for each in data["conventions"].values()) == 12
    assert sum(each["refereed"] for each in data["conventions"].values()) == 2
    assert data["found"] == []


def test_the_command_ends_with_1_where_something_is_false(monkeypatch):
    plant_high_bound(monkeypatch)
    done = RUNNER.invoke(app, ["lassos", "--problems", "60", "--referee", "1"])
    assert done.exit_code == 1
    assert "lower <= P*" in done.output


def test_every_convention_has_its_shape():
    """What the campaign writes down again takes what the convention takes."""
    for name, shape in SHAPES.items():
        taken = CONVENTIONS[name].takes
        assert shape.groups == ("groups" in taken), name
        assert shape.weights == ("weights" in taken), name
        assert shape.samples == ("sample_weight" in taken), name
        assert shape.ratio == ("l1_ratio" in taken), name
        assert shape.second == ("l1_reg" in taken), name
    assert conventions.CONVENTIONS is CONVENTIONS
