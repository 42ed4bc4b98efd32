"""Segments of a body from its height and mass."""

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.scene.anthropometry import LENGTHS, TABLES, segment

PAIRED = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")


@pytest.mark.parametrize("sex", TABLES)
def test_masses_add_up_to_that_of_the_body(sex):
    masses = {name: segment(name, 1.8, 80.0, sex).mass for name in LENGTHS}
    assert sum(masses.values()) + sum(masses[name] for name in PAIRED) == pytest.approx(80.0, rel=0.005)


def test_arm_of_a_subject_is_that_of_the_table():
    """1.86 m and 72 kg; percent of the length, from Dumas 2007 (right arm: x forwards, y upwards, z to the right)."""
    arm = segment("upper_arm", 1.86, 72.0)
    assert arm.mass == pytest.approx(0.024 * 72.0)
    assert arm.length == pytest.approx(0.186 * 1.86)
    np.testing.assert_allclose(arm.com, np.array([0.026, -0.452, 0.017]) * arm.length)
    np.testing.assert_allclose(arm.inertia, [0.021179, 0.004054, 0.019876], rtol=2e-3)
    assert arm.body().mass == arm.mass


def test_left_segments_are_the_mirror_images_of_right_ones():
    left, right = (segment("thigh", 1.7, 60.0, "female", side) for side in ("left", "right"))
    np.testing.assert_allclose(left.com, np.multiply(right.com, (-1.0, 1.0, 1.0)))
    assert left.inertia == right.inertia


def test_moments_of_inertia_are_those_of_a_body_that_can_exist():
    for sex in TABLES:
        for name in LENGTHS:
            inertia = np.array(segment(name, 1.8, 80.0, sex).inertia)
            assert np.all(inertia.sum() - inertia > inertia), (sex, name)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("wing", 1.8, 80.0), "no segment 'wing'; known: head, torso"),
        (("hand", 0.0, 80.0), "positive height and mass, not 0 m"),
        (("hand", 1.8, float("nan")), "positive height"),
    ],
)
def test_impossible_segments_are_refused(arguments, message):
    with pytest.raises(Error, match=message):
        segment(*arguments)
