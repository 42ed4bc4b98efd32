"""Noise of recorded motions: how much of it is too much, and a filter against it.

Accelerations decide which torques a motion needs, and differentiating twice magnifies noise by the square of its
frequency. People move their limbs below some 20 Hz; what accelerates faster is noise.

Where nobody names a filter, noisy motions get one. Residual analysis (Winter 2009, section 3.4.4) finds the cut-off
at which a filter takes as much as there is noise. That suits angles; accelerations take a lower one (Giakas and
Baltzopoulos 1997), of 22 throws with noise of 0.02 to 2 degrees some three fifths of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.throw.motion import ArmMotion

ORDER = 2  # of one pass
FASTEST = 20.0  # Hz, of limbs
LEAST_RATE = 3.0 * FASTEST  # 1/s: slower recordings hold too little beyond it to tell noise by
TOO_NOISY, NOISY = 4.0, 0.25  # times as much acceleration beyond FASTEST as below it: refused, and filtered
TRIED = 40  # cut-offs that residual analysis tries
SLOWEST, NOISE_ONLY, LAST_TRIED = 2.0, 0.2, 0.45  # Hz; parts of the sampling rate, between which all is noise
FOR_ACCELERATIONS = 0.6  # of the cut-off for angles
PERIODS = 1.001  # of the chosen filter, which the shortest motion takes at least
UNEVEN = 1e-3  # part of a step
LOST = 0.25  # of the acceleration that passes a filter, at most, may be noise (root mean squares)


def low_passed(motion: ArmMotion, frequency: float) -> ArmMotion:
    """A motion without what is faster, by Butterworth's filter of second order, forwards and backwards: without lag.

    Args:
        frequency: Hz, at which each of the two passes halves the power.

    Raises:
        SignalError: the frequency is not between 0 and half the sampling rate, or the motion is too short for it.
    """
    rate = _rate(motion)
    if not 0.0 < frequency < 0.5 * rate:
        raise SignalError(
            f"motion {motion.name}: a low-pass must lie above 0 Hz and below half the sampling rate, {0.5 * rate:.4g} "
            f"Hz, not at {frequency:g} Hz"
        )
    if motion.time[-1] * frequency < 1.0:
        raise SignalError(
            f"motion {motion.name}: {motion.time[-1]:.3g} s are too short for a low-pass of {frequency:g} Hz, which "
            f"takes at least one period, {1.0 / frequency:.3g} s"
        )
    time = np.linspace(0.0, motion.time[-1], round(motion.time[-1] * rate) + 1)
    angles, pitch, place = (
        _filtered(_evenly(time, motion, part), rate, frequency, ORDER)
        for part in (motion.angles, motion.pitch[:, None], motion.place)
    )
    return replace(motion, time=time, angles=angles, pitch=pitch[:, 0], place=place)


def suitable(motions: Sequence[ArmMotion]) -> float | None:
    """A cut-off, Hz, for motions of which some are noisy, see `low_passed`; None if none is.

    It is the median of those that suit the noisy ones, each the highest of its angles, no higher than limbs are fast,
    and one that all can pass.
    """
    noisy = [motion for motion in motions if max(noise(motion), default=0.0) > NOISY]
    found = [float(noise_and_cutoff(_even(motion), _rate(motion))[1].max()) for motion in noisy]
    if not found:
        return None
    lowest = PERIODS / min(m.time[-1] for m in motions)
    highest = max(min(FASTEST, LAST_TRIED * min(_rate(m) for m in motions)), lowest)
    return float(np.clip(FOR_ACCELERATIONS * np.median(found), lowest, highest))


def noise_and_cutoff(angles: Floats, rate: float) -> tuple[Floats, Floats]:
    """How great white noise is (J,), in the unit of angles (T, J), and the cut-offs (J,), Hz, of residual analysis.

    The squared residual of a low-pass falls in a line with its cut-off where all that it takes is noise. At a cut-off
    of 0 that line is at the variance of the noise.
    """
    cutoffs = np.geomspace(SLOWEST, LAST_TRIED * rate, TRIED)
    residual = np.array([np.mean((angles - _filtered(angles, rate, f, ORDER)) ** 2, axis=0) for f in cutoffs])
    beyond = cutoffs >= NOISE_ONLY * rate
    variance = np.maximum(np.polyfit(cutoffs[beyond], residual[beyond], 1)[1], 0.0)
    enough = residual <= variance
    enough[-1] = True
    return np.sqrt(variance), cutoffs[enough.argmax(axis=0)]


def usable(
    motions: Sequence[ArmMotion], joints: Sequence[str], low_pass: float | None, chosen: bool = False
) -> list[ArmMotion]:
    """Motions that have passed a filter, if there is one, and hold no more noise than a fit can bear.

    Args:
        joints: names of the angles.
        low_pass: Hz, see `low_passed`.
        chosen: whether the filter is `suitable` rather than what somebody asked for.

    Raises:
        SignalError: the filter does not suit a motion, or accelerations are lost in noise.
    """
    passed = [motion if low_pass is None else low_passed(motion, low_pass) for motion in motions]
    for before, after in zip(motions, passed, strict=True):
        check_noise(after, joints)
        if low_pass is not None and chosen:
            check_passed(before, after, low_pass, joints)
    return passed


def check_passed(before: ArmMotion, after: ArmMotion, frequency: float, joints: Sequence[str]) -> None:
    """SignalError if so much noise passed a filter that an angle's accelerations are lost in it.

    Args:
        before, after: what was filtered. frequency: Hz, of the filter. joints: (J,) names of the angles.
    """
    rate = _rate(before)
    impulse = np.zeros((2 * int(3.0 * rate / frequency) + 1, 1))
    impulse[len(impulse) // 2] = 1.0
    passes = np.linalg.norm(np.diff(_filtered(impulse, rate, frequency, ORDER), 2, axis=0))
    bends = np.sqrt(np.mean(np.diff(after.angles, 2, axis=0) ** 2, axis=0))
    for name, size, bend in zip(joints, noise_and_cutoff(_even(before), rate)[0], bends, strict=True):
        if size * passes > LOST * bend:
            raise SignalError(
                f"motion {before.name}: {name} has noise of about {np.degrees(size):.2g} deg, in which its "
                f"accelerations are lost even below {frequency:.2g} Hz; smooth it before, or more, for instance with "
                f"--low-pass {max(0.6 * frequency, 1.0):.0f}"
            )


def removed(before: ArmMotion, after: ArmMotion) -> Floats:
    """Root mean square (J,), rad, of what a filter took from each angle."""
    parts = [np.interp(before.time, after.time, column) for column in after.angles.T]
    return np.asarray(np.sqrt(np.mean((before.angles - np.stack(parts, axis=1)) ** 2, axis=0)))


def noise(motion: ArmMotion) -> list[float]:
    """How much faster acceleration there is beyond what limbs do than below, of each angle.

    Empty of recordings below 60 samples a second, which hold too little beyond it.
    """
    return [fast / max(slow, 1e-12) for fast, slow, _ in _shares(motion)]


def check_noise(motion: ArmMotion, joints: Sequence[str]) -> None:
    """SignalError if noise hides the accelerations of an angle.

    Args:
        joints: (J,) names of the angles.
    """
    for name, (fast, slow, size) in zip(joints, _shares(motion), strict=False):
        if fast > TOO_NOISY * slow:
            raise SignalError(
                f"motion {motion.name}: {name} has noise of about {np.degrees(size):.2g} deg, in which its "
                f"accelerations are lost; smooth it, for instance with --low-pass 6"
            )


def _shares(motion: ArmMotion) -> list[tuple[float, float, float]]:
    """Of each angle: second differences beyond and below `FASTEST`, root mean square, and how great white noise is."""
    rate = _rate(motion)
    if rate < LEAST_RATE:
        return []
    angle = _even(motion)
    slow = _filtered(angle, rate, FASTEST, 2 * ORDER)
    size = np.std(angle - slow, axis=0) / np.sqrt(1.0 - 2.0 * FASTEST / rate)
    bends = (np.sqrt(np.mean(np.diff(part, 2, axis=0) ** 2, axis=0)) for part in (angle - slow, slow))
    return list(zip(*(part.tolist() for part in (*bends, size)), strict=True))


def _rate(motion: ArmMotion) -> float:
    """Samples a second."""
    return float((len(motion.time) - 1) / motion.time[-1])


def _even(motion: ArmMotion) -> Floats:
    """Angles (T, J) at even times."""
    time = np.linspace(0.0, motion.time[-1], round(motion.time[-1] * _rate(motion)) + 1)
    return _evenly(time, motion, motion.angles)


def _evenly(time: Floats, motion: ArmMotion, values: Floats) -> Floats:
    """Values (S, k) at other times (T,), by a cubic spline where samples are uneven: corners would pass for noise."""
    if np.ptp(np.diff(motion.time)) > UNEVEN * float(np.mean(np.diff(motion.time))):
        return np.asarray(CubicSpline(motion.time, values)(time))
    return np.stack([np.interp(time, motion.time, column) for column in values.T], axis=1)


def _filtered(values: Floats, rate: float, frequency: float, order: int) -> Floats:
    """Low-passed forwards and backwards; beyond both ends values go on as their reflection in the point there."""
    sections = butter(order, frequency, "lowpass", fs=rate, output="sos")
    reach = min(int(np.ceil(3.0 * rate / frequency)), len(values) - 1)
    return np.asarray(sosfiltfilt(sections, values, axis=0, padtype="odd", padlen=reach))
