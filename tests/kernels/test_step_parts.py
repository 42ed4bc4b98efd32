"""Stages of a step are of the instance whose step it is: batches in which others than the first matter."""

import numpy as np

from muscle_arm import leg
from warpmuscle.scene import Actuation, Motion
from warpmuscle.simulation.rollout import Rollout


def test_every_instance_swings_by_the_motion_that_is_prescribed():
    """A shank hangs on a thigh that is moved: without the thigh's acceleration it would swing otherwise."""
    time = np.linspace(0.0, 0.2, 21)
    turns = np.stack([0.3 * np.sin(12.0 * time), 0.0 * time, 0.0 * time], axis=1)
    scene = leg(motion={"hip": Motion(time.tolist(), rotation=turns.tolist())}, duration=0.1, time_step=0.001)
    scene.actuation = {"hip": Actuation("kinematic"), "knee": Actuation("torque")}
    scene.character.muscles = {}
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2])
    rollout.run()
    first, *others = (rollout.recording(k).coordinate for k in range(3))
    assert np.abs(first[-1, -1] - first[0, -1]) > 0.05
    for other in others:
        np.testing.assert_array_equal(other, first)
