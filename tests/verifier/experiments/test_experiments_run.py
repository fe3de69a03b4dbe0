"""A whole run of the experiments: repeatable, resumable, and not fooled by shuffled labels."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from shutil import copytree
from typing import Any

import jsonschema
import numpy as np
import pytest
from made_up_pictures import collection, write_folder
from typer.testing import CliRunner

from convexperc import Problem, solve
from convexperc.features import extract
from convexperc.features.configuration import NORMALISATIONS
from verification.__main__ import app
from verification.experiments.design import BOTH, Design
from verification.experiments.measure import evaluation
from verification.experiments.measure.configurations import Configuration, first, fraction
from verification.experiments.measure.evaluation import ANY_LENGTH, Task, to_unit_references
from verification.experiments.measure.features import Store, blocks, prepare
from verification.experiments.record.collection import Collection
from verification.experiments.record.rankings import rankings
from verification.experiments.record.reading import packaged
from verification.experiments.record.record import SCHEMA
from verification.experiments.record.run import run
from verification.experiments.record.sensitivity import vacuous
from verification.experiments.scenes.pictures import PictureSet
from verification.provenance import record_digest
from verification.report.schema import experiments_schema

DESIGN = Design(seed=0, repetitions=1, resamples=200)
CONFIGURATIONS = first(2)
RUNNER = CliRunner(env={"COLUMNS": "140", "TERM": "dumb", "NO_COLOR": "1"})


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("features")


def go(cache: Path, journal: Path, given: Collection | None = None, **options: Any) -> dict[str, Any]:
    sets = [collection() if given is None else given]
    settings: dict[str, Any] = {"workers": 1} | options
    return run(
        sets, settings.pop("configurations", CONFIGURATIONS), DESIGN, cache=cache, journal=journal, **settings
    )


@pytest.fixture(scope="module")
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("journal")


@pytest.fixture(scope="module")
def unbroken(cache: Path, journal: Path) -> dict[str, Any]:
    return go(cache, journal)


def test_the_record_follows_its_schema(unbroken: Mapping[str, Any]) -> None:
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    assert schema == experiments_schema(), 'python -c "from verification.report.schema import write; write()"'
    plain = json.loads(json.dumps(unbroken))
    jsonschema.Draft202012Validator(schema).validate(plain)
    assert record_digest(plain) == plain["digest"]
    plain["sets"][0]["readings"][0]["accuracy"][0][0] += 0.1
    assert record_digest(plain) != plain["digest"]


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r["sets"][0]["readings"][0]["accuracy"].pop(),
        lambda r: r["sets"][0]["readings"][1]["accuracy"][0].append(0.5),
        lambda r: r["sets"][0]["readings"][0]["claims"].pop("X8/ten"),
        lambda r: r["sets"][0]["readings"][0]["claims"]["X8/ten"].update(outcome="holds"),
        lambda r: r["sets"][0]["readings"][0]["claims"]["X8/ten"].update(lower="inf"),
        lambda r: r["sets"][0]["claims"]["X1/figure"]["factors"]["hog"].update({"8-pixel cells": [1, 2, 3]}),
        lambda r: r["sets"][0]["default"]["grid"][0][0].update(score=1.5),
        lambda r: r["sets"][0]["default"].update(more=1),
        lambda r: r["sets"][0]["rankings"][0].pop("proved zero"),
        lambda r: r["sets"][0]["limits"]["accuracy"].pop("lbp"),
        lambda r: r["sets"][0].update(name="drawings"),
        lambda r: r["design"]["settings"].pop(),
        lambda r: r.update(digest="0"),
    ],
)
def test_the_schema_refuses_what_is_no_record(unbroken: Mapping[str, Any], change: Any) -> None:
    plain = json.loads(json.dumps(unbroken))
    change(plain)
    assert not jsonschema.Draft202012Validator(experiments_schema()).is_valid(plain)


def test_what_is_easy_is_recognised(unbroken: Mapping[str, Any]) -> None:
    (found,) = unbroken["sets"]
    assert min(found["readings"][0]["accuracy"][3][1:]) == 1.0, found["readings"][0]["accuracy"]
    assert found["levels"] == dict.fromkeys(found["levels"], 2)
    counts = found["default"]["accuracy"][3][5]
    assert (counts["right"], counts["score"]) == (4 * DESIGN.repetitions, 1.0)
    assert found["claims"]["X2/stated"]["counts"][0] == 0, "nothing beats what is nearly always right"
    assert found["default"]["shares"]["full"] < found["default"]["shares"]["none"]


def test_the_outcome_does_not_depend_on_the_workers(
    unbroken: Mapping[str, Any], cache: Path, tmp_path: Path
) -> None:
    assert go(cache, tmp_path, workers=2)["digest"] == unbroken["digest"]


@pytest.fixture
def asked(unbroken: Mapping[str, Any], journal: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the tasks that are done, each at once: what it finds was found by the unbroken run."""
    (place,) = journal.rglob("*.jsonl")
    lines = place.read_text(encoding="utf-8").splitlines()
    entries = [json.loads(line[line.index("{") :]) for line in lines[1:]]
    known = {each["name"]: each["entry"] for each in entries}
    assert len(known) == 2, "the journal of the unbroken run"
    done: list[str] = []

    def evaluate(task: Task) -> dict[str, Any]:
        done.append(task.name)
        return known[task.name]

    monkeypatch.setattr("verification.experiments.record.run.evaluate", evaluate)
    return done


