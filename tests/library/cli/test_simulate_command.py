"""The command ``convexperc simulate``."""

import importlib.util
import json
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from convexperc.cli.main import app
from convexperc.simulation import RED_CAR, backends, read_meshes, scene_of_record


def run(*arguments: object):
    return CliRunner().invoke(app, ["simulate", *map(str, arguments)])


def test_help_loads_neither_numpy_nor_mujoco():
    program = (
        "import sys\nfrom convexperc.cli.main import app\n"
        "try:\n    app(['simulate', 'physical', '--help'])\n"
        "except SystemExit as end:\n    assert end.code == 0\n"
        "print('loaded:', [name for name in ('numpy', 'mujoco', 'cv2', 'joblib') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.endswith("loaded: []\n"), done


def test_an_example_can_be_changed_drawn_and_recognised(opengl, tmp_path):
    printed = run("example", "red-car")
    assert printed.exit_code == 0
    record = json.loads(printed.stdout)
    assert scene_of_record(record, "printed") == RED_CAR
    record |= {"robots": record["robots"][:2], "name": "two-robots"}
    (tmp_path / "scene.json").write_text(json.dumps(record))
    drawn = run("scene", tmp_path / "scene.json", tmp_path / "out", "--width", 64, "--height", 48)
    assert drawn.exit_code == 0, drawn.output
    assert drawn.stdout.startswith("3 views and references with masks of 1 scenes in"), drawn.stdout
    assert "drew 3 of them in" in drawn.stdout
    views = tmp_path / "out" / "views" / "two-robots"
    assert sorted(path.name for path in views.iterdir()) == ["robot-1.png", "robot-2.png"]


def test_a_data_set_is_drawn_and_the_command_to_try_works(opengl, tmp_path):
    arguments = [
        "case-study",
        tmp_path / "set",
        "--scenes",
        1,
        "--workers",
        1,
        "--objects",
        "red-car,ica-sign",
    ]
    arguments += ["--width", 64, "--height", 48]
    done = run(*arguments)
    assert done.exit_code == 0, done.output
    assert "12 views and references with masks of 2 scenes" in done.stdout
    again = run(*arguments)
    assert "all of them were there already" in again.stdout
    tried = done.stdout.splitlines()[-1].removeprefix("try: convexperc ").split()
    assert tried[0] == "recognize"
    found = CliRunner().invoke(app, [str(part) for part in tried])
    assert found.exit_code in (0, 1), found.output
    assert "Ranking by robot for" in found.stdout


def test_what_of_the_meshes_is_not_drawn_and_whom_no_robot_sees_is_said(opengl, tmp_path):
    corners = [(x, y, z) for z in (0, 3) for y in (0, 2) for x in (0, 1)]
    sides = ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6))
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {' '.join(map(str, side))}" for side in sides]
    for name in ("red-car", "block"):
        (tmp_path / "meshes" / name).mkdir(parents=True)
        (tmp_path / "meshes" / name / "a.OBJ").write_text("\n".join(lines))
    (tmp_path / "meshes" / "red-car" / "a.stl").write_bytes(b"x")
    (tmp_path / "meshes" / "readme.txt").write_text("x")
    (tmp_path / "meshes" / "Old_Car").mkdir()
    record = json.loads(run("example", "red-car").stdout)
    wall = {"kind": "wall", "azimuth": record["robots"][0]["camera"]["azimuth"], "distance": 2.5}
    wall |= {"width": 20.0, "height": 20.0, "elevation": 0.0, "turn": 0.0}
    sha256 = read_meshes(tmp_path / "meshes")["red-car"].sha256
    record |= {"robots": record["robots"][:1], "obstacles": [wall], "mesh_sha256": sha256}
    (tmp_path / "scene.json").write_text(json.dumps(record))
    size = ["--width", 64, "--height", 48, "--meshes", tmp_path / "meshes"]
    drawn = run("scene", tmp_path / "scene.json", tmp_path / "out", *size)
    assert drawn.exit_code == 0, drawn.output
    assert drawn.stderr.splitlines() == [
        f"left out of {tmp_path / 'meshes'}: red-car/a.stl (not used), "
        "block (no object of that name is drawn), Old_Car (its name must be letters a-z and digits, joined "
        "by single hyphens, at most 64), readme.txt (not in the folder of an object)",
        "warning: no robot sees the object in red-car",
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["physical", "{}", "--objects", "unicorn"], "objects must be among red-car"),
        (["physical", "{}", "--scenes", 0], "scenes must lie in"),
        (["physical", "{}", "--width", 8], "size must be at least 32 pixels a side"),
        (["physical", "{}", "--seed", -1], "seed must lie in"),
        (["case-study", "{}", "--meshes", "{}-absent"], "must be a readable folder"),
        (["scene", "{}/absent.json", "{}/out"], "must be a readable JSON file"),
    ],
)
def test_bad_input_ends_with_2_and_writes_nothing(opengl, tmp_path, arguments, message):
    target = tmp_path / "target"
    done = run(*(str(part).replace("{}", str(target)) for part in arguments))
    assert done.exit_code == 2, done.output
    assert message in done.stderr, done.stderr
    assert not target.exists()


def test_without_a_library_the_command_names_the_packages(monkeypatch, tmp_path):
    monkeypatch.setattr(backends.ctypes.util, "find_library", lambda name: None)
    monkeypatch.setenv("MUJOCO_GL", "")
    done = run("physical", tmp_path / "set")
    needed = "convexperc[sim]" if importlib.util.find_spec("mujoco") is None else "apt-get install"
    assert (done.exit_code, needed in done.stderr) == (2, True), done.stderr
    assert not (tmp_path / "set").exists()
