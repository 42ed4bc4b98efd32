"""Muscle reflexes in NumPy and float64, leg by leg, from a recording with a frame a step."""

from __future__ import annotations

import numpy as np
from probes import matrix

from warpmuscle.core.pose import twist_angle
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Reflex, Reflexes, Scene

PARTS = {"all": lambda x: x, "positive": lambda x: max(x, 0.0), "negative": lambda x: min(x, 0.0)}


def term(reflex: Reflex, signal: float, rate: float, phases: set[str], loads: dict[str, float]) -> float:
    """What a reflex adds to an excitation; `phases` are those that its leg is in, `loads` factors by name."""
    moves = {"either": True, "rising": rate > 0.0, "falling": rate < 0.0}
    if reflex.during not in phases or not moves[reflex.moving]:
        return 0.0
    return reflex.gain * PARTS[reflex.part](signal - reflex.offset + reflex.lead * rate) * loads[reflex.times]


class Legs:
    """What both legs feel, step after step."""

    def __init__(self, reflexes: Reflexes) -> None:
        self.reflexes = reflexes
        self.stands, self.landed, self.lean_at_lift = [False, False], 0, [0.0, 0.0]

    def feel(self, loads: list[float], lean: float, stance: int) -> None:
        """Take in the loads in body weights, and the trunk's lean."""
        for side in (1 - stance, stance):
            stands = loads[side] > self.reflexes.stance_load
            if stands and not self.stands[side]:
                self.landed = side
            if self.stands[side] and not stands:
                self.lean_at_lift[side] = lean
            self.stands[side] = stands

    def phases(self, side: int) -> set[str]:
        """The phases that a leg is in."""
        if not self.stands[side]:
            return {"always", "swing"}
        trailing = self.stands[1 - side] and self.landed != side
        return {"always", "stance", "trailing"} if trailing else {"always", "stance"}


def leans(motion: Recording, trunk: str) -> np.ndarray:
    """Forward lean of the trunk, a child of the root, and its rate, (F, 2)."""
    body = motion.body_names.index(trunk)
    up = matrix(motion.body_orientation[:, body].astype(float))[:, :, 1]
    about_root = matrix(motion.root_orientation.astype(float)) @ motion.joint_angular_velocity[:, body - 1, :, None]
    yaw = 2.0 * np.arctan2(motion.root_orientation[:, 1], motion.root_orientation[:, 3])
    across = [(np.sin(yaw), np.cos(yaw)), (np.cos(yaw), -np.sin(yaw))]
    forward, left = (np.stack([x, np.zeros_like(x), z], axis=1) for x, z in across)
    rate = np.sum((motion.root_angular_velocity + about_root[:, :, 0]) * left, axis=1)
    return np.stack([np.arctan2(np.sum(up * forward, axis=1), up[:, 1]), rate], axis=1)


def excitations(scene: Scene, motion: Recording, weight: float) -> np.ndarray:
    """Excitations (F, M) before their delays; those of muscles without reflexes are not numbers."""
    assert scene.controller is not None
    assert scene.controller.reflexes is not None
    reflexes, muscles = scene.controller.reflexes, motion.muscle_names
    own = [scene.character.muscles[name] for name in muscles]
    l_opt, f_max = (np.array([getattr(m, field) for m in own]) for field in ("l_opt", "f_max"))
    length, speed = motion.muscle_fibre_length / l_opt, motion.muscle_fibre_velocity / l_opt
    force = motion.muscle_force / f_max
    ground = np.stack([motion.foot_force_left[:, 1], motion.foot_force_right[:, 1]], axis=1)
    loads = np.maximum(ground, 0.0) / weight
    lean = leans(motion, reflexes.trunk)
    legs = Legs(reflexes)
    result = np.full((len(motion.time), len(muscles)), np.nan)
    for k in range(len(motion.time)):
        legs.feel(list(loads[k]), lean[k, 0], int(motion.stance[k]))
        for m, name in enumerate(muscles):
            side = "lr".index(name[0])
            total, known = 0.0, reflexes.muscles.get(name[1:], {})
            factors = {"once": 1.0, "load": loads[k, side], "other_load": loads[k, 1 - side]}
            for reflex in known.values():
                source = muscles.index(name[0] + reflex.of) if reflex.of and reflex.signal != "angle" else m
                rate = 0.0
                if reflex.signal in ("force", "length", "velocity"):
                    if k == 0:
                        continue
                    table = {"force": force, "length": length, "velocity": speed}[reflex.signal]
                    signal, rate = table[k - 1, source], speed[k - 1, source] if reflex.signal == "length" else 0.0
                elif reflex.signal == "angle":
                    joint = motion.joint_names.index(name[0] + reflex.of)
                    axis = np.array(scene.character.joints[name[0] + reflex.of].axes[0], float)
                    signal = float(twist_angle(motion.joint_orientation[k : k + 1, joint].astype(float), axis)[0])
                    rate = float(motion.joint_angular_velocity[k, joint] @ axis)
                elif reflex.signal == "lean":
                    signal, rate = lean[k]
                else:
                    signal = {
                        "constant": 1.0, "lean_at_lift": legs.lean_at_lift[side], "load": loads[k, side],
                        "other_load": loads[k, 1 - side],
                    }[reflex.signal]  # fmt: skip
                total += term(reflex, signal, rate, legs.phases(side), factors)
            if known:
                result[k, m] = np.clip(total, reflexes.least, 1.0)
    return result
