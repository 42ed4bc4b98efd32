"""Motions of several instances at once are those of each alone, to the last bit."""

import msgspec
import numpy as np
import pytest

from same_values import assert_same
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout


def turning(name: str) -> Scene:
    """A scene whose body turns by more than half a turn about the vertical while it falls."""
    scene = load(name)
    state = msgspec.structs.replace(scene.initial_state, root_angular_velocity=(0.0, 20.0, 0.0))
    failure = msgspec.structs.replace(scene.failure, com_height=0.0, heading=0.0)
    return msgspec.structs.replace(scene, duration=0.5, initial_state=state, failure=failure)


def moved(name: str) -> Rollout:
    rollout = Rollout(turning(name), 3, "cpu", record=[0, 1, 2], threads=1)
    rollout.reset(velocity_noise=0.5, seed=3)
    rollout.run()
    return rollout


def test_motions_at_once_are_those_of_each_alone():
    rollout = moved("fwalk")
    together = rollout.recordings([2, 0, 1])
    alone = [rollout.recording(instance) for instance in (2, 0, 1)]
    assert_same(tuple(together), tuple(alone))
    assert_same(tuple(rollout.recordings()), tuple(rollout.recordings([0, 1, 2])))
    angles = [motion.joint_angle[:, motion.joint_angle_names.index("pelvis_rotation")] for motion in together]
    assert max(np.abs(angle).max() for angle in angles) > np.pi  # so that a break between two motions counts


def test_an_instance_that_was_not_recorded_is_refused():
    rollout = Rollout(turning("fwalk"), 2, "cpu", record=[1])
    with pytest.raises(RolloutError, match="instance 0 was not recorded"):
        rollout.recordings([1, 0])
