"""Musculotendon units in float64: OpenSim's tables, and fibre and tendon integrated in fine steps."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from probes import evaluate

from warpmuscle.kernels.curve import curves
from warpmuscle.kernels.curve.curves import MILLARD, THELEN
from warpmuscle.kernels.muscle import muscle

PROPERTIES = {  # N, m, m, rad
    "BIClong": (624.3, 0.1157, 0.2723, 0.0),
    "TRIlong": (798.52, 0.134, 0.143, 0.20943951),
    "soleus": (3549.0, 0.05, 0.25, 0.43633231),
    "DELT1": (1142.6, 0.0976, 0.093, 0.38397244),
    "ECU": (93.2, 0.0622, 0.2285, 0.06981317),
}
OPENSIM = {THELEN: "Thelen2003Muscle", MILLARD: "Millard2012EquilibriumMuscle"}


@dataclass
class States:
    """States of muscles in OpenSim; forces over f_max, speeds over v_max."""

    l_opt: np.ndarray
    l_slack: np.ndarray
    width: np.ndarray
    activation: np.ndarray
    length: np.ndarray
    speed: np.ndarray
    mt_length: np.ndarray
    force: np.ndarray


def opensim_states(reference_data: Path, model: int, kind: str) -> States:
    """Rows of a table with fibre speeds up to v_max."""
    file = reference_data / "opensim_reference" / f"hill_{OPENSIM[model]}_{kind}.csv"
    t = np.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding=None)
    t = t[np.abs(t["norm_fiber_velocity"]) < 1.0]
    names = [next(name for name in PROPERTIES if row.startswith(name)) for row in t["muscle"]]
    f_max, l_opt, l_slack, pennation = np.array([PROPERTIES[name] for name in names]).T
    length, speed, force = t["fiber_length_m"], t["norm_fiber_velocity"], t["tendon_force_N"] / f_max
    width = l_opt * np.sin(pennation)
    return States(l_opt, l_slack, width, t["activation"], length, speed, t["mt_length_m"], force)


class Reference:
    """Fibres and tendons by Heun's method on curves interpolated in float64; arrays are (units,)."""

    def __init__(self, model: int, activation, l_opt: float, l_slack, width, v_max: float, damping: float) -> None:
        """Tabulate the curves of a model."""
        self.activation, self.l_opt, self.l_slack, self.width = activation, l_opt, l_slack, width
        self.v_max, self.damping = v_max, damping
        self.x, self.v, self.strain = (
            np.linspace(0, 2.5, 20001),
            np.linspace(-1, 1, 10001),
            np.linspace(-0.1, 0.3, 40001),
        )
        self.active = evaluate(curves.active_force_length, model, self.x)
        self.passive = evaluate(muscle.bounded_passive, model, self.x)
        self.tendon = evaluate(curves.tendon_force_strain, model, self.strain)
        self.levels = np.unique(activation)
        self.velocity = [evaluate(curves.force_velocity_slope, model, self.v, a).T for a in self.levels]

    def force(self, mt_length: np.ndarray, length: np.ndarray) -> np.ndarray:
        """Of the tendon."""
        strain = (mt_length - self.l_slack - np.sqrt(length**2 - self.width**2)) / self.l_slack
        return np.interp(strain, self.strain, self.tendon)

    def speed(self, mt_length: np.ndarray, length: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """Of the fibre over v_max, by Newton's method."""
        cosine, x, v = np.sqrt(1.0 - (self.width / length) ** 2), length / self.l_opt, guess
        active = self.activation * np.interp(x, self.x, self.active)
        rest = np.interp(x, self.x, self.passive) - self.force(mt_length, length) / cosine
        value, slope = np.empty_like(length), np.empty_like(length)
        for _ in range(4):
            for level, table in zip(self.levels, self.velocity, strict=True):
                chosen = self.activation == level
                value[chosen] = np.interp(v[chosen], self.v, table[0])
                slope[chosen] = np.interp(v[chosen], self.v, table[1])
            excess = active * value + rest + self.damping * v
            v = np.clip(v - excess / np.maximum(active * slope + self.damping, 1e-3), -1.0, 1.0)
        return v

    def forces(self, path: np.ndarray, length: np.ndarray, time_step: float) -> np.ndarray:
        """Forces (steps + 1, units) for lengths of the units (steps + 1, units), from a fibre length."""
        v, scale, forces = np.zeros_like(length), time_step * self.v_max * self.l_opt, [self.force(path[0], length)]
        for now, then in pairwise(path):
            v = self.speed(now, length, v)
            length = length + scale * 0.5 * (v + self.speed(then, length + scale * v, v))
            forces.append(self.force(then, length))
        return np.array(forces)
