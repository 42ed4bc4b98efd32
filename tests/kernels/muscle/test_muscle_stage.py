"""Muscles in the fused step: energy, bounds, delays, excitations of their own, and independence of what is around."""

import dataclasses
from functools import partial

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from biped import rotate
from muscle_arm import INERTIA, MASS, arm, constant, leg
from warpmuscle.formats import load
from warpmuscle.kernels import stages as single_stages
from warpmuscle.kernels.curve.curves import LEE
from warpmuscle.kernels.muscle import muscle, muscle_stage
from warpmuscle.results.recorded_quantities import MUSCLE_QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Actuation, Excitation, JointState, Muscle, MuscleModel, PolynomialPath, Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

TENDONS = ["rigid", "switch", "compliant"]
RATE = 2000.0  # steps a second
ASSISTED = Actuation("assisted")


def recorded(scene: Scene, duration: float = 0.0) -> Recording:
    """Every step of a simulation; torques, too, may drive its joints, and are zero without a controller."""
    scene.duration, scene.actuation = duration or scene.duration, dict.fromkeys(scene.character.joints, ASSISTED)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=RATE)
    rollout.run()
    return rollout.recording()


# One step at a time.


def test_reflexes_feel_the_ground_before_muscles_hear_of_it():
    """A leg stands that bears the body's weight, of another instance neither."""
    stages = Stages(load("reflex_walk"), 2, "cpu")
    force = np.zeros((2, 2, 3), np.float32)
    force[1, :, 1] = 700.0, 0.0
    stages.state.foot_force.assign(force)
    stages.state.muscles.stands.zero_()
    stages.muscle_torques(np.zeros((2, len(stages.names.joints), 3)))
    np.testing.assert_array_equal(stages.state.muscles.stands.numpy(), [[0, 0], [1, 0]])


def test_the_neural_signal_and_the_activation_follow_the_excitation_one_after_the_other():
    """e' = (u - e)/tau_ne, a' = (e - a)/tau (Cruz Ruiz 2015, eq. 11), in steps of a thousandth; first is as given."""
    model = MuscleModel(activation="neural", neural_time=0.004, rise_time=0.015, initial_activation=0.1)
    scene = arm(flexor={"excitation": constant(0.7)}, muscle_model=model)
    stages = Stages(scene, 1, "cpu")
    muscles, still = stages.state.muscles, np.zeros((1, 1, 3))
    stages.muscle_torques(still)
    e, a = (float(array.numpy()[0, 0]) for array in (muscles.neural, muscles.activation))
    for _ in range(12):
        stages.muscle_torques(still)
        for _ in range(1000):
            e, a = e + (0.7 - e) / (0.004 * RATE * 1000.0), a + (e - a) / (0.015 * RATE * 1000.0)
        assert muscles.neural.numpy()[0, 0] == pytest.approx(e, abs=1e-3)
        assert muscles.activation.numpy()[0, 0] == pytest.approx(a, abs=1e-3)
    assert 0.5 < e < 0.69
    assert a < e - 0.1


def test_muscles_that_share_a_torque_make_as_much_as_is_wanted_of_them_and_no_more():
    """The one on the other side rests; what is recorded as wanted of it is its part of the strongest force."""
    stages = Stages(arm(muscle_model=MuscleModel(sharing="least_effort")), 3, "cpu")
    wanted = np.zeros((3, 1, 3))
    wanted[:, 0, 0] = [1.0, -2.0, 0.0]
    for _ in range(300):
        torque, found = stages.muscle_torques(wanted)
    np.testing.assert_allclose(torque[:, 0, 0], [1.0, -2.0, 0.0], atol=0.05)
    desired = found["muscle_desired_force"]
    pulling = desired.argmax(axis=1)
    assert pulling[0] != pulling[1]
    for instance in (0, 1):
        assert 0.02 * 400.0 < desired[instance, pulling[instance]] < 0.6 * 400.0
        assert desired[instance, 1 - pulling[instance]] < 0.01 * 400.0
    assert desired[2].max() < 0.01 * 400.0
    np.testing.assert_allclose(found["muscle_excitation"], desired / 400.0, atol=1e-6)


