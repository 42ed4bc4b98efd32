"""Muscle reflexes against NumPy: single terms, and the excitations of a whole walk."""

import itertools

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled, turn_about, units, vectors
from reflex_oracle import excitations, term

from warpmuscle.core.arrays import structs_to_device
from warpmuscle.formats import load
from warpmuscle.kernels.control import reflex
from warpmuscle.kernels.reflex_structs import ALWAYS, CONSTANT, OTHER_LOAD, TRAILING, Reflexes, ReflexPlan, ReflexRow
from warpmuscle.kernels.structs import Model, MuscleState, SimbiconState, Skeleton, State
from warpmuscle.model.controllers.reflexes import DURING, MOVING, PART, TIMES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Reflex, Scene
from warpmuscle.simulation.rollout import Rollout


@wp.kernel(enable_backward=False)
def terms(
    plan: wp.array[ReflexPlan], row: wp.array[ReflexRow], signal: wp.array[wp.vec2], legs: wp.array2d[int],
    loads: wp.array[wp.vec2], result: wp.array2d[float],
):  # fmt: skip
    i, k = wp.tid()
    stance, trailing = legs[i, 0] == 1, legs[i, 1] == 1
    result[i, k] = reflex.reflex_term(plan[k], row[k], signal[i], stance, trailing, loads[i][0], loads[i][1])


def test_a_reflex_adds_the_wanted_part_of_its_signal_in_its_phase_times_its_load():
    random = np.random.default_rng(0)
    choices = list(itertools.product(PART, MOVING, DURING, TIMES))
    numbers = random.normal(size=(3, len(choices)))
    reflexes = [
        Reflex(gain, "length", offset=offset, lead=lead, part=part, moving=moving, during=during, times=times)
        for gain, offset, lead, (part, moving, during, times) in zip(*numbers, choices, strict=True)
    ]
    words = {"part": PART, "moving": MOVING, "during": DURING, "times": TIMES}
    columns = {name: [table[getattr(r, name)] for r in reflexes] for name, table in words.items()}
    plan = structs_to_device(ReflexPlan, columns, "cpu")
    row = structs_to_device(ReflexRow, dict(zip(("gain", "offset", "lead"), numbers, strict=True)), "cpu")
    states = [(0, 0), (1, 0), (1, 1)] * 10
    signal, loads = random.normal(size=(len(states), 2)), random.random((len(states), 2))
    given = [wp.array(values.astype(np.float32), dtype=wp.vec2, device="cpu") for values in (signal, loads)]
    legs = wp.array(np.array(states, np.int32), dtype=int, device="cpu")
    result = wp.zeros((len(states), len(reflexes)), device="cpu")
    wp.launch(terms, result.shape, [plan, row, given[0], legs, given[1], result], device="cpu")
    for i, (stance, trailing) in enumerate(states):
        phases = {"always", "stance" if stance else "swing"} | ({"trailing"} if trailing else set())
        factors = {"once": 1.0, "load": loads[i, 0], "other_load": loads[i, 1]}
        expected = [term(r, signal[i, 0], signal[i, 1], phases, factors) for r in reflexes]
        np.testing.assert_allclose(result.numpy()[i], expected, atol=1e-6)
    assert np.mean(result.numpy() != 0.0) > 0.2


@wp.kernel(enable_backward=False)
def feel(model: Model, state: State, lean: float):
    reflex.feel_ground(wp.tid(), wp.vec2(lean, 0.0), model, state)


def felt(
    loads: list[tuple[float, float]], before: list[tuple[int, int]], landed: list[int], stance: list[int]
) -> State:
    """The state after loads, body weights, from which legs stood before and which one landed last; a lean of 0.3."""
    bounds = filled(Reflexes, bounds=np.array([[[0.1, 0.0]]], np.float32))
    skeleton = filled(Skeleton, total_mass=np.array([[50.0]], np.float32))
    model = filled(Model, reflexes=bounds, skeleton=skeleton, gravity=np.array([[10.0]], np.float32))
    muscles = filled(
        MuscleState, stands=np.int32(before), landed=np.int32(landed), lean_at_lift=np.full((len(loads), 2), -1.0)
    )
    force = np.zeros((len(loads), 2, 3), np.float32)
    force[:, :, 1], force[:, :, 0] = 500.0 * np.array(loads), 400.0
    state = filled(State, simbicon=filled(SimbiconState, stance=np.int32(stance)), foot_force=force, muscles=muscles)
    wp.launch(feel, len(loads), [model, state, 0.3], device="cpu")
    return state


