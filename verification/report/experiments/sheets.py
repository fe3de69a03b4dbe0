"""Contact sheets: what the robots of a simulated scene saw, beside the weights that the method gave them."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import UInt8
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from convexperc.errors import FileFormatError
from convexperc.report.canvas import settings
from verification.ledger.surveys import DECIDING
from verification.report.drawing import COLORS, INK, QUIET, STYLE

BUDGET = 125_000
"""Bytes of all sheets together: as text in a page they are a third longer."""
QUALITIES = (85, 80, 75, 70, 65, 60, 50, 40, 30)
"""Of JPEG; the best that keeps the budget is taken."""
DOTS, WIDE = 112, 4.8
"""Dots an inch, and inches of width: letters stay readable where a phone shows the sheet."""
GOOD, HIDDEN = COLORS[2], COLORS[1]
OBSTRUCTIONS = {"none": "free", "partial": "partly hidden", "full": "hidden"}
Picture = UInt8[np.ndarray, "height width 3"]
Data = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class _Folder:
    """A folder of simulated scenes with its manifest."""

    path: Path
    manifest: Data

    def scene(self, name: str) -> Data:
        for each in self.manifest["scenes"]:
            if each["name"] == name:
                return dict(each)
        must = "must have the scenes of the record"
        raise FileFormatError(f"scenes of {self.path.name}", value=name, must=must)

    def picture(self, file: str, sha256: str) -> Picture:
        data = (self.path / file).read_bytes()
        if (found := hashlib.sha256(data).hexdigest()) != sha256:
            raise FileFormatError(file, value=found, must=f"must have SHA-256 {sha256}, as its manifest says")
        decoded = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR)
        if decoded is None:
            raise FileFormatError(file, value=f"{len(data)} bytes", must="must be a picture")
        return np.asarray(cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def _views(folder: _Folder, shown: Data) -> dict[str, Data]:
    """The views of a scene by name; they must show as much of the object as the record says."""
    views: dict[str, Data] = {view["name"]: view for view in folder.scene(shown["scene"])["views"]}
    found = [round(float(views[name]["visible_share"]), 4) for name in shown["views"]]
    if found != [round(float(share), 4) for share in shown["visible_share"]]:
        must = f"must be {shown['visible_share']}, as the record has it"
        remedy = "Name the folders that the record was made from."
        raise FileFormatError(f"visible shares of {shown['scene']}", value=found, must=must, remedy=remedy)
    return views


def contact_sheets(record: Data, data_dirs: Sequence[Path]) -> dict[str, bytes]:
    """Draw the sheets of the simulated sets of a record.

    Parameters
    ----------
    record : mapping
        See `verification.experiments.record.reading.read_experiments`; the case and the case study are shown.
    data_dirs : sequence of Path
        Folders that `convexperc simulate` wrote: the physical set and the case study, in any order.

    Returns
    -------
    dict of str to bytes
        JPEG by name, in the order of the names, together at most `BUDGET` bytes; empty if the record has no
        simulated set. Photographs are never shown.

    Raises
    ------
    FileFormatError
        A folder lacks a scene of the record or has another one, or a picture is not the one of its manifest.
    """
    own = [each for each in record["sets"] if each["name"] == DECIDING]
    if not own:
        return {}
    manifests = (json.loads((path / "manifest.json").read_text(encoding="utf-8")) for path in data_dirs)
    folders = {found["set"]: _Folder(path, found) for path, found in zip(data_dirs, manifests, strict=True)}
    physical, study, default = folders["physical"], folders["case-study"], own[0]["default"]
    drawn = {f"1-case-study-{each['object']}": _study(study, each) for each in default["case_study"]}
    drawn["2-case"] = _case(physical, default["case"])
    drawn["3-levels"] = _levels(physical, physical.scene(default["case"]["scene"])["object"])
    drawn["4-references"] = _references(physical)
    return _encoded(dict(sorted(drawn.items())))


def _encoded(drawn: Mapping[str, Picture]) -> dict[str, bytes]:
    """JPEG in the best quality that keeps the budget, else in the last one."""
    made: dict[str, bytes] = {}
    for quality in QUALITIES:
        for name, picture in drawn.items():
            swapped = cv2.cvtColor(np.ascontiguousarray(picture), cv2.COLOR_RGB2BGR)
            made[name] = cv2.imencode(".jpg", swapped, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        if sum(map(len, made.values())) <= BUDGET:
            break
    return made


def _study(folder: _Folder, shown: Data) -> Picture:
    """The scene from above, and beneath it the views by |w|, the good ones framed."""
    scene = folder.scene(shown["scene"])
    views = _views(folder, shown)
    order = np.argsort(-np.abs(np.array(shown["w"], dtype=np.float64)), kind="stable")

    def draw(figure: Figure) -> None:
        above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=[2.5, 1.0])[:, 0]
        _show(above.subplots(), folder.picture(scene["overhead"], scene["overhead_sha256"]))
        above.suptitle(f"{shown['object']}: the scene from above, the views by rank", fontsize=10)
        for rank, (axes, at) in enumerate(zip(below.subplots(1, len(order)), order, strict=True), 1):
            view, good = views[shown["views"][at]], shown["good"][at]
            _show(axes, folder.picture(view["file"], view["sha256"]), GOOD if good else "")
            told = f"{rank}. {view['name']}\nw = {shown['w'][at]:.2f}\n{'good' if good else 'not good'}"
            axes.set_xlabel(told, fontsize=8, color=GOOD if good else QUIET)

    return _drawn(draw, 4.6)


def _case(folder: _Folder, case: Data) -> Picture:
    """The six views of the case with their weights."""
    views = _views(folder, case)

    def draw(figure: Figure) -> None:
        figure.suptitle(f"The case: {case['scene']}, six views and their weights", fontsize=10)
        told = zip(case["views"], case["w"], case["obstruction"], strict=True)
        for axes, (name, weight, kind) in zip(figure.subplots(2, 3).flat, told, strict=True):
            view = views[name]
            _show(axes, folder.picture(view["file"], view["sha256"]), "" if kind == "none" else HIDDEN)
            axes.set_xlabel(f"{name}, {OBSTRUCTIONS[kind]}\nw = {weight:.3f}", fontsize=8.5, color=INK)

    return _drawn(draw, 3.6)


def _levels(folder: _Folder, name: str) -> Picture:
    """One scene of an object for each level of obstruction, a row each."""
    scenes: dict[str, Data] = {}
    for scene in folder.manifest["scenes"]:
        if scene["object"] == name:
            scenes.setdefault(scene["level"], scene)

    def draw(figure: Figure) -> None:
        figure.suptitle(
            "One scene for each level of obstruction (orange: hidden or partly hidden)", fontsize=9
        )
        parts = figure.subfigures(len(scenes), 1, squeeze=False)[:, 0]
        for part, (level, scene) in zip(parts, scenes.items(), strict=True):
            part.suptitle(level, fontsize=9, x=0.01, ha="left")
            for axes, view in zip(part.subplots(1, len(scene["views"])), scene["views"], strict=True):
                color = "" if view["obstruction"] == "none" else HIDDEN
                _show(axes, folder.picture(view["file"], view["sha256"]), color)

    return _drawn(draw, 0.3 + 0.92 * len(scenes))


def _references(folder: _Folder) -> Picture:
    """The references of all objects."""
    references = folder.manifest["references"]

    def draw(figure: Figure) -> None:
        figure.suptitle("The references", fontsize=10)
        cells = figure.subplots(-(-len(references) // 4), 4, squeeze=False).ravel()
        for axes, each in zip(cells, references, strict=False):
            _show(axes, folder.picture(each["file"], each["sha256"]))
            axes.set_xlabel(each["object"], fontsize=8.5)
        for axes in cells[len(references) :]:
            axes.set_visible(False)

    return _drawn(draw, 2.7)


def _drawn(draw: Callable[[Figure], None], height: float) -> Picture:
    with settings(STYLE):
        figure = Figure(figsize=(WIDE, height), dpi=DOTS, layout="constrained", facecolor="white")
        canvas = FigureCanvasAgg(figure)
        draw(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        return np.array(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3]  # type: ignore[no-untyped-call]


def _show(axes: Axes, picture: Picture, frame: str = "") -> None:
    """A picture without ticks; framed where a colour is given."""
    axes.imshow(picture, interpolation="lanczos")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set(visible=bool(frame), color=frame or "none", linewidth=2.5)
