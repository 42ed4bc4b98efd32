"""Names of both sides find each other; names at the edge of a panel keep apart."""

from xml.etree import ElementTree

import numpy as np
import pytest

import hostile
from warpmuscle.plots.names import Pair, pairs
from warpmuscle.plots.style import LONGEST_NAME, apart, legible, picture


def test_sides_are_paired_however_they_are_marked():
    names = ["lSOL", "Neck_Flex", "rSOL", "bic_l", "bic_r", "left_knee", "right_knee", "lonely", "L_ELB", "R_ELB"]
    assert pairs(names) == [
        Pair("SOL", "lSOL", "rSOL"), Pair("Neck_Flex", "Neck_Flex", "Neck_Flex"), Pair("bic", "bic_l", "bic_r"),
        Pair("knee", "left_knee", "right_knee"), Pair("lonely", "lonely", "lonely"), Pair("ELB", "L_ELB", "R_ELB"),
    ]  # fmt: skip


@pytest.mark.filterwarnings("error:Glyph")
@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
def test_letters_that_the_font_lacks_are_no_warning(ending):
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    figure.add_subplot().set_title("ünïcödé 走る")
    assert picture(figure, ending)


def test_labels_move_as_little_as_possible():
    np.testing.assert_allclose(apart([0.0, 5.0, 5.0, 9.0], 1.0), [0.0, 4.5, 5.5, 9.0])
    np.testing.assert_allclose(apart([1.0, 1.0, 1.0], 2.0), [-1.0, 1.0, 3.0])
    assert apart([], 1.0).tolist() == []


def test_names_are_drawn_as_letters_that_every_picture_can_hold(recwarn):
    from matplotlib.figure import Figure

    figure = Figure()
    axes = figure.add_subplot()
    axes.set_title("\n".join(hostile.NAMES))
    axes.plot([0, 1], label=hostile.NAMES[0])
    axes.set_yticks(range(len(hostile.NAMES)), [legible(name) for name in hostile.NAMES])
    axes.legend()
    tree = ElementTree.fromstring(picture(figure, ".svg"))
    assert {element.tag.rpartition("}")[2] for element in tree.iter()}.isdisjoint({"script", "img", "foreignObject"})
    texts = "".join(tree.itertext())
    assert "<img src=x onerror=alert(1)>" in texts
    assert "x" * (LONGEST_NAME - 1) + "\u2026" in texts
    assert "x" * LONGEST_NAME not in texts
    assert picture(figure, ".png")
    told = [said for said in recwarn if not said.category.__module__.startswith("pytest")]
    assert not [said for said in told if said.category is not ResourceWarning]  # of what other tests have left open
    assert legible("ankle, deg\nright") == "ankle, deg\nright"
    assert legible("\x1b[2J\u202e\udcff") == "\ufffd[2J\ufffd\ufffd"
