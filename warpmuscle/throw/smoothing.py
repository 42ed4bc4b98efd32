"""Noise of recorded motions: how much of it is too much, and a filter against it.

Accelerations decide which torques a motion needs, and differentiating twice magnifies noise by the square of its
frequency. People move their limbs below some 20 Hz; what accelerates faster is noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.throw.motion import Motion

ORDER = 2  # of one pass
FASTEST = 20.0  # Hz, of limbs
LEAST_RATE = 3.0 * FASTEST  # 1/s: slower recordings hold too little beyond it to tell noise by
TOO_NOISY, NOISY = 4.0, 0.4  # times as much acceleration beyond FASTEST as below it: refused, and worth a word


def low_passed(motion: Motion, frequency: float) -> Motion:
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


def removed(before: Motion, after: Motion) -> Floats:
    """Root mean square (J,), rad, of what a filter took from each angle."""
    parts = [np.interp(before.time, after.time, column) for column in after.angles.T]
    return np.asarray(np.sqrt(np.mean((before.angles - np.stack(parts, axis=1)) ** 2, axis=0)))


def noise(motion: Motion) -> list[float]:
    """How much faster acceleration there is beyond what limbs do than below, of each angle.

    Empty of recordings below 60 samples a second, which hold too little beyond it.
    """
    return [fast / max(slow, 1e-12) for fast, slow, _ in _shares(motion)]


def check_noise(motion: Motion, joints: Sequence[str]) -> None:
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


def _shares(motion: Motion) -> list[tuple[float, float, float]]:
    """Of each angle: second differences beyond and below `FASTEST`, root mean square, and how great white noise is."""
    rate = _rate(motion)
    if rate < LEAST_RATE:
        return []
    time = np.linspace(0.0, motion.time[-1], round(motion.time[-1] * rate) + 1)
    angle = _evenly(time, motion, motion.angles)
    slow = _filtered(angle, rate, FASTEST, 2 * ORDER)
    size = np.std(angle - slow, axis=0) / np.sqrt(1.0 - 2.0 * FASTEST / rate)
    bends = (np.sqrt(np.mean(np.diff(part, 2, axis=0) ** 2, axis=0)) for part in (angle - slow, slow))
    return list(zip(*(part.tolist() for part in (*bends, size)), strict=True))


def _rate(motion: Motion) -> float:
    """Samples a second."""
    return float((len(motion.time) - 1) / motion.time[-1])


def _evenly(time: Floats, motion: Motion, values: Floats) -> Floats:
    """Values (S, k) at other times (T,), straight between samples."""
    return np.stack([np.interp(time, motion.time, column) for column in values.T], axis=1)


def _filtered(values: Floats, rate: float, frequency: float, order: int) -> Floats:
    """Low-passed forwards and backwards; beyond both ends values go on as their reflection in the point there."""
    sections = butter(order, frequency, "lowpass", fs=rate, output="sos")
    reach = min(int(np.ceil(3.0 * rate / frequency)), len(values) - 1)
    return np.asarray(sosfiltfilt(sections, values, axis=0, padtype="odd", padlen=reach))