def test_a_broken_run_goes_on_where_it_was(
    unbroken: Mapping[str, Any], asked: list[str], cache: Path, tmp_path: Path
) -> None:
    def breaks(stage: str, done: int, total: int) -> None:
        if (stage, done) == ("configurations", 1):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        go(cache, tmp_path, progress=breaks)
    (kept,) = tmp_path.rglob("*.jsonl")
    before = kept.read_bytes()
    assert len(before.splitlines()) == 2, "the head and one configuration"
    seen = []
    found = go(cache, tmp_path, progress=lambda *each: seen.append(each))
    assert ("configurations", 1, 2) in seen
    assert asked == ["simulation-r000", "simulation-r001"], "what was finished was done again"
    assert kept.read_bytes().startswith(before)
    assert found["digest"] == unbroken["digest"]


def test_a_damaged_journal_is_not_believed(
    unbroken: Mapping[str, Any], asked: list[str], cache: Path, journal: Path, tmp_path: Path
) -> None:
    copied = copytree(journal, tmp_path / "journal")
    (place,) = copied.rglob("*.jsonl")
    head, first, second, *_ = place.read_text(encoding="utf-8").splitlines()
    changed = first.replace('"hog":', '"gray":')
    assert changed != first
    place.write_text("\n".join([head, changed, second[:-20]]))
    assert go(cache, copied)["digest"] == unbroken["digest"]
    assert sorted(asked) == ["simulation-r000", "simulation-r001"], "a damaged line was believed"


def changed(given: PictureSet) -> PictureSet:
    """The same set but for one pixel of its last view."""
    last = given.pictures[-1].copy()
    last[0, 0, 0] ^= 1
    known = list(zip(given.pictures, given.masks, strict=True))
    known[-1] = last, given.masks[-1]
    references = dict(zip(given.layout.objects, known, strict=False))
    scenes = [(scene, known[rows]) for scene, rows in given.layout.rows()]
    return PictureSet.of(given.layout.name, references, scenes, given.source)


def test_one_pixel_changes_the_digest_and_no_features_are_taken_over(
    unbroken: Mapping[str, Any], cache: Path
) -> None:
    given = collection()
    other = replace(given, study=changed(given.study))
    assert unbroken["sets"][0]["digest"] == given.as_json()["digest"] != other.as_json()["digest"]
    block = blocks(CONFIGURATIONS[0])[0]
    assert Store.of(cache, given.study).known(block)
    assert not Store.of(cache, other.study).known(block)


