"""What a batch on one device is told: parameters, commands, excitations, motions, starts and disturbances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from warpmuscle.core.arguments import answering, as_truth
from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import times_repeated
from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.kernels import structs
from warpmuscle.model.build import build_model, update_model
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import KnownNumbers, substitute
from warpmuscle.simulation import memory
from warpmuscle.simulation.batch_input import checked_values, in_silence, named_values
from warpmuscle.simulation.batch_state import BatchState
from warpmuscle.simulation.commands import Course, checked_commands, levelled, place_of_root, turned_below
from warpmuscle.simulation.launcher import Launcher
from warpmuscle.simulation.perturbations import Perturbations, with_bodies
from warpmuscle.simulation.rollout_results import RolloutResults


class RolloutSettings(RolloutResults):
    """What can be told to a `Rollout`, which has these parts."""

    model: structs.Model
    coordinate_names: tuple[str, ...]
    _numeric: Scene | None
    _known: KnownNumbers
    _following: tuple[str, ...] | None  # parts of the model in which free parameters appear; None: in others, too
    _course: Course
    _ground_turned: bool  # about where instances stood
    _batch: BatchState
    _launcher: Launcher

    @property
    def numeric(self) -> Scene:
        if self._numeric is None:  # nobody has asked since parameters were set
            self._numeric = self._substituted(self._values)
        return self._numeric

    @numeric.setter
    def numeric(self, scene: Scene) -> None:
        self._numeric = self._few = scene

    @in_silence
    def change(self, numeric: Scene) -> None:
        """Continue from the present state with other numbers of the scene; initial states change with the next `reset`.

        Args:
            numeric: the batch's scene with numbers in place of its free parameters (see `parameters.substitute`).
        """
        self.model = build_model(numeric, self.structure, self.device, self._inputs.of_model)
        self._extensions.use(numeric)
        self._inputs.use(numeric)
        self.numeric = numeric

    def change_controller(self, numeric: Scene) -> None:
        """Continue with other numbers of the controller; no other numbers may differ."""
        self.change_parts(numeric, ["controller"])

    @in_silence
    def change_parts(self, numeric: Scene, parts: Sequence[str]) -> None:
        """Continue with other numbers of these parts of the model only, see `model.build.update_model`."""
        self.numeric = numeric
        for part in parts:
            self._update(part)
        if "controller" in parts:
            self._extensions.use_controller(numeric)

    def change_forces(self, numeric: Scene) -> None:
        """Continue with other numbers of the scene's forces; no other numbers may differ."""
        self.numeric = numeric
        self._extensions.use(numeric)

    def _update(self, part: str) -> None:
        """Let a part of the model have what the batch is told now."""
        update_model(self.model, [part], self.numeric, self.structure, self.device, self._inputs.of_model)

    def _substituted(self, values: Floats) -> Scene:
        """The scene with values of its parameters, as commanded, with masses and strengths of disturbed instances."""
        return with_bodies(substitute(self.scene, values, self._commands, self._known), self._inputs.disturbances)

    @answering(
        {}, "set_parameters({name: value}) takes names as text, parameter_names lists them; set_commands has commands"
    )
    def set_parameters(self, values: ArrayLike | Mapping[str, ArrayLike]) -> None:
        if isinstance(values, Mapping):
            values = named_values(values, self.parameters, self._values, self.instances)
        array = checked_values(values, self.instances, len(self.parameters))
        if array.ndim == 2 and self.instances > memory.FEW:
            memory.check_memory(self.instances, self.instance_bytes.total, self.device, self.held_bytes)
        before = self._numeric, self._few
        try:
            if self._following is not None:
                self._follow(array, self._following)
            else:
                self.model = structs.Model()  # so that its memory is free for the new one
                self.change(self._substituted(array))
            self._values = array
        except Error:
            self._numeric, self._few = before
            self.change(self.numeric)
            raise
        finally:
            self.reset()

    @in_silence
    def _follow(self, array: Floats, parts: Sequence[str]) -> None:
        """Take values of parameters that appear in these parts alone; those of neighbours may be the same."""
        disturbed = self._inputs.disturbances
        alike = array.ndim == 2 and not self._commands and not self._extensions.of_controller
        times = times_repeated(array) if alike and disturbed.mass is None and disturbed.strength is None else 1
        few = self._substituted(array[::times] if times > 1 else array)
        self._numeric, self._few = None if times > 1 else few, few
        each = len(array) // times, times
        update_model(self.model, parts, few, self.structure, self.device, self._inputs.of_model, each)
        if "controller" in parts:
            self._extensions.use_controller(few)

    @answering({}, "set_commands({'speed': 1.2}) takes names as text, scene.commands lists them")
    def set_commands(self, commands: Mapping[str, ArrayLike], *, restart: bool = True) -> None:
        checked = checked_commands(commands, self.scene, self.instances)
        as_truth(restart, "restart", error=RolloutError)
        self._course.leave(checked)
        self._command(checked, restart)

    def _command(self, checked: Mapping[str, Floats], restart: bool) -> None:
        before = self.numeric
        self._commands = {**self._commands, **checked}
        numeric = self._substituted(self._values)
        if restart:
            self.change(numeric)
            self.reset()
        else:
            place = place_of_root(self.coordinate_names, self.state.coordinates.numpy())
            ground = turned_below(before.ground, numeric.ground, place)
            self._ground_turned = ground is not numeric.ground
            self.change(msgspec.structs.replace(numeric, ground=ground))

    def _level_ground(self, mask: NDArray[np.bool_] | None) -> None:
        """Put the ground back to where the scene has it, below instances that start again, by default all."""
        ground, numeric = self.numeric.ground, self._substituted(self._values)
        again = np.ones(self.instances, dtype=bool) if mask is None else mask
        self._ground_turned = not again.all()
        if self._ground_turned:
            numeric = msgspec.structs.replace(numeric, ground=levelled(ground, numeric.ground, again))
        self.change(numeric)

    def set_excitations(self, time: ArrayLike, values: ArrayLike, *, restart: bool = True) -> None:
        as_truth(restart, "restart", error=RolloutError)
        self._inputs.set_excitations(time, values)
        self._launcher.read_excitations()
        self._update("excitations")
        if restart:
            self.reset()

    def set_motion(self, time: ArrayLike, values: ArrayLike, of: ArrayLike | None = None) -> None:
        self._inputs.set_motion(time, values, of, self.steps * self.scene.time_step)
        self._update("motion")
        self.reset()

    def set_initial(
        self, coordinates: ArrayLike | None = None, speeds: ArrayLike | None = None, activation: ArrayLike | None = None
    ) -> None:
        self._inputs.set_initial(coordinates, speeds, activation)
        self.reset()

    def disturb(self, disturbances: Perturbations) -> None:
        self._inputs.set_disturbances(disturbances)
        self._batch.push(disturbances, self.scene.time_step)
        if disturbances.mass is not None or disturbances.strength is not None:
            self.change(self._substituted(self._values))
        else:
            self._update("slope")
        self.reset()
