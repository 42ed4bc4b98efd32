"""Clearance, arms and calves while a leg swings, of motions that are made up."""

from copy import deepcopy

import numpy as np
import pytest

from small_result import STRIDE, march, walk_scene, with_arrays
from warpmuscle.formats import load
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.foot_sliding import foot_points
from warpmuscle.gait.measures import feet_of
from warpmuscle.gait.swing import ARMS, CALF, CLEARANCE, arm_joints, clearances, of_stance, swing_measures
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute

STANCE = 0.6  # of a stride, as `march` has it
CYCLES = {"left": [(1.0 * k, 1.0 * k + 1.0) for k in range(3)], "right": [(0.5 + k, 1.5 + k) for k in range(3)]}


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on 56 muscles."""
    return substitute(walk_scene(), start_values(walk_scene()))


@pytest.fixture(scope="module")
def motion(scene: Scene) -> Recording:
    return march(scene.character, 1.2, 5.0, 1001, 0)


def raised(motion: Recording, height: np.ndarray) -> Recording:
    place = motion.body_position.copy()
    place[:, :, 1] += height[:, None]
    return with_arrays(motion, body_position=place)


def test_clearance_is_the_least_height_of_the_lowest_point_in_the_middle_of_swings(scene: Scene, motion: Recording):
    assert STRIDE == 1.0
    lowest = max(float(p.depth.max()) for foot in feet_of(scene) for p in foot_points(motion, scene, foot))
    level = raised(motion, np.full(motion.frames, lowest + 0.02))
    flat = clearances(level, scene, CYCLES)
    assert len(flat) == 6
    assert min(flat) >= 0.02
    phase = np.mod(motion.time, 1.0)
    for middle, counts in ((0.8, True), (0.63, False), (0.97, False)):  # of the left foot's swing, and near its ends
        dipped = raised(level, np.where(np.abs(phase - middle) < 0.02, -0.05, 0.0))
        lowest_point = np.max([point.depth for point in foot_points(dipped, scene, feet_of(scene)[0])], axis=0)
        least = float(-lowest_point[np.abs(phase - 0.8) < 0.06].max())
        found = clearances(dipped, scene, CYCLES)[:3]
        np.testing.assert_allclose(found, least if counts else flat[:3], atol=1e-3, err_msg=str(middle))
        assert (least < 0.02) == counts
    assert swing_measures(level, scene, CYCLES, 60.0)[CLEARANCE] == pytest.approx(100.0 * np.mean(flat))


def test_feet_without_shapes_have_no_clearance(scene: Scene, motion: Recording):
    bare = deepcopy(scene)
    for body in bare.character.bodies.values():
        body.shapes = []
    assert clearances(motion, bare, CYCLES) == []
    assert CLEARANCE in swing_measures(motion, bare, CYCLES, 60.0)


def test_arms_swing_by_the_range_of_the_turn_of_the_joints_that_hang_on_the_trunk(scene: Scene, motion: Recording):
    arms = arm_joints(scene)
    assert arms == {"left": "lShoulder", "right": "rShoulder"}
    turns = motion.joint_orientation.copy()
    for name, degrees in zip(arms.values(), (32.0, 20.0), strict=True):
        half = 0.25 * np.radians(degrees) * np.sin(2.0 * np.pi * motion.time)
        index = motion.joint_names.index(name)
        turns[:, index] = np.stack([np.sin(half), 0.0 * half, 0.0 * half, np.cos(half)], axis=1)
    found = swing_measures(with_arrays(motion, joint_orientation=turns), scene, CYCLES, 60.0)
    assert found[ARMS] == pytest.approx(26.0, rel=1e-3)
    assert CALF not in found  # none of its muscles was recorded


def test_a_body_without_a_trunk_has_no_arms():
    free = load("bigbird_walk")
    assert arm_joints(substitute(free, start_values(free))) == {}


def test_a_calf_in_swing_is_told_in_percent_of_its_stance():
    curve = np.where(PERCENT < 60.0, 0.4, 0.1)
    assert of_stance(curve, 60.0) == pytest.approx(25.0)
    assert of_stance(np.where(PERCENT < 60.0, 0.0, 0.1), 60.0) is None
    assert of_stance(curve, 100.0) is None
