"""A made-up record of the experiments: every kind of verdict, every field, no number of it measured."""

import json
from itertools import product

import numpy as np

from verification.experiments.record.reading import checked
from verification.ledger.claims import PARTS, PROTOCOL
from verification.provenance import record_digest

FACTORS = {
    "lambda1": [0.1, 0.01, 1, 10],
    "normalisation": ["unit length by modality", "sum one by modality", "unit length", "none"],
    "color": [
        "by channel, 8 bins",
        "by channel, 32 bins",
        "joint, 4 bins a channel",
        "joint, 8 bins a channel",
    ],
    "hog": ["16-pixel cells", "8-pixel cells"],
    "lbp": ["P = 24, R = 3", "P = 8, R = 1"],
    "size": ["128 x 128", "64 x 64"],
    "background": ["kept", "cut away"],
}
DESIGN = {
    "seed": 0,
    "repetitions": 10,
    "counts": [1, 2, 3, 4, 5, 6],
    "settings": [[0, 0], [0.1, 0], [0, 0.1], [0.1, 0.1]],
    "grid": [0, 0.01, 0.1, 1, 10],
    "resamples": PROTOCOL.resamples,
    "confidence": PROTOCOL.confidence,
    "factors": FACTORS,
}
OBJECTS = ("ambulance", "barrel", "cone", "gray-car", "helicopter", "ica-sign", "red-car", "truck")
LEVELS = ("none", "one partial", "one full", "one full, one partial", "two full, two partial")
PARTS_X = tuple(key for key, part in PARTS.items() if part.rule is not None)
TENDENCY = {
    "X1/direction": ("reproduced", 1.0),
    "X1/figure": ("opposite", 1.0),
    "X2/stated": ("opposite", 1.0),
    "X3/stated": ("no effect", 0.6),
    "X4/stated": ("open", 0.5),
    "X5/stated": ("reproduced", 0.97),
    "X6/direction": ("reproduced", 1.0),
    "X6/zero": ("opposite", 1.0),
    "X6/two": ("opposite", 0.9),
    "X7/lbp": ("reproduced", 0.7),
    "X7/hog": ("reproduced", 1.0),
    "X7/figure": ("reproduced", 0.5),
    "X8/zero": ("open", 1.0),
    "X8/ten": ("reproduced", 1.0),
    "X8/peak": ("opposite", 0.4),
}
"""What most configurations say of a part, and how many of them, roughly."""
BOUNDS = {
    "reproduced": (0.1, 0.3),
    "no effect": (0.0, 0.0),
    "opposite": (-0.2, -0.05),
    "open": (-0.05, 0.15),
}
STEP = 389
"""Prime to the number of combinations: a few of them have many levels."""
KINDS = tuple(BOUNDS)
BASELINES = ("best single view", "mean of the views", "ridge")


def experiments_record(readings=8, names=("simulation", "photographs"), columns=40, outcomes=None, seed=0):
    """A record; `outcomes` maps a part to the outcomes of the simulation's readings, in place of a draw."""
    rng = np.random.default_rng(seed)
    record = {
        "format": 2,
        "design": DESIGN,
        "sets": [_set(name, readings, columns, outcomes or {}, rng) for name in names],
        "volatile": {"seconds": {"trials": 1.5}, "command": "an abacus", "workers": 2},
    }
    return sealed(_rounded(record))


def surveys():
    """What a small record says of every part, by simulation and photographs."""
    return list(checked(experiments_record(), "experiments.json").surveys)


def sealed(record):
    """The record with its digest as it is now."""
    return record | {"digest": record_digest(record)}


def written(path, record):
    path.write_text(json.dumps(record), encoding="utf-8")
    return path


def combinations(number):
    """That many readings that keep the background; the first is the default."""
    every = list(
        product(*(levels[:1] if name == "background" else levels for name, levels in FACTORS.items()))
    )
    return [dict(zip(FACTORS, every[at * STEP % len(every)], strict=True)) for at in range(number)]


