"""Static optimisation of recorded motions: activations of least cost that make the moments a motion needs.

As OpenSim's StaticOptimization: tendons are rigid, muscles make their active forces alone, every coordinate that is not
locked counts. Costs are sums of w a^p; see `static_optimization` for how they are minimised. What comes out is
computed from a motion and a model; it is no EMG.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, overload

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import instance_zeros, to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike
from warpmuscle.inverse.activations import RESERVE, ActivationOptions, Activations, widths_left_out
from warpmuscle.inverse.body_model import BodyModel, MuscleFrames
from warpmuscle.inverse.dynamics import CoordinatesLike, LoadsLike, Moments, Prepared, Several, are_several, prepare
from warpmuscle.inverse.elastic_tendon import tendon_motion
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.muscle_groups import Groups, groups_of
from warpmuscle.inverse.trial import Loads, each_of
from warpmuscle.kernels.inverse import static_optimization as kernels
from warpmuscle.kernels.inverse.left_out_pennation import leave_out_pennation
from warpmuscle.scene.masses import muscle_masses
from warpmuscle.scene.muscles import given
from warpmuscle.simulation.kernel_cache import said

SMALLEST_BEND = 0.02  # of costs a + bend a^2/2 in place of a alone, which leave more than one answer


@dataclass
class _Solved:
    """Arrays of all frames as they are found."""

    activation: Floats
    multiplier: Floats
    iterations: Integers
    fibre: Floats = field(default_factory=lambda: np.zeros((2, 0, 0)))
    active: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    passive: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    length: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    speed: Floats = field(default_factory=lambda: np.zeros((0, 0)))


@overload
def static_optimization(
    model: SceneLike | BodyModel, coordinates: CoordinatesLike, loads: LoadsLike = None, *,
    filter: float | None = None, times: Floats | Sequence[Floats] | None = None,
    emg: Emg | Sequence[Emg | None] | None = None, exact_rates: bool = False, device: str | None = None,
    **options: object,
) -> Activations: ...  # fmt: skip
@overload
def static_optimization(
    model: SceneLike | BodyModel, coordinates: Several, loads: LoadsLike = None, *,
    filter: float | None = None, times: Floats | Sequence[Floats] | None = None,
    emg: Emg | Sequence[Emg | None] | None = None, exact_rates: bool = False, device: str | None = None,
    **options: object,
) -> list[Activations]: ...  # fmt: skip
@said("finding muscle forces")
def static_optimization(
    model: SceneLike | BodyModel,
    coordinates: CoordinatesLike | Sequence[CoordinatesLike],
    loads: Loads | Sequence[Loads | None] | None = None,
    *,
    filter: float | None = None,
    times: Floats | Sequence[Floats] | None = None,
    emg: Emg | Sequence[Emg | None] | None = None,
    exact_rates: bool = False,
    device: str | None = None,
    **options: object,
) -> Activations | list[Activations]:
    """Muscle activations and forces by static optimisation, for one trial or many at once.

    Args:
        model, coordinates, loads, filter, times, exact_rates, device: see `inverse_dynamics`.
        emg: of the same trials, None of one without.
        options: see `ActivationOptions`: power, weight, physiology, passive, reserve, least, emg_weight, rates,
            elastic, pennation.

    Raises:
        ArgumentError: see `inverse_dynamics`; or an option that is none, or EMG of other muscles or another time.
        SceneError: the model cannot be read, or has no muscles.
    """
    many = are_several(coordinates)
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    unknown = next((name for name in options if name not in ActivationOptions.__dataclass_fields__), None)
    if unknown is not None:
        raise ArgumentError(f"no option {unknown!r}; there are {', '.join(ActivationOptions.__dataclass_fields__)}")
    trials = prepare(body, coordinates, loads, filter, times, exact_rates, of_speeds=True).of_speeds
    signals: list[Emg | None] = [None] * len(trials.times)
    if emg is not None:
        signals = each_of(Emg, emg, "emg", " that warpmuscle.inverse.emg.read_emg reads, or None", none=True)
    if len(signals) != len(trials.times):
        raise ArgumentError(
            f"there is EMG of {number_of(len(signals), 'trial')}, and coordinates of {len(trials.times)}"
        )
    found = activations_of(body, trials, ActivationOptions(**options), signals)  # type: ignore[arg-type]
    return found if many else found[0]


def activations_of(
    body: BodyModel,
    trials: Prepared,
    options: ActivationOptions,
    emg: Sequence[Emg | None] = (),
    effort: Floats | None = None,
) -> list[Activations]:
    """Activations of prepared trials.

    Args:
        emg: of each trial. effort: (n, S) that speeds need, if it is known already.
    """
    options.check(body)
    if not body.muscles:
        raise ArgumentError("the model has no muscles")
    if effort is None:
        dynamics = body.dynamics(trials.states, trials.loads)
        effort = dynamics.effort + dynamics.followed
    solver = Solver(body, trials, options, emg)
    solved = solver.run(effort, None)
    if options.elastic:
        solved = solver.run(effort, tendon_motion(body, solver.force(solved), trials.times))
    return solver.activations(solved, effort)


@dataclass(frozen=True)
class Launch:
    """The solver's kernel with all that it needs on the device.

    Attributes:
        kernels: in single and in double precision. runs: (2, runs) first frames of runs, and those after their last.
    """

    kernels: Callable[[Any], Any]
    groups: int
    runs: Integers
    inputs: list[Any]
    outputs: list[wp.array]
    device: Any

    def run(self, runs: Integers | None = None, real: Any = wp.float32) -> None:
        """Solve all frames, or those of some runs."""
        chosen = self.runs if runs is None else runs
        if self.groups and chosen.shape[1]:
            inputs = [*self.inputs, to_device(chosen, int, self.device)]
            size = (self.groups, chosen.shape[1])
            wp.launch(self.kernels(real), size, inputs, self.outputs, device=self.device)

    def mend(self) -> None:
        """Solve those runs again, in double precision, in which a frame did not converge."""
        lost = (self.outputs[2].numpy() < 0).any(axis=1)
        if lost.any():
            before = np.concatenate([[0], np.cumsum(lost)])
            self.run(self.runs[:, before[self.runs[1]] > before[self.runs[0]]], wp.float64)


class Solver:
    """Static optimisation of the trials of a model with the same options."""

    def __init__(
        self, body: BodyModel, trials: Prepared, options: ActivationOptions, emg: Sequence[Emg | None]
    ) -> None:
        self.body, self.trials, self.options = body, trials, options
        muscles = [body.muscle(name) for name in body.muscles]
        model = body.scene.muscle_model
        own = [(float(given(muscle, model, "minimum_activation") or 0.0), 1.0) for muscle in muscles]
        if body.scene.opensim is not None:
            own = [body.scene.opensim.controls.get(name, ends) for name, ends in zip(body.muscles, own, strict=True)]
        low, high = np.reshape(own, (-1, 2)).T
        self.low = np.where(body.pulls, low if options.least is None else options.least, 0.0)
        self.high = np.where(body.pulls, high, 0.0)
        # Ligaments pull in any case, as in OpenSim, which leaves out passive forces of muscles alone.
        self._taut = np.ones(len(muscles), bool) if options.passive else ~body.pulls
        self._widths = widths_left_out(body) if not options.pennation else np.zeros((3, len(muscles)))
        self.weight = np.ones(len(muscles))
        if options.weight == "volume":
            volume = np.array(muscle_masses(muscles, model))
            self.weight = volume / volume.mean()
        self.rise, self.fall = (
            np.array([float(given(one, model, name)) for one in muscles]) for name in ("rise_time", "fall_time")
        )
        self.groups: Groups = groups_of(body)
        self.reserve = self._reserve()
        self.gain, self.shift, self.exponent, self.law = self._cost(emg)

    def _reserve(self) -> Floats:
        """Strengths (S,) of the reserves of all speeds."""
        given = self.options.reserve
        names = [self.body.map.coordinate_of(speed) for speed in range(self.body.topology.speeds)]
        if isinstance(given, Mapping):
            return np.array([given.get(name, given.get("", RESERVE)) for name in names])
        return np.full(len(names), float(given))

    def _cost(self, emg: Sequence[Emg | None]) -> tuple[Floats, Floats, float, int]:
        """Gain and shift (frames or 1, M), exponent and law; see `kernels.inverse.static_optimization.Cost`."""
        weight, power = self.weight[None], self.options.power
        if power > 2:
            return 1.0 / weight, np.zeros_like(weight), 1.0 / (power - 1), kernels.POWER
        if power == 1:
            return 1.0 / (weight * SMALLEST_BEND), np.full_like(weight, -1.0 / SMALLEST_BEND), 1.0, kernels.LINEAR
        if self.options.emg_weight == 0.0 or not any(one is not None for one in emg):
            return 1.0 / weight, np.zeros_like(weight), 1.0, kernels.LINEAR
        known, signal = self._signals(emg)
        total = weight + self.options.emg_weight * known
        return 1.0 / total, self.options.emg_weight * known * signal / total, 1.0, kernels.LINEAR

    def _signals(self, emg: Sequence[Emg | None]) -> tuple[Floats, Floats]:
        """Whether a muscle has EMG, 0 or 1, and its envelope, in all frames (n, M)."""
        known, signal = [], []
        for one, at in zip(emg, self.trials.times, strict=True):
            own, values = np.zeros((len(at), len(self.body.muscles))), np.zeros((len(at), len(self.body.muscles)))
            if one is not None:
                for column, name in zip(one.at(at).T, one.muscles, strict=True):
                    if name not in self.body.muscles:
                        raise ArgumentError(f"EMG of {name!r}, which is not a muscle of the model; it has "
                                            f"{', '.join(self.body.muscles[:8])}, ...")  # fmt: skip
                    place = self.body.muscles.index(name)
                    own[:, place], values[:, place] = 1.0, column
            known.append(own)
            signal.append(values)
        return np.concatenate(known), np.concatenate(signal)

    def run(self, effort: Floats, tendon: Floats | None) -> _Solved:
        """All frames, chunk by chunk.

        Args:
            tendon: (2, n, M) lengths and lengthening speeds of tendons; None for rigid ones.
        """
        parts = [self._chunk(effort, tendon, part) for part in self._chunks()]
        joined = {
            name: np.concatenate([getattr(part, name) for part in parts], axis=1 if name == "fibre" else 0)
            for name in _Solved.__dataclass_fields__
        }
        return _Solved(**joined)

    def _chunks(self) -> list[slice]:
        """Frames that are solved at once; whole trials where a frame's bounds follow from the one before."""
        starts = self.trials.starts
        if not self.options.rates:
            return list(self.body.chunks(starts[-1]))
        found, first = [], 0
        for end, following in zip(starts[1:], [*starts[2:], starts[-1] + self.body.most_frames], strict=True):
            if following - first > self.body.most_frames or end == starts[-1]:
                found.append(slice(first, end))
                first = end
        return found

    def _chunk(self, effort: Floats, tendon: Floats | None, part: slice) -> _Solved:
        n = part.stop - part.start
        muscles = self.body.muscle_frames(self.trials.states, part, tendon)
        if not self.options.physiology:
            strength = [first_number(self.body.muscle(name).f_max) for name in self.body.muscles]
            muscles.active.assign(np.tile(np.array(strength, np.float32), (n, 1)))
        elif tendon is None and self._widths[1].any():
            inputs = [to_device(one, float, self.body.device) for one in self._widths]
            outputs = [muscles.fibre, muscles.active]
            wp.launch(leave_out_pennation, (n, len(self.body.muscles)), inputs, outputs, device=self.body.device)
        needed = effort[part]
        if self._taut.any():
            needed = needed - self._passive(muscles, n)
        one = self.launch(needed, muscles, part)
        one.run()
        one.mend()
        found = [*one.outputs, muscles.fibre, muscles.active, muscles.passive, muscles.length, muscles.speed]
        return _Solved(*(array.numpy() for array in found))

    def launch(self, needed: Floats, muscles: MuscleFrames, part: slice) -> Launch:
        """The solver's kernel with all that it needs on the device.

        Args:
            needed: (n, S) of the frames of `part`.
        """
        device, n = self.body.device, part.stop - part.start
        frames = kernels.Frames()
        frames.moment_arm, frames.active = muscles.moment_arm, muscles.active
        frames.needed = self.body.side_by_side(needed)
        frames.reserve = to_device(self.reserve, float, device)
        apart, count = self.body.apart, self.groups.count
        outputs = [
            instance_zeros((n, len(self.body.muscles)), float, device, apart),
            instance_zeros((n, max(self.body.topology.speeds, 1)), float, device, apart),
            wp.zeros((n, max(count, 1)), dtype=int, device=device),
        ]

        def kernel(real: Any) -> Any:
            most = self.groups.most_coordinates, self.groups.most_muscles
            return kernels.static_optimization_of(self.law, *most, self.options.rates, real)

        inputs = [self.groups.on(device), frames, self._cost_on(part)]
        return Launch(kernel, count, self._runs(part), inputs, outputs, device)

    def _passive(self, muscles: MuscleFrames, n: int) -> Floats:
        """Generalised forces (n, S) of the passive forces that count."""
        tension = np.where(self._taut, muscles.passive.numpy(), np.float32(0.0))
        forces = tension[:, self.body.lever_muscle] * muscles.moment_arm.numpy()
        found = np.zeros((n, self.body.topology.speeds))
        np.add.at(found.T, self.body.lever_speed, forces.T.astype(np.float64))
        return found

    def _runs(self, part: slice) -> Integers:
        """First frames of runs, and those after their last (2, runs), counted from the first of `part`."""
        if not self.options.rates:
            each = np.arange(part.stop - part.start)
            return np.stack([each, each + 1])
        starts = [start - part.start for start in self.trials.starts if part.start <= start <= part.stop]
        return np.array([starts[:-1], starts[1:]])

    def _cost_on(self, part: slice) -> kernels.Cost:
        device, cost = self.body.device, kernels.Cost()
        each = part if len(self.gain) > 1 else slice(None)
        cost.gain, cost.shift = self.body.side_by_side(self.gain[each]), self.body.side_by_side(self.shift[each])
        cost.exponent = self.exponent
        cost.low, cost.high = to_device(self.low, float, device), to_device(self.high, float, device)
        rates = [np.zeros((0, 0))] * 2
        if self.options.rates:
            times = np.concatenate(self.trials.times)[part]
            step = np.maximum(np.diff(times, prepend=times[:1]), 0.0)[:, None]
            rates = [1.0 - np.exp(-step / time) for time in (self.rise, self.fall)]
        cost.rise, cost.fall = map(self.body.side_by_side, rates)
        return cost

    def force(self, solved: _Solved) -> Floats:
        """Forces of muscles and ligaments (n, M), N."""
        return np.asarray(solved.activation * solved.active + np.where(self._taut, solved.passive, 0.0))

    def activations(self, solved: _Solved, effort: Floats) -> list[Activations]:
        """What was found, by trial."""
        body, trials = self.body, self.trials
        share = solved.multiplier * self.reserve
        if self.law == kernels.POWER:
            share = np.sign(share) * np.abs(share) ** self.exponent
        reserve = share * self.reserve
        bare = sorted(set(range(body.topology.speeds)) - set(self.groups.coordinates))
        reserve[:, bare] = effort[:, bare]
        unmuscled = frozenset({body.map.coordinate_of(speed) for speed in bare} | set(body.map.names[: body.map.roots]))
        muscles = [body.muscle(name) for name in body.muscles]
        l_opt = np.array([first_number(one.l_opt) for one in muscles])
        v_max = np.array([first_number(given(one, body.scene.muscle_model, "v_max")) for one in muscles])
        force = self.force(solved)
        units = tuple("N m" if unit == "rad" else "N" for unit in body.map.units)
        needed = Moments(body.map.names, units, np.zeros(0), np.zeros((0, 0)), body.map.roots)
        iterations = np.where((solved.iterations < 0).any(axis=1), -1, solved.iterations.max(axis=1))
        arrays = (
            solved.activation, force, solved.fibre[0] * l_opt, solved.fibre[1] * l_opt * v_max, solved.speed,
            body.map.forces(effort, trials.states), body.map.forces(reserve, trials.states), iterations,
        )  # fmt: skip
        found = []
        for times, *own in zip(trials.times, *map(trials.split, arrays), strict=True):
            activation, pulled, length, velocity, speed, moments, lacking, steps = own
            found.append(
                Activations(
                    body.muscles,
                    times,
                    activation,
                    pulled,
                    length,
                    velocity,
                    speed,
                    replace(needed, times=times, values=moments),
                    lacking,
                    unmuscled,
                    steps,
                )
            )
        return found
