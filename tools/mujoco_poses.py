"""Poses of a MuJoCo model and what MuJoCo computes in them, for `mujoco_agreement.py`.

Coordinates are those of hinges and slides that no equality makes functions of others, and of a free root. Where MuJoCo
lets such equalities give way a little, they hold exactly here: with q = f(free q), from MuJoCo's own mass matrix,
forces and moment arms (virtual work).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.pose import rotate
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.mujoco.muscles import ON_TENDON
from warpmuscle.formats.mujoco.reference import FREE, HINGE, SLIDE, Reference
from warpmuscle.formats.mujoco.skeleton import followers, held_joints
from warpmuscle.formats.mujoco.tendons import JOINT

Floats = NDArray[np.float64]
OFF = ("CONTACT", "LIMIT", "EQUALITY", "FRICTIONLOSS")  # what is not compared
ROOM, RATE, SLIDING = 1.0, 2.0, 0.05  # rad, of a hinge without a range; rad/s; of these for lengths, m/s


@dataclass
class Poses:
    """States of N poses, and what MuJoCo says of them; F free coordinates, with the six of a free root first."""

    names: list[str]  # (F,) of joints in the scene; "root" of a free root's
    q: Floats  # (N, F) values, of a free root nothing
    v: Floats  # (N, F)
    root: Floats  # (N, 13) position, orientation xyzw, velocity, angular velocity of the root's centre of mass
    activation: Floats  # (N, M)
    muscles: list[str]
    length: Floats  # (N, M) m
    speed: Floats  # (N, M)
    arm: Floats  # (N, M, F) m, length by free coordinate
    force: Floats  # (N, M) N
    acceleration: Floats  # (N, F)


class NotCompared(Exception):
    """A model has what is not compared."""


class Oracle:
    """A model and its free coordinates."""

    def __init__(self, path: Path) -> None:
        self.model = mujoco.MjModel.from_xml_path(str(path))
        for name in OFF:
            self.model.opt.disableflags |= getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}")
        held = held_joints(self.model)
        self.reference = Reference(self.model, path, Notes(), held)
        self.follows = followers(self.model, str)
        kinds = self.model.jnt_type
        self.free = [k for k in range(self.model.njnt) if k not in held and k not in self.follows and kinds[k] != FREE]
        if set(kinds[self.free]) - {HINGE, SLIDE}:
            raise NotCompared("loads; ball joints are not compared")
        self.roots = [k for k in range(self.model.njnt) if kinds[k] == FREE]
        if len(self.roots) > 1:
            raise NotCompared("loads; several free joints are not compared")
        self.held = held
        self.muscles = [k for k in range(self.model.nu) if self.model.actuator_dyntype[k] == 4]

    def keep(self, names: set[str]) -> None:
        """Compare these muscles alone; the others pull on nothing."""
        self.muscles = [k for k in self.muscles if (self.model.actuator(k).name or f"actuator{k}") in names]

    def poses(self, count: int, seed: int) -> Poses:
        """Draw states and compute."""
        random = np.random.default_rng(seed)
        model, first = self.model, 6 * len(self.roots)
        size = first + len(self.free)
        found = Poses(
            ["root"] * first + [self.reference.name("joint", k) for k in self.free], np.zeros((count, size)),
            np.zeros((count, size)), np.zeros((count, 13)), random.uniform(0.0, 1.0, (count, len(self.muscles))),
            [model.actuator(k).name or f"actuator{k}" for k in self.muscles], np.zeros((count, len(self.muscles))),
            np.zeros((count, len(self.muscles))), np.zeros((count, len(self.muscles), size)),
            np.zeros((count, len(self.muscles))), np.zeros((count, size)),
        )  # fmt: skip
        for column, joint in enumerate(self.free, start=first):
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-ROOM, ROOM)
            length = SLIDING if model.jnt_type[joint] == SLIDE else 1.0
            found.q[:, column] = random.uniform(low, high, count)
            found.v[:, column] = random.normal(0.0, RATE * length, count)
        data = mujoco.MjData(model)
        for number in range(count):
            self._one(found, number, data, random)
        return found

    def _one(self, found: Poses, number: int, data: Any, random: np.random.Generator) -> None:
        model, first = self.model, 6 * len(self.roots)
        size = found.q.shape[1]
        jacobian, drift = np.zeros((model.nv, size)), np.zeros(model.nv)
        data.qpos[:], data.qvel[:] = model.qpos0, 0.0
        for joint in self.roots:
            self._root(found, number, data, joint, random)
            jacobian[model.jnt_dofadr[joint] : model.jnt_dofadr[joint] + 6, :6] = np.eye(6)
        for column, joint in enumerate(self.free, start=first):
            data.qpos[model.jnt_qposadr[joint]] = found.q[number, column]
            jacobian[model.jnt_dofadr[joint], column] = 1.0
        for joint, value in self.held.items():
            data.qpos[model.jnt_qposadr[joint]] = value
        for joint, (driver, coefficients) in self.follows.items():
            column, function = first + self.free.index(driver), np.polynomial.Polynomial(coefficients)
            q, v = found.q[number, column], found.v[number, column]
            data.qpos[model.jnt_qposadr[joint]] = function(q)
            jacobian[model.jnt_dofadr[joint], column] = function.deriv()(q)
            drift[model.jnt_dofadr[joint]] = function.deriv(2)(q) * v**2
        data.qvel[:] = jacobian @ np.concatenate([data.qvel[:first], found.v[number, first:]])
        data.act[:] = 0.0
        for column, actuator in enumerate(self.muscles):
            data.act[model.actuator_actadr[actuator]] = found.activation[number, column]
        data.ctrl[:] = 0.0
        mujoco.mj_forward(model, data)
        self._read(found, number, data, jacobian, drift)

    def _read(self, found: Poses, number: int, data: Any, jacobian: Floats, drift: Floats) -> None:
        model = self.model
        arms = np.zeros((model.nu, model.nv))
        for k in range(model.nu):
            start, end = data.moment_rowadr[k], data.moment_rowadr[k] + data.moment_rownnz[k]
            arms[k, data.moment_colind[start:end]] = data.actuator_moment[start:end]
        gears = np.array([self._gear(k) for k in self.muscles])
        found.length[number] = data.actuator_length[self.muscles] / gears
        found.speed[number] = data.actuator_velocity[self.muscles] / gears
        found.arm[number] = arms[self.muscles] @ jacobian / gears[:, None]
        found.force[number] = -data.actuator_force[self.muscles] * gears
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        pulls = arms[self.muscles].T @ data.actuator_force[self.muscles]
        right = jacobian.T @ (pulls + data.qfrc_passive - data.qfrc_bias - mass @ drift)
        found.acceleration[number] = np.linalg.solve(jacobian.T @ mass @ jacobian, right)
        for joint in self.roots:
            self._root_rates(found, number, data, joint)

    def _gear(self, actuator: int) -> float:
        """Of an actuator of a spatial tendon, whose length counts as it is."""
        model = self.model
        spatial = model.actuator_trntype[actuator] == ON_TENDON
        spatial = spatial and model.wrap_type[model.tendon_adr[model.actuator_trnid[actuator, 0]]] != JOINT
        return float(model.actuator_gear[actuator, 0]) if spatial else 1.0

    def _root(self, found: Poses, number: int, data: Any, joint: int, random: np.random.Generator) -> None:
        """Draw the state of a free root, and what it is of its centre of mass."""
        model, axes = self.model, self.reference.axes
        at, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        turn = random.normal(size=4)
        data.qpos[at : at + 7] = np.concatenate([random.uniform(-1.0, 1.0, 3), turn / np.linalg.norm(turn)])
        data.qvel[dof : dof + 6] = random.normal(size=6)
        q, v = data.qpos[at : at + 7], data.qvel[dof : dof + 6]
        ours = np.concatenate([axes @ q[4:], q[3:4]])
        lever = rotate(ours, self.reference.moved[int(model.jnt_bodyid[joint])].center)
        spin = rotate(ours, axes @ v[3:])
        found.root[number] = np.concatenate(
            [axes @ q[:3] + lever, ours, axes @ v[:3] + np.cross(spin, lever), spin]
        )  # fmt: skip

    def _root_rates(self, found: Poses, number: int, data: Any, joint: int) -> None:
        """Put a free root's rates of speed, and moment arms, as those of its centre of mass in our axes."""
        axes, turn, spin = self.reference.axes, found.root[number, 3:7], found.root[number, 10:]
        lever = rotate(turn, self.reference.moved[int(self.model.jnt_bodyid[joint])].center)
        a = found.acceleration[number]
        alpha = rotate(turn, axes @ a[3:6])
        linear = axes @ a[:3] + np.cross(alpha, lever) + np.cross(spin, np.cross(spin, lever))
        found.acceleration[number, :6] = np.concatenate([linear, alpha])
        found.arm[number, :, :6] = 0.0  # a path within the body has none about its root
