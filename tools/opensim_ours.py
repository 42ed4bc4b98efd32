"""What warpmuscle computes of a scene from an OpenSim model, in OpenSim's coordinates: for `opensim_agreement.py`."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.pose import rotate
from warpmuscle.scene import Muscle, MuscleModel, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.opensim_root import root_motion
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.skeleton import weightless
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

Floats = NDArray[np.float64]
BATCH = 2000  # poses at once
STEP = 1e-6  # of differences
PATH_STEP = 5e-3  # rad or m, of differences of lengths in single precision
INSTANT = 1e-7  # s, a step in which no activation changes, ...
SLOW = 0.04  # s, of activation, if it takes this time


class Ours:
    """A scene whose states are given in coordinates of OpenSim, K of them, of which I are independent."""

    def __init__(self, scene: Scene, coordinates: list[str], independent: list[int]) -> None:
        """Find each coordinate among the scene's.

        Raises:
            SystemExit: the scene has no coordinate of a name, or one more than the model.
        """
        self.scene = msgspec.structs.replace(scene, time_step=INSTANT, duration=INSTANT)
        self.bare, self.held = bare(scene), slow(self.scene)
        self.stages: Stages | None = None
        self.names, self.coordinates, self.independent = topology(scene.character), coordinates, independent
        self.opensim = scene.opensim
        moved = [coordinates[k] for k in independent]
        self.root = [coordinates.index(name) for name in self.opensim.root_coordinates]
        self.own = {}  # number of a coordinate: place among the scene's coordinates and speeds
        for body, name in enumerate(self.names.joints, start=1):
            if self.names.speed_start[body + 1] > self.names.speed_start[body]:
                if name not in moved and name not in scene.motion:
                    raise SystemExit(f"the scene's joint {name!r} has no independent coordinate of that name")
                place = self.names.coordinate_start[body], self.names.speed_start[body]
                self.own[coordinates.index(name)] = place
        known = {coordinates[k] for k in (*self.root, *self.own)}
        if missing := [name for name in moved if name not in known]:
            raise SystemExit(f"the scene has no coordinate {', '.join(missing)}")

    @property
    def muscles(self) -> list[str]:
        """Names of all muscles."""
        return list(self.scene.character.muscles)

    def places(self, q: Floats) -> Floats:
        """The scene's coordinates (n, C) at OpenSim's (n, K)."""
        found = np.zeros((len(q), self.names.coordinates))
        motion = root_motion(self.opensim, q[:, self.root])
        if self.names.coordinate_start[1] == 7:
            found[:, :7] = np.concatenate([motion.position, motion.orientation], axis=1)
        else:
            angle = 2.0 * np.arctan2(motion.orientation[:, 0], motion.orientation[:, 3])
            found[:, :3] = np.column_stack([motion.position[:, 1:], angle])
        for k, (place, _) in self.own.items():
            found[:, place] = q[:, k]
        return found

    def rates(self, q: Floats) -> Floats:
        """The scene's speeds for a unit rate of each independent coordinate, (n, S, I)."""
        found = np.zeros((len(q), self.names.speeds, len(self.independent)))
        motion, first = root_motion(self.opensim, q[:, self.root]), self.names.speed_start[1]
        both = np.concatenate([motion.moving, motion.turning], axis=2)  # (n, R, 6)
        chosen = {6: [0, 1, 2, 3, 4, 5], 3: [1, 2, 3], 0: []}[first]
        for column, k in enumerate(self.independent):
            if k in self.root:
                found[:, :first, column] = both[:, self.root.index(k)][:, chosen]
            else:
                found[:, self.own[k][1], column] = 1.0
        return found

    def paths(self, q: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        """Lengths and lengthening speeds (n, M), and moment arms (n, M, I) by virtual work, as the device has them."""
        parts = [self._paths(q[at], rate[at]) for at in batches(len(q))]
        length, speed, arm = (np.concatenate(part) for part in zip(*parts, strict=True))
        return length, speed, arm

    def lengths(self, q: Floats) -> Floats:
        """(n, M) m."""
        parts = []
        for at in batches(len(q)):
            stages = self._stages(q[at], np.zeros_like(q[at]))
            parts.append(stages.muscle_paths().length[: len(q[at])])
        return np.concatenate(parts).astype(np.float64)

    def slopes(self, q: Floats) -> Floats:
        """(n, M, I) m, -dl/dq by central differences of lengths."""
        found = np.zeros((len(q), len(self.muscles), len(self.independent)))
        for column, k in enumerate(self.independent):
            move = PATH_STEP * np.eye(q.shape[1])[k]
            found[:, :, column] = (self.lengths(q - move) - self.lengths(q + move)) / (2.0 * PATH_STEP)
        return found

    def _stages(self, q: Floats, rate: Floats, scene: Scene | None = None) -> Stages:
        """The poses and rates on the device, of the scene without its muscles' own values, or another one."""
        count, scene = len(q), scene or self.bare
        if self.stages is None or self.stages.instances < count or self.posed is not scene:
            self.stages, self.posed = Stages(scene, count, "cpu"), scene
        full = self.stages.instances
        places, rates = self.places(q), self.rates(q)
        speeds = np.einsum("nsi,ni->ns", rates, rate[:, self.independent])
        for target, values in ((self.stages.state.coordinates, places), (self.stages.state.speeds, speeds)):
            padded = np.concatenate([values, np.repeat(values[-1:], full - count, axis=0)])
            target.assign(padded.astype(np.float32))
        return self.stages

    def _paths(self, q: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        count = len(q)
        stages = self._stages(q, rate)
        paths, bodies = stages.muscle_paths(), stages.forward_kinematics()["orientation"][:count].astype(float)
        arm = np.zeros((count, len(self.muscles), len(self.independent)))
        columns = {self.coordinates[k]: column for column, k in enumerate(self.independent)}
        places = self.places(q)
        for crossing, (muscle, joint) in enumerate(zip(paths.muscle, paths.joint, strict=True)):
            name = self.names.joints[joint]
            if name not in columns:
                continue
            kind, entry = joint_type(self.scene.character.joints[name]), self.scene.character.joints[name]
            own = places[:, self.names.coordinate_start[joint + 1] : self.names.coordinate_start[joint + 2]]
            about = rotate(bodies[:, self.names.parents[joint + 1]], kind.pulled_about(entry, own)[0])
            pulled = paths.moment_arm[:count, crossing].astype(float)
            arm[:, muscle, columns[name]] -= np.sum(pulled * about, axis=1)
        return paths.length[:count].astype(float), paths.speed[:count].astype(float), arm

    def dynamics(self, q: Floats, rate: Floats, acceleration: Floats) -> tuple[Floats, Floats, Floats]:
        """Mass matrix (n, I, I), inverse dynamics and gravity (n, I) of the independent coordinates, in float64."""
        places, along = self.places(q), self.rates(q)
        v = rate[:, self.independent]
        speeds = np.einsum("nsi,ni->ns", along, v)
        ends = [self.rates(q + way * STEP * rate) for way in (-1.0, 1.0)]
        drift = np.einsum("nsi,ni->ns", (ends[1] - ends[0]) / (2.0 * STEP), v)
        accelerations = np.einsum("nsi,ni->ns", along, acceleration[:, self.independent]) + drift
        still = np.zeros_like(speeds)
        needed = inverse_dynamics(self.scene, places, speeds, accelerations)
        gravity = inverse_dynamics(self.scene, places, still, still)
        pulls = [inverse_dynamics(self.scene, places, still, along[:, :, k]) - gravity for k in range(along.shape[2])]
        mass = np.einsum("nsi,nsk->nik", along, np.stack(pulls, axis=2))
        return mass, np.einsum("nsi,ns->ni", along, needed), np.einsum("nsi,ns->ni", along, gravity)

    def forces(self, q: Floats, activation: Floats, muscles: list[str]) -> Floats:
        """Tension (n, m), N, of muscles at rest at these activations (n, m), in equilibrium with their tendons.

        Those that cross no joint that moves are not simulated, and have none: infinite.
        """
        first = self._stages(q[:BATCH], 0.0 * q[:BATCH], self.held)
        simulated = first.structure.actuation.muscles  # ligaments among them
        own = [k for k, name in enumerate(simulated) if name in muscles]
        column = [muscles.index(simulated[k]) for k in own]
        found = np.full((len(q), len(muscles)), np.inf)
        for at in batches(len(q)):
            stages, count = self._stages(q[at], np.zeros_like(q[at]), self.held), len(q[at])
            levels = np.zeros((count, len(simulated)), dtype=np.float32)
            levels[:, own] = activation[at][:, column]
            full = np.concatenate([levels, np.repeat(levels[-1:], stages.instances - count, axis=0)])
            stages.state.muscles.activation.assign(full)
            stages.state.muscles.neural.assign(full)
            stages.state.step.zero_()
            found[at, column] = stages.muscle_torques(0.0)[1]["muscle_force"][:count, own]
        return found


def bare(scene: Scene) -> Scene:
    """The scene with the paths of its muscles alone, without springs and forces."""
    muscles = {
        name: Muscle(
            f_max=1.0, l_opt=1.0, l_slack=1.0, path=muscle.path, wraps=muscle.wraps, polynomial=muscle.polynomial
        )
        for name, muscle in scene.character.muscles.items()
    }
    character = msgspec.structs.replace(scene.character, muscles=muscles)
    held = weightless(character)  # which is posed all the same
    return msgspec.structs.replace(
        scene, character=character, muscle_model=MuscleModel(), forces={}, time_step=0.001,
        actuation={name: scene.actuation[name] for name in held}, motion={name: scene.motion[name] for name in held},
    )  # fmt: skip


def slow(scene: Scene) -> Scene:
    """The scene with muscles that no step takes from the activations that they are given."""
    muscles = {
        name: muscle if muscle.rise_time is None else msgspec.structs.replace(muscle, rise_time=SLOW, fall_time=SLOW)
        for name, muscle in scene.character.muscles.items()
    }
    return msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, muscles=muscles))


def batches(count: int) -> Iterator[slice]:
    """Slices of so many poses."""
    for start in range(0, count, BATCH):
        yield slice(start, min(start + BATCH, count))
