"""Numbers of a task that are others while a policy begins to learn: limits of failure, costs, rewards."""

from __future__ import annotations

import msgspec
import numpy as np
import warp as wp

from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import structs
from warpmuscle.model.build import failure_limits
from warpmuscle.model.collisions import nearest_squared
from warpmuscle.scene import Failure
from warpmuscle.scene.learning import Task, Tightening
from warpmuscle.simulation.rollout import Rollout


class TighteningLimits:
    """The limits of a batch, in the arrays that its kernels read, so that a captured graph sees them change.

    Attributes:
        present: the limits that hold now; those of the scene until `after` says otherwise.
        costs: (1,) share of the rewards that are taken off, on the device; 1 until then.
    """

    def __init__(self, tightening: Tightening | None, rollout: Rollout, model: structs.Model) -> None:
        """Prepare; nothing changes yet.

        Args:
            model: that the instances have.

        Raises:
            SceneError: limits, or shapes that collide, are those of a variant each.
        """
        self._tightening, self._rollout, self._model = tightening, rollout, model
        self._last = self.present = rollout.numeric.failure
        self.costs = wp.full(1, 1.0, dtype=float, device=rollout.device)
        if tightening is None:
            return
        self._collides = "self_collision" in tightening.first
        if len(model.failure) > 1 or (self._collides and len(model.collisions.nearest_sq) > 1):
            raise SceneError(
                "limits of failure, or shapes that collide, follow a command that variants differ in; they cannot "
                "tighten",
                key="learning.tightening",
            )

    def after(self, decisions: int) -> None:
        """Let the limits be those after so many decisions of all instances together."""
        if self._tightening is None:
            return
        self.costs.fill_(costs_after(self._tightening, decisions))
        wanted = limits_after(self._tightening, self._last, decisions)
        if wanted == self.present:
            return
        rollout = self._rollout
        wp.copy(self._model.failure, failure_limits(wanted, rollout.device))
        if self._collides:
            depth = np.array([wanted.self_collision])
            nearest = nearest_squared(rollout.numeric, rollout.structure.collision_pairs, depth)
            wp.copy(self._model.collisions.nearest_sq, to_device(nearest, wp.vec2, rollout.device))
        self.present = wanted


def limits_after(tightening: Tightening, last: Failure, decisions: int) -> Failure:
    """Limits of failure after so many decisions of all instances together; `last` are those of the scene."""
    part = part_of(tightening, decisions)
    if part >= 1.0:
        return last
    limits = {name: first + part * (getattr(last, name) - first) for name, first in tightening.first.items()}
    return msgspec.structs.replace(last, **limits)


def costs_after(tightening: Tightening, decisions: int) -> float:
    """Share of the costs after so many decisions of all instances together."""
    first = 1.0 if tightening.costs is None else tightening.costs
    return first + part_of(tightening, decisions) * (1.0 - first)


def with_rewards(task: Task, decisions: int) -> Task:
    """The task with its rewards as they are after so many decisions of all instances together."""
    tightening = task.tightening
    if tightening is None or not (tightening.rewards or tightening.custom):
        return task
    part, last = part_of(tightening, decisions), task.rewards
    custom = {name: _between(tightening.custom.get(name, end), end, part) for name, end in last.custom.items()}
    moved = {name: _between(first, getattr(last, name), part) for name, first in tightening.rewards.items()}
    return msgspec.structs.replace(task, rewards=msgspec.structs.replace(last, custom=custom, **moved))


def part_of(tightening: Tightening, decisions: int) -> float:
    """How much of the way from the first numbers to the last has been made, 0 to 1."""
    return min(max((decisions - tightening.held) / (tightening.decisions - tightening.held), 0.0), 1.0)


def _between(first: float, last: float, part: float) -> float:
    return last if part >= 1.0 else first + part * (last - first)
