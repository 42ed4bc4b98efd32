"""Inverse dynamics against MuJoCo's, in float64, and back through the simulation's forward dynamics."""

from typing import Any

import numpy as np
import pytest
from probes import matrix

from biped import biped
from random_states import random_states
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about, conjugate, rotate
from warpmuscle.formats import load
from warpmuscle.scene import Body, Character, Failure, Ground, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.ground_loads import step_accelerations
from warpmuscle.studies.inverse_dynamics import body_points, inverse_dynamics, joint_space


def character_of(name: str) -> Character:
    character = load("bigbird_walk").character if name == "bigbird" else biped()
    for joint in character.joints.values():
        joint.limits = []
    if name in ("planar", "fixed"):
        character.root_joint = name
    return character


def motion(scene: Scene, states) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and speeds of states."""
    root = (states.root_position, states.root_orientation, states.root_velocity, states.root_angular_velocity)
    parts = [root_type(scene.character).coordinates_of(*root)]
    for i, name in enumerate(topology(scene.character).joints):
        parts.append(
            joint_type(scene.character.joints[name]).nearest(
                scene.character.joints[name], states.joint_orientation[:, i], states.joint_angular_velocity[:, i]
            )
        )
    return tuple(np.concatenate([part[k] for part in parts], axis=1) for k in (0, 1))


def places(model: Any, character: Character) -> list[int]:
    """MuJoCo's degree of freedom for each of our speeds."""
    found = list(range({"free": 6, "planar": 3, "fixed": 0}[character.root_joint]))
    for name in topology(character).joints:
        kind = character.joints[name].type
        if kind == "ball":
            found += range(model.joint(name).dofadr[0], model.joint(name).dofadr[0] + 3)
        elif kind != "fixed":
            labels = [name] if kind == "hinge" else [f"{name}_a", f"{name}_b"]
            found += [model.joint(label).dofadr[0] for label in labels]
    return found


@pytest.mark.parametrize("name", ["biped", "bigbird", "planar", "fixed"])
def test_forces_are_those_of_mujoco(name: str, mujoco_oracle):
    mujoco, state_to_qpos = mujoco_oracle.mujoco, mujoco_oracle.state_to_qpos
    scene = Scene("x", character_of(name), ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0))
    character, states = scene.character, random_states(scene.character, 20, seed=4)
    coordinates, speeds = motion(scene, states)
    accelerations = np.random.default_rng(5).normal(size=speeds.shape) * 20.0
    got = inverse_dynamics(scene, coordinates, speeds, accelerations)
    model = mujoco_oracle.compile_model(scene)
    order, data = places(model, character), mujoco.MjData(model)
    for k in range(len(states)):
        data.qpos, data.qvel = state_to_qpos(model, character, states, k)
        wanted = accelerations[k].copy()
        turn = conjugate(states.root_orientation[k])
        if character.root_joint == "free":  # MuJoCo turns a free body about its own axes
            wanted[3:6] = rotate(turn, wanted[3:6])
        data.qacc[order] = wanted
        mujoco.mj_inverse(model, data)
        expected = data.qfrc_inverse[order].copy()
        if character.root_joint == "free":
            expected[3:6] = rotate(states.root_orientation[k], expected[3:6])
        np.testing.assert_allclose(got[k], expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["biped", "planar", "fixed"])
def test_mass_matrix_and_gravity_are_those_of_mujoco(name: str, mujoco_oracle):
    mujoco, state_to_qpos = mujoco_oracle.mujoco, mujoco_oracle.state_to_qpos
    scene = Scene("x", character_of(name), ground=Ground(stiffness=0.0))
    states = random_states(scene.character, 5, seed=3, speed=0.0)
    found = joint_space(scene, motion(scene, states)[0])
    model = mujoco_oracle.compile_model(scene)
    order, data = places(model, scene.character), mujoco.MjData(model)
    matrices = mujoco_oracle.mass_matrix(scene, states)[:, order][:, :, order]
    for k in range(len(states)):
        data.qpos, data.qvel = state_to_qpos(model, scene.character, states, k)
        mujoco.mj_forward(model, data)
        to_world, gravity = np.eye(len(order)), -data.qfrc_bias[order]
        if scene.character.root_joint == "free":
            to_world[3:6, 3:6] = rotate(states.root_orientation[k], np.eye(3)).T
        np.testing.assert_allclose(found.mass_matrix[k], to_world @ matrices[k] @ to_world.T, atol=1e-9)
        np.testing.assert_allclose(found.gravity[k], to_world @ gravity, atol=1e-9)


