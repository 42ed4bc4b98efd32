"""Moments and powers of the legs against the mechanics of a leg: x points to the left, y up, z forwards."""

import dataclasses

import numpy as np
import pytest

from biped import random_recording
from warpmuscle.formats import load
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.joint_moments import PEOPLE, from_people, leg_moments, leg_powers
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute

# Torque on the child, about x to the left, that extends hip and knee and plantarflexes the ankle.
EXTENDING = {"Hip": 1.0, "Knee": -1.0, "Ankle": 1.0}


def turned_legs(heading: float):
    """The biped's scene, and a motion whose every joint bears 35 N m of extension, all bodies turned alike."""
    free = load("walk56")
    scene = substitute(free, start_values(free))
    for joint in scene.character.joints.values():
        joint.limits = []  # a random motion is beyond them
    joints, bodies = tuple(scene.character.joints), tuple(scene.character.bodies)
    recording = random_recording(12, joints=len(joints))
    half = np.array([0.0, np.sin(0.5 * heading), 0.0, np.cos(0.5 * heading)])
    left = np.array([np.cos(heading), 0.0, -np.sin(heading)])
    torque = np.zeros_like(recording.joint_torque)
    for name, sign in EXTENDING.items():
        for side in "lr":
            torque[:, joints.index(side + name)] = -35.0 * sign * left  # on the parent
    return scene, dataclasses.replace(
        recording,
        joint_names=joints,
        body_names=bodies,
        joint_torque=torque,
        body_orientation=np.tile(half, (recording.frames, len(bodies), 1)),
    )


@pytest.mark.parametrize("heading", [0.0, 1.1, -2.5])
def test_moments_of_extensors_and_plantarflexors_are_positive_whatever_the_heading(heading: float):
    scene, recording = turned_legs(heading)
    for of_sides in leg_moments(recording, scene).values():
        for curve in of_sides.values():
            np.testing.assert_allclose(curve, 35.0 / body_mass(scene.character), rtol=1e-5)


def test_power_is_that_of_the_torque_on_the_child_as_it_turns_against_the_parent():
    scene, recording = turned_legs(0.0)
    for name, of_sides in leg_powers(recording, scene).items():
        for side, power in of_sides.items():
            k = recording.joint_names.index(side[0] + name.split()[0])
            expected = -np.sum(recording.joint_torque[:, k] * recording.joint_angular_velocity[:, k], axis=1)
            np.testing.assert_allclose(power, expected / body_mass(scene.character), rtol=1e-5)


def test_the_distance_from_people_is_that_of_both_sides_in_their_mean_standard_deviation():
    for name, norm in PEOPLE.items():
        mean, deviation = norm.mean(PERCENT), norm.sd(PERCENT).mean()
        assert from_people(name, [mean, mean + 2.0 * deviation]) == pytest.approx(1.0)
        assert from_people(name, [mean - deviation, mean - deviation]) == pytest.approx(1.0)
