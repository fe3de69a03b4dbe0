"""Random pairs: two derivations of the weight agree, and the campaign acquits and names."""

import json

import numpy as np
import pytest
import sympy as sp
from typer.testing import CliRunner

from verification.__main__ import app
from verification.reweighted.terms import campaign, measured, sampling
from verification.reweighted.terms.campaign import Settings, run
from verification.reweighted.terms.random_terms import FAULTS, draw

RUNNER = CliRunner(env={"COLUMNS": "140", "TERM": "dumb", "NO_COLOR": "1"})


@pytest.mark.parametrize("number", range(40))
def test_loss_and_weight_in_float64_are_those_of_the_formulas(number):
    drawn = draw(1, number)
    loss, weight = drawn.functions()
    term = drawn.term()
    width = sp.Symbol("w", positive=True)
    for r in (0.013, 0.7, 3.1, 40.0):
        at = float(drawn.width) * r
        exact = [
            each.subs({symbol: sp.Float(at, 40) if symbol.name == "r" else sp.Rational(str(drawn.width))
                       for symbol in each.free_symbols}).evalf(40)
            for each in (term.loss_expression, term.weight_expression)
        ]  # fmt: skip
        assert width in term.loss_expression.free_symbols
        assert np.isclose(float(loss(np.array(at))), float(exact[0]), rtol=1e-6, atol=1e-9)
        assert np.isclose(float(weight(np.array(at))), float(exact[1]), rtol=1e-6, atol=1e-12)


def test_a_campaign_acquits_the_sound_and_names_every_fault():
    outcome = run(Settings(300, seed=5, mutants=2, exact=100))
    assert outcome.clean, outcome.found
    assert outcome.named, outcome.found
    assert (outcome.measured.sound, outcome.measured.mutants) == (300, 150)
    assert (outcome.exact.sound, outcome.exact.mutants) == (3, 3)


def tail(r):
    """A loss that is constant in float64 where r**2 > 15: it is a difference of too large numbers there."""
    s = r * r
    return np.where(s < 12, s, 12 + (1e9 - np.exp(8 * np.minimum(12 - s, 0)) - 1e9 + 1) / 8)


@pytest.mark.parametrize(("name", "value"), [("COARSE", 0.0), ("RESOLVED", 1e6), ("_lasting", np.zeros_like)])
def test_rounding_that_hides_in_most_windows_accuses_nobody(name, value, monkeypatch):
    """A tail below the rounding, a sum of which a small part has steps, and steps in three windows alone."""
    pairs = {
        "COARSE": (tail, lambda r: np.exp(8 * np.minimum(12 - r * r, 0)), "r**2"),
        "RESOLVED": (*draw(0, 10855).functions(), draw(0, 10855).square),
        "_lasting": (*draw(1, 52401).functions(), draw(1, 52401).square),
    }
    assert measured.judge_functions(*pairs[name], formula=False).faults == ()
    monkeypatch.setattr(sampling, name, value)
    assert measured.judge_functions(*pairs[name], formula=False).faults != ()


def in_a_decade(loss):
    """The loss, with seven digits less from 1e3 to 1e4."""
    return lambda r: np.where((r > 1e3) & (r < 1e4), (loss(r) + 1e10) - 1e10, loss(r))


def cauchy(r):
    return np.log1p(r * r) / 2


def test_noise_hides_no_fault_that_is_larger_and_makes_no_proof():
    coarse = in_a_decade(cauchy)
    judged = {
        factor: measured.judge_functions(coarse, lambda r, k=factor: k / (1 + r * r), formula=False)
        for factor in (1, 1.01, 1.05)
    }
    assert not judged[1].faults
    assert "rounding may hide 0.0" in judged[1.01]["tangent"].statement, judged[1.01]
    assert judged[1.05]["tangent"].accuses, judged[1.05]


@pytest.mark.parametrize(("decimals", "width"), [(2, 1.0), (3, 1.0), (9, 3e-4), (9, 1e-4)])
def test_a_loss_of_few_decimals_is_not_taken_for_one_without_slope(decimals, width):
    def loss(r):
        return np.round(width**2 * (1 - np.exp(-((r / width) ** 2) / 2)), decimals)

    assert not measured.judge_functions(loss, lambda r: np.exp(-((r / width) ** 2) / 2), formula=False).faults


def test_a_fault_beyond_six_decimals_is_seen():
    found = measured.judge_functions(
        lambda r: np.round(cauchy(r), 6), lambda r: 1.1 / (1 + r * r), formula=False
    )
    assert found["tangent"].accuses, found


