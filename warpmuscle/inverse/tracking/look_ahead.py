"""What muscles can come to by the end of a window, if the body moves as it is expected to."""

from __future__ import annotations

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import rows
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.tracking.driven_body import DrivenBody
from warpmuscle.inverse.tracking.force_sharing import Reach
from warpmuscle.kernels.inverse.window_forces import window_forces_of
from warpmuscle.kernels.muscle.hill_law import HILL
from warpmuscle.model.build import with_fields
from warpmuscle.model.muscles import muscle_kind

KEPT = ("activation", "neural", "fibre_length", "previous_fibre_length")  # of a muscle, that a window changes


class LookAhead:
    """Muscles of a simulation, moved on by themselves along paths that are told."""

    def __init__(self, driven: DrivenBody) -> None:
        """Raises ArgumentError for muscles that are not of Hill's type, or hear their excitation late."""
        self._driven, self._body = driven, driven.body
        body: BodyModel = driven.body
        muscles = [body.muscle(name) for name in driven.muscle_names]
        kind = muscle_kind(body.scene.muscle_model, muscles)
        if kind.law is not HILL:
            raise ArgumentError("motions are followed by Hill-type muscles, not by ideal or legacy ones")
        if any((rows(muscle.delay) > 0.0).any() for muscle in muscles):
            raise ArgumentError("muscles that hear their excitation late cannot follow a motion; set their delay to 0")
        self._kernel = window_forces_of(kind)
        state, device = driven.rollout.state, body.device
        fields = {f"muscles.{name}": wp.clone(getattr(state.muscles, name)) for name in KEPT}
        self._state = with_fields(state, fields | {"step": wp.ones(len(state.step), dtype=int, device=device)})
        self._start = self._end = wp.zeros((0, 0), dtype=float, device=device)

    def lengths(self, states: States) -> wp.array:
        """Lengths (n, M) of the paths of simulated muscles, on the device."""
        parts = [self._body.muscle_frames(states, part).length for part in self._body.chunks(len(states.coordinates))]
        found = np.concatenate([part.numpy() for part in parts])[:, self._driven.muscles]
        return to_device(found, float, self._body.device)

    def begin(self, now: States, then: States) -> None:
        """Take over the muscles as they are, and where the body is now and at the window's end."""
        self._start, self._end = self.lengths(now), self.lengths(then)

    def reach(self, excitation: Floats) -> Reach:
        """What all muscles come to under excitations (n, M)."""
        simulated, own = self._driven.rollout.state.muscles, self._state.muscles
        for name in KEPT:
            if getattr(simulated, name).size:
                wp.copy(getattr(own, name), getattr(simulated, name))
        steps, device = self._driven.window_steps, self._body.device
        first = self._driven.rollout.steps_done == 0
        shape = self._start.shape
        excited = to_device(excitation[:, self._driven.muscles], float, device)
        outputs = [wp.zeros(shape, dtype=float, device=device) for _ in range(2)]
        inputs = [self._driven.rollout.model, self._state, steps, self._start, self._end, excited]
        if first:  # fibres that have not begun yet
            self._state.step.zero_()
            wp.launch(self._kernel, shape, [*inputs[:2], 1, self._start, self._start, excited], outputs, device=device)
            self._state.step.fill_(1)
            wp.copy(own.activation, simulated.activation)
            wp.copy(own.neural, simulated.neural)
        wp.launch(self._kernel, shape, inputs, outputs, device=device)
        return Reach(*(self._driven.of_muscles(array) for array in outputs))
