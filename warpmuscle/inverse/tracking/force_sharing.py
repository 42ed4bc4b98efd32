"""Static optimisation within what muscles can come to over a window of time, as of computed muscle control."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import instance_zeros, to_device
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.muscle_groups import Groups, groups_of
from warpmuscle.inverse.static_optimization import Launch
from warpmuscle.kernels.inverse import static_optimization as kernels

LEAST_RISE = 1.0e-3  # of activation over a window, with which costs are divided


class Reach(NamedTuple):
    """What n x M muscles come to over a window, under an excitation."""

    force: Floats  # (n, M) N
    activation: Floats  # (n, M)


class Shares(NamedTuple):
    """How far muscles go from one reach to another, and what they leave."""

    share: Floats  # (n, M) 0 to 1
    reserve: Floats  # (n, S) N and N m along speeds
    iterations: Integers  # (n,) -1: did not converge


class ForceSharing:
    """Shares out generalised forces among the muscles of a model.

    Attributes:
        bare: (S,) whether no muscle acts on a speed.
    """

    def __init__(self, body: BodyModel, reserve: Floats) -> None:
        """Args: reserve: (S,) strengths of reserves, N and N m."""
        self.body, self._strength = body, reserve
        self.groups: Groups = groups_of(body)
        self.bare = np.ones(body.topology.speeds, dtype=bool)
        self.bare[self.groups.coordinates] = False

    def share(self, states: States, needed: Floats, low: Reach, high: Reach) -> Shares:
        """The shares x with which forces f_low + x (f_high - f_low) make generalised forces (n, S) at least cost.

        The cost is the sum of squares of activations a_low + x (a_high - a_low), as in computed muscle control
        (Thelen, Anderson, Delp 2003); reserves count as in `kernels.inverse.static_optimization`.
        """
        parts = [self._share(states, needed, low, high, part) for part in self.body.chunks(len(needed))]
        share, multiplier, iterations = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        steps = np.where((iterations < 0).any(axis=1), -1, iterations.max(axis=1))
        return Shares(share, np.where(self.bare, 0.0, multiplier * np.square(self._strength)), steps)

    def _share(self, states: States, needed: Floats, low: Reach, high: Reach, part: slice) -> tuple[Any, ...]:
        body, device, n = self.body, self.body.device, part.stop - part.start
        muscles = body.muscle_frames(states, part)
        arms = muscles.moment_arm.numpy()[:, : len(body.lever_muscle)].astype(np.float64)
        left = needed[part].copy()
        np.subtract.at(left.T, body.lever_speed, (low.force[part][:, body.lever_muscle] * arms).T)
        rise = np.maximum(high.activation[part] - low.activation[part], LEAST_RISE)
        frames, cost = kernels.Frames(), kernels.Cost()
        frames.moment_arm = muscles.moment_arm
        frames.active = body.side_by_side(np.maximum(high.force[part] - low.force[part], 0.0))
        frames.needed, frames.reserve = body.side_by_side(left), to_device(self._strength, float, device)
        cost.gain = body.side_by_side(1.0 / np.square(rise))
        cost.shift = body.side_by_side(-low.activation[part] / rise)
        cost.exponent = 1.0
        cost.low = to_device(np.zeros(len(body.muscles)), float, device)
        cost.high = to_device(np.where(body.pulls, 1.0, 0.0), float, device)
        cost.rise, cost.fall = (body.side_by_side(np.zeros((0, 0))) for _ in range(2))
        outputs = [
            instance_zeros((n, len(body.muscles)), float, device, body.apart),
            instance_zeros((n, max(body.topology.speeds, 1)), float, device, body.apart),
            wp.zeros((n, max(self.groups.count, 1)), dtype=int, device=device),
        ]

        def kernel(real: Any) -> Any:
            most = self.groups.most_coordinates, self.groups.most_muscles
            return kernels.static_optimization_of(kernels.LINEAR, *most, False, real)

        each = np.arange(n)
        launch = Launch(
            kernel, self.groups.count, np.stack([each, each + 1]), [self.groups.on(device), frames, cost], outputs,
            device,
        )  # fmt: skip
        launch.run()
        launch.mend()
        return tuple(array.numpy().astype(np.float64 if k < 2 else np.int64) for k, array in enumerate(outputs))


def interpolated(wanted: Floats, tried: Sequence[tuple[Floats, Floats]]) -> Floats:
    """Excitations (n, M) that lead to forces, between those tried, as single precision has them.

    Args:
        tried: excitations and the forces that they lead to, the least first, the greatest last.
    """
    (a, f_a), (b, f_b) = tried[0], tried[-1]
    for excitation, force in tried[1:-1]:
        below = (force < wanted) & (force > f_a)
        above = (force >= wanted) & (force < f_b)
        a, f_a = np.where(below, excitation, a), np.where(below, force, f_a)
        b, f_b = np.where(above, excitation, b), np.where(above, force, f_b)
    part = np.clip((wanted - f_a) / np.maximum(f_b - f_a, 1e-9), 0.0, 1.0)
    return np.asarray(a + part * (b - a), np.float32).astype(np.float64)