def test_numbers_of_half_precision_may_vanish():
    def loss(r):
        return (1 - np.exp(-(np.asarray(r, dtype=float) ** 2) / 2)).astype(np.float16)

    assert not measured.judge_functions(loss, lambda r: np.exp(-r * r / 2), formula=False).faults


def test_every_kind_of_fault_is_drawn():
    kinds = {draw(0, number, mutant=True).fault.split()[0] for number in range(200)}
    assert len(kinds) == len(FAULTS) - 1  # factor 2 and factor 1/2 begin with one word


def test_a_judge_that_accuses_the_sound_is_found_out(monkeypatch):
    """Without an allowance for rounding the campaign is to fail."""
    monkeypatch.setattr(measured, "sampled", without_noise(measured.sampled))
    outcome = run(Settings(100, seed=5, mutants=0))
    assert outcome.measured.accused > 0
    assert not outcome.clean
    assert all("accused" in each["wrong"] for each in outcome.found)


def without_noise(sampled):
    def changed(*arguments):
        found = sampled(*arguments)
        return type(found)(found.values, 0 * found.noise)

    return changed


def test_a_judge_that_overlooks_is_found_out(monkeypatch):
    monkeypatch.setattr(measured, "TOLERANCE", 10.0)
    outcome = run(Settings(40, seed=5, mutants=1))
    assert outcome.clean
    assert not outcome.named
    assert any("not named" in each["wrong"] for each in outcome.found)


def test_an_exception_is_that_of_one_pair(monkeypatch):
    monkeypatch.setattr(campaign, "judge_functions", lambda *args, **kwargs: 1 / 0)
    outcome = run(Settings(3, mutants=0))
    assert (outcome.measured.crashed, outcome.measured.sound) == (3, 0)
    assert not outcome.clean
    assert "ZeroDivisionError" in outcome.found[0]["wrong"]


def test_shards_change_nothing(monkeypatch):
    whole = run(Settings(30, seed=2))
    monkeypatch.setattr(campaign, "SHARD", 7)
    assert run(Settings(30, seed=2)) == whole


def test_a_campaign_that_is_broken_off_goes_on_where_it_was(tmp_path, monkeypatch):
    monkeypatch.setattr(campaign, "SHARD", 10)
    judge, place, numbers = campaign.draw, tmp_path / "kernels.json", []

    def interrupted(seed, number, **options):
        numbers.append(number)
        if number == 25 and numbers.count(25) == 1:
            raise KeyboardInterrupt
        return judge(seed, number, **options)

    options = ["kernels", "--campaign", "40", "--seed", "2", "--mutants", "5", "--json", str(place)]
    monkeypatch.setattr(campaign, "draw", interrupted)
    broken = RUNNER.invoke(app, options)
    assert broken.exit_code == 3, broken.output
    assert "interrupted after 20 of 40 problems; the same command goes on" in broken.stderr, broken.stderr
    assert not place.exists()
    numbers[:] = [25]
    resumed = RUNNER.invoke(app, options)
    assert resumed.exit_code == 0, resumed.output
    assert set(numbers) == set(range(20, 40)), "what the journal keeps is not done again"

    found = json.loads(place.read_text(encoding="utf-8"))
    whole = run(Settings(40, seed=2, mutants=5))
    assert campaign.Tally(**found["measured"]) == whole.measured
    assert (found["undecided"], found["found"], found["lost"]) == (whole.undecided, whole.found, {})
    assert (whole.measured.sound, whole.measured.mutants) == (40, 8)


def test_the_command_runs_the_campaign_and_writes_it(tmp_path):
    place = tmp_path / "kernels.json"
    result = RUNNER.invoke(app, ["kernels", "--campaign", "40", "--seed", "3", "--json", str(place)])
    assert result.exit_code == 0, result.output
    assert (
        "measured: 40 sound pairs, 0 accused; 2 planted faults, 2 caught, 2 named; 0 crashed" in result.output
    )
    data = json.loads(place.read_text(encoding="utf-8"))
    assert data["schema"] == "convexperc/kernels/1"
    assert data["command"] == "python -m verification kernels --campaign 40 --seed 3 --mutants 20 --exact 0"
    assert data["measured"]["sound"] == 40


def test_the_command_fails_where_a_sound_pair_is_accused(monkeypatch):
    monkeypatch.setattr(measured, "sampled", without_noise(measured.sampled))
    result = RUNNER.invoke(app, ["kernels", "--campaign", "60", "--mutants", "0"])
    assert result.exit_code == 1, result.output
    assert "accused" in result.output
