"""Coordinates of a model, as OpenSim names them, as the state of its bodies; and generalised forces the way back.

A coordinate of most joints is a coordinate of the state. Of the root, and of ball joints, coordinates are angles where
the state has a quaternion, and speeds are angular velocities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.pose import about, conjugate, euler_xyz, multiply, normalized, rotate
from warpmuscle.model.build import start_of
from warpmuscle.scene import OpenSim, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.opensim_root import root_motion, root_values, usual_root
from warpmuscle.scene.topology import topology


@dataclass(frozen=True)
class Turns:
    """Three turns in a row, each about an axis that those before have turned, in n states."""

    orientation: Floats  # (n, 4)
    turning: list[Floats]  # (n, 3) each, angular velocity by a unit of each angle's rate
    acceleration: Floats  # (n, 3) rad/s^2


@dataclass(frozen=True)
class States:
    """Bodies in n frames, and what their speeds are to the coordinates."""

    coordinates: Floats  # (n, C) of the state
    speeds: Floats  # (n, S)
    rates: Floats  # (n, S) of the speeds
    by_root: Floats  # (n, R, S_root) speeds of the root by a unit of each of its coordinates' rates
    by_ball: dict[str, Floats] = field(default_factory=dict)  # (n, 3, 3) the same of ball joints, by name


def turns(axes: Sequence[Floats], angles: Floats, rates: Floats, accelerations: Floats) -> Turns:
    """Turns by angles (n, A) about axes (3,), with their rates and accelerations."""
    orientation = np.tile([0.0, 0.0, 0.0, 1.0], (len(angles), 1))
    velocity, acceleration, turning = np.zeros((len(angles), 3)), np.zeros((len(angles), 3)), []
    for k, axis in enumerate(axes):
        own = rotate(orientation, np.broadcast_to(axis, velocity.shape))
        acceleration = acceleration + own * accelerations[:, k, None] + np.cross(velocity, own * rates[:, k, None])
        velocity = velocity + own * rates[:, k, None]
        turning.append(own)
        orientation = multiply(orientation, about(axis, angles[:, k]))
    return Turns(orientation, turning, acceleration)


class CoordinateMap:
    """Which coordinates a model has, and what they are to its state.

    Attributes:
        names: (K,) of all that move by themselves, those of the root first. units: (K,) rad or m.
        roots: how many are the root's. default: (K,) where they are if a motion does not say.
        speed: (K,) number of the speed that a coordinate's rate is; -1 where it is none alone.
    """

    def __init__(self, scene: Scene) -> None:
        """Args: scene: without free parameters."""
        self.scene, self.topology = scene, topology(scene.character)
        self.opensim: OpenSim = scene.opensim or usual_root(scene.character)
        self._balls: dict[str, tuple[int, list[Floats]]] = {}  # by joint: first coordinate, and axes of its angles
        self._singles: list[tuple[int, int, int]] = []  # coordinate, of the state, speed
        names = list(self.opensim.root_coordinates)
        speed = [-1] * len(names)
        self.roots = len(names)
        turning = 0 if self.opensim.root is None else len(self.opensim.root.rotations)
        units = ["rad"] * turning + ["m"] * (self.roots - turning)
        for number, name in enumerate(self.topology.joints, start=1):
            joint, first = scene.character.joints[name], len(names)
            kind = joint_type(joint)
            if not kind.moves:
                continue
            own, axes = self._names_of(name)
            if kind.quaternion:
                self._balls[name] = first, axes
                speed += [-1] * len(own)
            else:
                place, at = self.topology.coordinate_start[number], self.topology.speed_start[number]
                self._singles += [(first + k, place + k, at + k) for k in range(len(own))]
                speed += [at + k for k in range(len(own))]
            names += own
            units += [kind.unit(joint)] * len(own)
        self.names, self.units, self.speed = tuple(names), tuple(units), np.array(speed, dtype=np.int64)
        self.default = self._default()

    def _names_of(self, name: str) -> tuple[list[str], list[Floats]]:
        """Names of a joint's coordinates, and of a ball joint the axes that they turn about."""
        joint = self.scene.character.joints[name]
        kind = joint_type(joint)
        ball = self.opensim.balls.get(name)
        if ball is not None:
            swing, twist = (axis[0] for axis in kind.frame(joint))
            return list(ball.names), [swing, np.cross(swing, twist) * (-1.0 if ball.turned_round else 1.0), twist]
        if self.scene.opensim is not None and not kind.quaternion:
            return [name], []
        return [f"{name}_{word}".rstrip("_") for word in kind.angles], list(np.eye(3))

    def _default(self) -> Floats:
        start = start_of(self.scene, self.topology).coordinates[:1].astype(np.float64)
        found = np.zeros(len(self.names))
        for coordinate, place, _ in self._singles:
            found[coordinate] = start[0, place]
        root = root_type(self.scene.character).motion(start[:, : self.topology.coordinate_start[1]])
        if self.roots:
            found[: self.roots] = root_values(self.opensim, root.place, root.orientation)[0]
        return found

    def states(self, values: Floats, rates: Floats, accelerations: Floats) -> States:
        """The state at coordinates (n, K), rad and m, which change so; also accelerations of its speeds."""
        names, count = self.topology, len(values)
        q, v, a = np.zeros((count, names.coordinates)), np.zeros((count, names.speeds)), np.zeros((count, names.speeds))
        by_root = self._root(values, rates, accelerations, q, v, a)
        by_ball = {}
        for name, (first, axes) in self._balls.items():
            own = slice(first, first + 3)
            found = turns(axes, values[:, own], rates[:, own], accelerations[:, own])
            body = names.body_of_joint(name)
            back = conjugate(found.orientation)
            by_ball[name] = np.stack([rotate(back, axis) for axis in found.turning], axis=1)
            q[:, names.coordinates_of(body)] = found.orientation
            v[:, names.speeds_of(body)] = np.einsum("nks,nk->ns", by_ball[name], rates[:, own])
            a[:, names.speeds_of(body)] = rotate(back, found.acceleration)
        for coordinate, place, speed in self._singles:
            q[:, place], v[:, speed], a[:, speed] = (
                values[:, coordinate], rates[:, coordinate], accelerations[:, coordinate],
            )  # fmt: skip
        return States(q, v, a, by_root, by_ball)

    def _root(self, values: Floats, rates: Floats, accelerations: Floats, q: Floats, v: Floats, a: Floats) -> Floats:
        """Put the root's part into a state; its speeds (n, R, S) by a unit of each coordinate's rate."""
        kind, own = root_type(self.scene.character), self.roots
        place, speeds = slice(0, self.topology.coordinate_start[1]), slice(0, self.topology.speed_start[1])
        joint = self.opensim.root
        if joint is None or not own:
            q[:, place] = start_of(self.scene, self.topology).coordinates[:1, place]
            return np.zeros((len(values), 0, speeds.stop))
        at = root_motion(self.opensim, values[:, :own])
        axes, slopes = [], []
        for one in joint.rotations:
            axes.append(np.asarray(normalized(rows(one.axis))[0]))
            slopes.append(first_number(one.slope))
        count = len(axes)
        shift = np.array([first_number(one.value) for one in joint.rotations])
        slope = np.array(slopes)
        turned = turns(
            axes, shift + slope * values[:, :count], slope * rates[:, :count], slope * accelerations[:, :count]
        )
        angular = np.einsum("nks,nk->ns", at.turning, rates[:, :own])
        arm = -rotate(at.orientation, rows(joint.position_in_child))
        shifts = at.moving - np.cross(at.turning, arm[:, None])  # of the joint's point alone
        linear = np.einsum("nks,nk->ns", shifts, accelerations[:, :own])
        linear = linear + np.cross(turned.acceleration, arm) + np.cross(angular, np.cross(angular, arm))
        moving = np.einsum("nks,nk->ns", at.moving, rates[:, :own])
        q[:, place], v[:, speeds] = kind.coordinates_of(at.position, at.orientation, moving, angular)
        a[:, speeds] = kind.coordinates_of(at.position, at.orientation, linear, turned.acceleration)[1]
        return np.stack(
            [
                kind.coordinates_of(at.position, at.orientation, at.moving[:, k], at.turning[:, k])[1]
                for k in range(own)
            ],
            axis=1,
        )

    def values(self, q: Floats) -> Floats:
        """Coordinates (n, K), rad and m, of states (n, C)."""
        found = np.zeros((len(q), len(self.names)))
        if self.roots:
            root = root_type(self.scene.character).motion(q[:, : self.topology.coordinate_start[1]])
            found[:, : self.roots] = root_values(self.opensim, root.place, root.orientation)
        for name, (first, axes) in self._balls.items():
            joint = self.scene.character.joints[name]
            turn = normalized(q[:, self.topology.coordinates_of(self.topology.body_of_joint(name))])
            if name in self.opensim.balls:
                angles = joint_type(joint).angles_of(joint, turn)
                sign = -1.0 if self.opensim.balls[name].turned_round else 1.0
                found[:, first : first + 3] = angles * [1.0, sign, 1.0]
            else:
                found[:, first : first + len(axes)] = euler_xyz(turn)
        for coordinate, place, _ in self._singles:
            found[:, coordinate] = q[:, place]
        return found

    def forces(self, effort: Floats, states: States) -> Floats:
        """Generalised forces (n, K) of coordinates from those of speeds (n, S)."""
        found = np.zeros((len(effort), len(self.names)))
        found[:, : self.roots] = np.einsum("nks,ns->nk", states.by_root, effort[:, : self.topology.speed_start[1]])
        for name, (first, _) in self._balls.items():
            own = effort[:, self.topology.speeds_of(self.topology.body_of_joint(name))]
            found[:, first : first + 3] = np.einsum("nks,ns->nk", states.by_ball[name], own)
        for coordinate, _, speed in self._singles:
            found[:, coordinate] = effort[:, speed]
        return found

    def coordinate_of(self, speed: int) -> str:
        """Name of the coordinate that a speed is the rate of, or that goes with it in a ball joint."""
        alone = np.flatnonzero(self.speed == speed)
        if len(alone):
            return self.names[int(alone[0])]
        for name, (first, _) in self._balls.items():
            own = self.topology.speeds_of(self.topology.body_of_joint(name))
            if own.start <= speed < own.stop:
                return str(self.names[first + speed - own.start])
        return self.names[min(speed, self.roots - 1)]
