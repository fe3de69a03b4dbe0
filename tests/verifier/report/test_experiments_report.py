"""The stored experiments: damaged or inconsistent records are refused, verdicts follow the rule,"
" pages are whole."""

import hashlib
import json
import re
from copy import deepcopy
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import cv2
import jsonschema
import numpy as np
import pytest
from made_up import evidence, judged, series
from made_up_experiments import PARTS_X, experiments_record, sealed, written
from matplotlib.figure import Figure
from test_report import EVIL, Page
from typer.testing import CliRunner

from convexperc.errors import FileFormatError, InputError
from verification import report
from verification.__main__ import app
from verification.experiments.record.contact_sheets import read_sheets, sheet_files
from verification.experiments.record.reading import PACKAGED, checked, packaged, read_experiments
from verification.ledger.baseline import read_baseline
from verification.ledger.claims import PARTS, PROTOCOL, Role
from verification.ledger.evidence import Evidence, Verdict
from verification.ledger.rules import Rule
from verification.ledger.surveys import Comparison, Survey, Tally
from verification.ledger.verdicts import judge_all, judge_part, judge_surveys, survey_judgement
from verification.report import words
from verification.report.experiments import figures
from verification.report.experiments.figures import spaced
from verification.report.experiments.pages import experiment_files, publish
from verification.report.experiments.sheets import BUDGET, contact_sheets
from verification.report.experiments.summary import summary
from verification.report.write import files

RUNNER = CliRunner(env={"COLUMNS": "200", "TERM": "dumb", "NO_COLOR": "1"})
DECIDED = Comparison("reproduced", 0.2, 0.1, 0.3, "n = 3", 15, 240, 0)


@pytest.fixture(scope="module")
def record():
    return experiments_record()


@pytest.fixture(scope="module")
def found(record):
    return checked(record, "experiments.json")


@pytest.fixture(scope="module")
def pages(found):
    return experiment_files(replace(found, sheets={"2-case": b"\xff\xd8 no picture"}))


def survey(*counts, pictures="simulation", part="X2/stated", levels=None):
    tally = Tally(*counts)
    return Survey(
        part, pictures, tally, 0, tally.reproduced, DECIDED, levels or {}, "0" * 64, "1" * 64, "command"
    )


@pytest.mark.parametrize(
    ("counts", "expected"),
    [
        ((19, 0, 1, 0), Verdict.REPRODUCED),
        ((18, 0, 0, 2), Verdict.WHERE_DECIDED),
        ((17, 1, 1, 1), Verdict.DEPENDS),
        ((1, 0, 19, 0), Verdict.OPPOSITE),
        ((1, 10, 9, 0), Verdict.NOT_REPRODUCED),
        ((0, 0, 0, 1), Verdict.INCONCLUSIVE),
    ],
)
def test_the_simulation_decides_and_photographs_stand_beside_it(counts, expected):
    part, other = PARTS["X2/stated"], survey(0, 5, 0, 0, pictures="photographs")
    found = judge_surveys(part, [other, survey(*counts)])
    assert found.verdict is survey_judgement(survey(*counts)).verdict is expected
    assert "photographs: not reproduced" in found.reason, found
    assert judge_surveys(part, [other]).verdict is Verdict.NOT_TESTABLE


def test_the_verdict_names_the_factor_that_it_depends_on():
    levels = {"hog": {"8": Tally(9, 0, 1, 0), "16": Tally(1, 9, 0, 0)}}
    found = judge_surveys(PARTS["X2/stated"], [survey(10, 9, 1, 0, levels=levels)])
    assert found.verdict is Verdict.DEPENDS
    assert found.condition == "the cells of HOG: reproduced in 9 of 10 with 8; reproduced in 1 of 10 with 16"
    alone = judge_surveys(PARTS["X2/stated"], [survey(10, 9, 1, 0)])
    assert alone.condition == "the configuration; no single factor decides"


def test_a_figure_that_is_missed_is_not_reproduced_and_has_no_opposite():
    assert survey_judgement(survey(0, 0, 9, 0, part="X6/zero")).verdict is Verdict.NOT_REPRODUCED
    assert survey_judgement(survey(0, 0, 9, 0, part="X6/direction")).verdict is Verdict.OPPOSITE


