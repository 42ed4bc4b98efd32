"""Where the points of a path lie."""

import math

import pytest

from muscle_arm import arm, muscle
from warpmuscle.core.pose import about
from warpmuscle.scene import JointState
from warpmuscle.scene.muscles import PointMotion
from warpmuscle.scene.validation.muscles import initial_path_lengths


@pytest.mark.parametrize(("angle", "held"), [(0.3, 0.3), (1.2, 0.5), (-1.0, -0.2)])
def test_a_moving_point_stays_beyond_the_coordinates_that_it_moves_within(angle: float, held: float):
    scene = arm()
    path = muscle(("base", (0.0, 0.1, 0.0)), ("base", (0.0, 0.0, 0.0)))
    path.path[1].motion = [PointMotion((0.0, 0.0, 1.0), slope=0.1, joint="elbow", within=[-0.2, 0.5])]
    scene.character.muscles = {"one": path}
    scene.initial_state.joints["elbow"] = JointState(tuple(map(float, about((1.0, 0.0, 0.0), angle))))
    assert initial_path_lengths(scene)["one"] == pytest.approx(math.hypot(0.1, 0.1 * held), abs=1e-12)
