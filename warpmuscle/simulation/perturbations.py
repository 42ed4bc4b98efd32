"""Disturbances of simulated bipeds: pushes, initial velocities, slopes, masses, strengths; robust objectives' runs."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Robustness, Scene

FIRST_PUSH = 1.0  # s, not before which a drawn push comes, where the simulation is long enough


@dataclass(frozen=True)
class Perturbations:
    """What disturbs each of n instances.

    Attributes:
        velocity: (n, 3) m/s, added to the root's initial velocity, world.
        push: (n, 3) N s, impulse on the root's centre of mass, world.
        push_start: (n,) s. push_duration: s, of a constant force.
        slope: (n,) rad, by which the ground rises forwards.
        mass: (n, bodies) factors on masses and inertias; None: all bodies are as the scene says.
        strength: (n, muscles) factors on `f_max` of all muscles of the scene, in order; None: as the scene says.
    """

    velocity: Floats
    push: Floats
    push_start: Floats
    slope: Floats
    push_duration: float = 0.1
    mass: Floats | None = None
    strength: Floats | None = None

    def __len__(self) -> int:
        """Number of instances."""
        return len(self.slope)

    @property
    def any(self) -> bool:
        """Whether any instance is disturbed at all."""
        other_bodies = self.mass is not None or self.strength is not None
        return bool(np.any(self.velocity) or np.any(self.push) or np.any(self.slope) or other_bodies)

    def part(self, share: slice) -> Perturbations:
        """Those of some of the instances."""
        return Perturbations(
            self.velocity[share], self.push[share], self.push_start[share], self.slope[share], self.push_duration,
            None if self.mass is None else self.mass[share],
            None if self.strength is None else self.strength[share],
        )  # fmt: skip

    def tiled(self, times: int) -> Perturbations:
        """The same for so many groups of instances, one group behind the other."""
        return Perturbations(
            np.tile(self.velocity, (times, 1)), np.tile(self.push, (times, 1)), np.tile(self.push_start, times),
            np.tile(self.slope, times), self.push_duration,
            None if self.mass is None else np.tile(self.mass, (times, 1)),
            None if self.strength is None else np.tile(self.strength, (times, 1)),
        )  # fmt: skip


def none(instances: int) -> Perturbations:
    """No disturbance of any instance."""
    zero, zeros = np.zeros((instances, 3)), np.zeros(instances)
    return Perturbations(zero, zero, zeros, zeros)


def drawn(robustness: Robustness, duration: float, bodies: int = 1) -> Perturbations:
    """The runs of one candidate, the same for every one of them: the first is not disturbed if there are several.

    Args:
        robustness: says how much. duration: of the simulation, s; pushes come in its last three quarters.
        bodies: whose masses differ.
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
    mass = None
    if robustness.mass > 0.0:
        mass = 1.0 + robustness.mass * generator.uniform(-1.0, 1.0, (runs, bodies)) * disturbed[:, None]
    return Perturbations(
        velocity * disturbed[:, None], push * disturbed[:, None], start, slope * disturbed, robustness.push_duration,
        mass,
    )  # fmt: skip


def with_masses(numeric: Scene, factors: Floats) -> Scene:
    """A scene of numbers whose bodies are heavier or lighter by factors (n, bodies), inertias as well."""
    bodies = {
        name: msgspec.structs.replace(
            body, mass=body.mass * factor, inertia=tuple(moment * factor for moment in body.inertia)
        )
        for (name, body), factor in zip(numeric.character.bodies.items(), factors.T, strict=True)
    }
    return msgspec.structs.replace(numeric, character=msgspec.structs.replace(numeric.character, bodies=bodies))


def with_strengths(numeric: Scene, factors: Floats) -> Scene:
    """A scene of numbers whose muscles are stronger or weaker by factors (n, muscles)."""
    muscles = {
        name: msgspec.structs.replace(muscle, f_max=muscle.f_max * factor)
        for (name, muscle), factor in zip(numeric.character.muscles.items(), factors.T, strict=True)
    }
    return msgspec.structs.replace(numeric, character=msgspec.structs.replace(numeric.character, muscles=muscles))


def with_bodies(numeric: Scene, disturbances: Perturbations) -> Scene:
    """A scene of numbers with the masses and strengths of disturbed instances."""
    if disturbances.mass is not None:
        numeric = with_masses(numeric, disturbances.mass)
    return numeric if disturbances.strength is None else with_strengths(numeric, disturbances.strength)


def combined(costs: Floats, robustness: Robustness) -> Floats:
    """Cost of each candidate, (n,), from those of its runs, (n, runs): their mean, or the worst."""
    return np.asarray(costs.mean(axis=1) if robustness.cost == "mean" else costs.max(axis=1))