def _set(name, number, columns, outcomes, rng):
    made = combinations(number)
    planted = outcomes if name == "simulation" else {}
    readings = [
        {
            "id": f"r{at:03d}",
            "levels": levels,
            "claims": {
                key: _outcome(key, planted[key][at] if key in planted else _draw(key, rng), rng)
                for key in PARTS_X
            },
            **_scores(at, rng),
        }
        for at, levels in enumerate(made)
    ]
    return {
        "name": name,
        "digest": "5" * 64 if name == "simulation" else "f" * 64,
        "source": {"engine": "an abacus", "seed": 0}
        if name == "simulation"
        else {"pictures": "eight objects"},
        "objects": list(OBJECTS),
        "scenes": 240,
        "views": 1440,
        "levels": dict.fromkeys(LEVELS, 48),
        "case_study": {"objects": ["red-car", "gray-car", "ica-sign"], "scenes": 24},
        "claims": {key: _tally(key, readings) for key in PARTS_X},
        "readings": readings,
        "default": _default(readings[0], columns, rng),
        "limits": _limits(),
        "rankings": [
            {
                "lambdas": [l2, l3],
                "visible": 0.4,
                "full": 192,
                "proved zero": 90,
                "negative": 0.1,
                "three": 0.7,
            }
            for l2, l3 in ((0.0, 0.0), (0.1, 0.1), (1.0, 0.1))
        ],
    }


def _limits():
    """What a user should know, as the experiments count it."""
    by_level = {
        name: {_level(each): 0.5 + 0.1 * at for at, each in enumerate(levels)}
        for name, levels in FACTORS.items()
    }
    counts = (24 * np.eye(8, dtype=int) + 5 * np.eye(8, k=1, dtype=int)).tolist()
    return {
        "shortest": {
            "none": {"wrong": 900, "shortest": 610},
            "sum one by modality": {"wrong": 0, "shortest": 0},
        },
        "objective": {"none": 0.31, "unit length": 0.6},
        "explained": {"none": 0.42, "unit length": 0.6},
        "visible": {"0.1": 0.41, "10": None, "default": 0.41},
        "accuracy": by_level,
        "open": {name: dict.fromkeys(levels, 0.01) for name, levels in by_level.items()},
        "settings": [0.61, 0.6, 0.59, 0.58],
        "settings_open": [0.0, 0.01, 0.01, 0.02],
        "grid": [[0.6] * 5] * 4 + [[0.125] * 5],
        "grid_open": [[0.0] * 5] * 4 + [[1.0] * 5],
        "confusion": {"objects": list(OBJECTS), "counts": counts, "open": [1] * 8},
    }


def _draw(key, rng):
    likely, share = TENDENCY[key]
    figure = PARTS[key].rule.figure
    others = [each for each in BOUNDS if each != likely and not (figure and each == "no effect")]
    return likely if rng.random() < share else others[int(rng.integers(len(others)))]


def _outcome(key, outcome, rng):
    lower, upper = BOUNDS[outcome]
    rule = PARTS[key].rule
    shift = rng.random() * (rule.smallest_effect if outcome == "no effect" else 0.02)
    return {
        "outcome": outcome,
        "statistic": (lower + upper) / 2,
        "lower": lower - shift,
        "upper": upper + shift,
        "comparison": "n = 3, (0.1, 0) against (0, 0)",
        "comparisons": rule.comparisons,
        "above": rule.comparisons if outcome == "reproduced" else rule.comparisons - 1,
        "units": 240,
        "left_out": 0,
    }


def _tally(key, readings):
    said = [each["claims"][key]["outcome"] for each in readings]
    counts = [said.count(outcome) for outcome in KINDS]
    return {
        "verdict": _verdict(counts, figure=PARTS[key].rule.figure),
        "counts": counts,
        "undefined": 0,
        "agreeing": counts[0],
        "factors": by_level(key, readings),
    }


def _verdict(counts, *, figure):
    reproduced, flat, opposite, _ = (each / sum(counts) for each in counts)
    if reproduced >= 0.95:
        return "reproduced"
    if opposite >= 0.95:
        return "not reproduced" if figure else "opposite found"
    if reproduced > 0.05:
        return "depends on" if flat + opposite > 0.05 else "reproduced where decided"
    return "not reproduced" if flat + opposite > 0.5 else "inconclusive"


