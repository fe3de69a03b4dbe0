"""The page of findings: what it says is what the kit found, and its commands can be run."""

import json
import shlex
from pathlib import Path

import pytest

from verification.conformance import adapters
from verification.conformance.findings import PEERS, Peer, findings, markdown
from verification.conformance.generated import BACKENDS
from verification.conformance.vectors import VERSION

REPORTS = Path(__file__).parents[3] / "reports"


def test_every_peer_has_its_adapter():
    assert all(callable(getattr(adapters, peer.adapter)) for peer in PEERS if not peer.generated)
    assert {shlex.split(peer.adapter)[1] for peer in PEERS if peer.generated} == set(BACKENDS)
    assert len({(peer.name, peer.tolerance) for peer in PEERS}) == len(PEERS)


def test_the_committed_page_is_that_of_the_committed_record():
    record = json.loads((REPORTS / "conformance.json").read_text("utf-8"))
    assert record["vectors"] == VERSION
    assert [row["name"] for row in record["solvers"]] == [peer.name for peer in PEERS]
    assert not [row for row in record["solvers"] if "absent" in row]
    assert markdown(record) == (REPORTS / "conformance.md").read_text("utf-8")
    controls = record["solvers"][:2]
    assert all(row["smallest"] is None and row["reached"] == "L3" for row in controls), controls


@pytest.mark.filterwarnings("ignore")
def test_a_run_tells_counts_declined_requests_and_absent_peers():
    peers = (
        Peer("sklearn_lasso", "a lasso", "1e-4", ("scikit-learn",), "sklearn"),
        Peer("library", "nobody has it", "none", ("numpy",), "no_such_module"),
    )
    record = findings(peers, ())
    lasso, absent = record["solvers"]
    assert (
        lasso["declined"] + lasso["levels"]["L2"]["held"] + lasso["levels"]["L2"]["failed"] == lasso["asked"]
    )
    assert lasso["levels"]["L1"]["failed"] > 0, "its default tolerance is 1e-4"
    assert json.loads(lasso["smallest"]["request"])["lambda1"] == 0.0
    assert "no_such_module" in absent["absent"]
    page = markdown(record)
    assert lasso["smallest"]["id"] in page
    assert "Not run: nobody has it" in page