def test_one_more_configuration_against_it_changes_the_verdict_of_a_whole_record():
    for outcomes, expected in (
        (["no effect"] * 8, "not reproduced"),
        (["no effect", "reproduced"] * 4, "depends on"),
    ):
        made = checked(experiments_record(outcomes={"X3/stated": outcomes}), "experiments.json")
        found = judge_all(Evidence(surveys=list(made.surveys)))
        assert found["X3"].verdict == found["X3/stated"].verdict == expected


@pytest.mark.parametrize(
    ("lbp", "hog", "expected"),
    [
        ("reproduced", "reproduced", Verdict.REPRODUCED),
        ("reproduced", "no effect", Verdict.NOT_REPRODUCED),
        ("open", "opposite", Verdict.OPPOSITE),
        ("reproduced", "open", Verdict.INCONCLUSIVE),
        (None, "reproduced", Verdict.NOT_TESTABLE),
    ],
)
def test_a_claim_is_as_weak_as_its_weakest_stated_part(lbp, hog, expected):
    told = {"X7/lbp": lbp, "X7/hog": hog, "X7/figure": "opposite"}
    planted = {key: [outcome] * 8 for key, outcome in told.items() if outcome}
    made = checked(experiments_record(outcomes=planted), "experiments.json")
    kept = [each for each in made.surveys if told.get(each.part)]
    assert judge_all(Evidence(surveys=kept))["X7"].verdict is expected


def test_no_verdict_on_the_experiments_is_that_of_a_theorem():
    """Other data than the paper's refute nothing and prove nothing."""
    for counts in product((0, 3, 97), repeat=4):
        if any(counts):
            found = survey_judgement(survey(*counts)).verdict
            assert found not in (Verdict.HOLDS, Verdict.HOLDS_UNDER, Verdict.SUPPORTED, Verdict.REFUTED)


def test_the_rules_of_the_ledger():
    with pytest.raises(InputError, match="comparisons"):
        Rule("scenes", "statistic", 0, 0.0)
    assert {key: PARTS[key].rule.comparisons for key in PARTS_X if PARTS[key].rule.comparisons > 1} == {
        "X2/stated": 15, "X3/stated": 15, "X8/zero": 6, "X8/peak": 3,
    }  # fmt: skip
    assert {PARTS[key].rule.smallest_effect for key in PARTS_X} == {0.0, 0.01, 0.05}
    for key in PARTS_X:
        rule = PARTS[key].rule
        assert rule.figure == (rule.smallest_effect == 0.0) == (PARTS[key].role is Role.VARIANT), key
    assert (PROTOCOL.deciding_share, PROTOCOL.contradicted_share, PROTOCOL.deciding_spread) == (
        0.95,
        0.5,
        0.3,
    )


def changed(record, change):
    made = deepcopy(record)
    change(made)
    return sealed(made)


def _flip(record):
    told = record["sets"][0]["readings"][1]["claims"]["X1/direction"]
    told["outcome"] = "opposite"


def _without_default(record):
    record["sets"][0]["readings"][0]["levels"]["lambda1"] = 10


def _foreign(record):
    for pictures in record["sets"]:
        for told in (pictures["claims"], *(each["claims"] for each in pictures["readings"])):
            told["X9/stated"] = told["X1/direction"]


