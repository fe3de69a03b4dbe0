"""The documents: examples run and print what is proved; every link, picture, file and name is there."""

import ast
import json
import math
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name

import pytest

import convexperc
from convexperc.problem import read_problem
from verification.experiments.record.reading import PACKAGED, packaged
from verification.ledger.baseline import read_baseline
from verification.ledger.claims import CAUSES, CLAIMS, Voice
from verification.ledger.evidence import Verdict
from verification.ledger.surveys import DECIDING
from verification.ledger.verdicts import survey_judgement

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMANDS = (
    "    python3 -m venv .venv && .venv/bin/python -m pip install -q -c constraints.txt -e '.[test]'"
    " && .venv/bin/python -m verification report\n",
    "    python3 -m venv .venv && .venv/bin/python -m pip install -q -c constraints.txt -e '.[test]'"
    " && .venv/bin/python -m pytest\n",
)
"""What continuous integration and users copy, verbatim."""


def text(name: str | Path) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def blocks(document: str | Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text(document), re.DOTALL)


def readme(lines: list[str]) -> None:
    assert lines[0].startswith("proved: lowest optimum ica-sign ['robot-3', 'robot-4', 'robot-1'"), lines


def python(lines: list[str]) -> None:
    assert lines[0].startswith("Status.CERTIFIED"), lines
    lower, upper = map(float, lines[0].split()[1:])
    assert lower <= upper <= lower * (1 + 1e-9), lines
    assert float(lines[2]) > 1e-9, lines
    label = re.fullmatch(r"Verdict.PROVED (object \d+) (\d+) of 1000 solved to the end", lines[3])
    assert label is not None, lines
    assert 0 < int(label[2]) < 1000, lines
    assert lines[4] == f"Verdict.PROVED {label[1]}", lines
    certified, gap = lines[5].split()
    assert certified == "True", lines
    assert float(gap) < 1e-8, lines
    assert len(ast.literal_eval(lines[6])) == 5, lines
    assert ast.literal_eval(lines[7])[0] == label[1], lines
    below, width, bits = lines[8].split()
    assert (below, bits) == ("True", "128"), lines
    assert float(width) < 1e-12, lines
    assert lines[9].startswith("[ True  True  True  True  True  True] "), lines
    low, high, runner_up = lines[10].replace("(", "").replace(")", "").replace(",", "").split(maxsplit=2)
    assert 0.0 < float(low) <= float(high) < 1.0, lines
    assert runner_up not in {"None", label[1]}, lines
    assert len(lines[11]) > 0, lines
    statement, explained = lines[12].split(" (")
    assert statement == "proved: lowest optimum", lines
    assert 0.0 < float(explained.split(",")[0]) < 1.0, lines
    assert re.match(r"(object \d+|None) \(0\.", lines[13]), lines
    acceptance, accepted = lines[14].split(maxsplit=1)
    assert (acceptance == "Acceptance.RECOGNISED") == (ast.literal_eval(accepted) == (label[1],)), lines
    assert [line.split()[:3] for line in lines[15:-1]] == [
        [name, "Verdict.PROVED", name] for name in ("red-car", "gray-car", "ica-sign")
    ], lines
    assert lines[-1] == "ProblemError lambda1 must be a finite real number >= 0", lines


def certificates(lines: list[str]) -> None:
    lower, upper, width, bits = map(float, lines[0].split())
    assert lower <= upper, lines
    assert width < 1e-12, lines
    assert bits == 128, lines
    for line in lines[1:3]:
        determined, least, weight, most = line.split()
        assert determined == "True", lines
        assert float(least) <= float(most), lines
        assert abs(float(weight) - float(least)) < 1e-12, lines  # w is not w*: it may lie beside the interval
    assert lines[3].endswith("all determined"), lines


def solvers(lines: list[str]) -> None:
    assert [line.split()[0] for line in lines[:3]] == ["newton", "cvxpy+clarabel", "osqp"], lines
    assert all("Status.CERTIFIED" in line for line in lines[:3]), lines
    assert float(lines[3].split()[-1]) > 1e-9, lines


def lasso(lines: list[str]) -> None:
    lower, upper, share = map(float, lines[0].split())
    assert lower < upper < lower * (1 + 2 * share), lines
    certified, zeros = lines[1].split()
    assert certified == "True", lines
    assert 100 < int(zeros) < 200, lines
    assert lines[2].startswith("||y - Xb - b0||^2 / (2n) + alpha * l1_ratio"), lines


def cvxpy(lines: list[str]) -> None:
    lower, value, upper = map(float, lines[0].split())
    assert lower <= upper, lines
    assert lower * (1 - 1e-6) <= value <= upper * (1 + 1e-6), lines
    certified, share = lines[1].split()
    assert certified == "True", lines
    assert upper - lower <= float(share) * lower, lines