def test_with_shuffled_labels_nothing_is_recognised(cache: Path, tmp_path: Path) -> None:
    given = collection(("red", "green", "blue"))
    objects = given.physical.layout.objects
    rng = np.random.default_rng(0)
    scenes = tuple(
        replace(scene, object=objects[int(rng.integers(3))]) for scene in given.physical.layout.scenes
    )
    layout = replace(given.physical.layout, scenes=scenes)
    found = go(
        cache,
        tmp_path,
        replace(given, physical=replace(given.physical, layout=layout)),
        configurations=first(1),
    )
    (configuration,) = found["sets"][0]["readings"]
    right = np.mean(
        [new.object == old.object for new, old in zip(scenes, given.physical.layout.scenes, strict=True)]
    )
    assert np.mean(configuration["accuracy"]) == pytest.approx(right, abs=0.05), (
        "as often right as the shuffle is"
    )
    assert configuration["claims"]["X2/stated"]["outcome"] == "open", "no scene differs, of a few"


def test_features_are_those_of_the_library(unbroken: Mapping[str, Any], cache: Path, tmp_path: Path) -> None:
    pictures = collection().physical
    store = Store.of(cache, pictures)
    for configuration in CONFIGURATIONS:
        found = store.matrix(configuration)
        shown = [
            store.pictures(configuration.features.working_size, background=configuration.background)[k]
            for k in (0, 9)
        ]
        assert np.array_equal(found[[0, 9]], extract(shown, configuration.features)), configuration
    assert len({store.place(block) for each in fraction() for block in blocks(each)}) == 32
    assert not Store.of(tmp_path, pictures).known(blocks(CONFIGURATIONS[0])[0])


def share_of_critical(cache: Path, configuration: Configuration) -> float:
    """The paper's lambda2 in terms of that from which w = 0: the least of the references by themselves."""
    (part, _) = collection().parts(cache)
    _, known = part.described(configuration)
    return float((BOTH[0] / (2.0 * (known.O**2).sum(axis=0))).min())


