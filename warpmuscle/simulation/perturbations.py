"""Disturbances of simulated bipeds: pushes, initial velocities, slopes; and the runs of a robust objective."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Robustness

FIRST_PUSH = 1.0  # s, not before which a drawn push comes, where the simulation is long enough


@dataclass(frozen=True)
class Perturbations:
    """What disturbs each of n instances.

    Attributes:
        velocity: (n, 3) m/s, added to the root's initial velocity, world.
        push: (n, 3) N s, impulse on the root's centre of mass, world.
        push_start: (n,) s. push_duration: s, of a constant force.
        slope: (n,) rad, by which the ground rises forwards.
    """

    velocity: Floats
    push: Floats
    push_start: Floats
    slope: Floats
    push_duration: float = 0.1

    def __len__(self) -> int:
        """Number of instances."""
        return len(self.slope)

    @property
    def any(self) -> bool:
        """Whether any instance is disturbed at all."""
        return bool(np.any(self.velocity) or np.any(self.push) or np.any(self.slope))

    def part(self, share: slice) -> Perturbations:
        """Those of some of the instances."""
        return Perturbations(
            self.velocity[share], self.push[share], self.push_start[share], self.slope[share], self.push_duration
        )

    def tiled(self, times: int) -> Perturbations:
        """The same for so many groups of instances, one group behind the other."""
        return Perturbations(
            np.tile(self.velocity, (times, 1)), np.tile(self.push, (times, 1)), np.tile(self.push_start, times),
            np.tile(self.slope, times), self.push_duration,
        )  # fmt: skip


def none(instances: int) -> Perturbations:
    """No disturbance of any instance."""
    zero, zeros = np.zeros((instances, 3)), np.zeros(instances)
    return Perturbations(zero, zero, zeros, zeros)


def drawn(robustness: Robustness, duration: float) -> Perturbations:
    """The runs of one candidate, the same for every one of them: the first is not disturbed if there are several.

    Args:
        robustness: says how much. duration: of the simulation, s; pushes come in its last three quarters.
    """
    generator = np.random.default_rng(robustness.seed)
    runs = robustness.runs
    velocity = generator.normal(0.0, 1.0, (runs, 3)) * robustness.velocity_noise
    direction = generator.uniform(0.0, 2.0 * np.pi, runs)
    earliest = min(FIRST_PUSH, 0.25 * duration)
    start = generator.uniform(earliest, max(0.9 * duration, earliest), runs)
    slope = generator.uniform(-1.0, 1.0, runs) * robustness.slope
    push = robustness.push * np.stack([np.sin(direction), np.zeros(runs), np.cos(direction)], axis=1)
    disturbed = np.arange(runs) > 0 if runs > 1 else np.ones(1, dtype=bool)
    return Perturbations(
        velocity * disturbed[:, None], push * disturbed[:, None], start, slope * disturbed, robustness.push_duration
    )


def combined(costs: Floats, robustness: Robustness) -> Floats:
    """Cost of each candidate, (n,), from those of its runs, (n, runs): their mean, or the worst."""
    return np.asarray(costs.mean(axis=1) if robustness.cost == "mean" else costs.max(axis=1))
