"""Norm bands of adult human walking at a comfortable speed, to see a simulated gait beside.

Between key points, the extremes of a norm's mean curve, a band follows smooth steps; it is as exact as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.figure import leg
from warpmuscle.recording import Floats
from warpmuscle.scene import Scene
from warpmuscle.topology import Topology

SOURCE = "norm curves in SCONE Studio"
FORCE = "Vertical ground force"
LEG_ANGLES = ("Hip flexion", "Knee flexion", "Ankle dorsiflexion")
FLEXION = (-1.0, 1.0, -1.0)  # sign of a turn about x, which points to the left, that is flexion of hip, knee and ankle
BINS = 50  # of the phase of a step
STANCE = 50.0 * (np.arange(BINS) + 0.5) / BINS  # percent of the gait cycle where the stance leg is in each of them


@dataclass(frozen=True)
class Norm:
    """Mean and half-width of a quantity over the gait cycle, from the touch-down of a foot to its next."""

    points: tuple[tuple[float, float], ...]  # percent of the cycle and mean, in order
    half_band: float
    unit: str
    periodic: bool = True  # the last point leads on to the first; else the mean is 0 before and after

    def mean(self, percent: Floats) -> Floats:
        """Mean at these percents, of the same shape."""
        at, value = np.array(self.points).T
        if self.periodic:
            at = np.concatenate([[at[-1] - 100.0], at, [at[0] + 100.0]])
            value = np.concatenate([value[-1:], value, value[:1]])
        after = np.clip(np.searchsorted(at, percent), 1, len(at) - 1)
        part = np.clip((percent - at[after - 1]) / (at[after] - at[after - 1]), 0.0, 1.0)
        smooth = part * part * (3.0 - 2.0 * part)  # level at both ends, as at an extreme
        return np.asarray((1.0 - smooth) * value[after - 1] + smooth * value[after])


NORMS = {
    "Hip flexion": Norm(((1.0, 33.0), (52.0, -8.3), (87.0, 33.7)), 8.4, "deg"),
    "Knee flexion": Norm(((12.0, 19.4), (39.0, 7.2), (72.0, 63.4), (97.0, 3.8)), 5.3, "deg"),
    "Ankle dorsiflexion": Norm(((5.0, -6.5), (43.0, 12.5), (64.0, -19.9), (85.0, 2.7)), 3.9, "deg"),
    FORCE: Norm(
        ((0.0, 0.0), (15.0, 1.05), (31.0, 0.80), (49.0, 1.14), (64.0, 0.0)), 0.06, "body weights", periodic=False
    ),
}


@dataclass(frozen=True)
class Reference:
    """Means of a measure of human walking, from the least to the greatest of the groups measured."""

    low: float
    high: float
    source: str


_MURRAY = "Murray et al. 1964, 1970"
REFERENCES = {
    "speed": Reference(1.27, 1.46, "Bohannon 1997"),
    "step length": Reference(0.66, 0.79, _MURRAY),
    "step width": Reference(0.071, 0.081, _MURRAY),
    "cadence": Reference(117.0, 117.0, _MURRAY),
    "cost of transport": Reference(3.05, 3.51, "PLOS ONE 0168070, 0138154"),
}


def norm_table(scene: Scene, names: Topology) -> tuple[Floats, Floats]:
    """Sagittal angles of human legs over the phase of a step, for `kernels.objective_terms.norms`.

    Args:
        scene: with a controller, whose feet have a hip, a knee and an ankle above them.

    Returns:
        Mean angles (2 BINS, bodies) of each body's joint in half-bands, left stance first, and (bodies,) half-bands per
        rad of a turn about x, 0 for joints without a norm.
    """
    assert scene.controller is not None
    table, scale = np.zeros((2 * BINS, len(names.bodies))), np.zeros(len(names.bodies))
    for side, foot in enumerate(scene.controller.feet):
        percents = np.concatenate([STANCE, STANCE + 50.0] if side == 0 else [STANCE + 50.0, STANCE])
        for title, sign, joint in zip(LEG_ANGLES, FLEXION, leg(scene.character, foot)[-3:], strict=True):
            body, norm = names.body_of_joint(joint), NORMS[title]
            table[:, body] = norm.mean(percents) / norm.half_band
            scale[body] = np.degrees(sign) / norm.half_band
    return table, scale
