"""Arguments of other types than are documented end in the errors of the package, not in those of Python."""

import array
from types import SimpleNamespace

import numpy as np
import pytest

from convexperc import (
    FeatureConfiguration,
    Problem,
    References,
    TemplateLibrary,
    decided_by,
    extract,
    lambda2_max,
    optimality_residual,
    perceive,
    recognize,
    recognize_path,
    solve,
    solve_many,
    solve_path,
    weight_intervals,
)
from convexperc.errors import CalibrationError, InputError
from convexperc.features import (
    Region,
    as_rgb,
    color_histogram,
    cropped,
    cut_out,
    hog_descriptor,
    lbp_histogram,
    list_images,
    masked,
    normalise,
    raw_blocks,
    read_configuration,
    read_image,
    read_mask,
    resize,
    to_gray,
    unit_length,
)
from convexperc.inputs import (
    Frame,
    Hypothesis,
    ResultBag,
    Source,
    compressed_picture,
    image_picture,
    moments,
    open_source,
    open_sources,
)
from convexperc.problem import objective, problem_record, read_answer, read_problem, residuals, terms
from convexperc.recognition import (
    Calibration,
    EachView,
    Rules,
    calibrated,
    counted,
    decide,
    fewest_scenes,
    held_out_scenes,
    left_out,
    narrowed_answers,
    read_calibration,
    read_pictures,
    read_references,
    read_scenes,
    sample_scene,
)
from convexperc.report import (
    certificate_record,
    data_digest,
    line_text,
    live_view,
    picture_kind,
    proof_record,
    recognition_line,
    recognition_picture,
    recognition_record,
    solution_record,
)

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
RNG = np.random.default_rng(0)
X, O = RNG.random((2, 4)), RNG.random((4, 3))
LIBRARY = TemplateLibrary(O, names=["a", "b", "c"], modalities=[1, 3])
SEVERAL = TemplateLibrary({"a": RNG.random((2, 4)), "b": RNG.random(4)}, modalities=[1, 3])
FOUND = recognize(X, LIBRARY, **LAMBDAS, prune=False)
PROBLEM = Problem(X, O[:, 0], modalities=[1, 3], **LAMBDAS)
SOLUTION = solve(PROBLEM)
ANSWERS = solve_many(X, O, **LAMBDAS)
MADE = Calibration.of([(FOUND, "a")])
QUICK = FeatureConfiguration(
    working_size=(16, 16), hog_pixels_per_cell=(8, 8), lbp_points=8, lbp_radius=1.0, lbp_bins=10
)
PICTURE = RNG.integers(0, 255, (20, 20, 3), np.uint8)
GRAY = PICTURE[..., 0].copy()
REFERENCES = References.of({"a": PICTURE, "b": PICTURE[::-1]}, QUICK)
LINE = recognition_line(0.0, 0, {}, {}, None)


class Recorded(Source):
    def __init__(self, *times):
        super().__init__("recorded", "recorded")
        self.times = times

    def __iter__(self):
        return iter([Frame(time, lambda: PICTURE) for time in self.times])


SOURCES = {"one": Recorded(0.0, 1.0)}


def image(**parts):
    given = {
        "encoding": "rgb8",
        "height": 20,
        "width": 20,
        "step": 60,
        "is_bigendian": 0,
        "data": bytes(1200),
    }
    return SimpleNamespace(**{**given, **parts})


