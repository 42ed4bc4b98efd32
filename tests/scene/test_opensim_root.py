"""Coordinates of a root's joint to the ground, as OpenSim's CustomJoint has them, from its pose and back."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warpmuscle.scene import Displacement, Joint, OpenSim
from warpmuscle.scene.opensim_root import root_motion, root_values

IN_PARENT, IN_CHILD = (0.1, 0.2, -0.3), (0.02, -0.1, 0.05)
STEP = 1e-6
WAYS = {
    "right-handed": [(-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)],
    "left-handed": [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)],
    "planar": [(-1.0, 0.0, 0.0)],
}


def model(way: str) -> OpenSim:
    root = Joint("coupled", "ground", "pelvis", IN_PARENT, IN_CHILD)
    root.rotations = [Displacement(axis, slope=slope) for axis, slope in zip(WAYS[way], (1.0, -1.0, 1.0), strict=False)]
    root.rotations[0].value = 0.3
    along = [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)][: 2 if way == "planar" else 3]
    root.translations = [Displacement(axis, slope=1.0, value=0.4) for axis in along]
    return OpenSim("", root, [f"c{k}" for k in range(len(root.rotations) + len(root.translations))])


def poses(opensim: OpenSim) -> np.ndarray:
    return np.random.default_rng(3).uniform(-1.4, 1.4, (50, len(opensim.root_coordinates)))


@pytest.mark.parametrize("way", WAYS)
def test_the_pose_is_that_of_turns_about_riding_axes_and_gives_the_coordinates_back(way):
    opensim, root = model(way), model(way).root
    for q in poses(opensim):
        turn = Rotation.identity()
        for displacement, value in zip(root.rotations, q, strict=False):
            angle = displacement.value + displacement.slope * value
            turn = turn * Rotation.from_rotvec(angle * np.array(displacement.axis))
        point = np.array(IN_PARENT)
        for displacement, value in zip(root.translations, q[len(root.rotations) :], strict=True):
            point = point + (0.4 + value) * np.array(displacement.axis)
        found = root_motion(opensim, q[None])
        np.testing.assert_allclose(found.position[0], point - turn.apply(IN_CHILD), atol=1e-12)
        np.testing.assert_allclose(Rotation.from_quat(found.orientation[0]).as_matrix(), turn.as_matrix(), atol=1e-12)
        np.testing.assert_allclose(root_values(opensim, found.position, found.orientation)[0], q, atol=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_unit_rates_move_it_as_differences_of_poses_do(way):
    opensim = model(way)
    q = poses(opensim)
    found = root_motion(opensim, q)
    for k in range(q.shape[1]):
        ends = [root_motion(opensim, q + sign * STEP * np.eye(q.shape[1])[k]) for sign in (-1.0, 1.0)]
        moved = (ends[1].position - ends[0].position) / (2.0 * STEP)
        before, after = (Rotation.from_quat(end.orientation) for end in ends)
        np.testing.assert_allclose(found.moving[:, k], moved, atol=1e-8)
        np.testing.assert_allclose(found.turning[:, k], (after * before.inv()).as_rotvec() / (2.0 * STEP), atol=1e-8)


def test_a_whole_turn_is_counted_on():
    opensim = model("right-handed")
    q = np.zeros((200, 6))
    q[:, 0] = np.linspace(-1.0, 9.0, 200)
    found = root_motion(opensim, q)
    np.testing.assert_allclose(root_values(opensim, found.position, found.orientation), q, atol=1e-9)


def test_a_fixed_root_has_no_coordinates():
    assert root_values(OpenSim(), np.zeros((4, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (4, 1))).shape == (4, 0)
