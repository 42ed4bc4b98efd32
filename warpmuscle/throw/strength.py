"""Why a goal is out of reach: how much stronger the muscles would have to be, and what torque they lack then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.studies.inverse_dynamics import inverse_dynamics
from warpmuscle.throw.motion import RATE
from warpmuscle.throw.synthesis import Throw, Thrower

FACTORS = (1.25, 1.5, 2.0, 3.0)  # of all muscles' strength, tried in turn
LEAST = 0.5  # N m; what lacks less is not worth a word


@dataclass(frozen=True)
class Missing:
    """What muscles lack for a throw that stronger ones make."""

    factor: float  # by which all muscles were stronger
    torque: dict[str, tuple[float, float, float]]  # by joint: needed and available, N m, and when, s

    def __str__(self) -> str:
        parts = [
            f"{joint} needs {needed:+.0f} N m at {time:.2f} s where the muscles make at most {most:+.0f}"
            for joint, (needed, most, time) in self.torque.items()
        ]
        return f"muscles {self.factor:g} times as strong throw it: then {'; '.join(parts) or 'no torque is lacking'}"


def what_lacks(thrower: Thrower, made: Throw) -> str:
    """What keeps a throw from its goal, in one line."""
    for factor in FACTORS:
        try:
            other = thrower.stronger(factor)
        except Error:
            return ""
        found = other.throw(made.goal, made.synergies)
        if found.met:
            return str(Missing(factor, missing_torque(thrower, found)))
    return f"muscles {FACTORS[-1]:g} times as strong do not throw it either"


def missing_torque(thrower: Thrower, made: Throw) -> dict[str, tuple[float, float, float]]:
    """By joint, where a throw needs most beyond what the muscles of a thrower make at most at its angles and speeds.

    Torques needed are the rates of the joints' momenta by inverse dynamics, and the joints' damping.
    """
    arm = thrower.follower.arm
    last = round(made.release * RATE) + 1
    angle, speed = made.replay.angle[0, :last], made.replay.speed[0, :last]
    q, v, a = (part[:last].copy() for part in thrower.recorded)
    q[:, arm.coordinate_places], v[:, arm.speed_places] = angle, speed
    a[:, arm.speed_places] = np.gradient(speed, 1.0 / RATE, axis=0)
    needed = inverse_dynamics(arm.scene, q, v, a)[:, arm.speed_places] + arm.damping * speed
    table = arm.muscle_table(arm.unknowns(thrower.values)[None])
    most, passive = (table.torques(level, angle, speed)[0] for level in (1.0, 0.0))
    active = most - passive
    upper = passive.sum(axis=1) + np.maximum(active, 0.0).sum(axis=1)
    lower = passive.sum(axis=1) + np.minimum(active, 0.0).sum(axis=1)
    found = {}
    for column in arm.free:
        beyond = np.maximum(needed[:, column] - upper[:, column], lower[:, column] - needed[:, column])
        frame = int(beyond.argmax())
        if beyond[frame] > LEAST:
            bound = upper if needed[frame, column] > upper[frame, column] else lower
            found[arm.joints[column]] = (
                float(needed[frame, column]), float(bound[frame, column]), frame / RATE,
            )  # fmt: skip
    return found
