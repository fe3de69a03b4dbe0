"""Tables of the experiments: verdicts, the comparisons that decide, scores and counts."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from verification.ledger.surveys import DECIDING
from verification.report.experiments.blocks import Table
from verification.report.experiments.flips import FACTORS, OUTCOMES

Data = Mapping[str, Any]


def verdicts(sets: Sequence[Data]) -> Table:
    """Of each part and set of pictures: the verdict, counts, and the numbers of the default configuration."""
    rows = []
    for key in dict.fromkeys(key for each in sets for key in each["claims"]):
        for each in sets:
            if key in each["claims"]:
                found = each["claims"][key]
                told = found["default"]
                numbers = [number(told[name]) for name in ("statistic", "lower", "upper")]
                counts = [str(found[name]) for name in (*OUTCOMES, "undefined", "agreeing")]
                words = (short(key), each["name"], found["verdict"])
                scenes = (str(told["units"]), str(told["left_out"]))
                rows.append((*words, *counts, told["outcome"], *numbers, *scenes))
    title = (
        "Verdicts of the sensitivity analysis over the configurations that keep the background: in how many a"
        " part is reproduced, shows no effect, shows the opposite, stays open; in how many no scene defines"
        " the statistic, so that they are left out; in how many of the others every mean lies on the"
        " claim's side, whatever its interval; then what the default configuration says, with the statistic"
        f" and interval of the comparison that decides it. The verdict of a claim comes from the {DECIDING}"
    )
    counted = ("reproduced", "no effect", "opposite", "open", "undefined", "means agree")
    head = ("part", "pictures", "verdict", *counted, "default outcome", "statistic", "lower", "upper")
    return Table(title, (*head, "scenes", "left out"), tuple(rows), words=(0, 1, 2, 9))


def deciding(pictures: Data) -> Table:
    """The comparison that decides each part by default, and the factor that matters most."""
    rows = tuple(
        (short(key), found["default"]["name"], found["spread"]) for key, found in pictures["claims"].items()
    )
    title = (
        f"{name_of(pictures)}: the comparison that decides the default configuration; and the factor whose"
        " levels differ most in the share of configurations that reproduce a part"
    )
    head = ("part", "deciding comparison", "widest factor")
    return Table(title, head, rows, words=(0, 1, 2), folded=pictures["name"] != DECIDING)


def scores(pictures: Data, design: Data) -> Table:
    """The labels of the default configuration, counted."""
    default, rows = pictures["default"], []
    for at, setting in enumerate(design["settings"]):
        for k, n in enumerate(design["counts"]):
            cell = default["accuracy"][at][k]
            counts = [f"{cell[name]:,}" for name in ("right", "wrong", "tie", "undecided")]
            share = [percent(default["explained"][at][k]["score"])] if "explained" in default else []
            interval = f"{percent(cell['lower'])} to {percent(cell['upper'])}"
            rows.append((pair(setting), str(n), percent(cell["score"]), interval, *counts, *share))
    head = ["(lambda2, lambda3)", "n", "score, %", "95 % interval", "right", "wrong", "tie", "undecided"]
    head += ["by explained fraction, %"] if "explained" in default else []
    title = f"{name_of(pictures)}: labels of the default configuration, by setting and number of views n"
    return Table(title, tuple(head), tuple(rows), words=(0,), folded=True)


def baselines(pictures: Data, design: Data) -> Table:
    """Scores of the settings and of the baselines on the same views."""
    default = pictures["default"]
    rows = [
        (pair(setting), *(percent(cell["score"]) for cell in cells))
        for setting, cells in zip(design["settings"], default["accuracy"], strict=True)
    ]
    rows += [
        (name, *(percent(cell["score"]) for cell in cells)) for name, cells in default["baselines"].items()
    ]
    title = (
        f"{name_of(pictures)}: mean score in %, default configuration, by the number of views; (0, 0) is"
        f" least squares alone, chance is {percent(pictures['chance'])}"
    )
    head = ("method", *(f"n = {n}" for n in design["counts"]))
    return Table(title, head, tuple(rows))


def divided(pictures: Data, design: Data) -> Iterator[Table]:
    """Scores with all views, by level of obstruction and by object."""
    last = design["counts"][-1]
    for key, what in (("by_level", "obstructed views"), ("by_object", "object")):
        rows = tuple(
            (name, *(percent(score) for score in values)) for name, values in pictures["default"][key].items()
        )
        title = f"{name_of(pictures)}: mean score in % by {what}, default configuration, n = {last}"
        yield Table(title, (what, *map(pair, design["settings"])), rows, folded=True)


def factors(pictures: Data) -> Table:
    """Score and share of open labels at (0.1, 0.1), by level of each factor."""
    limits = pictures["limits"]
    rows = tuple(
        (f"{FACTORS[name]}: {level}", percent(score), percent(limits["open"][name][level]))
        for name in FACTORS
        if name in limits["accuracy"]
        for level, score in limits["accuracy"][name].items()
    )
    title = f"{name_of(pictures)}: (0.1, 0.1), mean over n and over the configurations with that level, in %"
    return Table(title, ("level", "score", "tied or undecided"), rows)


def rankings(pictures: Data) -> Table:
    """The ranking of the views at several lambdas."""
    rows = tuple(
        (
            pair(each["lambdas"]),
            number(each["visible"]),
            f"{each['proved zero']} of {each['full']}",
            percent(each["negative"]),
            percent(each["three"]),
        )
        for each in pictures["rankings"]
    )
    title = (
        f"{name_of(pictures)}: the ranking of the views, default configuration: Kendall's tau-b of |w| and"
        " the visible share; hidden views that no optimum uses, by proof; weights below 0; scenes of the case"
        " study in which the three good views come first"
    )
    head = ("(lambda2, lambda3)", "tau-b", "hidden, proved 0", "w < 0, %", "three first, %")
    return Table(title, head, rows)


def confusion(pictures: Data) -> Table:
    """Proved labels by object."""
    found = pictures["limits"]["confusion"]
    rows = tuple(
        (name, *map(str, counts), str(left))
        for name, counts, left in zip(found["objects"], found["counts"], found["open"], strict=True)
    )
    title = (
        f"{name_of(pictures)}: objects (rows) and their labels, default configuration, (0.1, 0.1), all views"
    )
    return Table(title, ("object", *found["objects"], "no label"), rows, folded=True)


def name_of(pictures: Data) -> str:
    """The name of a set with a capital."""
    return str(pictures["name"]).capitalize()


def short(key: str) -> str:
    """A part without "stated"."""
    return key.removesuffix("/stated")


def pair(setting: Sequence[float]) -> str:
    """A setting of the lambdas."""
    return f"({setting[0]:g}, {setting[1]:g})"


def percent(value: float) -> str:
    """A share in percent, one decimal."""
    return f"{100.0 * value:.1f}"


def number(value: float | None) -> str:
    """Three decimals; "-" for none."""
    return "-" if value is None else f"{value:.3f}"