def test_a_muscle_whose_path_is_a_polynomial_pulls_as_well():
    """Its path is 0.25 + 0.03 q long, so that it turns the elbow by 0.03 m times its force."""
    scene = arm(flexor={"excitation": constant(0.5)})
    path = PolynomialPath(["elbow"], [[0], [1]], [0.25, 0.03])
    one = Muscle(polynomial=path, f_max=400.0, l_opt=0.15, l_slack=0.1, excitation=constant(0.5))
    scene.character.muscles = {"fitted": one}
    stages = Stages(scene, 2, "cpu")
    for _ in range(20):
        torque, found = stages.muscle_torques(np.zeros((2, 1, 3)))
    assert found["muscle_force"].min() > 50.0
    np.testing.assert_allclose(torque[:, 0], found["muscle_force"] * [0.03, 0.0, 0.0], rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(found["muscle_path_length"], 0.25, atol=1e-6)


@wp.func_native(snippet="static int turn = 0; if (anew) { turn = 0; return 0; } return turn++;")
def counted_turn(anew: int) -> int: ...


def test_muscles_that_are_taken_from_a_queue_do_what_they_do_in_turn(monkeypatch: pytest.MonkeyPatch):
    """As where warps of a GPU share the muscles of an instance, here with a counter of the CPU in place of theirs."""

    def pulled_by(count: int) -> tuple[np.ndarray, np.ndarray]:
        scene = arm()
        scene.character.muscles = {
            f"fitted{k}": Muscle(
                polynomial=PolynomialPath(["elbow"], [[0], [1]], [0.25, 0.03 - 0.02 * k]), f_max=400.0, l_opt=0.15,
                l_slack=0.1, excitation=constant(0.3 + 0.2 * k),
            )
            for k in range(count)
        }  # fmt: skip
        stages = Stages(scene, 2, "cpu")
        for _ in range(5):
            torque, found = stages.muscle_torques(np.zeros((2, 1, 3)))
        return torque, found["muscle_force"]

    in_turn = pulled_by(3)
    monkeypatch.setattr(muscle_stage, "next_turn", counted_turn)
    queued = partial(muscle_stage.muscle_stage_of.__wrapped__, lanes_in_warp=1)
    monkeypatch.setattr(single_stages, "muscle_stage_of", queued)
    monkeypatch.setattr(single_stages, "muscle_torques", single_stages.muscle_torques.__wrapped__)
    for got, expected in zip(pulled_by(3), in_turn, strict=True):
        np.testing.assert_array_equal(got, expected)
    assert in_turn[1].min() > 1.0


# The law of force.


@pytest.mark.parametrize("tendon", TENDONS)
def test_recorded_quantities_obey_the_law_of_force(tendon: str):
    scene = pulled(tendon, pennation=0.4)
    motion = recorded(scene, 0.5)
    path, fibre = motion.muscle_path_length[:, 0], motion.muscle_fibre_length[:, 0]
    width = np.full_like(path, 0.15 * np.sin(0.4))
    if tendon == "compliant":
        expected = evaluate(muscle.compliant_force, LEE, path, fibre, 0.1, width)
    else:
        speed, activation = motion.muscle_fibre_velocity[:, 0] / (10.0 * 0.15), motion.muscle_activation[:, 0]
        along = np.sqrt(np.maximum(fibre**2 - width**2, 0.0)) / fibre
        expected = along * evaluate(muscle.fibre_force, LEE, activation, fibre / 0.15, speed, 0.1)
    np.testing.assert_allclose(motion.muscle_force[:, 0], 600.0 * expected, atol=0.1)
    assert np.ptp(motion.muscle_force) > 50.0


@pytest.mark.parametrize("tendon", TENDONS)
def test_recorded_speed_of_the_fibre_is_the_rate_of_its_length_over_the_last_step(tendon: str):
    motion = recorded(pulled(tendon, pennation=0.6), 0.5)
    length = motion.muscle_fibre_length[:, 0]
    rate, free = RATE * np.diff(length), length[1:] > 1.1 * length.min()  # not where it may not become shorter
    assert np.ptp(rate[free]) > 0.2
    error = np.abs(motion.muscle_fibre_velocity[1:, 0] - rate)[free]
    assert np.mean(error < 0.01 * np.ptp(rate)) > 0.99  # but where a tendon switches


def test_speed_of_a_path_between_moving_bodies_is_that_of_the_middle_of_the_last_step():
    """As the leg starts to move; the speed at the end of the step would be wrong by half of what the step adds."""
    scene = leg(duration=0.01)
    for own, excitation in zip(scene.character.muscles.values(), (0.3, 0.9, 0.0), strict=True):
        own.l_slack, own.excitation = 0.0, constant(excitation)
    motion = recorded(scene)
    error = motion.muscle_fibre_velocity[1:] - RATE * np.diff(motion.muscle_path_length, axis=0)
    assert np.ptp(motion.muscle_fibre_velocity, axis=0).max() > 0.1
    assert np.abs(error).max() < 6e-4


def test_fibre_and_compliant_tendon_are_in_equilibrium_at_the_end_of_each_step():
    """With the speed of the backward differentiation formula of second order."""
    motion = recorded(pulled("compliant", pennation=0.4), 0.5)
    fibre, width = motion.muscle_fibre_length[:, 0], 0.15 * np.sin(0.4)
    speed = RATE * (3.0 * fibre[2:] - 4.0 * fibre[1:-1] + fibre[:-2]) / 2.0
    activation, x = motion.muscle_activation[2:, 0], fibre[2:] / 0.15
    force = evaluate(muscle.fibre_force, LEE, activation, x, speed / (10.0 * 0.15), 0.1)
    expected = 600.0 * force * np.sqrt(1.0 - (width / fibre[2:]) ** 2)
    assert np.ptp(speed) > 0.2
    np.testing.assert_allclose(motion.muscle_force[2:, 0], expected, atol=0.02 * 600.0)


# Energy.


def pulled(tendon: str, **flexor) -> Scene:
    """An arm on one muscle, whose excitation goes up and down; its path is from 0.2 to 0.34 m long."""
    beat = Excitation([0.0, 0.1, 0.3, 0.4], [0.05, 0.6, 0.3, 0.05], period=0.5)
    scene = arm(flexor={"excitation": beat, "f_max": 600.0, **flexor}, muscle_model=MuscleModel(tendon=tendon))
    del scene.character.muscles["extensor"]
    scene.initial_state.joints = {"elbow": JointState((np.sin(0.2), 0.0, 0.0, np.cos(0.2)))}
    return scene


@pytest.mark.parametrize(("tendon", "tolerance"), [("rigid", 2e-4), ("switch", 0.01), ("compliant", 2e-4)])
@pytest.mark.parametrize("pennation", [0.0, 0.4])
def test_energy_changes_by_the_work_of_the_muscle(tendon: str, tolerance: float, pennation: float):
    """The force of a tendon switch jumps, so that its work is not known better than to a part of a step."""
    motion = recorded(pulled(tendon, pennation=pennation), 1.0)
    spin = rotate(motion.body_orientation[:, 0], motion.joint_angular_velocity[:, 0])
    velocity = np.cross(spin, motion.body_position[:, 1] - motion.body_position[:, 0])
    about_x = motion.joint_angular_velocity[:, 0, 0]
    energy = 0.5 * MASS * np.sum(velocity**2, axis=1) + 0.5 * INERTIA[0] * about_x**2
    energy += MASS * 9.8 * motion.body_position[:, 1, 1]
    force, length = motion.muscle_force[:, 0], motion.muscle_path_length[:, 0]
    work = -np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(length))
    assert np.ptp(energy) > 1.0
    assert np.ptp(length) > 0.02
    np.testing.assert_allclose(energy[1:] - energy[0], work, atol=tolerance * np.ptp(energy))


