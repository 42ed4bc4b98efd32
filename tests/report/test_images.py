"""Figures in a page: lines where there is room, else dots, and never more than that."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest

from warpmuscle.report.images import data_uri, data_uris


def figure(lines: int):
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(3.0, 2.0))
    axes = drawn.subplots()
    rng = np.random.default_rng(lines)
    for _ in range(lines):
        axes.plot(rng.normal(size=200))
    return drawn


def test_a_figure_that_fits_is_lines():
    assert data_uri(figure(2)).startswith("data:image/svg+xml;base64,")


@pytest.mark.parametrize(("room", "kinds"), [(60_000, ["webp", "svg+xml"]), (20_000, ["webp", "webp"])])
def test_the_largest_become_dots_until_all_fit(room: int, kinds: list[str]):
    found = data_uris([figure(40), figure(6)], room)
    assert [one.removeprefix("data:image/").split(";")[0] for one in found] == kinds
    assert sum(map(len, found)) <= room
    from PIL import Image

    picture = Image.open(io.BytesIO(base64.b64decode(found[0].split(",")[1])))
    assert picture.width > 150


def test_no_figures_are_no_images():
    assert data_uris([]) == []
