"""How far a pelvis has to lean for the legs of a norm to stand on the ground, and where these then reach.

In mid-stance the foot is to be flat; as the heel of the leading foot lands, the ball of the trailing one is to touch.

For docs/how-to/learn-from-python.md.

python tools/research/imitated_norms.py
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.norms import IMITATED, LEG_ANGLES, GaitNorm, is_run

PART = 0.43  # m, thigh and shank of a person of 1.75 m
CYCLE = 1.03  # s
HEEL, BALL = (-0.05, -0.08), (0.13, -0.08)  # m, ahead of the ankle and above it, of a flat foot
PERCENT = np.arange(101.0)
FLAT, BACK = slice(12, 33), slice(12, 41)  # % of the cycle in which the foot is flat, and in which it carries
FLAT_IN_RUNS = slice(10, 21)


def ankle_places(norm: GaitNorm, tilt: float) -> Floats:
    """How far ahead of the hip the ankle is over the cycle (101,), m, if the pelvis leans forwards by degrees."""
    hip, knee, _ = (norm.angles[name].mean(PERCENT) for name in LEG_ANGLES)
    thigh = np.radians(hip - tilt)
    return np.asarray(PART * (np.sin(thigh) + np.sin(thigh - np.radians(knee))))


def hanging(norm: GaitNorm, tilt: float) -> float:
    """How far the heel that lands is above the ball of the trailing foot, mm, over a pelvis that leans by degrees."""
    heights = []
    for percent, (ahead, above) in ((0, HEEL), (50, BALL)):
        hip, knee, ankle = (float(norm.angles[name].mean(PERCENT)[percent]) for name in LEG_ANGLES)
        thigh, shank, foot = np.radians(np.cumsum([hip - tilt, -knee, ankle]))
        heights.append(above * np.cos(foot) + ahead * np.sin(foot) - PART * (np.cos(thigh) + np.cos(shank)))
    return float(1000.0 * (heights[0] - heights[1]))


def landing_tilt(norm: GaitNorm) -> float:
    """Degrees by which the pelvis leans where both touch."""
    tilts = np.linspace(-10.0, 30.0, 401)
    return float(tilts[np.argmin(np.abs([hanging(norm, tilt) for tilt in tilts]))])


def main() -> None:
    """Print a table."""
    print("| `norm` | degrees, and their spread | ahead at contact, m | behind at 50 % | moves back, m/s "
          "| heel above the ball behind, mm | none at degrees |")  # fmt: skip
    print("|---|---|---|---|---|---|---|")
    for norm in IMITATED:
        if is_run(norm.source):
            continue
        hip, knee, ankle = (norm.angles[name].mean(PERCENT) for name in LEG_ANGLES)
        pitch = (hip - knee + ankle)[FLAT]  # of the foot over an upright pelvis, toes up
        place = ankle_places(norm, float(pitch.mean()))
        speed = -np.gradient(place, CYCLE / 100.0)[BACK].mean()
        row = f"{pitch.mean():.1f}, {pitch.std():.1f} | {place[0]:.2f} | {-place[50]:.2f} | {speed:.2f}"
        row += f" | {hanging(norm, float(pitch.mean())):.0f} | {landing_tilt(norm):.1f}"
        print(f"| `{norm.source}` | {row} |")
    for norm in (one for one in IMITATED if is_run(one.source)):
        hip, knee, ankle = (norm.angles[name].mean(PERCENT)[FLAT_IN_RUNS] for name in LEG_ANGLES)
        pitch = hip - knee + ankle
        print(f"`{norm.source}`: {pitch.mean():.1f}, {pitch.std():.1f} degrees from {FLAT_IN_RUNS.start} to "
              f"{FLAT_IN_RUNS.stop - 1} %")  # fmt: skip


if __name__ == "__main__":
    main()