@pytest.mark.parametrize("tendon", TENDONS)
def test_muscle_without_excitation_does_not_drive_an_arm(tendon: str):
    """From where its path is short: passive fibre and damping take energy, and the arm never rises above its start."""
    scene = pulled(tendon, excitation=constant(0.0))
    scene.initial_state.joints = {"elbow": JointState((-np.sin(0.5), 0.0, 0.0, np.cos(0.5)))}
    scene.muscle_model.initial_activation = 0.0
    height = recorded(scene, 3.0).body_position[:, 1, 1]
    assert height.max() <= height[0] + 1e-4
    assert height[4000:].max() < height[0] - 0.002


# Bounds.


@pytest.mark.parametrize("tendon", TENDONS)
@pytest.mark.parametrize("slack", [0.02, 0.1, 0.29])
def test_force_and_fibre_length_stay_within_bounds_however_the_arm_is_thrown_about(tendon: str, slack: float):
    """With a compliant tendon, as long as the path lengthens no faster than a fibre can."""
    scene = arm("ball", {"excitation": constant(1.0), "l_slack": slack}, muscle_model=MuscleModel(tendon=tendon))
    throw = np.array([25.0, 10.0, -30.0]) * (0.3 if tendon == "compliant" else 1.0)
    scene.initial_state.joints = {"elbow": JointState(angular_velocity=tuple(throw))}
    motion = recorded(scene, 1.0)
    assert motion.frames == 2000
    assert motion.muscle_force.min() >= 0.0
    assert motion.muscle_force.max() <= (1.8 + 1.5 + scene.muscle_model.damping) * 400.0
    assert motion.muscle_fibre_length.min() >= 0.05 * 0.15 * (1.0 - 1e-6)
    assert all(np.isfinite(motion[name]).all() for name in MUSCLE_QUANTITIES)


