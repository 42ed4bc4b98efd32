"""The small picture of a scene shows its bones and muscles within its frame, and no names of the scene."""

import xml.etree.ElementTree as ElementTree

import pytest

from warpmuscle.formats import load
from warpmuscle.scene.anatomy import BONE, MUSCLE, picture


@pytest.mark.parametrize(("name", "muscles"), [("walk56", 56), ("fwalk", 0), ("gait2392", 92), ("throw18", 18)])
def test_all_muscles_and_some_bones_are_drawn_within_the_frame(name: str, muscles: int):
    scene = load(name)
    drawing = ElementTree.fromstring(picture(scene))
    lines = drawing.findall("{http://www.w3.org/2000/svg}polyline")
    assert sum(line.get("stroke") == MUSCLE for line in lines) == muscles
    assert any(line.get("stroke") == BONE for line in lines)
    wide, tall = float(drawing.get("width", 0)), float(drawing.get("height", 0))
    for line in lines:
        for point in line.get("points", "").split():
            x, y = map(float, point.split(","))
            assert -1.0 <= x <= wide + 1.0
            assert -1.0 <= y <= tall + 1.0


def test_what_a_scene_calls_itself_is_plain_text_in_a_notebook():
    scene = load("fwalk")
    scene.name = scene.description = "<script>alert(1)</script>"
    assert "<script" not in scene._repr_html_()