DAMAGE = {
    "another part": (_foreign, "must be a part of the ledger"),
    "a part in one reading": (
        lambda r: r["sets"][0]["readings"][2]["claims"].update({"Z1/a": {}}),
        "must judge the parts that the set judges",
    ),
    "an outcome against its bounds": (_flip, "must follow from its bounds"),
    "a count": (
        lambda r: r["sets"][0]["claims"]["X1/direction"].update(agreeing=3),
        "counts of X1/direction",
    ),
    "a count by level": (
        lambda r: r["sets"][0]["claims"]["X1/direction"]["factors"]["hog"].update(
            {"8-pixel cells": [1, 1, 1, 0]}
        ),
        "counts by level of X1/direction on simulation",
    ),
    "counts by another factor": (
        lambda r: r["sets"][0]["claims"]["X2/stated"]["factors"].pop("lbp"),
        "counts by level of X2/stated on simulation",
    ),
    "an outcome without bounds": (
        lambda r: r["sets"][0]["readings"][0]["claims"]["X7/hog"].update(lower=None),
        "bounds of X7/hog on simulation",
    ),
    "a verdict": (
        lambda r: r["sets"][0]["claims"]["X1/direction"].update(verdict="not reproduced"),
        "verdict of X1/direction on simulation",
    ),
    "fewer comparisons": (
        lambda r: r["sets"][1]["readings"][0]["claims"]["X2/stated"].update(comparisons=14),
        "comparisons of X2/stated on photographs must be 15",
    ),
    "fewer resamples": (lambda r: r["design"].update(resamples=100), "resamples"),
    "another format": (lambda r: r.update(format=1), "format"),
    "a set twice": (lambda r: r["sets"].append(r["sets"][0]), "sets of"),
    "another set": (lambda r: r["sets"][0].update(name="drawings"), "sets of"),
    "no set": (lambda r: r.update(sets=[]), "sets of"),
    "no default reading": (_without_default, "default configuration of simulation"),
    "a reading twice": (lambda r: r["sets"][0]["readings"][1].update(id="r000"), "default configuration"),
    "no design": (lambda r: r.pop("design"), "KeyError: 'design'"),
    "no scene and yet an outcome": (
        lambda r: r["sets"][0]["readings"][0]["claims"]["X7/hog"].update(lower=None, upper=None),
        "without bounds",
    ),
    "one bound": (
        lambda r: r["sets"][0]["readings"][0]["claims"]["X7/hog"].update(lower=None),
        "bounds of X7/hog on simulation",
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_a_record_that_does_not_follow_from_its_readings_is_refused(record, tmp_path, name):
    change, needed = DAMAGE[name]
    with pytest.raises(FileFormatError) as caught:
        read_experiments(written(tmp_path / "experiments.json", changed(record, change)))
    assert needed in str(caught.value), caught.value


def test_a_record_that_was_changed_after_it_was_written_is_refused(record, tmp_path):
    made = deepcopy(record)
    made["sets"][0]["default"]["accuracy"][0][0]["right"] += 1
    with pytest.raises(FileFormatError, match="changed after it was written"):
        read_experiments(written(tmp_path / "experiments.json", made))
    other = record | {"volatile": {"seconds": 1}}
    assert read_experiments(written(tmp_path / "b.json", other)).digest == record["digest"]
    for content, needed in (("{", "must be JSON"), ("[]", "must be a record of the experiments")):
        (tmp_path / "c.json").write_text(content, encoding="utf-8")
        with pytest.raises(FileFormatError, match=needed):
            read_experiments(tmp_path / "c.json")
    with pytest.raises(FileFormatError, match="No such file"):
        read_experiments(tmp_path / "none.json")


def test_a_reading_without_a_scene_has_no_numbers(record, found):
    def nothing(made):
        for each in made["sets"][0]["readings"]:
            told = each["claims"]["X8/zero"]
            told.update(units=0, left_out=48, statistic=None, lower=None, upper=None, outcome="open", above=0)
        told = made["sets"][0]["claims"]["X8/zero"]
        told.update(counts=[0] * 4, undefined=8, agreeing=0, verdict="not testable here")
        told["factors"] = {name: dict.fromkeys(by, [0] * 4) for name, by in told["factors"].items()}

    made = checked(changed(record, nothing), "experiments.json")
    text = experiment_files(made)["experiments.md"].decode()
    row = next(line for line in text.splitlines() if line.startswith("| X8/zero | simulation"))
    assert row.endswith("| open | - | - | - | 0 | 48 |"), row


def test_surveys_come_back(found):
    for each in found.surveys:
        assert Survey.from_json(json.loads(json.dumps(asdict(each)))) == each
    assert found.command == "python -m verification experiments --configurations 8 --photos DIR"
    with pytest.raises(InputError, match="at least one configuration"):
        survey(0, 0, 0, 0)


def rendered(stored):
    return files(judged(evidence(surveys=list(stored.surveys))), {}, stored)


def test_the_report_shows_the_record_and_says_that_it_did_not_find_it(found):
    with_sheet = replace(found, sheets={"2-case": b"\xff\xd8"})
    content = rendered(with_sheet)
    page, text = Page(content["report.html"].decode()), content["report.md"].decode()
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))
    beside = "experiments/experiments.html"
    assert {link.removeprefix("#") for link in page.links} - {words.LINK, beside} <= set(page.ids)
    assert beside in page.links
    assert f"]({beside})" in text
    assert content[beside] == experiment_files(with_sheet)["experiments.html"], (
        "the page that is linked is written"
    )
    squeezed, elsewhere = (
        " ".join(each.split()) for each in (page.text, Page(content[beside].decode()).text)
    )
    for each in (
        *found.content["sets"][0]["claims"],
        "they were read from a stored record",
        found.digest[:12],
    ):
        assert each in squeezed, each
    for needed in (
        "it was not found by the run that wrote this page",
        found.digest,
        found.content["sets"][0]["digest"],
        "What a user should know",
        "610 of 900 wrong labels are the shortest reference",
        "the ambulance is labelled right least often",
        "smallest effect 0.01",
    ):
        assert needed in elsewhere, needed
        assert needed not in squeezed, f"{needed}: on the page of the experiments alone"
    assert found.command in squeezed
    drawn = set(re.findall('id="(simulation|photographs)-([a-z]+)-', content["report.html"].decode()))
    assert drawn <= {("simulation", "accuracy")}, drawn
    assert content["report.html"].decode().count('<svg class="plot"') == len(series()) - 1 + 2
    assert content[beside].decode().count('src="data:image/jpeg;base64,/9g="') == 1
    found_again = json.loads(content["report.json"])
    assert found_again["experiments"]["record"] == found.digest
    assert "readings" not in found_again["experiments"]["sets"][0]["default"]
    schema = json.loads(Path(report.__file__).with_name("report.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(found_again)


def test_without_a_record_the_report_says_how_to_make_one():
    content = files(judged(evidence(surveys=[])), {})
    assert "python -m verification experiments" in content["report.html"].decode()
    assert not [name for name in content if name.startswith("experiments/")]
    assert json.loads(content["report.json"])["experiments"] is None


def test_figures_are_small_and_tell_what_they_show_and_pages_are_whole(pages):
    drawings = {name: data.decode() for name, data in pages.items() if name.startswith("figures/")}
    assert len(drawings) == 16, list(drawings)
    for name, svg in drawings.items():
        root = ElementTree.fromstring(svg)
        assert len(root.get("aria-label")) > 80, name
        assert len(svg) < 40_000, (name, len(svg))
        assert "<image" not in svg, name
    page = Page(pages["experiments.html"].decode())
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))
    shown = re.findall(r"\]\(([^)]*)\)", pages["experiments.md"].decode())
    assert sorted(shown) == sorted([*drawings, "sheets/2-case.jpg"])


