"""What the fused kernel records of chosen instances, frame by frame, and its translation into recordings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import attrgetter
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arguments import as_integer, as_texts
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import put, rows
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.limits import check_size
from warpmuscle.kernels import structs
from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.recording.record import RecordKind
from warpmuscle.kernels.recording.recorded import MUSCLE_PLACES
from warpmuscle.model.controllers.table import recorded_places
from warpmuscle.model.structure import Structure
from warpmuscle.results.degrees_of_freedom import with_angles_of_all, with_joint_angles
from warpmuscle.results.quantity import RawFrames
from warpmuscle.results.recorded_quantities import MUSCLE_QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.topology import coordinate_names, coordinate_units
from warpmuscle.simulation.memory import check_memory


def dtype_at(place: str) -> Any:
    """Type of the array at a place in `structs.Record`."""
    struct: Any = structs.Record
    *outer, last = place.split(".")
    for name in outer:
        struct = struct.vars[name].type
    return struct.vars[last].type.dtype


SIZES: dict[str, tuple[int | str, ...]] = {  # of what a frame has of each array of `structs.Record`
    "simbicon.phase": (),
    "simbicon.stance": (),
    "simbicon.machine_state": (),
    "memory": ("recorded",),
    "com": (2,),
    "foot_force": (2,),
    "orientation": ("bodies",),
    "position": ("bodies",),
    "angular_velocity": ("bodies",),
    "torque": ("bodies",),
    "desired_torque": ("bodies",),
    "target": ("bodies",),
    "coordinates": ("coordinates",),
    "speeds": ("speeds",),
    "muscle": (MUSCLE_PLACES, "muscles"),
    "custom": ("custom",),
}
DTYPES = {place: dtype_at(place) for place in SIZES}
FEW_BYTES = 2**28  # of recorded motion, for which there always is memory
COPIES = 3  # of a recorded motion in the memory: on the device, and twice as wide when it is read
MOTION = ("coordinates", "speeds")


def record_kind(quantities: Sequence[str] | None) -> RecordKind:
    """What a step records for the quantities that are asked for; all if None.

    Raises:
        RolloutError: an unknown name.
    """
    if quantities is None:
        return RecordKind()
    quantities = as_texts(quantities, "quantities", error=RolloutError)
    for name in quantities:
        if name not in (*MOTION, *MUSCLE_QUANTITIES):
            raise RolloutError(f"quantities: no quantity {name!r}; known: {', '.join((*MOTION, *MUSCLE_QUANTITIES))}")
    return RecordKind(False, any(name in MUSCLE_QUANTITIES for name in quantities))


def shapes(structure: Structure) -> dict[str, tuple[int, ...]]:
    """Shape of what a frame has of each array."""
    names, muscles = structure.names, structure.actuation.muscles
    sizes = {"bodies": len(names.bodies), "coordinates": names.coordinates, "speeds": names.speeds}
    sizes["muscles"], sizes["recorded"] = max(len(muscles), 1), len(structure.controller.custom.recorded)
    sizes["custom"] = len(structure.recorded_names)
    return {
        name: tuple(sizes[size] if isinstance(size, str) else size for size in shape) for name, shape in SIZES.items()
    }


def frame_steps(scene: Scene, rate: float) -> int:
    """Steps from frame to frame at so many frames a second."""
    steps = max(round(scene.duration / scene.time_step), 1)
    return max(round(min(1.0 / (rate * scene.time_step), steps)), 1)


def frame_bytes(structure: Structure) -> int:
    """Bytes of a frame in which everything is recorded."""
    of_frame = shapes(structure)
    written = [name for name in SIZES if is_written(name, structure)]
    return sum(math.prod(of_frame[name]) * int(wp.types.type_size_in_bytes(DTYPES[name])) for name in written)


def is_written(place: str, structure: Structure) -> bool:
    """Whether frames of a batch in which everything is recorded hold what has this place."""
    if place == "memory":
        return bool(structure.controller.custom.recorded)
    return "." not in place or place in recorded_places(structure.controller)


def check_room(structure: Structure, instances: int, frames: int, device: Any) -> None:
    """Raise RolloutError if the motion of so many instances is too long, or does not fit into the memory."""
    size = frame_bytes(structure) * frames
    if instances:
        check_size("frames", frames, RolloutError)
    if instances * size > FEW_BYTES:
        check_memory(instances, COPIES * size, device)


class Recorder:
    """Device arrays for the motion of chosen instances.

    Attributes:
        record: the arrays. chosen: the instances. every: steps from frame to frame. kind: what is recorded.
    """

    def __init__(
        self,
        structure: Structure,
        instances: int,
        chosen: list[int],
        every: int,
        steps: int,
        device: Any,
        kind: RecordKind = RecordKind(),  # noqa: B008, immutable
    ) -> None:
        """Room for a frame every `every` steps of a simulation of `steps` steps.

        Raises:
            RolloutError: so many frames are too long, or do not fit into the memory.
        """
        check_room(structure, len(chosen), -(-steps // every), device)
        self.names, self.muscles = structure.names, structure.actuation.muscles
        self._own = structure.recorded_names, structure.recorded_units
        self.chosen, self.every, self.kind = chosen, every, kind
        slot = np.full(instances, -1, dtype=np.int32)
        slot[chosen] = np.arange(len(chosen))
        self.record = structs.Record()
        self.record.slot = wp.array(slot, dtype=int, device=device)
        self.record.every = every if chosen else 0
        lead = (len(chosen), -(-steps // every)) if chosen else (1, 1)
        self._recorded = structure.controller.custom.recorded
        asked = [n for n in SIZES if kind.complete or n in MOTION or (n == "muscle" and kind.muscles)]
        self._kept = [n for n in asked if is_written(n, structure)]
        for name, shape in shapes(structure).items():
            room = lead if name in self._kept else (0, 0)
            put(self.record, name, wp.zeros((*room, *shape), dtype=DTYPES[name], device=device))
        rows_of_step = (lead[0] if kind.complete else 0, len(self.names.bodies))
        self.record.stiffness = wp.zeros(rows_of_step, dtype=symmetric, device=device)

    def clear(self) -> None:
        """Forget what was recorded."""
        for name in self._kept:
            if attrgetter(name)(self.record).size:
                attrgetter(name)(self.record).zero_()

    def values(self, name: str, steps: int) -> Floats:
        """A quantity of all chosen instances (chosen, frames, ...) in the first `steps` steps, float32.

        Raises:
            RolloutError: it was not recorded.
        """
        array = "muscle" if name in MUSCLE_QUANTITIES else name
        if not self.chosen:
            raise RolloutError("no instance was recorded: name some in Rollout(..., record=[...])")
        if array not in (*MOTION, "muscle") or array not in self._kept:
            raise RolloutError(f"{name!r} was not recorded: name it in Rollout(..., quantities=[...])")
        count = -(-steps // self.every)
        recorded = getattr(self.record, array).numpy()[:, :count]
        if array == "muscle":
            recorded = recorded[:, :, MUSCLE_QUANTITIES.index(name), : len(self.muscles)]
        return np.asarray(recorded)

    def values_until(self, name: str, steps: int, ended: Integers) -> Floats:
        """The same with zeros after the end of an instance, which made `ended` steps, (instances,)."""
        values, last = self.values(name, steps), ended[self.chosen]
        if (last >= steps).all():
            return values
        before = np.arange(values.shape[1]) * self.every < last[:, None]
        return np.where(before[..., None], values, np.float32(0.0))

    def instance(self, instance: int | None) -> int:
        """The number of a recorded instance, by default of the first one; RolloutError if it was not recorded."""
        if instance is None and self.chosen:
            return self.chosen[0]
        if instance is not None:
            instance = as_integer(instance, "instance", 0, error=RolloutError)
        if instance is None or instance not in self.chosen:
            which = "nothing was" if instance is None else f"instance {instance} was not"
            raise RolloutError(f"{which} recorded: name it in Rollout(..., record=[{instance or 0}])")
        return instance

    def recording(self, scene: Scene, instance: int, steps: int, start: float = 0.0) -> Recording:
        """The motion of a chosen instance over its first `steps` steps, from a time on, s, but for the last frame."""
        return with_joint_angles(self._motion(scene, instance, steps, start), scene, instance)

    def recordings(self, scene: Scene, instances: Sequence[int], steps: Sequence[int]) -> list[Recording]:
        """The same of several instances, which takes less time than one by one."""
        motions = [self._motion(scene, *of, 0.0) for of in zip(instances, steps, strict=True)]
        return with_angles_of_all(motions, scene, instances)

    def _motion(self, scene: Scene, instance: int, steps: int, start: float) -> Recording:
        """A motion without its angles by name."""
        if not self.kind.complete:
            raise RolloutError("only some quantities were recorded: take them from `Rollout.recorded`")
        names, capacity = self.names, self.record.coordinates.shape[1]
        count = min(-(-steps // self.every), capacity)
        first = max(min(math.ceil(start / (self.every * scene.time_step) - 1e-6), count - 1), 0)
        raw = self._raw(self.chosen.index(instance), first, count)
        raw["muscle"] = raw["muscle"][:, :, : len(self.muscles)]
        frames = RawFrames(
            time=np.arange(first, count) * self.every * scene.time_step,
            arrays=raw,
            parents=list(names.parents[1:]),
            root_velocity=root_type(scene.character).velocity(raw["speeds"]),
            centers=self._centers(scene, instance),
        )
        named = *coordinate_names(names, scene.character), *coordinate_units(names, scene.character)
        return Recording.from_frames(
            frames, names.joints, names.bodies, self.muscles, *named,
            tuple(name for name, _ in self._recorded), tuple(unit for _, unit in self._recorded), *self._own,
        )  # fmt: skip

    def _raw(self, row: int, first: int, count: int) -> dict[str, Floats]:
        """Frames first..count - 1 of all arrays of a row; only these leave the device."""
        arrays = {name: attrgetter(name)(self.record) for name in self._kept}
        kept = {name: array[row, first:count].numpy().astype(float) for name, array in arrays.items() if array.size}
        for name, array in arrays.items():  # of a character without joints that move
            if not array.size and array.shape[:2] > (row, 0):
                kept[name] = array.numpy()[row, first:count].astype(float)
        return {"custom": np.zeros((count - first, 0))} | kept

    def _centers(self, scene: Scene, instance: int) -> Floats:
        """Centres of mass from the joints, body axes, (bodies, 3), m."""
        zero = (0.0, 0.0, 0.0)
        joints = [scene.character.joints[name] for name in self.names.joints]
        table = rows([zero, *(list(joint.position_in_child) for joint in joints)])
        return np.asarray(-table[min(instance, len(table) - 1)])
