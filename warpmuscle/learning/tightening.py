"""Limits of failure that are wide, and costs that are small, while a policy begins to learn."""

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
from warpmuscle.scene.learning import Tightening
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
    part = decisions / tightening.decisions
    if part >= 1.0:
        return last
    limits = {name: first + part * (getattr(last, name) - first) for name, first in tightening.first.items()}
    return msgspec.structs.replace(last, **limits)


def costs_after(tightening: Tightening, decisions: int) -> float:
    """Share of the costs after so many decisions of all instances together."""
    first = 1.0 if tightening.costs is None else tightening.costs
    return first + min(decisions / tightening.decisions, 1.0) * (1.0 - first)