def scikit_learn(lines: list[str]) -> None:
    assert 0.85 < float(lines[0]) <= 1.0, lines
    proved, digit, reference, views = re.fullmatch(
        r"(proved: lowest optimum) (\d) (\d)/row \d+ (\[.*\])", lines[1]
    ).groups()  # type: ignore[union-attr]
    assert (proved, digit) == ("proved: lowest optimum", reference), lines
    assert sorted(ast.literal_eval(views)) == ["robot 1", "robot 2", "robot 3", "robot 4"], lines
    assert lines[2] == "{'lambda2': 0.01}", lines


EXAMPLES: dict[str, Callable[[list[str]], None]] = {
    "README.md": readme,
    "docs/python.md": python,
    "docs/certificates.md": certificates,
    "docs/lasso.md": lasso,
    "docs/cvxpy.md": cvxpy,
    "docs/scikit-learn.md": scikit_learn,
    "docs/solvers.md": solvers,
}
"""What the examples of each document print; those of one document continue one another."""


ELSEWHERE = {"docs/robots.md", "docs/conformance.md", "docs/reweighted.md"}
"""Run by tests of their own: test_robots_page.py, test_solver_templates.py, test_reweighted_page.py."""


@pytest.mark.parametrize("document", EXAMPLES)
def test_the_examples_run_and_print_what_is_proved(interpreter, document):
    done = interpreter.run("".join(blocks(document, "python")))
    assert done.returncode == 0, done.stderr
    EXAMPLES[document](done.stdout.splitlines())


def test_no_example_is_left_out():
    found = {str(each.relative_to(ROOT)) for each in DOCUMENTS if blocks(each, "python")}
    assert found == {*EXAMPLES, "CONTRIBUTING.md", *ELSEWHERE}, found


def test_the_example_of_workers_elsewhere_names_what_there_is():
    imports = [
        each
        for each in ast.walk(ast.parse("".join(blocks("CONTRIBUTING.md", "python"))))
        if isinstance(each, ast.ImportFrom)
    ]
    names = [resolve_name(f"{each.module}:{name.name}") for each in imports for name in each.names]
    assert len(names) >= 2, "the example imports nothing"


def test_the_problem_of_the_command_line_page_can_be_read(tmp_path):
    (written,) = blocks("docs/command-line.md", "json")
    (tmp_path / "problem.json").write_text(written, encoding="utf-8")
    found = read_problem(tmp_path / "problem.json")
    assert found.id == json.loads(written)["id"]
    assert found.problem.modalities.names == ("color", "lbp")


def test_the_readme_is_short_and_keeps_both_commands():
    found = text("README.md")
    assert len(found.splitlines()) <= 100
    assert all(found.count(command) == 1 for command in COMMANDS)
    (example,) = blocks("README.md", "python")
    assert len([line for line in example.splitlines() if line]) <= 6, example


