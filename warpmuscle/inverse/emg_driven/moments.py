"""Moments of recordings that muscles make under EMG, for many sets of parameters at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Prepared
from warpmuscle.inverse.emg import Emg
from warpmuscle.kernels import structs
from warpmuscle.kernels.inverse import emg_driven as kernels
from warpmuscle.model.build import with_fields
from warpmuscle.model.muscles import muscle_kind, muscles_struct
from warpmuscle.scene.muscles import given

LEAD = 0.3  # s, of EMG before a trial that is heard, if it was recorded; else as its first value
STEP = 0.005  # s, between samples of EMG


class EmgMoments:
    """Trials with EMG on a device.

    Attributes:
        measured: (M,) 1 for muscles with EMG. wanted: (n, K) moments of the chosen speeds.
    """

    def __init__(
        self, body: BodyModel, trials: Prepared, emg: Sequence[Emg], estimated: Floats, speeds: Integers, wanted: Floats
    ) -> None:
        """Args: estimated: (n, M) activations of muscles without EMG. speeds: (K,) numbers. wanted: (n, K)."""
        self.body, self.trials, self.wanted, device = body, trials, wanted, body.device
        muscles = [body.muscle(name) for name in body.muscles]
        known = kernels.Recordings()
        known.begin = to_device(trials.starts, int, device)
        known.time = to_device(np.concatenate([at - at[0] + LEAD for at in trials.times]), float, device)
        signal, self.measured = _signals(body, trials, emg)
        known.emg, known.estimated = to_device(signal, float, device), to_device(estimated, float, device)
        known.step = STEP
        known.measured = to_device(self.measured, int, device)
        model = body.scene.muscle_model
        known.rise_time, known.fall_time = (
            to_device([float(given(one, model, name)) for one in muscles], float, device)
            for name in ("rise_time", "fall_time")
        )
        parts = [body.muscle_frames(trials.states, part) for part in body.chunks(len(estimated))]
        for name in ("length", "speed", "moment_arm"):
            values = np.concatenate([getattr(part, name).numpy() for part in parts])
            setattr(known, name, to_device(values, float, device))
        self._known = known
        self._model = with_fields(structs.Model(), {"muscles": muscles_struct(body.scene, body.muscles, device)})
        kind = muscle_kind(model, muscles)
        self._forces = kernels.emg_forces_of(kind.curves, kind.special_curves)
        entries = [np.flatnonzero(body.lever_speed == speed) for speed in speeds]
        self._first = to_device(np.cumsum([0, *map(len, entries)]), int, device)
        every = np.concatenate(entries)
        self._lever, self._muscle = to_device(every, int, device), to_device(body.lever_muscle[every], int, device)
        self._wanted = to_device(wanted, float, device)

    def moments(self, parameters: Mapping[str, Floats]) -> tuple[wp.array, wp.array]:
        """Activations (C, n, M) and moments (C, n, K) of candidates, on the device."""
        device, count = self.body.device, len(parameters["delay"])
        candidates = kernels.Candidates()
        for name, values in parameters.items():
            setattr(candidates, name, to_device(values, float, device))
        n, muscles = len(self.wanted), len(self.body.muscles)
        activation, force = (wp.zeros((count, n, muscles), dtype=float, device=device) for _ in range(2))
        moment = wp.zeros((count, n, self.wanted.shape[1]), dtype=float, device=device)
        size = (count, len(self.trials.times), muscles)
        wp.launch(kernels.emg_activations, size, [self._known, candidates], [activation], device=device)
        inputs: list[Any] = [self._model, self._known, candidates, activation]
        wp.launch(self._forces, activation.shape, inputs, [force], device=device)
        inputs = [self._known, self._first, self._lever, self._muscle, force]
        wp.launch(kernels.emg_moments, moment.shape, inputs, [moment], device=device)
        return activation, moment

    def errors(self, parameters: Mapping[str, Floats], blocks: Integers) -> Floats:
        """Sums of squared errors (C, blocks, K) over blocks of frames that begin there."""
        moment = self.moments(parameters)[1]
        device, shape = self.body.device, (len(moment), len(blocks) - 1, moment.shape[2])
        error = wp.zeros(shape, dtype=float, device=device)
        inputs = [to_device(blocks, int, device), self._wanted, moment]
        wp.launch(kernels.moment_errors, shape, inputs, [error], device=device)
        return np.asarray(error.numpy(), np.float64)


def _signals(body: BodyModel, trials: Prepared, emg: Sequence[Emg]) -> tuple[Floats, Integers]:
    """Envelopes (trials, G, M) from `LEAD` before each trial on, and which muscles (M,) have any."""
    names = set(emg[0].muscles)
    if any(set(one.muscles) != names for one in emg):
        raise ArgumentError("EMG of all trials must be of the same muscles")
    unknown = sorted(names - set(body.muscles))
    if unknown:
        raise ArgumentError(f"EMG of {unknown[0]!r}, which is not a muscle of the model; it has "
                            f"{', '.join(body.muscles[:8])}, ...")  # fmt: skip
    longest = max(float(at[-1] - at[0]) for at in trials.times)
    grid = STEP * np.arange(int(np.ceil((LEAD + longest) / STEP)) + 2) - LEAD
    found = np.zeros((len(emg), len(grid), len(body.muscles)))
    for one, at, rows in zip(emg, trials.times, found, strict=True):
        one.at(at)  # which says whether it reaches over the trial
        for name, column in zip(one.muscles, one.values.T, strict=True):
            rows[:, body.muscles.index(name)] = np.interp(at[0] + grid, one.times, column)
    return found, np.array([name in names for name in body.muscles], dtype=np.int64)
