"""What moves of a character along a recorded motion of its arm."""

import numpy as np

from warpmuscle.formats import load
from warpmuscle.studies.inverse_dynamics import body_points
from warpmuscle.throw.arm import Arm, states
from warpmuscle.throw.motion import Motion, resample


def test_legs_of_a_whole_body_stay_upright_where_the_trunk_leans():
    arm, (time, pitch) = (
        Arm(load("throw_body")),
        (np.arange(0.0, 1.001, 0.01), 0.3 * np.sin(np.arange(0.0, 1.001, 0.01))),
    )
    still = np.tile([0.2, 1.0, 0.1], (len(time), 1))
    motions = resample([Motion("lean", 0.0, time, still, pitch, np.zeros((len(time), 2)))])
    q, v, a = (part[0] for part in states(arm, motions))
    points = body_points(arm.scene, q)
    np.testing.assert_allclose(points["r_thigh"][1], np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1)), atol=1e-9)
    assert np.abs(points["pelvis"][1][-1, 0]) > 0.1
    assert arm.hips == ("r_hip", "l_hip")
    speed, bend = (part[:, arm.names.speed_start[arm.names.body_of_joint("r_hip")]] for part in (v, a))
    np.testing.assert_allclose(np.gradient(speed, 0.01)[2:-2], bend[2:-2], atol=1e-3)
    np.testing.assert_allclose(speed, -motions.pitch[1][0], atol=1e-9)
