"""A batch of independent simulations of one scene on a device."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import answering, as_kind, as_number, check_function
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.kernels import structs
from warpmuscle.kernels.recording.record import NOTHING
from warpmuscle.model.build import Fields, ModelInputs, build_model, parts_of, replaced, with_fields
from warpmuscle.model.controllers.program import has_program
from warpmuscle.model.parts import check_custom, recorded_functions
from warpmuscle.model.state import state_struct
from warpmuscle.model.structure import structure_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import Parameter, constant, free_parameters, known_numbers, start_values
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation import memory
from warpmuscle.simulation.batch_input import checked_threads, chosen, chunk_steps, end_step, noise_and_mask, positive
from warpmuscle.simulation.batch_state import BatchState, Snapshot
from warpmuscle.simulation.commands import Course
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.extensions import Extensions
from warpmuscle.simulation.fused_kernel import FusedKernel, KernelConfig
from warpmuscle.simulation.inputs import Inputs
from warpmuscle.simulation.kernel_cache import progress_said
from warpmuscle.simulation.launcher import Launcher, kernel_config
from warpmuscle.simulation.recorder import Recorder, frame_steps, record_kind
from warpmuscle.simulation.reference_gait import reference_of
from warpmuscle.simulation.rollout_settings import RolloutSettings
from warpmuscle.simulation.stepper import Stepper
from warpmuscle.simulation.terrain_starts import TerrainStarts

if TYPE_CHECKING:
    from warpmuscle.model.objective import RecordedNorms
    from warpmuscle.simulation.program.step_program import StepProgram

QUICK = 0.05  # s of wall time; a chunk that is over sooner is followed by a longer one if most come through it ...
MOST = 0.95  # ... of the instances, or where those that have failed leave no room that others could use


def advance_by(rollout: Rollout, chunk: int, end: int) -> int:
    """Advance by a chunk of steps, or up to this step if that comes sooner; how long the next chunk is to be."""
    running, begin = len(rollout._batch.running), time.monotonic()
    rollout.advance(min(rollout.steps_done + chunk, end))
    if len(rollout._batch.running) < MOST * running and running > rollout._room:
        return chunk_steps(rollout.scene)
    return 2 * chunk if time.monotonic() - begin < QUICK else chunk


def _how_far(rollout: Rollout) -> str:
    seconds = rollout.scene.time_step
    return f"simulating {rollout.scene.name}: {seconds * rollout.steps_done:.1f} of {seconds * rollout.steps:.1f} s"


class Rollout(RolloutSettings):
    """Independent simulations of one scene, each with its own parameters, stepped together on one device.

    Instances that fail stop; the others continue unaffected. Equal parameters give equal bits on the same kind of
    device, whatever the number of instances, the index of the instance or the number of CPU threads.

    Example:
        rollout = Rollout(load("fwalk"), instances=100)
        rollout.set_parameters(candidates)  # (100, parameters)
        rollout.run()
        best = rollout.cost().argmin()

    Attributes:
        coordinate_names, speed_names: in the order of the arrays of `state`.
        muscle_names: all of the scene, in the order of excitations.
        motion_names: kinematic coordinates in the order of `set_motion`; see `prescribed_motion`.
        torque_names: speeds of the joints, in the order of the torques that `step` takes.
        excitable: whether muscles drive any joint, so that `step` takes excitations.
        structure: what all instances have in common. threads: of a CPU. block_dim: GPU threads in a block.
        numeric: the scene with its present numbers in place of free parameters; see `parameters.substitute`.
        state, model: Warp arrays on the device, without a copy; see `kernels.structs`. Do not write to the model.
    """

    @answering(
        {
            **dict.fromkeys(("n", "batch", "count", "num_envs", "size"), "instances=100 are as many"),
            "duration": "run(2.0) simulates for 2 s", "seconds": "run(2.0) simulates for 2 s",
            "set": "wm.Rollout(wm.load(scene, set={...})) changes the scene",
            "policy": "wm.simulate(scene, policy='policy.h5') runs one",
            "gpu": "device='cuda:0' is the first GPU",
            "seed": "nothing in a rollout is random; reset(velocity_noise=0.1, seed=1) and disturb(...) draw",
            "commands": "set_commands({'speed': 1.2}) commands all of them", "dt": "scene.time_step is it",
        }
    )  # fmt: skip
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
                (see `recorded_quantities.QUANTITIES`); by default everything, for `recording`.
            threads: CPU threads, by default one a core; without effect on a GPU.
            lanes: GPU threads that share an instance, by default 8 to 32; without effect on the CPU.
            trust: let code run that the scene names; not needed where `load` was told so.

        Raises:
            SceneError: the scene is inconsistent.
            RolloutError: no such device or not enough memory on it, an impossible number of instances, recordings,
                threads or lanes, or an unknown quantity.
        """
        scene = scene_of(scene, trust=trust)
        with constant([scene]):  # while it is looked at
            self._prepare(scene, instances, device, record, record_rate, quantities, threads, lanes)

    def _prepare(
        self, scene: Scene, instances: int, device: str | None, record: Sequence[int], record_rate: float,
        quantities: Sequence[str] | None, threads: int | None, lanes: int | None,
    ) -> None:  # fmt: skip
        """See `__init__`."""
        check_scene(scene)
        check_custom(scene)
        self.scene, self.instances = scene, positive(instances, "instances")
        self.parameters: list[Parameter] = free_parameters(scene)
        self.structure = structure = structure_of(scene)
        self.names, self.coordinate_names = structure.names, structure.coordinate_names
        self.speed_names, self.motion_names = structure.speed_names, structure.kinematic.names
        self.excitable = bool(structure.actuation.muscles)
        self.device, self.threads = find_device(device), checked_threads(threads)
        record_rate = as_number(record_rate, "record_rate", above=0.0, error=RolloutError)
        recorded, asked = chosen(record, self.instances), record_kind(quantities)
        # On a GPU, code that is not there saves time; elsewhere one kernel for all saves compiling another.
        kind = asked if recorded or self.device.is_cpu else NOTHING
        if kind.complete:
            kind = kind._replace(custom=recorded_functions(structure.parts, scene.character))
        config = kernel_config(scene, structure, self.instances, self.device, lanes, kind)
        self.steps, self.lanes, self.block_dim = round(scene.duration / scene.time_step), config.lanes, config.block_dim
        self._paths_apart = config.paths_apart
        if self.instances > memory.FEW:
            memory.check_memory(self.instances, self.instance_bytes.state, self.device)
        self.side_by_side = config.several_warps
        self._room = 0 if self.device.is_cpu else config.resident(self.device.sm_count)  # for instances at once
        self.state = state_struct(
            scene, structure, self.instances, self.device, self.side_by_side, self._paths_apart
        )  # fmt: skip
        self._extensions = Extensions(structure, self.instances, self.device)
        self._batch = BatchState(self.state, self._extensions, self.steps)
        every = frame_steps(scene, record_rate)
        self._recorder = Recorder(structure, self.instances, recorded, every, self.steps, self.device, kind)
        self._launcher = Launcher(
            config, self.device, self.threads, lanes is None and not self.device.is_cpu, self.instances
        )
        self._inputs = Inputs(scene, structure, self.instances, self.device)
        self.muscle_names, self.torque_names = self._inputs.muscle_names, self._inputs.torque_names
        reference = reference_of(scene, structure, self._record)
        self._inputs.of_model = ModelInputs(reference=reference, norms=_norms(scene))
        self._values: Floats = start_values(scene)
        self._known = known_numbers(scene)
        self._numeric: Scene | None = None
        self._following = parts_of(name for name, _, _ in self._known.numbers)
        self._commands: Mapping[str, Floats] = {}  # that are not those of the scene
        self._course = Course(scene)
        self.terrain_starts = TerrainStarts(scene, self.instances, self.device)
        self._ground_turned = False  # about where instances stood
        self.change(self._substituted(self._values))
        self._program: StepProgram | None = None
        if has_program(scene):
            from warpmuscle.simulation.program.step_program import StepProgram

            kind = config.kind.muscles
            self._program = StepProgram(scene, structure, self.model, self.instances, kind, self.device, self.threads)
        self.reset()

    def _record(self, scene: Scene) -> Recording:
        """The motion of one simulation of another scene on this device."""
        rollout = Rollout(scene, 1, str(self.device), record=[0], record_rate=200.0)
        rollout.run()
        return rollout.recording()

    def reset(self, velocity_noise: Any = 0.0, seed: int = 0, mask: Any = None) -> None:
        self.restart(*noise_and_mask(self.scene, self.instances, velocity_noise, seed, mask))

    def restart(self, root_velocity: Floats, mask: NDArray[np.bool_] | None = None) -> None:
        """Put instances, by default all, back to their start; add noise, (rows, 3 or less), to the root's speeds."""
        if self._course.given and (mask is None or mask.all()):
            self._commands = {name: value for name, value in self._commands.items() if name not in self._course.given}
            self._course.given.clear()
            self.change(self._substituted(self._values))
        if self._ground_turned:
            self._level_ground(mask)
        initial = self._inputs.initial_values(root_velocity)
        if mask is None or mask.all():
            self._batch.restart(initial)
            self._recorder.clear()
        else:
            self._batch.restart_some(mask, initial)
        self.terrain_starts.put(self.model, self.state, mask)

    @answering(
        {
            **dict.fromkeys(("seconds", "time", "t", "until"), "duration=1.0 is in s"),
            **dict.fromkeys(("steps", "n", "n_steps", "k"), "step(10) makes ten steps, run(1.0) simulates 1 s"),
        }
    )
    def run(self, duration: float | None = None, progress: Callable[[Rollout], None] | None = None) -> None:
        end, chunk = end_step(self, duration), chunk_steps(self.scene)
        check_function(progress, "progress", error=RolloutError)
        with progress_said(progress, f"simulating {self.scene.name}", _how_far) as tell:
            while self.steps_done < end and self.running:
                self._follow_course()
                chunk = advance_by(self, chunk, min(end, self._course.until(self.steps_done) or end))
                if tell is not None:
                    tell(self)
        if self.steps_done >= self.steps:
            self.complete()

    def _follow_course(self) -> None:
        """Tell the batch what commands of the scene that change over time have come to."""
        changed = self._course.at(self.steps_done)
        if changed:
            self._command({name: np.asarray(value) for name, value in changed.items()}, restart=False)
            self._course.given.update(changed)

    def step(self, k: int = 1, excitations: Any = None, torques: Any = None) -> None:
        target = self.steps_done + positive(k, "the number of steps k")
        fields = self._inputs.from_outside(excitations, torques)
        config = self._launcher.config_from_outside(excitations is not None, torques is not None)
        with replaced(self.model, fields):
            self.advance(target, self._launcher.kernel(config))
        if self.running and self.steps_done >= self._batch.next_end:
            self.complete()

    def advance(self, step: int, kernel: FusedKernel | None = None) -> None:
        """Advance all running instances to this step, in one launch unless some end earlier."""
        batch = self._batch
        while step > batch.steps_done and self.running:
            end = batch.next_end
            target = min(step, end)
            if self._program is not None:
                target = self._decide(target)
            if target > batch.steps_done:
                count = target - batch.steps_done
                suiting = self._launcher.kernel_for(len(batch.running)) if kernel is None else kernel
                suiting.launch(
                    count, batch.running, self.model, batch.state, self._recorder.record, self._extensions.struct
                )
                batch.came_to(target)
            if end < step:
                batch.complete()

    def _decide(self, step: int) -> int:
        """Let instances decide whose programme is due now; the step until which none is again, up to this one."""
        assert self._program is not None
        batch = self._batch
        done, begun = batch.steps_done, batch.begun[batch.running]
        if step > done:
            own, objects = self._extensions.struct.first, self._extensions.objects
            self._program.decide(self.model, batch.state, own, objects, batch.running, done - begun)
        return min(step, self._program.until(done, begun))

    def complete(self) -> None:
        """Mark the instances that have reached the end of the simulation as completed."""
        self._batch.complete()

    def snapshot(self) -> Snapshot:
        """The present state of all instances, for `restore`."""
        return self._batch.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Restore the states of a snapshot; parameters, commands and other settings stay as they are now."""
        as_kind(Snapshot, snapshot, "snapshot", error=RolloutError)
        self._batch.restore(snapshot)

    def load(self) -> None:
        self._launcher.kernel().load()

    def stepper(self, change: Callable[[KernelConfig], KernelConfig], fields: Fields, model: Any = None) -> Stepper:
        """A `Stepper`, which advances all instances without waiting for the device.

        Args:
            change: makes the configuration of its kernel from the usual one.
            fields: of the model, which the kernel has in the place of the rollout's.
            model: in the place of the rollout's.
        """
        if self._program is not None:
            raise RolloutError(
                "a controller by quadratic programmes decides between steps, which nobody here waits for"
            )
        kernel = self._launcher.kernel(change(self._launcher.config))
        model = with_fields(self.model if model is None else model, fields)
        return Stepper(kernel, model, self.state, self._recorder.record, self._extensions.struct)

    def varied_model(self, numeric: Scene, slope: Floats) -> structs.Model:
        """The model of other numbers, (n,) of some of them, and of slopes (n,), rad; its rows are not of instances."""
        inputs = replace(self._inputs.of_model, slope=slope)
        return build_model(numeric, self.structure, self.device, inputs)

    def load_step(self, excitations: bool = False, torques: bool = False) -> None:
        """Compile and load the kernel that `step` launches with excitations, torques or both; see `load`."""
        self._launcher.kernel(self._launcher.config_from_outside(excitations, torques)).load()

    @property
    def at_once(self) -> int:
        if self.device.is_cpu:
            return 0
        config = kernel_config(self.scene, self.structure, 1, self.device, None, NOTHING)
        return config.resident(self.device.sm_count)

    @property
    def compiles(self) -> bool:
        return self._launcher.kernel().compiles

    @property
    def steps_done(self) -> int:
        return self._batch.steps_done

    @property
    def running(self) -> bool:
        return len(self._batch.running) > 0


def _norms(scene: Scene) -> RecordedNorms | None:
    """The recorded curves that a scene compares with; most name none, and what reads them takes long to import."""
    if scene.norms is None:
        return None
    from warpmuscle.simulation.recorded_norms import recorded_norms

    return recorded_norms(scene)
