"""Gait cycles are found where feet touch down, and curves over them are what they were over time."""

from copy import deepcopy

import numpy as np
import pytest

from small_result import walk_result, walk_scene, with_arrays
from warpmuscle.core.errors import Error
from warpmuscle.gait.cycles import (
    PERCENT,
    flexion_signs,
    leg_angles,
    longest_span,
    over_strides,
    spans,
    steady_strides,
    strides,
)
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.norms import NORMS


def test_strides_run_from_contact_to_contact_whatever_the_controller_calls_its_stance():
    motion = walk_result().replays[0]
    np.testing.assert_allclose(strides(motion, "left", 1.5), [(1.995, 2.995), (2.995, 3.995)], atol=1e-9)
    np.testing.assert_allclose(strides(motion, "right", 1.0), [(1.495, 2.495), (2.495, 3.495)], atol=1e-9)
    early = with_arrays(motion, stance=np.roll(motion.stance, -5))
    assert strides(early, "left") == strides(motion, "left")
    assert steady_strides(early, walk_scene()) == steady_strides(motion, walk_scene())


def test_spans_are_where_something_holds_without_a_break_and_the_first_of_the_longest_counts():
    true = np.array([1, 0, 0, 1, 1, 0, 1, 1], dtype=bool)
    assert spans(true) == [slice(0, 1), slice(3, 5), slice(6, 8)]
    assert longest_span(true) == slice(3, 5)
    assert longest_span(np.ones(4, dtype=bool)) == slice(0, 4)
    assert longest_span(np.zeros(4, dtype=bool)) is None
    assert spans(np.zeros(0, dtype=bool)) == []


def test_curves_over_strides_follow_the_motion():
    time = np.linspace(0.0, 4.0, 401)
    values = np.stack([np.sin(2.0 * np.pi * time), time], axis=1)
    curves = over_strides(time, values, [(1.0, 2.0), (2.0, 4.0)])
    assert curves.shape == (2, 101, 2)
    np.testing.assert_allclose(curves[0, :, 0], np.sin(2.0 * np.pi * PERCENT / 100.0), atol=1e-9)
    np.testing.assert_allclose(curves[1, :, 1], 2.0 + PERCENT / 50.0, atol=1e-9)


def test_leg_angles_are_flexion_in_degrees():
    motion, scene = walk_result().replays[0], walk_scene()
    angles = leg_angles(motion, scene)
    expected = -np.degrees(0.3 * np.sin(2.0 * np.pi * motion.time))
    np.testing.assert_allclose(angles["Hip flexion"]["left"], expected, atol=1e-6)
    np.testing.assert_allclose(angles["Hip flexion"]["right"], -expected, atol=1e-6)


def test_only_turns_about_axes_that_are_nearly_across_are_flexion():
    """0.7 along x is 45.6 degrees away from it."""
    scene = deepcopy(walk_scene())
    joints = [name for side in (0, 1) for name in leg_joints(scene, side)]
    for name in joints:
        scene.character.joints[name].type = "hinge"
    slanted = {joints[0]: 0.72, joints[1]: -0.75, joints[2]: 0.65, joints[3]: -0.6, joints[4]: 1.0, joints[5]: -1.0}
    for name, along in slanted.items():
        scene.character.joints[name].axes = [(along, 0.0, (1.0 - along**2) ** 0.5)]
    signs = flexion_signs(scene)
    assert sorted(signs) == sorted(name for name, along in slanted.items() if abs(along) > 0.7)
    way = {
        joints[0]: -1.0,
        joints[1]: -1.0,
        joints[4]: 1.0,
        joints[5]: 1.0,
    }  # hips bend at negative turns, as ankles do
    assert signs == way


def test_a_motion_of_less_than_a_cycle_says_so():
    motion = walk_result().replays[0].window(0.0, 1.6)
    with pytest.raises(Error, match="no whole gait cycle: the left foot lands less than twice"):
        steady_strides(motion, walk_scene())
    with pytest.raises(Error, match="no whole gait cycle"):
        steady_strides(motion.window(9.0), walk_scene())


@pytest.mark.parametrize("name", NORMS)
def test_norms_go_through_their_key_points_and_close_the_cycle(name: str):
    norm = NORMS[name]
    at, value = np.array(norm.points).T
    np.testing.assert_allclose(norm.mean(at), value, atol=1e-12)
    assert norm.mean(np.array([0.0]))[0] == pytest.approx(norm.mean(np.array([100.0]))[0])
    assert np.all(np.diff(at) > 0.0)
