"""The loop of computed muscle control over windows of time, for all trials at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from numbers import Real

import numpy as np

from warpmuscle.core.arguments import as_truth
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.dynamics import Prepared
from warpmuscle.inverse.static_optimization import activations_of
from warpmuscle.inverse.tracking.driven_body import DrivenBody
from warpmuscle.inverse.tracking.force_sharing import ForceSharing, interpolated
from warpmuscle.inverse.tracking.look_ahead import LookAhead
from warpmuscle.inverse.tracking.state_difference import difference, moved_by
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.results.recording import Recording
from warpmuscle.scene.muscles import given

MENDED = 0.3  # of what accelerations fell short by, that is added to those of the next window
TRIES = 3  # to find excitations that lead to forces, between least and full ones


@dataclass(frozen=True)
class TrackingOptions:
    """How a motion is followed.

    Attributes:
        window: s, over which excitations are constant.
        kp: 1/s^2, kv: 1/s, of the accelerations that lead back; on the ground, a feedback is found instead.
        reserve: N m or N, strength of reserves beside muscles, as of static optimisation.
        reserves: whether what muscles cannot make acts besides, or is only told.
        residuals: whether forces act on the root that nothing makes.
        ground: whether the ground of the simulation carries the model, without recorded forces and without residuals.
    """

    window: float = 0.015
    kp: float = 100.0
    kv: float = 20.0
    reserve: float = 0.1
    reserves: bool = True
    residuals: bool = True
    ground: bool = False

    def check(self) -> None:
        """Raise ArgumentError where an option is none."""
        for name in ("reserves", "residuals", "ground"):
            as_truth(getattr(self, name), name)
        for name, least, most in (("window", 1e-3, 0.1), ("kp", 0.0, 1e4), ("kv", 0.0, 1e3), ("reserve", 1e-4, 1e6)):
            value = getattr(self, name)
            if not isinstance(value, Real) or not least <= float(value) <= most:
                raise ArgumentError(f"{name} is a number from {least:g} to {most:g}, not {value!r}")


class Tracker:
    """Follows prepared trials, whose frames lie between windows, all at once."""

    def __init__(
        self, body: BodyModel, trials: Prepared, options: TrackingOptions, recorded: bool = False
    ) -> None:  # fmt: skip
        """Args: recorded: whether the runs are kept as motions."""
        self.body, self.trials, self.options, self._recorded = body, trials, options, recorded
        counts = np.array([len(times) for times in trials.times])
        self.windows, self.count = int(counts.max()) - 1, len(counts)
        each = np.minimum(np.arange(self.windows + 1)[:, None], counts - 1)
        self._row = np.array(trials.starts[:-1]) + each  # frames of all trials, by window; short ones stay at their end
        duration = (self.windows + 1) * options.window
        loads = trials.loads.body
        self.driven = DrivenBody(body, self.count, options.window, loads, duration, recorded=recorded)
        self._ahead = LookAhead(self.driven)
        self.sharing = ForceSharing(body, np.full(body.topology.speeds, options.reserve))
        speeds, muscles, root = body.topology.speeds, len(body.muscles), body.topology.speed_start[1]
        self._acts = np.zeros(speeds, dtype=bool)  # whether forces act along a speed beside muscles
        self._acts[:root] = options.residuals
        self._acts[root:] = options.reserves | self.sharing.bare[root:]
        model = body.scene.muscle_model
        least = [float(given(body.muscle(name), model, "minimum_activation") or 0.0) for name in body.muscles]
        self._least, self._most = np.tile(least, (self.count, 1)), np.ones((self.count, muscles))
        self._missed, self._before = np.zeros((self.count, speeds)), np.zeros((self.count, speeds))
        self._initial = self._initial_activation()
        shape = self.windows, self.count
        self._excitation, self._force = np.zeros((*shape, muscles)), np.zeros((*shape, muscles))
        self._effort, self._lacking = np.zeros((*shape, speeds)), np.zeros((*shape, speeds))
        self._iterations: Integers = np.zeros(shape, dtype=np.int64)
        self._state = np.zeros((self.windows + 1, self.count, body.topology.coordinates))
        self._activation = np.zeros((self.windows + 1, self.count, muscles))
        self._alive = np.ones((self.windows + 1, self.count), dtype=bool)

    def _initial_activation(self) -> Floats:
        """Activations (n, M) by static optimisation of the first frames."""
        return first_activations(self.body, self.trials)

    def _loads(self, window: int) -> BodyLoads:
        return loads_of(self.trials.loads, self._row[window])

    def _start(self) -> None:
        self.driven.start(frames_of(self.trials.states, self._row[0]), self._initial)
        self._state[0], self._activation[0] = self.driven.state()[0], self._initial

    def follow(self) -> None:
        """Follow the motions from their starts."""
        self._start()
        for window in range(self.windows):
            self._follow(window)

    def _follow(self, w: int) -> None:
        """Follow the motions over a window."""
        now, then = (frames_of(self.trials.states, self._row[k]) for k in (w, w + 1))
        alive = self._alive[w][:, None]
        q, v = self.driven.state()
        away = difference(self.body, np.where(alive, q, now.coordinates), now.coordinates)
        slower = np.where(alive, now.speeds - v, 0.0)
        rates = then.rates + self.options.kp * away + self.options.kv * slower
        coordinates = moved_by(self.body, then.coordinates, -away)
        expected = States(coordinates, then.speeds - slower, rates + self._missed, then.by_root)
        dynamics = self.body.dynamics(expected, self._loads(w + 1))
        needed = dynamics.effort + dynamics.followed
        here = States(np.where(alive, q, now.coordinates), now.speeds - slower, now.rates, now.by_root)
        self._excite(w, here, expected, needed)
        self._run(w)
        got = np.where(alive, self.driven.state()[1] - v, 0.0) / self.driven.window
        asked = rates if w == 0 else 0.5 * (self._before + rates)  # forces rise over the window
        self._missed = np.where(self._alive[w + 1][:, None], self._missed + MENDED * (asked - got), 0.0)
        self._before = rates

    def _excite(self, w: int, here: States, expected: States, needed: Floats) -> None:
        """Find excitations of a window after which muscles make generalised forces (n, S), and what they lack."""
        self._ahead.begin(here, expected)
        low, high = self._ahead.reach(self._least), self._ahead.reach(self._most)
        shares = self.sharing.share(expected, needed, low, high)
        wanted = low.force + shares.share * np.maximum(high.force - low.force, 0.0)
        tried = [(self._least, low.force), (self._most, high.force)]
        for _ in range(TRIES):
            excitation = interpolated(wanted, tried)
            tried.insert(-1, (excitation, self._ahead.reach(excitation).force))
        self._excitation[w], self._iterations[w] = interpolated(wanted, tried), shares.iterations
        self._lacking[w] = np.where(self.sharing.bare, needed, shares.reserve)
        self._effort[w] = np.where(self._acts, self._lacking[w], 0.0).astype(np.float32)

    def _tell(self, w: int, effort: Floats) -> None:
        self.driven.tell(effort, self._loads(w), self._loads(w + 1))

    def _run(self, w: int) -> None:
        """Simulate a window with what was found for it."""
        self._tell(w, self._effort[w])
        self.driven.run(self._excitation[w])
        self._alive[w + 1] = self._alive[w] & self.driven.runs()
        alive = self._alive[w + 1][:, None]
        self._state[w + 1] = np.where(alive, self.driven.state()[0], self._state[w])
        self._activation[w + 1] = np.where(alive, self.driven.activation(), self._activation[w])
        self._force[w] = np.where(alive, self.driven.force(), 0.0)

    def repeat(self) -> None:
        """Run the motions from their starts by excitations alone, and whatever acts besides as it was told."""
        self._start()
        for window in range(self.windows):
            self._run(window)

    def results(self) -> list[Tracked]:
        """What was found, by trial."""
        return [self._result(k) for k in range(self.count)]

    def _result(self, k: int) -> Tracked:
        body, times = self.body, self.trials.times[k]
        last = int(self._alive[: len(times), k].sum()) - 1  # the window after which it is lost, or all
        rows, part = self._row[: last + 1, k], slice(0, last)
        before = frames_of(self.trials.states, rows[:-1])
        acting, lacking = (body.map.forces(one[part, k], before) for one in (self._effort, self._lacking))
        return Tracked(
            body.muscles, body.map.names, tuple(body.map.units), body.map.roots, times[: last + 1],
            self.trials.values[rows], body.map.values(self._state[: last + 1, k]), self._excitation[part, k],
            self._activation[: last + 1, k], self._force[part, k], acting, lacking, self._iterations[part, k],
            (self.trials.states.coordinates[rows[0]], self.trials.states.speeds[rows[0]]),
            None if last == len(times) - 1 else float(times[last]),
            motion=self._motion(k, times[: last + 1]) if self._recorded else None,
        )  # fmt: skip

    def _motion(self, k: int, times: Floats) -> Recording:
        """The run of a trial, in its times."""
        motion = self.driven.rollout.recording(k).window(0.0, float(times[-1] - times[0]))
        return replace(motion, time=motion.time + times[0])  # without the scene, which has all trials' loads


def first_activations(body: BodyModel, trials: Prepared) -> Floats:
    """Activations (n, M) in the first frames of trials, by static optimisation with elastic tendons."""
    first = np.array(trials.starts[:-1])
    states, loads = frames_of(trials.states, first), loads_of(trials.loads, first)
    alone = Prepared([times[:1] for times in trials.times], states, loads, trials.values[first])
    found = activations_of(body, alone, ActivationOptions(passive=True, elastic=True))
    return np.concatenate([one.activation for one in found])


def frames_of(states: States, rows: Integers) -> States:
    """Some of the frames."""
    by_ball = {name: values[rows] for name, values in states.by_ball.items()}
    return States(states.coordinates[rows], states.speeds[rows], states.rates[rows], states.by_root[rows], by_ball)


def loads_of(loads: BodyLoads, rows: Integers) -> BodyLoads:
    """Loads of some frames."""
    return BodyLoads(loads.body, loads.force[rows], loads.point[rows], loads.moment[rows])
