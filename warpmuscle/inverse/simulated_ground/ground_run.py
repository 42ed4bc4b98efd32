"""How the ground carried a simulation that follows a recording, beside what force plates measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.html_table import Tabulated
from warpmuscle.scene import Scene


@dataclass(frozen=True, repr=False)
class GroundRun(Tabulated):
    """The ground of a trial of W windows; world axes: x to the left, y up, z forward.

    Attributes:
        scene: the model on the ground, which `Tracked.start` and excitations run.
        lift: (W + 1,) m, by which the root was lifted so that the recorded feet are on the ground.
        belt: (3,) m/s, of the treadmill below the recording; the run walks ahead by so much.
        force: (W, 2, 3) N, of the ground on left and right foot as windows end. plates: the same, measured.
        gap: the greatest gap that was left in the plan of the motion, 1 being some 2 degrees, 0.5 rad/s or 0.3 m/s.
    """

    scene: Scene
    lift: Floats
    belt: Floats
    force: Floats
    plates: Floats
    gap: float

    @property
    def force_error(self) -> Floats:
        """Root mean square (2, 3) of the differences between the ground's and the plates' forces, N."""
        return np.asarray(np.sqrt(np.mean(np.square(self.force - self.plates), axis=0)))
