"""Coordinates as the state of bodies: rates and forces by differences and by power."""

import numpy as np
import pytest

import muscle_arm
from small_leg import motion, small_leg
from warpmuscle.core.pose import conjugate, multiply, normalized
from warpmuscle.formats import load
from warpmuscle.inverse.coordinates import CoordinateMap
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.studies.inverse_dynamics import body_accelerations, body_points

H = 1.0e-4  # s, between states whose differences are rates


def leg_map(tmp_path, ball_joints: bool) -> CoordinateMap:
    return CoordinateMap(load(small_leg(tmp_path), ignored=[], ball_joints=ball_joints))


def states_along(found: CoordinateMap, time: float):
    """States a little before, at, and a little after a time of a motion without end."""
    random = np.random.default_rng(3)
    size, phase = random.uniform(0.2, 0.5, len(found.names)), random.uniform(0.0, 6.0, len(found.names))

    def at(t: float):
        turn = 3.0 * t + phase
        return found.states(
            *(part[None] for part in (size * np.sin(turn), 3.0 * size * np.cos(turn), -9.0 * size * np.sin(turn)))
        )

    return [at(time + step) for step in (-H, 0.0, H)]


@pytest.mark.parametrize("ball_joints", [False, True])
def test_speeds_are_rates_of_the_bodies_places_and_rates_those_of_speeds(tmp_path, ball_joints):
    found = leg_map(tmp_path, ball_joints)
    before, now, after = states_along(found, 0.4)
    assert now.rates[0] == pytest.approx((after.speeds - before.speeds)[0] / (2.0 * H), abs=1e-4)
    places = [body_points(found.scene, one.coordinates) for one in (before, now, after)]
    accelerations = body_accelerations(found.scene, now.coordinates, now.speeds, now.rates)
    for name in found.topology.bodies:
        by_differences = (places[2][name][0] - 2.0 * places[1][name][0] + places[0][name][0]) / H**2
        assert accelerations[name][0][0] == pytest.approx(by_differences[0], abs=1e-3)


def test_angular_speeds_turn_the_root_as_its_orientations_do(tmp_path):
    found = leg_map(tmp_path, False)
    before, now, after = states_along(found, 0.7)
    turned = multiply(normalized(after.coordinates[:, 3:7]), conjugate(normalized(before.coordinates[:, 3:7])))
    assert now.speeds[0, 3:6] == pytest.approx(turned[0, :3] / turned[0, 3] / H, abs=1e-4)


@pytest.mark.parametrize("ball_joints", [False, True])
def test_forces_of_coordinates_have_the_power_of_forces_of_speeds(tmp_path, ball_joints):
    found = leg_map(tmp_path, ball_joints)
    random = np.random.default_rng(5)
    values, rates = random.uniform(-0.5, 0.5, (2, 6, len(found.names)))
    states = found.states(values, rates, np.zeros_like(rates))
    effort = random.normal(size=states.speeds.shape)
    power = np.sum(found.forces(effort, states) * rates, axis=1)
    assert power == pytest.approx(np.sum(effort * states.speeds, axis=1), rel=1e-9)


def test_names_and_units_are_those_of_the_model(tmp_path):
    found = leg_map(tmp_path, False)
    assert found.names == motion().names
    assert dict(zip(found.names, found.units, strict=True))["pelvis_ty"] == "m"
    assert dict(zip(found.names, found.units, strict=True))["knee_angle"] == "rad"
    assert found.roots == 6


def test_a_scene_of_its_own_has_names_of_joints():
    scene = muscle_arm.leg()
    found = CoordinateMap(substitute(scene, start_values(scene)))
    joints = scene.character.joints
    ball = next(name for name, joint in joints.items() if joint.type == "ball")
    assert {f"{ball}_{axis}" for axis in "xyz"} <= set(found.names)


@pytest.mark.parametrize("ball_joints", [False, True])
def test_values_of_states_are_those_that_they_were_made_of(tmp_path, ball_joints):
    found = leg_map(tmp_path, ball_joints)
    values = np.random.default_rng(6).uniform(-0.5, 0.5, (20, len(found.names)))
    states = found.states(values, np.zeros_like(values), np.zeros_like(values))
    assert found.values(states.coordinates) == pytest.approx(values, abs=1e-9)
    arm = CoordinateMap(substitute(muscle_arm.leg(), start_values(muscle_arm.leg())))
    values = np.random.default_rng(7).uniform(-0.5, 0.5, (20, len(arm.names)))
    assert arm.values(arm.states(values, 0.0 * values, 0.0 * values).coordinates) == pytest.approx(values, abs=1e-9)