def test_the_committed_pages_are_what_the_packaged_record_gives(tmp_path):
    folder = Path(__file__).parents[3] / "reports" / "experiments"
    result = RUNNER.invoke(app, ["experiments-pages", "--out", str(tmp_path / "pages")])
    assert result.exit_code == 0, (result.output, result.exception)
    made = {path.relative_to(tmp_path / "pages") for path in (tmp_path / "pages").rglob("*.*")}
    sheets = {name for name in made if name.parent.name == "sheets"}
    assert {name.name for name in sheets} == {path.name for path in (PACKAGED.parent / "sheets").iterdir()}
    assert made - sheets == {path.relative_to(folder) for path in folder.rglob("*.*")}, "no second copy"
    remedy = "python -m verification experiments-pages"
    for name in made - sheets:
        text = (tmp_path / "pages" / name).read_text(encoding="utf-8")
        kept = text.replace("](sheets/", "](../../verification/experiments/record/sheets/")
        assert (folder / name).read_text(encoding="utf-8") == kept, (name, remedy)
    assert (folder / "experiments.html").stat().st_size < 700_000


def test_the_packaged_record_is_whole():
    full = packaged()
    assert [len(each["readings"]) for each in full.content["sets"]] == [128, 128]
    assert {survey.part for survey in full.surveys} == set(PARTS_X)
    assert 0 < sum(map(len, full.sheets.values())) <= BUDGET


def test_hostile_names_stay_text():
    def hostile(made):
        (pictures,), evil = made["sets"], EVIL.replace("\x00", "")
        pictures["objects"][0] = evil
        pictures["default"]["baselines"][evil] = pictures["default"]["baselines"]["ridge"]
        pictures["readings"][0]["claims"]["X1/direction"]["comparison"] = evil

    made = changed(experiments_record(names=("simulation",)), hostile)
    content = experiment_files(checked(made, "experiments.json"))
    page = Page(content["experiments.html"].decode())
    assert "script" not in page.tags
    assert "alert(1)" in page.text
    assert "<script" not in content["experiments.md"].decode()


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r["sets"][0]["default"].pop("shares"),
        lambda r: r["sets"][0]["default"]["grid"].pop(),
        lambda r: r["sets"][0]["default"]["case"]["u"].append(1.0),
        lambda r: r["sets"][1]["default"]["accuracy"][0].pop(),
    ],
)
def test_a_record_that_lacks_what_is_shown_is_refused_by_name(record, change):
    made = checked(changed(record, change), "experiments.json")
    with pytest.raises((InputError, KeyError, ValueError)):
        experiment_files(made)