def test_a_leg_lands_that_did_not_stand_and_leaves_the_ground_with_the_lean_of_that_moment():
    cases = [  # loads of left and right, which stood, which landed last, stance leg; which stand, which landed last
        ((0.5, 0.0), (0, 0), 1, 0, [1, 0], 0),
        ((0.0, 0.5), (0, 0), 0, 0, [0, 1], 1),
        ((0.5, 0.4), (1, 0), 0, 0, [1, 1], 1),
        ((0.5, 0.4), (1, 1), 1, 0, [1, 1], 1),
        ((0.5, 0.4), (1, 1), 0, 0, [1, 1], 0),
        ((0.05, 0.4), (1, 1), 1, 0, [0, 1], 1),
        ((0.5, 0.05), (1, 1), 1, 0, [1, 0], 1),
        ((0.0, 0.0), (1, 1), 0, 1, [0, 0], 0),
        ((0.5, 0.5), (0, 0), 1, 0, [1, 1], 0),  # both at once: the stance leg leads
        ((0.5, 0.5), (0, 0), 0, 1, [1, 1], 1),
        ((-0.5, -0.5), (0, 0), 1, 0, [0, 0], 1),
    ]
    loads, before, landed, stance, stands, last = (list(column) for column in zip(*cases, strict=True))
    muscles = felt(loads, before, landed, stance).muscles
    np.testing.assert_array_equal(muscles.stands.numpy(), stands)
    np.testing.assert_array_equal(muscles.landed.numpy(), last)
    lifted = (np.array(before) == 1) & (np.array(stands) == 0)
    np.testing.assert_allclose(muscles.lean_at_lift.numpy(), np.where(lifted, 0.3, -1.0), atol=1e-6)
    assert lifted.sum() == 4


@wp.kernel(enable_backward=False)
def excite(model: Model, state: State, result: wp.array2d[float]):
    i, m = wp.tid()
    result[i, m] = reflex.reflex_excitation(i, m, wp.vec2(0.0), model, state)


@pytest.mark.parametrize("rows", [1, 3])
def test_a_muscle_whose_reflexes_say_nothing_has_the_least_excitation_of_its_own_instance(rows: int):
    """Or that of all, where these have one row; what lies behind it in memory is another's."""
    least = np.array([0.02, 0.07, 0.3])
    bounds = wp.array(np.float32([[[0.1, one]] for one in least]), dtype=wp.vec2, device="cpu")[:rows]
    reflexes = filled(Reflexes, bounds=bounds, span={"first": [0], "end": [0], "side": [1]})
    skeleton = filled(Skeleton, total_mass=np.array([[50.0]], np.float32))
    model = filled(Model, reflexes=reflexes, skeleton=skeleton, gravity=np.array([[10.0]], np.float32))
    muscles = filled(MuscleState, stands=np.zeros((3, 2), np.int32), landed=np.zeros(3, np.int32))
    state = filled(State, foot_force=np.zeros((3, 2, 3), np.float32), muscles=muscles)
    result = wp.zeros((3, 1), dtype=float, device="cpu")
    wp.launch(excite, (3, 1), [model, state, result], device="cpu")
    np.testing.assert_allclose(result.numpy()[:, 0], least if rows == 3 else least[0], rtol=1e-6)


def test_a_leg_trails_that_stands_with_the_other_one_that_landed_after_it():
    """Of muscles of both legs; instances next to each other differ, and so does what stands before them in memory."""
    stands = np.array([(1, 1), (1, 0), (1, 1), (0, 1), (1, 1), (0, 0), (1, 1), (1, 0)], np.int32)
    landed = np.array([1, 1, 0, 0, 1, 1, 0, 0], np.int32)
    reflexes = filled(
        Reflexes, span={"first": [0, 0], "end": [1, 1], "side": [0, 1]}, bounds=np.array([[[0.1, 0.0]]], np.float32),
        plan={"signal": [CONSTANT], "during": [TRAILING]}, row={"gain": [[0.5]]},
    )  # fmt: skip
    skeleton = filled(Skeleton, total_mass=np.array([[50.0]], np.float32))
    model = filled(Model, reflexes=reflexes, skeleton=skeleton, gravity=np.array([[10.0]], np.float32))
    muscles = filled(MuscleState, stands=stands, landed=landed)
    count = len(stands)
    state = filled(
        State, foot_force=np.zeros((count, 2, 3), np.float32), muscles=muscles, step=np.ones(count, np.int32)
    )
    result = wp.zeros((count, 2), dtype=float, device="cpu")
    wp.launch(excite, result.shape, [model, state, result], device="cpu")
    trails = stands.all(axis=1)[:, None] & (landed[:, None] != [0, 1])
    np.testing.assert_allclose(result.numpy(), 0.5 * trails)


