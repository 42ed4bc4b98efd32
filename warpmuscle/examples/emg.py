"""Raw EMG that is made rather than recorded: noise whose amplitude follows known muscle activity."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.examples.motions import LIFT, table

RATE = 1000.0  # 1/s
STRIDE = 1.1  # s
WALKING = ("GLU", "HFL", "HAM", "VAS", "GAS", "SOL", "TA")
# Weights of four synergies in these muscles, and the part of the gait cycle in which each of them is most active, after
# the common finding of early stance, push-off, early swing and late swing (Ivanenko, Poppele and Lacquaniti 2004).
WEIGHTS = np.array(
    [[1.0, 0.0, 0.0, 0.2], [0.0, 0.2, 1.0, 0.0], [0.3, 0.0, 0.0, 1.0], [1.0, 0.1, 0.0, 0.2],
     [0.0, 0.9, 0.0, 0.0], [0.2, 1.0, 0.0, 0.0], [0.3, 0.0, 0.9, 0.4]]
)  # fmt: skip
PEAKS = np.array([0.08, 0.45, 0.68, 0.93])
WIDTH = 0.09  # of a peak, in cycles


def walking_emg(strides: int = 8) -> Iterable[tuple[str, str]]:
    """EMG of a walk, and a table of the times at which its strides and their swing phases begin."""
    time = np.arange(round(strides * STRIDE * RATE)) / RATE
    phase = (time / STRIDE - PEAKS[:, None] + 0.5) % 1.0 - 0.5
    activity = (WEIGHTS @ np.exp(-((phase / WIDTH) ** 2))).T
    begins = STRIDE * np.arange(strides)
    yield "emg.csv", _noise(time, activity, WALKING)
    yield "strides.csv", table(np.column_stack([begins, begins + 0.62 * STRIDE]), ("touch_down_s", "lift_off_s"))


def lifting_emg() -> str:
    """EMG of shoulder and elbow in the shipped lift: what static optimisation says that its muscles do."""
    from warpmuscle.formats import load
    from warpmuscle.throw.arm import Arm
    from warpmuscle.throw.computed_synergies import computed_excitation
    from warpmuscle.throw.motion import ArmMotion, resample

    angles = np.radians(LIFT[:, 1:4])
    motion = ArmMotion("lift", 0.0, LIFT[:, 0], angles, np.radians(LIFT[:, 4]), LIFT[:, 5:7], ())
    arm = Arm(load("throw_groups"), ("wrist",))
    motions = resample([motion])
    excitation = computed_excitation(arm, motions)[1][0]
    time = np.arange(round(LIFT[-1, 0] * RATE) + 1) / RATE
    channels = ("DELT_ant", "DELT_post", "BIC", "TRI")
    activity = np.stack([np.interp(time, motions.time, excitation[:, k]) for k in range(len(channels))], axis=1)
    return _noise(time, activity, channels)


def _noise(time: Floats, amplitude: Floats, names: tuple[str, ...]) -> str:
    """A table of noise (T, C) of an amplitude, mV, over time."""
    noise = np.random.default_rng(1).normal(size=amplitude.shape)
    return table(np.column_stack([time, (amplitude + 0.01) * noise]), ("time", *names))
