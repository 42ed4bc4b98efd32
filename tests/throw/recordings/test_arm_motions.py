"""Motions that an arm is fitted to, and those that are refused."""

from dataclasses import replace

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.motion import ArmMotion
from warpmuscle.throw.recordings.arm_motions import check_limits, check_range


def test_motions_beyond_the_limits_of_a_joint_are_refused(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    angles = motion.angles.copy()
    angles[70, 1] = 4.0
    scene = arm.scene
    if not scene.character.joints["elbow"].limits:
        scene.character.joints["elbow"].limits = [(-0.2, 2.7)]
    with pytest.raises(Error, match=r"elbow is at 229\.2 deg after 0\.7 s"):
        check_limits(Arm(scene), ArmMotion("m", 0.0, motion.time, angles, motion.pitch, motion.place))
    for zero, sign, what in ((0.0, -1.0, "its negative"), (np.pi, -1.0, "180 deg less it")):
        angles[:, 1] = zero + sign * np.linspace(0.1, 2.0, len(angles))
        with pytest.raises(Error, match=rf"a straight arm that hangs down\? Within them would be .*{what}"):
            check_limits(Arm(scene), ArmMotion("m", 0.0, motion.time, angles, motion.pitch, motion.place))


def test_joints_that_stand_still_are_refused_unless_they_are_prescribed(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    still = replace(motion, angles=motion.angles * [1.0, 1.0, 0.01])
    with pytest.raises(Error, match=r"wrist moves by no more than 0\.\d+ deg.*--prescribe wrist"):
        check_range(arm, still)
    check_range(Arm(arm.scene, ("wrist",)), still)
