"""How far the centre of pressure goes in a stance, and where along the foot its points are."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.gait.centre_of_pressure import _along, travel
from warpmuscle.scene import Box, Sphere


def test_travel_is_from_the_rearmost_to_the_foremost_place_of_each_stance_that_lasts():
    gap = [np.nan] * 3
    centre = np.array(
        [*gap, 10.0, 5.0, 40.0, 80.0, 70.0, *gap, 20.0, 90.0, 30.0, 20.0, *gap, 30.0, 35.0, 60.0, 61.0, 62.0]
    )
    np.testing.assert_allclose(travel(centre), [75.0, 32.0])
    assert travel(np.full(9, np.nan)).shape == (0,)


def test_places_are_parts_of_the_straight_foot_from_heel_to_toe():
    scene = load("fwalk")
    joints = {joint.child: (name, joint) for name, joint in scene.character.joints.items()}
    foot, toes = "lFoot", "lToes"
    toe = joints[toes][1]
    toe.position_in_parent, toe.position_in_child = (0.0, 0.0, 0.13), (0.0, 0.0, -0.02)
    scene.character.bodies[foot].shapes = [
        Sphere((0.0, -0.02, -0.08), 0.02),
        Box((-0.03, -0.04, -0.05), (0.03, 0.0, 0.1)),
    ]
    scene.character.bodies[toes].shapes = [Sphere((0.0, -0.01, 0.03), 0.02)]
    along = _along(scene, foot)
    heel, tip = -0.1, 0.13 + 0.02 + 0.03 + 0.02  # m
    expected = [-0.08, *[-0.05] * 4, *[0.1] * 4, 0.18]
    np.testing.assert_allclose(sorted(along), sorted((np.array(expected) - heel) / (tip - heel)), atol=1e-9)
    assert max(along) == pytest.approx(0.28 / 0.3)
