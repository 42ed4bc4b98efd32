"""Muscle redundancy solved frame by frame: the least activations that make given joint torques.

What comes out is *computed* from a motion and a model. It is no measurement and must not be called EMG: least squares
of activations never contract antagonists against each other, people do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import lsq_linear, nnls

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of

PENALTY = 1e5  # weight of a torque error, in parts of the joint's greatest torque, against an activation of 1
TOLERANCE = 1e-6  # torque error that still counts as none, in the same parts


@dataclass(frozen=True)
class Shortage:
    """The frame in which a muscle falls short most."""

    muscle: int
    frame: int
    needed: float  # activation, > 1: so many times its active force


@dataclass(frozen=True)
class StaticOptimization:
    """Computed activations of T frames, J joints and M muscles."""

    activation: Floats  # (T, M), 0..1
    needed: Floats  # (T, M), the same without the upper bound, so that > 1 says what a muscle lacks
    torque_error: Floats  # (T, J) N m, torque made less torque asked for; 0 where the muscles suffice
    unreachable: Floats  # (T, J) N m, what is missing even without the upper bound: no muscle pulls that way
    feasible: NDArray[np.bool_]  # (T,), whether the muscles suffice

    def shortages(self) -> list[Shortage]:
        """Muscles that would have to be stronger, the weakest first; only frames where the muscles do not suffice."""
        needed = np.where(self.feasible[:, None], 0.0, self.needed)
        frames = needed.argmax(axis=0)
        found = [Shortage(m, int(t), float(needed[t, m])) for m, t in enumerate(frames) if needed[t, m] > 1.0]
        return sorted(found, key=lambda shortage: -shortage.needed)

    def explanation(self, muscles: Sequence[str], joints: Sequence[str], time: ArrayLike) -> str:
        """One line about what the muscles lack; empty if they suffice.

        Args:
            muscles: (M,) names. joints: (J,) names. time: (T,) s.
        """
        if self.feasible.all():
            return ""
        at = np.asarray(time, np.float64)
        parts = [f"{muscles[s.muscle]} lacks {s.needed - 1.0:.0%} of its force at {at[s.frame]:.3g} s"
                 for s in self.shortages()]  # fmt: skip
        for joint in np.flatnonzero(self.unreachable.any(axis=0)).tolist():
            missing = self.unreachable[:, joint]
            frame = int(np.abs(missing).argmax())
            parts.append(f"no muscle makes the {missing[frame]:+.3g} N m of {joints[joint]} at {at[frame]:.3g} s")
        count = int((~self.feasible).sum())
        return f"the muscles do not suffice in {count} of {number_of(len(self.feasible), 'frame')}: {'; '.join(parts)}"


def static_optimization(
    torque: ArrayLike, moment_arm: ArrayLike, active_force: ArrayLike, passive_force: ArrayLike
) -> StaticOptimization:
    """Activations a in 0..1 of least sum a^2 that make the torques, or come as near to them as the muscles can.

    Of each frame: moment_arm (active_force a + passive_force) = torque. Where the bounds leave no solution, the
    squared torque error, in parts of the greatest active torque of each joint, counts 1e10 times as much as sum a^2.

    Args:
        torque: (T, J) N m, to be made by the muscles.
        moment_arm: (T or 1, J, M) m, torque per tension.
        active_force: (T or 1, M) N, at full activation, at the frame's length and velocity, along the tendon.
        passive_force: (T or 1, M) N, along the tendon.

    Raises:
        Error: shapes do not fit, a value is not finite, or an active force is negative.
    """
    torque, moment_arm, active_force, passive_force = _checked(torque, moment_arm, active_force, passive_force)
    frames, muscles = active_force.shape
    gain = moment_arm * active_force[:, None, :]
    wanted = torque - np.einsum("tjm,tm->tj", moment_arm, passive_force)
    strength = np.abs(gain).sum(axis=2).max(axis=0)
    strength = np.where(strength > 0.0, strength, 1.0)
    matrix = np.concatenate(
        [PENALTY * gain / strength[:, None], np.broadcast_to(np.eye(muscles), (frames, muscles, muscles))], axis=1
    )
    target = np.concatenate([PENALTY * wanted / strength, np.zeros((frames, muscles))], axis=1)
    needed = np.array([nnls(a, b)[0] for a, b in zip(matrix, target, strict=True)]).reshape(frames, muscles)
    activation = needed.copy()
    for t in np.flatnonzero(needed.max(axis=1, initial=0.0) > 1.0):  # else the upper bound does not matter
        activation[t] = np.clip(lsq_linear(matrix[t], target[t], (0.0, 1.0), method="bvls").x, 0.0, 1.0)

    def error(solution: Floats) -> Floats:
        found = np.einsum("tjm,tm->tj", gain, solution) - wanted
        return np.where(np.abs(found) > TOLERANCE * strength, found, 0.0)

    torque_error = error(activation)
    feasible = np.asarray(~torque_error.any(axis=1))
    return StaticOptimization(activation, needed, torque_error, -error(needed), feasible)


def _checked(
    torque: ArrayLike, moment_arm: ArrayLike, active_force: ArrayLike, passive_force: ArrayLike
) -> tuple[Floats, Floats, Floats, Floats]:
    """The arrays as float64, a row a frame; raises Error."""
    wanted, arm = np.asarray(torque, np.float64), np.asarray(moment_arm, np.float64)
    if wanted.ndim != 2 or arm.ndim != 3:
        raise Error(
            f"torques are (frames, joints) and moment arms (frames or 1, joints, muscles), "
            f"not {wanted.shape} and {arm.shape}"
        )
    frames, joints = wanted.shape
    arrays = [wanted]
    for name, given, shape in (
        ("moment arms", arm, (frames, joints, arm.shape[2])),
        ("active forces", np.asarray(active_force, np.float64), (frames, arm.shape[2])),
        ("passive forces", np.asarray(passive_force, np.float64), (frames, arm.shape[2])),
    ):
        if given.shape[1:] != shape[1:] or given.shape[0] not in (1, frames):
            raise Error(f"{name} have shape {given.shape}, not {shape} or one row for all frames")
        arrays.append(np.broadcast_to(given, shape))
    for name, array in zip(("torques", "moment arms", "active forces", "passive forces"), arrays, strict=True):
        if not np.isfinite(array).all():
            raise Error(f"{name} hold a value that is not finite, in frame {np.argwhere(~np.isfinite(array))[0][0]}")
    if np.any(arrays[2] < 0.0):
        frame, muscle = np.argwhere(arrays[2] < 0.0)[0]
        raise Error(f"the active force of muscle {muscle} is negative in frame {frame}")
    return arrays[0], arrays[1], arrays[2], arrays[3]