def by_level(key, readings):
    """How many readings with each level say what, as the record has it."""
    counts = {name: {_level(each): [0, 0, 0, 0] for each in levels} for name, levels in FACTORS.items()}
    for reading in readings:
        said = KINDS.index(reading["claims"][key]["outcome"])
        for name, level in reading["levels"].items():
            counts[name][_level(level)][said] += 1
    return counts


def _level(level):
    return level if isinstance(level, str) else f"{level:g}"


def _scores(at, rng):
    """Accuracy that grows with n, and differs by setting and reading."""
    n = np.arange(1, 7)
    base = 0.5 + 0.3 * (1 - np.exp(-n / 2)) - 0.25 * rng.random() * (at > 0)
    shifts = np.array([0.0, 0.004, -0.03, -0.027])
    accuracy = base + shifts[:, None] + 0.01 * rng.standard_normal((4, 6))
    grid = 0.7 - 0.1 * rng.random((5, 5)) - 0.5 * np.outer([0, 0, 0, 0.3, 1], [1, 1, 1, 1, 1])
    return {
        "accuracy": accuracy.tolist(),
        "open": (0.05 * rng.random((4, 6))).tolist(),
        "baselines": {name: (base - 0.05 * (k + 1)).tolist() for k, name in enumerate(BASELINES)},
        "grid": np.maximum(grid, 0.02).tolist(),
        "chance": 0.125,
    }


def _default(reading, columns, rng):
    accuracy = np.array(reading["accuracy"])
    bins = columns // 4
    sizes = {"color": bins, "hog": columns - 2 * bins, "lbp": bins}
    return {
        "accuracy": [[_counted(score, 2400) for score in row] for row in accuracy],
        "explained": [[_counted(score + 0.01, 2400) for score in row] for row in accuracy],
        "baselines": {name: [_around(score) for score in row] for name, row in reading["baselines"].items()},
        "grid": [[_counted(score, 240) for score in row] for row in reading["grid"]],
        "by_level": {level: (accuracy[:, 5] - 0.05 * k).tolist() for k, level in enumerate(LEVELS)},
        "by_object": {name: (accuracy[:, 5] - 0.02 * k).tolist() for k, name in enumerate(OBJECTS)},
        "information": [{"rank": k} | _interval(0.9 - 0.08 * k) for k in range(1, 7)],
        "shares": {"none": 0.71, "partial": 0.16, "full": 0.13},
        "modalities": {"color": 0.31, "hog": 0.62, "lbp": 0.07},
        "case": {
            "scene": "helicopter-3-00",
            "views": [f"robot-{k}" for k in range(1, 7)],
            "obstruction": ["full", "none", "none", "partial", "none", "none"],
            "visible_share": [0.01, 1.0, 0.97, 0.45, 0.99, 1.0],
            "w": [0.08, 0.21, -0.05, 0.1, 0.24, 0.17],
            "u": (np.exp(-np.arange(columns) % 17 / 3) * 0.01 * rng.standard_normal(columns)).tolist(),
            "modality_sizes": sizes,
            "modality_norms": [0.031, 0.062, 0.006],
        },
        "case_study": [
            {
                "scene": f"{name}-0",
                "object": name,
                "views": [f"robot-{k}" for k in range(1, 6)],
                "w": [0.3, 0.02, 0.25, 0.21, 0.05],
                "good": [True, False, True, True, False],
                "visible_share": [1.0, 0.0, 0.98, 0.95, 0.31],
            }
            for name in ("red-car", "gray-car", "ica-sign")
        ],
    }


def _counted(score, trials):
    right = int(score * trials)
    tie, undecided = trials // 100, trials // 200
    rest = {"right": right, "wrong": trials - right - tie - undecided, "tie": tie, "undecided": undecided}
    return rest | _around(score)


def _around(score):
    return {"score": score, "lower": score - 0.03, "upper": score + 0.03}


def _interval(mean):
    return {"mean": mean, "lower": mean - 0.04, "upper": mean + 0.04}


def _rounded(value):
    """Six significant digits, as the record has them."""
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(each) for each in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value
