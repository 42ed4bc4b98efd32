"""Small figures: the lines, words and colours of the large ones."""

import re

import numpy as np
import pytest

from warpmuscle.core.array_types import Floats
from warpmuscle.plots.compact_svg import compact_path, compact_svg, thinned

pytest.importorskip("matplotlib")


def corners(path: str) -> list[Floats]:
    """The corners (n, 2) of each line of a path of M, L, l and z, from the beginning of the picture."""
    lines: list[list[Floats]] = []
    for kind, numbers in re.findall(r"([MLl])([^MLlz]*)", path):
        pairs = np.array([float(n) for n in re.findall(r"-?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", numbers)]).reshape(-1, 2)
        if kind == "M":
            lines.append([])
        for pair in pairs:
            lines[-1].append(pair + (lines[-1][-1] if kind == "l" else 0.0))
    return [np.array(line) for line in lines]


def distance(point: Floats, line: Floats) -> float:
    """From a polyline, in its units."""
    start, way = line[:-1], np.diff(line, axis=0)
    part = np.clip(np.sum((point - start) * way, axis=1) / np.maximum(np.sum(way * way, axis=1), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(start + part[:, None] * way - point, axis=1).min())


@pytest.mark.parametrize(("points", "error"), [(5, 0.0075), (200, 0.155)])
def test_lines_stay_where_they_are_within_rounding(points: int, error: float):
    numbers = np.array([50.0, 300.0]) + np.random.default_rng(points).normal(size=(points, 2)).cumsum(axis=0)
    text = "".join(f"{'L' if k else 'M'} {x:.6f} {y:.6f} \n" for k, (x, y) in enumerate(numbers)) + "z\n"
    small = compact_path(text)
    (line,) = corners(small)
    assert small.endswith("z")
    assert len(small) < 0.5 * len(text)
    assert max(distance(point, line) for point in numbers) < error
    assert max(distance(point, numbers) for point in line) < error


def test_a_smooth_curve_needs_few_points_and_one_that_turns_back_keeps_its_turn():
    angle = np.linspace(0.0, 2.0 * np.pi, 401)
    curve = list(zip((50.0 * angle).tolist(), (30.0 * np.sin(angle)).tolist(), strict=True))
    few = np.array(thinned(curve))
    assert len(few) < 60
    assert max(distance(np.array(point), few) for point in curve) <= 0.08 + 1e-9
    there_and_back = [(float(x), 0.0) for x in [*range(10), *range(10)[::-1]]]
    assert thinned(there_and_back) == [(0.0, 0.0), (9.0, 0.0), (0.0, 0.0)]


def test_points_on_a_straight_line_go_and_turns_back_stay():
    assert compact_path("M 0 0 L 1 1 L 2 2 L 3 3 L 4 2 L 5 1 L 2 4") == "M0 0l3 3 2-2-3 3"
    assert compact_path("M 1 1 L 1 1") == "M1 1l0 0"  # a dot, where its ends are round
    assert compact_path("M 0 0 L 0.5 -0.25 M 3 3 L 3 4 z") == "M0 0l.5-.25M3 3l0 1z"


def test_curves_keep_their_numbers():
    assert compact_path("M 0 3 \nC 0.8 3 1.5 2.7 2.1 2.1 \nz") == "M 0 3 C 0.8 3 1.5 2.7 2.1 2.1 z"


def test_a_figure_keeps_its_words_colours_and_what_it_refers_to():
    from matplotlib.figure import Figure

    from warpmuscle.plots.style import picture

    figure = Figure()
    axes = figure.add_subplot()
    time = np.linspace(0.0, 1.0, 400)
    for name, color in (("a < b & c", "#123456"), ("two  spaces", "#abcdef")):
        axes.plot(time, np.sin(9.0 * time), "o-", color=color, label=name, markersize=1.0)
    axes.legend()
    large = picture(figure, ".svg")
    small = compact_svg(large).decode()
    assert len(small) < 0.6 * len(large)
    assert {"#123456", "#abcdef"} <= set(re.findall(r"#[0-9a-f]{6}", small))
    words = re.compile(r"<text[^>]*>([^<]*)</text>")
    assert words.findall(small) == words.findall(large.decode())
    assert "a &lt; b &amp; c" in words.findall(small)
    assert set(re.findall(r'(?:href="|url\()#([\w-]+)', small)) <= set(re.findall(r' id="([^"]*)"', small))
    assert large.count(b"<use") == small.count("<use")
    styled = len(re.findall(r' style="', large.decode()))
    assert len(re.findall(r' style="| class="', small)) == styled
