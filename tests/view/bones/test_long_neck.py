"""A long neck that ends a body has vertebrae along it and a head that looks ahead; others are plain bones."""

import numpy as np
import pytest

from warpmuscle.scene import Body, Character, Joint
from warpmuscle.view.bones.long_neck import LongNeck
from warpmuscle.view.figure import figure_of
from warpmuscle.view.pieces import Hull


def bird(name: str = "neck", half: float = 0.33) -> Character:
    """A trunk that a neck stands on, 2 * half high, about the middle of each."""
    trunk, neck = Body(mass=30.0, inertia=(1.0, 1.0, 1.0)), Body(mass=3.0, inertia=(0.1, 0.1, 0.1))
    joint = Joint("hinge", "trunk", name, (0.0, 0.1, 0.3), (0.0, -half, 0.0), axes=[(1.0, 0.0, 0.0)])
    return Character("trunk", bodies={"trunk": trunk, name: neck}, joints={"Neck": joint})


def of_neck(character: Character) -> list[Hull]:
    pieces = figure_of(character, (), list(character.bodies))
    return [piece for piece in pieces if isinstance(piece, Hull) and piece.body == 1]


def test_a_long_neck_has_vertebrae_and_a_head_that_looks_ahead():
    bones, eyes = of_neck(bird())
    assert (bones.layer, eyes.layer) == ("bone", "hollow")
    corners = np.asarray(bones.corners)
    assert corners[:, 1].min() == pytest.approx(-0.33, abs=0.03)
    assert corners[:, 1].max() < 0.36
    tip = corners[corners[:, 2].argmax()]
    assert tip[2] > 0.1
    assert tip[1] == pytest.approx(0.27, abs=0.06)
    np.testing.assert_allclose(np.ptp(corners[:, 0]) / 2.0, corners[:, 0].max(), atol=1e-3)  # both sides are alike


@pytest.mark.parametrize(("name", "half"), [("tail", 0.33), ("neck", 0.05)])
def test_other_bodies_and_short_necks_have_a_plain_bone(name: str, half: float):
    assert [hull.layer for hull in of_neck(bird(name, half))] == ["bone"]


def test_a_neck_along_the_view_still_has_a_head():
    (corners, *_), _ = LongNeck(np.zeros(3), np.array([0.0, 0.0, 0.6]), 0.04).bones()
    assert np.isfinite(corners).all()
    assert corners[:, 1].min() < -0.1  # and looks down
