"""What the muscles of an arm lack for motions."""

from dataclasses import replace

import numpy as np

from warpmuscle.throw.arm import Arm
from warpmuscle.throw.computed_synergies import computed_excitation
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.missing_torque import Lack, lacking, shortcoming
from warpmuscle.throw.motion import ArmMotion, resample


def faster(motion: ArmMotion, factor: float) -> ArmMotion:
    return ArmMotion("fast", 0.0, motion.time / factor, motion.angles, motion.pitch, motion.place)


def test_a_motion_beyond_the_strength_of_the_muscles_says_which_lack_how_much(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    strong = Job(arm.scene, [], JobOptions()).strong
    usual, fast = resample([motion]), resample([faster(motion, 3.0)])
    unknowns = np.zeros(0)
    assert not lacking(strong, usual, computed_excitation(strong, usual)[-1], unknowns)
    lack = lacking(strong, fast, computed_excitation(strong, fast)[-1], unknowns)[0]
    assert "m1 lacks" in lack.explanation or "m4 lacks" in lack.explanation
    assert lack.joint in arm.driven
    assert lack.weak
    assert abs(lack.bound) < abs(lack.needed)


def test_what_an_arm_lacks_is_told_once_in_a_sentence(arm_and_motion: tuple[Arm, ArmMotion]):
    """Where muscles are far too weak, as for a pitch, turns that a planar arm does not have are named."""
    arm, motion = arm_and_motion
    strong = Job(arm.scene, [], JobOptions()).strong
    fast = resample([motion, faster(motion, 4.0), faster(motion, 3.0)])
    lacks = lacking(strong, fast, computed_excitation(strong, fast)[-1], np.zeros(0))
    text = shortcoming(arm, lacks, 3, "the muscle groups")
    assert text.startswith("the muscle groups cannot make 2 of 3 motions: the ")
    assert "N m in fast at " in text
    assert "turning trunk, upper arm and forearm about themselves" in text
    assert "\n" not in text
    assert shortcoming(arm, [], 3, "the muscle groups") == ""
    weak = [replace(lacks[0], needed=10.0, least=-5.0, most=8.0, others=())]
    assert shortcoming(arm, weak, 1, "the fitted muscles").endswith("and they make at most 8")


def test_a_torque_that_muscles_make_too_much_of_is_told_apart_from_weakness(arm_and_motion: tuple[Arm, ArmMotion]):
    """Passive forces of stretched muscles, and muscles over two joints, are no lack of strength."""
    arm, _ = arm_and_motion
    stretched = Lack("m", "", 0.1, "shoulder", 0.5, 4.25, 0.48, 4.73, 119.0)
    assert "shoulder needs 4.25 N m at 0.50 s, and stretched as they are they make at least 4.73" in shortcoming(
        arm, [stretched], 1, "the fitted muscles"
    )
    other_way = replace(stretched, needed=-3.5, least=2.0, most=20.0)
    assert "make 2 or more the other way" in shortcoming(arm, [other_way], 1, "the fitted muscles")
    together = replace(stretched, least=-9.0, most=9.0, others=("elbow", "wrist"))
    text = shortcoming(arm, [together], 1, "the fitted muscles")
    assert "which they do not make together with the torques of elbow and wrist" in text
    assert not any(lack.weak for lack in (stretched, other_way, together))