ODD = {
    "a type": int,
    "a number": -2.5,
    "a huge integer": 10**400,
    "a complex number": 1j,
    "NaN": float("nan"),
    "bytes": b"x",
    "an object": object(),
    "a list in a list": [[1], [2, 3]],
    "a set": {1, 2},
    "no dimension": np.array(3),
    "no entry": np.zeros((0, 3)),
    "dates": np.array(["2020"], "M8[Y]"),
    "objects": np.array([None, 1], object),
    "a mask": np.ma.array(np.ones((2, 5)), mask=np.eye(2, 5)),
    "a mapping": {1: None},
    "a function": lambda: None,
    "a NUL": "a\0b",
}
DOORS = {
    "recognize names": lambda x: recognize(X, LIBRARY, **LAMBDAS, names=x),
    "recognize views": lambda x: recognize(X, LIBRARY, **LAMBDAS, views=x),
    "recognize prune": lambda x: recognize(X, LIBRARY, **LAMBDAS, prune=x),
    "recognize escalate": lambda x: recognize(X, LIBRARY, **LAMBDAS, escalate=x),
    "recognize_path grid": lambda x: [*recognize_path(X, LIBRARY, x)],
    "perceive views": lambda x: perceive(x, REFERENCES, **LAMBDAS),
    "perceive channels": lambda x: perceive([PICTURE], REFERENCES, **LAMBDAS, channels=x),
    "perceive regions": lambda x: perceive([PICTURE], REFERENCES, **LAMBDAS, regions=x),
    "decided_by": lambda x: decided_by(x, "objective"),
    "decide answers": lambda x: decide(x, FOUND.names, FOUND.views),
    "decide names": lambda x: decide(FOUND.answers, x, FOUND.views),
    "decide views": lambda x: decide(FOUND.answers, FOUND.names, x),
    "decide decision": lambda x: decide(FOUND.answers, FOUND.names, FOUND.views, x),
    "narrowed_answers": lambda x: [*narrowed_answers(x, x)],
    "Recognition.template": FOUND.template,
    "References": lambda x: References(x, QUICK),
    "References configuration": lambda x: References(LIBRARY, x),
    "References.of": lambda x: References.of(x, QUICK),
    "References.of configuration": lambda x: References.of({"a": PICTURE, "b": PICTURE}, x),
    "References.load": References.load,
    "References.save": REFERENCES.save,
    "TemplateLibrary names": lambda x: TemplateLibrary(O, names=x),
    "TemplateLibrary objects": lambda x: TemplateLibrary(O, objects=x),
    "TemplateLibrary.of names": lambda x: TemplateLibrary.of(LIBRARY, names=x),
    "TemplateLibrary.of objects": lambda x: TemplateLibrary.of(LIBRARY, objects=x),
    "TemplateLibrary.for_views": lambda x: TemplateLibrary.for_views(O, None, x),
    "TemplateLibrary.stored": TemplateLibrary.stored,
    "read_pictures": read_pictures,
    "read_references": read_references,
    "read_scenes": lambda x: [*read_scenes(x)],
    "left_out": left_out,
    "left_out scenes": lambda x: left_out(".", scenes=x),
    "read_calibration": read_calibration,
    "Calibration.of": Calibration.of,
    "Calibration.of a scene": lambda x: Calibration.of([x]),
    "Calibration.of a recognition": lambda x: Calibration.of([(x, "a")]),
    "Calibration.of an object": lambda x: Calibration.of([(FOUND, x)]),
    "Calibration.of held_out_of": lambda x: Calibration.of([(FOUND, "a")], held_out_of=x),
    "Calibration.judge": MADE.judge,
    "Calibration.from_dict": Calibration.from_dict,
    "Calibration.from_dict schema": lambda x: Calibration.from_dict({**MADE.to_dict(), "schema": x}),
    "Calibration.from_dict origin": lambda x: Calibration.from_dict({**MADE.to_dict(), "origin": x}),
    "calibrated": lambda x: calibrated([x]),
    "counted": lambda x: counted(x, [(FOUND, "a")]),
    "counted a scene": lambda x: counted(MADE, [x]),
    "fewest_scenes": fewest_scenes,
    "held_out_scenes": lambda x: [*held_out_scenes(SEVERAL, x, **LAMBDAS)],
    "EachView.of": EachView.of,
    "Rules.of": lambda x: Rules.of(x, FOUND.views, "a"),
    "sample_scene": sample_scene,
    "open_source": open_source,
    "open_source rate": lambda x: open_source("missing.png", rate=x),
    "open_source timeout": lambda x: open_source("missing.png", timeout=x),
    "open_sources": open_sources,
    "moments": lambda x: moments(x, slop=0.1),
    "moments a source": lambda x: moments({"one": x}, slop=0.1),
    "moments slop": lambda x: moments(SOURCES, slop=x),
    "moments every": lambda x: moments(SOURCES, slop=0.1, every=x),
    "moments strict": lambda x: moments(SOURCES, slop=0.1, strict=x),
    "moments regions": lambda x: moments(SOURCES, slop=0.1, regions=x),
    "moments region": lambda x: [*moments(SOURCES, slop=0.1, regions={"one": x})],
    "Frame time": lambda x: Frame(x, lambda: PICTURE),
    "Hypothesis object": lambda x: Hypothesis(x, 0.0, 1.0, 0.5),
    "Hypothesis upper": lambda x: Hypothesis("a", 0.0, x, 0.5),
    "ResultBag": ResultBag,
    "image_picture": lambda x: image_picture(x, "x"),
    "image_picture encoding": lambda x: image_picture(image(encoding=x), "x"),
    "image_picture height": lambda x: image_picture(image(height=x), "x"),
    "image_picture step": lambda x: image_picture(image(step=x), "x"),
    "image_picture data": lambda x: image_picture(image(data=x), "x"),
    "compressed_picture": lambda x: compressed_picture(x, "x"),
    "compressed_picture format": lambda x: compressed_picture(SimpleNamespace(format=x, data=b""), "x"),
    "compressed_picture data": lambda x: compressed_picture(SimpleNamespace(format="png", data=x), "x"),
    "extract": lambda x: extract(x, QUICK),
    "extract configuration": lambda x: extract([PICTURE], x),
    "extract recent": lambda x: extract([PICTURE], QUICK, recent=x),
    "raw_blocks": lambda x: raw_blocks(PICTURE, x),
    "color_histogram": lambda x: color_histogram(x, QUICK),
    "color_histogram configuration": lambda x: color_histogram(PICTURE, x),
    "hog_descriptor": lambda x: hog_descriptor(x, QUICK),
    "hog_descriptor configuration": lambda x: hog_descriptor(GRAY, x),
    "lbp_histogram": lambda x: lbp_histogram(x, QUICK),
    "lbp_histogram configuration": lambda x: lbp_histogram(GRAY, x),
    "normalise": lambda x: normalise(x, "none"),
    "normalise a modality": lambda x: normalise({"a": x}, "unit length by modality"),
    "normalise by": lambda x: normalise({"a": np.ones(2)}, x),
    "unit_length": unit_length,
    "as_rgb channels": lambda x: as_rgb(PICTURE, "x", x),
    "list_images": list_images,
    "read_image": read_image,
    "read_mask": read_mask,
    "read_configuration": read_configuration,
    "resize": lambda x: resize(x, (16, 16)),
    "resize size": lambda x: resize(PICTURE, x),
    "to_gray": to_gray,
    "Region": lambda x: Region(x, 0, 16, 16),
    "Region width": lambda x: Region(0, 0, x, 16),
    "Region.parse": Region.parse,
    "Region.around": Region.around,
    "cropped": lambda x: cropped(x, Region(0, 0, 16, 16)),
    "cropped region": lambda x: cropped(PICTURE, x),
    "cut_out": lambda x: cut_out(PICTURE, x),
    "masked": lambda x: masked(x, np.ones((20, 20), bool)),
    "certificate_record": certificate_record,
    "certificate_record residual": lambda x: certificate_record(SOLUTION.certificate, x),
    "data_digest": data_digest,
    "line_text": line_text,
    "live_view": lambda x: live_view(x, []),
    "live_view a robot": lambda x: live_view(LINE, [x]),
    "picture_kind": picture_kind,
    "proof_record": proof_record,
    "recognition_line found": lambda x: recognition_line(0.0, 0, {}, {}, x),
    "recognition_line judgement": lambda x: recognition_line(0.0, 0, {}, {}, FOUND, x),
    "recognition_picture": lambda x: recognition_picture(x, {}, "png"),
    "recognition_picture kind": lambda x: recognition_picture(FOUND, {}, x),
    "recognition_record": recognition_record,
    "recognition_record judgement": lambda x: recognition_record(FOUND, judgement=x),
    "solution_record": solution_record,
    "solve": solve,
    "solve_path grid": lambda x: [*solve_path(X, O, x)],
    "solve escalate": lambda x: solve(PROBLEM, escalate=x),
    "weight_intervals": weight_intervals,
    "weight_intervals enclosure": lambda x: weight_intervals(SOLUTION, x),
    "Answers.solution": ANSWERS.solution,
    "Answers.u": ANSWERS.u,
    "Answers.status": ANSWERS.status,
    "Answers.problem": ANSWERS.problem,
    "Problem.of": lambda x: Problem.of(x, O[:, 0], PROBLEM.penalties),
    "Problem.of penalties": lambda x: Problem.of(PROBLEM.views, O[:, 0], x),
    "Modalities.permuted": PROBLEM.modalities.permuted,
    "recognition_line time": lambda x: recognition_line(x, 0, {}, {}, None),
    "lambda2_max": lambda2_max,
    "optimality_residual": lambda x: optimality_residual(x, SOLUTION.w, SOLUTION.u),
    "objective": lambda x: objective(x, SOLUTION.w, SOLUTION.u),
    "terms w": lambda x: terms(PROBLEM, x, SOLUTION.u),
    "residuals u": lambda x: residuals(PROBLEM, SOLUTION.w, x),
    "problem_record": problem_record,
    "read_problem": read_problem,
    "read_answer": lambda x: read_answer("missing.json", x),
}  # fmt: skip

