"""Groups of walks before the band of a person: each walk is a line, its median a thick one, all in one legend."""

import numpy as np

from warpmuscle.plots.stride_bands import Group, Panel, draw_strides

WAVE = np.sin(np.linspace(0.0, 2.0 * np.pi, 101))


def test_walks_medians_and_the_band_are_drawn_where_they_are():
    curves = np.array([WAVE + offset for offset in (0.0, 1.0, 5.0)])
    groups = (Group("before", np.zeros((0, 101)), quiet=True), Group("after", curves))
    panels = [Panel("Left hip", "degrees", WAVE, np.full(101, 2.0), groups), Panel("Hip", "", None, None, groups)]
    figure = draw_strides(panels, 2, "the mean", "the band")
    axes, other = figure.axes
    lines = [line.get_ydata() for line in axes.get_lines()]
    assert any(np.array_equal(line, WAVE + 1.0) for line in lines)  # the median
    assert sum(len(line) == 101 for line in lines) == 1 + len(curves) + 1  # the person, walks and their median
    band = axes.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == (WAVE.min() - 2.0, WAVE.max() + 2.0)
    assert len(other.collections) == 0
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["the band", "the mean", "after"]
