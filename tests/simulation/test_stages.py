"""The stages one at a time against the fused step."""

import copy
from typing import Any

import numpy as np
import pytest
import warp as wp

from warpmuscle.formats import load
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Actuation
from warpmuscle.scene.parameters import start_values
from warpmuscle.simulation.perturbations import Perturbations
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


@pytest.fixture(scope="module")
def walk() -> Recording:
    """A second of walking, every step."""
    scene = load("iwalk")
    scene.duration = 1.0
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    return rollout.recording()


@pytest.fixture(scope="module")
def stages(walk: Recording) -> Stages:
    """The stages in the states of the walk."""
    stages = Stages(load("iwalk"), walk.frames, "cpu")
    stages.set_state(
        walk.root_position, walk.root_orientation, walk.root_velocity, walk.root_angular_velocity,
        walk.joint_orientation, walk.joint_angular_velocity,
        phase=walk.phase, stance=walk.stance, machine_state=walk.state,
        foot_force=np.stack([walk.foot_force_left, walk.foot_force_right], axis=1),
    )  # fmt: skip
    return stages


def test_kinematics_are_those_of_the_fused_step(walk: Recording, stages: Stages):
    now = stages.forward_kinematics()
    np.testing.assert_allclose(now["position"], walk.body_position, atol=2e-6)
    np.testing.assert_allclose(now["com"][:, 0], walk.com, atol=2e-6)
    np.testing.assert_allclose(now["com"][:, 1], walk.com_velocity, atol=1e-5)


@pytest.fixture(scope="module")
def halfway(walk: Recording) -> Stages:
    """The stages in the middle of the walk, where the fused step has brought them."""
    stages = Stages(load("iwalk"), 1, "cpu")
    stages.run(0.4)
    return stages


def test_torques_are_those_of_the_fused_step(walk: Recording, halfway: Stages):
    target, torque = halfway.controller_torques()
    np.testing.assert_allclose(np.abs(np.sum(target[0] * walk.joint_target[800], axis=-1)), 1.0, atol=1e-5)
    np.testing.assert_allclose(torque[0], walk.joint_torque[800], atol=1e-5 * np.abs(torque).max())


def test_accelerations_are_those_of_the_fused_step(walk: Recording, halfway: Stages):
    """Velocities are extrapolated to the end of a step by half its acceleration."""
    before = halfway.state.accelerations.numpy()[0, :3]
    now = halfway.forward_dynamics(walk.joint_torque[800])["speed_rate"][0, :3]
    change = (walk.root_velocity[801] - walk.root_velocity[800]) / halfway.scene.time_step
    np.testing.assert_allclose(1.5 * now - 0.5 * before, change, atol=5e-3 * np.abs(change).max())


def test_contact_acts_on_the_feet_and_lies_between_nothing_and_a_few_times_the_weight(stages: Stages):
    force, _ = stages.contact_forces()
    feet = [stages.names.bodies.index(name) for name in ("lFoot", "lToes", "rFoot", "rToes")]
    others = [i for i in range(len(stages.names.bodies)) if i not in feet]
    assert np.all(force[:, others] == 0.0)
    assert np.all(force[..., 1] >= 0.0)
    assert 0.5 < force[:, feet, 1].sum(axis=1).mean() / (70.4 * 9.8) < 1.5


def test_stages_leave_the_states_alone(stages: Stages):
    arrays = stages.state.coordinates, stages.state.speeds, stages.state.simbicon.phase
    before = [array.numpy().copy() for array in arrays]
    stages.controller_torques()
    stages.forward_dynamics()
    stages.mass_matrix()
    after = [array.numpy() for array in arrays]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


def test_scene_without_controller_has_no_torques():
    scene = load("iwalk")
    scene.controller = None
    target, torque = Stages(scene, 2, "cpu").controller_torques()
    assert np.all(torque == 0.0)
    assert np.all(target == [0.0, 0.0, 0.0, 1.0])


def test_structures_for_other_kernels_are_those_of_the_batch(stages: Stages):
    model, state = stages.structs
    assert model.body_count == 15
    assert state.coordinates.shape == (2000, stages.names.coordinates)


def test_feet_may_carry_more_bodies_than_legs_usually_have():
    """Eleven bodies of which five are feet and toes: as many as the size class of fifteen has room for."""
    scene = load("iwalk")
    character, controller = scene.character, scene.controller
    for name in ("torso_head", "lShoulder", "rShoulder", "lElbow", "rElbow"):
        del character.bodies[character.joints.pop(name).child]
    character.bodies["lHeel"] = copy.deepcopy(character.bodies["lToes"])
    character.joints["lHeelJoint"] = copy.deepcopy(character.joints["lToeJoint"])
    character.joints["lHeelJoint"].child = "lHeel"
    controller.pd, controller.states[0].trajectories, scene.initial_state.joints = {}, {}, {}
    scene.initial_state.root_position = (0.0, 1.02, 0.0)
    fused, stages = Rollout(scene, 1, "cpu"), Stages(scene, 1, "cpu")
    mass = np.array([character.bodies[name].mass for name in stages.names.bodies])
    weight = np.array([0.0, 9.8 * mass.sum(), 0.0])
    acceleration = stages.forward_dynamics()["acceleration"][0]
    fused.run(scene.time_step)
    force = fused.state.foot_force.numpy()[0].sum(axis=0)
    assert force[1] > 100.0
    np.testing.assert_allclose(force, mass @ acceleration + weight, atol=1e-3 * force[1])


