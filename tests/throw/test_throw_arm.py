"""What moves of a character along a recorded motion of its arm."""

from dataclasses import replace

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.studies.inverse_dynamics import body_points
from warpmuscle.throw.arm import Arm, joint_positions, root_motion, states
from warpmuscle.throw.motion import ArmMotion, resample


def test_legs_of_a_whole_body_stay_upright_where_the_trunk_leans():
    arm, (time, pitch) = (
        Arm(load("throw_body")),
        (np.arange(0.0, 1.001, 0.01), 0.3 * np.sin(np.arange(0.0, 1.001, 0.01))),
    )
    still = np.tile([0.2, 1.0, 0.1], (len(time), 1))
    motions = resample([ArmMotion("lean", 0.0, time, still, pitch, np.zeros((len(time), 2)))])
    q, v, a = (part[0] for part in states(arm, motions))
    points = body_points(arm.scene, q)
    np.testing.assert_allclose(points["r_thigh"][1], np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1)), atol=1e-9)
    assert np.abs(points["pelvis"][1][-1, 0]) > 0.1
    assert arm.hips == ("r_hip", "l_hip")
    speed, bend = (part[:, arm.names.speed_start[arm.names.body_of_joint("r_hip")]] for part in (v, a))
    np.testing.assert_allclose(np.gradient(speed, 0.01)[2:-2], bend[2:-2], atol=1e-3)
    np.testing.assert_allclose(speed, -motions.pitch[1][0], atol=1e-9)


def test_the_shoulder_accelerates_alike_in_the_middle_and_at_the_ends_of_a_noisy_file(
    arm_and_motion: tuple[Arm, ArmMotion],
):
    """Its place and the trunk's pitch are differentiated once, not again as the root's place."""
    arm, motion = arm_and_motion
    noisy = motion.pitch + np.radians(0.02) * np.random.default_rng(0).normal(size=motion.pitch.shape)
    bend = root_motion(arm, resample([replace(motion, pitch=noisy)]))[2][0]
    clean = root_motion(arm, resample([motion]))[2][0]
    error = np.abs(bend - clean).max(axis=1)
    assert error[[0, 1, -2, -1]].max() < 1.5 * error[10:-10].max()


def test_the_root_moves_so_that_the_shoulder_does_as_recorded(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    motions = resample([motion])
    q, v, a = states(arm, motions)
    shoulder = joint_positions(arm, q[0])[0][:, [2, 1]]
    np.testing.assert_allclose(shoulder - shoulder[0], motions.place[0][0] - motions.place[0][0, 0], atol=1e-9)
    np.testing.assert_allclose(np.gradient(q[0, :, :3], 0.01, axis=0)[1:-1], v[0, 1:-1, :3], atol=0.02)
    np.testing.assert_allclose(np.gradient(v[0, :, :3], 0.01, axis=0)[1:-1], a[0, 1:-1, :3], atol=0.5)


def test_one_angle_of_a_universal_joint_may_be_the_muscles():
    """The whole body's elbow and wrist, whose other angle stays as the scene has it."""
    arm = Arm(load("throw_body"))
    assert arm.axes == {"shoulder": 0, "elbow": 1, "wrist": 1}
    assert arm.simulated.actuation["elbow"].drive == ["kinematic", "muscle"]
    prescribed = Arm(arm.scene, ("elbow",)).simulated
    assert prescribed.actuation["elbow"].drive == ["kinematic", "kinematic"]


def test_muscles_over_two_angles_of_a_joint_are_refused_rather_than_fitted_in_part():
    scene = load("throw_body")
    scene.character.muscles["m5"].pulleys[0].axis = 0
    with pytest.raises(Error, match="wrist, which is neither a hinge nor a universal joint with one"):
        Arm(scene)


def test_joints_that_no_muscle_moves_cannot_be_prescribed():
    with pytest.raises(Error, match="knee"):
        Arm(load("throw"), ("knee",)).driven  # noqa: B018
    with pytest.raises(Error, match="all joints"):
        Arm(load("throw"), ("shoulder", "elbow", "wrist"))
