"""Degrees of freedom of recorded motions by name, in files beside the quaternions."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from opensim_table import table
from warpmuscle.core.pose import about, multiply
from warpmuscle.formats import load, sto
from warpmuscle.results.degrees_of_freedom import degrees_of_freedom
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.results.result import read, write
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture(scope="module")
def rollout() -> Rollout:
    """A walk on torques whose knees turn about an axis that differs from instance to instance."""
    scene = msgspec.structs.replace(load("fwalk"), duration=0.2)
    knee = scene.character.joints["lKnee"]
    x, _, z = knee.axes[0]
    knee.axes[0] = [x, Free(0.0, -0.5, 0.5), z]
    rollout = Rollout(scene, 2, "cpu", record=[0, 1])
    values = np.tile([p.value for p in rollout.parameters], (2, 1))
    values[1, [p.name for p in rollout.parameters].index("character.joints.lKnee.axes.0.1")] = 0.4
    rollout.set_parameters(values)
    rollout.run()
    return rollout


def angle(motion, name: str) -> np.ndarray:
    return motion.joint_angle[:, motion.joint_angle_names.index(name)]


def test_every_angle_has_a_name_and_turns_the_body_as_the_quaternion_does(rollout):
    motion = rollout.recording(0)
    assert len(motion.joint_angle_names) == motion.joint_angle.shape[1] == len(set(motion.joint_angle_names))
    turned = multiply(
        multiply(about(np.eye(3)[0], angle(motion, "lHip_x")), about(np.eye(3)[1], angle(motion, "lHip_y"))),
        about(np.eye(3)[2], angle(motion, "lHip_z")),
    )
    quaternion = motion.joint_orientation[:, motion.joint_names.index("lHip")]
    np.testing.assert_allclose(np.abs(np.sum(turned * quaternion, axis=1)), 1.0, atol=1e-6)
    np.testing.assert_allclose(
        angle(motion, "rKnee"), motion.coordinate[:, motion.coordinate_names.index("rKnee")], atol=1e-5
    )


def test_axes_are_those_of_the_instance(rollout):
    for instance in range(2):
        motion = rollout.recording(instance)
        knee = motion.coordinate[:, motion.coordinate_names.index("lKnee")]
        np.testing.assert_allclose(angle(motion, "lKnee"), knee, atol=1e-5)


def test_angles_are_read_back_from_a_file_and_are_those_of_the_exported_motion(rollout, tmp_path: Path):
    motion, scene = rollout.recording(0), rollout.scene
    result = Result("", "cpu", "", 0, parameter_table(rollout.parameters), replays=(motion,))
    write(tmp_path / "a.h5", result)
    found = read(tmp_path / "a.h5").replays[0]
    assert found.joint_angle_names == motion.joint_angle_names
    np.testing.assert_array_equal(found.joint_angle, motion.joint_angle)
    sto.write(motion, scene, tmp_path / "a.mot")
    _, names, rows = table(tmp_path / "a.mot")
    for name in motion.joint_angle_names:
        np.testing.assert_allclose(np.radians(rows[:, names.index(name)]), angle(motion, name), atol=1e-7)


def test_a_model_of_opensim_has_the_names_of_its_coordinates():
    scene = msgspec.structs.replace(load("gait2392_walk"), duration=0.02)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    motion = rollout.recording()
    assert {"pelvis_tilt", "hip_flexion_r", "knee_angle_l", "ankle_angle_r"} <= set(motion.joint_angle_names)
    assert "pelvis_tx" not in motion.joint_angle_names
    assert degrees_of_freedom(motion, rollout.scene)