def test_a_few_large_losses_do_not_hide_the_effect_of_interest(record):
    found = summary(checked(record, "experiments.json"))
    pictures = found["sets"][0]
    pictures["gain"] = [[[-0.8, -0.6, -0.002, 0.0, 0.02] for _ in row] for row in pictures["gain"]]
    canvas = Figure()
    figures.gain(canvas, pictures, found["design"])
    for axes in canvas.axes:
        zero, point, worst, best = (axes.transData.transform((1, y))[1] for y in (0, 1, -80, 2))
        assert point - zero > (best - worst) / 10, "a tenth of the height"
        assert {-10, -1, 0, 1} <= set(axes.get_yticks())
        assert 100 not in axes.get_yticks()


def test_labels_keep_apart_and_stay_inside():
    placed = spaced([0.5, 0.5, 0.51, 0.9], 0.05)
    assert np.diff(placed).min() >= 0.05 - 1e-12, placed
    assert placed[3] == 0.9
    assert spaced([0.1, 0.4], 0.05) == [0.1, 0.4]
    assert min(spaced([0.0, 0.0, 0.0], 0.1)) == 0.0


def test_sheets_are_bound_to_their_record(tmp_path):
    for name, data in sheet_files("a" * 64, {"2-case": b"x", "1-b": b"y"}).items():
        (tmp_path / name).write_bytes(data)
    assert read_sheets(tmp_path, "a" * 64) == {"1-b": b"y", "2-case": b"x"}
    assert read_sheets(tmp_path / "none", "a" * 64) == {}
    with pytest.raises(FileFormatError, match="must be that of the record"):
        read_sheets(tmp_path, "b" * 64)
    (tmp_path / "2-case.jpg").write_bytes(b"z")
    with pytest.raises(FileFormatError, match="SHA-256"):
        read_sheets(tmp_path, "a" * 64)
    (tmp_path / "2-case.jpg").unlink()
    with pytest.raises(FileFormatError, match="must list the sheets"):
        read_sheets(tmp_path, "a" * 64)


def drawn(folder, kind, names, shares):
    """A folder as `convexperc simulate` writes it: noise for pictures, a robot for each visible share."""
    rng = np.random.default_rng([0, len(names)])

    def stored(file):
        place = folder / file
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(
            cv2.imencode(".png", rng.integers(0, 256, (12, 16, 3), dtype=np.uint8))[1].tobytes()
        )
        return {"file": file, "sha256": hashlib.sha256(place.read_bytes()).hexdigest()}

    scenes = []
    for name, level in names:
        views = [
            {"name": f"robot-{k}", "obstruction": "none", "visible_share": share}
            | stored(f"views/{name}/robot-{k}.png")
            for k, share in enumerate(shares, 1)
        ]
        above = stored(f"overhead/{name}.png")
        told = {"name": name, "object": name.rpartition("-")[0], "level": level, "views": views}
        scenes.append(told | {"overhead": above["file"], "overhead_sha256": above["sha256"]})
    references = [{"object": "cone"} | stored("references/cone.png")]
    manifest = {"format": 1, "set": kind, "scenes": scenes, "references": references}
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    return folder


