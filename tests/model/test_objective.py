"""What the terms of an objective count."""

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.model.unused_parameters import unused_parameters
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout


def walk(**factors) -> Scene:
    scene = load("fwalk")
    scene.duration = 0.5
    scene.objective.torque_by_joint = factors
    return scene


def run(scene: Scene) -> Rollout:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    return rollout


def test_feedback_torques_count_as_often_as_their_joints_are_weighed():
    plain = run(walk())
    recording, step = plain.recording(), plain.scene.time_step
    by_joint = {  # N m s, from recorded torques rather than from what the device has summed
        joint: step * np.linalg.norm(recording.joint_torque_desired[:-1, index], axis=-1).sum()
        for index, joint in enumerate(recording.joint_names)
    }
    once = plain.terms()["torque"][0]
    weighed = run(walk(lHip=5.0, rKnee=0.0)).terms()["torque"][0]
    assert by_joint["lHip"] > 1.0
    assert weighed - once == pytest.approx(4.0 * by_joint["lHip"] - by_joint["rKnee"], rel=0.02)


def test_weights_of_torques_may_be_searched_for_and_are_never_unused():
    scene = walk(lHip=Free(5.0, 1.0, 10.0))
    assert not [name for name in unused_parameters(scene) if "torque_by_joint" in name]
    assert run(scene).terms()["torque"][0] == run(walk(lHip=5.0)).terms()["torque"][0]


@pytest.mark.parametrize(
    ("factors", "message"),
    [
        ({"lHop": 2.0}, "objective.torque_by_joint.lHop: no joint is called 'lHop'; did you mean 'lHip'"),
        ({"lHip": -1.0}, "objective.torque_by_joint.lHip: must not be negative, is -1"),
        ({"lHip": float("nan")}, "objective.torque_by_joint.lHip: "),
    ],
)
def test_weights_of_torques_name_joints_and_are_not_negative(factors, message):
    with pytest.raises(SceneError, match=message):
        check_scene(walk(**factors))
