"""A batch of independent simulations of one scene on a device."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_number, as_text, as_whole, check_function
from warpmuscle.core.array_interop import is_array, mask_of
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.core.limits import check_size
from warpmuscle.core.status import Status, counted, words
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.kernels import structs
from warpmuscle.kernels.record import NOTHING
from warpmuscle.kernels.scratch import capacity_of, work_floats
from warpmuscle.model.build import ModelInputs, build_model, motion_of, start_of, update_model
from warpmuscle.model.extensions import extensions_struct, put_parameters
from warpmuscle.model.muscles import compiled_kind
from warpmuscle.model.objective import term_values, wanted, weighted
from warpmuscle.model.prescribed_motion import moved
from warpmuscle.model.state import state_struct
from warpmuscle.model.structure import structure_of
from warpmuscle.model.user_functions import check_custom
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.parameters import Parameter, free_parameters, start_values, substitute
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.batch_input import (
    checked_threads,
    checked_values,
    chosen,
    chunk_steps,
    end_step,
    positive,
    root_noise,
)
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.extensions import Extensions
from warpmuscle.simulation.inputs import Inputs
from warpmuscle.simulation.launcher import GPU_BLOCK, WARP, KernelConfig, Launcher, usual_lanes
from warpmuscle.simulation.memory import InstanceBytes, bytes_of, check_memory, repeated, struct_bytes
from warpmuscle.simulation.objective_parts import Parts, term_parts
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.recorder import Frames, frame_bytes, record_kind
from warpmuscle.simulation.reference_gait import reference_of
from warpmuscle.simulation.stepping import Stepped

FEW = 8192  # instances, some 0.3 GiB, for which there always is memory, so that nobody has to find out about it
FEW_BYTES = 2**28  # of recorded motion, the same
RECORDED_COPIES = 3  # of a recorded motion in the memory: on the device, and twice as wide when it is read
QUICK = 0.05  # s of wall time; a chunk that is over sooner and that all come through is followed by a longer one
Progress = Callable[["Rollout"], None]
in_silence = np.errstate(over="ignore", divide="ignore", invalid="ignore")  # of numbers that will diverge


class Rollout(Stepped):
    """Independent simulations of one scene, each with its own parameters, stepped together on one device.

    Instances that fail stop; the others go on undisturbed. The same parameters give the same bits on the same kind of
    device whatever the number of instances, the instance's place among them, or the number of CPU threads.

    Example:
        rollout = Rollout(load("fwalk"), instances=100)
        rollout.set_parameters(candidates)  # (100, parameters)
        rollout.run()
        best = rollout.cost().argmin()
    """

    def __init__(
        self,
        scene: SceneLike,
        instances: int = 1,
        device: str | None = None,
        *,
        record: Sequence[int] = (),
        record_rate: float = 100.0,
        quantities: Sequence[str] | None = None,
        threads: int | None = None,
        lanes: int | None = None,
        trust: bool = False,
    ) -> None:
        """Prepare a batch at the scene's initial state and parameter values.

        Args:
            scene: what to simulate, or its name or file; see `warpmuscle.load`.
            instances: how many simulations.
            device: "cpu", "cuda:0", ...; by default the first GPU, or the CPU without one. For several GPUs see
                `multi_device.make_rollout`.
            record: instances whose motion is kept.
            record_rate: frames per second of simulated time.
            quantities: what is kept of them, for `recorded`: "coordinates", "speeds" and names of muscle quantities
                (see `recording.QUANTITIES`); by default everything, for `recording`.
            threads: CPU threads, by default one a core; without effect on a GPU.
            lanes: GPU threads that share an instance, by default 8, and 16 where few run; without effect on the CPU.
            trust: let code run that the scene names; not needed where `load` was told so.

        Raises:
            SceneError: the scene is inconsistent.
            RolloutError: no such device or not enough memory on it, an impossible number of instances, recordings,
                threads or lanes, or an unknown quantity.
        """
        scene = scene_of(scene, trust=trust)
        check_scene(scene)
        check_custom(scene)
        self.scene = scene
        self.instances = positive(instances, "instances")
        self.parameters: list[Parameter] = free_parameters(scene)
        self.structure = structure_of(scene)
        self.names, self._driven = self.structure.names, self.structure.actuation
        self._kinematic, self._objective = self.structure.kinematic, self.structure.objective
        self.coordinate_names, self.speed_names = self.structure.coordinate_names, self.structure.speed_names
        self.device = find_device(device)
        self._inputs = Inputs()
        self.threads = checked_threads(threads)
        if lanes is not None:
            as_whole(lanes, "lanes", 1, WARP, error=RolloutError)
        record_rate = as_number(record_rate, "record_rate", above=0.0, error=RolloutError)
        self.steps = round(scene.duration / scene.time_step)
        self.block_dim = 1 if self.device.is_cpu else GPU_BLOCK
        capacity = capacity_of(len(self.names.bodies))
        self.lanes = 1
        if not self.device.is_cpu:
            self.lanes = usual_lanes(
                lanes, work_floats(capacity, bool(self.structure.joints)), self.instances, self.device.sm_count
            )
        kind = compiled_kind(scene, self.names, self._driven, capacity, lean=not self.device.is_cpu)
        recorded_instances = chosen(record, self.instances)
        # On a GPU, code that is not there saves time; elsewhere one kernel for all saves compiling another.
        asked = record_kind(quantities)
        recorded = asked if recorded_instances or self.device.is_cpu else NOTHING
        self._recipe = KernelConfig(
            capacity, self.lanes, self.block_dim, kind, self._objective, bool(self.structure.collision_pairs),
            bool(self._kinematic.names), recorded, self.structure.controller,
            self.structure.joints,
        )  # fmt: skip
        self._launchers: dict[KernelConfig, Launcher] = {}
        self._spreads = lanes is None and not self.device.is_cpu
        if self.instances > FEW:
            check_memory(self.instances, self.instance_bytes.state, self.device)
        self._state = self._state_of(self.instances, self.device)
        self._extensions = Extensions(self.structure, self.instances, self.device)
        every = max(round(min(1.0 / (record_rate * scene.time_step), max(self.steps, 1))), 1)
        self._check_frames(len(recorded_instances), -(-self.steps // every))
        self._frames = Frames(
            self.names, self._driven.muscles, self.instances, recorded_instances, every, self.steps, self.device,
            recorded,
        )  # fmt: skip
        self._disturbances = none(self.instances)
        self._inputs.of_model = ModelInputs(reference=reference_of(scene, self.structure, self._record))
        self._numeric, self._model = substitute(scene, start_values(scene)), structs.Model()
        self._use(self._numeric)

    def _check_frames(self, instances: int, frames: int) -> None:
        """Raise RolloutError if the motion of so many instances is too long, or does not fit into the memory."""
        size = frame_bytes(self.names, self._driven.muscles) * frames
        if instances:
            check_size("frames", frames, RolloutError)
        if instances * size > FEW_BYTES:
            check_memory(instances, RECORDED_COPIES * size, self.device)

    def _state_of(self, instances: int, device: Any) -> structs.State:
        return state_struct(self.scene, self.structure, instances, device)

    def _model_parts(self, numeric: Scene, device: Any) -> tuple[Any, Any]:
        """The model of a scene of numbers, and the parameters of its extensions."""
        extensions = extensions_struct(self.structure.controller, 0, device)
        put_parameters(extensions, numeric, self.structure.controller, device)
        return build_model(numeric, self.structure, device), extensions

    @cached_property
    def instance_bytes(self) -> InstanceBytes:
        """Memory on the device that every further instance takes."""
        start = start_values(self.scene)
        return bytes_of(
            lambda count: (self._state_of(count, "cpu"), Extensions(self.structure, count, "cpu").struct),
            lambda count: self._model_parts(substitute(self.scene, repeated(start, count)), "cpu"),
        )

    @property
    def recording_bytes(self) -> int:
        """Memory on the device that every further instance takes all of whose motion is recorded."""
        return frame_bytes(self.names, self._driven.muscles) * -(-self.steps // self._frames.every)

    def set_parameters(self, values: ArrayLike) -> None:
        """Set the free parameters of all instances, and start again.

        Args:
            values: (instances, parameters), or (parameters,) for all instances alike, in the order of `parameters`.

        Raises:
            RolloutError: another shape, a value that is not finite, or not enough memory on the device.
        """
        array = checked_values(values, self.instances, len(self.parameters))
        if array.ndim == 2 and self.instances > FEW:
            held = struct_bytes(self._state, self._model, self._extensions.struct)
            check_memory(self.instances, self.instance_bytes.total, self.device, held)
        before = self._numeric
        self._model = structs.Model()  # so that its memory is free for the new one
        try:
            self._use(substitute(self.scene, array))
        except Error:
            self._use(before)
            raise

    def _use(self, numeric: Scene) -> None:
        """Take the numbers of all instances from this scene (see `parameters.substitute`), and start again."""
        self.change(numeric)
        self.reset()

    @in_silence
    def change(self, numeric: Scene) -> None:
        """Go on from where the batch stands with other numbers; what starts count with the next `reset`.

        Args:
            numeric: the batch's scene with numbers in place of its free parameters (see `parameters.substitute`).
        """
        self._model = build_model(numeric, self.structure, self.device, self._inputs.of_model)
        self._extensions.use(numeric)
        self._numeric, self._start, self._start_rows = numeric, start_of(numeric, self.names), {}
        if self._kinematic.names:
            self._moved = moved(self._kinematic, motion_of(numeric, self.structure, self._inputs.of_model), 0.0)

    def change_controller(self, numeric: Scene) -> None:
        """Go on with other numbers of the controller, which are all that differs from the present ones."""
        update_model(self._model, ["controller"], numeric, self.structure, self.device, self._inputs.of_model)
        self._numeric = numeric

    def reset(self, velocity_noise: Any = 0.0, seed: int = 0, mask: Any = None) -> None:
        """Put every instance back to its start, or those of a mask.

        Args:
            velocity_noise: standard deviation of what is added to each component of the root's velocity, m/s. An array
                in its place is the mask.
            seed: of that noise.
            mask: (instances,) of bool, as `step` takes arrays: which instances; the others stay as they are, and the
                clock, `time`, goes on.

        Raises:
            RolloutError: the mask has another shape, or is not of bool.
        """
        if is_array(velocity_noise):
            velocity_noise, mask = 0.0, velocity_noise
        noise = root_noise(self.scene, self.instances, velocity_noise, seed)
        if mask is None:
            self.restart(noise)
        else:
            self.restart_some(mask_of(mask, self.instances), noise)

    @in_silence
    def _starts(self, root_velocity: Floats) -> tuple[Any, Any, Any]:
        """Coordinates, speeds and accelerations of all instances at their start, (instances, ...), float32."""
        n, start, given = self.instances, self._start, self._inputs
        at = start.coordinates if given.coordinates is None else given.coordinates
        coordinates = np.broadcast_to(at, (n, self.names.coordinates)).astype(np.float32)
        at = start.speeds if given.speeds is None else given.speeds
        speeds = np.broadcast_to(at, (n, self.names.speeds)).astype(np.float32)
        linear = len(root_type(self.scene.character).moving)
        speeds[:, :linear] += root_velocity
        speeds[:, :linear] += self._disturbances.velocity[:, 3 - linear :]
        if self._kinematic.names:
            return coordinates, speeds, self._put_moved(coordinates, speeds)
        return coordinates, speeds, np.zeros((1, speeds.shape[1]), dtype=np.float32)

    def restart(self, root_velocity: Floats) -> None:
        """Put every instance back to its start, with something added to the root's linear speeds, (rows, 3 or less)."""
        n, s, start, given = self.instances, self._state, self._start, self._inputs
        coordinates, speeds, accelerations = self._starts(root_velocity)
        s.accelerations.zero_()
        if self._kinematic.names:
            s.accelerations.assign(accelerations)
        s.coordinates.assign(coordinates)
        s.speeds.assign(speeds)
        s.stance.fill_(start.stance)
        s.machine_state.fill_(start.machine_state)
        activation = start.activation if given.activation is None else given.activation
        if activation.size == 1:
            s.muscles.activation.fill_(float(activation[0, 0]))
        else:
            s.muscles.activation.assign(np.broadcast_to(activation, s.muscles.activation.shape).astype(np.float32))
        s.muscles.neural.assign(s.muscles.activation)
        for name in structs.MuscleState.vars:
            if name not in ("activation", "neural"):
                getattr(s.muscles, name).zero_()
        for name in ("torque_integral", "muscle_terms", "body_terms", "whole_terms"):
            getattr(s, name).zero_()
        for name in ("phase", "foot_force", "foot_cycle", "start_height", "start_heading", "step", "status"):
            getattr(s, name).zero_()
        self.steps_done = 0
        self._begun: Integers = np.zeros(n, dtype=np.int32)
        self._running: Integers = np.arange(n, dtype=np.int32)
        self._start_rows = {}
        self._extensions.restart()
        self._frames.clear()

    def recorded(self, quantity: str) -> Floats:
        """A quantity of all recorded instances, in the order of `record`, at 0, 1/record_rate, ... s before the end.

        Frames after the end of an instance that failed are zero.

        Args:
            quantity: "coordinates" or "speeds", as in `coordinate_names` and `speed_names`, or a muscle quantity.

        Returns:
            (recorded instances, frames, coordinates, speeds or simulated muscles), float32.

        Raises:
            RolloutError: it was not recorded.
        """
        as_text(quantity, "quantity", error=RolloutError)
        steps = min(self.steps_done, self.steps)
        values, ended = self._frames.values(quantity, steps), self._state.step.numpy()[self._frames.chosen]
        if (ended >= steps).all():
            return values
        before = np.arange(values.shape[1]) * self._frames.every < ended[:, None]
        return np.where(before[..., None], values, np.float32(0.0))

    def _record(self, scene: Scene) -> Recording:
        """The motion of one simulation of another scene on this device."""
        rollout = Rollout(scene, 1, str(self.device), record=[0], record_rate=200.0)
        rollout.run()
        return rollout.recording()

    def run(self, duration: float | None = None, progress: Progress | None = None) -> None:
        """Simulate on from where the batch stands.

        Args:
            duration: s; by default up to the scene's duration. The batch never goes beyond that.
            progress: called after every chunk of steps with this rollout, some times a second or more often. An
                exception from it, such as KeyboardInterrupt, leaves a batch that can be read and continued.
        """
        end, chunk = end_step(self, duration), chunk_steps(self.scene)
        check_function(progress, "progress", error=RolloutError)
        while self.steps_done < end and self.running:
            running, begin = len(self._running), time.monotonic()
            self.advance(min(self.steps_done + chunk, end))
            if progress is not None:
                progress(self)
            rest = len(self._running) == running and time.monotonic() - begin < QUICK
            chunk = 2 * chunk if rest else chunk_steps(self.scene)
        if self.steps_done >= self.steps:
            self.complete()

    @property
    def time(self) -> float:
        """Simulated time that the batch has come to since all of it last started, s."""
        return self.steps_done * self.scene.time_step

    @property
    def alive(self) -> int:
        """Number of instances that have not failed."""
        return int(np.isin(self.status(), (Status.RUNNING, Status.COMPLETED)).sum())

    def status(self) -> Integers:
        """Status of every instance, (instances,), see `warpmuscle.Status`."""
        return np.asarray(self._state.status.numpy())

    def status_names(self) -> tuple[str, ...]:
        """The same in words, such as `completed` and `fell`."""
        return words(self.status())

    def __repr__(self) -> str:
        kind = type(self).__name__
        where = f"{self.scene.name!r}, {self.instances} on {self.device}"
        return f"{kind}({where}, {self.time:.4g} of {self.scene.duration:.4g} s: {counted(self.status())})"

    def end_time(self) -> Floats:
        """Simulated time that every instance came to, (instances,), s."""
        return np.asarray(self._state.step.numpy() * self.scene.time_step)

    def terms(self) -> dict[str, Floats]:
        """Values (instances,) of the objective's terms so far, by name; see `objective.TERMS`."""
        names = wanted(self.scene.objective)  # not of the numbers: a free weight may be 0 in all instances
        return term_values(names, self._numeric, self._objective, self._state, self.end_time(), self._distance())

    def parts(self, instance: int = 0) -> dict[str, Parts]:
        """What joints and muscles have added to the terms of an instance so far, by term and name."""
        instance = as_whole(instance, "instance", 0, self.instances - 1, error=RolloutError)
        end = float(self.end_time()[instance])
        muscles = self._driven.muscles
        return term_parts(self.terms(), self._numeric, self._objective, self._state, self.names, muscles, instance, end)

    def _distance(self) -> Floats:
        """Horizontal distance from the start, (instances,), m."""
        moved = self._state.coordinates.numpy()[:, :3].astype(float) - self._start.coordinates[:, :3]
        along = [moved[:, k] for k in root_type(self.scene.character).on_ground]
        return np.asarray(np.hypot(*along) if len(along) > 1 else np.abs(sum(along, np.zeros(self.instances))))

    def cost(self) -> Floats:
        """Cost of every instance, (instances,), finite.

        For one that has not failed the weighted sum of the terms so far, at most the failure cost; for one that has
        failed the failure cost, plus as much of it as the part of the time that it missed.
        """
        worst = self.scene.objective.failure_cost
        missed = 1.0 - self._state.step.numpy() / self.steps
        failed = ~np.isin(self.status(), (Status.RUNNING, Status.COMPLETED))
        return np.asarray(np.where(failed, worst * (1.0 + missed), weighted(self._numeric, self.terms())))

    def recording(self, instance: int | None = None, start: float = 0.0) -> Recording:
        """Motion of a recorded instance up to its end; by default of the first one recorded.

        Args:
            start: s, from where on it is wanted; at least the last frame is given.

        Raises:
            RolloutError: the instance was not among those to record.
        """
        if instance is None and self._frames.chosen:
            instance = self._frames.chosen[0]
        start = as_number(start, "start", error=RolloutError)
        if instance is not None:
            instance = as_whole(instance, "instance", 0, error=RolloutError)
        if instance is None or instance not in self._frames.chosen:
            raise RolloutError(f"instance {instance} was not recorded: name it in Rollout(..., record=[...])")
        return self._frames.recording(self._numeric, instance, int(self._state.step.numpy()[instance]), start)

    @property
    def numeric(self) -> Scene:
        """The scene with its present numbers in place of free parameters; see `parameters.substitute`."""
        return self._numeric

    @property
    def state(self) -> structs.State:
        """The state of all instances as Warp arrays on the device, without a copy (see `kernels.structs.State`)."""
        return self._state

    @property
    def controller_state(self) -> Floats:
        """States that the scene's own controller keeps, (instances, floats); none if it has none."""
        memory = self._extensions.struct.first.memory if self.structure.controller.custom.state else None
        return np.zeros((self.instances, 0)) if memory is None else np.asarray(memory.numpy()[:, 0])

    @property
    def model(self) -> structs.Model:
        """The model as Warp arrays on the device, without a copy (see `kernels.structs.Model`)."""
        return self._model
