"""Noise of recorded motions is told from motion, and a low-pass takes it away without lag."""

from dataclasses import replace

import numpy as np
import pytest

from warpmuscle.core.errors import SignalError
from warpmuscle.throw.motion import ArmMotion
from warpmuscle.throw.recordings.smoothing import (
    NOISY,
    check_noise,
    check_passed,
    low_passed,
    noise,
    noise_and_cutoff,
    removed,
    suitable,
)

TIME = np.arange(0.0, 1.501, 0.01)
JOINTS = ("shoulder", "elbow")


def motion(size: float = 0.0, time: np.ndarray = TIME) -> ArmMotion:
    """Angles that move by 1 rad within half a second, with white noise, deg."""
    angles = np.stack([0.5 * np.sin(6.0 * time), 0.5 * np.cos(7.0 * time)], axis=1)
    angles += np.radians(size) * np.random.default_rng(0).normal(size=angles.shape)
    return ArmMotion("m", 0.0, time, angles, 0.1 * time, np.zeros((len(time), 2)))


def test_noise_of_two_degrees_is_refused_with_its_size_and_what_helps():
    with pytest.raises(SignalError, match=r"shoulder has noise of about (1\.[89]|2|2\.[012]) deg.*--low-pass 6"):
        check_noise(motion(2.0), JOINTS)
    check_noise(motion(0.0), JOINTS)
    assert max(noise(motion(0.0))) < 0.5 * NOISY < NOISY < min(noise(motion(0.05)))


def test_slow_recordings_hold_too_little_to_tell_noise_by():
    check_noise(motion(2.0, TIME[::3]), JOINTS)


def test_a_low_pass_takes_the_noise_and_leaves_the_motion_where_it_was():
    clean, noisy = motion(), motion(2.0)
    passed = low_passed(noisy, 6.0)
    check_noise(passed, JOINTS)
    assert np.sqrt(np.mean((passed.angles - clean.angles) ** 2)) < np.radians(1.0)
    np.testing.assert_allclose(np.degrees(removed(noisy, passed)), 2.0, atol=0.4)
    np.testing.assert_allclose(low_passed(clean, 6.0).angles, clean.angles, atol=0.02)
    assert np.abs(low_passed(clean, 6.0).pitch - clean.pitch).max() < 1e-3


def test_uneven_times_are_made_even():
    uneven = motion(0.0, np.sort(np.concatenate([TIME[::2], TIME[1:40:2]])))
    passed = low_passed(uneven, 8.0)
    assert np.ptp(np.diff(passed.time)) < 1e-9
    assert passed.time[-1] == uneven.time[-1]


def test_missing_samples_do_not_pass_for_noise():
    time = np.delete(TIME, [50, 51, 52, 110])
    assert max(noise(motion(0.0, time))) < 2.0 * max(noise(motion())) < NOISY
    passed = low_passed(motion(0.0, time), 20.0)
    assert np.abs(passed.angles[:, 0] - 0.5 * np.sin(6.0 * passed.time))[5:-5].max() < 1e-3


def test_the_chosen_filter_is_no_higher_than_limbs_are_fast():
    time = np.arange(0.0, 1.501, 0.001)
    rounded = replace(motion(0.0, time), angles=np.radians(np.round(np.degrees(motion(0.0, time).angles), 3)))
    assert max(noise(rounded)) > NOISY
    assert suitable([rounded]) <= 20.0


@pytest.mark.parametrize(("frequency", "message"), [(0.0, "above 0 Hz"), (60.0, "below half"), (np.nan, "nan Hz")])
def test_frequencies_that_make_no_filter_are_refused(frequency: float, message: str):
    with pytest.raises(SignalError, match=message):
        low_passed(motion(), frequency)


def test_a_motion_that_is_shorter_than_a_period_is_refused():
    with pytest.raises(SignalError, match=r"0\.2 s are too short for a low-pass of 4 Hz"):
        low_passed(replace(motion(), time=TIME[:21], angles=motion().angles[:21]), 4.0)


@pytest.mark.parametrize("size", [0.02, 0.5, 2.0])
def test_residual_analysis_finds_how_great_noise_is(size: float):
    found, cutoffs = noise_and_cutoff(np.degrees(motion(size).angles), 100.0)
    np.testing.assert_allclose(found, size, rtol=0.15)
    assert np.all((cutoffs > 2.0) & (cutoffs < 20.0))


def test_clean_motions_need_no_filter_and_noisier_ones_a_lower_one():
    assert suitable([motion()]) is None
    little, much = (suitable([motion(), motion(size)]) for size in (0.05, 0.5))
    assert little is not None
    assert much is not None
    assert 2.0 < much < little < 12.0


def test_the_chosen_filter_is_nearly_the_best_for_accelerations():
    """Beside all other cut-offs, against the accelerations that are known."""
    true = np.stack([-18.0 * np.sin(6.0 * TIME), -24.5 * np.cos(7.0 * TIME)], axis=1)[10:-10]
    noisy = motion(0.1)

    def error(frequency: float) -> float:
        angles = low_passed(noisy, frequency).angles
        return float(
            np.sqrt(np.mean((np.gradient(np.gradient(angles, 0.01, axis=0), 0.01, axis=0)[10:-10] - true) ** 2))
        )

    chosen = suitable([noisy])
    assert chosen is not None
    assert error(chosen) < 2.0 * min(error(frequency) for frequency in np.arange(2.0, 20.0, 0.5))


def test_noise_that_passes_the_filter_is_refused_where_it_hides_accelerations():
    noisy = motion(4.0)
    frequency = suitable([noisy])
    assert frequency is not None
    with pytest.raises(SignalError, match=r"shoulder has noise of about [34]\S* deg.*lost even below.*--low-pass"):
        check_passed(noisy, low_passed(noisy, frequency), frequency, JOINTS)
    check_passed(motion(0.1), low_passed(motion(0.1), frequency), frequency, JOINTS)


def test_short_motions_and_slow_recordings_pass_the_filter_that_is_chosen():
    short = replace(motion(0.05), time=TIME[:15], angles=motion(0.05).angles[:15], pitch=0.1 * TIME[:15],
                    place=np.zeros((15, 2)))  # fmt: skip
    slow = motion(0.05, TIME[::5])
    for others in ([short], [motion(0.05), slow]):
        frequency = suitable(others)
        assert frequency is not None
        assert all(np.isfinite(low_passed(one, frequency).angles).all() for one in others)
