"""Ground forces as those of force plates are published: low-passed, so that no row hangs on the spike of one frame.

A contact of springs has spikes of a few milliseconds, of which a recording holds more or less by how many frames a
second it has. Plates' data are low-passed before extremes are read off, and so are these. Contacts of feet with the
ground are found in what was recorded, see `foot_contact`.
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.sequences import are_even, mirrored
from warpmuscle.gait.cycles import body_weight
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.measures import heading
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene

# Cut-offs, Hz. In the plates' data that limits of the fore-aft force rest on, OpenSim's subject 01, 0.02 % of the power
# lies above 20 Hz, and ten times less above 25 Hz: a filter there changes their extremes by less than 0.001 weights.
# How norms of the vertical force were filtered is not known, so they get the mildest of the usual filters.
FORE_AFT, VERTICAL = 20.0, 50.0
ORDER = 4  # of Butterworth's filter without lag, as of one of second order that is run forwards and backwards
LEAST_FRAMES = 4
SETTLED = 5.0  # periods of the cut-off, after which the filter has forgotten a jump


def low_passed(time: Floats, values: Floats, cutoff: float) -> Floats:
    """Values (F, ...) at times (F,), s, without what is faster than a cut-off, Hz, by Butterworth's filter, zero lag.

    It weakens each frequency by what the filter does in continuous time, so that the rate of frames changes nothing.
    Recordings of too few frames, or of too few a second, stay as they are: they hold nothing that is faster.
    """
    at, given = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    if len(at) < LEAST_FRAMES or at[-1] <= at[0]:
        return given
    even = are_even(at)
    count = len(at) if even else round((at[-1] - at[0]) / float(np.median(np.diff(at)))) + 1
    rate = (count - 1) / (at[-1] - at[0])
    if cutoff >= 0.5 * rate:
        return given
    rows = given.reshape(len(given), -1)
    grid = np.linspace(at[0], at[-1], count)
    if not even:
        rows = np.stack([np.interp(grid, at, column) for column in rows.T], axis=1)
    more = min(round(SETTLED * rate / cutoff), count - 1)
    longer = mirrored(rows, more)
    gain = 1.0 / (1.0 + (np.fft.rfftfreq(len(longer), 1.0 / rate) / cutoff) ** ORDER)
    rows = np.fft.irfft(gain[:, None] * np.fft.rfft(longer, axis=0), len(longer), axis=0)[more : more + count]
    if not even:
        rows = np.stack([np.interp(at, grid, column) for column in rows.T], axis=1)
    return np.asarray(rows.reshape(given.shape))


def vertical_forces(recording: Recording, scene: Scene) -> dict[str, Floats]:
    """Vertical ground forces (F,) on the feet over the weight of a numeric scene's character, by side, low-passed."""
    weight = body_weight(scene)
    return {
        side: low_passed(recording.time, recording[f"foot_force_{side}"][:, 1], VERTICAL) / weight for side in SIDES
    }


def horizontal_forces(recording: Recording, scene: Scene) -> dict[str, Floats]:
    """Ground forces (F, 2) on the feet along x and z over the weight of the character, by side, low-passed."""
    weight = body_weight(scene)
    return {
        side: low_passed(recording.time, recording[f"foot_force_{side}"][:, [0, 2]], FORE_AFT) / weight
        for side in SIDES
    }


def forward_forces(recording: Recording, scene: Scene) -> dict[str, Floats]:
    """Force of the ground (F,) on each foot along the root's heading, body weights; negative where it brakes."""
    turned = heading(recording)
    ahead = np.stack([np.sin(turned), np.cos(turned)], axis=1)
    return {side: np.sum(force * ahead, axis=1) for side, force in horizontal_forces(recording, scene).items()}
