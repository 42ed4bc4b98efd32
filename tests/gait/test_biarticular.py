"""One pair of muscles across elbow and wrist (Bergmann 2017, section 7.3)."""

import numpy as np
import pytest

from warpmuscle.core.pose import twist_angle
from warpmuscle.formats import load
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Actuation
from warpmuscle.simulation.rollout import Rollout

TARGETS = {"synchronised": [-0.5, 0.5, -0.5], "opposed": [0.5, -0.5, 0.5]}  # rad, of the wrist
AXES = {"rElbow": (0.0, 1.0, 0.0), "rWrist": (0.0, 0.0, 1.0)}


def motion(wrist: list[float], torques: bool) -> Recording:
    scene = load("wrist_biarticular")
    scene.controller.states[0].trajectories["rWrist"].components[0].angle = wrist
    scene.duration = 6.0
    if torques:
        scene.actuation = {name: Actuation("torque") for name in scene.character.joints}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=100.0)
    rollout.run()
    return rollout.recording().window(3.5)


def turned(recording: Recording, joint: str) -> np.ndarray:
    return np.unwrap(twist_angle(recording.joint_orientation[:, recording.joint_names.index(joint)], AXES[joint]))


def test_muscles_across_two_joints_suit_synchronised_motion_and_not_opposed_motion():
    alike = {}
    for name, wrist in TARGETS.items():
        on_torques, on_muscles = motion(wrist, True), motion(wrist, False)
        alike[name] = [np.corrcoef(turned(on_torques, j), turned(on_muscles, j))[0, 1] for j in AXES]
    assert alike["synchronised"][1] > 0.6
    assert alike["opposed"][1] < -0.4
    assert alike["synchronised"][0] > alike["opposed"][0]


def test_the_spring_of_the_wrist_is_no_stiffer_than_its_gain():
    scene = load("wrist_biarticular")
    assert scene.actuation["rWrist"].stiffness == pytest.approx(scene.controller.pd["rWrist"].kp)
