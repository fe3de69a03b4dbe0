"""Provenance: what a digest of code depends on, and what it does not."""

import subprocess
import sys
from pathlib import Path

import grimp
import pytest

from verification import provenance

CODE = '''"""A module."""

LIMIT = 1.5
"""A limit."""


def double(x: float) -> float:
    """Twice x."""
    return 2 * x  # exactly
'''


@pytest.fixture
def top(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(provenance, "TOP", tmp_path)
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "module.py").write_text(CODE)
    (tmp_path / "code" / "rules.toml").write_text("share = 0.8\n")
    return tmp_path / "code"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Twice x.", "The double of x."),
        ("# exactly", ""),
        ("\n\n\ndef", "\n\n\n\n# a comment\n\ndef"),
        ('"""A limit."""\n', ""),
        ("return 2 * x", "return (2 * x)"),
    ],
)
def test_documentation_does_not_change_the_digest_of_code(top: Path, old: str, new: str) -> None:
    before = provenance.code_digest("code")
    assert old in CODE
    (top / "module.py").write_text(CODE.replace(old, new))
    assert provenance.code_digest("code") == before


@pytest.mark.parametrize(
    ("old", "new"),
    [("1.5", "1.25"), ("2 * x", "2 + x"), ("2 * x", "x * 2"), ("double", "twice"), ("LIMIT = 1.5", "")],
)
def test_any_change_of_code_changes_its_digest(top: Path, old: str, new: str) -> None:
    before = provenance.code_digest("code")
    (top / "module.py").write_text(CODE.replace(old, new))
    assert provenance.code_digest("code") != before


def test_files_and_their_names_count_and_texts_do_not(top: Path) -> None:
    seen = [provenance.code_digest("code")]
    (top / "notes.md").write_text("A note.\n")
    assert provenance.code_digest("code") == seen[0], "a text is no code"
    for change in ("rules.toml", "more.py"):
        (top / change).write_text("share = 0.9\n")
        seen.append(provenance.code_digest("code"))
    (top / "more.py").rename(top / "other.py")
    seen.append(provenance.code_digest("code"))
    assert len(set(seen)) == len(seen), seen


def test_a_folder_can_be_left_out(top: Path) -> None:
    before = provenance.code_digest("code")
    (top / "other").mkdir()
    (top / "other" / "module.py").write_text(CODE)
    assert provenance.code_digest("code") != before
    assert provenance.code_digest("code", without="code/other") == before


@pytest.mark.parametrize("subject", provenance.SUBJECTS)
def test_every_place_of_a_subject_is_there(subject: str) -> None:
    for place in provenance.SUBJECTS[subject]:
        assert (provenance.TOP / place).exists(), place


MAKERS = {
    "accuracy": ["accuracy.measure", "accuracy.record"],
    "campaign": ["search.certify"],
    "benchmark": ["bench.run", "bench.floor", "bench.picture_frames", "bench.proof_times"],
    "faults": ["faults.hunt", "faults.own"],
    "kernels": ["reweighted.terms.campaign", "reweighted.terms.kernels"],
    "lassos": ["lassos.campaign"],
    "report": ["run.stages"],
}
"""What finds what the files of a subject say."""


@pytest.fixture(scope="module")
def graph() -> grimp.ImportGraph:
    return grimp.build_graph("convexperc", "verification")


@pytest.mark.parametrize("subject", provenance.SUBJECTS)
def test_a_subject_has_all_code_that_its_makers_import(subject: str, graph: grimp.ImportGraph) -> None:
    """Only what stamps the files is left out."""
    makers = {f"verification.{name}" for name in MAKERS[subject]}
    modules = makers.union(*(graph.find_upstream_modules(maker) for maker in makers))
    paths = {provenance.TOP.joinpath(*name.split(".")) for name in modules}
    needed = {path.with_suffix(".py") for path in paths if path.with_suffix(".py").exists()}
    places = [provenance.TOP / place for place in provenance.SUBJECTS[subject]]
    listed = {file for place in places for file in (place.rglob("*.py") if place.is_dir() else [place])}
    missing = {file.relative_to(provenance.TOP).as_posix() for file in needed - listed}
    assert missing <= {"verification/provenance.py"}, missing
    assert needed & listed, subject


@pytest.mark.parametrize("data", [{}, {"made": {}}, {"made": {"code": "0"}}, {"volatile": {}}])
def test_a_file_without_the_stamp_of_the_present_code_is_not_current(data: dict[str, object]) -> None:
    assert not provenance.is_current(data, "campaign")


def test_a_stamp_is_the_same_in_another_process() -> None:
    script = "from verification.provenance import stamp; print(stamp('campaign')['code'])"
    told = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert told.stdout.strip() == provenance.stamp("campaign")["code"]


def test_canonical_text_refuses_what_is_no_number() -> None:
    assert provenance.canonical({"b": 1, "a": [0.5]}) == b'{"a":[0.5],"b":1}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        provenance.canonical({"a": float("nan")})
