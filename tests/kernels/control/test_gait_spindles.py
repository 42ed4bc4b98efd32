"""Reflexes that sense spindles and activations: against NumPy, and with SCONE's names of their numbers."""

from pathlib import Path

import numpy as np

import small_scone
from warpmuscle.formats import load, save
from warpmuscle.formats.scone.parameters import Parameter, read_parameters, write_parameters
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.kernels.control import gait_sensors
from warpmuscle.simulation.rollout import Rollout

VALUES = {"calf.KS": 0.5, "calf-seat.KS": -0.25, "seat-calf.KA": -0.8}


def rate(length: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Of a spindle; scone-core, Muscle.cpp: max(0, 65 / 200 sign(v) sqrt(|v|) + l)."""
    return np.maximum(65.0 / 200.0 * np.sign(velocity) * np.sqrt(np.abs(velocity)) + length, 0.0)


def test_a_spindle_tells_length_and_the_root_of_speed():
    random = np.random.default_rng(3)
    length, velocity = random.uniform(0.3, 1.7, 200), random.normal(scale=6.0, size=200)
    velocity[:3] = 0.0
    expected = rate(length, velocity)
    assert (expected == 0.0).any()
    found = [gait_sensors.spindle_rate(*pair) for pair in zip(length.tolist(), velocity.tolist(), strict=True)]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_excitations_are_those_of_spindles_and_activations_a_delay_ago(tmp_path: Path):
    path = small_scone.write(tmp_path, controller=small_scone.SPINDLES)
    write_parameters(tmp_path / "best.par", [Parameter(name, value, value, 0.1) for name, value in VALUES.items()])
    scene = load(path, tmp_path / "best.par", ignored=[])
    assert loads(dumps(scene)) == scene
    save(scene, tmp_path / "out.par")
    found = {name: one.best for name, one in read_parameters(tmp_path / "out.par").items()}
    assert {name: value for name, value in found.items() if not name.endswith(".offset")} == VALUES
    rollout = Rollout(scene, record=[0], record_rate=1.0 / scene.time_step, device="cpu")
    rollout.run()
    motion = rollout.recording(0)
    frames = np.arange(1, len(motion.time) - 1, 5)  # when control is renewed, each 5 ms; muscles as in the frame before
    names = list(motion.muscle_names)

    def late(values: np.ndarray, steps: int) -> np.ndarray:
        return values[np.maximum(np.arange(len(values)) - steps, 0)]

    for s in "lr":
        calf, seat = names.index(f"calf_{s}"), names.index(f"seat_{s}")
        length, velocity = motion.muscle_fibre_length[frames - 1], motion.muscle_fibre_velocity[frames - 1]
        of_calf = rate(length[:, calf] / 0.06, velocity[:, calf] / 0.06)
        of_seat = rate(length[:, seat] / 0.12, velocity[:, seat] / 0.12)
        active = motion.muscle_activation[frames - 1, calf]
        calves = 0.2 + 0.5 * np.maximum(late(of_calf, 2) - 0.9, 0.0) + 0.05 - 0.25 * (of_seat - 0.4)
        seats = 0.5 - 0.8 * np.maximum(late(active, 1) - 0.25, 0.0) + 0.2 * (late(length[:, calf], 1) / 0.06 - 1.0)
        for muscle, told in ((calf, calves), (seat, seats)):
            got = motion.muscle_excitation[frames, muscle]
            np.testing.assert_allclose(got, np.clip(told, 0.01, 1.0), atol=5e-4)
            assert np.ptp(got) > 0.05
