"""States of gait and their reflexes: the rules one by one, single terms, and the excitations of a walk in NumPy."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from gait_state_rules import LIMITS, expected_state

import small_scone
from warpmuscle.core.arrays import structs_to_device
from warpmuscle.formats import load
from warpmuscle.kernels.control import gait_states
from warpmuscle.kernels.gait_state_structs import (
    EARLY_STANCE,
    LANDING,
    LATE_STANCE,
    LIFTOFF,
    SWING,
    UNKNOWN,
    GaitThresholds,
    StateReflexRow,
)
from warpmuscle.results.recording import Recording
from warpmuscle.scene.gait_states.part import STATES
from warpmuscle.simulation.rollout import Rollout


@wp.kernel(enable_backward=False)
def next_states(now: wp.array[int], numbers: wp.array[wp.vec4], limits: wp.array[GaitThresholds], found: wp.array[int]):
    i = wp.tid()
    n = numbers[i]
    found[i] = gait_states.next_state(now[i], n[0], n[1], n[2], n[3] > limits[0].stance_load, limits[0])


def test_a_leg_comes_from_state_to_state_by_its_load_and_its_place():
    places, loads = (-0.5, -0.1, 0.02, 0.1, 0.3), (0.0, 0.15, 0.6)
    every = list(itertools.product(range(UNKNOWN, LANDING + 1), places, places, loads, loads))
    limits = structs_to_device(GaitThresholds, {name: [value] for name, value in LIMITS.items()}, "cpu")
    now = wp.array([one[0] for one in every], dtype=int, device="cpu")
    numbers = wp.array(np.float32([one[1:] for one in every]), dtype=wp.vec4, device="cpu")
    found = wp.zeros(len(every), dtype=int, device="cpu")
    wp.launch(next_states, len(every), [now, numbers, limits, found], device="cpu")
    assert found.numpy().tolist() == [expected_state(*one) for one in every]
    assert set(found.numpy().tolist()) == {EARLY_STANCE, LATE_STANCE, LIFTOFF, SWING, LANDING}


@wp.kernel(enable_backward=False)
def terms(signal: wp.array[wp.vec3], row: wp.array[StateReflexRow], positive: int, found: wp.array2d[float]):
    i, k = wp.tid()
    s = signal[i]
    found[i, k] = gait_states.state_reflex_term(s[0], row[k], positive)
    if gait_states.silenced(s[1], s[2], row[k]):
        found[i, k] = 0.0


@pytest.mark.parametrize("positive", [0, 1, 2])
def test_a_term_is_its_gain_times_what_its_signal_exceeds_unless_a_joint_goes_on_beyond_its_interval(positive: int):
    random = np.random.default_rng(2)
    gain, offset = random.normal(size=(2, 6))
    low, high = np.full(6, -0.4), np.full(6, 0.3)
    row = structs_to_device(StateReflexRow, {"gain": gain, "offset": offset, "low": low, "high": high}, "cpu")
    signals = random.normal(size=(60, 3))
    given = wp.array(np.float32(signals), dtype=wp.vec3, device="cpu")
    found = wp.zeros((60, 6), device="cpu")
    wp.launch(terms, found.shape, [given, row, positive, found], device="cpu")
    excess = signals[:, :1] - offset
    # scone-core, DofReflex.cpp: KP (P0 - pos) is cut; MuscleReflex.h: gain * max(signal - offset, 0).
    wanted = (gain * excess, np.maximum(gain * excess, 0.0), gain * np.maximum(excess, 0.0))[positive]
    assert positive == 0 or (wanted[:, gain < 0.0] < 0.0).any() == (positive == 2)
    angle, rate = signals[:, 1:2], signals[:, 2:]
    silent = ((angle > 0.3) & (rate >= 0.0)) | ((angle < -0.4) & (rate < 0.0))
    np.testing.assert_allclose(found.numpy(), np.where(silent, 0.0, wanted), atol=1e-6)
    assert 0.1 < np.mean(silent) < 0.9


def test_excitations_of_a_motion_are_those_of_its_sensors_a_delay_ago_in_the_states_of_now(tmp_path: Path):
    scene = load(small_scone.write(tmp_path), ignored=[])
    rollout = Rollout(scene, record=[0], record_rate=1.0 / scene.time_step, device="cpu")
    rollout.run()
    motion = rollout.recording(0)
    frames = np.arange(1, len(motion.time) - 1, 5)  # when control is renewed, each 5 ms; fibres as in the frame before
    phases = states_of(motion, frames, 9.81 * (40.0 + 2.0 * 9.5))
    assert {"early_stance", "late_stance", "liftoff", "swing"} <= {
        STATES[state - 1] for both in phases for state in both
    }
    names, joints = list(motion.muscle_names), list(motion.coordinate_names)
    tilt, spin = -tilt_of(motion.root_orientation), -motion.root_angular_velocity[:, 0]
    for side, s in enumerate("lr"):
        calf, seat, foot = names.index(f"calf_{s}"), names.index(f"seat_{s}"), joints.index(f"foot_{s}")
        force = motion.muscle_force[frames - 1, calf] / 3000.0
        length = motion.muscle_fibre_length[frames - 1, calf] / 0.06
        velocity = motion.muscle_fibre_velocity[frames - 1, calf] / 0.06
        angle, rate = motion.coordinate[frames, foot], motion.speed[frames, list(motion.speed_names).index(f"foot_{s}")]
        told = np.zeros((2, len(frames)))
        for k, both in enumerate(phases):
            late, later, last = max(k - 4, 0), max(k - 2, 0), max(k - 1, 0)  # 20, 10 and 5 ms
            if STATES[both[side] - 1] in ("early_stance", "late_stance", "liftoff"):
                told[0, k] = 0.05 + 1.2 * force[late]
                told[1, k] = 1.9 * (-0.1 - tilt[frames][last]) - 0.4 * spin[frames][last]
            else:
                told[0, k] = 0.02 + (0.0 if angle[later] > -0.1 and rate[later] >= 0.0 else 0.7 * force[later])
                told[1, k] = 2.0 * (length[later] - 0.7) + max(0.1 * velocity[later], 0.0)
        got = motion.muscle_excitation[frames][:, [calf, seat]].T
        np.testing.assert_allclose(got, np.clip(told, 0.01, 1.0), atol=2e-4)
        assert np.ptp(got, axis=1).min() > 0.1


def tilt_of(orientation: np.ndarray) -> np.ndarray:
    """How far a body in the sagittal plane leans forwards, rad, from its quaternion."""
    return 2.0 * np.arctan2(orientation[:, 0], orientation[:, 3])


def states_of(motion: Recording, frames: np.ndarray, weight: float) -> list[list[int]]:
    """The states of both legs at frames, by the rules above with the thresholds of the scenario."""
    now, found = [UNKNOWN, UNKNOWN], []
    bodies = [list(motion.body_names).index(name) for name in ("trunk", "foot_l", "foot_r")]
    place = motion.body_position[:, bodies, 2]
    force = np.stack([motion.foot_force_left, motion.foot_force_right], axis=1)
    for frame in frames:
        ahead = place[frame, 1:] - place[frame, 0]
        load = np.linalg.norm(force[frame], axis=1) / weight
        limits = LIMITS | {"stance_load": 0.1, "swing_load": 0.1, "landing": 0.0, "liftoff": -math.hypot(0.05, 0.49)}
        now = [expected_state(now[s], ahead[s], ahead[1 - s], load[s], load[1 - s], limits) for s in range(2)]
        found.append(now)
    return found