def test_a_reflex_feels_the_load_of_the_leg_of_its_muscle_and_that_of_the_other_one():
    """Muscles of the left and the right leg, of three instances in a row."""
    loads = np.array([[0.2, 0.7], [0.1, 0.4], [0.6, 0.3]])
    reflexes = filled(
        Reflexes, span={"first": [0, 1], "end": [1, 2], "side": [0, 1]}, bounds=np.array([[[0.1, 0.0]]], np.float32),
        plan={"signal": [OTHER_LOAD] * 2, "during": [ALWAYS] * 2}, row={"gain": [[0.5] * 2]},
    )  # fmt: skip
    skeleton = filled(Skeleton, total_mass=np.array([[50.0]], np.float32))
    model = filled(Model, reflexes=reflexes, skeleton=skeleton, gravity=np.array([[10.0]], np.float32))
    force = np.zeros((3, 2, 3), np.float32)
    force[:, :, 1] = 500.0 * loads
    muscles = filled(MuscleState, stands=np.zeros((3, 2), np.int32), landed=np.zeros(3, np.int32))
    state = filled(State, foot_force=force, muscles=muscles, step=np.ones(3, np.int32))
    result = wp.zeros((3, 2), dtype=float, device="cpu")
    wp.launch(excite, result.shape, [model, state, result], device="cpu")
    np.testing.assert_allclose(result.numpy(), 0.5 * loads[:, ::-1], rtol=1e-5)


def test_lean_is_positive_forward_whatever_the_heading():
    lean, rate, yaw = np.linspace(-1.0, 1.0, 50), vectors(50)[:, 0], np.linspace(-3.0, 3.0, 50)
    heading = turn_about(np.array([0.0, 1.0, 0.0]), yaw)
    forward = np.stack([np.sin(yaw), np.zeros(50), np.cos(yaw)], axis=1)
    up = np.cos(lean)[:, None] * np.array([0.0, 1.0, 0.0]) + np.sin(lean)[:, None] * forward
    left = np.stack([np.cos(yaw), np.zeros(50), -np.sin(yaw)], axis=1)
    spin = rate[:, None] * left + 0.3 * units(50)[:, :1] * forward
    got = evaluate(reflex.forward_lean, up, spin, heading)
    np.testing.assert_allclose(got, np.stack([lean, rate], axis=1), atol=2e-6)


@pytest.fixture(scope="module")
def walk() -> tuple[Scene, Recording, float]:
    """A second and a half of a walk by reflexes with a frame a step, and the body's weight, N."""
    scene = load("reflex_walk")
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step, threads=1)
    rollout.run(1.5)
    mass = sum(body.mass for body in rollout.numeric.character.bodies.values())
    return rollout.numeric, rollout.recording(), float(mass * rollout.numeric.gravity)


def test_excitations_of_a_walk_are_those_of_its_reflexes(walk: tuple[Scene, Recording, float]):
    scene, motion, weight = walk
    expected = excitations(scene, motion, weight)
    f_max = np.array([scene.character.muscles[name].f_max for name in motion.muscle_names])
    assert len(motion.muscle_names) == 14
    assert not np.isnan(expected).any()
    difference = np.abs(motion.muscle_desired_force / f_max - expected)
    assert np.median(difference) < 1e-6
    assert np.percentile(difference, 99.9) < 1e-4
    assert np.ptp(expected, axis=0).min() > 0.05


def test_muscles_hear_their_reflexes_after_their_delays(walk: tuple[Scene, Recording, float]):
    scene, motion, _ = walk
    for m, name in enumerate(motion.muscle_names):
        muscle = scene.character.muscles[name]
        late = round(muscle.delay / scene.time_step)
        said = motion.muscle_desired_force[:, m] / muscle.f_max
        np.testing.assert_allclose(motion.muscle_excitation[late:, m], said[: len(said) - late], atol=1e-6)
        np.testing.assert_allclose(motion.muscle_excitation[:late, m], said[0], atol=1e-6)
