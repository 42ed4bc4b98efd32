"""Electromyograms made of known synergies."""

from pathlib import Path

import numpy as np

from warpmuscle.synergy.signals import Signals

NAMES = ("DA", "DP", "BIC", "TRI", "FCR", "ECU", "PEC")
RATE = 1000.0  # 1/s
WEIGHTS = np.array(
    [
        [1.0, 0.0, 0.1],
        [0.0, 1.0, 0.0],
        [0.7, 0.0, 0.0],
        [0.0, 0.6, 0.2],
        [0.0, 0.0, 1.0],
        [0.2, 0.0, 0.8],
        [0.5, 0.3, 0.0],
    ]
)


def coefficients(time: np.ndarray) -> np.ndarray:
    """Coefficients (3, T): bumps that come one after the other every 1.5 s."""
    phase = (time[None] / 1.5 - np.array([[0.2], [0.5], [0.8]]) + 0.5) % 1.0 - 0.5
    return np.exp(-((phase / 0.09) ** 2))


def raw_emg(seconds: float = 6.0, seed: int = 0) -> Signals:
    """Noise (T, 7) whose amplitude is W C(t), mV."""
    time = np.arange(int(seconds * RATE)) / RATE
    amplitude = (WEIGHTS @ coefficients(time)).T
    return Signals(NAMES, RATE, amplitude * np.random.default_rng(seed).normal(size=amplitude.shape))


def write_csv(path: Path, signals: Signals, form: str = "%.6f") -> Path:
    """Write signals as comma-separated values with their times."""
    table = np.column_stack([signals.time, signals.values])
    header = ",".join(("time", *signals.names))
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt=form)
    return path
