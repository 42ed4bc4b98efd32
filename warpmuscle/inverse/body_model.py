"""A model whose bodies and muscles are evaluated in many frames at once, on a CPU or a GPU."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import warp as wp

from warpmuscle.core.arguments import as_truth
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import instance_zeros, structs_to_device, to_device
from warpmuscle.formats import SceneLike
from warpmuscle.formats.load import load, scene_of
from warpmuscle.inverse.coordinates import CoordinateMap, States
from warpmuscle.inverse.tracking.timed_forces import without_timed
from warpmuscle.kernels.inverse import inverse_dynamics as dynamics
from warpmuscle.kernels.inverse import muscle_moments
from warpmuscle.kernels.inverse.model_forces import model_forces_of
from warpmuscle.model.build import with_fields
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.muscles import muscle_kind, muscles_struct
from warpmuscle.model.path_table import path_table
from warpmuscle.model.paths import paths_struct, route_struct
from warpmuscle.scene import Muscle, Scene
from warpmuscle.scene.muscles import is_cable
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.stages import Stages

ON_CPU, ON_GPU = 256, 32768  # frames that are worked on at once


class BodyLoads(NamedTuple):
    """Forces on bodies in n frames, world axes."""

    body: list[int]  # (L,) numbers of bodies
    force: Floats  # (n, L, 3) N
    point: Floats  # (n, L, 3) m
    moment: Floats  # (n, L, 3) N m, about the point

    def beside(self, other: BodyLoads) -> BodyLoads:
        """These and others in the same frames."""
        vectors = (np.concatenate(both, axis=1) for both in zip(self[1:], other[1:], strict=True))
        return BodyLoads([*self.body, *other.body], *vectors)


class Dynamics(NamedTuple):
    """What n frames need, world axes; see `kernels.inverse.inverse_dynamics`."""

    effort: Floats  # (n, S) N and N m
    followed: Floats  # (n, S)
    moment: Floats  # (n, B, 3) N m, that each joint puts on its child, about its point
    force: Floats  # (n, B, 3) N
    position: Floats  # (n, B, 3) m, of joints
    orientation: Floats  # (n, B, 4) of bodies


class DynamicsOnDevice(NamedTuple):
    """The same as arrays on the device, of vectors and quaternions where `Dynamics` has a last axis for them."""

    effort: wp.array
    followed: wp.array
    moment: wp.array
    force: wp.array
    position: wp.array
    orientation: wp.array


@dataclass(frozen=True)
class MuscleFrames:
    """Muscles in n frames, as arrays on the device of at least so many rows."""

    length: wp.array  # (n, M) m, of paths
    speed: wp.array  # (n, M) m/s
    moment_arm: wp.array  # (n, levers) m
    fibre: wp.array  # (2, n, M) length over l_opt, speed over v_max
    active: wp.array  # (n, M) N, along the tendon at full activation
    passive: wp.array  # (n, M) N


class BodyModel:
    """A scene without free parameters, evaluated frame by frame.

    Attributes:
        scene, map, device: what it is made of. muscles: (M,) names of muscles that pull as they are activated.
        lever_muscle, lever_speed: (levers,) pairs of a muscle and a speed that it acts on, by their numbers.
        file: the `.osim` that it was read from, if any.
        apart: whether the same number of neighbouring frames lies side by side on the device, as GPU lanes fetch it.
        model_forces: whether springs, bushings and limits of the model act.
    """

    def __init__(
        self, model: SceneLike, device: str | None = None, *, trust: bool = False, model_forces: bool = False
    ) -> None:
        """Take a scene, its name or its file; paths of a `.osim` jump as OpenSim's do.

        Args:
            model_forces: let springs, bushings, limits and other passive forces of the model act, so that moments are
                what is needed beside them, as OpenSim's are unless they are excluded.
            trust: let code of muscles' curves run that the scene names; no other code of a scene matters here.

        Raises:
            SceneError: the model cannot be read, or names such code without trust. RolloutError: no such device.
        """
        self.file = Path(model) if not isinstance(model, Scene) and str(model).lower().endswith(".osim") else None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)  # of free runs, which nothing here is
            scene = load(self.file, hard_points=True, ignored=[]) if self.file else scene_of(model, trust=trust)
        plain = substitute(scene, start_values(scene))
        self.scene = msgspec.structs.replace(without_code(plain), muscle_model=plain.muscle_model)
        self.model_forces = as_truth(model_forces, "model_forces") and bool(without_timed(self.scene.forces))
        if self.model_forces:
            self.scene = msgspec.structs.replace(self.scene, forces=without_timed(self.scene.forces))
        self.map, self.device = CoordinateMap(self.scene), find_device(device)
        self.topology = self.map.topology
        character = self.scene.character
        self._muscles: dict[str, Muscle] = dict(character.muscles)
        self.muscles = tuple(self._muscles)
        self.pulls = np.array([not is_cable(muscle) for muscle in self._muscles.values()], dtype=bool)
        self.table = path_table(self._muscles, self.topology, character, couples=True)
        self.grouped = grouped_paths(self.table, self.topology, character, together=False)
        columns = np.array(self.table.levers(self.topology.speed_start), dtype=np.int64).reshape(-1, 5).T
        self._levers: Integers = columns[:3]
        self.lever_muscle, self.lever_speed = columns[3], columns[4]
        self.apart = not self.device.is_cpu
        self._stages: dict[int, Stages] = {}

    def muscle(self, name: str) -> Muscle:
        """A muscle by its name."""
        return self._muscles[name]

    def side_by_side(self, values: Floats) -> wp.array:
        """Numbers (n, k) on the device, in the order that `apart` says."""
        if not self.apart or 0 in values.shape:
            return to_device(values, float, self.device)
        return to_device(np.ascontiguousarray(values.T), float, self.device).transpose([1, 0])

    @property
    def most_frames(self) -> int:
        """Frames that are worked on at once at most."""
        return ON_CPU if self.device.is_cpu else ON_GPU

    def chunks(self, frames: int) -> Iterator[slice]:
        """Frames that are worked on at once, one after the other."""
        return (slice(first, min(first + self.most_frames, frames)) for first in range(0, frames, self.most_frames))

    def stages(self, states: States, part: slice) -> Stages:
        """Stages that have these frames, and the last one again in the places of more."""
        count = part.stop - part.start
        room = self.most_frames if count == self.most_frames else 1 << max(count - 1, 0).bit_length()
        if room not in self._stages:
            if len(self._stages) > 2:
                self._stages.pop(next(iter(self._stages)))
            stages = Stages(self.scene, room, str(self.device))
            own = {
                "muscles": muscles_struct(self.scene, self.muscles, self.device),
                "paths": paths_struct(self.table, self.grouped, self.topology, self.scene.character, self.device),
                "routes": route_struct(
                    self.table, self.grouped, self._muscles, self.topology, self.scene.character, self.device
                ),
            }
            stages.model = with_fields(stages.model, own)
            stages.state.accelerations.zero_()
            self._stages[room] = stages
        stages = self._stages[room]
        for array, values in ((stages.state.coordinates, states.coordinates), (stages.state.speeds, states.speeds)):
            array.assign(filled(values[part], room))
        return stages

    def dynamics(self, states: States, loads: BodyLoads) -> Dynamics:
        """Inverse dynamics of all frames, without muscles."""
        along = None
        if self.model_forces:
            along, own = self.forces_of_model(states)
            loads = loads.beside(own)
        chunks = self.chunks(len(states.coordinates))
        parts = [[one.numpy() for one in self.dynamics_on_device(states, loads, part)] for part in chunks]
        found = Dynamics(*(np.concatenate(arrays).astype(np.float64) for arrays in zip(*parts, strict=True)))
        return found if along is None else found._replace(effort=found.effort - along)

    def forces_of_model(self, states: States) -> tuple[Floats, BodyLoads]:
        """What springs, bushings and limits do in all frames: along speeds (n, S), N and N m, and on bodies."""
        count, speeds = len(self.topology.bodies), max(self.topology.speeds, 1)
        parts = []
        for part in self.chunks(len(states.coordinates)):
            stages, n = self.stages(states, part), part.stop - part.start
            shapes = [((n, speeds), float)] + [((n, count), wp.vec3)] * 3
            outputs = [wp.zeros(shape, dtype=dtype, device=self.device) for shape, dtype in shapes]
            kernel = model_forces_of(stages.structure.force_kinds)
            inputs = [stages.model, stages.state, stages.workspace, stages.force_extensions]
            wp.launch(kernel, n, inputs, outputs, device=self.device)
            parts.append([array.numpy().astype(np.float64) for array in outputs])
        along, *vectors = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        return along, BodyLoads(list(range(count)), *vectors)

    def dynamics_on_device(self, states: States, loads: BodyLoads, part: slice) -> DynamicsOnDevice:
        """The same of some frames, as arrays on the device."""
        stages, n = self.stages(states, part), part.stop - part.start
        on = dynamics.BodyLoads()
        on.body = to_device(loads.body, int, self.device)
        for name in ("force", "point", "moment"):
            setattr(on, name, to_device(getattr(loads, name)[part], wp.vec3, self.device))
        bodies, speeds = len(self.topology.bodies), max(self.topology.speeds, 1)
        shapes = [((n, speeds), float)] * 2 + [((n, bodies), wp.vec3)] * 3 + [((n, bodies), wp.quat)]
        outputs = [wp.zeros(shape, dtype=dtype, device=self.device) for shape, dtype in shapes]
        rate = to_device(states.rates[part], float, self.device)
        inputs = [stages.model, stages.state, stages.workspace, rate, on]
        wp.launch(dynamics.inverse_dynamics, n, inputs, outputs, device=self.device)
        return DynamicsOnDevice(*outputs)

    def muscle_frames(self, states: States, part: slice, tendon: Floats | None = None) -> MuscleFrames:
        """Muscles in some frames, on the device.

        Args:
            tendon: (2, frames, M) lengths, m, and lengthening speeds, m/s, of tendons, in place of rigid ones.
        """
        stages, n, count = self.stages(states, part), part.stop - part.start, max(len(self.muscles), 1)

        def room(*shape: int, dtype: Any = float) -> wp.array:
            return instance_zeros((n, *shape), dtype, self.device, self.apart)

        crossings, levers = max(len(self.table.crossings), 1), len(self.lever_muscle)
        length, speed, moment_arm = room(count), room(count), room(max(levers, 1))
        arm = wp.zeros((n, crossings), dtype=wp.vec3, device=self.device)
        active, passive = room(count), room(count)
        fibre = wp.zeros((2, n, count), dtype=float, device=self.device)
        table = dict(zip(("crossing", "body", "axis"), self._levers, strict=True))
        on = (
            structs_to_device(muscle_moments.Lever, table, self.device)
            if levers
            else wp.zeros(0, dtype=muscle_moments.Lever, device=self.device)
        )
        paths = self.grouped.kind_of(self._muscles.values(), self.scene.character)
        wp.launch(
            muscle_moments.muscle_moments_of(paths), n, [stages.model, stages.state, stages.workspace, on],
            [arm, length, speed, moment_arm], device=self.device,
        )  # fmt: skip
        kind = muscle_kind(self.scene.muscle_model, self._muscles.values())
        given = np.zeros((0, 0, 0)) if tendon is None else tendon[:, part]
        wp.launch(
            muscle_moments.fibre_forces_of(kind.curves, kind.special_curves), (n, len(self.muscles)),
            [stages.model, to_device(given, float, self.device), length, speed], [fibre, active, passive],
            device=self.device,
        )  # fmt: skip
        return MuscleFrames(length, speed, moment_arm, fibre, active, passive)


def filled(values: Floats, rows: int) -> Floats:
    """So many rows in float32: the given ones, and the last one again."""
    array = np.empty((rows, *values.shape[1:]), np.float32)
    array[: len(values)] = values
    array[len(values) :] = values[-1:]
    return array
