"""What instances have come to: the terms of the objective, their parts, and the cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.status import Status
from warpmuscle.kernels import structs
from warpmuscle.model.causes import cause_words
from warpmuscle.model.objective import term_values, weighted
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.simulation.objective_parts import Parts, term_parts


@dataclass(frozen=True)
class Outcome:
    """The state of n instances, read as results."""

    names: tuple[str, ...]  # of the terms
    scene: Scene  # its numbers are floats or (n,) arrays
    structure: Structure
    state: structs.State
    start: Floats  # (1 or n, coordinates)

    def status(self) -> Integers:
        """Status of every instance, (n,)."""
        return np.asarray(self.state.status.numpy())

    def causes(self) -> tuple[str, ...]:
        """For every instance the part of the scene's own that ended it, (n,); see `Batch.causes`."""
        return cause_words(self.state.cause.numpy(), self.scene, self.structure)

    def end_time(self) -> Floats:
        """Simulated time that every instance came to, (n,), s."""
        return np.asarray(self.state.step.numpy() * self.scene.time_step)

    def distance(self) -> Floats:
        """Horizontal distance from the start, (n,), m."""
        moved = self.state.coordinates.numpy()[:, :3].astype(float) - self.start[:, :3]
        along = [moved[:, k] for k in root_type(self.scene.character).on_ground]
        return np.asarray(np.hypot(*along) if len(along) > 1 else np.abs(sum(along, np.zeros(len(moved)))))

    def terms(self) -> dict[str, Floats]:
        """Values (n,) of the terms so far, by name."""
        sums = self.structure.objective
        return term_values(self.names, self.scene, sums, self.state, self.end_time(), self.distance())

    def cost(self) -> Floats:
        """Cost of every instance, (n,); see `Batch.cost`."""
        worst, steps = self.scene.objective.failure_cost, round(self.scene.duration / self.scene.time_step)
        missed = 1.0 - self.state.step.numpy() / steps
        failed = ~np.isin(self.status(), (Status.RUNNING, Status.COMPLETED))
        return np.asarray(np.where(failed, worst * (1.0 + missed), weighted(self.scene, self.terms())))

    def parts(self, instance: int) -> dict[str, Parts]:
        """What joints and muscles have added to the terms of an instance so far, by term and name."""
        sums, muscles = self.structure.objective, self.structure.actuation.muscles
        end_time = float(self.end_time()[instance])
        names = self.structure.names
        return term_parts(self.terms(), self.scene, sums, self.state, names, muscles, instance, end_time)