def begun(rollout: Rollout) -> Any:
    """A batch of two on slopes, excited from outside, after 0.05 s."""
    count = len(rollout.muscle_names)
    end = np.arange(count) * 0.37 % 1.0
    rollout.set_excitations([0.0, 0.6], np.stack([0.1 * end, end], axis=-1)[None])
    still = np.zeros((2, 3))
    rollout.disturb(Perturbations(still, still, np.zeros(2), np.array([0.1, -0.1])))
    rollout.run(0.05)
    return rollout


def test_stages_have_collisions_excitations_and_slope_as_the_fused_step_has():
    scene = load("walk56")
    scene.failure.self_collision, scene.failure.com_height, scene.failure.heading = 0.002, 0.0, 0.0
    scene.duration = 0.6
    usual, stages = begun(Rollout(scene, 2, "cpu", record=[0, 1], record_rate=2000)), begun(Stages(scene, 2, "cpu"))
    before = stages.snapshot()
    stages.muscle_paths()
    torque, muscles = stages.muscle_torques(stages.controller_torques()[1])
    stages.contact_forces()
    stages.forward_dynamics(torque)
    stages.restore(before)
    usual.run()
    for instance in (0, 1):
        recording, at = usual.recording(instance), 100
        scale = np.abs(recording.joint_torque[at]).max()
        np.testing.assert_allclose(torque[instance], recording.joint_torque[at], atol=1e-4 * scale)
        for name in ("muscle_excitation", "muscle_activation", "muscle_force"):
            size = np.abs(recording[name][at]).max()
            np.testing.assert_allclose(muscles[name][instance], recording[name][at], atol=1e-4 * size, err_msg=name)
    assert stages.model.collisions.pair.shape == usual.model.collisions.pair.shape != (0, 0)
    normal = stages.model.contacts.normal.numpy()
    assert normal.shape[0] == 2  # a slope for each
    assert not np.allclose(normal[0], normal[1])
    stages.run()
    assert stages.status().tolist() == usual.status().tolist()
    assert np.array_equal(stages.state.coordinates.numpy(), usual.state.coordinates.numpy())
    assert np.array_equal(stages.end_time(), usual.end_time())


def test_reflexes_excite_the_muscles_of_the_stages_too():
    scene = load("reflex_walk")
    scene.duration = 0.1
    stages, usual = Stages(scene, 1, "cpu"), Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    usual.run()
    stages.run(0.05)
    _, muscles = stages.muscle_torques(stages.controller_torques()[1])
    np.testing.assert_allclose(
        muscles["muscle_excitation"][0], usual.recording().muscle_excitation[stages.steps_done], atol=1e-5
    )


def contents(struct: Any, name: str = "model") -> dict[str, Any]:
    """All fields of a device structure and of those within it: arrays as bytes, numbers as they are."""
    found: dict[str, Any] = {}
    for field in struct._cls.vars:
        value = getattr(struct, field)
        if hasattr(value, "_cls"):
            found |= contents(value, f"{name}.{field}")
        elif isinstance(value, wp.array):
            found[f"{name}.{field}"] = (value.shape, value.numpy().tobytes() if value.size else b"")
        elif value is not None:
            found[f"{name}.{field}"] = tuple(value) if hasattr(value, "__len__") else value
    return found


@pytest.mark.parametrize(
    "name", ["fwalk", "walk56_search", "walk56_legacy", "wang2012", "reflex_walk", "throw", "bigbird_walk"]
)
def test_stages_and_rollout_have_the_same_model_in_every_array(name: str):
    scene = load(name)
    scene.failure.self_collision = 0.01 if name in ("fwalk", "walk56_search") else scene.failure.self_collision
    batches = Rollout(scene, 2, "cpu"), Stages(scene, 2, "cpu")
    values = start_values(scene) * np.array([[1.0], [1.001]])
    still, models = np.zeros((2, 3)), []
    for batch in batches:
        batch.set_parameters(values)
        batch.disturb(Perturbations(still, still, np.zeros(2), np.array([0.1, -0.1])))
        if batch.muscle_names:
            batch.set_excitations([0.0, 1.0], np.full((1, len(batch.muscle_names), 2), 0.3))
        if batch.motion_names:
            batch.set_motion([0.0], np.full((1, len(batch.motion_names), 1), 0.5))
        if isinstance(batch, Stages):
            batch.muscle_paths()
        models.append(contents(batch.model))
    assert len(models[0]) > 70
    assert models[0] == models[1]
    plain = contents(Rollout(scene, 2, "cpu").model)
    changed = {field for field in plain if plain[field] != models[1].get(field)}
    assert "model.contacts.normal" in changed
    assert ("model.muscles.knot_value" in changed) == bool(scene.character.muscles)
    assert ("model.motion.curve" in changed) == bool(batches[0].motion_names)
    assert ("model.collisions.pair" in models[1]) == (scene.failure.self_collision > 0.0)


def test_stages_that_told_the_paths_of_all_muscles_go_on_with_those_that_act():
    scene = load("throw")
    scene.actuation |= {name: Actuation("torque") for name in list(scene.character.joints)[-2:]}
    usual, stages = Rollout(scene, 1, "cpu"), Stages(scene, 1, "cpu")
    assert 0 < usual.model.muscles.count < len(scene.character.muscles)
    assert stages.muscle_paths().length.shape[1] == len(scene.character.muscles)
    assert contents(stages.model) == contents(usual.model)
