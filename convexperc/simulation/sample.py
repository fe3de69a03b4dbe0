"""Makes the sample that the package carries: a reference and five robots' views of each of three objects."""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2

from convexperc.errors import InputError
from convexperc.simulation.layouts import SCENES
from convexperc.simulation.mjcf import Group
from convexperc.simulation.rendering import Engine, Picture, SceneRenderer
from convexperc.simulation.scenes import Scene

COMMAND = "python -m convexperc.simulation convexperc/sample"
WIDTH, HEIGHT = 192, 144
OVERHEAD_WIDTH, OVERHEAD_HEIGHT = 288, 216
SUPERSAMPLING = 3
RECORD = "sample.json"


def write_sample(directory: Path) -> list[Path]:
    """Draw all pictures of the sample and record how they came about.

    The same engine gives the same bytes again.

    Parameters
    ----------
    directory : Path
        Where ``references/``, ``views/``, ``overhead/`` and ``sample.json`` go; made when missing. Files of
        the same name are replaced, others stay.

    Returns
    -------
    list of Path
        The files written, ``sample.json`` last.

    Raises
    ------
    InputError
        The directory cannot be written.
    MissingExtraError
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or it failed.
    """
    files: dict[str, bytes] = {}
    entries: list[dict[str, Any]] = []
    for scene in SCENES:
        pictures, fractions, engine = _draw(scene)
        encoded = {_file_name(scene, camera): _png(picture) for camera, picture in pictures.items()}
        files |= encoded
        entries.append(_entry(scene, encoded, fractions))
    record = _header(engine) | {"scenes": entries}
    files[RECORD] = (json.dumps(record, indent=2) + "\n").encode()
    return [_write(directory / name, content) for name, content in files.items()]


def _draw(scene: Scene) -> tuple[dict[str, Picture], dict[str, float], Engine]:
    """Return each camera's picture, the fraction of the object that each robot sees, and the engine."""
    robots = [name for name in scene.cameras() if name.startswith("robot-")]
    with SceneRenderer(scene, WIDTH, HEIGHT, SUPERSAMPLING) as renderer:
        pictures = {"reference": renderer.picture("reference", (Group.OBJECT, Group.PARK))}
        pictures |= {name: renderer.picture(name) for name in robots}
        fractions = {name: renderer.visible_fraction(name) for name in robots}
        engine = renderer.engine()
    with SceneRenderer(scene, OVERHEAD_WIDTH, OVERHEAD_HEIGHT, SUPERSAMPLING) as renderer:
        pictures["overhead"] = renderer.picture("overhead")
    return pictures, fractions, engine


def _file_name(scene: Scene, camera: str) -> str:
    """Return the path of a picture relative to the sample, with forward slashes."""
    if camera == "reference":
        return f"references/{scene.name}.png"
    return f"overhead/{scene.name}.png" if camera == "overhead" else f"views/{scene.name}/{camera}.png"


def _header(engine: Engine) -> dict[str, Any]:
    return {
        "format": 1,
        "command": COMMAND,
        "engine": asdict(engine),
        "opencv": cv2.__version__,
        "image": {"width": WIDTH, "height": HEIGHT, "supersampling": SUPERSAMPLING},
        "overhead_image": {
            "width": OVERHEAD_WIDTH,
            "height": OVERHEAD_HEIGHT,
            "supersampling": SUPERSAMPLING,
        },
        "units": "metres; degrees; azimuth anticlockwise from above, 0 where the reference is taken",
        "visible_fraction": "samples that show the object / samples that show it when it is alone",
    }


def _entry(scene: Scene, encoded: dict[str, bytes], fractions: dict[str, float]) -> dict[str, Any]:
    """Describe one scene: its cameras with their pictures, and its obstacles."""
    cameras: dict[str, dict[str, Any]] = {}
    for name, camera in scene.cameras().items():
        file = _file_name(scene, name)
        digest = hashlib.sha256(encoded[file]).hexdigest()
        cameras[name] = {"name": name, "file": file, "sha256": digest, **asdict(camera)}
    for name, fraction in fractions.items():
        cameras[name] |= {"visible_fraction": round(fraction, 4), "obstruction": _obstruction(fraction)}
    return {
        "name": scene.name,
        "target_height": scene.target_height,
        "reference": cameras["reference"],
        "robots": [cameras[name] for name in fractions],
        "overhead": cameras["overhead"],
        "obstacles": [asdict(thing) for thing in scene.obstacles],
    }


def _obstruction(fraction: float) -> str:
    if fraction == 0.0:
        return "full"
    return "none" if fraction == 1.0 else "partial"


def _png(picture: Picture) -> bytes:
    blue_first = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    done, data = cv2.imencode(".png", blue_first, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    if not done:
        raise InputError("picture", value=picture.shape, must="must be encodable as PNG")
    return data.tobytes()


def _write(path: Path, content: bytes) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    except OSError as problem:
        raise InputError(
            "the output directory", value=str(path), must="must be writable", remedy=str(problem)
        ) from problem
    return path
