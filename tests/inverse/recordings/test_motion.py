"""Trials as motions: what they hold agrees with the coordinates and moments that they are made of."""

import msgspec
import numpy as np
import pytest

import small_leg
import warpmuscle as wm
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.recordings.motion import recorded_motions, scene_with_feet
from warpmuscle.results.degrees_of_freedom import degrees_of_freedom
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.studies.inverse_dynamics import inverse_dynamics


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A model, prepared trials of 40 and 25 frames, their efforts, and the recordings."""
    body = BodyModel(small_leg.small_leg(tmp_path_factory.mktemp("leg")), "cpu")
    motions = [small_leg.motion(40), small_leg.motion(25, seed=1)]
    trials = prepare(body, motions, [small_leg.loads(motions[0].times), None], None, None)
    states = trials.states
    effort = inverse_dynamics(body.scene, states.coordinates, states.speeds, states.rates)
    return body, trials, effort, recorded_motions(body, trials, effort)


def test_coordinates_come_back_from_the_motion(made):
    body, trials, _, motions = made
    assert [motion.frames for motion in motions] == [40, 25]
    values = trials.split(trials.values)
    for motion, own in zip(motions, values, strict=True):
        found = {one.name: one.values for one in degrees_of_freedom(motion, body.scene)}
        for k, name in enumerate(body.map.names):
            assert found[name] == pytest.approx(own[:, k], abs=1e-9), name


def test_joints_do_the_work_that_their_coordinates_take(made):
    body, trials, effort, (motion, _) = made
    relative = np.zeros_like(motion.joint_torque)
    parents = list(body.topology.parents[1:])
    for k, parent in enumerate(parents):
        turn = motion.body_orientation[:, parent]
        w = motion.joint_angular_velocity[:, k]
        relative[:, k] = rotate(turn, w)
    power = -np.einsum("njk,njk->n", motion.joint_torque, relative)
    first = body.topology.speed_start[1]
    wanted = np.einsum("ns,ns->n", effort[:40, first:], trials.states.speeds[:40, first:])
    assert np.abs(wanted).max() > 1.0
    assert power == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_velocities_are_the_rates_of_places_and_turns(made):
    *_, (motion, _) = made
    step = float(np.diff(motion.time).mean())
    middle = (motion.com[2:] - motion.com[:-2]) / (2.0 * step)
    assert motion.com_velocity[1:-1] == pytest.approx(middle, abs=5e-3)
    turned = multiply(motion.root_orientation[2:], conjugate(motion.root_orientation[:-2]))
    turned = turned * np.sign(turned[:, 3:])
    assert motion.root_angular_velocity[1:-1] == pytest.approx(turned[:, :3] / step, abs=5e-3)


def test_feet_are_known_by_the_names_of_bodies():
    scene = substitute(wm.load("gait2392_walk"), start_values(wm.load("gait2392_walk")))
    without = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, feet=None))
    if without.feet is not None:
        without = msgspec.structs.replace(without, controller=None)
    found = scene_with_feet(without).feet
    assert found is not None
    assert [foot[-2:] for foot in found] == ["_l", "_r"]
    assert all(foot in scene.character.bodies for foot in found)
