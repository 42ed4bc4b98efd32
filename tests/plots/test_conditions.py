"""A figure of conditions says by itself what its points are, how many runs there are, and what was expected."""

import numpy as np
import pytest

from warpmuscle.plots.conditions import FALLS, RISES, Lines, Panel, draw_conditions
from warpmuscle.plots.style import style

VALUES = np.array([1.0, 2.0, 3.0, 4.0])


def lines(**expected: tuple[tuple[int | float | str, ...], ...]) -> Lines:
    median = np.array([1.5, 3.5])
    return Lines("", median, median - 0.4, median + 0.4, (0, 0, 1, 1), VALUES, **expected)  # type: ignore[arg-type]


def texts(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def markers(axes) -> list[tuple[str, float]]:
    return [(line.get_marker(), float(line.get_ydata()[0])) for line in axes.lines if line.get_marker() in "Dv^"]


def test_marks_stand_where_something_was_expected_and_the_key_names_them():
    panels = [
        Panel("cost of transport", "J/(kg m)", (lines(expected=((1, 3.0),)),)),
        Panel("speed", "m/s", (lines(signs=((1, 1.5, RISES),)),)),
        Panel("cadence", "steps/min", (lines(),)),
    ]
    for conditions in (["none", "load"], [0.0, 2.0]):
        with style():
            figure = draw_conditions("load", conditions, panels, ["20 runs", "20 runs"])
        first, second, third = figure.axes
        assert markers(first) == [("D", 3.0)]
        assert markers(second) == [("^", 1.5)]
        assert not markers(third)
        assert [axes.get_title("left") for axes in figure.axes] == [panel.title for panel in panels]
        assert [axes._left_title.get_weight() for axes in figure.axes] == ["bold", "bold", "normal"]
        assert [axes.get_ylabel() for axes in figure.axes] == ["J/(kg m)", "m/s", "steps/min"]
        assert texts(figure) == ["one run", "median", "5 to 95 % of the runs", "expected value", "expected: rises"]
        assert [text.get_text() for text in figure.texts] == ["each condition: 20 runs"]


def test_values_that_are_equal_but_for_rounding_are_a_level_row():
    values = 0.2 + 1e-9 * VALUES
    median = np.array([0.2, 0.2])
    panel = Panel("step width", "m", (Lines("", median, median, median, (0, 0, 1, 1), values),))
    with style():
        axes = draw_conditions("load", ["none", "load"], [panel]).axes[0]
    low, high = axes.get_ylim()
    assert (low, high) == pytest.approx((0.198, 0.202))
    axes.figure.canvas.draw()
    assert axes.yaxis.get_offset_text().get_text() == ""


def test_counts_that_differ_are_said_of_each_condition():
    panel = Panel("speed", "m/s", (lines(signs=((1, 1.5, FALLS),), stays=((0, 1.5, 0.2),)),))
    with style():
        figure = draw_conditions("load", ["none", "load"], [panel], ["20 runs", "18 of 20 walked"])
    assert [text.get_text() for text in figure.texts] == ["none: 20 runs; load: 18 of 20 walked"]
    assert texts(figure)[-2:] == ["expected: falls", "expected: stays within"]
    assert len(figure.axes[0].containers) == 2  # the bar of medians, and that of no change