def anchors(document: Path) -> set[str]:
    """What GitHub makes of the headings."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda each: each.name)
def test_every_link_and_picture_is_there(document):
    prose = re.sub(r"```.*?```", "", text(document), flags=re.DOTALL)
    links = re.findall(r"!?\[[^\]]*\]\(([^)\s]+)\)", prose)
    for link in links:
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (document.parent / path).resolve() if path else document
        assert target.exists(), link
        assert target.is_relative_to(ROOT), link
        assert not anchor or anchor in anchors(target), (link, anchors(target))
    assert all(alt for alt in re.findall(r"!\[([^\]]*)\]", prose)), "a picture without a description"


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda each: each.name)
def test_every_file_and_name_in_code_is_there(document):
    for code in re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", text(document), flags=re.DOTALL)):
        path = re.fullmatch(r"(convexperc|verification|tests|docs|reports|\.ci)/[\w./-]*", code)
        # A schema is called like convexperc/proof/1; a folder of bytecode is there once something has run.
        if path and not re.search(r"NAME|/\d$|__pycache__", code):
            assert (ROOT / code).exists(), code
        if re.fullmatch(r"convexperc(\.\w+)+", code):
            resolve_name(code)


def test_the_page_of_the_verifier_has_the_verdicts_of_the_baseline():
    rows = re.findall(r"^\| ([A-Z]\w+) \| [^|]* \| ([a-z ]+) \|", text("docs/verifier.md"), re.MULTILINE)
    expected = read_baseline()
    told = {key: verdict for key, verdict in rows if key in CLAIMS}
    assert told == {key: expected[key] for key in told}
    missing = [key for key, each in CLAIMS.items() if each.voice is not Voice.PROMISE and key not in told]
    assert missing == [f"X{k}" for k in range(1, 9)], "those have a page of their own"


def test_the_readme_counts_the_claims_as_the_baseline_does():
    expected = read_baseline()
    about = [key for key, each in CLAIMS.items() if each.voice is Voice.PAPER and not each.surveyed]
    counts = Counter(expected[key] for key in about)
    words = {1: "one", 2: "two", 3: "three", 8: "eight"}
    told = " ".join(text("README.md").split())
    assert f"the paper's {len(about)} claims about formulation and algorithm" in told
    phrases = {
        Verdict.HOLDS: "holds",
        Verdict.HOLDS_UNDER: "holds under a condition",
        Verdict.SUPPORTED: "is supported by cases",
        Verdict.REFUTED: "are refuted",
    }
    for verdict, phrase in phrases.items():
        assert f"{words[counts[verdict]]} {phrase}" in told, verdict
    surveyed = Counter(expected[key] for key, each in CLAIMS.items() if each.surveyed)
    assert surveyed == {
        Verdict.REPRODUCED: 2, Verdict.WHERE_DECIDED: 1, Verdict.DEPENDS: 1, Verdict.INCONCLUSIVE: 2,
        Verdict.NOT_REPRODUCED: 2,
    }  # fmt: skip
    assert (
        "Of its eight claims about experiments, judged on simulated scenes with photographs beside them, two"
        " are reproduced (one of them in its direction alone) and one where the data decide; one depends on a"
        " choice that the paper leaves open,"
        " two remain undecided, and two are not reproduced" in told
    )
    causes = {cause for key in about if expected[key] is Verdict.REFUTED for cause in CLAIMS[key].causes}
    assert causes == set(CAUSES), "six causes, as the text says"
    assert all(CLAIMS[key].causes for key in about if expected[key] is Verdict.REFUTED)


def test_the_page_of_the_experiments_has_the_counts_of_the_record():
    rows = dict(re.findall(r"^\| (X\d/\w+) \| [^|]* \| (.*) \|$", text("docs/experiments.md"), re.MULTILINE))
    found = packaged()
    assert set(rows) == {each.part for each in found.surveys}
    for each in found.surveys:
        cells = [cell.strip() for cell in rows[each.part].split("|")]
        verdict, counts, agreeing = cells[:3] if each.pictures == DECIDING else cells[3:]
        judged = survey_judgement(each)
        assert counts == ", ".join(map(str, each.tally)), each.part
        assert agreeing == str(each.agreeing), each.part
        assert verdict == f"{judged.verdict.value} {judged.condition.partition(':')[0]}".strip(), each.part


def test_the_page_of_the_experiments_states_the_protocol_of_the_record():
    page, record = text("docs/experiments.md"), json.loads(PACKAGED.read_text())
    assert record["volatile"]["command"] in page
    design, sets = record["design"], {each["name"]: each for each in record["sets"]}
    assert f"n = {design['counts'][0]}..{design['counts'][-1]} views | {design['repetitions']} for" in page
    assert f"{design['resamples']:,}, seed {design['seed']} |" in page
    assert ", ".join(f"({a:g}, {b:g})" for a, b in design["settings"]) in page
    assert ", ".join(f"{value:g}" for value in design["grid"]) in page
    combinations = math.prod(map(len, design["factors"].values()))
    for each in sets.values():
        assert (len(each["readings"]), combinations) == (128, 1024)
        assert (len(each["objects"]), each["scenes"], each["views"], len(each["levels"])) == (8, 240, 1440, 5)
    assert "128 of 1,024 |" in page
    for name in ("simulation", "photographs"):
        study = sets[name]["case_study"]
        said = f"{len(study['objects'])} objects, {study['scenes']} scenes, {study['views']} views"
        assert said in page, said
    assert {*sets["photographs"]["source"]["photographs"].values()} == {16}


def test_the_tree_of_the_architecture_is_that_of_the_files():
    tree = next(block for block in blocks("docs/architecture.md", "text") if block.startswith("convexperc/"))
    inside = {line.split()[0].strip("/") for line in tree.splitlines() if line.startswith("  ")}
    hidden = {"__init__.py", "__init__.pyi", "__main__.py", "__pycache__", "py.typed"}
    assert inside == {each.name for each in (ROOT / "convexperc").iterdir()} - hidden
    assert all((ROOT / line.split()[0]).is_dir() for line in tree.splitlines() if not line.startswith("  "))


def test_the_reference_has_a_page_for_each_public_face_and_lists_all_public_names():
    faces = {
        ".".join(each.relative_to(ROOT).parts[:-1]) for each in (ROOT / "convexperc").rglob("__init__.pyi")
    }
    pages = {page.stem for page in (ROOT / "docs" / "api").glob("*.rst")} - {"index"}
    assert pages == faces - {"convexperc"} | {"convexperc.errors", "convexperc.files"}
    listed = re.findall(r"^   ~convexperc\.\w+\.(\w+)$", text("docs/api/index.rst"), re.MULTILINE)
    assert sorted(listed) == sorted(convexperc.__all__)


def test_the_reference_builds_without_a_warning(tmp_path):
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "-q",
        "-b",
        "html",
        str(ROOT / "docs" / "api"),
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
