"""Units into factors, by hand and against numbers that are scaled by laws of motion."""

import math

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene.sizes.similarity import factor_of, gait_of_size, powers


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("N m/rad", (1, 2, -2)), ("N m s/rad", (1, 2, -1)), ("rad/m", (0, -1, 0)), ("rad s/m", (0, -1, 1)),
        ("m/s", (0, 1, -1)), ("N m s^2/rad^2", (1, 2, 0)), ("m/(N s)", (-1, 0, 1)), ("1", (0, 0, 0)),
        ("Hz", (0, 0, -1)),
    ],
)  # fmt: skip
def test_units_are_powers_of_mass_length_and_time(unit, expected):
    assert powers(unit) == expected


def test_a_pendulum_twice_as_long_swings_by_the_root_of_two_more_slowly():
    assert factor_of("s", 2.0, 3.0) == pytest.approx(math.sqrt(2.0))
    assert factor_of("rad/s", 2.0, 3.0) == pytest.approx(1.0 / math.sqrt(2.0))
    assert factor_of("N m/rad", 2.0, 3.0) == pytest.approx(6.0)  # m g l
    assert factor_of("m/s", 2.0, 3.0) ** 2 / 2.0 == pytest.approx(1.0)  # the Froude number stays


@pytest.mark.parametrize("unit", ["l_opt/s", "eV"])
def test_other_units_have_no_known_size(unit):
    with pytest.raises(ValueError, match="no known size"):
        powers(unit)


def test_the_gait_of_fwalk_for_a_larger_body():
    scene, grown = load("fwalk"), gait_of_size(load("fwalk"), 1.44, 2.0)
    old, new = scene.controller, grown.controller
    assert new.pd["root"].kp.value == pytest.approx(2.88 * old.pd["root"].kp.value)
    assert new.pd["root"].kd.max == pytest.approx(2.88 * 1.2 * old.pd["root"].kd.max)
    assert new.pd["rHip"].kp == old.pd["rHip"].kp  # which follows the left one
    assert new.states[0].time.value == pytest.approx(1.2 * old.states[0].time.value)
    hip, grown_hip = (one.states[0].trajectories["SWING_Hip"].components[1] for one in (old, new))
    assert grown_hip.angle == hip.angle
    assert grown_hip.feedback.cd.value == pytest.approx(hip.feedback.cd.value / 1.44)
    assert grown_hip.feedback.cv.value == pytest.approx(hip.feedback.cv.value / 1.2)
    assert grown.initial_state.root_velocity[2] == pytest.approx(1.2 * scene.initial_state.root_velocity[2])
    assert grown.character == scene.character


def test_a_switch_that_is_off_stays_off_and_factors_are_positive():
    scene = load("fwalk")
    scene.controller.stance_hip_damping = -1.0
    assert gait_of_size(scene, 2.0, 8.0).controller.stance_hip_damping == -1.0
    with pytest.raises(SceneError, match="positive factor"):
        gait_of_size(scene, 0.0, 1.0)