def test_sheets_are_drawn_of_simulated_pictures_and_published_with_the_pages(record, tmp_path):
    default = record["sets"][0]["default"]
    seen, study = default["case"]["visible_share"], default["case_study"][0]["visible_share"]
    scenes = [(each["scene"], "case study") for each in default["case_study"]]
    folders = [
        drawn(
            tmp_path / "a", "physical", [("helicopter-3-00", "none"), ("helicopter-3-01", "one full")], seen
        ),
        drawn(tmp_path / "b", "case-study", scenes, study),
    ]
    out = tmp_path / "out"
    out.mkdir()
    written(out / "experiments.json", record)
    given = read_experiments(out / "experiments.json")
    with_sheets = replace(given, sheets=contact_sheets(given.content, folders))
    names = {path.relative_to(out).as_posix() for path in publish(with_sheets, out)}
    sheets = sorted(name for name in names if name.endswith(".jpg"))
    assert sheets == [
        *(f"sheets/1-case-study-{name}.jpg" for name in ("gray-car", "ica-sign", "red-car")),
        "sheets/2-case.jpg", "sheets/3-levels.jpg", "sheets/4-references.jpg",
    ]  # fmt: skip
    assert sum((out / name).stat().st_size for name in sheets) <= BUDGET
    again = read_experiments(out / "experiments.json")
    assert contact_sheets(again.content, folders[::-1]) == again.sheets, "in any order, the same bytes"
    assert (out / "experiments.html").read_text(encoding="utf-8").count("<img") == 6
    assert contact_sheets(experiments_record(names=("photographs",)), folders) == {}
    other = drawn(tmp_path / "c", "case-study", scenes, study[::-1])
    with pytest.raises(FileFormatError, match="as the record has it"):
        contact_sheets(record, [folders[0], other])
    (tmp_path / "a" / "references" / "cone.png").write_bytes(b"another")
    with pytest.raises(FileFormatError, match="as its manifest says"):
        contact_sheets(record, folders)


@pytest.fixture
def quick(monkeypatch, tmp_path):
    """No arguments, which take seconds; the baseline expects the opposite of X2; a command about X2."""
    monkeypatch.setattr("verification.run.stages.all_arguments", list)
    expected = read_baseline() | {"X2": Verdict.OPPOSITE, "X2/stated": Verdict.OPPOSITE}
    monkeypatch.setattr("verification.ledger.baseline.read_baseline", lambda: expected)

    def command(name, *more):
        arguments = (name, "--claim", "X2", "--jobs", 1, "--out", tmp_path / "out", *more)
        return RUNNER.invoke(app, [str(each) for each in arguments])

    return command


def test_a_run_judges_by_the_record_that_is_named(record, tmp_path, monkeypatch, quick):
    result = quick("run", "--experiments", written(tmp_path / "experiments.json", record))
    assert result.exit_code == 0, (result.output, result.exception)
    assert record["digest"][:12] in result.stdout, result.stdout
    assert re.search(r"X2/stated\s*│ photographs", result.stdout), result.stdout
    other = experiments_record(outcomes={"X2/stated": ["reproduced"] * 8})
    result = quick("run", "--experiments", written(tmp_path / "other.json", other))
    assert result.exit_code == 1, result.output
    assert "X2: reproduced, the baseline says opposite found" in result.stdout, result.stdout
    damaged = written(tmp_path / "damaged.json", record | {"format": 7})
    for wrong in (damaged, tmp_path / "none.json"):
        result = quick("run", "--experiments", wrong)
        assert result.exit_code == 2, result.output
        assert "--experiments" in result.stderr, result.stderr
    monkeypatch.setattr("verification.experiments.record.reading.PACKAGED", tmp_path / "none.json")
    assert quick("run").exit_code == 3, "nothing was judged, and nothing speaks against the baseline"


def test_a_report_shows_the_record_that_comes_with_the_verifier(record, tmp_path, monkeypatch, quick):
    file = written(tmp_path / "experiments.json", record)
    monkeypatch.setattr("verification.experiments.record.reading.PACKAGED", file)
    result = quick("report")
    assert result.exit_code == 0, (result.output, result.exception)
    told = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert told["settings"]["experiments"]["record"] == told["experiments"]["record"] == record["digest"]
    assert told["settings"]["command"].endswith("--claim X2")
    kept = tmp_path / "out" / ".journal" / "quick-0-X2.evidence.json"
    assert json.loads(kept.read_text(encoding="utf-8"))["evidence"]["surveys"] == [], "not found by the run"
    result = RUNNER.invoke(
        app, ["report", "--evidence", str(kept), "--experiments", str(file), "--out", str(tmp_path)]
    )
    assert result.exit_code == 0, (result.output, result.exception)
    told = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert told["settings"]["command"].endswith("--claim X2 --experiments experiments.json")


def test_a_part_about_the_experiments_is_judged_by_surveys_alone(found):
    made = evidence(surveys=[])
    assert judge_part(PARTS["X1/direction"], made).verdict is Verdict.NOT_TESTABLE
    assert {survey.part for survey in found.surveys} == set(PARTS_X)