RIGHT = {
    ("recognize_path grid", "no entry"), ("solve_path grid", "no entry"), ("Hypothesis object", "a NUL"),
    ("Frame time", "a number"), ("Region", "a huge integer"), ("Region width", "a huge integer"),
    ("live_view a robot", "a NUL"), ("recognition_line time", "a number"), ("recognition_line time", "NaN"),
}  # fmt: skip
"""Values that are odd in other places, and what they are right for."""


@pytest.mark.parametrize("door", DOORS)
def test_another_type_is_refused(untyped, door):
    for name, value in ODD.items():
        if (door, name) in RIGHT:
            DOORS[door](value)
            continue
        try:
            DOORS[door](value)
        except InputError as error:
            said = str(error)
        except Exception as error:
            pytest.fail(f"{name}: {type(error).__name__}: {error}")
        else:
            pytest.fail(f"{name} is accepted")
        assert "must" in said


@pytest.mark.parametrize(
    "coverage", [0, 1, -1, 5, 2.5, float("nan"), float("inf"), True, None, "0.9", 10**400]
)
def test_scenes_for_a_coverage_that_is_none_are_not_counted_for_ever(untyped, coverage):
    with pytest.raises(CalibrationError, match="coverage must be a"):
        fewest_scenes(coverage)


@pytest.mark.parametrize("every", [0, -1, 1e-9, 9e-7, 1e-300, float("nan"), float("inf"), 10**400, True, "1"])
def test_moments_that_float64_cannot_tell_apart_are_refused(untyped, every):
    with pytest.raises(InputError, match="every must be a finite number of seconds >= 1e-06; got"):
        moments(SOURCES, slop=0.1, every=every)


