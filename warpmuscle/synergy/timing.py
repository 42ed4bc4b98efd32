"""When synergies are active, and for how long: centre of activity, and full width at half maximum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats, Integers

HALF = 0.5  # of the maximum


@dataclass(frozen=True)
class Timing:
    """Of N synergies: means over trials, and their standard deviations; NaN where a synergy is never active."""

    centre: Floats  # (N,) in the unit of time; of cycles 0..1
    centre_spread: Floats  # (N,)
    width: Floats  # (N,) in the unit of time; of cycles 0..1
    width_spread: Floats  # (N,)


def timing(coefficients: Floats, trial: Integers, time: Floats, cyclic: bool) -> Timing:
    """Timing of coefficients C (N, T).

    Args:
        trial: (T,) number of the recording, or of the cycle, of each sample. time: (T,) s, or cycles.
        cyclic: whether a trial is a cycle, whose end is next to its start.
    """
    centres, widths = [], []
    for number in np.unique(trial):
        inside = trial == number
        part = coefficients[:, inside]
        if cyclic:
            phase = np.arange(part.shape[1]) / part.shape[1]
            centres.append(circular_centre(part, phase))
            widths.append(width(part) / part.shape[1])
        else:
            own = time[inside]
            total = part.sum(axis=1)
            centres.append(np.where(total > 0.0, part @ own / np.where(total > 0.0, total, 1.0), np.nan))
            widths.append(width(part) * (own[1] - own[0]))
    table, extents = np.array(centres), np.array(widths, dtype=np.float64)
    if cyclic:
        vector = np.exp(2j * np.pi * table).mean(axis=0)
        centre = np.angle(vector) / (2.0 * np.pi) % 1.0
        spread = np.sqrt(-2.0 * np.log(np.clip(np.abs(vector), 1e-12, 1.0))) / (2.0 * np.pi)
    else:
        centre, spread = table.mean(axis=0), table.std(axis=0)
    return Timing(centre, spread, extents.mean(axis=0), extents.std(axis=0))


def circular_centre(curves: Floats, phase: Floats) -> Floats:
    """Centre of activity (N,), 0..1, of curves (N, P) round a cycle at phases (P,), 0..1.

    The direction of the sum of vectors that point to each phase and are as long as the curve is high there (Martino et
    al. 2014, J. Neurophysiol. 112:2810); NaN where the curve is 0.
    """
    total = curves @ np.exp(2j * np.pi * phase)
    centre = np.angle(total) / (2.0 * np.pi) % 1.0
    return np.asarray(np.where(curves.max(axis=1) > 0.0, centre, np.nan))


def width(curves: Floats) -> Floats:
    """Full width at half maximum (N,), samples, of curves (N, P).

    The number of samples above half of the greatest value, above the least (Cappellini et al. 2006, J. Neurophysiol.
    95:3426, and Santuz et al. 2018 count so); NaN where the curve is constant.
    """
    low, high = curves.min(axis=1, keepdims=True), curves.max(axis=1, keepdims=True)
    above = (curves - low > HALF * (high - low)).sum(axis=1)
    return np.asarray(np.where((high > low)[:, 0], above, np.nan))
