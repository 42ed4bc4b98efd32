"""The controller against recordings of the original program, and against its description in double precision."""

from pathlib import Path

import numpy as np
import pytest
import simbicon_oracle as oracle
import warp as wp
from probes import evaluate, filled, matrix, turn_about, units, vectors

from biped import biped, xyzw
from random_states import States, random_states
from warpmuscle.formats import load
from warpmuscle.kernels.control import simbicon, simbicon_equations
from warpmuscle.kernels.structs import LEFT, REVERSE, RIGHT, SAME, Model, Scratch, Simbicon, Skeleton
from warpmuscle.model.controllers.simbicon import model_fields
from warpmuscle.scene import (
    PD,
    Balance,
    Component,
    Controller,
    Curve,
    Feedback,
    Ground,
    MachineState,
    Scene,
    Trajectory,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.stages import Stages

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def torques(scene: Scene, states: States, **controller_state) -> tuple[np.ndarray, np.ndarray]:
    """Targets (n, J, 4) and torques (n, J, 3) of the kernels."""
    stages = Stages(scene, len(states), "cpu")
    stages.set_state(*(getattr(states, name) for name in States.__dataclass_fields__), **controller_state)
    return stages.controller_torques()


@pytest.fixture(scope="module")
def recorded(reference_data: Path) -> dict[str, np.ndarray]:
    """Every step of a second of walking of the original program."""
    with np.load(reference_data / "simbicon" / "reference" / "fullrate_bipV2_fWalk.npz") as file:
        return {name: file[name] for name in file.files}


@pytest.fixture(scope="module")
def replayed(recorded) -> tuple[np.ndarray, np.ndarray]:
    """Targets and torques of the kernels in the recorded states."""
    states = States(
        recorded["root_pos"], xyzw(recorded["root_quat"]), recorded["root_vel"], recorded["root_angvel"],
        xyzw(recorded["joint_quat"]), recorded["joint_angvel"],
    )  # fmt: skip
    force = np.stack([recorded["foot_force_l"], recorded["foot_force_r"]], axis=1)
    return torques(load("fwalk"), states, phase=recorded["phi"], stance=recorded["stance"], foot_force=force)


def test_recorded_states_give_the_recorded_torques(recorded, replayed):
    largest = np.abs(recorded["joint_torque"]).max()
    error = np.abs(replayed[1] - recorded["joint_torque"]) / largest
    assert error.max() < 1e-3
    assert np.median(error) < 1e-5


def test_recorded_states_give_the_recorded_targets(recorded, replayed):
    off = 1.0 - np.abs(np.sum(replayed[0] * xyzw(recorded["desired_quat"]), axis=-1))
    assert off.max() < 1e-5


# All rules at once, most of which no shipped gait uses.


def everything_on() -> Scene:
    """A controller with every feature on, on the biped; it would not walk."""

    def curve(*value: float) -> Curve:
        return Curve(list(np.linspace(0.1, 1.1, len(value)) ** 1.5), list(value))

    def turn(axis, *angle: float, **more) -> Component:
        knots = curve(*angle)
        return Component(axis, knots.phase, knots.value, **more)

    lateral = Feedback(X, 0.5, 0.3, d_limits=(-0.1, 0.2), v_limits=(-0.5, 0.4))
    oblique = Feedback((1.0, 0.0, -2.0), -0.4, 0.2)
    joints = list(biped().joints)
    first = MachineState(
        0.5,
        {
            "root": Trajectory([turn(X, 0.1, 0.2), turn(Z, -0.2)], strength=curve(0.5, 1.5)),
            "SWING_Hip": Trajectory([turn(Z, 0.1, -0.3, 0.2, reverse_on="left", feedback=lateral), turn(X, -0.6)]),
            "STANCE_Hip": Trajectory([turn(X, 0.2, -0.1)], strength=curve(0.3, 0.9, 0.6)),
            "lKnee": Trajectory([turn(X, 1.0)], strength=curve(5.0)),
            "STANCE_Knee": Trajectory([turn(X, 0.2, 0.5, feedback=oblique)]),
            "SWING_Ankle": Trajectory([turn(Z, 0.3, 0.1, reverse_on="right"), turn(X, 0.4)], frame="character"),
            "torso_head": Trajectory([turn((1.0, 2.0, 3.0), 0.4), Component(Y)], frame="character"),
        },
        balance=Balance(curve(0.05, 0.1), curve(-0.1), curve(0.2, 0.1, 0.3), curve(0.5, 1.0)),
    )
    second = MachineState(
        0.3, {"pelvis_torso": Trajectory([turn(Y, 0.2, -0.2, feedback=oblique)])}, 1, "time_up", "same"
    )
    return Scene(
        "everything on",
        biped(),
        Controller(
            [first, second],
            {name: PD(100.0 + 30.0 * i, 5.0 + i, 80.0, (1.0, 0.2, 0.7)) for i, name in enumerate(joints[:-1])}
            | {"root": PD(800.0, 60.0, 300.0, (1.0, 0.5, 0.9)), "lHip": PD(300.0, 30.0, 150.0, (1.0, 0.66, 0.8))},
            stance_hip_damping=25.0,
            stance_hip_max_velocity=2.0,
            root_predictive_torque_scale=3.0,
            desired_heading=0.3,
        ),
    )


def upright_states(count: int, seed: int) -> States:
    """Random states whose heading is well defined, some of them low above the ground."""
    states, rng = random_states(biped(), count, seed, speed=2.0), np.random.default_rng(seed)
    tilt = rng.normal([0.0, 0.0, 0.0, 2.0], 0.5, size=(count, 4))
    states.root_orientation[:] = tilt / np.linalg.norm(tilt, axis=1, keepdims=True)
    states.root_position[:, 1] = rng.uniform(0.1, 1.0, count)
    return states


@pytest.mark.parametrize(
    "change", [{}, {"heading_control": False}, {"stance_hip_damping": -1.0}, {"stance_hip_damping": 0.8}, {"pd": {}}]
)
def test_random_states_give_the_torques_of_the_description(change):
    scene, count, rng = everything_on(), 50, np.random.default_rng(3)
    for name, value in change.items():
        setattr(scene.controller, name, value)
    states = upright_states(count, seed=4)
    given = {
        "phase": rng.uniform(0.0, 1.1, count),
        "stance": rng.integers(0, 2, count),
        "machine_state": rng.integers(0, 2, count),
        "foot_force": rng.normal(300.0, 300.0, (count, 2, 3)) * rng.integers(0, 2, (count, 2, 1)),
    }
    target, torque = torques(scene, states, **given)
    for i in range(count):
        expected_target, expected = oracle.control(scene, states, i, *(value[i] for value in given.values()))
        np.testing.assert_allclose(np.abs(np.sum(target[i] * expected_target, axis=-1)), 1.0, atol=1e-6)
        np.testing.assert_allclose(torque[i], expected, atol=1e-4 * max(np.abs(torque).max(), 1.0))


def test_joint_without_gains_gets_no_torque():
    _, torque = torques(everything_on(), upright_states(20, seed=5))
    assert np.all(torque[:, -1] == 0.0)  # the last joint, a toe, has none


def test_of_two_trajectories_of_one_joint_the_later_wins():
    scene = load("fwalk")
    angles = {name: Trajectory([Component(X, [0.0], [a])]) for name, a in (("lKnee", 0.3), ("STANCE_Knee", 0.8))}
    knee = list(Stages(scene, 1, "cpu").names.joints).index("lKnee")
    states = upright_states(2, seed=6)
    for order, in_left_stance in ((1, 0.8), (-1, 0.3)):
        scene.controller.states = [MachineState(0.5, dict(list(angles.items())[::order]))]
        target, _ = torques(scene, states, stance=[0, 1])
        np.testing.assert_allclose(2.0 * np.arcsin(target[:, knee, 0]), [in_left_stance, 0.3], atol=1e-6)


def test_torques_on_the_root_add_up_to_its_own_whatever_the_load_of_the_feet():
    scene, count, gains = load("fwalk"), 50, PD(3000.0, 300.0, scale=(1.0, 0.2, 1.0))
    scene.controller.pd["root"], scene.controller.stance_hip_damping = gains, -1.0
    del scene.controller.states[0].trajectories["root"]
    states = upright_states(count, seed=7)
    states.root_position[:, 1] = 1.0
    _, torque = torques(scene, states, foot_force=np.random.default_rng(8).uniform(1.0, 700.0, (count, 2, 3)))
    names = Stages(scene, 1, "cpu").names
    total = sum(torque[:, i] for i, parent in enumerate(names.parents[1:]) if parent == 0)
    for i in range(count):
        expected = oracle.pd(states.root_orientation[i], oracle.IDENTITY, states.root_angular_velocity[i], gains, 1.0)
        np.testing.assert_allclose(total[i], -expected, atol=5e-3)


# The state machine, step by step.


def machine(phase: float, states: list[MachineState], stance: int = 0) -> tuple[float, int, int]:
    """Phase, state and stance after one step in free flight, from state 0."""
    scene = load("fwalk")
    scene.controller.states, scene.ground = states, Ground(stiffness=0.0)
    stages = Stages(scene, 1, "cpu")
    s = stages.state
    s.simbicon.phase.fill_(phase)
    s.simbicon.stance.fill_(stance)
    stages.run(scene.time_step)
    return tuple(getattr(s.simbicon, name).numpy()[0] for name in ("phase", "machine_state", "stance"))


def test_phase_advances_by_the_nominal_duration_of_the_state():
    phase, state, stance = machine(0.6, [MachineState(0.4)])
    assert (phase, state, stance) == (pytest.approx(0.6 + 0.0005 / 0.4), 0, LEFT)


@pytest.mark.parametrize("transition", ["foot_down", "time_up"])
@pytest.mark.parametrize(
    ("rule", "before", "after"),
    [("reverse", 0, 1), ("reverse", 1, 0), ("same", 1, 1), ("same", 0, 0), ("left", 1, 0), ("right", 1, 1)],
)
def test_at_phase_one_the_next_state_begins_with_its_own_stance(transition, rule, before, after):
    states = [MachineState(0.4, next=1, transition=transition, stance="same"), MachineState(0.7, stance=rule)]
    assert machine(0.9999, states, before) == (0.0, 1, after)


def test_state_that_may_last_passes_phase_one_in_flight_and_ends_at_its_longest():
    states = [MachineState(0.4, next=1, longest=1.5, stance="same"), MachineState(0.7, stance="reverse")]
    assert machine(0.9999, states) == (pytest.approx(0.9999 + 0.0005 / 0.4), 0, LEFT)
    assert machine(1.4999, states) == (0.0, 1, RIGHT)


def test_each_instance_waits_for_its_own_longest_phase():
    scene = substitute(load("fwalk"), start_values(load("fwalk")))
    free = MachineState(0.4, next=1, longest=Free(1.2, 1.0, 2.0), stance="same")
    scene.controller.states, scene.ground = [free, MachineState(0.7)], Ground(stiffness=0.0)
    stages = Stages(scene, 2, "cpu")
    values = substitute(scene, np.array([[1.2], [1.6]]))
    stages.model.simbicon = model_fields(values, stages.names, "cpu")["simbicon"]
    stages.state.simbicon.phase.fill_(1.4)
    stages.run(scene.time_step)
    assert stages.state.simbicon.machine_state.numpy().tolist() == [1, 0]


def test_targets_beyond_phase_one_are_those_at_phase_one():
    scene, states = everything_on(), upright_states(30, seed=9)
    scene.controller.states[0].longest = 2.0
    for at_one, beyond in zip(*(torques(scene, states, phase=phase) for phase in (1.0, 1.7)), strict=True):
        np.testing.assert_array_equal(at_one, beyond)


# The functions, one by one.


def test_transition_needs_a_loaded_swing_foot_after_half_the_time():
    phase = np.array([0.4, 0.51, 0.51, 0.51, 0.51, 1.0, 1.0])
    on_foot_down = np.array([1, 1, 1, 1, 0, 0, 1])
    force = np.array([500.0, 19.0, 21.0, -21.0, 500.0, 0.0, 0.0])
    due = evaluate(simbicon_equations.transition_due, phase, np.ones(7), on_foot_down, force)
    assert due.tolist() == [0, 0, 1, 1, 0, 1, 1]


def test_state_that_may_last_waits_for_its_foot_up_to_its_longest_phase():
    phase, force = np.array([1.0, 1.39, 1.39, 1.4, 1.41]), np.array([0.0, 0.0, 21.0, 0.0, 0.0])
    due = evaluate(simbicon_equations.transition_due, phase, np.full(5, 1.4), np.ones(5, int), force)
    assert due.tolist() == [0, 0, 1, 1, 1]


def test_stance_rules():
    stance, rule = np.array([0, 1, 0, 1, 0, 1, 0, 1]), np.array([REVERSE] * 2 + [SAME] * 2 + [LEFT] * 2 + [RIGHT] * 2)
    assert evaluate(simbicon_equations.stance_after, stance, rule).tolist() == [1, 0, 0, 1, 0, 0, 1, 1]


def test_balance_feedback_clamps_position_and_velocity_apart():
    d, v, axis = vectors(200, 1), vectors(200, 2), units(200, 3)
    got = evaluate(simbicon_equations.balance_feedback, d, v, axis, [0.5, -0.2], [-0.3, 0.4, -1.0, 0.1])
    along_d, along_v = np.sum(d * axis, axis=1), np.sum(v * axis, axis=1)
    np.testing.assert_allclose(got, 0.5 * np.clip(along_d, -0.3, 0.4) - 0.2 * np.clip(along_v, -1.0, 0.1), atol=1e-6)


def test_pd_error_is_the_turn_that_leads_to_the_target_the_short_way():
    q, axis, angle = units(300, 1, 4), units(300, 2), np.random.default_rng(3).uniform(-3.1, 3.1, 300)
    target = oracle.multiply(q, turn_about(axis, angle))
    for sign in (1.0, -1.0):  # q and -q are the same orientation
        np.testing.assert_allclose(evaluate(simbicon.pd_error, q, sign * target), angle[:, None] * axis, atol=3e-5)


def test_pd_torque_scales_first_and_clamps_each_axis():
    error, velocity, scale = vectors(300, 1), vectors(300, 2), np.array([1.0, 0.2, 0.5])
    got = evaluate(simbicon_equations.pd_torque, error, velocity, 50.0, 4.0, 0.7, scale, 20.0)
    wanted = scale * 0.7 * (4.0 * velocity - 50.0 * error)
    np.testing.assert_allclose(got, np.clip(wanted, -20.0 * scale, 20.0 * scale), atol=1e-4)
    assert np.any(np.abs(wanted) > 20.0 * scale)


def test_hip_damping_grows_with_the_square_of_the_yaw_rate_up_to_its_largest():
    rate = np.array([-9.0, -2.0, 0.0, 1.0, 4.0, 50.0])
    np.testing.assert_allclose(
        evaluate(simbicon_equations.hip_damping, rate, 10.0, 4.0), [160.0, 40.0, 0.0, -10.0, -160.0, -160.0], rtol=1e-6
    )


def test_stance_share_is_the_part_of_the_load_or_minus_one_without_load():
    share = evaluate(
        simbicon_equations.stance_share, np.array([300.0, 0.0, 50.0, 0.0]), np.array([100.0, 20.0, 0.0, 0.0])
    )
    np.testing.assert_allclose(share, [0.75, 0.0, 1.0, -1.0])


def test_torques_fade_with_the_height_of_the_root():
    height = np.array([-1.0, 0.2, 0.25, 0.3, 0.4, 2.0])
    np.testing.assert_allclose(
        evaluate(simbicon_equations.strength_by_height, height), [0.0, 0.0, 0.25, 0.5, 1.0, 1.0], atol=1e-6
    )


def test_hip_takes_its_share_within_limits_along_the_thigh():
    q, torque, part, bound = units(100, 1, 4), vectors(100, 2), vectors(100, 3), np.array([0.5, 1.0, 5.0])
    rotation = matrix(q)
    got = evaluate(simbicon.hip_share, 0.3, torque, part, rotation, bound)
    child = np.clip(np.einsum("nji,nj->ni", rotation, torque + 0.3 * part), -bound, bound)
    np.testing.assert_allclose(got, np.einsum("nij,nj->ni", rotation, child), atol=1e-6)


def test_implicit_pd_is_the_explicit_one_of_the_step_ahead():
    """With a constant joint acceleration, error and velocity after the step give torque + inertia * acceleration."""
    kp, kd, strength, scale, h = 300.0, 30.0, 0.8, np.array([1.0, 0.2, 0.5]), 0.002
    velocity, acceleration = vectors(50, 1), vectors(50, 2, 100.0)
    after = velocity + h * acceleration
    ahead = scale * strength * (kd * after + kp * h * after)
    inertia = evaluate(simbicon_equations.pd_inertia, kp, kd, strength, scale, h)
    now = scale * strength * (kd + h * kp) * velocity
    np.testing.assert_allclose(now + inertia * acceleration, ahead, rtol=1e-5, atol=1e-4)


def test_no_axis_at_its_limit_is_implicit_whichever_way_it_pushes():
    torque = np.array([[0.9, -0.9, 0.5], [1.1, 0.2, -1.1], [-1.1, -1.1, 1.1], [-0.5, 1.1, -0.9]])
    got = evaluate(simbicon_equations.unless_clamped, np.array([2.0, 3.0, 4.0]), torque, np.ones(3))
    np.testing.assert_allclose(got, [[2, 3, 4], [0, 3, 0], [0, 0, 0], [2, 0, 4]])


@wp.kernel(enable_backward=False)
def torque_of(model: Model, work: Scratch):
    its = work
    simbicon.joint_torque(0, 1, False, wp.quat(0.0, 0.0, 0.0, 1.0), model, its)


@pytest.mark.parametrize("implicit", [0, 1])
@pytest.mark.parametrize("limit", [1000.0, 6.0])
def test_implicit_pd_brakes_by_what_its_spring_will_do_within_the_step(implicit: int, limit: float):
    """On the parent s (-kp e + (kd + h kp) w), implicit by s h (kd + h kp) about axes that are not at their limit."""
    kp, kd, h, strength, scale = 300.0, 8.0, 0.01, 0.8, np.array([1.0, 0.2, 0.5])
    turned, axis, angle, spin = units(2, 1, 4), units(1, 2)[0], 0.03, vectors(2, 3, 0.6)
    relative = oracle.multiply(turned[0] * [-1.0, -1.0, -1.0, 1.0], turned[1])
    target = oracle.multiply(relative, turn_about(axis, np.array([angle]))[0])
    frames, none = matrix(turned), np.zeros((2, 3), np.float32)
    gains = {"kp": [[0.0, kp]], "kd": [[0.0, kd]], "torque_limit": [[0.0, limit]], "scale": np.tile(scale, (1, 2, 1))}
    model = filled(
        Model, implicit_pd=implicit, time_step=h, simbicon=filled(Simbicon, gains=gains),
        skeleton=filled(Skeleton, plan={"parent": [-1, 0]}),
    )  # fmt: skip
    work = filled(
        Scratch, rotation=np.float32(frames), orientation=np.float32(turned), angular_velocity=np.float32(spin),
        lag_angular=none, target=np.float32(np.stack([target, target])), strength=np.float32([0.0, strength]),
        torque=none.copy(), stiffness=np.zeros((2, 6), np.float32),
    )  # fmt: skip
    wp.launch(torque_of, 1, [model, work], device="cpu")
    damping = kd + implicit * h * kp
    wanted = scale * strength * (damping * frames[1].T @ (spin[1] - spin[0]) - kp * angle * axis)
    bound = scale * limit
    got = frames[1].T @ work.torque.numpy()[1]
    np.testing.assert_allclose(got, np.clip(wanted, -bound, bound), rtol=1e-4, atol=2e-3)
    six = work.stiffness.numpy()[1]
    full = frames[1].T @ six[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3) @ frames[1]
    free = np.where(np.abs(wanted) < bound, implicit * scale * strength * h * damping, 0.0)
    np.testing.assert_allclose(full, np.diag(free), atol=1e-6)
    assert (np.abs(wanted) > bound).any() == (limit < 10.0)


def test_the_controller_sees_velocities_at_the_middle_of_the_step():
    """What speeds have gained in the last half step is taken off those that torques damp; feedback is of the step."""
    scene, count, rng = everything_on(), 40, np.random.default_rng(5)
    for state in scene.controller.states:
        state.balance = Balance()
        for component in (c for trajectory in state.trajectories.values() for c in trajectory.components):
            component.feedback = None
    states = upright_states(count, seed=6)
    stages, given = Stages(scene, count, "cpu"), {"stance": rng.integers(0, 2, count)}
    given["foot_force"] = rng.uniform(50.0, 400.0, (count, 2, 3))
    stages.set_state(*(getattr(states, name) for name in States.__dataclass_fields__), **given)
    plain = stages.controller_torques()[1]
    now = stages.state.speeds.numpy()
    gained = rng.normal(0.0, 1.5, now.shape).astype(np.float32)
    stages.state.speeds.assign(now + gained)
    different = stages.controller_torques()[1]
    stages.state.accelerations.assign(gained / (0.5 * stages.numeric.time_step))
    same = stages.controller_torques()[1]
    scale = np.abs(plain).max()
    np.testing.assert_allclose(same, plain, atol=2e-4 * scale)
    assert np.abs(different - plain).max() > 0.05 * scale
