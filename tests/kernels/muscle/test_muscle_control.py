"""From wanted torques to activations, against NumPy in float64."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, vectors

from muscle_arm import leg
from random_states import random_states
from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.muscle import activation, muscle_control
from warpmuscle.kernels.structs import CLIP, DROP, KEEP, MuscleRow, Muscles, MuscleState, TimedExcitation
from warpmuscle.scene import JointState, MuscleModel
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

TIME_STEP = 1.0 / 2000.0


def test_wanted_force_gives_the_torque_along_the_moment_arm():
    torque, arm = vectors(200, 0, 50.0), vectors(200, 1, 0.05)
    force = evaluate(muscle_control.wanted_force, torque, arm)
    along = np.sum(torque * arm, axis=1) / np.linalg.norm(arm, axis=1)
    np.testing.assert_allclose(force * np.linalg.norm(arm, axis=1), along, atol=1e-4)
    assert (force < 0.0).any()


def test_muscle_without_a_moment_arm_is_not_wanted():
    arm = np.array([[0.0, 0.0, 0.0], [0.0, 1e-8, 0.0]])
    assert np.all(evaluate(muscle_control.wanted_force, (1.0, 2.0, 3.0), arm) == 0.0)


@pytest.mark.parametrize(
    ("negative", "pushing"),
    [(KEEP, [-5.0, 1.0]), (DROP, [0.0, 0.0]), (CLIP, [0.0, 1.0])],
    ids=["keep", "drop", "clip"],
)
def test_pushing_joint_counts_as_the_scene_says_and_a_pulling_one_always(negative: int, pushing: list[float]):
    np.testing.assert_array_equal(evaluate(muscle_control.counted, [-5.0, 7.0], negative), [pushing, [7.0, 1.0]])


# Several joints.


def average(contributions: list[float], negative: str) -> float:
    """The desired force of a muscle from what each of its joints wants."""
    counted = [force for force in contributions if negative != "drop" or force > 0.0]
    if negative == "clip":
        counted = [max(force, 0.0) for force in counted]
    return max(sum(counted), 0.0) / max(len(counted), 1)


@pytest.mark.parametrize("negative", ["keep", "drop", "clip"])
def test_muscle_over_two_joints_should_have_the_average_of_what_they_want(negative: str):
    n, scene = 100, leg(muscle_model=MuscleModel(ideal=True, negative=negative))
    stages, states = Stages(scene, n, "cpu"), random_states(scene.character, n)
    stages.set_state(*(getattr(states, name) for name in type(states).__dataclass_fields__))
    torque, paths = np.stack([vectors(n, 1, 20.0), vectors(n, 2, 20.0)], axis=1), stages.muscle_paths()
    force = stages.muscle_torques(torque)[1]["muscle_desired_force"]
    arms = list(zip(paths.muscle, paths.joint, paths.moment_arm.swapaxes(0, 1).astype(float), strict=True))
    for i in range(n):
        for m in range(3):
            wanted = [torque[i, j] @ r[i] / (r[i] @ r[i]) for muscle, j, r in arms if muscle == m]
            assert len(wanted) == (2 if m == 0 else 1)
            assert force[i, m] == pytest.approx(average(wanted, negative), abs=1e-2)
    assert 0.2 < np.mean(force > 0.0) < 1.0


def test_ideal_muscles_have_the_force_that_they_should_have_even_beyond_f_max():
    stages = Stages(leg(muscle_model=MuscleModel(ideal=True)), 50, "cpu")
    quantities = stages.muscle_torques(vectors(100, 3, 60.0).reshape(50, 2, 3))[1]
    wanted = quantities["muscle_desired_force"]
    assert wanted.max() > 500.0
    np.testing.assert_array_equal(quantities["muscle_force"], wanted)
    np.testing.assert_allclose(quantities["muscle_activation"], np.minimum(wanted / 400.0, 1.0), rtol=1e-6)


def test_the_fibre_of_an_ideal_muscle_is_as_fast_as_its_length_changes():
    scene = leg(muscle_model=MuscleModel(ideal=True), duration=0.1)
    scene.initial_state.joints = {"knee": JointState(angular_velocity=(3.0, 0.0, 0.0))}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    frames = rollout.recording()
    speed = np.gradient(frames.muscle_fibre_length.astype(np.float64), scene.time_step, axis=0)[1:-1]
    assert np.ptp(speed) > 0.05
    np.testing.assert_allclose(frames.muscle_fibre_velocity[1:-1], speed, atol=0.02 * np.ptp(speed))


# Excitations of their own.


@wp.kernel(enable_backward=False)
def timed(muscles: Muscles, time: wp.array[float], excitation: wp.array2d[float]):
    i, m = wp.tid()
    excitation[i, m] = muscle_control.timed_excitation(muscles, muscles.timed[0, m], 0, time[i])


def test_own_excitation_is_straight_between_knots_constant_beyond_and_periodic():
    knots = [([0.2, 0.5, 0.9], [0.1, 0.8, 0.4], 0.0), ([0.3], [0.6], 0.0), ([0.1, 0.4], [0.0, 1.0], 0.5)]
    muscles = Muscles()
    for name, column in (("knot_time", 0), ("knot_value", 1)):
        values = np.concatenate([knot[column] for knot in knots])[None].astype(np.float32)
        setattr(muscles, name, wp.array(values, dtype=float, device="cpu"))
    columns = {"first_knot": [[0, 3, 4]], "end_knot": [[3, 4, 6]], "period": [[knot[2] for knot in knots]]}
    muscles.timed = structs_to_device(TimedExcitation, columns, "cpu")
    time = np.linspace(-0.301, 2.31, 1000)
    given, got = wp.array(time.astype(np.float32), dtype=float, device="cpu"), wp.zeros((1000, 3), device="cpu")
    wp.launch(timed, got.shape, [muscles, given], [got], device="cpu")
    for m, (at, value, period) in enumerate(knots):
        expected = np.interp(time % period if period else time, at, value)
        np.testing.assert_allclose(got.numpy()[:, m], expected, atol=1e-5)


# Delay and activation.

DELAYS = (0, 1, 9, 31)  # steps, by muscle


def activating() -> tuple[Muscles, MuscleState]:
    """Muscles of an instance with delays and different rates, and a ring that holds the longest delay."""
    muscles, state = Muscles(), MuscleState()
    count = len(DELAYS)
    rise, fall = np.linspace(0.005, 0.05, count), np.linspace(0.02, 0.08, count)
    numbers = {"rise_time": rise, "fall_time": fall, "delay_steps": np.array(DELAYS)}
    numbers |= {"rise_rest": np.exp(-TIME_STEP / rise), "fall_rest": np.exp(-TIME_STEP / fall)}
    muscles.row = structs_to_device(MuscleRow, {name: value[None] for name, value in numbers.items()}, "cpu")
    state.excitation_ring = wp.zeros((1, 32, count), dtype=float, device="cpu")
    state.activation = wp.full((1, count), 0.3, dtype=float, device="cpu")
    return muscles, state


@wp.kernel(enable_backward=False)
def heard(step: int, excitation: float, muscles: Muscles, state: MuscleState, result: wp.array[float]):
    m = wp.tid()
    delay_steps = muscles.row[0, m].delay_steps
    before = muscle_control.heard_before(0, m, step, delay_steps, state)
    result[m] = muscle_control.delayed(0, m, step, delay_steps, excitation, before, state)


def test_muscle_hears_an_excitation_its_delay_later_and_the_first_one_until_then():
    muscles, state = activating()
    excitation, got = np.random.default_rng(0).random(100).astype(np.float32), wp.zeros(len(DELAYS), device="cpu")
    for step, value in enumerate(excitation):
        wp.launch(heard, len(DELAYS), [step, float(value), muscles, state], [got], device="cpu")
        expected = [excitation[max(step - delay, 0)] for delay in DELAYS]
        np.testing.assert_array_equal(got.numpy(), np.array(expected, np.float32))


@wp.kernel(enable_backward=False)
def activations(steps: int, excitation: wp.array[float], muscles: Muscles, state: MuscleState):
    m = wp.tid()
    for _ in range(steps):
        state.activation[0, m] = muscle_control.activated(
            state.activation[0, m], excitation[m], wp.static(TIME_STEP), muscles.row[0, m], muscles.scaled_rates
        )


TOWARDS = np.array([0.9, 0.0, 0.31, 0.1])  # by muscle, from 0.3


def after(steps: int, scaled: bool) -> tuple[Muscles, np.ndarray]:
    """Activations after some steps of constant excitations."""
    muscles, state = activating()
    muscles.scaled_rates = int(scaled)
    given = wp.array(TOWARDS.astype(np.float32), dtype=float, device="cpu")
    wp.launch(activations, len(TOWARDS), [steps, given, muscles, state], device="cpu")
    return muscles, state.activation.numpy()[0]


@pytest.mark.parametrize("steps", [1, 7, 200])
def test_activation_with_linear_rates_is_the_exact_exponential(steps: int):
    muscles, got = after(steps, False)
    row = muscles.row.numpy()[0]
    rate = 1.0 / np.where(TOWARDS > 0.3, row["rise_time"], row["fall_time"])
    np.testing.assert_allclose(got, TOWARDS + (0.3 - TOWARDS) * np.exp(-rate * steps * TIME_STEP), atol=1e-6)


@pytest.mark.parametrize("steps", [1, 7, 200])
def test_activation_with_scaled_rates_relaxes_step_by_step_at_the_rate_it_has(steps: int):
    muscles, got = after(steps, True)
    expected = np.full(len(TOWARDS), 0.3)
    for _ in range(steps):
        times = (muscles.row.numpy()[0][name] for name in ("rise_time", "fall_time"))
        rate = evaluate(activation.activation_rate, expected, TOWARDS, *times)
        expected = TOWARDS + (expected - TOWARDS) * np.exp(-rate * TIME_STEP)
    np.testing.assert_allclose(got, expected, atol=2e-6)


def test_activation_stays_within_its_bounds():
    for scaled in (False, True):
        got = after(1000, scaled)[1]
        assert np.all((got >= 0.0) & (got <= 1.0))
