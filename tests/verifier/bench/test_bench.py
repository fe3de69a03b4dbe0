"""The benchmark poses every peer rightly and judges it rightly; no test looks at a time."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from convexperc.certificate.certificate import certify
from verification.bench.floor import Growth, frame_times
from verification.bench.growth_plot import growth_plot
from verification.bench.instances import LAMBDAS, SHAPES, TINY, Instance
from verification.bench.peers import ABSENT, OURS, PEERS, Peer
from verification.bench.picture_frames import PictureTimes
from verification.bench.posed import Ours, Posed
from verification.bench.proof_times import proof_times
from verification.bench.reduced_gap import value_and_gap
from verification.bench.run import GAP, Outcome, Sample, isolated, measure, proved_bounds
from verification.bench.screen import (
    as_json,
    frames_table,
    growth_table,
    machine,
    peers_table,
    pictures_table,
    proofs_table,
)

INSTANCE = Instance.of(TINY)
SLOW = ("skglm, reduced", "cvxpy+clarabel, cold")  # compile for seconds; dpp poses the same model
FAST = [peer for peer in PEERS.values() if peer.name not in SLOW and "paper" not in peer.name]


class Wrong(Ours):
    """A peer whose w is off by a thousandth: the judge must see it."""

    def point(self, found):
        w, u = super().point(found)
        return w * (1.0 + 1e-3), u


def gathered(peer):
    facts = {"samples": [], "setups": []}

    def send(key, value):
        if key in ("samples", "setups"):
            facts[key].append(value)
        else:
            facts[key] = value

    bounds = proved_bounds(INSTANCE, 1)
    measure(peer, TINY, bounds, 1, 1, send)
    return {(s.lambdas, s.template): s for s in facts["samples"]}, facts


def test_instances_are_what_they_say():
    for rows in (INSTANCE.X, INSTANCE.O.T):
        assert (rows >= 0.0).all()
        for columns in INSTANCE.modalities:
            np.testing.assert_allclose(np.linalg.norm(rows[:, columns], axis=1), 1.0)
    assert np.array_equal(INSTANCE.X, Instance.of(TINY).X)
    assert {"S", "M", "L", "XL", "P"} == set(SHAPES)


def test_reduced_form_keeps_the_products_and_the_norms():
    reduced, rng = INSTANCE.reduced, np.random.default_rng(0)
    z = [rng.standard_normal(rank) for rank in reduced.ranks]
    _, u = reduced.point(np.concatenate([np.zeros(TINY.n), *z]))
    for columns, L, z_i in zip(INSTANCE.modalities, reduced.L, z, strict=True):
        np.testing.assert_allclose(INSTANCE.X[:, columns] @ u[columns], L @ z_i, atol=1e-12)
        assert np.linalg.norm(u[columns]) == pytest.approx(np.linalg.norm(z_i))


@pytest.mark.parametrize("peer", FAST, ids=lambda peer: peer.name)
def test_each_peer_reaches_the_gap(peer):
    if peer.left_out(1):
        pytest.skip(peer.left_out(1))
    found, facts = gathered(peer)
    assert len(found) == len(LAMBDAS)
    assert max(sample.gap for sample in found.values()) <= GAP
    assert facts["ready"]
    assert len(facts["setups"]) >= len(LAMBDAS)


def test_a_wrong_point_does_not_reach_the_gap():
    found, _ = gathered(Peer("wrong", Wrong, (1e-9,)))
    assert all(sample.gap > GAP for sample in found.values())
    assert Outcome("wrong", samples=list(found.values())).missed == len(LAMBDAS)


@pytest.mark.parametrize("factor", [1.0, 1.01])
def test_the_gap_of_the_reduced_data_encloses_the_same_optimum(factor):
    posed = Ours(INSTANCE, LAMBDAS[0], 1e-12)
    [_, (_, found)] = posed.run([0, 1])
    w, u = posed.point(found)
    value, gap = value_and_gap(INSTANCE, 1, LAMBDAS[0], factor * w, u)
    best = certify(INSTANCE.problem(1, LAMBDAS[0]), w, u)
    judged = certify(INSTANCE.problem(1, LAMBDAS[0]), factor * w, u)
    assert value == pytest.approx(judged.objective[1], rel=1e-12)
    assert value - gap <= best.upper * (1.0 + 1e-12)
    assert gap >= judged.objective[0] - best.upper - 1e-12
    assert gap < 1e-8 or factor != 1.0


def test_a_missing_package_and_a_size_are_remarks_not_errors():
    peer = Peer("none", Posed, (1e-9,), ("no_such_package",))
    assert isolated(peer, TINY, {}, templates=1, repeat=1, limit=1.0).remark.endswith("extra bench")
    small = Peer("small", Posed, (1e-9,), most=10.0)
    assert "left out" in isolated(small, TINY, {}, templates=1, repeat=1, limit=1.0).remark


def test_a_peer_is_stopped_at_its_limit():
    outcome = isolated(PEERS[OURS], TINY, proved_bounds(INSTANCE, 1), templates=1, repeat=1, limit=60.0)
    assert not outcome.remark
    assert len(outcome.samples) == len(LAMBDAS)
    paper = PEERS["paper, printed, direct"]
    stopped = isolated(paper, replace(SHAPES["S"], p=1), {}, templates=1, repeat=1, limit=0.2)
    assert stopped.remark == "stopped after 0.2 s"


def test_tables_and_json_hold_what_was_found():
    sample = Sample(LAMBDAS[0], 0, 1e-9, 1e-3, 2e-9)
    outcomes = [Outcome(OURS, [replace(sample, gap=1e-10)]), Outcome("other", [sample], remark="stopped")]
    frame = frame_times(INSTANCE, 1)
    line = Growth("n", (1, 10), (1.0, 10.0), (1.0, 1000.0))
    assert line.exponents == pytest.approx((1.0, 3.0))
    assert peers_table(TINY, outcomes).row_count == 2 + len(ABSENT)
    assert frames_table({"tiny": frame}).row_count == growth_table([line]).row_count == 1
    proofs, seen = proof_times(INSTANCE, 1), PictureTimes(0.5, (0.2, 0.1), (0.1, 0.1), (0.1, 0.1), 2)
    assert proofs_table("tiny", proofs).row_count == len(LAMBDAS)
    assert all(each.enclosed_width < 1e-25 < each.relative_width < 1e-8 for each in proofs), proofs
    assert pictures_table(seen).row_count == 1
    data = as_json({"tiny": outcomes}, {"tiny": frame}, [line], {"tiny": proofs}, seen, {"code": "0"})
    assert json.loads(json.dumps(data, allow_nan=False))["frames"]["tiny"]["labelled"] == frame.labelled
    assert data["made"] == {"code": "0"}, "what made it stands in it"
    assert data["peers"]["tiny"][1]["first_call"] is None
    assert math.isnan(outcomes[0].first_call)
    assert not any("/" in text for text in machine()["blas"])


@pytest.mark.parametrize(("kind", "head"), [("png", b"\x89PNG"), ("svg", b"<?xml")])
def test_the_growth_is_drawn(kind, head):
    lines = [Growth(size, (1, 10), (1e-3, 1e-2), (1e-3, 1.0)) for size in "ndmp"]
    drawn = growth_plot(lines, kind)
    assert drawn.startswith(head)
    assert drawn == growth_plot(lines, kind)


def test_powers_of_ten_are_drawn_as_such():
    lines = [Growth(size, (1, 10), (1e-3, 1e-2), (1e-3, 1.0)) for size in "ndmp"]
    text = growth_plot(lines, "svg").decode()
    labels = re.findall(r"<!-- \$\\mathdefault\{10\^\{\d+\}\}\$ -->(.*?)</g>\s*</g>", text, re.DOTALL)
    assert len(labels) >= 3, "the labels of the times"
    for label in labels:
        assert label.count("<use") == 3, label  # 1, 0 and the exponent, not the signs of the formula


def test_the_whole_frame_is_recognised_and_mostly_pruned():
    frame = frame_times(Instance.of(replace(SHAPES["P"], p=600)), 1)
    assert frame.labelled == len(LAMBDAS)
    assert frame.full[0] < 100, frame
