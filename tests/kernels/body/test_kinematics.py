"""Where bodies are and how they move, beside sines and cosines."""

import numpy as np
import pytest
from joint_chains import chain, lagging

from muscle_arm import REACH, arm
from warpmuscle.scene import JointState
from warpmuscle.simulation.rollout import Rollout


@pytest.mark.parametrize("root", ["free", "planar", "fixed"])
def test_velocities_lag_by_what_their_speeds_gained_in_half_a_step(root: str):
    found, gained = lagging(chain(("universal", "none"), ("ball", "none"), ("hinge", "none"), root=root))
    np.testing.assert_allclose(found[:, :, 2:], gained, atol=2e-5)
    moves = {"free": (True, True), "planar": (True, True), "fixed": (False, False)}[root]
    assert (np.abs(gained[:, 0]).max(axis=(0, 2)) > 0.01).tolist() == list(moves)
    assert np.abs(gained[:, -1]).max() > 0.05


def test_the_centre_of_mass_moves_as_those_of_the_bodies_do():
    """Of two bodies of one mass, whose joint is the centre of mass of the one that stands still."""
    angle, speed = 0.7, 2.0
    scene = arm(duration=0.01)
    half = 0.5 * angle
    turned = JointState((np.sin(half), 0.0, 0.0, np.cos(half)), (speed, 0.0, 0.0))
    scene.initial_state.joints["elbow"] = turned
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    recording = rollout.recording(0)
    place = np.array([0.0, -np.cos(angle), -np.sin(angle)]) * REACH
    np.testing.assert_allclose(recording.body_position[0, 1] - recording.body_position[0, 0], place, atol=1e-6)
    velocity = 0.5 * speed * REACH * np.array([0.0, np.sin(angle), -np.cos(angle)])
    np.testing.assert_allclose(recording.com_velocity[0], velocity, atol=1e-6)
