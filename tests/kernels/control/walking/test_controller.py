"""The walking controller as a whole: a biped stands, starts to walk and comes to its speed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.kernels.control.walking.parameters import RECORDED
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture(scope="module")
def walks() -> Rollout:
    """One that stands, and one that walks at 0.8 m/s, over 4 s."""
    rollout = Rollout(load("steer"), 2, "cpu", record=[0, 1])
    rollout.set_commands({"speed": [0.0, 0.8]})
    rollout.run(4.0)
    return rollout


def test_a_body_that_is_told_to_stand_stands_and_another_one_walks(walks: Rollout):
    assert np.isin(walks.status(), [Status.RUNNING, Status.COMPLETED]).all()
    standing, walking = walks.recording(0), walks.recording(1)
    assert np.abs(standing.com[-1] - standing.com[len(standing.com) // 2]).max() < 0.02
    late = walking.time > 3.0
    assert walking.com_velocity[late, 2].mean() == pytest.approx(0.8, abs=0.08)
    stance = walking.controller_value[:, 1]
    assert set(np.unique(standing.controller_value[:, 1])) == {2.0}
    assert (np.diff(stance) != 0.0).sum() > 6  # steps
    assert walking.controller_value_names == tuple(name for name, _ in RECORDED)


def test_torques_of_hinges_act_about_their_axes_alone(walks: Rollout):
    recording = walks.recording(1)
    shank = list(recording.body_names).index("lLowerleg")
    axis = Rotation.from_quat(recording.body_orientation[:, shank]).apply([1.0, 0.0, 0.0])
    torque = recording.joint_torque[:, list(recording.joint_names).index("lKnee")]
    assert np.linalg.norm(torque, axis=1).max() > 20.0
    np.testing.assert_allclose(torque, axis * np.sum(axis * torque, axis=1)[:, None], atol=0.05)


@pytest.mark.parametrize(("aside", "first"), [(-0.45, 1.0), (0.45, 0.0)])
def test_a_body_that_is_pushed_aside_as_it_starts_steps_out_on_the_side_that_it_falls_to(aside: float, first: float):
    """Over its right foot, the left leg swings first, though it is the right one that usually does."""
    rollout = Rollout(load("steer"), 1, "cpu", record=[0])
    rollout.set_commands({"speed": 0.8})
    speeds = rollout.state.speeds.numpy()
    speeds[0, 0] = aside
    rollout.state.speeds.assign(speeds)
    rollout.run(3.0)
    assert rollout.status()[0] == Status.RUNNING
    stance = rollout.recording(0).controller_value[:, 1]
    assert stance[stance != 2.0][0] == first
