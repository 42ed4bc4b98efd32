"""A batch that goes on step by step, driven by whoever asks: a policy, a controller of one's own, a loop."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.array_interop import rows_of
from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import structs_to_device
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.status import Status
from warpmuscle.kernels import structs
from warpmuscle.kernels.control import driven_from_outside
from warpmuscle.kernels.restart import put_rows
from warpmuscle.model.build import Start, replaced
from warpmuscle.simulation.batch_input import positive
from warpmuscle.simulation.extensions import words
from warpmuscle.simulation.inputs import Given
from warpmuscle.simulation.launcher import KernelConfig, Launcher, soon_loaded, spread_recipe
from warpmuscle.simulation.recorder import Frames

KEPT = ("push", "push_steps", "muscles")  # of the state, that no restart changes, or that is a structure of its own


class Stepped(Given):
    """A batch that can be driven from outside."""

    speed_names: tuple[str, ...]
    threads: int
    _recipe: KernelConfig
    _launchers: dict[KernelConfig, Launcher]
    _spreads: bool  # more lanes over an instance when few are left
    _frames: Frames
    _start: Start
    _start_rows: dict[str, wp.array]

    @abstractmethod
    def _starts(self, root_velocity: Floats) -> tuple[Any, Any, Any]:
        """Coordinates, speeds and accelerations of all instances at their start."""

    @abstractmethod
    def restart(self, root_velocity: Floats) -> None:
        """Put every instance back to its start."""

    @property
    def _launcher(self) -> Launcher:
        """The launcher of the batch's own kernel, made when it is wanted first."""
        return self._launcher_of(self._recipe_now)

    @property
    def _recipe_now(self) -> KernelConfig:
        """What the batch's own kernel is made of, with what it needs for the excitations that were given."""
        recipe = self._recipe
        if recipe.muscles is None or not self._inputs.of_model.excitations:
            return recipe
        return recipe._replace(muscles=recipe.muscles._replace(timed=True))

    @cached_property
    def torque_names(self) -> tuple[str, ...]:
        """Speeds of the joints, in the order of the torques that `step` takes; a part of `speed_names`."""
        return tuple(name for name in self.speed_names if not name.startswith("root."))

    @property
    def excitable(self) -> bool:
        """Whether muscles drive any joint, so that `step` takes excitations."""
        return self._recipe.muscles is not None and bool(self._driven.muscles)

    def step(self, k: int = 1, excitations: Any = None, torques: Any = None) -> None:
        """Make k steps under control from outside; what is not given stays with the scene and its controller.

        Given numbers hold for all k steps. They may be Warp arrays, anything with `__dlpack__` (PyTorch, JAX, CuPy) or
        what NumPy takes; an array of float32 on the rollout's device is read where it lies, without a copy. The first
        step with excitations, and the first with torques, compiles a kernel unless Warp has it in its cache.

        An instance that comes to the end of the scene's duration has completed it and stops, like those that fail; see
        `reset` for how to go on with them.

        Args:
            k: how many steps.
            excitations: (1 or instances, muscles), muscles as in `muscle_names`; beyond 0..1 they count as 0 or 1, and
                what is not a number as 0.
            torques: (1 or instances, torques) N m, as in `torque_names`, each along its speed, as of a motor between
                parent and child; in the place of what the controller wants. Joints that muscles drive take it as such a
                wish. An instance for which one is not finite has diverged.

        Raises:
            RolloutError: no number of steps, another shape, excitations without muscles, or nothing that could be taken
                for numbers.
        """
        target = self.steps_done + positive(k, "the number of steps k")
        with self._driven_by(excitations, torques) as launcher:
            self.advance(target, launcher)
        if self.running and self.steps_done >= self._next_end():
            self.complete()

    def advance(self, step: int, launcher: Launcher | None = None) -> None:
        """Bring all instances that still run to this step, in one launch unless some of them end before."""
        while step > self.steps_done and self.running:
            end = self._next_end()
            target = min(step, end)
            if target > self.steps_done:
                count = target - self.steps_done
                now = self._launcher_now() if launcher is None else launcher
                now.launch(count, self._running, self._model, self._state, self._frames.record, self._extensions.struct)
                self.steps_done = target
                status = self._state.status.numpy()
                goes_on = status[self._running] == Status.RUNNING
                if not goes_on.all():
                    self._running = self._running[goes_on]
            if end < step:
                self.complete()

    def _next_end(self) -> int:
        """The step at which the first of the running instances comes to the end of the simulation."""
        return self.steps + int(self._begun[self._running].min())

    @property
    def running(self) -> bool:
        """Whether any instance still runs."""
        return len(self._running) > 0

    def complete(self) -> None:
        """Those that have come to the end of the simulation have completed it."""
        status = self._state.status.numpy()
        ended = self.steps_done - self._begun >= self.steps
        status[(status == Status.RUNNING) & ended] = Status.COMPLETED
        self._state.status.assign(status)
        self._running = np.flatnonzero(status == Status.RUNNING).astype(np.int32)

    def observation(self) -> dict[str, wp.array]:
        """What a controller may want to know, by name, as Warp arrays of the rollout's device, without a copy.

        They are the state itself, which steps change in place: `wp.to_torch`, `wp.to_jax` or `np.from_dlpack` make
        other libraries see it. Do not write to them.

        Returns:
            coordinates, speeds: (instances, ...), as in `coordinate_names` and `speed_names`.
            phase, stance, machine_state: (instances,) of the controller.
            foot_force: (instances, 2, 3) N, left and right foot, of the step before.
            activation, muscle_force: (instances, simulated muscles), N.
            step, status: (instances,) steps since its start, and `Status`.
        """
        names = ("coordinates", "speeds", "phase", "stance", "machine_state", "foot_force", "step", "status")
        found = {name: getattr(self._state, name) for name in names}
        muscles = self._state.muscles
        return found | {"activation": muscles.activation, "muscle_force": muscles.force}

    def load(self) -> None:
        """Have the kernel ready on the device, compiled now unless Warp has it in its cache."""
        self._launcher.load()

    @property
    def compiles(self) -> bool:
        """Whether the kernel is yet to be compiled, for some seconds, when it is run."""
        return self._launcher.compiles

    def load_step(self, excitations: bool = False, torques: bool = False) -> None:
        """Have the kernel ready that `step` launches with excitations, torques, or both; see `load`."""
        self._launcher_of(self._recipe_of(excitations, torques)).load()

    def _recipe_of(self, excited: bool, driven: bool) -> KernelConfig:
        """What a kernel is made of that takes excitations, torques or both from outside."""
        recipe = self._recipe_now
        if excited:
            if recipe.muscles is None or not self.excitable:
                raise RolloutError("there are no muscles to excite: they drive no joint of this scene")
            recipe = recipe._replace(muscles=recipe.muscles._replace(given=True, timed=True))
        return recipe._replace(controller=driven_from_outside(recipe.controller)) if driven else recipe

    @contextmanager
    def _driven_by(self, excitations: Any, torques: Any) -> Iterator[Launcher]:
        """The launcher for steps that are driven so, while the model has what is given."""
        fields: dict[str, Any] = {}
        recipe = self._recipe_of(excitations is not None, torques is not None)
        if excitations is not None:
            count = len(self.muscle_names)
            value = rows_of(excitations, count, self.instances, self.device, "excitations")
            fields |= self._one_knot | {"muscles.knot_value": value}
        if torques is not None:
            count = len(self.torque_names)
            fields["actuation.effort"] = rows_of(torques, count, self.instances, self.device, "torques")
        with replaced(self._model, fields):
            yield self._launcher_of(recipe)

    @cached_property
    def _one_knot(self) -> dict[str, wp.array]:
        """Excitations of one knot a muscle, which stands in the muscle's column of what is given."""
        every = self.muscle_names
        first = np.array([[every.index(name) for name in self._driven.muscles]])
        own = structs_to_device(structs.OwnExcitation, {"first_knot": first, "end_knot": first + 1}, self.device)
        return {"muscles.own": own, "muscles.knot_time": wp.zeros((1, len(every)), dtype=float, device=self.device)}

    def _launcher_of(self, recipe: KernelConfig) -> Launcher:
        """The launcher of a fused kernel."""
        if recipe not in self._launchers:
            self._launchers[recipe] = Launcher(recipe, self.device, self.threads)
        return self._launchers[recipe]

    def _launcher_now(self) -> Launcher:
        """The launcher of the batch's own kernel, or of one that is quicker for the few instances left, if there is."""
        if self._spreads:
            spread = spread_recipe(self._recipe_now, len(self._running), self.device.sm_count)
            if spread is not None and soon_loaded(spread, self.device):
                return self._launcher_of(spread)
        return self._launcher

    def restart_some(self, mask: NDArray[np.bool_], root_velocity: Floats) -> None:
        """Put the instances of a mask back to their start, see `restart`."""
        if mask.all():
            self.restart(root_velocity)
            return
        if not mask.any():
            return
        chosen = wp.array(np.flatnonzero(mask).astype(np.int32), dtype=int, device=self.device)
        if root_velocity.any() or not self._start_rows:
            self._start_rows = self._new_start_rows(root_velocity)
        rows, none = self._start_rows, self._start_rows[""]
        for part, names in ((self._state, structs.State.vars), (self._state.muscles, structs.MuscleState.vars)):
            for name in names:
                if name not in KEPT and len(getattr(part, name)) == self.instances:
                    target = words(getattr(part, name))
                    dim = (len(chosen), target.shape[1])
                    wp.launch(put_rows, dim, [chosen, rows.get(name, none), target], device=self.device)
        self._extensions.restart(chosen)
        if root_velocity.any():
            self._start_rows = {}
        self._begun[mask] = self.steps_done
        status = np.isin(np.arange(self.instances), self._running) | mask
        self._running = np.flatnonzero(status).astype(np.int32)

    def _new_start_rows(self, root_velocity: Floats) -> dict[str, wp.array]:
        """What the arrays of the state have at the start, in rows of words; under no name zeros for all others."""
        start, given = self._start, self._inputs
        coordinates, speeds, accelerations = self._starts(root_velocity)
        activation = start.activation if given.activation is None else given.activation
        activation = np.broadcast_to(activation, (len(activation), self._state.muscles.activation.shape[1]))
        found = {
            "coordinates": coordinates, "speeds": speeds, "accelerations": accelerations, "activation": activation,
            "neural": activation,
        }  # fmt: skip
        whole = {"stance": start.stance, "machine_state": start.machine_state}
        rows = {name: np.ascontiguousarray(values, dtype=np.float32).view(np.int32) for name, values in found.items()}
        rows |= {name: np.full((1, 1), value, dtype=np.int32) for name, value in whole.items()}
        parts = (self._state, structs.State.vars), (self._state.muscles, structs.MuscleState.vars)
        widest = max(
            words(getattr(part, name)).shape[1]
            for part, names in parts
            for name in names
            if name not in KEPT and len(getattr(part, name)) == self.instances
        )
        rows[""] = np.zeros((1, widest), dtype=np.int32)
        return {name: wp.array(values, dtype=int, device=self.device) for name, values in rows.items()}
