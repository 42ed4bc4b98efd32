"""Steps of all instances of a batch, driven from outside, without a question to the device: they can be captured."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.kernels import structs
from warpmuscle.kernels.recording.record import NOTHING
from warpmuscle.model.controllers.outside import moved_by, telling
from warpmuscle.simulation.fused_kernel import FusedKernel, KernelConfig


class Stepper:
    """Launches of one kernel for all instances of a batch, whatever their status; see `Rollout.stepper`.

    `Rollout.step` asks after every launch which instances still run. Here nobody asks: whoever steps so sees to it, on
    the device, that an instance that has failed is put back to a start before the next launch. Ends of the simulated
    time are not noticed either.

    Attributes:
        model, state, extensions: what the kernel is given.
    """

    def __init__(
        self, kernel: FusedKernel, model: structs.Model, state: structs.State, record: structs.Record, extensions: Any
    ) -> None:
        """Prepare."""
        self._kernel, self.model, self.state = kernel, model, state
        self.extensions, self._record = extensions, record
        self._every = np.arange(len(state.step), dtype=np.int32)

    @property
    def compiles(self) -> bool:
        """Whether the kernel is yet to be compiled."""
        return self._kernel.compiles

    def load(self) -> None:
        """Have the kernel ready; raises as `Rollout.load`."""
        self._kernel.load()

    def launch(self, steps: int) -> None:
        """Make so many steps."""
        self._kernel.launch(steps, self._every, self.model, self.state, self._record, self.extensions)


def unrecorded(config: KernelConfig) -> KernelConfig:
    """The configuration of a kernel that records nothing."""
    return config.compiling(recorded=NOTHING)


def sensing(config: KernelConfig) -> KernelConfig:
    """The configuration of a kernel in which muscles also tell what they feel, in `MuscleState.sensed`."""
    if config.kind.muscles is None:
        return config
    return config.compiling(controller=telling(config.kind.controller))


def excited(config: KernelConfig) -> KernelConfig:
    """The configuration of a kernel whose muscles take excitations from outside."""
    if config.kind.muscles is None:
        return config
    return config.compiling(muscles=config.kind.muscles._replace(given=True, timed=True))


def moved(config: KernelConfig, effort: Any) -> KernelConfig:
    """The configuration of a kernel with a Warp function for the efforts of joints, see `control.CustomController`."""
    return config.compiling(controller=moved_by(config.kind.controller, effort))
