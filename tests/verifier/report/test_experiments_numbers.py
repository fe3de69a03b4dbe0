"""Every number by setting on the pages of the experiments stands beside its own lambdas, in any order."""

import re
from copy import deepcopy

import numpy as np
import pytest
from made_up_experiments import experiments_record, sealed
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from verification.experiments.record.reading import checked
from verification.report.experiments import figures, tables
from verification.report.experiments.advice import advice
from verification.report.experiments.summary import first_places, summary


def score(setting, n):
    """Another number for each setting and number of views."""
    return setting[0] / 2 + setting[1] / 4 + n / 100


def by_lambdas(design):
    return np.array([[score(setting, n) for n in design["counts"]] for setting in design["settings"]])


def lambdas_of(text):
    return tuple(float(each) for each in re.findall(r"[\d.]+", text)[:2])


def rows_of(cells, table):
    """Pairs of a cell and its number."""
    for row, numbers in zip(cells, table, strict=True):
        yield from zip(row, numbers, strict=True)


def filled(made):
    """Put known numbers into every table by setting or by cell of the grid."""
    design = made["design"]
    table = by_lambdas(design)
    grid = [[a / 20 + b / 50 for b in design["grid"]] for a in design["grid"]]
    for pictures in made["sets"]:
        default = pictures["default"]
        for each in pictures["readings"]:
            each["accuracy"] = table.tolist()
        for name, shift in (("accuracy", 0.0), ("explained", 0.001)):
            for cell, value in rows_of(default[name], table + shift):
                cell.update(score=value, lower=value - 0.01, upper=value + 0.02, wrong=round(value * 1e3))
        for key, shift in (("by_level", 0.01), ("by_object", 0.001)):
            names = enumerate(list(default[key]))
            default[key] = {name: (table[:, -1] + shift * k).tolist() for k, name in names}
        for cell, value in rows_of(default["grid"], grid):
            cell["score"] = value
        pictures["limits"].update(grid=grid, settings=table.mean(axis=1).tolist())


@pytest.fixture(scope="module", params=["in order", "in another order"])
def known(request):
    """What is shown of a record whose numbers follow from their lambdas, in two orders of the settings."""
    made = deepcopy(experiments_record())
    if request.param != "in order":
        made["design"]["settings"] = [made["design"]["settings"][at] for at in (2, 0, 3, 1)]
        made["design"]["grid"] = made["design"]["grid"][::-1]
    filled(made)
    return summary(checked(sealed(made), "experiments.json"))


def test_every_row_by_setting_and_views_shows_the_numbers_of_its_lambdas(known):
    pictures, design = known["sets"][0], known["design"]
    rows = tables.scores(pictures, design).rows
    shown = sorted(lambdas_of(row[0]) for row in rows)
    assert shown == sorted(tuple(map(float, each)) for each in design["settings"] for _ in range(6))
    for setting, n, percent, interval, _, wrong, *_, explained in rows:
        wanted = score(lambdas_of(setting), int(n))
        assert (percent, explained) == (f"{100 * wanted:.1f}", f"{100 * wanted + 0.1:.1f}"), (setting, n)
        assert interval == f"{100 * wanted - 1:.1f} to {100 * wanted + 2:.1f}", (setting, n)
        assert int(wrong.replace(",", "")) == round(1e3 * wanted), (setting, n)
    for name, *percents in tables.baselines(pictures, design).rows:
        if name.startswith("("):
            assert percents == [f"{100 * score(lambdas_of(name), n):.1f}" for n in design["counts"]], name
    for table, shift in zip(tables.divided(pictures, design), (1.0, 0.1), strict=True):
        for k, (name, *percents) in enumerate(table.rows):
            wanted = [f"{100 * score(lambdas_of(head), 6) + shift * k:.1f}" for head in table.head[1:]]
            assert percents == wanted, name


def test_every_sentence_about_a_setting_has_the_numbers_of_its_lambdas(known):
    told = dict(advice(known["sets"][0], known["design"]))
    means = re.findall(r"(\([\d., ]+\)) ([\d.]+) %", told["Settings"].partition(" Highest")[0])
    assert len(means) == 4, told
    for lambdas, percent in means:
        assert float(percent) == pytest.approx(100 * score(lambdas_of(lambdas), 3.5), abs=0.06), told
    assert "(0.1, 0.1) in 8" in told["Settings"], told
    assert "(0.1, 0.1), and 6.0 % by least squares alone" in told["Accuracy"], told
    assert "= (10, 10) is best with 70.0 %, (0, 0) worst with 0.0 %" in told["Lambdas"], told
    own = "On the grid's subsets that scores 5.2 %, the paper's (0.1, 0.1) 0.7 %, least squares 0.0 %."
    assert own in told["The library's own choice"], told


def test_every_line_of_a_figure_shows_the_numbers_of_its_lambdas(known):
    pictures, design = known["sets"][0], known["design"]
    table = 100.0 * by_lambdas(design)
    wanted = {tuple(map(float, each)): row for each, row in zip(design["settings"], table, strict=True)}
    canvas = Figure()
    figures.accuracy(canvas, pictures, design)
    (axes,) = canvas.axes
    named = {to_hex(each.get_color()): lambdas_of(each.get_text()) for each in axes.texts}
    assert len(axes.containers) == 4
    for container in axes.containers:
        line = container.lines[0]
        assert line.get_ydata() == pytest.approx(wanted[named[to_hex(line.get_color())]])
    for draw, zero in ((figures.spread, 0.0), (figures.gain, wanted[0.0, 0.0])):
        canvas = Figure()
        draw(canvas, pictures, design)
        panels = {lambdas_of(each.get_title(loc="left")): each for each in canvas.axes}
        assert set(panels) == set(wanted) - ({(0.0, 0.0)} if draw is figures.gain else set())
        for lambdas, axes in panels.items():
            assert axes.lines[0].get_xdata() == pytest.approx(design["counts"])
            assert axes.lines[0].get_ydata() == pytest.approx(wanted[lambdas] - zero, abs=0.01), lambdas


def test_every_cell_of_the_heat_map_shows_the_number_of_its_lambdas(known):
    canvas = Figure()
    figures.lambdas(canvas, known["sets"][0], known["design"])
    axes = canvas.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel(), len(axes.texts)) == ("lambda3", "lambda2", 25)
    ticks = (axis.get_ticklabels() for axis in (axes.xaxis, axes.yaxis))
    across, up = ([float(each.get_text()) for each in labels] for labels in ticks)
    for each in axes.texts:
        column, row = each.xy
        assert each.get_text() == f"{5 * up[row] + 2 * across[column]:.0f}", (up[row], across[column])


def test_a_tie_that_rounding_breaks_is_a_tie() -> None:
    """Of two settings with one mean neither is first, in whatever order floats add it up."""
    scores = np.array([[[0.1, 0.2, 0.3], [0.3, 0.2, 0.1]], [[0.1, 0.2, 0.4], [0.3, 0.2, 0.1]]])
    assert scores.mean(axis=2)[0, 0] != scores.mean(axis=2)[0, 1], "else there is nothing to test"
    assert first_places(scores) == [1, 0]