# Excitations of their own.


def test_own_excitation_reaches_the_muscle_its_delay_later_and_activates_it():
    curve, delay = Excitation([0.1, 0.2, 0.4], [0.0, 0.7, 0.2]), 0.03
    motion = recorded(arm(flexor={"excitation": curve, "delay": delay}), 0.6)
    heard = np.interp(motion.time - delay, curve.time, curve.value)
    np.testing.assert_allclose(motion.muscle_excitation[:, 0], heard, atol=1e-5)
    wanted = 400.0 * np.interp(motion.time, curve.time, curve.value)
    np.testing.assert_allclose(motion.muscle_desired_force[:, 0], wanted, atol=0.01)
    lagged = [1e-4]
    for excitation in heard:
        lagged.append(excitation + (lagged[-1] - excitation) * np.exp(-1.0 / (0.01 * RATE)))
    np.testing.assert_allclose(motion.muscle_activation[:, 0], lagged[1:], atol=1e-5)
    assert np.all(motion.muscle_excitation[:, 1] == 0.0)


@pytest.mark.parametrize("tendon", TENDONS)
@pytest.mark.parametrize(("name", "sign"), [("flexor", -1.0), ("extensor", 1.0)])
def test_excited_muscle_turns_the_arm_to_its_own_side(tendon: str, name: str, sign: float):
    """Forwards is a negative turn about x, which points to the left."""
    scene = arm(muscle_model=MuscleModel(tendon=tendon))
    scene.character.muscles[name].excitation = constant(0.5)
    orientation = recorded(scene, 0.3).joint_orientation[-1, 0]
    assert sign * orientation[0] > 0.05


# Instances.