@pytest.mark.parametrize("normalisation", NORMALISATIONS)
def test_the_lambdas_are_of_the_scale_of_the_features(
    normalisation: str, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At equal lambdas, long features would make every setting (0, 0), and short ones w nearly 0."""
    chosen = next(each for each in fraction() if each["normalisation"] == normalisation)
    given = collection()
    prepare(given.physical, Store.of(cache, given.physical), [chosen], 1, lambda done, total: None)
    assert 0.01 < share_of_critical(cache, chosen) <= 0.05
    monkeypatch.setattr(evaluation, "to_unit_references", lambda X, references: X)
    if normalisation in ANY_LENGTH:
        assert not 0.01 < share_of_critical(cache, chosen) <= 0.05, "the fault would be seen"


def test_dividing_the_features_is_scaling_the_lambdas() -> None:
    rng = np.random.default_rng(0)
    X = 40.0 * rng.random((7, 12))
    scaled = to_unit_references(X, 3)
    t = X[0, 0] / scaled[0, 0]
    assert np.sqrt((scaled[:3] ** 2).sum(axis=1).mean()) == pytest.approx(1.0)
    sizes, lambdas = {"a": 5, "b": 7}, np.array([0.1, 0.2, 0.3])
    powers = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas * [t**2, t**2, t**3], strict=True))
    own = dict(zip(powers, lambdas, strict=True))
    wanted = solve(Problem(X[3:], X[0], modalities=sizes, **powers))
    found = solve(Problem(scaled[3:], scaled[0], modalities=sizes, **own))
    assert found.certificate.lower * t**2 == pytest.approx(wanted.certificate.lower, rel=1e-8)
    assert found.w == pytest.approx(wanted.w, rel=1e-5)
    assert found.u == pytest.approx(wanted.u * t, rel=1e-4, abs=1e-9)


def test_a_configuration_is_vacuous_where_no_setting_can_be_told_from_another() -> None:
    flat = {"accuracy": [[0.3, 0.5, 0.6]] * 3 + [[0.9, 0.5, 0.6]], "grid": [[0.5] * 5] * 5}
    assert vacuous(flat), "one view tells nothing"
    assert not vacuous(flat | {"accuracy": [*flat["accuracy"][:3], [0.3, 0.5, 0.61]]})
    assert not vacuous(flat | {"grid": [[0.5] * 5] * 4 + [[0.125] * 5]}), "all right at small lambdas"
    found = packaged()
    assert found is not None
    for pictures in found.content["sets"]:
        assert [each["id"] for each in pictures["readings"] if vacuous(each)] == []


def test_with_one_view_and_references_of_one_length_no_lambda_counts() -> None:
    """What R1/one_view proves, in the packaged record: equal scores but where every optimum is 0."""
    found = packaged()
    assert found is not None
    for pictures in found.content["sets"]:
        kept = [each for each in pictures["readings"] if each["levels"]["normalisation"].startswith("unit")]
        assert len(kept) == 64
        for each in kept:
            scores = {
                row[0] for row, open_ in zip(each["accuracy"], each["open"], strict=True) if not open_[0]
            }
            assert len(scores) == 1, each["id"]


def test_rankings_agree_with_what_the_claims_measured_at_the_same_lambdas(
    unbroken: Mapping[str, Any], cache: Path
) -> None:
    found = unbroken["sets"][0]
    by_lambdas = {tuple(each["lambdas"]): each for each in found["rankings"]}
    paper = by_lambdas[0.1, 0.1]
    assert paper["visible"] == found["limits"]["visible"]["default"]
    share = found["readings"][0]["claims"]["X1/figure"]["statistic"] + 0.8
    assert paper["three"] == pytest.approx(share, abs=1e-5)
    hidden = [v.obstruction == "full" for s in collection().physical.layout.scenes for v in s.views]
    assert {each["full"] for each in by_lambdas.values()} == {sum(hidden)}
    assert by_lambdas[0.0, 0.0]["proved zero"] <= paper["proved zero"] <= sum(hidden)
    parts = collection().parts(cache)
    again = rankings(*parts, CONFIGURATIONS[0])
    assert again == found["rankings"]


# ---------- the command


def test_the_command_writes_the_record(tmp_path: Path) -> None:
    given = collection()
    options = ["experiments", "--configurations", "1", "--repetitions", "1", "--workers", "1"]
    options += ["--simulation", str(write_folder(tmp_path / "a", given.physical))]
    options += [
        "--case-study",
        str(write_folder(tmp_path / "b", given.study)),
        "--out",
        str(tmp_path / "out"),
    ]
    result = RUNNER.invoke(app, options)
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "out" / "experiments.json").read_text(encoding="utf-8"))
    assert record_digest(found) == found["digest"]
    assert str(tmp_path) not in json.dumps(found), "a path of this machine"
    assert "X8/peak" in result.output
    first_time = found["volatile"]["seconds"]["readings"]
    again = RUNNER.invoke(app, options)
    assert again.exit_code == 0, again.output
    repeated = json.loads((tmp_path / "out" / "experiments.json").read_text(encoding="utf-8"))
    assert (repeated["digest"], repeated["volatile"]["seconds"]["readings"]) == (found["digest"], 0)
    assert first_time > 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--simulation", "."], "go together"),
        (["--no-simulate"], "nothing is left"),
        (["--no-simulate", "--photos", "."], "at least two objects"),
        (["--no-simulate", "--photos", ".", "--configurations", "129"], "from 1 to 128"),
        (["--simulation", ".", "--case-study", "."], "has finished"),
        (["--photos", "nowhere"], "does not exist"),
    ],
)
def test_misuse_is_told(
    options: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "pictures").mkdir()
    monkeypatch.chdir(tmp_path / "pictures")
    result = RUNNER.invoke(app, ["experiments", *options, "--out", "../out"])
    assert result.exit_code == 2, result.output
    assert message in " ".join(result.output.replace("│", " ").split()), result.output
