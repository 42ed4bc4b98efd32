"""What a batch of simulations can do, be it on one device or shared out over several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import RolloutError, lacking
from warpmuscle.core.html_table import html_table
from warpmuscle.core.status import Status, counted, words
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import picture
from warpmuscle.scene.parameters import Parameter
from warpmuscle.scene.topology import Topology
from warpmuscle.simulation.batch_input import INSTEAD
from warpmuscle.simulation.memory import InstanceBytes
from warpmuscle.simulation.objective_parts import Parts
from warpmuscle.simulation.perturbations import Perturbations


class Batch(Protocol):
    """Independent simulations of one scene, each with its own parameters, stepped together.

    Attributes:
        scene: that is simulated. instances: how many. parameters: its free parameters, in the order of their values.
        names: of bodies and joints, by number. steps: of a whole simulation. lanes: GPU threads that share an instance.
        device: where, several by one name.
    """

    scene: Scene
    instances: int
    parameters: list[Parameter]
    names: Topology
    steps: int
    lanes: int
    device: Any

    @property
    def devices(self) -> list[Any]:
        """The devices that hold the instances."""
        return [self.device]

    @property
    def steps_done(self) -> int:
        """Steps that the batch has come to since all of it last started."""

    @property
    def running(self) -> bool:
        """Whether any instance still runs."""

    @property
    def compiles(self) -> bool:
        """Whether the kernel is yet to be compiled, for some seconds, when it is run."""

    @property
    def at_once(self) -> int:
        """Instances of such a scene that its GPUs compute in about the time of one; 0 on a CPU."""

    @property
    def instance_bytes(self) -> InstanceBytes:
        """Bytes of device memory per additional instance."""

    @property
    def held_bytes(self) -> int:
        """Bytes of memory that state and model take on the first device; an additional instance takes no more."""

    @property
    def recording_bytes(self) -> int:
        """Memory on the device that every further instance takes all of whose motion is recorded."""

    def load(self) -> None:
        """Have the kernel ready, compiled now unless Warp has it in its cache."""

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Of the free parameters, in the order of `parameters`."""
        return tuple(parameter.name for parameter in self.parameters)

    def set_parameters(self, values: ArrayLike | Mapping[str, ArrayLike]) -> None:
        """Set the free parameters of all instances, and start again.

        Args:
            values: (instances, parameters), or (parameters,) for all instances alike, in the order of `parameters`; or
                values by names of parameters, each a number or one for every instance: others are as they were.

        Raises:
            RolloutError: another shape, a value that is not finite, or not enough memory on the device.
        """

    def set_commands(self, commands: Mapping[str, ArrayLike], *, restart: bool = True) -> None:
        """Command all instances, such as a speed, in place of what the scene says; numbers of the scene follow.

        What is not named stays as it was commanded last.

        Args:
            commands: by name one value, or (instances,) values, in the unit and the range of the scene's command.
            restart: start again. If not, instances go on from where they stand; a plane of the ground that is
                inclined otherwise now is turned about the point of the ground below their roots.

        Raises:
            RolloutError: no such command, another shape, or a value that is out of range.
        """

    def set_excitations(self, time: ArrayLike, values: ArrayLike, *, restart: bool = True) -> None:
        """Excite all muscles over time in place of a controller and of the scene's excitations, and start again.

        It stays so, also with other parameters. Values beyond 0..1 count as 0 or 1.

        Args:
            time: (K,) s, increasing; excitations are straight between these knots and constant beyond them.
            values: (1 or instances, muscles, K), muscles as in `Rollout.muscle_names`.
            restart: False to go on from where the batch stands.

        Raises:
            RolloutError: wrong shapes, numbers that are not finite, or times that do not increase.
        """

    def set_motion(self, time: ArrayLike, values: ArrayLike, of: ArrayLike | None = None) -> None:
        """Let the kinematic coordinates move in place of what the scene says, and start again. It stays so.

        Args:
            time: (K,) s, increasing, over the whole simulated time; between knots motions are splines of fifth degree.
            values: (1 or instances, coordinates, K), rad and m, coordinates as in `Rollout.motion_names`; quaternions
                of any length but zero.
            of: (instances,) number of the row of `values`, which then may have any number of them, that an instance
                follows.

        Raises:
            RolloutError: no kinematic coordinates, wrong shapes, numbers that are not finite, times that do not
                increase or do not reach over the simulated time.
        """

    def set_initial(
        self, coordinates: ArrayLike | None = None, speeds: ArrayLike | None = None, activation: ArrayLike | None = None
    ) -> None:
        """Start from other states than the scene's, where there are any here, and start again. It stays so.

        Kinematic coordinates start where their motion does, whatever is said here.

        Args:
            coordinates: (1 or instances, coordinates) rad, m, and quaternions of unit length, as in
                `Rollout.coordinate_names`.
            speeds: (1 or instances, speeds) rad/s and m/s, as in `Rollout.speed_names`.
            activation: (1 or instances, muscles), as in `Rollout.muscle_names`.

        Raises:
            RolloutError: wrong shapes, or numbers that are not finite.
        """

    def disturb(self, disturbances: Perturbations) -> None:
        """Push instances, start them at other velocities, or tilt their ground, from now on; and start again.

        Raises:
            RolloutError: another number of instances.
        """

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

    def step(self, k: int = 1, excitations: Any = None, torques: Any = None) -> None:
        """Make k steps under control from outside; what does not come from there stays with the scene's controller.

        The numbers hold for all k steps. They may be Warp arrays, anything with `__dlpack__` (PyTorch, JAX, CuPy) or
        what NumPy takes; an array of float32 on the rollout's device is read where it lies, without a copy. The first
        step with excitations, and the first with torques, compiles a kernel unless Warp has it in its cache.

        An instance that comes to the end of the scene's duration has completed it and stops, like those that fail; see
        `reset` for how to go on with them.

        Args:
            k: how many steps.
            excitations: (1 or instances, muscles), muscles as in `Rollout.muscle_names`; beyond 0..1 they count as 0 or
                1. What is not a number is refused on a CPU; on a GPU, which is not waited for, the instance has
                diverged, and `causes` names the muscle.
            torques: (1 or instances, torques) N m, as in `Rollout.torque_names`, each along its speed, as of a motor
                between parent and child; in the place of what the controller asks for. Joints that muscles drive take
                it as such a wish. An instance for which one is not finite has diverged, and
                `causes` names the joint.

        Raises:
            RolloutError: no number of steps, another shape, excitations without muscles, or nothing that could be taken
                for numbers.
        """

    def run(self, duration: float | None = None, progress: Callable[[Self], None] | None = None) -> None:
        """Simulate on from where the batch stands.

        Args:
            duration: s; by default up to the scene's duration. The batch never goes beyond that.
            progress: called with this batch when all of it has come equally far, a few times a second or more often. An
                exception from it, such as KeyboardInterrupt, leaves a batch that can be read and continued.
        """

    def status(self) -> Integers:
        """Status of every instance, (instances,), see `warpmuscle.Status`."""

    def causes(self) -> tuple[str, ...]:
        """For every instance, (instances,), what of the scene's own or from outside ended it, in words; else nothing.

        That is a term, force or controller of the user's that gave no number, or excitations or torques that were none.
        """

    def end_time(self) -> Floats:
        """Simulated time that every instance came to, (instances,), s."""

    def cost(self) -> Floats:
        """Cost of every instance, (instances,), finite.

        For one that has not failed the weighted sum of the terms so far, at most the failure cost; for one that has
        failed the failure cost, plus as much of it as the part of the time that it missed.
        """

    def terms(self) -> dict[str, Floats]:
        """Values (instances,) of the objective's terms so far, by name; see `objective.TERMS`."""

    def parts(self, instance: int = 0) -> dict[str, Parts]:
        """What joints and muscles have added to the terms of an instance so far, by term and name."""

    @property
    def recorded_instances(self) -> tuple[int, ...]:
        """Numbers of the instances whose motion is recorded, as `record` named them."""

    def recording(self, instance: int | None = None, start: float = 0.0) -> Recording:
        """Motion of a recorded instance up to its end; by default of the first one recorded.

        Args:
            start: s, from where on; the last frame is there in any case.

        Raises:
            RolloutError: the instance was not among those to record.
        """

    def recorded(self, quantity: str) -> Floats:
        """A quantity of all recorded instances, in the order of `record`, at 0, 1/record_rate, ... s before the end.

        Frames after the end of an instance that failed are zero.

        Args:
            quantity: "coordinates" or "speeds", as in `Rollout.coordinate_names` and `Rollout.speed_names`, or a muscle
                quantity.

        Returns:
            (recorded instances, frames, coordinates, speeds or simulated muscles), float32.

        Raises:
            RolloutError: it was not recorded.
        """

    @property
    def time(self) -> float:
        """Simulated time since the last start of all instances, s."""
        return self.steps_done * self.scene.time_step

    @property
    def alive(self) -> int:
        """Number of instances that have not failed."""
        return int(np.isin(self.status(), (Status.RUNNING, Status.COMPLETED)).sum())

    def status_names(self) -> tuple[str, ...]:
        """Status of every instance as a word, such as `completed` or `fell`."""
        return words(self.status())

    def __enter__(self) -> Self:
        """Use it within `with`, at whose end its memory on the device is free again."""
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the memory on the device; any later use raises RolloutError."""
        vars(self).clear()

    def _repr_html_(self) -> str:
        """What notebooks show: a table, and the scene's body as it starts."""
        rows = [("scene", self.scene.name), ("instances", f"{self.instances} on {self.device}")]
        rows += [("time", f"{self.time:.4g} of {self.scene.duration:.4g} s"), ("now", counted(self.status()))]
        return picture(self.scene) + html_table(("", ""), rows)

    def __len__(self) -> int:
        """How many instances there are."""
        return self.instances

    def __getitem__(self, instance: int) -> Recording:
        """The motion of a recorded instance, as `recording` gives it; a negative number counts from the last one.

        Raises:
            IndexError: there is no such instance. RolloutError: it was not among those to record.
        """
        if not isinstance(instance, int | np.integer):
            asked = "list(rollout)[0:2] are several; " if isinstance(instance, slice) else ""
            raise RolloutError(f"{asked}a rollout is asked for an instance by its number, such as rollout[0]")
        if not -self.instances <= instance < self.instances:
            raise IndexError(f"there is no instance {instance} of {self.instances}")
        return self.recording(int(instance) % self.instances)

    def __iter__(self) -> Iterator[Recording]:
        """The motions of all instances, which must have been recorded."""
        return (self[instance] for instance in range(self.instances))

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            f"a {type(self).__name__} is neither copied nor pickled, since its memory is on a device; "
            "make another one, or keep recording(i) and cost()"
        )

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Only of what is not there, as of a rollout that is closed."""
            if not vars(self) and not name.startswith("__"):
                raise RolloutError("this rollout is closed, and its memory free; make another one")
            raise lacking(f"a {type(self).__name__}", name, dir(type(self)), INSTEAD)

    def __repr__(self) -> str:
        if not vars(self):
            return f"{type(self).__name__}(closed)"
        where = f"{self.scene.name!r}, {self.instances} on {self.device}"
        kind = type(self).__name__
        return f"{kind}({where}, {self.time:.4g} of {self.scene.duration:.4g} s: {counted(self.status())})"
