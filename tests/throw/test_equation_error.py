"""What counts in fits without simulation."""

import numpy as np

from warpmuscle.scene.parameters import start_values
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.equation_error import Capacity
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.motion import ArmMotion, resample


def faster(motion: ArmMotion, factor: float) -> ArmMotion:
    return ArmMotion("fast", 0.0, motion.time / factor, motion.angles, motion.pitch, motion.place)


def test_what_a_motion_needs_beyond_the_muscles_strength_counts_in_fits(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    strong = Job(arm.scene, [], JobOptions()).strong
    motions = resample([motion, faster(motion, 3.0)])
    usual, fast = Capacity(strong, motions).residuals(np.array([0, 1]), np.zeros((2, 0)))
    assert np.abs(usual).max() < 0.2 < np.abs(fast).max()
    literature = Capacity(arm, motions).residuals(np.array([0]), arm.unknowns(start_values(arm.scene))[None])
    assert np.abs(literature).max() > 2.0 * np.abs(usual).max()
