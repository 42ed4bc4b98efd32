"""Low-passed ground forces: Butterworth's filter against its formula, and rows that no rate of frames changes."""

import numpy as np
import pytest

from small_result import march, walk_scene, with_arrays
from warpmuscle.core.array_types import Floats
from warpmuscle.gait.body_motion import centre_of_mass
from warpmuscle.gait.cycles import PERCENT, body_weight, over_strides
from warpmuscle.gait.ground_force import (
    FORE_AFT,
    VERTICAL,
    forward_forces,
    horizontal_forces,
    low_passed,
    vertical_forces,
)
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute

RATES = (1000, 250, 100)
STRIDES = [(0.4 + 1.0637 * k, 0.4 + 1.0637 * (k + 1)) for k in range(14)]  # s, in step with none of these rates
LANDING, SPIKE = 0.008, 0.35  # s; body weights, of the spike of a heel


def forces(time: Floats) -> Floats:
    """Upward and forward force (F, 2), body weights: braking to 0.15, driving to 0.2, and a spike at each landing."""
    phase = np.mod(time - STRIDES[0][0], 1.0637) / 1.0637
    stance = phase < 0.6
    up = np.where(stance, np.abs(np.sin(np.pi * phase / 0.6)) ** 0.7, 0.0)
    along = np.where(phase < 0.3, -0.15 * np.sin(np.pi * phase / 0.3), 0.2 * np.sin(np.pi * (phase - 0.3) / 0.3))
    spike = np.where(phase * 1.0637 < LANDING, np.sin(np.pi * phase * 1.0637 / LANDING), 0.0)
    return np.stack([up + SPIKE * spike, np.where(stance, along, 0.0) - SPIKE * spike], axis=1)


@pytest.mark.parametrize("cutoff", [FORE_AFT, VERTICAL])
@pytest.mark.parametrize("hertz", [3.0, 15.0, 20.0, 40.0])
def test_a_wave_is_weakened_as_by_two_passes_of_butterworths_filter(cutoff: float, hertz: float):
    """1 / (1 + (f / cutoff)^4) of it is left, at the same time."""
    rate = 400.0
    time = np.arange(1600) / rate
    wave = np.cos(2.0 * np.pi * hertz * time)
    left = low_passed(time, np.stack([wave, 2.0 * wave], axis=1), cutoff)[400:-400]
    gain = 1.0 / (1.0 + (hertz / cutoff) ** 4)
    np.testing.assert_allclose(left, gain * np.stack([wave, 2.0 * wave], axis=1)[400:-400], atol=1e-6)


def test_it_agrees_with_scipys_filter_forwards_and_backwards():
    """From end to end, at a rate at which that filter's warped frequencies are nearly true."""
    signal = pytest.importorskip("scipy.signal")
    time = np.arange(8000) / 4000.0
    force = forces(time)
    theirs = signal.sosfiltfilt(signal.butter(2, FORE_AFT, fs=4000.0, output="sos"), force, axis=0, padlen=1000)
    np.testing.assert_allclose(low_passed(time, force, FORE_AFT), theirs, atol=1e-4)


def test_a_push_keeps_its_impulse_and_a_steady_force_its_size():
    time = np.arange(1000) / 500.0
    push = np.where((time > 0.9) & (time < 0.91), 100.0, 0.0)
    assert low_passed(time, push, FORE_AFT).sum() == pytest.approx(push.sum(), rel=1e-6)
    np.testing.assert_allclose(low_passed(time, np.full(1000, 7.0), VERTICAL), 7.0)


def test_frames_that_are_too_few_or_too_rare_stay_as_they_are():
    assert low_passed(np.zeros(0), np.zeros((0, 2)), FORE_AFT).shape == (0, 2)
    for time in (np.arange(3) / 500.0, np.arange(50) / 40.0, np.zeros(9)):
        values = np.sin(40.0 * np.arange(len(time)))
        np.testing.assert_array_equal(low_passed(time, values, FORE_AFT), values)


def test_uneven_frames_are_filtered_at_the_rate_of_most():
    time = np.delete(np.arange(1000) / 500.0, [300, 301, 777])
    wave = np.cos(2.0 * np.pi * 2.0 * time)
    np.testing.assert_allclose(low_passed(time, wave, FORE_AFT)[50:-50], wave[50:-50], atol=1e-3)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on 56 muscles."""
    return substitute(walk_scene(), start_values(walk_scene()))


@pytest.fixture(scope="module")
def motion(scene: Scene) -> Recording:
    """A march with these forces on both feet, 1000 frames a second."""
    frames = 1000 * 16 + 1
    marched = march(scene.character, 1.2, 16.0, frames, 0)
    upward, forward = body_weight(scene) * forces(np.arange(frames) / 1000.0).T
    both = np.stack([np.zeros(frames), upward, forward], axis=1)
    return with_arrays(marched, foot_force_left=both, foot_force_right=both)


def test_extremes_of_the_fore_aft_force_do_not_depend_on_the_rate_of_frames(scene: Scene, motion: Recording):
    cycles = {"left": STRIDES, "right": STRIDES}
    found, spikes = [], []
    for rate in RATES:
        seen = motion.at(slice(None, None, 1000 // rate))
        found.append(centre_of_mass(seen, scene, cycles))
        single = over_strides(seen.time, seen.foot_force_left[:, 2], STRIDES) / body_weight(scene)
        spikes.append(-float(single.min(axis=1).mean()))
    braking, driving = (
        np.array([one[f"maximum {what} force"] for one in found], dtype=float) for what in ("braking", "driving")
    )
    np.testing.assert_allclose(braking, braking[0], rtol=0.02)
    np.testing.assert_allclose(driving, driving[0], rtol=0.01)
    assert 0.14 < braking[0] < 0.17
    assert driving[0] == pytest.approx(0.2, rel=0.03)
    assert np.ptp(spikes) > 0.1 * max(spikes), "single frames hang on the rate, or this test could not fail"


def test_the_greatest_vertical_force_does_not_depend_on_the_rate_of_frames(scene: Scene, motion: Recording):
    peaks = []
    for rate in (1000, 500, 200):
        seen = motion.at(slice(None, None, 1000 // rate))
        curve = over_strides(seen.time, vertical_forces(seen, scene)["left"], STRIDES).mean(axis=0)
        assert curve.shape == PERCENT.shape
        peaks.append(float(curve.max()))
    np.testing.assert_allclose(peaks, peaks[0], rtol=0.01)


def test_forces_are_along_x_and_z_and_along_the_heading(scene: Scene, motion: Recording):
    sides, ahead = horizontal_forces(motion, scene), forward_forces(motion, scene)
    np.testing.assert_allclose(sides["left"][:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(ahead["right"], sides["right"][:, 1], atol=1e-9)