@pytest.mark.parametrize("start", [0.0, -5.0, -1e9, 1.7e9, 4e9])
def test_the_closest_moments_differ_at_present_times_and_before_the_epoch(start):
    found = moments({"one": Recorded(start, start + 4e-6)}, slop=0.0, every=1e-6)
    times = [moment.time for moment in found]
    assert sorted(set(times)) == times
    assert times[0] == start


@pytest.mark.parametrize("time", [float("nan"), float("inf"), 1e300, 10**400, None, "1", True, [1]])
def test_a_frame_has_a_time(untyped, time):
    with pytest.raises(InputError, match="time"):
        Frame(time, lambda: PICTURE)


@pytest.mark.parametrize("kind", [bytes, bytearray, list, np.array])
def test_the_bytes_of_a_message_are_those_of_ros_1_and_of_ros_2(kind):
    pixels = PICTURE.tobytes()
    given = np.frombuffer(pixels, np.uint8) if kind is np.array else kind(pixels)
    if kind is list:
        given = array.array("B", given)
    assert np.array_equal(image_picture(image(data=given), "x"), PICTURE)


@pytest.mark.parametrize(
    "data", [np.zeros((20, 60), np.uint8), np.zeros(1200, np.int16), np.zeros((1200, 1), np.uint8)]
)
def test_pixels_that_are_no_row_of_bytes_are_refused(untyped, data):
    with pytest.raises(InputError, match="x: data must be bytes, or an array of uint8 with one dimension"):
        image_picture(image(data=data), "x")


@pytest.mark.parametrize("name", ["lower", "upper", "unexplained"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), "1", None, True, 10**400])
def test_a_hypothesis_has_finite_numbers(untyped, name, value):
    with pytest.raises(InputError, match=f"hypothesis 'a': {name} must be a finite number"):
        Hypothesis(**{"object": "a", "lower": 0.0, "upper": 1.0, "unexplained": 0.5, name: value})


@pytest.mark.parametrize("side", [2.5, float("nan"), float("inf"), True, "16", None, np.float64(16.0)])
def test_a_region_has_whole_sides(untyped, side):
    with pytest.raises(InputError, match="region: width must be an integer"):
        Region(0, 0, side, 16)
    assert Region(np.int64(1), np.uint8(2), 16, 16) == Region(1, 2, 16, 16)


def test_an_unknown_normalisation_is_not_none():
    with pytest.raises(InputError, match="normalisation must be one of 'unit length by modality'"):
        normalise({"a": np.ones(2)}, "unit")


@pytest.mark.parametrize("j", [-1, 3, True, 0.0, None, "a"])
def test_a_template_is_not_counted_from_the_end(untyped, j):
    for of in (ANSWERS.solution, ANSWERS.u, ANSWERS.status, ANSWERS.problem):
        with pytest.raises(InputError, match="template must be an integer from 0 to 2"):
            of(j)
    assert ANSWERS.status(np.int64(2)) == ANSWERS.status(2)


def test_what_is_written_beside_hypotheses_is_json(tmp_path, untyped):
    pytest.importorskip("rosbags")
    for details, said in (
        ({"a": float("nan")}, r"details\['a'\] must be a JSON value"),
        ({1: 2}, "a key of details must be a string"), ([1], "details must be of the type"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said), ResultBag(tmp_path / "a.mcap") as bag:
            bag.write(1, [], details)
    for time in (-1, 1.5, None, "1", True, 2**62):
        with (
            pytest.raises(InputError, match="nanoseconds must be an integer"),
            ResultBag(tmp_path / "a.mcap") as bag,
        ):
            bag.write(time, [])
    for hypotheses in (None, 5, [1], "a"):
        with pytest.raises(InputError, match="hypotheses must"), ResultBag(tmp_path / "a.mcap") as bag:
            bag.write(1, hypotheses)
    assert not (tmp_path / "a.mcap").exists()
