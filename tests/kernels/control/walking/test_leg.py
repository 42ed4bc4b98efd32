"""The leg whose ankle comes to a place, against its own forward kinematics in float64."""

import numpy as np
import pytest
from probes import evaluate, units, vectors
from scipy.spatial.transform import Rotation

from warpmuscle.kernels.control.walking.leg import axes_along, knee_angle, reaching_length, thigh_rotation, turned

THIGH, SHANK, AXIS = np.array([0.01, -0.43, 0.02]), np.array([0.0, -0.41, 0.03]), np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_hip_and_knee_bring_the_ankle_where_it_is_to_be(sense: float):
    random = np.random.default_rng(2)
    thigh, shank = THIGH * [0, 1, 1], SHANK  # across the knee's axis
    reach = units(12, 3) * random.uniform(0.3, 0.8, (12, 1))
    across = vectors(12, 4)
    angle = evaluate(knee_angle, np.linalg.norm(reach, axis=1), thigh, shank, AXIS, sense)
    own = thigh + Rotation.from_rotvec(angle[:, None] * AXIS).apply(shank)
    np.testing.assert_allclose(np.linalg.norm(own, axis=1), np.linalg.norm(reach, axis=1), rtol=1e-5)
    assert np.all(sense * angle > -0.15)  # it bends in its sense
    rotation = evaluate(thigh_rotation, reach, across, own, AXIS)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", rotation, own), reach, atol=2e-6)
    np.testing.assert_allclose(rotation @ rotation.swapaxes(1, 2), np.broadcast_to(np.eye(3), (12, 3, 3)), atol=2e-6)
    # Of all such rotations it is the one whose knee's axis is nearest to the one that is wanted.
    about = Rotation.from_rotvec(0.05 * reach / np.linalg.norm(reach, axis=1)[:, None]).as_matrix()
    near = np.sum((rotation @ AXIS) * across, axis=1)
    assert np.all(near > np.sum((about @ rotation @ AXIS) * across, axis=1))


def test_a_place_out_of_reach_straightens_the_knee():
    far = evaluate(knee_angle, 2.0, np.array([0, -0.4, 0.0]), np.array([0, -0.4, 0.0]), AXIS, 1.0)[0]
    assert far == pytest.approx(0.0, abs=1e-3)


def test_vectors_turn_by_rodrigues_and_axes_stand_across():
    v, axis, angle = vectors(8, 5), units(8, 6), np.linspace(-3.0, 3.0, 8)
    np.testing.assert_allclose(
        evaluate(turned, v, axis, angle), Rotation.from_rotvec(axis * angle[:, None]).apply(v), atol=2e-6
    )
    first, second = vectors(8, 7), vectors(8, 8)
    axes = evaluate(axes_along, first, second)
    np.testing.assert_allclose(axes[:, :, 0], first / np.linalg.norm(first, axis=1)[:, None], atol=1e-6)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, atol=1e-5)
    assert np.all(np.sum(axes[:, :, 1] * second, axis=1) > 0.0)


def test_a_leg_is_so_short_that_the_other_one_reaches_its_foothold():
    random = np.random.default_rng(4)
    reach = 0.88
    to_foothold = np.stack(
        [random.uniform(-0.1, 0.1, 40), random.uniform(-1.1, -0.7, 40), random.uniform(0, 0.4, 40)], 1
    )
    to_foot = np.stack([np.zeros(40), random.uniform(-0.95, -0.85, 40), random.uniform(-0.3, 0.3, 40)], 1)
    length = evaluate(reaching_length, to_foothold, to_foot, reach)
    lowered = -to_foot[:, 1] - np.sqrt(length**2 - to_foot[:, 2] ** 2)  # by which the hip is then lower
    far = np.linalg.norm(to_foothold, axis=1) > reach
    assert far.sum() > 10
    assert (~far).sum() > 5
    np.testing.assert_allclose(lowered[~far], 0.0, atol=1e-5)
    there = to_foothold[far] + lowered[far, None] * [0.0, 1.0, 0.0]
    np.testing.assert_allclose(np.linalg.norm(there, axis=1), reach, atol=1e-5)
