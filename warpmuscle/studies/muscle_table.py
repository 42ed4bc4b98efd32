"""The muscles of an arm as arrays: lengths, moment arms, forces and torques along recorded motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.warp_start import start_warp
from warpmuscle.kernels.curve.curve_sets import CURVES
from warpmuscle.kernels.muscle.muscle import rigid_force
from warpmuscle.scene import Muscle, Scene
from warpmuscle.studies.moment_arms import muscle_geometry

KEPT = 8  # sets of angles whose lengths and moment arms are kept: a fit asks for the same ones again and again


@dataclass
class PathGeometry:
    """Lengths and moment arms of all M muscles of a scene over J of its coordinates; the others stay as they are."""

    scene: Scene
    coordinates: Floats  # (C,) of the pose
    places: Sequence[int]  # (J,) of the coordinates that change
    speed_places: Sequence[int]  # (J,) of their rates
    _found: dict[bytes, tuple[Floats, Floats]] = field(default_factory=dict)

    def at(self, angle: Floats) -> tuple[Floats, Floats]:
        """Lengths (S, M), m, and moment arms (S, M, J), m, at angles (S, J)."""
        key = angle.tobytes()
        if key not in self._found:
            poses = np.tile(self.coordinates, (len(angle), 1))
            poses[:, self.places] = angle
            length, arm = muscle_geometry(self.scene, poses)
            while len(self._found) >= KEPT:
                del self._found[next(iter(self._found))]
            self._found[key] = length, arm[:, :, list(self.speed_places)]
        return self._found[key]


@dataclass(frozen=True, repr=False)
class MuscleTable(Tabulated):
    """Numbers (Z, M) of M muscles for Z sets of parameters."""

    model: int
    f_max: Floats  # N
    l_opt: Floats  # m
    l_slack: Floats  # m
    width: Floats  # m
    rest_length: Floats  # m; of muscles through points 0, as their pulleys' moment arms
    moment_arm: Floats  # (Z, M, J) m, of pulleys
    rest_angle: Floats  # (Z, M, J) rad
    v_max: float  # l_opt/s
    fibre_damping: float
    geometry: PathGeometry
    through_points: tuple[int, ...]  # places of the muscles that are

    @staticmethod
    def of(plain: Scene, joints: Sequence[str], count: int, geometry: PathGeometry) -> MuscleTable:
        """Of a scene with `count` values of what was free, or one for all."""
        table = list(plain.character.muscles.values())

        def column(get: Any) -> Floats:
            return np.stack([np.broadcast_to(np.asarray(get(m), dtype=np.float64), (count,)) for m in table], axis=1)

        def pulleys(name: str) -> Floats:
            out = np.zeros((count, len(table), len(joints)))
            for i, muscle in enumerate(table):
                for pulley in muscle.pulleys:
                    if pulley.joint in joints:
                        out[:, i, joints.index(pulley.joint)] = getattr(pulley, name)
            return out

        model = plain.muscle_model
        l_opt = column(lambda m: m.l_opt)
        return MuscleTable(
            CURVES[model.curves], column(lambda m: m.f_max), l_opt, column(lambda m: m.l_slack),
            l_opt * np.sin(column(lambda m: m.pennation)), column(_rest_length), pulleys("moment_arm"),
            pulleys("rest_angle"), first_number(model.v_max), first_number(model.damping), geometry,
            tuple(i for i, muscle in enumerate(table) if not muscle.pulleys),
        )  # fmt: skip

    def paths(self, angle: Floats) -> tuple[Floats, Floats]:
        """Lengths (Z, S, M), m, and moment arms (Z or 1, S or 1, M, J), m, at angles (S, J)."""
        through = list(self.through_points)
        arm = self.moment_arm[:, None]
        if len(through) == self.f_max.shape[1]:
            length, arm = (part[None] for part in self.geometry.at(angle))
            return length, arm
        length = self.rest_length[:, None] - np.sum(arm * (angle[None, :, None, :] - self.rest_angle[:, None]), axis=-1)
        if through:
            own_length, own_arm = self.geometry.at(angle)
            length[:, :, through] = own_length[:, through]
            arm = np.broadcast_to(arm, (len(arm), len(angle), *arm.shape[2:])).copy()
            arm[:, :, through] = own_arm[:, through]
        return length, arm

    def forces(self, activation: Floats | float, angle: Floats, speed: Floats) -> Floats:
        """Tensions (Z, S, M), N, at activations (S, M) or one for all, angles and speeds (S, J)."""
        return self._pulled(activation, angle, speed)[0]

    def torques(self, activation: Floats | float, angle: Floats, speed: Floats) -> Floats:
        """Torques (Z, S, M, J), N m, of every muscle about every joint."""
        force, arm = self._pulled(activation, angle, speed)
        return np.asarray(force[..., None] * arm)

    def _pulled(self, activation: Floats | float, angle: Floats, speed: Floats) -> tuple[Floats, Floats]:
        """Tensions and moment arms."""
        start_warp()
        length, arm = self.paths(angle)
        rate = -np.sum(arm * speed[None, :, None, :], axis=-1)
        shape = (len(self.f_max), len(angle), self.f_max.shape[1])

        def flat(values: Floats | float) -> wp.array:
            full = np.broadcast_to(np.asarray(values, dtype=np.float32), shape)
            return wp.array(full.ravel(), dtype=float, device="cpu")

        per_muscle = [flat(values[:, None]) for values in (self.l_opt, self.l_slack, self.width)]
        out = wp.map(
            rigid_force, self.model, flat(activation), flat(length), flat(rate), *per_muscle, self.v_max,
            self.fibre_damping,
        )  # fmt: skip
        return np.asarray(out.numpy().reshape(shape).astype(np.float64) * self.f_max[:, None]), arm


def _rest_length(muscle: Muscle) -> Any:
    if muscle.pulleys and muscle.rest_length is None:
        raise SceneError("a muscle on pulleys has a rest length", key="character.muscles")
    return 0.0 if muscle.rest_length is None else muscle.rest_length