def test_bodies_are_where_mujoco_places_them(mujoco_oracle):
    scene = Scene("x", biped(), ground=Ground(stiffness=0.0))
    states = random_states(scene.character, 5, seed=1)
    coordinates, _ = motion(scene, states)
    position, orientation, *_ = mujoco_oracle.body_states(scene, states)
    points = body_points(scene, coordinates)
    names = topology(scene.character)
    for i, body in enumerate(names.bodies):
        joint, turned = points[body]
        offset = np.zeros(3) if i == 0 else -np.array(scene.character.joints[names.joints[i - 1]].position_in_child)
        np.testing.assert_allclose(joint + rotate(turned, np.tile(offset, (5, 1))), position[:, i], atol=1e-9)
        np.testing.assert_allclose(np.abs(np.sum(turned * orientation[:, i], axis=-1)), 1.0, atol=1e-9)


def test_recorded_torques_are_those_that_acted_over_the_step():
    """A controller that is implicit gives way over a step: the torque at its start is another one."""
    scene = load("fwalk")
    scene.implicit_pd, scene.duration = True, 0.1
    scene.ground.height, scene.failure.com_height, scene.failure.heading = -100.0, 0.0, 0.0
    for joint in scene.character.joints.values():
        joint.limits = []
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / float(scene.time_step))
    rollout.run()
    fall, names = rollout.recording(), topology(scene.character)
    accelerations = step_accelerations(fall, float(scene.time_step))
    assert accelerations is not None
    needed = inverse_dynamics(scene, fall.coordinate, fall.speed, accelerations)
    acted = np.zeros_like(needed)
    at_start = acted.copy()
    for number, name in enumerate(names.joints, start=1):
        joint, speeds = scene.character.joints[name], names.speeds_of(number)
        parent = np.asarray(fall.body_orientation[:, names.parents[number]], float)
        axes = joint_type(joint).pulled_about(
            joint, np.asarray(fall.coordinate[:, names.coordinates_of(number)], float)
        )
        for torques, found in ((fall.joint_torque, acted), (fall.joint_torque_desired, at_start)):
            torque = -np.asarray(torques[:, number - 1], float)
            found[:, speeds] = np.stack([np.sum(rotate(parent, axis) * torque, axis=1) for axis in axes], axis=1)
    peak, kept = np.abs(needed[:, 6:]).max(), slice(20, -1)
    assert np.abs(needed[kept] - acted[kept]).max() < 2e-4 * peak
    assert np.abs(needed[kept] - at_start[kept]).max() > 0.005 * peak


def test_a_body_whose_principal_axes_are_turned_needs_the_torque_of_its_inertia_tensor():
    """Euler's equation in the body's axes, J a + w x J w, with J = P diag(I) P^T."""
    turn, axes = about([0.6, 0.0, 0.8], 0.9), about([0.0, 1.0, 0.0], 0.5)
    body = Body(2.0, (0.08, 0.05, 0.03), inertia_axes=tuple(axes.tolist()))
    failure = Failure(com_height=0.0, heading=0.0)
    scene = Scene("x", Character("top", {"top": body}, {}), ground=Ground(stiffness=0.0), failure=failure)
    w, a = np.array([[3.0, -2.0, 5.0]]), np.array([[7.0, 4.0, -6.0]])
    none = np.zeros((1, 3))
    coordinates, speeds = root_type(scene.character).coordinates_of(none, turn[None], none, w)
    got = inverse_dynamics(scene, coordinates, speeds, np.concatenate([none, a], axis=1))
    principal, whole = matrix(axes), matrix(turn)
    tensor = whole @ principal @ np.diag(body.inertia) @ principal.T @ whole.T  # in the world's axes
    np.testing.assert_allclose(got[0, 3:], tensor @ a[0] + np.cross(w[0], tensor @ w[0]), rtol=1e-9)
    np.testing.assert_allclose(got[0, :3], [0.0, 2.0 * scene.gravity, 0.0], atol=1e-12)


def test_other_shapes_and_numbers_that_are_not_finite_are_refused():
    scene = Scene("x", biped())
    names = topology(scene.character)
    with pytest.raises(Error, match="coordinates"):
        inverse_dynamics(scene, np.zeros((3, 2)), np.zeros((3, 2)), np.zeros((3, 2)))
    still = np.zeros((2, names.speeds))
    with pytest.raises(Error, match="finite"):
        inverse_dynamics(scene, np.full((2, names.coordinates), np.nan), still, still)