def test_forces_are_in_proportion_to_the_f_max_of_each_instance():
    scene = arm(flexor={"excitation": constant(0.5), "f_max": Free(400.0, 100.0, 900.0)})
    rollout, f_max = Rollout(scene, 3, "cpu"), np.array([150.0, 400.0, 850.0])
    rollout.set_parameters(f_max[:, None])
    rollout.run(1.0 / RATE)
    force = rollout.state.muscles.force.numpy()
    np.testing.assert_allclose(force[:, 0] / f_max, force[0, 0] / f_max[0], rtol=1e-6)
    assert force[0, 0] > 5.0
    assert np.all(force[:, 1] == force[0, 1])


def test_each_instance_has_its_own_delay():
    """The longest that a search may ask for has room in the delay line."""
    steps = np.array([0, 7, 80, 200])
    curve = Excitation([0.0, 1.0], [0.0, 1.0])
    scene = arm(flexor={"excitation": curve, "delay": Free(0.01, 0.0, 0.1)}, duration=0.2)
    rollout = Rollout(scene, 4, "cpu", record=range(4), record_rate=RATE)
    rollout.set_parameters(steps[:, None] / RATE)
    rollout.run()
    for i, delay in enumerate(steps):
        recording = rollout.recording(i)
        expected = np.maximum(recording.time - delay / RATE, 0.0)
        np.testing.assert_allclose(recording.muscle_excitation[:, 0], expected, atol=1e-5)


def free_leg(tendon: str) -> Scene:
    """A leg with free muscle properties, an undriven knee axis, and passive damping."""
    scene = leg(muscle_model=MuscleModel(tendon=tendon), duration=0.3)
    scene.actuation = {"hip": Actuation(["muscle", "muscle", "passive"], 30.0, 1.0)}
    beat = Excitation([0.0, 0.1], [0.1, 0.9], period=0.15)
    for i, own in enumerate(scene.character.muscles.values()):
        own.f_max, own.delay, own.excitation = Free(400.0, 100.0, 900.0), 0.005 * i, beat
    scene.character.muscles["both"].l_slack = Free(0.1, 0.01, 0.2)
    return scene


CANDIDATE = np.array([500.0, 0.12, 300.0, 450.0])


def simulated(tendon: str, count: int = 1, slot: int = 0, durations: tuple[float, ...] = (0.3,), **options) -> Rollout:
    rollout = Rollout(free_leg(tendon), count, "cpu", record=[slot], record_rate=500, **options)
    values = np.random.default_rng(count).uniform([100.0, 0.05, 100.0, 100.0], [900.0, 0.2, 900.0, 900.0], (count, 4))
    values[slot] = CANDIDATE
    rollout.set_parameters(values)
    for duration in durations:
        rollout.run(duration)
    return rollout


@pytest.mark.parametrize("tendon", TENDONS)
@pytest.mark.parametrize(
    "around",
    [
        {"count": 5, "slot": 2, "threads": 1},
        {"count": 5, "slot": 2, "threads": 2},
        {"count": 40, "slot": 39, "threads": 2},
        {"durations": (0.1,) * 3},
    ],
    ids=str,
)
def test_a_candidate_with_muscles_gives_the_same_bits_whatever_is_around_it(tendon: str, around: dict):
    alone, among = simulated(tendon, threads=1).recording(), simulated(tendon, **around)
    got = among.recording(around.get("slot", 0))
    assert np.ptp(got.muscle_force) > 20.0
    for field in dataclasses.fields(Recording):
        np.testing.assert_array_equal(getattr(got, field.name), getattr(alone, field.name))


@pytest.mark.parametrize("tendon", ["rigid", "compliant"])
def test_simulating_again_after_a_reset_gives_the_same_bits(tendon: str):
    rollout = simulated(tendon)
    first = rollout.recording()
    rollout.reset()
    rollout.run()
    for name in MUSCLE_QUANTITIES:
        np.testing.assert_array_equal(rollout.recording()[name], first[name])
