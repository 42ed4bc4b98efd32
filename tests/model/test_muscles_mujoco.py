"""Muscles as MuJoCo understands them in the exported MJCF: paths and moment arms equal ours, the law is its own."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
import warp as wp

from mujoco_oracle import compile_model, state_to_qpos
from random_states import random_states
from warpmuscle.formats import load
from warpmuscle.kernels import stages
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.model.muscles import driven
from warpmuscle.scene import Actuation, Body, Character, Condition, Joint, Muscle, MuscleModel, Scene, ViaPoint
from warpmuscle.scene.number import Free
from warpmuscle.simulation.stages import Stages

ZERO, X = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
LENGTH = 0.3  # m, of the arm's muscle in the reference pose


@pytest.fixture(scope="module")
def biped(reference_data: Path) -> Scene:
    """The biped with 56 muscles."""
    file = reference_data / "simbicon/characters/bipV2M/bipV2M_save_allUniArticularMuscles.rbs"
    if not file.is_file():
        pytest.skip(f"no {file}")
    return load(file, ignored=[])


def arm(**muscle) -> Scene:
    """Two bodies, a hinge, and a muscle that is 0.3 m long in the reference pose and passes the hinge at 0.1 m."""
    bodies = {"base": Body(1.0, (0.1, 0.1, 0.1)), "tip": Body(1.0, (0.1, 0.1, 0.1))}
    joint = Joint("hinge", "base", "tip", ZERO, ZERO, axes=[X])
    bent = ViaPoint("base", (0.0, 0.0, 0.5), Condition("elbow", -0.5, 0.5))
    path = [ViaPoint("base", (0.0, 0.1, -0.15)), bent, ViaPoint("tip", (0.0, 0.1, 0.15))]
    given = {"f_max": 500.0, "l_opt": 0.1, "l_slack": 0.2} | muscle
    character = Character("base", bodies, {"elbow": joint}, "fixed", {"flexor": Muscle(path=path, **given)})
    return Scene("arm", character)


def tension(scene: Scene, activation: float, speed: float = 0.0) -> float:
    """Force in the flexor, N, of the arm in the reference pose with a joint speed, rad/s."""
    model = compile_model(scene)
    data = mujoco.MjData(model)
    data.act[:], data.qvel[:] = activation, speed
    mujoco.mj_forward(model, data)
    assert data.actuator_length[0] == pytest.approx(LENGTH)
    return -float(data.actuator_force[0])


def test_lengths_and_moment_arms_are_ours(biped: Scene):
    count = 20
    states, ours = random_states(biped.character, count, seed=7), Stages(biped, count, "cpu")
    table = driven(biped, ours.names).table
    ours.set_state(*(getattr(states, name) for name in type(states).__dataclass_fields__))
    workspace = wp.zeros((count, work_floats(capacity_of(len(ours.names.bodies)))), dtype=float, device="cpu")
    length, speed = (wp.zeros((count, 56), dtype=float, device="cpu") for _ in range(2))
    arms = wp.zeros((count, len(table.crossings)), dtype=wp.vec3, device="cpu")
    wp.launch(stages.muscle_paths_of(), count, [*ours.structs, workspace], [length, speed, arms], device="cpu")

    model = compile_model(biped)
    data = mujoco.MjData(model)
    body_of = [model.body(name).id for name in ours.names.bodies]
    rows = [model.tendon(name).id for name in table.muscles]
    assert len(rows) == model.ntendon == model.nu == 56
    for i in range(count):
        data.qpos, data.qvel = state_to_qpos(model, biped.character, states, i)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.ten_length[rows], length.numpy()[i], atol=1e-5)
        np.testing.assert_allclose(data.ten_velocity[rows], speed.numpy()[i], atol=1e-4)
        expected = np.zeros((model.ntendon, model.nv))
        for crossing, ours_arm in zip(table.crossings, arms.numpy()[i], strict=True):
            moves = np.flatnonzero(model.dof_bodyid == body_of[crossing.joint])
            expected[rows[crossing.muscle], moves] = data.cdof[moves, :3] @ ours_arm  # cdof: rotation axes, world
        np.testing.assert_allclose(tendon_moments(model, data), expected, atol=1e-5)
    assert np.abs(expected).max() > 0.05


def tendon_moments(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Derivatives of the tendons' lengths by the speeds' integrals (tendons, nv), m; MuJoCo stores what is not zero."""
    moments = np.zeros((model.ntendon, model.nv))
    if data.ten_J.size == moments.size:
        return np.array(data.ten_J).reshape(moments.shape)
    for row in range(model.ntendon):
        filled = slice(model.ten_J_rowadr[row], model.ten_J_rowadr[row] + model.ten_J_rownnz[row])
        moments[row, model.ten_J_colind[filled]] = data.ten_J[filled]
    return moments


def test_conditional_points_are_left_out():
    model = compile_model(arm())
    assert [model.site(i).name for i in range(model.nsite)] == ["flexor_0", "flexor_2"]


def test_muscle_has_its_force_at_its_optimal_length():
    assert tension(arm(), 1.0) == pytest.approx(500.0)
    assert tension(arm(), 0.25) == pytest.approx(125.0)


def test_fibre_length_is_what_the_tendon_leaves_over():
    """MuJoCo's active force ends at 0.5 and 1.6 optimal lengths and is a parabola halfway down at 0.75."""
    assert tension(arm(l_slack=0.225), 1.0) == pytest.approx(250.0)
    assert tension(arm(l_slack=0.25), 1.0) == pytest.approx(0.0, abs=1e-9)
    assert tension(arm(l_slack=0.14), 1.0) == tension(arm(l_slack=0.14), 0.0) > 500.0


def test_speed_counts_in_the_muscles_own_measure():
    """A moment arm of 0.1 m, so 10 rad/s shorten the fibre by ten optimal lengths a second."""
    scene = arm()
    ways = [tension(scene, 1.0, speed) for speed in (10.0, -10.0)]
    assert min(ways) == pytest.approx(0.0, abs=1e-9)
    assert max(ways) == pytest.approx(600.0)
    scene.muscle_model.v_max = 20.0
    assert min(tension(scene, 1.0, speed) for speed in (10.0, -10.0)) == pytest.approx(125.0)


def test_pennate_fibre_acts_along_the_tendon():
    at_optimum = arm(pennation=0.5, l_slack=LENGTH - 0.1 * np.cos(0.5))
    assert tension(at_optimum, 1.0) == pytest.approx(500.0 * np.cos(0.5))
    for speed in (-4.0, 4.0):  # the fibre sees the cosine of the path's speed
        pennate, straight = tension(at_optimum, 1.0, speed / np.cos(0.5)), tension(arm(), 1.0, speed)
        assert pennate == pytest.approx(straight * np.cos(0.5))


def test_activation_starts_and_changes_as_ours():
    scene = arm()
    scene.muscle_model = MuscleModel(rise_time=0.02, fall_time=0.05, initial_activation=Free(0.25, 0.0, 1.0))
    model = compile_model(scene)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    np.testing.assert_allclose(data.act, [0.25])
    np.testing.assert_allclose(model.actuator_dynprm[0, :2], [0.02, 0.05])


def test_muscle_that_drives_nothing_is_a_tendon_alone():
    scene = arm()
    scene.actuation = {"elbow": Actuation("torque")}
    model = compile_model(scene)
    assert (model.ntendon, model.nu, model.na) == (1, 0, 0)
